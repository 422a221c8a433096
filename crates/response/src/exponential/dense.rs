//! Dense matrices in contiguous buffers.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

use super::algebra::{Algebra, Explicit};

/// n × n matrices, column by column.
pub(super) struct Dense {
    n: usize,
    pool: Vec<Vec<f64>>,
    products: u32,
}

impl Dense {
    pub(super) fn new(n: usize) -> Dense {
        Dense {
            n,
            pool: Vec::with_capacity(8),
            products: 0,
        }
    }

    /// A copy of `a` times 2^-`shift`, for 0 ≤ shift ≤ 1100.
    pub(super) fn load(&mut self, a: MatRef<'_, f64>, shift: i32) -> Vec<f64> {
        let (n, mut out) = (self.n, self.take());
        if n == 0 {
            return out;
        }
        // Two factors: one alone may be below the smallest double.
        let (half, rest) = (power(-(shift / 2)), power(-(shift - shift / 2)));
        for (j, column) in out.chunks_exact_mut(n).enumerate() {
            for (entry, value) in column.iter_mut().zip(a.col(j).iter()) {
                *entry = value * half * rest;
            }
        }
        out
    }

    /// How many products were formed so far.
    pub(super) fn products(&self) -> u32 {
        self.products
    }

    /// A buffer with anything in it.
    pub(super) fn take(&mut self) -> Vec<f64> {
        let size = self.n * self.n;
        self.pool.pop().unwrap_or_else(|| vec![0.0; size])
    }

    fn product(&mut self, beta: Accum, out: &mut [f64], x: &[f64], y: &[f64]) {
        self.products += 1;
        match self.n {
            0 => {}
            1 => small::<1>(beta, out, x, y),
            2 => small::<2>(beta, out, x, y),
            3 => small::<3>(beta, out, x, y),
            4 => small::<4>(beta, out, x, y),
            n => matmul(
                MatMut::from_column_major_slice_mut(out, n, n),
                beta,
                MatRef::from_column_major_slice(x, n, n),
                MatRef::from_column_major_slice(y, n, n),
                1.0,
                Par::Seq,
            ),
        }
    }
}

/// 2^exponent for |exponent| ≤ 1022.
fn power(exponent: i32) -> f64 {
    2f64.powi(exponent)
}

/// Up to four rows, plain loops beat the call of the blocked product.
fn small<const N: usize>(beta: Accum, out: &mut [f64], x: &[f64], y: &[f64]) {
    let (out, x, y) = (
        out.as_chunks_mut::<N>().0,
        x.as_chunks::<N>().0,
        y.as_chunks::<N>().0,
    );
    for (out, y) in out.iter_mut().zip(y) {
        let mut sum = match beta {
            Accum::Add => *out,
            Accum::Replace => [0.0; N],
        };
        for (column, factor) in x.iter().zip(y) {
            for (sum, entry) in sum.iter_mut().zip(column) {
                *sum += entry * factor;
            }
        }
        *out = sum;
    }
}

impl Algebra for Dense {
    type Element = Vec<f64>;

    fn combine(&mut self, terms: &[(f64, &Vec<f64>)]) -> Vec<f64> {
        let mut out = self.take();
        linear(&mut out, terms);
        out
    }

    fn multiply_add(&mut self, mut sum: Vec<f64>, x: &Vec<f64>, y: &Vec<f64>) -> Vec<f64> {
        self.product(Accum::Add, &mut sum, x, y);
        sum
    }

    fn multiply(&mut self, x: &Vec<f64>, y: &Vec<f64>) -> Vec<f64> {
        let mut out = self.take();
        self.product(Accum::Replace, &mut out, x, y);
        out
    }

    fn recycle(&mut self, element: Vec<f64>) {
        self.pool.push(element);
    }
}

impl Explicit for Dense {
    fn order(&self) -> usize {
        self.n
    }

    fn value(element: &Vec<f64>) -> &[f64] {
        element
    }

    fn rescale(element: &mut Vec<f64>, factor: f64) {
        element.iter_mut().for_each(|entry| *entry *= factor);
    }

    fn value_mut(element: &mut Vec<f64>) -> &mut [f64] {
        element
    }

    fn twice(&mut self, x: &Vec<f64>, s: &[f64]) -> Vec<f64> {
        let mut out = self.take();
        let columns = x.chunks_exact(self.n).zip(s);
        for (out, (x, right)) in out.chunks_exact_mut(self.n).zip(columns) {
            for ((out, x), left) in out.iter_mut().zip(x).zip(s) {
                *out = (left + right) * x;
            }
        }
        out
    }
}

/// out = Σ factor · x, entry by entry, in one pass for up to five terms.
pub(super) fn linear(out: &mut [f64], terms: &[(f64, &Vec<f64>)]) {
    match terms {
        [] => out.fill(0.0),
        [(a, x)] => {
            for (out, x) in out.iter_mut().zip(*x) {
                *out = a * x;
            }
        }
        [(a, x), (b, y)] => {
            for ((out, x), y) in out.iter_mut().zip(*x).zip(*y) {
                *out = a * x + b * y;
            }
        }
        [(a, x), (b, y), (c, z)] => {
            for (((out, x), y), z) in out.iter_mut().zip(*x).zip(*y).zip(*z) {
                *out = a * x + b * y + c * z;
            }
        }
        [(a, x), (b, y), (c, z), (d, w)] => {
            for ((((out, x), y), z), w) in out.iter_mut().zip(*x).zip(*y).zip(*z).zip(*w) {
                *out = a * x + b * y + (c * z + d * w);
            }
        }
        [head @ .., (a, x)] => {
            linear(out, head);
            for (out, x) in out.iter_mut().zip(*x) {
                *out += a * x;
            }
        }
    }
}
