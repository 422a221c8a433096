//! All nonzero roots of a system without springs, from proven squares of the undamped one that has
//! the dampers for springs: λ = −σ.

use eigentone_digits::DoubleDouble;

use super::bounded_shape::Shape;
use super::congruence::{Goal, squares};
use crate::system::System;

/// One real root, and its shape.
#[derive(Clone, Debug)]
pub(crate) struct Relaxing {
    pub(crate) value: f64,
    pub(crate) bound: f64,
    /// How many roots the bounds do not separate.
    pub(crate) multiplicity: usize,
    pub(crate) shape: Shape,
}

/// Proves a bound for every nonzero root, given the undamped system and its elastic shapes
/// approximately. `None` where no proof was reached, as for C ⋡ 0.
pub(crate) fn certify(
    undamped: &System,
    shapes: Vec<Vec<f64>>,
    tolerance: f64,
) -> Option<Vec<Relaxing>> {
    let squares = squares(undamped, shapes, Goal::always(1e-24), tolerance)?;
    let mut found = Vec::new();
    for group in squares.groups() {
        let value = squares.values[(group.start + group.end) / 2].to_f64();
        // The farthest that a member may lie from this double.
        let reach = group.clone().map(|i| {
            let square = squares.values[i];
            (square - DoubleDouble::from(value)).to_f64().abs() + squares.reach[i]
        });
        let bound = reach.fold(0.0, f64::max) * (1.0 + 1e-9);
        found.extend(group.clone().map(|i| Relaxing {
            value: -value,
            bound: bound.max(f64::from_bits(1)),
            multiplicity: group.len(),
            shape: squares.shape(i),
        }));
    }
    Some(found)
}
