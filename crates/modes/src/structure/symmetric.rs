//! Symmetry. Elements are symmetric by themselves, so only an added matrix can break it.

use crate::model::MatrixKind;
use crate::model::Model;

/// Whether the matrix of this kind equals its transpose.
pub(crate) fn is_symmetric(model: &Model, kind: MatrixKind) -> bool {
    let dense = model.added(kind).is_none_or(|added| {
        (0..model.len()).all(|i| (0..i).all(|j| added[(i, j)] == added[(j, i)]))
    });
    let sparse = model.added_sparse(kind).is_none_or(|added| {
        added
            .triplet_iter()
            .all(|entry| added.get(entry.col, entry.row).copied().unwrap_or(0.0) == *entry.val)
    });
    dense && sparse
}
