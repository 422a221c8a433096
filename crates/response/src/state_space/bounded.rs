//! Matrices of doubles, each entry with a bound of its error.

use eigentone_digits::{BallMatrix, Magnitude, Real};
use faer::Mat;

use super::error::StateSpaceError;

/// A matrix of doubles, each within a proven bound of the true entry.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundedMatrix {
    /// The entries, each rounded once.
    pub values: Mat<f64>,
    /// How far each may be off, its rounding included.
    pub bound: Mat<f64>,
}

/// How small an entry may be beside what bounds it before its digits do not count.
const NOTHING: i64 = -100;
/// Digits of an entry that are to be right before it is rounded.
const RIGHT: i64 = -60;

impl BoundedMatrix {
    /// The same of a matrix of which nothing but itself says how large an entry could be: the largest of its row and of
    /// its column do.
    pub(super) fn by_itself<T: Real>(
        exact: &BallMatrix<T>,
        matrix: &'static str,
    ) -> Result<Option<(BoundedMatrix, bool)>, StateSpaceError> {
        let larger = |a: Magnitude, b: Magnitude| if a < b { b } else { a };
        let size = |i: usize, j: usize| exact.middle(i, j).upper();
        let (rows, columns) = (0..exact.rows(), 0..exact.columns());
        let of_row = |i| {
            columns
                .clone()
                .map(|j| size(i, j))
                .fold(Magnitude::ZERO, larger)
        };
        let of_column = |j| {
            rows.clone()
                .map(|i| size(i, j))
                .fold(Magnitude::ZERO, larger)
        };
        let of_rows: Vec<Magnitude> = rows.clone().map(of_row).collect();
        let of_columns: Vec<Magnitude> = columns.clone().map(of_column).collect();
        BoundedMatrix::of(exact, matrix, |i, j| match of_rows[i] < of_columns[j] {
            true => of_rows[i],
            false => of_columns[j],
        })
    }

    /// The entries rounded, and whether each is known well enough for that: to its last digit, or where it is nothing
    /// beside its scale. `None` where nothing is known of an entry.
    pub(super) fn of<T: Real>(
        exact: &BallMatrix<T>,
        matrix: &'static str,
        scale: impl Fn(usize, usize) -> Magnitude,
    ) -> Result<Option<(BoundedMatrix, bool)>, StateSpaceError> {
        let (rows, columns) = (exact.rows(), exact.columns());
        let mut values = Mat::<f64>::zeros(rows, columns);
        let mut bound = Mat::<f64>::zeros(rows, columns);
        let mut good = true;
        for row in 0..rows {
            for column in 0..columns {
                let (middle, radius) = (exact.middle(row, column), exact.radius(row, column));
                let size = middle.upper();
                if !radius.is_finite() {
                    return Ok(None);
                }
                let nothing = scale(row, column) * Magnitude::power_of_two(NOTHING);
                let counts = if size < nothing { nothing } else { size };
                good &= radius <= counts * Magnitude::power_of_two(RIGHT);
                if size <= radius {
                    bound[(row, column)] = (size + radius).to_f64();
                    continue;
                }
                let value = middle.to_f64();
                if !value.is_finite() {
                    let least = middle.magnitude().minus(radius);
                    if least < Magnitude::power_of_two(1024) {
                        return Ok(None);
                    }
                    return Err(StateSpaceError::Overflow {
                        matrix,
                        row,
                        column,
                    });
                }
                values[(row, column)] = value;
                bound[(row, column)] = (radius + (middle - T::from(value)).upper()).to_f64();
            }
        }
        let infinite = (0..columns).any(|j| (0..rows).any(|i| !bound[(i, j)].is_finite()));
        Ok((!infinite).then_some((BoundedMatrix { values, bound }, good)))
    }
}
