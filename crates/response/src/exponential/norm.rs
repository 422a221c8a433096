//! 1-norms of matrices that are stored column by column.

use faer::MatRef;

use pulp::{Simd, WithSimd};

use super::vector::{multiply_add, run};

/// e^T|X|: the column sums.
pub(super) fn column_sums(n: usize, x: &[f64]) -> Vec<f64> {
    let [sums] = weighted_sums(n, x, [None]);
    sums
}

/// e^T|X|, or w^T|X| for weights w ≥ 0, for each of these weights in one pass.
pub(super) fn weighted_sums<const W: usize>(
    n: usize,
    x: &[f64],
    weights: [Option<&[f64]>; W],
) -> [Vec<f64>; W] {
    run(WeightedSums { n, x, weights })
}

/// The largest entry; NaN and ∞ if there is one, 0 for none.
pub(super) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest: f64, value| {
        // Not f64::max, which drops NaN.
        if *value > largest || value.is_nan() {
            *value
        } else {
            largest
        }
    })
}

/// The largest column sum.
pub(super) fn norm_one(n: usize, x: &[f64]) -> f64 {
    largest(&column_sums(n, x))
}

struct WeightedSums<'a, const W: usize> {
    n: usize,
    x: &'a [f64],
    weights: [Option<&'a [f64]>; W],
}

impl<const W: usize> WithSimd for WeightedSums<'_, W> {
    type Output = [Vec<f64>; W];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [Vec<f64>; W] {
        let mut sums = std::array::from_fn(|_| Vec::with_capacity(self.n));
        for column in self.x.chunks_exact(self.n.max(1)) {
            for (sums, weights) in sums.iter_mut().zip(self.weights) {
                sums.push(match weights {
                    None => sum_of_sizes(column),
                    Some(weights) => weighted_sum::<S>(column, weights),
                });
            }
        }
        sums
    }
}

/// Independent partial sums, so that the additions need not wait for one another.
const LANES: usize = 16;

#[inline(always)]
fn sum_of_sizes(column: &[f64]) -> f64 {
    let (blocks, rest) = column.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for block in blocks {
        for (sum, entry) in sums.iter_mut().zip(block) {
            *sum += entry.abs();
        }
    }
    let rest: f64 = rest.iter().map(|entry| entry.abs()).sum();
    sums.iter().sum::<f64>() + rest
}

#[inline(always)]
fn weighted_sum<S: Simd>(column: &[f64], weights: &[f64]) -> f64 {
    let (blocks, rest) = column.as_chunks::<LANES>();
    let (factors, last) = weights.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for (block, factor) in blocks.iter().zip(factors) {
        for ((sum, entry), factor) in sums.iter_mut().zip(block).zip(factor) {
            *sum = multiply_add::<S>(entry.abs(), *factor, *sum);
        }
    }
    let rest: f64 = rest.iter().zip(last).map(|(x, w)| x.abs() * w).sum();
    sums.iter().sum::<f64>() + rest
}

/// The largest column sum; NaN if there is one.
pub(super) fn norm(a: MatRef<'_, f64>) -> f64 {
    let sums: Vec<f64> = a.col_iter().map(|column| column.norm_l1()).collect();
    largest(&sums)
}
