//! Second-order systems of a few masses: everything in arrays.

use faer::{Mat, MatRef};
use pulp::{Simd, WithSimd};

use super::algebra::Algebra;
use super::choice::{Choice, Size, is_upper};
use super::contiguous::{Columns, with_columns};
use super::dense::Dense;
use super::growth::Growth;
use super::squaring::square;
use super::taylor::store;
use super::vector::run;

/// 2^-s [0 G; −K −C] with `N` masses, columns padded to `ROWS`.
pub(super) struct FewMasses<const N: usize, const ROWS: usize> {
    g: [f64; N],
    /// Row i of column j at [j][i].
    k: Square<N, ROWS>,
    c: Square<N, ROWS>,
    choice: Choice,
}

type Square<const N: usize, const ROWS: usize> = [[f64; ROWS]; N];

/// 1/k! up to the largest degree.
const INVERSE_FACTORIALS: [f64; 26] = {
    let mut all = [1.0; 26];
    let mut factorial = 1.0;
    let mut k = 1;
    while k < all.len() {
        // Exact up to 22!, and rounded less than a unit beyond.
        factorial *= k as f64;
        all[k] = 1.0 / factorial;
        k += 1;
    }
    all
};

impl<const N: usize, const ROWS: usize> FewMasses<N, ROWS> {
    /// `None` for a matrix of another form, or too large for its powers to be formed.
    pub(super) fn of(a: MatRef<'_, f64>) -> Option<Self> {
        with_columns(a, Self::of_columns)
    }

    fn of_columns(a: Columns<'_>) -> Option<Self> {
        const LARGEST: f64 = 1e40;
        let mut g = [0.0; N];
        let mut k = [[0.0; ROWS]; N];
        let mut c = [[0.0; ROWS]; N];
        let (mut stiffness, mut damping) = (0.0f64, 0.0f64);
        let mut all = 0.0;
        for j in 0..N {
            let (left, right) = (a.col(j).as_slice(), a.col(N + j).as_slice());
            if !is_upper(N, j, left, right) {
                return None;
            }
            g[j] = right[j];
            let (mut by_k, mut by_c) = (0.0, 0.0);
            for i in 0..N {
                k[j][i] = -left[N + i];
                c[j][i] = -right[N + i];
                by_k += k[j][i].abs();
                by_c += c[j][i].abs();
            }
            all += by_k + by_c + g[j];
            stiffness = stiffness.max(by_k);
            damping = damping.max(c[j][j]);
        }
        // Nothing below is NaN either.
        let moderate = all < LARGEST;
        if !moderate {
            return None;
        }
        let [mut x, mut v, mut by_k, mut by_c] = [[0.0; N]; 4];
        let scratch = [&mut x[..], &mut v[..], &mut by_k[..], &mut by_c[..]];
        let size = Size::of(&g, stiffness, scratch, |w, by_k, by_c| {
            for j in 0..N {
                let sum =
                    |column: &[f64; ROWS]| -> f64 { (0..N).map(|i| w[i] * column[i].abs()).sum() };
                (by_k[j], by_c[j]) = (sum(&k[j]), sum(&c[j]));
            }
        });
        let choice = Choice::of(&size, damping)?;
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
        let halves = run(Polynomial { system: self });
        let n = 2 * N;
        let products = f64::from(degree) / 4.0 + f64::from(squarings);
        if squarings == 0 {
            let mut result = Mat::zeros(n, n);
            for at in 0..n {
                let column = result.col_as_slice_mut(at);
                write(column, &halves, at);
                column[at] += 1.0;
            }
            return (result, products);
        }
        let mut dense = Dense::new(n);
        let mut less_one = dense.zeros();
        for (at, column) in less_one.chunks_exact_mut(n).enumerate() {
            write(column, &halves, at);
        }
        let squarings = squarings.unsigned_abs();
        let result = square(&mut dense, less_one, squarings, || Growth::of(a));
        let matrix = store(a, &result, squarings);
        dense.recycle(result.element);
        (matrix, products)
    }
}

/// The column of this index, from those of the four blocks.
fn write<const N: usize, const ROWS: usize>(
    column: &mut [f64],
    halves: &[Square<N, ROWS>; 4],
    at: usize,
) {
    let (side, j) = (at / N, at % N);
    let (upper, lower) = column.split_at_mut(N);
    upper.copy_from_slice(&halves[2 * side][j][..N]);
    lower.copy_from_slice(&halves[2 * side + 1][j][..N]);
}

/// The Taylor polynomial of 2^-s [0 G; −K −C], less the identity: upper and lower half of its left columns, then
/// of its right ones.
///
/// Horner's scheme as in [`Series`](super::series::Series), for W_k = Q_k/(k − 1)!, which needs no factors: W_k =
/// I/k! − W_{k+2} KG − W_{k+1} C, and in the end Q = W_1, R = W_2.
struct Polynomial<'a, const N: usize, const ROWS: usize> {
    system: &'a FewMasses<N, ROWS>,
}

impl<const N: usize, const ROWS: usize> WithSimd for Polynomial<'_, N, ROWS> {
    type Output = [Square<N, ROWS>; 4];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [Square<N, ROWS>; 4] {
        let FewMasses { g, k, c, choice } = self.system;
        let pushed: Square<N, ROWS> = std::array::from_fn(|j| k[j].map(|k| -k * g[j]));
        let damped = c.map(|column| column.map(|c| -c));
        let one: Square<N, ROWS> =
            std::array::from_fn(|j| std::array::from_fn(|i| f64::from(u8::from(i == j))));
        let mut older = [[0.0; ROWS]; N];
        let mut newer = [[0.0; ROWS]; N];
        let degree = choice.degree as usize;
        for factor in INVERSE_FACTORIALS[1..=degree].iter().rev() {
            let mut next = [[0.0; ROWS]; N];
            for j in 0..N {
                add(simd, &mut next[j], *factor, &one[j]);
                for i in 0..N {
                    add(simd, &mut next[j], pushed[j][i], &older[i]);
                }
                for i in 0..N {
                    add(simd, &mut next[j], damped[j][i], &newer[i]);
                }
            }
            (older, newer) = (newer, next);
        }
        // [−GRK, −QK] and [GQ, −RKG − QC].
        let (r, q) = (older, newer);
        let mut halves = [[[0.0; ROWS]; N]; 4];
        let mut rows = [0.0; ROWS];
        rows[..N].copy_from_slice(g);
        for j in 0..N {
            let [mut rk, mut qk, mut sum] = [[0.0; ROWS]; 3];
            for i in 0..N {
                add(simd, &mut rk, -k[j][i], &r[i]);
                add(simd, &mut qk, -k[j][i], &q[i]);
                add(simd, &mut sum, damped[j][i], &q[i]);
            }
            add(simd, &mut sum, g[j], &rk);
            for row in 0..ROWS {
                halves[0][j][row] = rk[row] * rows[row];
                halves[2][j][row] = q[j][row] * rows[row];
            }
            halves[1][j] = qk;
            halves[3][j] = sum;
        }
        halves
    }
}

/// out += factor · x.
#[inline(always)]
fn add<S: Simd, const ROWS: usize>(simd: S, out: &mut [f64; ROWS], factor: f64, x: &[f64; ROWS]) {
    let (out, last) = S::as_mut_simd_f64s(out);
    let (x, x_last) = S::as_simd_f64s(x);
    let factors = simd.splat_f64s(factor);
    for (out, x) in out.iter_mut().zip(x) {
        *out = simd.mul_add_e_f64s(factors, *x, *out);
    }
    for (out, x) in last.iter_mut().zip(x_last) {
        *out += factor * x;
    }
}
