//! The exponential of any real matrix.

use eigentone_digits::{DoubleDouble, Magnitude, Real, Wide};
use eigentone_modes::balance;
use faer::{Mat, MatRef};
use thiserror::Error;

use super::squaring::MEANINGFUL;
use super::taylor::taylor;
use super::{Exponential, Pade13};
use crate::certified::{Normed, exponential};

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
/// [`Taylor`](super::Taylor) computes the exponential. In matrices far from normal, rounding may grow with
/// every squaring beyond what the condition explains: up to 64 rows, where there are several
/// squarings and [`Pade13`] differs by more than 1e-12, or there are too many squarings for any two to tell, all is done again with 32 digits or more, until
/// the error is proven to be below that of rounding the result. The relative error in the 1-norm is usually a small
/// multiple of 2^-53 times [`expm_condition`](super::expm_condition). Entries beyond the largest double
/// are infinite, none is NaN.
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
        return Ok(on_demand(a));
    }
    let balanced = balance(a);
    if norm(balanced.matrix.as_ref()) > 0.5 * norm(a) {
        return Ok(on_demand(a));
    }
    let mut result = on_demand(balanced.matrix.as_ref());
    let exponents: Vec<i64> = balanced.scale.iter().map(|d| d.log2() as i64).collect();
    for (column, right) in result.col_iter_mut().zip(&exponents) {
        for (entry, left) in column.iter_mut().zip(&exponents) {
            *entry = entry.scale(left - right);
        }
    }
    Ok(result)
}

/// In doubles, or with more digits where two methods in doubles differ visibly.
fn on_demand(a: MatRef<'_, f64>) -> Mat<f64> {
    /// Fewer squarings cannot do much harm, and more leave nothing that digits could mend.
    const TELLING: std::ops::RangeInclusive<u32> = 3..=128;
    const LARGEST: usize = 64;
    const VISIBLE: f64 = 1e-12;
    let (result, _, squarings) = taylor(a);
    if !TELLING.contains(&squarings) || a.nrows() > LARGEST {
        return result;
    }
    let other = Pade13.exponential(a);
    let size = norm(result.as_ref());
    // What is not finite in either is not finite in a sum of sizes, which no maximum hides.
    let total: f64 = (&result - &other).col_iter().map(|c| c.norm_l1()).sum();
    if squarings <= MEANINGFUL && total.is_finite() && total <= VISIBLE * size {
        return result;
    }
    let small = a.nrows() <= 16;
    precisely::<DoubleDouble>(a)
        .or_else(|| precisely::<Wide<4>>(a))
        .or_else(|| precisely::<Wide<8>>(a))
        .or_else(|| precisely::<Wide<16>>(a))
        .or_else(|| small.then(|| precisely::<Wide<32>>(a)).flatten())
        .or_else(|| small.then(|| precisely::<Wide<64>>(a)).flatten())
        .unwrap_or(result)
}

/// With the digits of T; `None` where they do not prove the result to be right to the last digit.
fn precisely<T: Real>(a: MatRef<'_, f64>) -> Option<Mat<f64>> {
    let n = a.nrows();
    let entries = (0..n * n).map(|at| T::from(a[(at / n, at % n)])).collect();
    let generator = Normed::new(n, n, entries, Magnitude::ZERO);
    let power = exponential(&generator, T::ONE, Magnitude::ZERO);
    let enough = power.frobenius() * Magnitude::power_of_two(-56);
    (power.error() <= enough && power.error().is_finite())
        .then(|| Mat::from_fn(n, n, |i, j| power.row(i)[j].to_f64()))
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
