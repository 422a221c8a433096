//! Dense matrices in contiguous buffers.

use std::cell::RefCell;

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

use super::algebra::{Algebra, Explicit};
use super::aligned::Aligned;
use super::contiguous::with_columns;
use pulp::{Simd, WithSimd};

use super::vector::run;

/// n × n matrices, column by column.
pub(super) struct Dense {
    n: usize,
    pool: Vec<Aligned>,
    products: u32,
}

thread_local! {
    /// Buffers that the last exponential of this thread left behind. The pages of fresh memory have to be
    /// cleared by the operating system one by one, which for eight buffers takes as long as a product or two.
    static LEFT_BEHIND: RefCell<Vec<Aligned>> = const { RefCell::new(Vec::new()) };
}

/// So many doubles are kept at most: 64 MB.
const KEPT: usize = 8 << 20;

impl Drop for Dense {
    fn drop(&mut self) {
        let mut pool = std::mem::take(&mut self.pool);
        pool.truncate(KEPT / (self.n * self.n).max(1));
        // While a thread ends there may be nothing to keep them.
        let _ = LEFT_BEHIND.try_with(|left| left.replace(pool));
    }
}

impl Dense {
    pub(super) fn new(n: usize) -> Dense {
        let left = LEFT_BEHIND.try_with(RefCell::take).unwrap_or_default();
        let fits = left.first().is_some_and(|buffer| buffer.len() == n * n);
        Dense {
            n,
            pool: if fits { left } else { Vec::with_capacity(8) },
            products: 0,
        }
    }

    /// A copy of `a` times 2^-`shift`, for 0 ≤ shift ≤ 1100.
    pub(super) fn load(&mut self, a: MatRef<'_, f64>, shift: i32) -> Aligned {
        let (n, mut out) = (self.n, self.take());
        if n == 0 {
            return out;
        }
        // Two factors: one alone may be below the smallest double.
        let (half, rest) = (power(-(shift / 2)), power(-(shift - shift / 2)));
        with_columns(a, |a| {
            for (column, values) in out.chunks_exact_mut(n).zip(a.col_iter()) {
                for (entry, value) in column.iter_mut().zip(values.as_slice()) {
                    *entry = value * half * rest;
                }
            }
        });
        out
    }

    /// How many products were formed so far.
    pub(super) fn products(&self) -> u32 {
        self.products
    }

    /// A matrix of zeros.
    pub(super) fn zeros(&mut self) -> Aligned {
        let mut zeros = self.take();
        zeros.fill(0.0);
        zeros
    }

    /// A buffer with anything in it.
    pub(super) fn take(&mut self) -> Aligned {
        let size = self.n * self.n;
        self.pool.pop().unwrap_or_else(|| Aligned::zeros(size))
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
    type Element = Aligned;

    fn combine<const SUMS: usize>(&mut self, terms: [&[(f64, &Aligned)]; SUMS]) -> [Aligned; SUMS] {
        let mut sums = std::array::from_fn(|_| self.take());
        run(Sums {
            sums: &mut sums,
            terms,
        });
        sums
    }

    fn multiply_add(&mut self, mut sum: Aligned, x: &Aligned, y: &Aligned) -> Aligned {
        self.product(Accum::Add, &mut sum, x, y);
        sum
    }

    fn multiply(&mut self, x: &Aligned, y: &Aligned) -> Aligned {
        let mut out = self.take();
        self.product(Accum::Replace, &mut out, x, y);
        out
    }

    fn recycle(&mut self, element: Aligned) {
        self.pool.push(element);
    }
}

impl Explicit for Dense {
    fn order(&self) -> usize {
        self.n
    }

    fn value(element: &Aligned) -> &[f64] {
        element
    }

    fn rescale(element: &mut Aligned, factor: f64) {
        element.iter_mut().for_each(|entry| *entry *= factor);
    }

    fn value_mut(element: &mut Aligned) -> &mut [f64] {
        element
    }

    fn twice(&mut self, x: &Aligned, s: &[f64]) -> Aligned {
        let mut out = self.take();
        run(Twice {
            n: self.n,
            out: &mut out,
            x,
            s,
        });
        out
    }
}

/// out = SX + XS.
struct Twice<'a> {
    n: usize,
    out: &'a mut [f64],
    x: &'a [f64],
    s: &'a [f64],
}

impl WithSimd for Twice<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let columns = self.x.chunks_exact(self.n).zip(self.s);
        for (out, (x, right)) in self.out.chunks_exact_mut(self.n).zip(columns) {
            for ((out, x), left) in out.iter_mut().zip(x).zip(self.s) {
                *out = (left + right) * x;
            }
        }
    }
}

/// Each sum = Σ factor · x, entry by entry.
struct Sums<'a, const SUMS: usize> {
    sums: &'a mut [Aligned; SUMS],
    terms: [&'a [(f64, &'a Aligned)]; SUMS],
}

impl<const SUMS: usize> WithSimd for Sums<'_, SUMS> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        /// So many entries of all terms stay in the nearest cache while all sums are formed.
        const BLOCK: usize = 256;
        let size = self.sums.iter().map(|sum| sum.len()).min().unwrap_or(0);
        for start in (0..size).step_by(BLOCK) {
            let range = start..size.min(start + BLOCK);
            for (sum, terms) in self.sums.iter_mut().zip(self.terms) {
                linear(&mut sum[range.clone()], range.clone(), terms);
            }
        }
    }
}

/// out = Σ factor · x, with the entries of x in `range`; memory is what it waits for.
#[inline(always)]
fn linear(out: &mut [f64], range: std::ops::Range<usize>, terms: &[(f64, &Aligned)]) {
    match terms {
        [] => out.fill(0.0),
        [(a, x)] => {
            for (out, x) in out.iter_mut().zip(&x[range]) {
                *out = a * x;
            }
        }
        [(a, x), (b, y)] => {
            let (x, y) = (&x[range.clone()], &y[range]);
            for ((out, x), y) in out.iter_mut().zip(x).zip(y) {
                *out = a * x + b * y;
            }
        }
        [(a, x), (b, y), (c, z)] => {
            let (x, y, z) = (&x[range.clone()], &y[range.clone()], &z[range]);
            for (((out, x), y), z) in out.iter_mut().zip(x).zip(y).zip(z) {
                *out = a * x + b * y + c * z;
            }
        }
        [(a, x), (b, y), (c, z), (d, w), rest @ ..] => {
            let (x, y) = (&x[range.clone()], &y[range.clone()]);
            let (z, w) = (&z[range.clone()], &w[range.clone()]);
            for ((((out, x), y), z), w) in out.iter_mut().zip(x).zip(y).zip(z).zip(w) {
                *out = a * x + b * y + (c * z + d * w);
            }
            for (a, x) in rest {
                for (out, x) in out.iter_mut().zip(&x[range.clone()]) {
                    *out += a * x;
                }
            }
        }
    }
}
