//! Products of matrices of magnitudes, rounded up: the radii of a product of balls.

use crate::Magnitude;

/// Two pairs of factors, row by row: what is wanted is the sum of their two products.
pub(crate) struct Radii<'a> {
    left: [&'a [Magnitude]; 2],
    right: [&'a [Magnitude]; 2],
    inner: usize,
    columns: usize,
    /// The same as doubles where each of the four needs one exponent only.
    plain: Option<Plain>,
}

struct Plain {
    left: [Vec<f64>; 2],
    right: [Vec<f64>; 2],
    /// Of the two products.
    exponents: [i64; 2],
}

impl<'a> Radii<'a> {
    /// With right factors of so many rows and columns.
    pub(crate) fn of(
        left: [&'a [Magnitude]; 2],
        right: [&'a [Magnitude]; 2],
        [inner, columns]: [usize; 2],
    ) -> Radii<'a> {
        let plain = || {
            let [first, second] = left.map(Magnitude::aligned);
            let [third, fourth] = right.map(Magnitude::aligned);
            let ((a, of_a), (b, of_b), (c, of_c), (d, of_d)) = (first?, second?, third?, fourth?);
            let exponents = [of_a.checked_add(of_c)?, of_b.checked_add(of_d)?];
            Some(Plain {
                left: [a, b],
                right: [c, d],
                exponents,
            })
        };
        Radii {
            plain: plain(),
            left,
            right,
            inner,
            columns,
        }
    }

    /// A row of the sum; 0 where every term has a factor 0.
    pub(crate) fn row(&self, i: usize, sums: &mut [Magnitude]) {
        let terms = || (0..self.inner).map(move |k| (i * self.inner + k, k * self.columns));
        let Some(Plain {
            left,
            right,
            exponents,
        }) = &self.plain
        else {
            sums.fill(Magnitude::ZERO);
            let filled = |weight: &Magnitude| !weight.is_zero();
            for (factors, weights) in self.left.into_iter().zip(self.right) {
                for (at, row) in terms().filter(|(at, _)| filled(&factors[*at])) {
                    let pairs = sums.iter_mut().zip(&weights[row..]);
                    for (sum, weight) in pairs.filter(|(_, weight)| filled(weight)) {
                        *sum = *sum + factors[at] * *weight;
                    }
                }
            }
            return;
        };
        // No double leaves its range: mantissas lie in [2^-256, 2^256). Each sum of k products is (1 + u)^(k + 1) too small at most.
        let more = 1.0 + (self.inner as f64 + 4.0) * f64::EPSILON;
        let of = |kind: usize| {
            let mut sums = vec![0.0; self.columns];
            for (at, row) in terms().filter(|(at, _)| left[kind][*at] != 0.0) {
                let factor = left[kind][at];
                let pairs = sums.iter_mut().zip(&right[kind][row..]);
                pairs.for_each(|(sum, weight)| *sum += factor * weight);
            }
            sums.into_iter()
                .map(move |sum| Magnitude::new(sum * more, exponents[kind]))
        };
        let pairs = of(0).zip(of(1));
        sums.iter_mut()
            .zip(pairs)
            .for_each(|(sum, (a, b))| *sum = a + b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rational::{Exact, dyadic};

    /// In doubles and number by number: no less than the exact sum of products, and hardly more.
    #[test]
    fn both_ways_lead_to_upper_bounds() {
        let number = |at: usize, power: i64| {
            let mantissa = (at * at * 31 + at * 7919) % 10_007;
            Magnitude::from(mantissa as f64 / 97.0) * Magnitude::power_of_two(power)
        };
        let (inner, columns) = (9, 4);
        let matrix = |size: usize, seed: usize, power: i64| -> Vec<Magnitude> {
            (0..size).map(|at| number(at + seed, power)).collect()
        };
        let left = [matrix(2 * inner, 1, 0), matrix(2 * inner, 2, -900)];
        let right = [
            matrix(inner * columns, 3, -600),
            matrix(inner * columns, 4, 300),
        ];
        let of = |matrices: &[Vec<Magnitude>; 2], k: usize, at: usize| matrices[k][at].exact();
        let size = [inner, columns];
        let mut radii = Radii::of(
            left.each_ref().map(Vec::as_slice),
            right.each_ref().map(Vec::as_slice),
            size,
        );
        assert!(radii.plain.is_some(), "each has one exponent");
        for _ in 0..2 {
            for i in 0..2 {
                let mut sums = vec![Magnitude::INFINITY; columns];
                radii.row(i, &mut sums);
                for (j, sum) in sums.into_iter().enumerate() {
                    let term = |k: usize, at: usize| {
                        of(&left, k, i * inner + at) * of(&right, k, at * columns + j)
                    };
                    let terms = (0..inner).flat_map(|at| [term(0, at), term(1, at)]);
                    let truth = terms.fold(dyadic(0.0, 0), |sum, term| sum + term);
                    let above = dyadic(1.0, 0) + dyadic(1.0, -45);
                    assert!(truth <= sum.exact() && sum.exact() <= truth * above);
                }
            }
            radii.plain = None;
        }
    }
}
