//! Symmetry. Elements are symmetric by themselves, so only an added matrix can break it.

use crate::element::MatrixKind;
use crate::system::System;

/// Whether the matrix of this kind equals its transpose.
pub(crate) fn is_symmetric(system: &System, kind: MatrixKind) -> bool {
    let dense = system.added(kind).is_none_or(|added| {
        (0..system.len()).all(|i| (0..i).all(|j| added[(i, j)] == added[(j, i)]))
    });
    let sparse = system.added_sparse(kind).is_none_or(|added| {
        added
            .triplet_iter()
            .all(|entry| added.get(entry.col, entry.row).copied().unwrap_or(0.0) == *entry.val)
    });
    dense && sparse
}

/// Whether M, C and K equal their transposes.
pub(crate) fn all_symmetric(system: &System) -> bool {
    [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness]
        .into_iter()
        .all(|kind| is_symmetric(system, kind))
}
