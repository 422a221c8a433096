//! What kernels ask of a number, so that one kernel serves every precision.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::Magnitude;

/// The decimal digits that numbers of so many limbs of 64 bits have; fewer than 4 limbs stand for a double-double.
pub fn decimal_digits(limbs: usize) -> usize {
    match limbs {
        0..4 => 32,
        _ => limbs * 1233 / 64,
    }
}

/// A real number of some fixed precision, with a proven bound of its rounding errors.
///
/// For ∘ in +, −, ·, / let z be the computed and ẑ the exact x∘y. When z is finite,
/// |z − ẑ| ≤ 2^`UNIT_LOG2`·min(|z|, |ẑ|) + `floor()`, without the floor for + and −. Negation,
/// absolute value and conversion from a double are exact. A result that is out of range, or a
/// quotient by zero, is not finite; and what is computed from a number that is not finite is not
/// finite, unless it was the divisor.
pub trait Real:
    Copy
    + Debug
    + PartialOrd
    + Send
    + Sync
    + 'static
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// 0.
    const ZERO: Self;

    /// 1.
    const ONE: Self;

    /// The base-2 logarithm of the relative error bound of one operation.
    const UNIT_LOG2: i32;

    /// The relative error bound of one operation.
    fn unit() -> Magnitude {
        Magnitude::power_of_two(i64::from(Self::UNIT_LOG2))
    }

    /// The absolute error that underflow may add to one product or quotient; below 2^-1000.
    fn floor() -> Magnitude;

    /// The nearest double, ±∞ where doubles end; not finite where x is not.
    fn to_f64(self) -> f64;

    /// Whether x is a number in range.
    fn is_finite(self) -> bool;

    /// A number between |x|(1 − 2^-52) and |x|(1 + 2^-52); infinite where x is not finite.
    fn magnitude(self) -> Magnitude;

    /// An upper bound of |x|, within a relative 2^-49.
    fn upper(self) -> Magnitude {
        self.magnitude().above()
    }

    /// x·2^power, within `floor()`.
    fn scale(self, power: i64) -> Self;

    /// √x, within 4 times the error of a quotient; not finite for x < 0.
    fn sqrt(self) -> Self;

    /// x·factor, within the bound of a product.
    fn mul_f64(self, factor: f64) -> Self {
        self * Self::from(factor)
    }

    /// sumᵢ + factor·entriesᵢ in place of sumᵢ, for as many as both have.
    fn add_multiple(sum: &mut [Self], factor: Self, entries: &[Self]) {
        let length = sum.len().min(entries.len());
        Self::add_multiples(&mut sum[..length], &[(factor, &entries[..length])]);
    }

    /// sumᵢ + Σ factor·entriesᵢ in place of sumᵢ, over all terms (factor, entries). However many calls add the k terms of
    /// a sum to 0, it is off by at most (k + 2)·`unit()`/(1 − k·`unit()`) times the sum of their sizes, and by `floor()`
    /// for each.
    ///
    /// # Panics
    /// If there are fewer entries in a term than sums.
    fn add_multiples(sum: &mut [Self], terms: &[(Self, &[Self])]) {
        for (factor, entries) in terms {
            for (sum, entry) in sum.iter_mut().zip(*entries) {
                *sum = *sum + *factor * *entry;
            }
        }
    }

    /// A·B of an m × k matrix and one of k × n, by rows, from their shape [m, k, n], where that takes less time than sums of products:
    /// off by at most (k + 2)·`unit()`·‖|A|‖‖|B|‖ in the 2-norm. What is 0 by terms that are all 0 is 0. `None` where it takes
    /// as long, or an entry is not finite.
    fn matrix_product(_shape: [usize; 3], _a: &[Self], _b: &[Self]) -> Option<Vec<Self>> {
        None
    }

    /// |x|.
    fn abs(self) -> Self {
        if self < Self::ZERO { -self } else { self }
    }

    /// Whether x is 0.
    fn is_zero(self) -> bool {
        self == Self::ZERO
    }
}

impl Real for f64 {
    const ZERO: f64 = 0.0;
    const ONE: f64 = 1.0;
    const UNIT_LOG2: i32 = -53;

    fn floor() -> Magnitude {
        Magnitude::power_of_two(-1074)
    }

    fn to_f64(self) -> f64 {
        self
    }

    fn is_finite(self) -> bool {
        f64::is_finite(self)
    }

    fn magnitude(self) -> Magnitude {
        Magnitude::from(self)
    }

    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }

    fn scale(self, power: i64) -> f64 {
        let (mut value, mut rest) = (self, power.clamp(-2200, 2200));
        while rest.abs() > 1000 {
            let step = rest.clamp(-1000, 1000);
            value *= power_of_two(step);
            rest -= step;
        }
        value * power_of_two(rest)
    }
}

/// 2^power, for |power| ≤ 1022.
pub(crate) fn power_of_two(power: i64) -> f64 {
    f64::from_bits(((1023 + power) as u64) << 52)
}
