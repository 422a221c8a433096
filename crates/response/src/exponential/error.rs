//! Why there is no exponential.

use faer::{Mat, MatRef};
use thiserror::Error;

/// Why a matrix has no exponential in doubles.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ExpmError {
    /// The matrix is not square.
    #[error("the matrix is {rows} × {columns}, but only square ones have an exponential")]
    NotSquare {
        /// Its number of rows.
        rows: usize,
        /// Its number of columns.
        columns: usize,
    },
    /// An entry is NaN or infinite.
    #[error("entry ({row}, {column}) of the matrix is not finite")]
    NotFinite {
        /// The entry's row, from 0.
        row: usize,
        /// The entry's column, from 0.
        column: usize,
    },
    /// A method in doubles was asked for what doubles do not hold: an exponential of which they have no digit, or
    /// with entries beyond the largest of them.
    #[error(
        "the exponential of the matrix has no certain digit in doubles, or leaves their range: `expm` takes more digits"
    )]
    BeyondDoubles,
    /// More digits would be needed than can be afforded at this order.
    #[error(
        "the exponential of the matrix of order {order} takes more digits than can be afforded: take that of a fraction of the matrix, or of blocks of it"
    )]
    TooManyDigits {
        /// The number of rows.
        order: usize,
    },
    /// The error of the exponential may be larger than its condition explains.
    #[error(
        "the exponential of the matrix is known to {error:.1e} in the 1-norm only: `expm_bounded` gives it with that bound"
    )]
    Uncertain {
        /// The estimated error, in the 1-norm.
        error: f64,
    },
}

/// That the matrix is square and finite.
pub(super) fn check(a: MatRef<'_, f64>) -> Result<(), ExpmError> {
    let (rows, columns) = a.shape();
    if rows != columns {
        return Err(ExpmError::NotSquare { rows, columns });
    }
    for (column, entries) in a.col_iter().enumerate() {
        if let Some(row) = entries.iter().position(|entry| !entry.is_finite()) {
            return Err(ExpmError::NotFinite { row, column });
        }
    }
    Ok(())
}

/// What was found, if doubles hold it.
pub(super) fn in_range(found: Option<(Mat<f64>, f64)>) -> Result<(Mat<f64>, f64), ExpmError> {
    found
        .filter(|(matrix, _)| matrix.as_ref().is_all_finite())
        .ok_or(ExpmError::BeyondDoubles)
}
