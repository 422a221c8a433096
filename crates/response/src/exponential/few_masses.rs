//! Second-order systems of a few masses: everything in arrays.

use faer::{Mat, MatRef};

use super::algebra::Algebra;
use super::contiguous::{Columns, with_columns};
use super::dense::Dense;
use super::growth::Growth;
use super::second_order::{Choice, is_upper, size};
use super::series::SmallSeries;
use super::squaring::square;
use super::taylor::store;
use crate::vector::run;

/// 2^-s [0 G; −K −C] with `N` masses, columns padded to `ROWS`.
pub(super) struct FewMasses<const N: usize, const ROWS: usize> {
    g: [f64; N],
    /// Row i of column j at [j][i].
    k: [[f64; ROWS]; N],
    c: [[f64; ROWS]; N],
    choice: Choice,
}

impl<const N: usize, const ROWS: usize> FewMasses<N, ROWS> {
    /// `None` for a matrix of another form.
    pub(super) fn of(a: MatRef<'_, f64>) -> Option<Self> {
        with_columns(a, Self::of_columns)
    }

    fn of_columns(a: Columns<'_>) -> Option<Self> {
        let mut g = [0.0; N];
        let mut k = [[0.0; ROWS]; N];
        let mut c = [[0.0; ROWS]; N];
        let (mut stiffness, mut damping) = (0.0f64, 0.0f64);
        for j in 0..N {
            let (left, right) = (a.col(j).as_slice(), a.col(N + j).as_slice());
            if !is_upper(N, j, left, right) {
                return None;
            }
            g[j] = right[j];
            let mut sum = 0.0;
            for i in 0..N {
                k[j][i] = -left[N + i];
                c[j][i] = -right[N + i];
                sum += k[j][i].abs();
            }
            stiffness = stiffness.max(sum);
            damping = damping.max(c[j][j]);
        }
        let [mut x, mut v, mut by_k, mut by_c] = [[0.0; N]; 4];
        let scratch = [&mut x[..], &mut v[..], &mut by_k[..], &mut by_c[..]];
        let size = size(&g, stiffness, scratch, |w, by_k, by_c| {
            for j in 0..N {
                let sum =
                    |column: &[f64; ROWS]| -> f64 { (0..N).map(|i| w[i] * column[i].abs()).sum() };
                (by_k[j], by_c[j]) = (sum(&k[j]), sum(&c[j]));
            }
        });
        let choice = Choice::of(size, damping)?;
        if choice.squarings > 0 {
            let epsilon = 2f64.powi(-choice.squarings);
            let entries = g.iter_mut().chain(k.iter_mut().flatten());
            entries
                .chain(c.iter_mut().flatten())
                .for_each(|entry| *entry *= epsilon);
        }
        Some(FewMasses { g, k, c, choice })
    }

    /// e^A, and what it cost in products of the order of A.
    pub(super) fn exponential(&self, a: MatRef<'_, f64>) -> (Mat<f64>, f64) {
        let Choice { degree, squarings } = self.choice;
        let [r, q] = run(SmallSeries {
            k: &self.k,
            c: &self.c,
            g: &self.g,
            degree,
        });
        let n = 2 * N;
        let products = f64::from(degree) / 4.0 + f64::from(squarings);
        if squarings == 0 {
            let mut result = Mat::zeros(n, n);
            for j in 0..N {
                let [left, right] = self.columns(&r, &q, j, 1.0);
                write(result.col_as_slice_mut(j), &left);
                write(result.col_as_slice_mut(N + j), &right);
            }
            return (result, products);
        }
        let mut dense = Dense::new(n);
        let mut less_one = dense.zeros();
        for j in 0..N {
            let [left, right] = self.columns(&r, &q, j, 0.0);
            write(&mut less_one[n * j..n * (j + 1)], &left);
            write(&mut less_one[n * (N + j)..n * (N + j + 1)], &right);
        }
        let squarings = squarings.unsigned_abs();
        let result = square(&mut dense, less_one, squarings, || Growth::of(a));
        let matrix = store(n, &result);
        dense.recycle(result.element);
        (matrix, products)
    }

    /// Columns j and N + j of the polynomial, upper and lower half, with `one` for the identity.
    fn columns(
        &self,
        r: &[[f64; ROWS]; N],
        q: &[[f64; ROWS]; N],
        j: usize,
        one: f64,
    ) -> [[[f64; N]; 2]; 2] {
        let (mut left, mut right) = ([[0.0; N]; 2], [[0.0; N]; 2]);
        for row in 0..N {
            let [mut rk, mut qk, mut qc] = [0.0; 3];
            for i in 0..N {
                rk += r[i][row] * self.k[j][i];
                qk += q[i][row] * self.k[j][i];
                qc += q[i][row] * self.c[j][i];
            }
            left[0][row] = -rk * self.g[row];
            left[1][row] = -qk;
            right[0][row] = q[j][row] * self.g[row];
            right[1][row] = -(rk * self.g[j] + qc);
        }
        left[0][j] += one;
        right[1][j] += one;
        [left, right]
    }
}

fn write<const N: usize>(column: &mut [f64], halves: &[[f64; N]; 2]) {
    let (upper, lower) = column.split_at_mut(N);
    upper.copy_from_slice(&halves[0]);
    lower.copy_from_slice(&halves[1]);
}
