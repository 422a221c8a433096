//! Systems for the tests of this room, singular ones included.

use faer::{Mat, mat};

use crate::model::{Element, Node};
use crate::system::System;

/// An element between coordinates counted from 1, 0 being the ground.
pub(crate) type Join = (usize, usize, f64);

/// From masses, springs and dampers, unchecked.
pub(crate) fn network(masses: &[f64], springs: &[Join], dampers: &[Join]) -> System {
    with_matrices(masses, springs, dampers, [const { None }; 3])
}

/// The same with matrices added.
pub(crate) fn with_matrices(
    masses: &[f64],
    springs: &[Join],
    dampers: &[Join],
    added: [Option<Mat<f64>>; 3],
) -> System {
    let node = |index: usize| index.checked_sub(1).map_or(Node::Ground, Node::Coordinate);
    let element = |&(a, b, coefficient): &Join| Element {
        first: node(a),
        second: node(b),
        coefficient,
    };
    System::assemble(
        (1..=masses.len()).map(|i| format!("m{i}")).collect(),
        masses.to_vec(),
        springs.iter().map(element).collect(),
        dampers.iter().map(element).collect(),
        added,
    )
}

/// From M, C and K alone.
pub(crate) fn matrices(mass: Mat<f64>, damping: Mat<f64>, stiffness: Mat<f64>) -> System {
    let masses = vec![0.0; mass.nrows()];
    with_matrices(
        &masses,
        &[],
        &[],
        [Some(mass), Some(damping), Some(stiffness)],
    )
}

/// Masses in a row: element i joins mass i to mass i + 1, the ground being 0 and also beyond the
/// last mass.
pub(crate) fn chain(masses: &[f64], springs: &[f64], dampers: &[f64]) -> System {
    let joins = |values: &[f64]| -> Vec<Join> {
        let end = |i: usize| if i == masses.len() { 0 } else { i + 1 };
        values
            .iter()
            .enumerate()
            .map(|(i, &value)| (i, end(i), value))
            .collect()
    };
    network(masses, &joins(springs), &joins(dampers))
}

/// The same system as whole matrices instead of elements; the elements must add up exactly.
pub(super) fn as_matrices(system: &System) -> System {
    matrices(
        system.mass_matrix(),
        system.damping_matrix(),
        system.stiffness_matrix(),
    )
}

/// Rayleigh damping in name only: K = [1+ε −ε; −ε 1+ε], C = diag(.1, .2).
pub(super) fn almost_classical() -> System {
    let e = 1e-15;
    network(
        &[1.0, 1.0],
        &[(0, 1, 1.0), (1, 2, e), (0, 2, 1.0)],
        &[(0, 1, 0.1), (0, 2, 0.2)],
    )
}

/// −1 three times.
pub(super) fn triple_defect() -> System {
    matrices(
        mat![[9.0, 0.0], [0.0, 0.0]],
        mat![[0.0, 0.0], [0.0, 8.0]],
        mat![[27.0, -24.0], [-24.0, 24.0]],
    )
}

/// The stiffness of a free beam of Hermite elements, EI = 1 and each 1 long (Przemieniecki 1968,
/// *Theory of Matrix Structural Analysis*): displacement and rotation at each end.
pub(crate) fn free_beam(elements: usize) -> Mat<f64> {
    let [_, stiffness] = uniform_beam(elements);
    stiffness
}

/// The consistent mass, for 420 per element, and the stiffness of that beam.
pub(crate) fn uniform_beam(elements: usize) -> [Mat<f64>; 2] {
    let mass = mat![
        [156.0, 22.0, 54.0, -13.0],
        [22.0, 4.0, 13.0, -3.0],
        [54.0, 13.0, 156.0, -22.0],
        [-13.0, -3.0, -22.0, 4.0]
    ];
    let stiffness = mat![
        [12.0, 6.0, -12.0, 6.0],
        [6.0, 4.0, -6.0, 2.0],
        [-12.0, -6.0, 12.0, -6.0],
        [6.0, 2.0, -6.0, 4.0]
    ];
    let n = 2 * elements + 2;
    [mass, stiffness].map(|element| {
        let mut whole = Mat::zeros(n, n);
        for (at, i, j) in (0..elements).flat_map(|at| (0..16).map(move |e| (2 * at, e / 4, e % 4)))
        {
            whole[(at + i, at + j)] += element[(i, j)];
        }
        whole
    })
}
