//! Columns of a matrix as slices.

use faer::{ContiguousFwd, Mat, MatRef};

/// A matrix whose columns are contiguous.
pub(super) type Columns<'a> = MatRef<'a, f64, usize, usize, ContiguousFwd>;

/// Calls `use_it` with the matrix itself where its columns are contiguous, else with a copy.
#[inline]
pub(super) fn with_columns<R>(a: MatRef<'_, f64>, use_it: impl FnOnce(Columns<'_>) -> R) -> R {
    match a.try_as_col_major() {
        Some(a) => use_it(a),
        None => {
            let copy: Mat<f64> = a.to_owned();
            let copy = copy.as_ref().try_as_col_major();
            use_it(copy.expect("an owned matrix has contiguous columns"))
        }
    }
}
