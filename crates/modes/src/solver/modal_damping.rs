//! C in the coordinates of real shapes.

use eigentone_digits::product;
use faer::Mat;

use crate::model::{MatrixKind, Node};
use crate::system::System;

/// XᵀCX for real shapes X, summed over the dampers.
pub(crate) fn modal_damping<'a>(
    system: &System,
    shapes: impl Iterator<Item = &'a [f64]>,
) -> Mat<f64> {
    let shapes: Vec<&[f64]> = shapes.collect();
    let (dampers, r) = (system.dampers(), shapes.len());
    let at = |node: Node, j: usize| node.coordinate().map_or(0.0, |i| shapes[j][i]);
    let stretches = Mat::from_fn(dampers.len(), r, |e, j| {
        at(dampers[e].first, j) - at(dampers[e].second, j)
    });
    let forces = Mat::from_fn(dampers.len(), r, |e, j| {
        dampers[e].coefficient * stretches[(e, j)]
    });
    let mut gamma = product(stretches.transpose(), forces.as_ref());
    if let Some(added) = system.added(MatrixKind::Damping) {
        let shapes = Mat::from_fn(system.len(), r, |i, j| shapes[j][i]);
        gamma += product(shapes.transpose(), product(added, shapes.as_ref()).as_ref());
    }
    gamma
}
