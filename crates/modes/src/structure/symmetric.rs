//! Symmetry. Elements are symmetric by themselves, so only an added matrix can break it.

use std::collections::HashMap;

use crate::model::MatrixKind;
use crate::model::Model;

/// Whether the matrix of this kind equals its transpose.
pub(crate) fn is_symmetric(model: &Model, kind: MatrixKind) -> bool {
    let is_symmetric = match model.added_sparse(kind) {
        Some(added) => added
            .triplet_iter()
            .all(|entry| added.get(entry.col, entry.row).copied().unwrap_or(0.0) == *entry.val),
        None => model.added(kind).is_none_or(|added| {
            (0..model.len()).all(|i| (0..i).all(|j| added[(i, j)] == added[(j, i)]))
        }),
    };
    is_symmetric && has_symmetric_tails(model, kind)
}

/// Whether the [tails](Model::tails) of the entries are those of the transpose. Where entries are symmetric sums of terms
/// they are.
fn has_symmetric_tails(model: &Model, kind: MatrixKind) -> bool {
    let mut places: HashMap<(usize, usize), Vec<f64>> = HashMap::new();
    for tail in model.tails(kind) {
        let place = places.entry((tail.row, tail.column)).or_default();
        place.push(tail.value);
    }
    places
        .iter()
        .all(|(&(row, column), tails)| places.get(&(column, row)) == Some(tails))
}
