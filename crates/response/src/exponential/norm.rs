//! 1-norms of matrices that are stored column by column.

/// e^T|X|, or w^T|X| for weights w ≥ 0: the weighted column sums.
pub(super) fn column_sums(n: usize, x: &[f64], weights: Option<&[f64]>) -> Vec<f64> {
    let columns = x.chunks_exact(n.max(1));
    match weights {
        None => columns.map(sum_of_sizes).collect(),
        Some(weights) => columns
            .map(|column| weighted_sum(column, weights))
            .collect(),
    }
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
    largest(&column_sums(n, x, None))
}

/// Independent partial sums, so that the additions need not wait for one another.
const LANES: usize = 8;

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

fn weighted_sum(column: &[f64], weights: &[f64]) -> f64 {
    let (blocks, rest) = column.as_chunks::<LANES>();
    let (factors, last) = weights.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for (block, factor) in blocks.iter().zip(factors) {
        for ((sum, entry), factor) in sums.iter_mut().zip(block).zip(factor) {
            *sum += entry.abs() * factor;
        }
    }
    let rest: f64 = rest.iter().zip(last).map(|(x, w)| x.abs() * w).sum();
    sums.iter().sum::<f64>() + rest
}
