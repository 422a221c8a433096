//! The exponential of any real matrix.

use eigentone_digits::Real;
use eigentone_modes::balance;
use faer::{Mat, MatRef};
use thiserror::Error;

use super::{Exponential, Taylor};

/// Why a matrix has no exponential in doubles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
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
}

/// e^A for a real square matrix A, in doubles.
///
/// A is balanced by a diagonal of powers of two where that halves its 1-norm at least, which spares
/// squarings and keeps digits of badly scaled systems (Ward 1977, SIAM J. Numer. Anal. 14); then
/// [`Taylor`] computes the exponential. The relative error in the 1-norm is usually a small multiple
/// of 2^-53 times [`expm_condition`](super::expm_condition). Entries beyond the largest double are infinite, none is NaN.
///
/// ```
/// use eigentone_response::expm;
/// use faer::mat;
///
/// let quarter_turn = std::f64::consts::FRAC_PI_2;
/// let rotation = expm(mat![[0.0, quarter_turn], [-quarter_turn, 0.0]].as_ref())?;
/// assert!((rotation[(0, 1)] - 1.0).abs() < 1e-15);
/// # Ok::<(), eigentone_response::ExpmError>(())
/// ```
///
/// # Errors
/// [`ExpmError`] for a matrix that is not square or has an entry that is not finite.
pub fn expm(a: MatRef<'_, f64>) -> Result<Mat<f64>, ExpmError> {
    check(a)?;
    if even(a) {
        return Ok(Taylor.exponential(a));
    }
    let balanced = balance(a);
    if norm(balanced.matrix.as_ref()) > 0.5 * norm(a) {
        return Ok(Taylor.exponential(a));
    }
    let mut result = Taylor.exponential(balanced.matrix.as_ref());
    let exponents: Vec<i64> = balanced.scale.iter().map(|d| d.log2() as i64).collect();
    for (column, right) in result.col_iter_mut().zip(&exponents) {
        for (entry, left) in column.iter_mut().zip(&exponents) {
            *entry = entry.scale(left - right);
        }
    }
    Ok(result)
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

/// Whether no row of the matrix is much larger or smaller than the column that belongs to it, so
/// that balancing cannot gain much.
fn even(a: MatRef<'_, f64>) -> bool {
    const FACTOR: f64 = 4.0;
    let n = a.nrows();
    let mut rows = vec![0.0; n];
    let mut columns = vec![0.0; n];
    for (j, column) in a.col_iter().enumerate() {
        for (i, entry) in column.iter().enumerate().filter(|(i, _)| *i != j) {
            rows[i] += entry.abs();
            columns[j] += entry.abs();
        }
    }
    rows.iter().zip(&columns).all(|(row, column)| {
        (*row <= FACTOR * column && *column <= FACTOR * row) || *row == 0.0 || *column == 0.0
    })
}

/// The largest column sum.
fn norm(a: MatRef<'_, f64>) -> f64 {
    a.col_iter()
        .map(|column| column.norm_l1())
        .fold(0.0, f64::max)
}
