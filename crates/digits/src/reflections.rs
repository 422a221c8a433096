//! Reduction of a symmetric matrix to tridiagonal form by reflections, several columns at a time: J. J. Dongarra, D. C. Sorensen and
//! S. J. Hammarling, *Block reduction of matrices to condensed forms for eigenvalue computations*, J. Comput. Appl. Math. 27
//! (1989).
//!
//! A reflection 1 − τ v vᵀ changes the rest of the matrix by −v wᵀ − w vᵀ. In a panel of columns only the one that comes next is brought
//! up to date, and w comes from v and from the matrix as it was before the panel, which is only read: 4/3 n³ operations, one half of
//! them in products of matrices.

use faer::linalg::matmul::matmul;
use faer::prelude::ReborrowMut;
use faer::{Accum, Mat, MatMut, Par};
use pulp::{Arch, Simd, WithSimd};

use crate::settle;

/// Columns of a panel; even.
const PANEL: usize = 8;

/// Columns that are read together.
const TOGETHER: usize = 4;

/// T with A = Q T Qᵀ, and what Q is the product of.
pub(crate) struct Reduced {
    pub(crate) diagonal: Vec<f64>,
    /// The entries below the diagonal.
    pub(crate) below: Vec<f64>,
    /// The vectors v, column by column: below the diagonal, with 1 first and 0 above them. Rows of 0 at the end make them
    /// [`even`](crate::even).
    vectors: Mat<f64>,
    /// The factors τ.
    factors: Vec<f64>,
}

impl Reduced {
    /// Of the lower half of a matrix of one row or more. What is not finite shows in T.
    pub(crate) fn of(matrix: &Mat<f64>) -> Reduced {
        const STRIPE: usize = 64;
        let n = matrix.nrows();
        let rows = n.next_multiple_of(8);
        let mut reduced = Reduced {
            diagonal: Vec::with_capacity(n),
            below: Vec::with_capacity(n),
            // At first those of the matrix.
            vectors: Mat::zeros(rows, n),
            factors: Vec::with_capacity(n),
        };
        let mut most = 0.0f64;
        for (j, column) in matrix.col_iter().enumerate() {
            let entries = column.subrows(j, n - j);
            reduced
                .vectors
                .col_mut(j)
                .subrows_mut(j, n - j)
                .copy_from(entries);
            most = most.max(largest(&reduced.vectors.col_as_slice(j)[j..n]));
        }
        // Squares stay within the range of doubles.
        let unit = if most.is_normal() {
            most.log2().floor().exp2()
        } else {
            1.0
        };
        for column in reduced.vectors.col_iter_mut() {
            column.iter_mut().for_each(|entry| *entry /= unit);
        }
        let mut changes = [Mat::zeros(rows, 2 * PANEL), Mat::zeros(rows, 2 * PANEL)];
        for first in (0..n).step_by(PANEL) {
            let end = n.min(first + PANEL);
            let [left, right] = &mut changes;
            left.fill(0.0);
            Arch::new().dispatch(Panel {
                changes: left,
                columns: first..end,
                reduced: &mut reduced,
            });
            for q in 0..2 * PANEL {
                right.col_mut(q).copy_from(left.col(q ^ 1));
            }
            for at in (end..n).step_by(STRIPE) {
                let width = STRIPE.min(n - at);
                matmul(
                    reduced.vectors.submatrix_mut(at, at, n - at, width),
                    Accum::Add,
                    left.subrows(at, n - at),
                    right.subrows(at, width).transpose(),
                    -1.0,
                    Par::Seq,
                );
            }
            settle();
        }
        for entries in [&mut reduced.diagonal, &mut reduced.below] {
            entries.iter_mut().for_each(|entry| *entry *= unit);
        }
        reduced
    }

    /// QX in the place of X.
    pub(crate) fn apply(&self, mut x: MatMut<'_, f64>) {
        const BLOCK: usize = 16;
        let (n, columns) = (x.nrows(), x.ncols());
        let count = self.factors.len();
        let mut starts: Vec<usize> = (0..count).step_by(BLOCK).collect();
        while let Some(first) = starts.pop() {
            let width = BLOCK.min(count - first);
            let rows = n - first - 1;
            let v = self.vectors.submatrix(first + 1, first, rows, width);
            // (1 − τ₁v₁v₁ᵀ) … = 1 − V S Vᵀ with an upper triangle S (Schreiber & Van Loan 1989).
            let products = v.transpose() * v;
            let mut s = Mat::<f64>::zeros(width, width);
            for j in 0..width {
                let factor = self.factors[first + j];
                for i in 0..j {
                    let sum: f64 = (i..j).map(|k| s[(i, k)] * products[(k, j)]).sum();
                    s[(i, j)] = -factor * sum;
                }
                s[(j, j)] = factor;
            }
            let mut x = x.rb_mut().submatrix_mut(first + 1, 0, rows, columns);
            let change = s * (v.transpose() * x.rb_mut());
            matmul(x, Accum::Add, v, change, -1.0, Par::Seq);
        }
        settle();
    }
}

/// The columns of one panel, of which those behind are as they were before it, in code for the registers that the processor has.
struct Panel<'a> {
    /// The vectors v and w of this panel in turn, and 0 where there are none yet.
    changes: &'a mut Mat<f64>,
    columns: std::ops::Range<usize>,
    reduced: &'a mut Reduced,
}

impl WithSimd for Panel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Panel {
            changes,
            columns,
            reduced,
        } = self;
        let n = reduced.vectors.ncols();
        let mut w = vec![0.0; n];
        for (i, j) in columns.enumerate() {
            let done = (2 * i).next_multiple_of(TOGETHER);
            let mut factors = [0.0; 2 * PANEL];
            (0..done).for_each(|q| factors[q] = -changes[(j, q ^ 1)]);
            let column = &mut reduced.vectors.col_as_slice_mut(j)[..n];
            add(simd, &mut column[j..], changes, j, &factors[..done]);
            reduced.diagonal.push(column[j]);
            column[..=j].fill(0.0);
            if j + 1 == n {
                return;
            }
            let (below, factor) = reflection(&mut column[j + 1..]);
            reduced.below.push(below);
            reduced.factors.push(factor);
            let v = &reduced.vectors.col_as_slice(j)[j + 1..n];
            if factor != 0.0 {
                let w = &mut w[j + 1..];
                w.fill(0.0);
                add_product(simd, &reduced.vectors, v, w);
                let products = dots(simd, changes, j + 1, v, done);
                (0..done).for_each(|q| factors[q] = -products[q ^ 1]);
                add(simd, w, changes, j + 1, &factors[..done]);
                let along = factor * v.iter().zip(&*w).map(|(v, w)| v * w).sum::<f64>();
                for (w, v) in w.iter_mut().zip(v) {
                    *w = factor * (*w - 0.5 * along * v);
                }
                changes.col_as_slice_mut(2 * i + 1)[j + 1..n].copy_from_slice(w);
            }
            changes.col_as_slice_mut(2 * i)[j + 1..n].copy_from_slice(v);
        }
    }
}

/// Makes x the v of 1 − τ v vᵀ, which takes x to a multiple of its first axis; this multiple, and τ, 0 where x is one already.
#[inline(always)]
fn reflection(x: &mut [f64]) -> (f64, f64) {
    let first = x[0];
    if largest(&x[1..]) == 0.0 {
        return (first, 0.0);
    }
    let unit = largest(x);
    x.iter_mut().for_each(|x| *x /= unit);
    let length = sum_of_squares(x).sqrt();
    let image = -length.copysign(first);
    let last = x[0] - image;
    let inverse = 1.0 / last;
    x.iter_mut().for_each(|x| *x *= inverse);
    x[0] = 1.0;
    (unit * image, -last / image)
}

/// Sums that the registers of processors have several of.
const LANES: usize = 8;

/// The largest size; NaN where there is one.
#[inline(always)]
fn largest(x: &[f64]) -> f64 {
    let larger = |most: f64, x: f64| if x > most || x.is_nan() { x } else { most };
    let mut lanes = [0.0; LANES];
    let chunks = x.chunks_exact(LANES);
    let rest = chunks.remainder().iter();
    for chunk in chunks {
        for (lane, x) in lanes.iter_mut().zip(chunk) {
            *lane = larger(*lane, x.abs());
        }
    }
    let rest = rest.fold(0.0, |most, x| larger(most, x.abs()));
    lanes.into_iter().fold(rest, larger)
}

#[inline(always)]
fn sum_of_squares(x: &[f64]) -> f64 {
    let mut lanes = [0.0; LANES];
    let chunks = x.chunks_exact(LANES);
    let rest: f64 = chunks.remainder().iter().map(|x| x * x).sum();
    for chunk in chunks {
        for (lane, x) in lanes.iter_mut().zip(chunk) {
            *lane += x * x;
        }
    }
    rest + lanes.iter().sum::<f64>()
}

/// y += Σ factors_q·columns_q, of columns from a row on.
#[inline(always)]
fn add<S: Simd>(simd: S, y: &mut [f64], columns: &Mat<f64>, row: usize, factors: &[f64]) {
    let end = row + y.len();
    for (at, factors) in factors.chunks_exact(TOGETHER).enumerate() {
        let column = |q: usize| &columns.col_as_slice(TOGETHER * at + q)[row..end];
        let columns = [column(0), column(1), column(2), column(3)];
        let [a, b, c, d] = columns.map(|column| S::as_simd_f64s(column));
        let (head, tail) = S::as_mut_simd_f64s(y);
        let single = [factors[0], factors[1], factors[2], factors[3]];
        let factors = single.map(|factor| simd.splat_f64s(factor));
        for ((((y, a), b), c), d) in head.iter_mut().zip(a.0).zip(b.0).zip(c.0).zip(d.0) {
            *y = sum(simd, *y, factors, [*a, *b, *c, *d]);
        }
        for (i, y) in tail.iter_mut().enumerate() {
            let entries = [a.1[i], b.1[i], c.1[i], d.1[i]];
            *y += single
                .iter()
                .zip(entries)
                .map(|(factor, entry)| factor * entry)
                .sum::<f64>();
        }
    }
}

/// y + Σ factors_q·entries_q, in two sums.
#[inline(always)]
fn sum<S: Simd>(
    simd: S,
    y: S::f64s,
    [p, q, r, s]: [S::f64s; TOGETHER],
    [a, b, c, d]: [S::f64s; TOGETHER],
) -> S::f64s {
    let one = simd.mul_add_f64s(p, a, y);
    let other = simd.mul_add_f64s(r, c, simd.mul_f64s(q, b));
    simd.add_f64s(one, simd.mul_add_f64s(s, d, other))
}

/// The products of so many columns, from a row on, with v.
#[inline(always)]
fn dots<S: Simd>(
    simd: S,
    columns: &Mat<f64>,
    row: usize,
    v: &[f64],
    count: usize,
) -> [f64; 2 * PANEL] {
    let mut products = [0.0; 2 * PANEL];
    let end = row + v.len();
    let (head, tail) = S::as_simd_f64s(v);
    for (at, products) in products[..count].chunks_exact_mut(TOGETHER).enumerate() {
        let column = |q: usize| S::as_simd_f64s(&columns.col_as_slice(TOGETHER * at + q)[row..end]);
        let [a, b, c, d] = [column(0), column(1), column(2), column(3)];
        let mut sums = [simd.splat_f64s(0.0); TOGETHER];
        for ((((v, a), b), c), d) in head.iter().zip(a.0).zip(b.0).zip(c.0).zip(d.0) {
            let [p, q, r, s] = sums;
            sums = [
                simd.mul_add_f64s(*a, *v, p),
                simd.mul_add_f64s(*b, *v, q),
                simd.mul_add_f64s(*c, *v, r),
                simd.mul_add_f64s(*d, *v, s),
            ];
        }
        for ((product, sum), rest) in products.iter_mut().zip(sums).zip([a.1, b.1, c.1, d.1]) {
            let rest: f64 = rest.iter().zip(tail).map(|(a, v)| a * v).sum();
            *product = simd.reduce_sum_f64s(sum) + rest;
        }
    }
    products
}

/// y += Av for the symmetric matrix of the last rows and columns, of which the lower half is read.
#[inline(always)]
fn add_product<S: Simd>(simd: S, matrix: &Mat<f64>, v: &[f64], y: &mut [f64]) {
    let count = v.len();
    let rows = matrix.ncols();
    let start = rows - count;
    let mut at = 0;
    while at < count {
        let end = count.min(at + TOGETHER);
        for j in at..end {
            let column = &matrix.col_as_slice(start + j)[start..rows];
            y[j] += column[j] * v[j];
            for i in j + 1..end {
                y[i] += column[i] * v[j];
                y[j] += column[i] * v[i];
            }
        }
        if end - at < TOGETHER {
            return;
        }
        let column =
            |q: usize| S::as_simd_f64s(&matrix.col_as_slice(start + at + q)[start + end..rows]);
        let [a, b, c, d] = [column(0), column(1), column(2), column(3)];
        let (above, y) = y.split_at_mut(end);
        let (y, last) = S::as_mut_simd_f64s(y);
        let (head, tail) = S::as_simd_f64s(&v[end..]);
        let single = [v[at], v[at + 1], v[at + 2], v[at + 3]];
        let factors = single.map(|factor| simd.splat_f64s(factor));
        let mut sums = [simd.splat_f64s(0.0); TOGETHER];
        let each = y.iter_mut().zip(head).zip(a.0).zip(b.0).zip(c.0).zip(d.0);
        for (((((y, v), a), b), c), d) in each {
            let [f, g, h, k] = sums;
            sums = [
                simd.mul_add_f64s(*a, *v, f),
                simd.mul_add_f64s(*b, *v, g),
                simd.mul_add_f64s(*c, *v, h),
                simd.mul_add_f64s(*d, *v, k),
            ];
            *y = sum(simd, *y, factors, [*a, *b, *c, *d]);
        }
        let rests = [a.1, b.1, c.1, d.1];
        for (i, (y, v)) in last.iter_mut().zip(tail).enumerate() {
            for (j, rest) in rests.iter().enumerate() {
                *y += single[j] * rest[i];
                above[at + j] += rest[i] * v;
            }
        }
        for (y, sum) in above[at..].iter_mut().zip(sums) {
            *y += simd.reduce_sum_f64s(sum);
        }
        at = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(i: usize, j: usize) -> f64 {
        let (i, j) = (i.max(j), i.min(j));
        ((i * i * 31 + j * 17 + i * j * 13) % 1009) as f64 / 1009.0 - 0.5
    }

    /// A = Q T Qᵀ and QᵀQ = 1 on both sides of the widths of panels, registers and stripes, at any size of the entries.
    #[test]
    fn the_form_is_that_of_the_matrix() {
        for n in [
            1, 2, 3, 4, 5, 8, 9, 15, 16, 17, 18, 31, 33, 47, 64, 65, 81, 130,
        ] {
            for factor in [1.0, 1e-290, 1e290] {
                let lower = Mat::from_fn(n, n, |i, j| {
                    if i < j {
                        f64::NAN
                    } else {
                        factor * entry(i, j)
                    }
                });
                let reduced = Reduced::of(&lower);
                let mut q = Mat::<f64>::identity(n, n);
                reduced.apply(q.as_mut());
                let t = Mat::from_fn(n, n, |i, j| match i.abs_diff(j) {
                    0 => reduced.diagonal[i] / factor,
                    1 => reduced.below[i.min(j)] / factor,
                    _ => 0.0,
                });
                let unit = f64::EPSILON * (4.0 + n as f64);
                let matrix = Mat::from_fn(n, n, entry);
                let off = (&q * t * q.transpose() - &matrix).norm_l2();
                assert!(off <= unit * matrix.norm_l2(), "{n}: {off:e}");
                assert!(
                    (q.transpose() * &q - Mat::<f64>::identity(n, n)).norm_l2() <= 4.0 * unit,
                    "{n}"
                );
            }
        }
    }

    /// Parts that are tridiagonal already take no reflection, and keep their entries.
    #[test]
    fn what_has_the_form_stays() {
        for n in [2, 7, 40] {
            let banded = |i: usize, j: usize| if i.abs_diff(j) < 2 { entry(i, j) } else { 0.0 };
            let reduced = Reduced::of(&Mat::from_fn(n, n, banded));
            assert_eq!(
                reduced.diagonal,
                (0..n).map(|i| entry(i, i)).collect::<Vec<_>>()
            );
            assert_eq!(
                reduced.below,
                (1..n).map(|i| entry(i, i - 1)).collect::<Vec<_>>()
            );
        }
    }

    #[test]
    fn what_is_not_finite_shows() {
        for n in [1, 3, 40] {
            for at in [(0, 0), (n - 1, 0), (n - 1, n - 1), (n / 2, n / 3)] {
                for wrong in [f64::NAN, f64::INFINITY] {
                    let mut matrix = Mat::from_fn(n, n, entry);
                    matrix[at] = wrong;
                    let reduced = Reduced::of(&matrix);
                    let entries = reduced.diagonal.iter().chain(&reduced.below);
                    assert!(
                        entries.clone().any(|entry| !entry.is_finite()),
                        "{n} {at:?}"
                    );
                }
            }
        }
    }
}
