//! Random networks of masses, springs and dampers.

use eigentone_modes::System;
use proptest::prelude::*;

use crate::root::{Join, network};

/// A chain with a few more elements across it.
#[derive(Clone, Debug)]
pub struct Network {
    pub masses: Vec<f64>,
    pub springs: Vec<Join>,
    pub dampers: Vec<Join>,
}

impl Network {
    pub fn system(&self) -> System {
        network(&self.masses, &self.springs, &self.dampers)
    }
}

/// From 1e-`decades` to 1e`decades`.
pub fn wide(decades: f64) -> impl Strategy<Value = f64> + Clone {
    (-decades..decades).prop_map(|exponent| 10f64.powf(exponent))
}

pub fn networks(decades: f64, most_dampers: usize) -> impl Strategy<Value = Network> {
    (2usize..7).prop_flat_map(move |n| {
        let across = (0..=n, 1..n, wide(decades))
            .prop_map(move |(a, step, value)| (a, (a + step) % (n + 1), value));
        (
            prop::collection::vec(wide(decades), n),
            prop::collection::vec(wide(decades), n),
            prop::collection::vec(across.clone(), 0..3),
            prop::collection::vec(across, 0..=most_dampers),
        )
            .prop_map(|(masses, chain, more, dampers)| {
                let chain = chain.into_iter().enumerate();
                let chain = chain.map(|(i, value)| (i, i + 1, value));
                Network {
                    masses,
                    springs: chain.chain(more).collect(),
                    dampers,
                }
            })
    })
}
