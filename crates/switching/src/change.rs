//! How a state changes at an event.

use crate::event::EventKind;

/// How the state changed at an event.
pub(crate) struct Change {
    /// The map from before to after, where there is one.
    pub(crate) map: Option<Vec<f64>>,
    /// What happened, to which switch, and how many seconds after the event itself.
    pub(crate) happened: Vec<(usize, EventKind, f64, f64)>,
}

impl Change {
    /// Another map after those before.
    pub(crate) fn compose(&mut self, map: &[f64], n: usize) {
        self.map = Some(match self.map.take() {
            None => map.to_vec(),
            Some(before) => product(n, map, &before),
        });
    }
}

/// A B of square matrices by rows.
pub(crate) fn product(n: usize, a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; n * n];
    for i in 0..n {
        for k in (0..n).filter(|k| a[i * n + k] != 0.0) {
            for j in 0..n {
                product[i * n + j] += a[i * n + k] * b[k * n + j];
            }
        }
    }
    product
}
