//! Householder's reduction to Hessenberg form (Golub & Van Loan, *Matrix Computations*, §7.4).

use num_complex::Complex;

/// Rows that are updated together.
const ROWS: usize = 8;

/// Reduces `a` (n × n, column by column) to upper Hessenberg form by reflections I − s v vᵀ, each with s vᵀv = 2;
/// `keep` is given the first row that v reaches, s and v, from the first reflection to the last.
#[inline(always)]
pub(crate) fn hessenberg(a: &mut [f64], n: usize, mut keep: impl FnMut(usize, f64, &[f64])) {
    for k in 0..n.saturating_sub(2) {
        let below = k + 2 + n * k..n + n * k;
        let rest = a[below].iter().fold(0.0, |sum: f64, x| sum + x * x);
        if rest == 0.0 {
            continue;
        }
        let head = a[k + 1 + n * k];
        let size = (head * head + rest).sqrt().copysign(head);
        let first = head + size;
        // v is kept where it makes zeros; its first entry is `first`.
        let scale = 1.0 / (size * first);
        a[k + 1 + n * k] = first;
        let (done, right) = a.split_at_mut(n * (k + 1));
        let v = &mut done[k + 1 + n * k..];
        keep(k + 1, scale, v);
        for column in right.chunks_exact_mut(n) {
            let column = &mut column[k + 1..];
            let product = scale * dot(column, v);
            for (x, v) in column.iter_mut().zip(&*v) {
                *x -= product * v;
            }
        }
        let mut row = 0;
        while row + ROWS <= n {
            let mut products = [0.0; ROWS];
            for (column, v) in right.chunks_exact(n).zip(&*v) {
                for (product, x) in products.iter_mut().zip(&column[row..row + ROWS]) {
                    *product += x * v;
                }
            }
            for (column, v) in right.chunks_exact_mut(n).zip(&*v) {
                let factor = scale * v;
                for (product, x) in products.iter().zip(&mut column[row..row + ROWS]) {
                    *x -= product * factor;
                }
            }
            row += ROWS;
        }
        for i in row..n {
            let columns = right.chunks_exact(n).zip(&*v);
            let product: f64 = columns.map(|(column, v)| column[i] * v).sum();
            for (column, v) in right.chunks_exact_mut(n).zip(&*v) {
                column[i] -= scale * product * v;
            }
        }
        v.fill(0.0);
        v[0] = -size;
    }
}

/// The reflections whose product Q makes A = Q H Qᵀ.
pub(crate) struct Reflections {
    /// The first row that each reaches, and its s.
    starts: Vec<(usize, f64)>,
    vectors: Vec<f64>,
    n: usize,
}

impl Reflections {
    pub(crate) fn new(n: usize) -> Reflections {
        Reflections {
            starts: Vec::with_capacity(n),
            vectors: Vec::with_capacity(n * n / 2),
            n,
        }
    }

    pub(crate) fn keep(&mut self, start: usize, scale: f64, v: &[f64]) {
        self.starts.push((start, scale));
        self.vectors.extend_from_slice(v);
    }

    /// Qx in place of x.
    pub(crate) fn apply(&self, x: &mut [Complex<f64>]) {
        let mut end = self.vectors.len();
        for (start, scale) in self.starts.iter().rev() {
            let v = &self.vectors[end - (self.n - start)..end];
            end -= v.len();
            let x = &mut x[*start..];
            let mut product = Complex::ZERO;
            for (x, v) in x.iter().zip(v) {
                product += x * v;
            }
            product *= scale;
            for (x, v) in x.iter_mut().zip(v) {
                *x -= product * v;
            }
        }
    }
}

/// In four sums, which one instruction serves.
#[inline(always)]
fn dot(x: &[f64], y: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (x, y) = (x.chunks_exact(4), y.chunks_exact(4));
    let rest: f64 = x
        .remainder()
        .iter()
        .zip(y.remainder())
        .map(|(x, y)| x * y)
        .sum();
    for (x, y) in x.zip(y) {
        for ((sum, x), y) in sums.iter_mut().zip(x).zip(y) {
            *sum += x * y;
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest
}
