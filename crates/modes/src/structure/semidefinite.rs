//! Positive semidefinite matrices that are no networks: finite elements, whole matrices from
//! elsewhere.
//!
//! A ≻ 0 is proved by a Cholesky factorisation of A − c·1 that runs to its end, c exceeding its
//! rounding errors (Rump 2006, *BIT* 46, theorem 2.3; Demmel 1989), in doubles, and in double-double where c is
//! too large in them. A singular A is semidefinite if it is definite on rank(A) independent rows and their
//! columns; its rank is bounded from above modulo primes.

use std::cmp::Ordering;
use std::ops::{AddAssign, Div, Mul, Sub, SubAssign};

use eigentone_digits::{Cholesky, DoubleDouble};
use faer::Mat;
use pulp::{Arch, Simd, WithSimd};

use crate::exact::matrix::ExactMatrix;
use crate::exact::rank::independent;
use crate::exact::sum::ExactSum;

/// The rank of a symmetric matrix, if it is proved positive semidefinite.
pub(crate) fn rank(matrix: &ExactMatrix) -> Option<usize> {
    let present: Vec<usize> = (0..matrix.len())
        .filter(|&i| matrix.row(i).next().is_some())
        .collect();
    match sign(matrix, &present) {
        Sign::Definite => return Some(present.len()),
        Sign::Indefinite => return None,
        Sign::Near => {}
    }
    let independent = independent(matrix);
    let count = independent.rows.len();
    (count < present.len()
        && sign(matrix, &independent.rows) == Sign::Definite
        && independent.is_largest(matrix))
    .then_some(count)
}

/// Whether a symmetric matrix is proved positive definite.
pub(crate) fn is_definite(matrix: &ExactMatrix) -> bool {
    let all: Vec<usize> = (0..matrix.len()).collect();
    sign(matrix, &all) == Sign::Definite
}

/// The same of a matrix of any size whose factor takes few operations, as that of a long beam.
pub(crate) fn is_narrow_definite(matrix: &ExactMatrix) -> bool {
    const MOST_WORK: usize = 100_000_000;
    let mut work = 0;
    let is_narrow = (0..matrix.len()).all(|i| {
        let first = matrix.row(i).map(|(j, _)| j).min().unwrap_or(i).min(i);
        work += (i - first + 1).pow(2);
        work <= MOST_WORK
    });
    is_narrow && is_definite(matrix)
}

/// What a Cholesky factorisation shows of a matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Sign {
    /// Positive definite.
    Definite,
    /// Not semidefinite.
    Indefinite,
    /// Too near to singular to be decided.
    Near,
}

/// What is proved of the rows and columns `chosen` of a symmetric matrix: in doubles, and in
/// double-double where they do not decide.
fn sign(matrix: &ExactMatrix, chosen: &[usize]) -> Sign {
    let Some(rows) = scaled(matrix, chosen) else {
        return Sign::Indefinite;
    };
    let full = is_full(&rows);
    let has_factor_in_doubles = |c: f64| {
        if full {
            return has_blocked_factor(&rows, c);
        }
        let highs = |row: &Vec<DoubleDouble>| row.iter().map(|entry| entry.high()).collect();
        let rows = rows.iter().map(highs).collect();
        Arch::new().dispatch(InDoubles { rows, c })
    };
    let size = rows.len() as f64;
    let slack = |unit: f64| 4.0 * size * (size + 5.0) * unit;
    let (near, far) = (slack(2f64.powi(-52)), slack(2f64.powi(-98)));
    if has_factor_in_doubles(near) {
        Sign::Definite
    } else if !has_factor_in_doubles(-near) {
        Sign::Indefinite
    } else if has_factor(rows, far, DoubleDouble::sqrt) {
        Sign::Definite
    } else {
        Sign::Near
    }
}

/// The lower triangle of the chosen rows and columns, which rise, by rows from their first entry on, scaled to
/// a diagonal of 1 … 4 by powers of two. `None` if a diagonal entry is not positive, or another one
/// is too large beside it for a definite matrix.
fn scaled(matrix: &ExactMatrix, chosen: &[usize]) -> Option<Vec<Vec<DoubleDouble>>> {
    let mut place = vec![usize::MAX; matrix.len()];
    let mut powers = vec![0; matrix.len()];
    for (at, &i) in chosen.iter().enumerate() {
        place[i] = at;
        let diagonal = ExactSum::of(matrix.entry(i, i));
        if diagonal.sign() != Ordering::Greater {
            return None;
        }
        powers[i] = -diagonal.exponent().div_euclid(2);
    }
    chosen
        .iter()
        .map(|&i| {
            let mut row = Vec::new();
            for (j, terms) in matrix.row(i) {
                if j > i {
                    break;
                }
                if place[j] == usize::MAX {
                    continue;
                }
                let value = ExactSum::rounded(terms, powers[i] + powers[j]);
                if value.abs() > DoubleDouble::from(4.0) {
                    return None;
                }
                if row.is_empty() {
                    row.resize(place[i] - place[j] + 1, DoubleDouble::ZERO);
                }
                let last = row.len() - 1;
                row[last - (place[i] - place[j])] = value;
            }
            Some(row)
        })
        .collect()
}

/// Whether blocks of whole columns are quicker than rows of different lengths.
fn is_full(rows: &[Vec<DoubleDouble>]) -> bool {
    const MANY: usize = 48;
    let n = rows.len();
    let filled: usize = rows.iter().map(Vec::len).sum();
    n > MANY && 4 * filled > n * n
}

/// [`has_factor`] in doubles, by faer, which sums the same products in another order and multiplies by reciprocals of pivots: one
/// rounding more.
fn has_blocked_factor(rows: &[Vec<DoubleDouble>], c: f64) -> bool {
    let n = rows.len();
    let mut matrix = Mat::<f64>::zeros(n, n);
    for (i, row) in rows.iter().enumerate() {
        let first = i + 1 - row.len();
        for (j, entry) in (first..).zip(row) {
            matrix[(i, j)] = entry.high();
        }
        matrix[(i, i)] -= c;
    }
    Cholesky::of(matrix.as_ref()).is_some()
}

/// [`has_factor`] in doubles. Closures are compiled without the wide registers of the processor where they are not inlined.
struct InDoubles {
    rows: Vec<Vec<f64>>,
    c: f64,
}

impl WithSimd for InDoubles {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        has_factor(self.rows, self.c, f64::sqrt)
    }
}

/// Whether A − c·1 has a Cholesky factor, for A given by [`scaled`].
///
/// With v bounding the relative error of each operation, and in whatever order products are summed, a factorisation that ends is exact for a
/// matrix off by at most (n + 2)v/(1 − (n + 2)v)·√(a_ii a_jj) in entry (i, j), a_ii < 4, to which
/// rounding A and subtracting c add 2v·4: in norm less than c = 4n(n + 5)v, so that A ≻ 0. One that
/// does not end, for A + c·1, shows in the same way that A is not semidefinite. What underflows is
/// below 2^-1000 and covered by v, which is taken twice too large in doubles and 8 times in
/// double-double.
#[inline(always)] // so that doubles are compiled for whole vector registers
fn has_factor<T>(mut rows: Vec<Vec<T>>, c: f64, root: impl Fn(T) -> T) -> bool
where
    T: Copy
        + From<f64>
        + PartialOrd
        + AddAssign
        + SubAssign
        + Sub<Output = T>
        + Mul<Output = T>
        + Div<Output = T>,
{
    let (c, zero) = (T::from(c), T::from(0.0));
    for i in 0..rows.len() {
        let (above, rest) = rows.split_at_mut(i);
        let row = &mut rest[0];
        let first = i + 1 - row.len();
        let mut pivot = row[i - first] - c;
        for j in first..i {
            let other = &above[j];
            let start = first.max(j + 1 - other.len());
            let mine = &row[start - first..j - first];
            let theirs = &other[other.len() - 1 - (j - start)..other.len() - 1];
            let entry = (row[j - first] - product(mine, theirs)) / other[other.len() - 1];
            pivot -= entry * entry;
            row[j - first] = entry;
        }
        if pivot.partial_cmp(&zero) != Some(Ordering::Greater) {
            return false;
        }
        row[i - first] = root(pivot);
    }
    true
}

/// aᵀb, summed in several lanes.
#[inline(always)]
fn product<T: Copy + From<f64> + AddAssign + Mul<Output = T>>(a: &[T], b: &[T]) -> T {
    const LANES: usize = 16;
    let mut lanes = [T::from(0.0); LANES];
    let (parts, others) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let (rest, other_rest) = (parts.remainder(), others.remainder());
    for (part, other) in parts.zip(others) {
        for ((lane, &a), &b) in lanes.iter_mut().zip(part).zip(other) {
            *lane += a * b;
        }
    }
    let mut sum = T::from(0.0);
    for (&a, &b) in rest.iter().zip(other_rest) {
        sum += a * b;
    }
    if a.len() >= LANES {
        lanes.into_iter().for_each(|lane| sum += lane);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::super::samples::{free_beam, matrices};
    use super::*;
    use crate::model::MatrixKind;
    use faer::{Mat, mat};
    use proptest::prelude::*;

    fn rank_of(matrix: Mat<f64>) -> Option<usize> {
        let n = matrix.nrows();
        let system = matrices(Mat::identity(n, n), Mat::zeros(n, n), matrix);
        rank(&ExactMatrix::of(system.model(), MatrixKind::Stiffness))
    }

    #[test]
    fn definite_and_indefinite_by_one_bit() {
        let e = f64::EPSILON;
        assert_eq!(rank_of(mat![[1.0, 1.0], [1.0, 1.0 + e]]), Some(2));
        assert_eq!(rank_of(mat![[1.0, 1.0], [1.0, 1.0]]), Some(1));
        assert_eq!(rank_of(mat![[1.0, 1.0], [1.0, 1.0 - e]]), None);
        assert_eq!(rank_of(mat![[1.0, 2.0], [2.0, 1.0]]), None);
        assert_eq!(rank_of(mat![[0.0, 1.0], [1.0, 0.0]]), None);
        assert_eq!(rank_of(mat![[-1.0]]), None);
        assert_eq!(rank_of(mat![[0.0]]), Some(0));
    }

    #[test]
    fn scales_far_apart() {
        let tiny = f64::from_bits(1);
        assert_eq!(rank_of(mat![[1e300, 1.0], [1.0, 1e-300 * 2.0]]), Some(2));
        assert_eq!(rank_of(mat![[1e300, 2.0], [2.0, 1e-300]]), None);
        assert_eq!(
            rank_of(mat![[2f64.powi(1000), 1.0], [1.0, 2f64.powi(-1000)]]),
            Some(1)
        );
        assert_eq!(rank_of(mat![[tiny, 0.0], [0.0, f64::MAX]]), Some(2));
        assert_eq!(rank_of(mat![[tiny, tiny], [tiny, tiny]]), Some(1));
    }

    #[test]
    fn a_bending_beam_is_definite_clamped_and_semidefinite_free() {
        for elements in [3, 40] {
            let n = 2 * elements + 2;
            let free = free_beam(elements);
            assert_eq!(rank_of(free.clone()), Some(n - 2));
            let clamped = free.submatrix(2, 2, n - 2, n - 2).to_owned();
            assert_eq!(rank_of(clamped.clone()), Some(n - 2));
            let mut pushed = clamped;
            pushed[(n - 4, n - 4)] -= 13.0;
            assert_eq!(rank_of(pushed), None);
        }
    }

    #[test]
    fn hilbert_matrices_times_their_denominators_are_definite() {
        // Condition 1e13 and 1e18 beyond what doubles distinguish.
        for (n, scale) in [(10, 232_792_560.0), (13, 26_771_144_400.0)] {
            let hilbert = Mat::from_fn(n, n, |i, j| scale / (i + j + 1) as f64);
            assert_eq!(rank_of(hilbert), Some(n));
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        /// B Bᵀ of small integers is semidefinite. Taking 2^-40 off its diagonal leaves it definite
        /// where its rank is full (its least eigenvalue is above 1/(4n)^n), and indefinite elsewhere.
        #[test]
        fn squares_are_semidefinite(n in 1usize..4, r in 0usize..5, numbers in prop::collection::vec(-1i32..2, 16)) {
            let b = Mat::from_fn(n, r, |i, j| f64::from(numbers[4 * i + j]));
            let square = &b * b.transpose();
            let rank = rank_of(square.clone());
            prop_assert!(rank.is_some_and(|rank| rank <= r.min(n)));
            let less = square - Mat::<f64>::identity(n, n) * 2f64.powi(-40);
            prop_assert_eq!(rank_of(less), rank.filter(|&rank| rank == n));
        }
    }
}
