//! Several double-double sums at a time.

use crate::DoubleDouble;
use crate::double_double::{quick_two_sum, split, two_sum};

/// L numbers side by side, highs apart from lows, so that one instruction serves several of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lanes<const L: usize> {
    high: [f64; L],
    low: [f64; L],
}

impl<const L: usize> Lanes<L> {
    /// All 0.
    pub const ZERO: Lanes<L> = Lanes {
        high: [0.0; L],
        low: [0.0; L],
    };

    /// Sets one of the numbers.
    ///
    /// # Panics
    /// If `lane` is not below L.
    pub fn set(&mut self, lane: usize, value: DoubleDouble) {
        (self.high[lane], self.low[lane]) = (value.high(), value.low());
    }

    /// Σ_k row_k · columns_k in every lane, each the same as by the operators of [`DoubleDouble`], bit for
    /// bit, as long as all is finite.
    pub fn products(row: &[DoubleDouble], columns: &[Lanes<L>]) -> [DoubleDouble; L] {
        let mut sum = Lanes::<L>::ZERO;
        for (factor, entries) in row.iter().zip(columns) {
            sum.add_product(*factor, entries);
        }
        let sums: [DoubleDouble; L] =
            std::array::from_fn(|lane| DoubleDouble::new(sum.high[lane], sum.low[lane]));
        if sums.iter().all(|sum| sum.high().is_finite()) {
            return sums;
        }
        // The splitting overflows above 2^996, where the operators go another way.
        std::array::from_fn(|lane| {
            let terms = row.iter().zip(columns);
            terms.fold(DoubleDouble::ZERO, |sum, (factor, entries)| {
                sum + *factor * DoubleDouble::new(entries.high[lane], entries.low[lane])
            })
        })
    }

    #[inline]
    fn add_product(&mut self, factor: DoubleDouble, entries: &Lanes<L>) {
        let (high, low) = (factor.high(), factor.low());
        let (first, second) = split(high);
        for lane in 0..L {
            let (x, rest) = (entries.high[lane], entries.low[lane]);
            let product = high * x;
            let (x1, x2) = split(x);
            let error = ((first * x1 - product) + first * x2 + second * x1) + second * x2;
            let cross = high * rest + low * x;
            let (b, b_low) = quick_two_sum(product, error + cross);
            let (a, a_low) = (self.high[lane], self.low[lane]);
            let (sum, error) = two_sum(a, b);
            let (low, rest) = two_sum(a_low, b_low);
            let (sum, error) = quick_two_sum(sum, error + low);
            (self.high[lane], self.low[lane]) = quick_two_sum(sum, error + rest);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn numbers(exponents: std::ops::Range<i32>) -> impl Strategy<Value = DoubleDouble> {
        (-1.0..1.0, -1.0..1.0, exponents).prop_map(|(high, low, exponent): (f64, f64, i32)| {
            let scale = 2f64.powi(exponent);
            DoubleDouble::new(high * scale, low * scale * 2f64.powi(-60))
        })
    }

    fn agree(row: &[DoubleDouble], columns: &[Vec<DoubleDouble>; 3]) {
        let mut lanes = vec![Lanes::<3>::ZERO; row.len()];
        for (k, lanes) in lanes.iter_mut().enumerate() {
            for (lane, column) in columns.iter().enumerate() {
                lanes.set(lane, column[k]);
            }
        }
        let found = Lanes::products(row, &lanes);
        for (found, column) in found.iter().zip(columns) {
            let terms = row.iter().zip(column);
            let sum = terms.fold(DoubleDouble::ZERO, |sum, (a, b)| sum + *a * *b);
            assert_eq!(*found, sum);
        }
    }

    proptest! {
        #[test]
        fn lanes_are_the_operators(
            row in prop::collection::vec(numbers(-200..200), 7),
            a in prop::collection::vec(numbers(-200..200), 7),
            b in prop::collection::vec(numbers(-200..200), 7),
            c in prop::collection::vec(numbers(-200..200), 7),
        ) {
            agree(&row, &[a, b, c]);
        }

        #[test]
        fn large_numbers_are_split_elsewhere(
            row in prop::collection::vec(numbers(995..1010), 4),
            a in prop::collection::vec(numbers(-60..-20), 4),
            b in prop::collection::vec(numbers(-60..-20), 4),
            c in prop::collection::vec(numbers(-60..-20), 4),
        ) {
            agree(&row, &[a, b, c]);
        }
    }
}
