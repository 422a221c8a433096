//! All nonzero roots of a system without springs, from proven squares of the undamped one that has
//! the dampers for springs: λ = −σ.

use super::congruence::{Goal, squares};
use super::quadratic::{Damped, Modal, roots};
use crate::system::System;

/// Proves a bound for every nonzero root, given the undamped system and its elastic shapes
/// approximately. `None` where no proof was reached, as for C ⋡ 0.
pub(crate) fn certify(
    undamped: &System,
    shapes: Vec<Vec<f64>>,
    tolerance: f64,
) -> Option<Vec<Damped>> {
    let squares = squares(undamped, shapes, Goal::always(1e-24), tolerance)?;
    let relaxing = (0..squares.values.len()).map(|i| Modal {
        gamma: squares.around(&(i..i + 1)),
        sigma: None,
        shape: squares.shape(i),
        is_common: false,
    });
    roots(&relaxing.collect::<Vec<_>>())
}
