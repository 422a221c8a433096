//! Symmetry. Elements are symmetric by themselves, so only an added matrix can break it.

use crate::element::MatrixKind;
use crate::system::System;

/// Whether the matrix of this kind equals its transpose.
pub(crate) fn is_symmetric(system: &System, kind: MatrixKind) -> bool {
    system.added(kind).is_none_or(|added| {
        (0..system.len()).all(|i| (0..i).all(|j| added[(i, j)] == added[(j, i)]))
    })
}
