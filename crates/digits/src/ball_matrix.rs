//! Real matrices whose entries have proven error bounds.

use std::any::Any;

use crate::radii::Radii;
use crate::{Magnitude, Real};

/// A real matrix known entry by entry: each true entry lies within its radius of its middle.
///
/// For a product, with inner length k, U = `T::unit()` and F = `T::floor()`, the computed sum of k
/// products errs by at most kU/(1 − kU) times the sum of the sizes of the products, and by F for
/// each product (Higham 2002, *Accuracy and Stability of Numerical Algorithms*, §3.1).
#[derive(Clone, Debug)]
pub struct BallMatrix<T> {
    rows: usize,
    columns: usize,
    /// Row by row.
    middle: Vec<T>,
    radius: Vec<Magnitude>,
}

impl<T: Real> BallMatrix<T> {
    /// All entries 0, exactly.
    pub fn zeros(rows: usize, columns: usize) -> BallMatrix<T> {
        BallMatrix {
            rows,
            columns,
            middle: vec![T::ZERO; rows * columns],
            radius: vec![Magnitude::ZERO; rows * columns],
        }
    }

    /// The identity, exactly.
    pub fn identity(n: usize) -> BallMatrix<T> {
        let mut identity = BallMatrix::zeros(n, n);
        (0..n).for_each(|i| identity.set(i, i, T::ONE, Magnitude::ZERO));
        identity
    }

    /// How many rows it has.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// How many columns it has.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// The middle of entry (i, j).
    #[inline]
    pub fn middle(&self, i: usize, j: usize) -> T {
        self.middle[i * self.columns + j]
    }

    /// The radius of entry (i, j).
    #[inline]
    pub fn radius(&self, i: usize, j: usize) -> Magnitude {
        self.radius[i * self.columns + j]
    }

    /// Sets entry (i, j). A middle out of range gets an infinite radius.
    pub fn set(&mut self, i: usize, j: usize, middle: T, radius: Magnitude) {
        let at = i * self.columns + j;
        self.middle[at] = middle;
        self.radius[at] = if middle.is_finite() {
            radius
        } else {
            Magnitude::INFINITY
        };
    }

    /// Whether entry (i, j) is exactly 0.
    #[inline]
    pub fn is_zero(&self, i: usize, j: usize) -> bool {
        let at = i * self.columns + j;
        self.middle[at].is_zero() && self.radius[at].is_zero()
    }

    /// Adds a ball to entry (i, j).
    pub fn add(&mut self, i: usize, j: usize, middle: T, radius: Magnitude) {
        if middle.is_zero() && radius.is_zero() {
            return;
        }
        if self.is_zero(i, j) {
            return self.set(i, j, middle, radius);
        }
        let sum = self.middle(i, j) + middle;
        let radius = self.radius(i, j) + radius + sum.upper() * T::unit();
        self.set(i, j, sum, radius);
    }

    /// The block of the given size whose first entry is (i, j).
    pub fn block(&self, i: usize, j: usize, rows: usize, columns: usize) -> BallMatrix<T> {
        let mut block = BallMatrix::zeros(rows, columns);
        for row in 0..rows {
            let from = (i + row) * self.columns + j;
            let to = row * columns;
            block.middle[to..to + columns].copy_from_slice(&self.middle[from..from + columns]);
            block.radius[to..to + columns].copy_from_slice(&self.radius[from..from + columns]);
        }
        block
    }

    /// Writes a block so that its first entry becomes (i, j).
    pub fn put(&mut self, i: usize, j: usize, block: &BallMatrix<T>) {
        for row in 0..block.rows {
            let to = (i + row) * self.columns + j;
            let from = row * block.columns;
            let length = block.columns;
            self.middle[to..to + length].copy_from_slice(&block.middle[from..from + length]);
            self.radius[to..to + length].copy_from_slice(&block.radius[from..from + length]);
        }
    }

    /// The same entries in another arithmetic, with what that leaves of their middles in the radii; the same matrix where
    /// it is the arithmetic they are in.
    pub fn rounded<U: Real>(&self) -> BallMatrix<U> {
        if let Some(same) = (self as &dyn Any).downcast_ref::<BallMatrix<U>>() {
            return same.clone();
        }
        let mut rounded = BallMatrix::zeros(self.rows, self.columns);
        for (at, (middle, radius)) in self.middle.iter().zip(&self.radius).enumerate() {
            if middle.is_zero() && radius.is_zero() {
                continue;
            }
            let high = middle.to_f64();
            let low = (*middle - T::from(high)).to_f64();
            let value = U::from(high) + U::from(low);
            // Two doubles hold what U keeps, or U keeps less.
            let high = value.to_f64();
            let low = (value - U::from(high)).to_f64();
            let back = T::from(high) + T::from(low);
            let left = (*middle - back).upper() + back.upper() * T::unit();
            rounded.set(at / self.columns, at % self.columns, value, *radius + left);
        }
        rounded
    }

    /// The product; terms with an exact 0 are passed over.
    ///
    /// # Panics
    /// If the inner sizes differ.
    pub fn times(&self, other: &BallMatrix<T>) -> BallMatrix<T> {
        assert_eq!(self.columns, other.rows, "inner sizes of a product");
        let mut product = BallMatrix::<T>::zeros(self.rows, other.columns);
        let length = Magnitude::from(self.columns as f64 + 2.0);
        let unit = T::unit() * length;
        // What the size and what the radius of a factor are multiplied by.
        let entries = || other.middle.iter().zip(&other.radius);
        let own: Vec<Magnitude> = entries()
            .map(|(middle, radius)| *radius + middle.upper() * unit)
            .collect();
        let whole: Vec<Magnitude> = entries()
            .map(|(middle, radius)| middle.upper() + *radius)
            .collect();
        let sizes: Vec<Magnitude> = self.middle.iter().map(|middle| middle.upper()).collect();
        let columns = other.columns;
        let inner = [self.columns, columns];
        let radii = Radii::of([&sizes, &self.radius], [&own, &whole], inner);
        let mut terms = Vec::with_capacity(self.columns);
        for i in 0..self.rows {
            let row = i * columns;
            let factors = (0..self.columns).filter(|k| !self.is_zero(i, *k));
            terms.clear();
            terms.extend(
                factors.map(|k| (self.middle(i, k), &other.middle[k * columns..][..columns])),
            );
            T::add_multiples(&mut product.middle[row..][..columns], &terms);
            let floor = T::floor() * Magnitude::from(2.0 * terms.len() as f64);
            let sums = &mut product.radius[row..][..columns];
            radii.row(i, sums);
            for (radius, middle) in sums.iter_mut().zip(&product.middle[row..]) {
                // It is 0 where there is no term.
                if !radius.is_zero() {
                    *radius = *radius + floor;
                }
                if !middle.is_finite() {
                    *radius = Magnitude::INFINITY;
                }
            }
        }
        product
    }

    /// The sum.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn plus(&self, other: &BallMatrix<T>) -> BallMatrix<T> {
        assert_eq!((self.rows, self.columns), (other.rows, other.columns));
        let mut sum = self.clone();
        for i in 0..self.rows {
            for j in 0..self.columns {
                sum.add(i, j, other.middle(i, j), other.radius(i, j));
            }
        }
        sum
    }

    /// The negative.
    pub fn negated(mut self) -> BallMatrix<T> {
        for middle in &mut self.middle {
            *middle = -*middle;
        }
        self
    }

    /// An upper bound of the largest row sum of sizes, ‖·‖_∞.
    pub fn row_norm(&self) -> Magnitude {
        let sum = |i: usize| {
            (0..self.columns).fold(Magnitude::ZERO, |sum, j| {
                sum + self.middle(i, j).upper() + self.radius(i, j)
            })
        };
        (0..self.rows).map(sum).fold(Magnitude::ZERO, largest)
    }

    /// An upper bound of the Frobenius norm of the radii: how far the true matrix may be from the
    /// middles, in the 2-norm.
    pub fn spread(&self) -> Magnitude {
        let squares = self.radius.iter().map(|radius| *radius * *radius);
        squares
            .fold(Magnitude::ZERO, |sum, square| sum + square)
            .sqrt()
    }

    /// A⁻¹·right for this square matrix A; `None` where the digits do not show that A is
    /// nonsingular.
    ///
    /// Rows that no entry couples are solved by themselves, so that what nothing reaches is exactly 0, and single ones divided.
    /// Otherwise X ≈ A⁻¹ comes from Gauss–Jordan elimination, and with
    /// ρ = ‖I − XA‖_∞ < 1 each column of A⁻¹R lies within ‖X(R − AZ)‖_∞/(1 − ρ) of that of Z = XR
    /// (Rump 2010, *Acta Numerica* 19, §10.7).
    pub fn solve(&self, right: &BallMatrix<T>) -> Option<BallMatrix<T>> {
        let columns: Vec<usize> = (0..right.columns).collect();
        let mut solution = BallMatrix::zeros(self.rows, right.columns);
        for rows in self.uncoupled() {
            let (part, of) = (self.part(&rows, &rows), right.part(&rows, &columns));
            let solved = match rows[..] {
                [_] => part.divide(&of)?,
                _ => part.solve_coupled(&of)?,
            };
            for (k, i) in rows.into_iter().enumerate() {
                for j in 0..right.columns {
                    solution.set(i, j, solved.middle(k, j), solved.radius(k, j));
                }
            }
        }
        Some(solution)
    }

    /// Sets of rows of this square matrix between which all entries are 0.
    fn uncoupled(&self) -> Vec<Vec<usize>> {
        let n = self.rows;
        let mut sets: Vec<usize> = (0..n).collect();
        for (i, j) in (0..n * n).map(|k| (k / n, k % n)) {
            let (one, other) = (sets[i], sets[j]);
            if one != other && !self.is_zero(i, j) {
                let joined = sets.iter_mut().filter(|set| **set == other);
                joined.for_each(|set| *set = one);
            }
        }
        let rows = |set: usize| (0..n).filter(|i| sets[*i] == set).collect::<Vec<usize>>();
        (0..n).map(rows).filter(|rows| !rows.is_empty()).collect()
    }

    /// The entries in these rows and columns, in this order.
    pub fn part(&self, rows: &[usize], columns: &[usize]) -> BallMatrix<T> {
        let mut part = BallMatrix::zeros(rows.len(), columns.len());
        for (k, i) in rows.iter().enumerate() {
            for (l, j) in columns.iter().enumerate() {
                part.set(k, l, self.middle(*i, *j), self.radius(*i, *j));
            }
        }
        part
    }

    fn solve_coupled(&self, right: &BallMatrix<T>) -> Option<BallMatrix<T>> {
        let n = self.rows;
        let inverse = self.approximate_inverse()?;
        let residual = BallMatrix::identity(n).plus(&inverse.times(self).negated());
        let contraction = residual.row_norm().to_f64();
        if contraction.is_nan() || contraction > 0.5 {
            return None;
        }
        let mut solution = inverse.times(right);
        for radius in &mut solution.radius {
            *radius = Magnitude::ZERO;
        }
        let rest = inverse.times(&right.plus(&self.times(&solution).negated()));
        let denominator = Magnitude::from((1.0 - contraction).next_down());
        for j in 0..right.columns {
            let size = (0..n)
                .map(|i| rest.middle(i, j).upper() + rest.radius(i, j))
                .fold(Magnitude::ZERO, largest);
            let radius = size / denominator;
            for i in 0..n {
                let middle = solution.middle(i, j);
                solution.set(i, j, middle, radius);
            }
        }
        Some(solution)
    }

    /// X ≈ A⁻¹ from the middles, by Gauss–Jordan elimination with row pivoting; nothing is claimed of
    /// its error. `None` where a pivot is 0, or entries leave the range of T.
    pub fn approximate_inverse(&self) -> Option<BallMatrix<T>> {
        let n = self.rows;
        let mut left = self.middle.clone();
        let mut inverse = BallMatrix::<T>::identity(n);
        for k in 0..n {
            let size = |i: usize| left[i * n + k].magnitude();
            let pivot = (k..n).fold(k, |best, i| if size(best) < size(i) { i } else { best });
            if left[pivot * n + k].is_zero() || !left[pivot * n + k].is_finite() {
                return None;
            }
            for j in 0..n {
                left.swap(k * n + j, pivot * n + j);
                inverse.middle.swap(k * n + j, pivot * n + j);
            }
            let divisor = left[k * n + k];
            for j in 0..n {
                left[k * n + j] = left[k * n + j] / divisor;
                inverse.middle[k * n + j] = inverse.middle[k * n + j] / divisor;
            }
            let row = k * n..(k + 1) * n;
            let pivot = [left[row.clone()].to_vec(), inverse.middle[row].to_vec()];
            for i in (0..n).filter(|i| *i != k) {
                let factor = left[i * n + k];
                if factor.is_zero() {
                    continue;
                }
                let row = i * n..(i + 1) * n;
                T::add_multiple(&mut left[row.clone()], -factor, &pivot[0]);
                T::add_multiple(&mut inverse.middle[row], -factor, &pivot[1]);
            }
        }
        inverse
            .middle
            .iter()
            .all(|x| x.is_finite())
            .then_some(inverse)
    }

    /// Each row of `right` divided by the diagonal entry of this matrix.
    fn divide(&self, right: &BallMatrix<T>) -> Option<BallMatrix<T>> {
        let mut quotient = BallMatrix::zeros(right.rows, right.columns);
        for i in 0..self.rows {
            let (d, r) = (self.middle(i, i), self.radius(i, i));
            let least = d.magnitude().below().minus(r);
            if least.is_zero() {
                return None;
            }
            for j in (0..right.columns).filter(|j| !right.is_zero(i, *j)) {
                let (b, s) = (right.middle(i, j), right.radius(i, j));
                let q = b / d;
                // |(b ± s)/(d ± r) − q| ≤ (|b − qd| + s + |q|r)/(|d| − r), and b − qd is at most a
                // unit of b, beside underflow.
                let size = q.upper();
                let rest =
                    size * d.upper() * T::unit() + T::floor() * (d.upper() + Magnitude::from(1.0));
                quotient.set(i, j, q, (rest + s + size * r) / least);
            }
        }
        Some(quotient)
    }
}

fn largest(a: Magnitude, b: Magnitude) -> Magnitude {
    if a < b { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rational::Exact;
    use crate::{DoubleDouble, Wide};
    use num_rational::BigRational;
    use num_traits::{Signed, Zero};
    use proptest::prelude::*;

    fn points<T: Real>(n: usize, values: &[f64]) -> BallMatrix<T> {
        let mut matrix = BallMatrix::zeros(n, n);
        for i in 0..n {
            for j in 0..n {
                matrix.set(i, j, T::from(values[i * n + j]), Magnitude::ZERO);
            }
        }
        matrix
    }

    fn rational(n: usize, values: &[f64]) -> Vec<Vec<BigRational>> {
        (0..n)
            .map(|i| (0..n).map(|j| values[i * n + j].exact()).collect())
            .collect()
    }

    fn product(a: &[Vec<BigRational>], b: &[Vec<BigRational>]) -> Vec<Vec<BigRational>> {
        let n = a.len();
        let entry = |i: usize, j: usize| {
            (0..n).fold(BigRational::zero(), |sum, k| sum + &a[i][k] * &b[k][j])
        };
        (0..n)
            .map(|i| (0..n).map(|j| entry(i, j)).collect())
            .collect()
    }

    fn holds<T: Real + Exact>(matrix: &BallMatrix<T>, truth: &[Vec<BigRational>]) -> bool {
        (0..matrix.rows()).all(|i| {
            (0..matrix.columns()).all(|j| {
                let error = (matrix.middle(i, j).exact() - &truth[i][j]).abs();
                error <= matrix.radius(i, j).exact()
            })
        })
    }

    fn check<T: Real + Exact>(n: usize, a: &[f64], b: &[f64]) -> Result<(), TestCaseError> {
        let (x, y) = (points::<T>(n, a), points::<T>(n, b));
        let (p, q) = (rational(n, a), rational(n, b));
        let xy = x.times(&y);
        let pq = product(&p, &q);
        prop_assert!(holds(&xy, &pq));
        prop_assert!(holds(&xy.times(&y), &product(&pq, &q)));
        // A solution Z with AZ = B: the true B lies in A·Z, and B's own points with A⁻¹(AB) = B.
        if let Some(z) = x.solve(&xy) {
            prop_assert!(holds(&z, &q));
            let relative = (0..n * n).map(|at| z.radius(at / n, at % n).to_f64());
            let worst = relative.fold(0.0, f64::max);
            prop_assert!(worst < 1e-15 * (1.0 + z.row_norm().to_f64()) || worst < 1e300);
        }
        Ok(())
    }

    proptest! {
        /// To fewer digits and to as many, and back: what is left out lies within the radii, and not far within.
        #[test]
        fn rounding_is_counted(values in prop::collection::vec((-1.0..1.0, -1.0..1.0, -200..200), 4)) {
            let entry = |(a, b, power): &(f64, f64, i32)| {
                // More digits than two doubles hold, and a gap between them.
                let third = Wide::<4>::from(*a) / Wide::from(3.0);
                (third + Wide::from(*b).scale(-170)).scale(i64::from(*power))
            };
            let mut fine = BallMatrix::<Wide<4>>::zeros(2, 2);
            for (at, value) in values.iter().enumerate() {
                fine.set(at / 2, at % 2, entry(value), Magnitude::ZERO);
            }
            let truth: Vec<Vec<BigRational>> =
                (0..2).map(|i| (0..2).map(|j| fine.middle(i, j).exact()).collect()).collect();
            let two = fine.rounded::<DoubleDouble>();
            prop_assert!(holds(&two, &truth));
            prop_assert!(holds(&fine.rounded::<f64>(), &truth));
            prop_assert!(holds(&two.rounded::<Wide<8>>(), &truth));
            let same = fine.rounded::<Wide<4>>();
            prop_assert!(same.radius.iter().all(|radius| radius.is_zero()) && same.middle == fine.middle);
            for (middle, radius) in two.middle.iter().zip(&two.radius) {
                prop_assert!(radius.to_f64() <= middle.to_f64().abs() * 2f64.powi(-105) + 1e-320);
            }
        }

        #[test]
        fn products_and_quotients_hold_the_truth(
            n in 1usize..5,
            entries in proptest::collection::vec((-1.0..1.0f64, -8i32..8, any::<bool>()), 50),
        ) {
            let value = |&(x, power, zero): &(f64, i32, bool)| if zero { 0.0 } else { x * 2f64.powi(power) };
            let values: Vec<f64> = entries.iter().map(value).collect();
            check::<DoubleDouble>(n, &values[..n * n], &values[25..25 + n * n])?;
            check::<Wide<4>>(n, &values[..n * n], &values[25..25 + n * n])?;
        }
    }

    #[test]
    fn what_nothing_couples_is_exactly_0() {
        // The first and the third row, and the second by itself.
        let matrix = points::<DoubleDouble>(3, &[2.0, 0.0, 1.0, 0.0, 3.0, 0.0, 1.0, 0.0, 5.0]);
        let inverse = matrix.solve(&BallMatrix::identity(3)).expect("regular");
        for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
            assert_eq!(inverse.is_zero(i, j), (i == 1) != (j == 1), "{i} {j}");
        }
    }

    #[test]
    fn a_singular_matrix_has_no_quotient() {
        let one = points::<DoubleDouble>(2, &[1.0, 2.0, 2.0, 4.0]);
        assert!(one.solve(&BallMatrix::identity(2)).is_none());
        assert!(
            points::<DoubleDouble>(2, &[0.0; 4])
                .solve(&BallMatrix::identity(2))
                .is_none()
        );
    }

    #[test]
    fn a_well_conditioned_solution_is_sharp() {
        let a = points::<DoubleDouble>(2, &[4.0, 1.0, -1.0, 3.0]);
        let z = a.solve(&BallMatrix::identity(2)).expect("regular");
        assert!((z.middle(0, 0).to_f64() - 3.0 / 13.0).abs() < 1e-16);
        assert!(z.radius(0, 0).to_f64() < 1e-30);
    }
}
