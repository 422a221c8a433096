//! Sizes with the range of [`Wide`](crate::Wide) and directed rounding.

use std::cmp::Ordering;
use std::ops::{Add, Div, Mul};

use crate::real::power_of_two;

/// A number ≥ 0, possibly infinite, of about 50 bits and practically unbounded exponent. `+`, `*`
/// and `/` round up, within a relative 2^-50; 0·∞, 0/0 and ∞/∞ are ∞. So what is computed from
/// upper bounds by sums and products is an upper bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Magnitude {
    /// 0, ∞ or in [2^-256, 2^256).
    mantissa: f64,
    /// In units of 512 bits; 0 where the mantissa is 0 or ∞.
    exponent: i64,
}

/// 2^-256 and 2^256: squares of mantissas neither overflow nor underflow.
const LEAST: f64 = f64::from_bits((1023 - 256) << 52);
const END: f64 = f64::from_bits((1023 + 256) << 52);

/// 2^-512 and 2^512.
const DOWN: f64 = f64::from_bits((1023 - 512) << 52);
const UP: f64 = f64::from_bits((1023 + 512) << 52);

/// One rounded operation followed by a product with 1 ± 4u lies on the safe side of the exact
/// result, as (1 − u)²(1 + 4u) > 1 > (1 + u)²(1 − 4u).
const ABOVE: f64 = 1.0 + 4.0 * UNIT;
const BELOW: f64 = 1.0 - 4.0 * UNIT;
const UNIT: f64 = f64::EPSILON / 2.0;

impl Magnitude {
    /// 0.
    pub const ZERO: Magnitude = Magnitude {
        mantissa: 0.0,
        exponent: 0,
    };

    /// ∞: no bound at all.
    pub const INFINITY: Magnitude = Magnitude {
        mantissa: f64::INFINITY,
        exponent: 0,
    };

    /// 2^power.
    #[inline]
    pub fn power_of_two(power: i64) -> Magnitude {
        Magnitude {
            mantissa: power_of_two(power.saturating_add(256).rem_euclid(512) - 256),
            exponent: power.saturating_add(256).div_euclid(512),
        }
    }

    /// mantissa·2^(512·exponent), for a mantissa in [2^-1022, 2^1023] or 0; ∞ for ∞ and NaN.
    #[inline]
    pub(crate) fn new(mantissa: f64, exponent: i64) -> Magnitude {
        if (LEAST..END).contains(&mantissa) {
            Magnitude { mantissa, exponent }
        } else {
            Magnitude::normalised(mantissa, exponent)
        }
    }

    #[cold]
    fn normalised(mantissa: f64, exponent: i64) -> Magnitude {
        if mantissa == 0.0 {
            Magnitude::ZERO
        } else if mantissa < LEAST {
            Magnitude::new(mantissa * UP, exponent.saturating_sub(1))
        } else if mantissa < f64::INFINITY {
            Magnitude::new(mantissa * DOWN, exponent.saturating_add(1))
        } else {
            Magnitude::INFINITY
        }
    }

    #[cfg(test)]
    pub(crate) fn parts(self) -> (f64, i64) {
        (self.mantissa, self.exponent)
    }

    /// Whether it is 0.
    pub fn is_zero(self) -> bool {
        self.mantissa == 0.0
    }

    /// Whether it is a number.
    pub fn is_finite(self) -> bool {
        self.mantissa < f64::INFINITY
    }

    /// √self, rounded up, within a relative 2^-50.
    pub fn sqrt(self) -> Magnitude {
        let root = self.mantissa.sqrt() * ABOVE;
        if self.exponent % 2 == 0 {
            Magnitude::new(root, self.exponent / 2)
        } else {
            Magnitude::new(root * END, self.exponent.div_euclid(2))
        }
    }

    /// A little more: at least this over 1 − 2^-50.
    #[inline]
    pub(crate) fn above(self) -> Magnitude {
        Magnitude::new(self.mantissa * (1.0 + 16.0 * UNIT), self.exponent)
    }

    /// A little less: at most this over 1 + 2^-50; 0 for ∞.
    #[inline]
    pub(crate) fn below(self) -> Magnitude {
        if self.is_finite() {
            Magnitude::new(self.mantissa * (1.0 - 16.0 * UNIT), self.exponent)
        } else {
            Magnitude::ZERO
        }
    }

    /// At most max(0, self − other), within 2^-50 of self; 0 where either is ∞. A lower bound when
    /// self is a lower and other an upper bound.
    pub fn minus(self, other: Magnitude) -> Magnitude {
        if self <= other || !self.is_finite() {
            return Magnitude::ZERO;
        }
        let other = match self.exponent.saturating_sub(other.exponent) {
            _ if other.is_zero() => 0.0,
            0 => other.mantissa,
            1 => other.mantissa * DOWN,
            _ => 0.0,
        };
        Magnitude::new((self.mantissa - other) * BELOW, self.exponent)
    }

    /// √(self² + other²) within a relative 2^-50, even if both are off by a relative 2^-52.
    #[inline]
    pub(crate) fn hypot(self, other: Magnitude) -> Magnitude {
        if self.exponent == other.exponent {
            let square = self.mantissa * self.mantissa + other.mantissa * other.mantissa;
            Magnitude::new(square.sqrt(), self.exponent)
        } else {
            self.uneven_hypot(other)
        }
    }

    /// For different exponents, where the smaller one counts only if the exponents are next to each
    /// other.
    #[cold]
    fn uneven_hypot(self, other: Magnitude) -> Magnitude {
        let (large, small) = if self < other {
            (other, self)
        } else {
            (self, other)
        };
        let distance = large.exponent.saturating_sub(small.exponent);
        if small.is_zero() || !large.is_finite() || distance > 1 {
            return large;
        }
        let ratio = small.mantissa * DOWN / large.mantissa;
        Magnitude::new(
            large.mantissa * (1.0 + ratio * ratio).sqrt(),
            large.exponent,
        )
    }

    /// The numbers as doubles, 0, ∞ or in [2^-256, 2^256), if all are of that size.
    #[inline]
    pub(crate) fn plain<const N: usize>(numbers: [Magnitude; N]) -> Option<[f64; N]> {
        let exponents = numbers.iter().fold(0, |all, m| all | m.exponent);
        (exponents == 0).then(|| numbers.map(|m| m.mantissa))
    }

    /// The mantissas of numbers that are 0 or share one exponent, and that; `None` for all others.
    pub(crate) fn aligned(numbers: &[Magnitude]) -> Option<(Vec<f64>, i64)> {
        let exponent = numbers
            .iter()
            .find(|m| !m.is_zero())
            .map_or(0, |m| m.exponent);
        let shares = |m: &Magnitude| m.is_zero() || m.is_finite() && m.exponent == exponent;
        let mantissas = || numbers.iter().map(|m| m.mantissa).collect();
        numbers.iter().all(shares).then(|| (mantissas(), exponent))
    }

    /// A double that is no smaller, the same where doubles reach; ∞ beyond their range.
    pub fn to_f64(self) -> f64 {
        match self.exponent {
            0 => self.mantissa,
            1 => self.mantissa * UP,
            2 => self.mantissa * UP * UP,
            -1 => self.mantissa * DOWN,
            -2 => (self.mantissa * DOWN * DOWN).next_up(),
            below if below < 0 => f64::from_bits(1),
            _ => f64::INFINITY,
        }
    }

    /// log₂, to double precision; −∞ for 0.
    pub fn log2(self) -> f64 {
        self.mantissa.log2() + 512.0 * self.exponent as f64
    }

    /// k with 2^(k−1) ≤ self < 2^k; 0 for 0 and ∞.
    pub fn exponent(self) -> i64 {
        if self.is_zero() || !self.is_finite() {
            return 0;
        }
        let bits = (self.mantissa.to_bits() >> 52) as i64 - 1022;
        self.exponent.saturating_mul(512).saturating_add(bits)
    }
}

/// |x|, exactly; ∞ for NaN.
impl From<f64> for Magnitude {
    #[inline]
    fn from(x: f64) -> Magnitude {
        Magnitude::new(x.abs(), 0)
    }
}

impl Add for Magnitude {
    type Output = Magnitude;

    #[inline]
    fn add(self, other: Magnitude) -> Magnitude {
        if self.exponent == other.exponent {
            return Magnitude::new((self.mantissa + other.mantissa) * ABOVE, self.exponent);
        }
        let (large, small) = if self < other {
            (other, self)
        } else {
            (self, other)
        };
        if small.is_zero() {
            return large;
        }
        let small = match large.exponent.saturating_sub(small.exponent) {
            1 => small.mantissa * DOWN,
            _ => 0.0,
        };
        Magnitude::new((large.mantissa + small) * ABOVE, large.exponent)
    }
}

impl Mul for Magnitude {
    type Output = Magnitude;

    #[inline]
    fn mul(self, other: Magnitude) -> Magnitude {
        Magnitude::new(
            self.mantissa * other.mantissa * ABOVE,
            self.exponent.saturating_add(other.exponent),
        )
    }
}

impl Div for Magnitude {
    type Output = Magnitude;

    fn div(self, other: Magnitude) -> Magnitude {
        if !self.is_finite() {
            return Magnitude::INFINITY;
        }
        Magnitude::new(
            self.mantissa / other.mantissa * ABOVE,
            self.exponent.saturating_sub(other.exponent),
        )
    }
}

impl PartialOrd for Magnitude {
    #[inline]
    fn partial_cmp(&self, other: &Magnitude) -> Option<Ordering> {
        let plain = self.mantissa.partial_cmp(&other.mantissa);
        let comparable = |m: &Magnitude| m.is_zero() || !m.is_finite();
        if self.exponent == other.exponent || comparable(self) || comparable(other) {
            plain
        } else {
            Some(self.exponent.cmp(&other.exponent))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Real;
    use crate::rational::{Exact, dyadic};
    use proptest::prelude::*;

    prop_compose! {
        fn any_magnitude()(
            fraction in prop_oneof![Just(1.0), 1.0..2.0f64, Just(2.0 - f64::EPSILON)],
            power in -1500i64..1500,
        ) -> Magnitude {
            Magnitude::power_of_two(power) * Magnitude::from(fraction)
        }
    }

    proptest! {
        #[test]
        fn rounding_is_directed_and_small(a in any_magnitude(), b in any_magnitude(), shift in -2i64..3, twist in 0.99..1.01f64) {
            // As b, also a number near a, where differences cancel.
            for b in [b, a, a * Magnitude::from(twist), a * Magnitude::power_of_two(510 * shift)] {
                let (x, y) = (a.exact(), b.exact());
                let slack = dyadic(1.0, -50);
                let one = dyadic(1.0, 0);
                for (computed, truth) in [(a + b, &x + &y), (a * b, &x * &y), (a / b, &x / &y)] {
                    prop_assert!(computed.exact() >= truth);
                    prop_assert!(computed.exact() <= &truth * (&one + &slack));
                }
                let difference = if x > y { &x - &y } else { &x - &x };
                prop_assert!(a.minus(b).exact() <= difference);
                prop_assert!(a.minus(b).exact() >= &difference - &slack * &x);
                let root = a.sqrt().exact();
                prop_assert!(&root * &root >= x);
                prop_assert!(&root * &root <= &x * (&one + &slack + &slack));
                let square = &x * &x + &y * &y;
                let hypot = a.hypot(b).exact();
                prop_assert!(&hypot * &hypot <= &square * (&one + &slack));
                prop_assert!(&hypot * &hypot >= &square * (&one - &slack));
                prop_assert_eq!(a < b, x < y);
                prop_assert_eq!(a == b, x == y);
                prop_assert!(a.to_f64() == f64::INFINITY || dyadic(a.to_f64(), 0) >= x);
            }
        }
    }

    #[test]
    fn doubles_come_back_as_they_are() {
        for power in -700..1024 {
            let x = Real::scale(1.0, power);
            assert_eq!(Magnitude::from(x).to_f64(), x, "2^{power}");
        }
        assert_eq!(Magnitude::from(f64::MAX).to_f64(), f64::MAX);
        assert_eq!(Magnitude::power_of_two(1024).to_f64(), f64::INFINITY);
    }

    #[test]
    fn nothing_known_stays_nothing_known() {
        let two = Magnitude::from(2.0);
        for unknown in [
            Magnitude::from(f64::NAN),
            Magnitude::INFINITY * Magnitude::ZERO,
            Magnitude::ZERO / Magnitude::ZERO,
            Magnitude::INFINITY + two,
            two + Magnitude::INFINITY,
            two / Magnitude::ZERO,
            Magnitude::INFINITY / two,
            Magnitude::INFINITY / Magnitude::INFINITY,
        ] {
            assert_eq!(unknown, Magnitude::INFINITY);
            assert_eq!(unknown.minus(two), Magnitude::ZERO);
            assert_eq!(two.minus(unknown), Magnitude::ZERO);
        }
    }
}
