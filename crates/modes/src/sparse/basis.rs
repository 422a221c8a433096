//! Products with tall matrices given by their columns, a stretch of rows at a time, so that what is
//! common to all columns stays near.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

use super::entry::Entry;

/// Rows taken together.
pub(crate) const STRETCH: usize = 1024;

/// xᵀy in eight running sums.
pub(crate) fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.chunks(STRETCH)
        .zip(y.chunks(STRETCH))
        .map(|(x, y)| short_dot(x, y))
        .sum()
}

/// The same without a stop, of any numbers.
#[inline]
pub(crate) fn short_dot<T: Entry>(x: &[T], y: &[T]) -> T {
    const LANES: usize = 8;
    let zero = T::from(0.0);
    let mut sums = [zero; LANES];
    let (x, y) = (x.chunks_exact(LANES), y.chunks_exact(LANES));
    let rest = x.remainder().iter().zip(y.remainder());
    let rest = rest.fold(zero, |sum, (x, y)| sum + *x * *y);
    for (x, y) in x.zip(y) {
        for lane in 0..LANES {
            sums[lane] += x[lane] * y[lane];
        }
    }
    sums.iter().fold(zero, |sum, part| sum + *part) + rest
}

/// The products of every column with y.
pub(crate) fn products(columns: &[Vec<f64>], y: &[f64]) -> Vec<f64> {
    let mut products = vec![0.0; columns.len()];
    for (stretch, y) in y.chunks(STRETCH).enumerate() {
        let start = stretch * STRETCH;
        for (product, column) in products.iter_mut().zip(columns) {
            *product += short_dot(&column[start..start + y.len()], y);
        }
    }
    products
}

/// y −= Σ factor · column.
pub(crate) fn subtract(columns: &[Vec<f64>], factors: &[f64], y: &mut [f64]) {
    for (stretch, y) in y.chunks_mut(STRETCH).enumerate() {
        let start = stretch * STRETCH;
        for (factor, column) in factors.iter().zip(columns) {
            let column = &column[start..start + y.len()];
            y.iter_mut().zip(column).for_each(|(y, x)| *y -= factor * x);
        }
    }
}

/// The first columns become the combinations that `factors` has, a column of them for each; the
/// others are left as they are.
pub(crate) fn combine(columns: &mut [Vec<f64>], factors: MatRef<'_, f64>) {
    let rows = columns.first().map_or(0, Vec::len);
    let (from, to) = (factors.nrows(), factors.ncols());
    let mut given = Mat::<f64>::zeros(STRETCH, from);
    let mut combined = Mat::<f64>::zeros(STRETCH, to);
    for start in (0..rows).step_by(STRETCH) {
        let count = STRETCH.min(rows - start);
        for (column, from) in columns.iter().zip(given.col_iter_mut()) {
            let part = &column[start..start + count];
            from.iter_mut().zip(part).for_each(|(to, x)| *to = *x);
        }
        matmul(
            combined.as_mut(),
            Accum::Replace,
            given.as_ref(),
            factors,
            1.0,
            Par::Seq,
        );
        for (column, to) in columns.iter_mut().zip(combined.col_iter()) {
            let part = &mut column[start..start + count];
            part.iter_mut()
                .zip(to.iter())
                .for_each(|(x, from)| *x = *from);
        }
    }
}
