//! Rows of double-doubles added to others, in the processor's vector registers where it has them.

use pulp::{Arch, Simd, WithSimd};

use crate::DoubleDouble;

/// sumᵢ + factor·entriesᵢ in place of sumᵢ: to the last bit what the operators give, where no error term underflows.
pub(crate) fn add_multiple(
    sum: &mut [DoubleDouble],
    factor: DoubleDouble,
    entries: &[DoubleDouble],
) {
    Arch::new().dispatch(AddMultiple {
        sum,
        factor,
        entries,
    });
}

struct AddMultiple<'a> {
    sum: &'a mut [DoubleDouble],
    factor: DoubleDouble,
    entries: &'a [DoubleDouble],
}

impl WithSimd for AddMultiple<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let pairs = self.sum.iter_mut().zip(self.entries);
        if S::F64_LANES > 1 {
            // Processors with vectors of doubles fuse multiplications and additions.
            let fused = |a: f64, b: f64| (a * b, a.mul_add(b, -(a * b)));
            for (sum, entry) in pairs {
                *sum += self.factor.times(*entry, fused);
            }
        } else {
            for (sum, entry) in pairs {
                *sum += self.factor * *entry;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn number() -> impl Strategy<Value = DoubleDouble> {
        (-1.0..1.0, -1.0..1.0, -300..300).prop_map(|(high, low, exponent): (f64, f64, i32)| {
            let scale = 2f64.powi(exponent);
            DoubleDouble::new(high * scale, low * scale * 2f64.powi(-54))
        })
    }

    proptest! {
        /// Whatever the number of entries leaves beside whole registers.
        #[test]
        fn vectors_and_operators_agree_to_the_last_bit(
            rows in prop::collection::vec((number(), number()), 0..21),
            factor in number(),
        ) {
            let (mut sum, entries): (Vec<_>, Vec<_>) = rows.into_iter().unzip();
            let known: Vec<DoubleDouble> =
                sum.iter().zip(&entries).map(|(sum, entry)| *sum + factor * *entry).collect();
            add_multiple(&mut sum, factor, &entries);
            prop_assert_eq!(sum, known);
        }
    }

    /// Where splitting overflows, the result is the same, finite or not.
    #[test]
    fn the_ends_of_the_range_agree() {
        for (factor, entry) in [
            (2f64.powi(1000), 3.0),
            (1e300, 1e8),
            (1e300, 1e9),
            (f64::INFINITY, 1.0),
        ] {
            let (factor, entry) = (DoubleDouble::from(factor), DoubleDouble::from(entry));
            let mut sum = [DoubleDouble::from(0.1); 5];
            add_multiple(&mut sum, factor, &[entry; 5]);
            let known = DoubleDouble::from(0.1) + factor * entry;
            let is_finite = known.high().is_finite() && known.low().is_finite();
            for sum in sum {
                assert_eq!(sum.high().is_finite() && sum.low().is_finite(), is_finite);
                assert!(!is_finite || sum == known);
            }
        }
    }
}
