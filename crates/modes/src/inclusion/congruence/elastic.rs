//! The frequencies of an undamped system, from their squares.

use eigentone_digits::DoubleDouble;

use super::refine::Goal;
use super::squares::{Squares, squares};
use crate::inclusion::bounded_shape::Shape;
use crate::inclusion::gram::UPWARD;
use crate::modes::Mode;
use crate::structure::Structure;
use crate::system::System;

/// One elastic mode: ω with a proven bound, and its shape.
#[derive(Clone, Debug)]
pub(crate) struct Elastic {
    pub(crate) frequency: f64,
    /// Of |ω̂ − ω|.
    pub(crate) bound: f64,
    /// How many frequencies the bounds do not tell apart.
    pub(crate) multiplicity: usize,
    pub(crate) shape: Shape,
}

/// Proves a bound for every nonzero frequency of an undamped system with M and K symmetric and no
/// massless nodes, given all its modes approximately. `None` where no proof was reached, as for
/// K ⋡ 0.
pub(crate) fn certify(
    system: &System,
    structure: &Structure,
    modes: &[Mode],
    tolerance: f64,
) -> Option<Vec<Elastic>> {
    let elastic = || {
        modes
            .iter()
            .filter(|mode| mode.eigenvalue().value.norm() != 0.0)
    };
    if !structure.is_undamped() || elastic().any(|mode| mode.roots() > 1) {
        return None;
    }
    let shapes = elastic().map(|mode| mode.shape().iter().map(|x| x.re).collect());
    let goal = Goal {
        spread: 1e-24,
        where_apart: 1e-20,
    };
    let found = squares(system, structure, shapes.collect(), goal, tolerance)?;
    Some(elastic_modes(&found))
}

/// ω = √σ with bounds; frequencies that are not told apart get one value.
fn elastic_modes(squares: &Squares) -> Vec<Elastic> {
    // √(1 + t) is within this of 1 for |t| ≤ spread. More is added for the root.
    let relative = squares.spread / (1.0 + (1.0 - squares.spread).sqrt()) + 2f64.powi(-100);
    let mut found = Vec::with_capacity(squares.values.len());
    for group in squares.groups() {
        let middle = squares.values[(group.start + group.end) / 2];
        let frequency = middle.sqrt().to_f64();
        let bound = group.clone().map(|i| {
            let root = squares.values[i].sqrt();
            let rounding = (root - DoubleDouble::from(frequency)).to_f64().abs();
            (rounding + relative * root.to_f64()) * UPWARD
        });
        let bound = bound.fold(f64::from_bits(1), f64::max);
        found.extend(group.clone().map(|i| Elastic {
            frequency,
            bound,
            multiplicity: group.len(),
            shape: squares.shape(i),
        }));
    }
    found
}
