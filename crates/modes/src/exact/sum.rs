//! Sums of doubles without rounding, over the whole range of doubles.

use std::cmp::Ordering;

use eigentone_digits::DoubleDouble;

/// Bits below the binary point that a double can have.
const FRACTION: i32 = 1074;

/// 2098 bits of a double, and room for 2^32 of them.
const LIMBS: usize = 68;

/// A sum of doubles, exactly: a fixed-point number of 32-bit limbs with delayed carries (Kulisch's
/// long accumulator). It holds up to 2^31 terms.
#[derive(Clone)]
pub(crate) struct ExactSum {
    limbs: [i64; LIMBS],
    lowest: usize,
    highest: usize,
}

impl ExactSum {
    pub(crate) fn new() -> ExactSum {
        ExactSum {
            limbs: [0; LIMBS],
            lowest: LIMBS,
            highest: 0,
        }
    }

    pub(crate) fn of(terms: &[f64]) -> ExactSum {
        let mut sum = ExactSum::new();
        terms.iter().for_each(|&term| sum.add(term));
        sum
    }

    /// The sign of a sum: of the sum in doubles where rounding leaves no doubt of it.
    pub(crate) fn sign_of(terms: &[f64]) -> Ordering {
        if let [term] = terms {
            return term.partial_cmp(&0.0).unwrap_or(Ordering::Equal);
        }
        let (mut sum, mut size) = (0.0, 0.0);
        for term in terms {
            sum += term;
            size += term.abs();
        }
        // Each addition rounds by half a unit of what has been added so far; none of them underflows.
        let doubt = f64::EPSILON * terms.len() as f64 * size;
        if sum > doubt {
            Ordering::Greater
        } else if sum < -doubt {
            Ordering::Less
        } else {
            ExactSum::of(terms).sign()
        }
    }

    /// A sum times 2^power, as [`round`](Self::round) gives it.
    pub(crate) fn rounded(terms: &[f64], power: i64) -> DoubleDouble {
        if let [term] = terms
            && power.abs() <= 1000
        {
            let scaled = term * f64::from_bits(((1023 + power) as u64) << 52);
            if scaled.is_normal() {
                return DoubleDouble::from(scaled);
            }
        }
        ExactSum::of(terms).round(power)
    }

    /// Adds a finite double.
    pub(crate) fn add(&mut self, term: f64) {
        let parts = Parts::of(term);
        if parts.mantissa == 0 {
            return;
        }
        let shift = (parts.exponent + FRACTION) as usize;
        let (first, offset) = (shift / 32, shift % 32);
        let mut digits = u128::from(parts.mantissa) << offset;
        for limb in &mut self.limbs[first..first + 3] {
            let digit = (digits & 0xffff_ffff) as i64;
            *limb += if parts.negative { -digit } else { digit };
            digits >>= 32;
        }
        self.lowest = self.lowest.min(first);
        self.highest = self.highest.max(first + 2);
    }

    /// The sign of the sum: `Less` for a negative one.
    pub(crate) fn sign(&self) -> Ordering {
        let (mut carry, mut digits) = (0, 0);
        for limb in self.limbs.iter().take(self.highest + 1).skip(self.lowest) {
            let value = limb + carry;
            digits |= value & 0xffff_ffff;
            carry = value >> 32;
        }
        if carry == 0 && digits == 0 {
            Ordering::Equal
        } else {
            carry.cmp(&0).then(Ordering::Greater)
        }
    }

    /// The first five digits of the size, from the first that is not 0, and the power of two by
    /// which the last of them counts. All 0 for the sum 0.
    fn leading(&self) -> ([i64; 5], i64) {
        let negative = self.sign() == Ordering::Less;
        let mut digits = [0; LIMBS + 1];
        let mut carry = 0;
        for (at, digit) in digits.iter_mut().enumerate().skip(self.lowest) {
            let limb = self.limbs.get(at).copied().unwrap_or(0);
            let value = if negative { -limb } else { limb } + carry;
            *digit = value & 0xffff_ffff;
            carry = value >> 32;
        }
        let top = digits.iter().rposition(|&digit| digit != 0).unwrap_or(0) as i64;
        let digit = |place: i64| usize::try_from(place).map_or(0, |place| digits[place]);
        let places = [0, 1, 2, 3, 4].map(|below| digit(top - below));
        (places, 32 * (top - 4) - i64::from(FRACTION))
    }

    /// ⌊log₂ of the size⌋, for a sum other than 0.
    pub(crate) fn exponent(&self) -> i64 {
        let (digits, last) = self.leading();
        last + 128 + i64::from(digits[0].max(1).ilog2())
    }

    /// The sum times 2^power, to 2^-103 of itself unless it underflows.
    pub(crate) fn round(&self, power: i64) -> DoubleDouble {
        let (digits, last) = self.leading();
        let size = digits.iter().fold(DoubleDouble::ZERO, |size, &digit| {
            size * 2f64.powi(32) + digit as f64
        });
        // In steps, since a power of two that is needed may be beyond those a double has.
        let mut left = last + power;
        let mut rounded = if self.sign() == Ordering::Less {
            -size
        } else {
            size
        };
        while left != 0 && rounded.high() != 0.0 && rounded.high().is_finite() {
            let step = left.clamp(-1000, 1000);
            rounded = rounded * 2f64.powi(step as i32);
            left -= step;
        }
        rounded
    }
}

/// A finite double as ± mantissa · 2^exponent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Parts {
    pub(crate) negative: bool,
    pub(crate) mantissa: u64,
    pub(crate) exponent: i32,
}

impl Parts {
    pub(crate) fn of(value: f64) -> Parts {
        let bits = value.to_bits();
        let biased = (bits >> 52 & 0x7ff) as i32;
        let fraction = bits & ((1 << 52) - 1);
        Parts {
            negative: bits >> 63 == 1,
            mantissa: if biased == 0 {
                fraction
            } else {
                fraction | 1 << 52
            },
            exponent: biased.max(1) - 1 - FRACTION,
        }
    }
}

/// The place of a number's bits: it is a multiple of 2^low and smaller than 2^high in size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extent {
    pub(crate) low: i64,
    pub(crate) high: i64,
}

impl Extent {
    /// The extent of 0, neutral in [`join`](Extent::join).
    pub(crate) const NOTHING: Extent = Extent {
        low: i64::MAX / 4,
        high: i64::MIN / 4,
    };

    /// Of the sum of `terms`.
    pub(crate) fn of(terms: &[f64]) -> Extent {
        let sum = terms.iter().fold(Extent::NOTHING, |extent, &term| {
            let parts = Parts::of(term);
            if parts.mantissa == 0 {
                return extent;
            }
            let at = |bits: u32| i64::from(parts.exponent) + i64::from(bits);
            extent.join(Extent {
                low: at(parts.mantissa.trailing_zeros()),
                high: at(u64::BITS - parts.mantissa.leading_zeros()),
            })
        });
        sum.of_sum(terms.len())
    }

    /// Of any number with one of two extents.
    pub(crate) fn join(self, other: Extent) -> Extent {
        Extent {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    /// Of a sum of so many numbers of this extent.
    pub(crate) fn of_sum(self, count: usize) -> Extent {
        Extent {
            high: self.high + ceil_log2(count),
            ..self
        }
    }

    /// Of the product of two numbers.
    pub(crate) fn times(self, other: Extent) -> Extent {
        Extent {
            low: self.low + other.low,
            high: self.high + other.high,
        }
    }

    /// Of the number times 2^power.
    pub(crate) fn shifted(self, power: i64) -> Extent {
        Extent {
            low: self.low + power,
            high: self.high + power,
        }
    }

    /// How many bits lie between the lowest and the highest; 0 where there is nothing.
    pub(crate) fn bits(self) -> u64 {
        u64::try_from(self.high - self.low).unwrap_or(0)
    }
}

/// ⌈log₂ count⌉, and 0 of 0.
pub(crate) fn ceil_log2(count: usize) -> i64 {
    i64::from(usize::BITS - count.saturating_sub(1).leading_zeros())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn cancelling_sums_keep_their_last_bit() {
        let tiny = f64::from_bits(1);
        assert_eq!(
            ExactSum::of(&[1e300, tiny, -1e300]).sign(),
            Ordering::Greater
        );
        assert_eq!(ExactSum::of(&[1e300, -tiny, -1e300]).sign(), Ordering::Less);
        assert_eq!(ExactSum::of(&[0.1, 0.2, -0.3]).sign(), Ordering::Greater);
        assert_eq!(ExactSum::of(&[0.5, 0.25, -0.75]).sign(), Ordering::Equal);
        assert_eq!(ExactSum::of(&[f64::MAX; 9]).sign(), Ordering::Greater);
        assert_eq!(
            ExactSum::of(&[f64::MAX, f64::MAX, -f64::MAX, -f64::MAX]).sign(),
            Ordering::Equal
        );
        assert_eq!(ExactSum::of(&[-0.0, 0.0]).sign(), Ordering::Equal);
        assert_eq!(ExactSum::of(&[]).sign(), Ordering::Equal);
    }

    #[test]
    fn extents_hold_the_number() {
        assert_eq!(Extent::of(&[6.0]), Extent { low: 1, high: 3 });
        assert_eq!(Extent::of(&[f64::from_bits(1)]).low, -1074);
        assert_eq!(Extent::of(&[f64::MAX]).high, 1024);
        assert_eq!(Extent::of(&[1.0, 1.0, 1.0]).high, 3);
        assert_eq!(Extent::of(&[]).bits(), 0);
        assert_eq!([0, 1, 2, 3, 4, 5].map(ceil_log2), [0, 0, 1, 2, 2, 3]);
    }

    #[test]
    fn rounding_keeps_a_hundred_bits() {
        let ones = [
            2f64.powi(1000),
            1.0,
            2f64.powi(-60),
            f64::from_bits(1),
            -(2f64.powi(1000)),
        ];
        assert_eq!(
            ExactSum::of(&ones).round(0),
            DoubleDouble::new(1.0, 2f64.powi(-60))
        );
        assert_eq!(ExactSum::of(&ones).exponent(), 0);
        assert_eq!(ExactSum::of(&[-2f64.powi(1023); 5]).exponent(), 1025);
        assert_eq!(
            ExactSum::of(&[-2f64.powi(1023); 5]).round(-1023).high(),
            -5.0
        );
        assert_eq!(
            ExactSum::of(&[f64::from_bits(3)]).round(1074),
            DoubleDouble::from(3.0)
        );
        assert_eq!(ExactSum::of(&[f64::from_bits(3)]).exponent(), -1073);
        assert_eq!(ExactSum::new().round(5), DoubleDouble::ZERO);
    }

    fn finite() -> impl Strategy<Value = f64> {
        any::<u64>()
            .prop_map(f64::from_bits)
            .prop_filter("finite", |x| x.is_finite())
    }

    proptest! {
        #[test]
        fn a_sum_and_its_negative_cancel(mut terms in prop::collection::vec(finite(), 1..8), extra in finite()) {
            let negative: Vec<f64> = terms.iter().rev().map(|x| -x).collect();
            terms.extend(negative);
            prop_assert_eq!(ExactSum::of(&terms).sign(), Ordering::Equal);
            terms.insert(terms.len() / 3, extra);
            prop_assert_eq!(ExactSum::of(&terms).sign(), extra.partial_cmp(&0.0).unwrap());
        }

        /// Also of sums that nearly or wholly cancel, where doubles do not decide.
        #[test]
        fn the_quick_sign_is_the_sign(terms in prop::collection::vec(finite(), 0..6), near in any::<bool>()) {
            let negative = terms.iter().rev().map(|x| if near { -x.next_up() } else { -x });
            let both: Vec<f64> = terms.iter().copied().chain(negative).collect();
            for terms in [&terms, &both] {
                prop_assert_eq!(ExactSum::sign_of(terms), ExactSum::of(terms).sign());
            }
        }

        #[test]
        fn a_comparison_is_the_sign_of_a_difference(a in finite(), b in finite()) {
            prop_assert_eq!(ExactSum::of(&[a, -b]).sign(), a.partial_cmp(&b).unwrap());
        }
    }
}
