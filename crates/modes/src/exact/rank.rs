//! The rank of a sparse matrix: from below by elimination modulo one prime, from above modulo so
//! many that their product exceeds every larger minor.

use super::elimination::{Row, eliminate};
use super::matrix::ExactMatrix;
use super::prime_field::{MOST_WORK, PRIME_BITS, PrimeField};
use super::sum::ceil_log2;

/// Rows that were seen to be independent.
pub(crate) struct Independent {
    /// As many as the matrix has modulo a prime, rising.
    pub(crate) rows: Vec<usize>,
    /// The multiplications it took.
    work: u64,
}

/// A set of independent rows, and almost certainly a largest one.
pub(crate) fn independent(matrix: &ExactMatrix) -> Independent {
    let field = PrimeField::first();
    let echelon = eliminate(&field, rows(matrix, &field));
    let mut rows = echelon.independent;
    rows.sort_unstable();
    Independent {
        rows,
        work: echelon.work,
    }
}

impl Independent {
    /// Whether it is proved that no other row is independent of these.
    pub(crate) fn is_largest(&self, matrix: &ExactMatrix) -> bool {
        let count = self.rows.len();
        let present = (0..matrix.len()).filter(|&i| matrix.row(i).next().is_some());
        let mut bits: Vec<u64> = present
            .map(|i| matrix.extent(i).bits() + ceil_log2(matrix.row(i).count()) as u64)
            .collect();
        if bits.len() == count {
            return true;
        }
        bits.sort_unstable_by(|a, b| b.cmp(a));
        let minor: u64 = bits.iter().take(count + 1).sum();
        let primes = minor / PRIME_BITS + 1;
        primes.saturating_mul(self.work) <= MOST_WORK
            && PrimeField::all()
                .take(primes as usize)
                .all(|field| eliminate(&field, rows(matrix, &field)).independent.len() <= count)
    }
}

/// The rank, where it is proved within [`MOST_WORK`].
pub(crate) fn rank(matrix: &ExactMatrix) -> Option<usize> {
    let independent = independent(matrix);
    independent
        .is_largest(matrix)
        .then_some(independent.rows.len())
}

/// Whether a square matrix of so many rows is singular, whose entries are the sums without rounding of what is given for them, as
/// (row, column, value); `None` where it is not decided within a second, a value is not finite, or one stands outside of the matrix.
///
/// ```
/// use eigentone_modes::is_singular;
///
/// // A third and two thirds are no doubles, and yet [3 1; 6 2] is singular.
/// let rows = [(0, 0, 3.0), (0, 1, 1.0), (1, 0, 6.0), (1, 1, 2.0)];
/// assert_eq!(is_singular(2, rows.to_vec()), Some(true));
/// let beside = rows.into_iter().chain([(1, 1, 1e-300)]);
/// assert_eq!(is_singular(2, beside.collect()), Some(false));
/// assert_eq!(is_singular(usize::MAX, rows.to_vec()), Some(true));
/// assert_eq!(is_singular(1, rows.to_vec()), None);
/// ```
pub fn is_singular(size: usize, parts: Vec<(usize, usize, f64)>) -> Option<bool> {
    let is_part = |part: &(usize, usize, f64)| part.0 < size && part.1 < size && part.2.is_finite();
    if !parts.iter().all(is_part) {
        return None;
    }
    // A row is empty.
    if parts.len() < size {
        return Some(true);
    }
    rank(&ExactMatrix::from_parts(size, parts)).map(|rank| rank < size)
}

fn rows(matrix: &ExactMatrix, field: &PrimeField) -> Vec<Row> {
    let image = matrix.image(field);
    let row = |i| Row::new(field, &image.row(i).collect::<Vec<_>>());
    (0..matrix.len()).map(row).collect()
}
