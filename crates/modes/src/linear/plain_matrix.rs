//! Dense matrices in the arithmetic of any [`Real`], without bounds.

use eigentone_digits::Real;

/// A real matrix; nothing is claimed of the rounding errors of its entries.
#[derive(Clone, Debug)]
pub(crate) struct PlainMatrix<T> {
    rows: usize,
    columns: usize,
    /// Row by row.
    entries: Vec<T>,
}

impl<T: Real> PlainMatrix<T> {
    pub(crate) fn zeros(rows: usize, columns: usize) -> PlainMatrix<T> {
        PlainMatrix {
            rows,
            columns,
            entries: vec![T::ZERO; rows * columns],
        }
    }

    pub(crate) fn size(&self) -> [usize; 2] {
        [self.rows, self.columns]
    }

    pub(crate) fn get(&self, i: usize, j: usize) -> T {
        self.entries[i * self.columns + j]
    }

    pub(crate) fn set(&mut self, i: usize, j: usize, entry: T) {
        self.entries[i * self.columns + j] = entry;
    }

    pub(crate) fn row(&self, i: usize) -> &[T] {
        &self.entries[i * self.columns..(i + 1) * self.columns]
    }

    pub(crate) fn row_mut(&mut self, i: usize) -> &mut [T] {
        &mut self.entries[i * self.columns..(i + 1) * self.columns]
    }

    pub(crate) fn times(&self, other: &PlainMatrix<T>) -> PlainMatrix<T> {
        let mut product = PlainMatrix::zeros(self.rows, other.columns);
        for i in 0..self.rows {
            let terms = self.row(i).iter().enumerate();
            let terms = terms.filter(|(_, factor)| !factor.is_zero());
            let terms: Vec<_> = terms.map(|(k, factor)| (*factor, other.row(k))).collect();
            T::add_multiples(product.row_mut(i), &terms);
        }
        product
    }

    /// A⁻¹·right for this square matrix A, by Gaussian elimination with row pivoting; `None` where a pivot is 0, or not
    /// finite.
    pub(crate) fn solve(&self, right: &PlainMatrix<T>) -> Option<PlainMatrix<T>> {
        let n = self.rows;
        let mut left = self.clone();
        let mut solution = right.clone();
        for k in 0..n {
            let larger = |best, i| match left.get(best, k).abs() < left.get(i, k).abs() {
                true => i,
                false => best,
            };
            let pivot = (k..n).fold(k, larger);
            left.swap_rows(k, pivot);
            solution.swap_rows(k, pivot);
            let divisor = left.get(k, k);
            if divisor.is_zero() || !divisor.is_finite() {
                return None;
            }
            for i in k + 1..n {
                let factor = left.get(i, k);
                if !factor.is_zero() {
                    let factor = -(factor / divisor);
                    left.add_row(i, factor, k);
                    solution.add_row(i, factor, k);
                }
            }
        }
        for k in (0..n).rev() {
            let divisor = left.get(k, k);
            for entry in solution.row_mut(k) {
                *entry = *entry / divisor;
            }
            for i in 0..k {
                let factor = left.get(i, k);
                if !factor.is_zero() {
                    solution.add_row(i, -factor, k);
                }
            }
        }
        Some(solution)
    }

    fn swap_rows(&mut self, i: usize, k: usize) {
        for j in (0..self.columns).filter(|_| i != k) {
            self.entries
                .swap(i * self.columns + j, k * self.columns + j);
        }
    }

    /// Adds a multiple of an earlier or later row.
    fn add_row(&mut self, to: usize, factor: T, from: usize) {
        let columns = self.columns;
        let (first, second) = self.entries.split_at_mut(to.max(from) * columns);
        let [low, high] = [to.min(from) * columns, 0];
        let (first, second) = (&mut first[low..low + columns], &mut second[high..columns]);
        match to < from {
            true => T::add_multiple(first, factor, second),
            false => T::add_multiple(second, factor, first),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentone_digits::DoubleDouble;

    /// The Hilbert matrix of 8 rows has the condition 1.5e10, and an inverse of whole numbers.
    #[test]
    fn solves_with_more_digits_than_doubles_have() {
        const N: usize = 8;
        let mut hilbert = PlainMatrix::<DoubleDouble>::zeros(N, N);
        let mut ones = PlainMatrix::zeros(N, 1);
        for i in 0..N {
            for j in 0..N {
                // Upside down, so that rows are exchanged.
                let sum = DoubleDouble::from((N - i + j) as f64);
                hilbert.set(i, j, DoubleDouble::ONE / sum);
            }
            ones.set(i, 0, DoubleDouble::ONE);
        }
        // The sums of the rows of the inverse.
        let binomial = |n: usize, k: usize| {
            (1..=k).fold(1.0, |product, i| product * (n - k + i) as f64 / i as f64)
        };
        let solution = hilbert.solve(&ones).expect("regular");
        for i in 0..N {
            let sign = [1.0, -1.0][(N - 1 - i) % 2];
            let row = (i + 1) as f64 * binomial(N + i, i + 1) * binomial(N - 1, i) * sign;
            let off = (solution.get(i, 0).to_f64() / row - 1.0).abs();
            assert!(off < 1e-15, "{i}: {off:e}");
        }
        assert!(hilbert.times(&solution).row(3)[0].to_f64() == 1.0);
    }

    #[test]
    fn a_singular_matrix_is_refused() {
        let mut matrix = PlainMatrix::<f64>::zeros(2, 2);
        (0..2).for_each(|i| (0..2).for_each(|j| matrix.set(i, j, 2.0)));
        assert!(matrix.solve(&PlainMatrix::zeros(2, 1)).is_none());
    }
}
