//! Real numbers known to within a radius: midpoint-radius arithmetic on whole numbers
//! (J. van der Hoeven, *Ball arithmetic*, 2010; F. Johansson, *Arb*, IEEE Trans. Comput. 66, 2017).

use std::cmp::Ordering;
use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};

use num_bigint::{BigInt, BigUint, Sign};
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

/// A radius that says that nothing is known.
const UNKNOWN: u64 = u64::MAX;

/// The bits that a radius may have before both it and the midpoint are cut.
const RADIUS_BITS: u64 = 32;

/// The fewest bits that an inexact result keeps.
const LEAST_BITS: u64 = 64;

/// A real number that is known to lie within `radius`·2^`exponent` of `midpoint`·2^`exponent`. Both
/// are whole numbers, so that every bound is exact or rounded up in sight.
///
/// Each operation keeps the larger number of bits of its two operands. Doubles and whole numbers
/// come with none: they take on those of what they meet.
#[derive(Clone, Debug)]
pub struct Ball {
    midpoint: BigInt,
    radius: u64,
    exponent: i64,
    bits: u64,
}

impl Ball {
    /// `midpoint`·2^`exponent`, known to `radius`·2^`exponent`, cut to `bits` bits.
    pub(crate) fn new(midpoint: BigInt, radius: BigUint, exponent: i64, bits: u64) -> Ball {
        let excess = midpoint.bits().saturating_sub(bits.max(LEAST_BITS));
        let shift = excess.max(radius.bits().saturating_sub(RADIUS_BITS));
        let (midpoint, radius) = match shift {
            0 => (midpoint, radius),
            _ => shift_right(&midpoint, &radius, shift),
        };
        Ball {
            midpoint,
            radius: radius.to_u64().expect("it was cut to 33 bits"),
            exponent: exponent.saturating_add(shift as i64),
            bits,
        }
    }

    /// A number of which nothing is known.
    pub(crate) fn unknown(bits: u64) -> Ball {
        Ball {
            midpoint: BigInt::zero(),
            radius: UNKNOWN,
            exponent: 0,
            bits,
        }
    }

    pub(crate) fn zero() -> Ball {
        Ball::from(0)
    }

    /// The rational number `value` to `bits` bits.
    pub(crate) fn rational(value: &BigRational, bits: u64) -> Ball {
        let [numerator, denominator] =
            [value.numer(), value.denom()].map(|whole| Ball::from(whole.clone()));
        numerator.with_bits(bits) / denominator
    }

    /// The same number with another number of bits for what is computed from it.
    pub(crate) fn with_bits(self, bits: u64) -> Ball {
        Ball { bits, ..self }
    }

    /// The same number, cut to `bits` bits.
    pub(crate) fn rounded(&self, bits: u64) -> Ball {
        match self.is_unknown() {
            true => Ball::unknown(bits),
            false => Ball::new(
                self.midpoint.clone(),
                self.radius.into(),
                self.exponent,
                bits,
            ),
        }
    }

    /// The bits that results computed from it keep.
    pub(crate) fn bits(&self) -> u64 {
        self.bits
    }

    pub(crate) fn is_unknown(&self) -> bool {
        self.radius == UNKNOWN
    }

    /// Whether it is 0 without doubt.
    pub(crate) fn is_zero(&self) -> bool {
        self.midpoint.is_zero() && self.radius == 0
    }

    pub(crate) fn contains_zero(&self) -> bool {
        *self.midpoint.magnitude() <= BigUint::from(self.radius)
    }

    /// Its sign, where that is known.
    pub(crate) fn sign(&self) -> Option<Ordering> {
        match self.midpoint.sign() {
            _ if self.is_zero() => Some(Ordering::Equal),
            _ if self.contains_zero() => None,
            Sign::Minus => Some(Ordering::Less),
            _ => Some(Ordering::Greater),
        }
    }

    /// Whether it is greater than 0 without doubt.
    pub(crate) fn is_positive(&self) -> bool {
        self.sign() == Some(Ordering::Greater)
    }

    /// Its midpoint as an exact number.
    pub(crate) fn midpoint(&self) -> Ball {
        Ball {
            midpoint: self.midpoint.clone(),
            radius: 0,
            ..*self
        }
    }

    /// The same number, known to |`more`| less.
    pub(crate) fn widened(&self, more: &Ball) -> Ball {
        if more.is_unknown() {
            return Ball::unknown(self.bits);
        }
        let upper = more.midpoint.magnitude() + more.radius;
        self + &Ball::new(BigInt::zero(), upper, more.exponent, self.bits)
    }

    /// The number times 2^`power`.
    pub(crate) fn scaled(mut self, power: i64) -> Ball {
        self.exponent = self.exponent.saturating_add(power);
        self
    }

    pub(crate) fn abs(&self) -> Ball {
        match self.midpoint.sign() {
            Sign::Minus => -self,
            _ => self.clone(),
        }
    }

    /// log₂ of the midpoint's size, roughly; −∞ for 0.
    pub(crate) fn log2(&self) -> f64 {
        log2(self.midpoint.magnitude(), self.exponent)
    }

    /// log₂ of the radius, roughly; −∞ for 0.
    pub(crate) fn radius_log2(&self) -> f64 {
        if self.is_unknown() {
            return f64::INFINITY;
        }
        log2(&BigUint::from(self.radius), self.exponent)
    }

    /// The whole number nearest to the midpoint, which must be below 2^`bits` for some sensible
    /// number of bits.
    pub(crate) fn round(&self) -> BigInt {
        let half = BigRational::new(BigInt::one(), BigInt::from(2));
        (self.exact() + half).floor().to_integer()
    }

    /// The midpoint as a rational number.
    fn exact(&self) -> BigRational {
        let power = BigInt::one() << self.exponent.unsigned_abs();
        match self.exponent < 0 {
            true => BigRational::new(self.midpoint.clone(), power),
            false => BigRational::from(&self.midpoint * power),
        }
    }

    /// The square root; unknown for a negative number.
    pub(crate) fn sqrt(&self) -> Ball {
        let radius = BigInt::from(self.radius);
        let upper = &self.midpoint + &radius;
        if self.is_unknown() || upper.is_negative() {
            return Ball::unknown(self.bits);
        }
        let lower = (&self.midpoint - &radius).max(BigInt::zero());
        // An even exponent, low enough for all the bits of the root.
        let wanted = 2 * self.bits.max(LEAST_BITS) + 4;
        let mut shift = wanted.saturating_sub(upper.bits()) as i64;
        shift += (self.exponent - shift).rem_euclid(2);
        let exact = |root: &BigInt, square: &BigInt| root * root == *square;
        let (lower, upper) = (lower << shift, upper << shift);
        let (low, high) = (lower.sqrt(), upper.sqrt());
        let high = match exact(&high, &upper) {
            true => high,
            false => high + 1,
        };
        let middle: BigInt = (&low + &high) >> 1;
        let radius = (high - &middle).max(&middle - low);
        let radius = radius.magnitude().clone();
        Ball::new(middle, radius, (self.exponent - shift) / 2, self.bits)
    }

    /// The double nearest to the midpoint; infinite beyond the largest one.
    pub fn nearest(&self) -> f64 {
        let magnitude = self.midpoint.magnitude();
        let size = match self.is_unknown() {
            true => f64::NAN,
            false => nearest(magnitude, self.exponent),
        };
        match self.midpoint.sign() {
            Sign::Minus => -size,
            _ => size,
        }
    }

    /// The double nearest to the midpoint less `value`, which keeps the digits that the two do not
    /// share: the error of a double far below its last place. NaN for a `value` that is not finite.
    pub fn minus(&self, value: f64) -> f64 {
        let exact = Ball::exactly(value).map(|value| self.midpoint().with_bits(u64::MAX) - value);
        exact.map_or(f64::NAN, |difference| difference.nearest())
    }

    /// The smallest double that is not below the radius; infinite where nothing is known.
    pub fn radius(&self) -> f64 {
        if self.is_unknown() {
            return f64::INFINITY;
        }
        let radius = BigUint::from(self.radius);
        let size = nearest(&radius, self.exponent);
        let short = Ball::exactly(size).is_some_and(|size| {
            let spread = Ball::from(BigInt::from(radius)).scaled(self.exponent);
            (size - spread).midpoint.is_negative()
        });
        if short { size.next_up() } else { size }
    }

    /// The double `value`, unless it is infinite or NaN.
    pub(crate) fn exactly(value: f64) -> Option<Ball> {
        let exact = BigRational::from_float(value)?;
        // The denominator of a double is a power of two.
        let power = exact.denom().bits() as i64 - 1;
        Some(Ball::from(exact.numer().clone()).scaled(-power))
    }

    /// The midpoint with so many significant decimal digits, halves away from 0:
    /// `-1.234567e-5`. The radius shows how many of them are significant.
    pub fn to_decimal(&self, digits: usize) -> String {
        if self.is_unknown() {
            return "NaN".to_owned();
        }
        if self.midpoint.is_zero() {
            return "0".to_owned();
        }
        let digits = digits.max(1);
        let value = self.exact().abs();
        // The estimate of the exponent may be one too small.
        let mut exponent = (self.log2() * std::f64::consts::LOG10_2).floor() as i64;
        let whole = loop {
            let power = BigInt::from(10).pow((digits as i64 - 1 - exponent).unsigned_abs() as u32);
            let scaled = match digits as i64 > exponent {
                true => &value * BigRational::from(power),
                false => &value / BigRational::from(power),
            };
            let text = scaled.round().to_integer().to_string();
            match text.len().cmp(&digits) {
                Ordering::Less => exponent -= 1,
                Ordering::Equal => break text,
                Ordering::Greater => exponent += 1,
            }
        };
        let sign = if self.midpoint.is_negative() { "-" } else { "" };
        let (first, rest) = whole.split_at(1);
        let point = if rest.is_empty() { "" } else { "." };
        format!("{sign}{first}{point}{rest}e{exponent}")
    }

    /// The number rounded to so many significant decimal digits, as [`to_decimal`](Self::to_decimal)
    /// writes them, where all numbers within the radius round to the same: then every digit is right.
    /// `None` where the radius leaves it open.
    pub fn decided(&self, digits: usize) -> Option<String> {
        if self.is_unknown() {
            return None;
        }
        let end = |radius: BigInt| {
            let end = Ball::from(&self.midpoint + radius).scaled(self.exponent);
            end.to_decimal(digits)
        };
        let low = end(-BigInt::from(self.radius));
        (low == end(BigInt::from(self.radius))).then_some(low)
    }

    /// Whether it is 0 and nothing else.
    pub fn is_exactly_zero(&self) -> bool {
        self.is_zero()
    }

    /// Whether 0 is within the radius.
    pub fn may_be_zero(&self) -> bool {
        self.is_unknown() || self.contains_zero()
    }

    /// A power of ten that the number's size is not above; `None` for an exact 0 and where nothing is
    /// known.
    pub fn ceiling(&self) -> Option<i64> {
        let size = self.midpoint.magnitude() + self.radius;
        if self.is_unknown() || size.is_zero() {
            return None;
        }
        // One more than the rounding of the logarithm can take away.
        Some((log2(&size, self.exponent) * std::f64::consts::LOG10_2).floor() as i64 + 1)
    }

    /// A whole number of units of 2^`exponent`, and how many of them it may be off.
    pub(super) fn in_units(&self, exponent: i64) -> (BigInt, BigUint) {
        let radius = BigUint::from(self.radius);
        let shift = exponent.saturating_sub(self.exponent);
        match u64::try_from(shift) {
            Ok(shift) => shift_right(&self.midpoint, &radius, shift),
            Err(_) => {
                let shift = shift.unsigned_abs();
                (&self.midpoint << shift, radius << shift)
            }
        }
    }

    /// The position above the highest bit of midpoint and radius.
    fn top(&self) -> i64 {
        let radius = u64::from(u64::BITS - self.radius.leading_zeros());
        let bits = self.midpoint.bits().max(radius) as i64;
        self.exponent.saturating_add(bits)
    }
}

/// A midpoint and a radius in units that are 2^shift larger; the radius rounded up.
pub(super) fn shift_right(midpoint: &BigInt, radius: &BigUint, shift: u64) -> (BigInt, BigUint) {
    if shift == 0 {
        return (midpoint.clone(), radius.clone());
    }
    let rounded = |lost: Option<u64>| u64::from(lost.is_some_and(|zeros| zeros < shift));
    let cut = rounded(midpoint.trailing_zeros()) + rounded(radius.trailing_zeros());
    (midpoint >> shift, (radius >> shift) + cut)
}

fn log2(magnitude: &BigUint, exponent: i64) -> f64 {
    let bits = magnitude.bits();
    let shift = bits.saturating_sub(60);
    let leading = (magnitude >> shift).to_f64().expect("60 bits fit");
    leading.log2() + (exponent as f64 + shift as f64)
}

/// The double nearest to `magnitude`·2^`exponent`, ties to even.
fn nearest(magnitude: &BigUint, exponent: i64) -> f64 {
    let bits = magnitude.bits() as i64;
    let top = exponent.saturating_add(bits);
    if magnitude.is_zero() || top < -1074 {
        return 0.0;
    }
    if top > 1024 {
        return f64::INFINITY;
    }
    // Below 2^-1022 a double has fewer than 53 bits.
    let shift = bits - (top + 1074).min(53);
    let (whole, exponent) = match u64::try_from(shift) {
        Ok(shift) => {
            let (quotient, rest) = magnitude.div_rem(&(BigUint::one() << shift));
            let up = match (rest << 1u8).cmp(&(BigUint::one() << shift)) {
                Ordering::Less => false,
                Ordering::Equal => quotient.is_odd(),
                Ordering::Greater => true,
            };
            (quotient + u8::from(up), exponent + shift as i64)
        }
        Err(_) => (magnitude.clone(), exponent),
    };
    let whole = whole.to_f64().expect("at most 2^53");
    // Two powers, neither of which leaves the range of doubles; the product is exact.
    let half = (exponent / 2) as i32;
    whole * 2f64.powi(half) * 2f64.powi(exponent as i32 - half)
}

impl From<i64> for Ball {
    fn from(value: i64) -> Ball {
        Ball::from(BigInt::from(value))
    }
}

impl From<BigInt> for Ball {
    fn from(value: BigInt) -> Ball {
        Ball {
            midpoint: value,
            radius: 0,
            exponent: 0,
            bits: 0,
        }
    }
}

impl Neg for &Ball {
    type Output = Ball;
    fn neg(self) -> Ball {
        Ball {
            midpoint: -&self.midpoint,
            ..*self
        }
    }
}

impl Add for &Ball {
    type Output = Ball;
    fn add(self, other: &Ball) -> Ball {
        let bits = self.bits.max(other.bits);
        if self.is_unknown() || other.is_unknown() {
            return Ball::unknown(bits);
        }
        // What lies far below the larger one's last bit is cut before it is aligned.
        let top = self.top().max(other.top());
        let last = top.saturating_sub_unsigned(bits.saturating_add(LEAST_BITS));
        let exponent = match (self.is_zero(), other.is_zero()) {
            (true, _) => other.exponent,
            (_, true) => self.exponent,
            _ => self.exponent.min(other.exponent).max(last),
        };
        let ((a, a_radius), (b, b_radius)) = (self.in_units(exponent), other.in_units(exponent));
        Ball::new(a + b, a_radius + b_radius, exponent, bits)
    }
}

impl Sub for &Ball {
    type Output = Ball;
    fn sub(self, other: &Ball) -> Ball {
        self + &-other
    }
}

impl Mul for &Ball {
    type Output = Ball;
    fn mul(self, other: &Ball) -> Ball {
        let bits = self.bits.max(other.bits);
        if self.is_zero() || other.is_zero() {
            return Ball::zero().with_bits(bits);
        }
        if self.is_unknown() || other.is_unknown() {
            return Ball::unknown(bits);
        }
        let midpoint = &self.midpoint * &other.midpoint;
        let mut radius = BigUint::zero();
        if self.radius != 0 || other.radius != 0 {
            radius += self.midpoint.magnitude() * other.radius;
            radius += (other.midpoint.magnitude() + other.radius) * self.radius;
        }
        let exponent = self.exponent.saturating_add(other.exponent);
        Ball::new(midpoint, radius, exponent, bits)
    }
}

impl Div for &Ball {
    type Output = Ball;
    fn div(self, other: &Ball) -> Ball {
        let bits = self.bits.max(other.bits);
        if self.is_unknown() || other.contains_zero() {
            return Ball::unknown(bits);
        }
        if self.is_zero() {
            return Ball::zero().with_bits(bits);
        }
        // a/b − m/n = ((a − m) − (b − n)·m/n)/b, with |b| ≥ |n| − rad n.
        let wanted = bits.max(LEAST_BITS) + 2 + other.midpoint.bits();
        let shift = wanted.saturating_sub(self.midpoint.bits());
        let (quotient, rest) = (&self.midpoint << shift).div_rem(&other.midpoint);
        let mut radius = BigUint::from(u64::from(!rest.is_zero()));
        if self.radius != 0 || other.radius != 0 {
            let least = other.midpoint.magnitude() - other.radius;
            let from_divisor = (quotient.magnitude() + 1u8) * other.radius;
            let spread = (BigUint::from(self.radius) << shift) + from_divisor;
            radius += spread.div_ceil(&least);
        }
        let exponent = self.exponent.saturating_sub(other.exponent);
        let exponent = exponent.saturating_sub_unsigned(shift);
        Ball::new(quotient, radius, exponent, bits)
    }
}

macro_rules! by_value {
    ($($operator:ident $method:ident),*) => {$(
        impl $operator for Ball {
            type Output = Ball;
            fn $method(self, other: Ball) -> Ball {
                $operator::$method(&self, &other)
            }
        }
        impl $operator<&Ball> for Ball {
            type Output = Ball;
            fn $method(self, other: &Ball) -> Ball {
                $operator::$method(&self, other)
            }
        }
        impl $operator<Ball> for &Ball {
            type Output = Ball;
            fn $method(self, other: Ball) -> Ball {
                $operator::$method(self, &other)
            }
        }
    )*};
}
by_value!(Add add, Sub sub, Mul mul, Div div);

impl Neg for Ball {
    type Output = Ball;
    fn neg(self) -> Ball {
        -&self
    }
}

impl fmt::Display for Ball {
    /// The digits of the midpoint that the radius leaves, at most 34 of them, and the radius.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let known = (self.log2() - self.radius_log2()) * std::f64::consts::LOG10_2;
        let digits = if known > 34.0 {
            34
        } else {
            known.max(1.0) as usize
        };
        write!(f, "{} ± {:.0e}", self.to_decimal(digits), self.radius())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    impl Ball {
        fn holds(&self, value: &BigRational) -> bool {
            let reach = Ball::from(BigInt::from(self.radius)).scaled(self.exponent);
            self.is_unknown() || (self.exact() - value).abs() <= reach.exact()
        }
    }

    /// A ball with few bits and a number in it.
    fn inside() -> impl Strategy<Value = (Ball, BigRational)> {
        let parts = (
            any::<i64>(),
            0u64..1 << 20,
            -40i64..40,
            0.0..=1.0f64,
            prop::bool::ANY,
        );
        parts.prop_map(|(midpoint, radius, exponent, place, exact)| {
            let radius = if exact { 0 } else { radius };
            let ball = Ball::new(midpoint.into(), radius.into(), exponent, 64);
            let place = BigRational::from_float(2.0 * place - 1.0).expect("finite");
            let reach = Ball::from(BigInt::from(ball.radius)).scaled(ball.exponent);
            let value = ball.exact() + place * reach.exact();
            (ball, value)
        })
    }

    proptest! {
        #[test]
        fn results_hold_what_the_operands_hold((a, x) in inside(), (b, y) in inside()) {
            prop_assert!((&a + &b).holds(&(&x + &y)));
            prop_assert!((&a - &b).holds(&(&x - &y)));
            prop_assert!((&a * &b).holds(&(&x * &y)));
            if !y.is_zero() {
                prop_assert!((&a / &b).holds(&(&x / &y)));
            }
            prop_assert!(a.rounded(16).holds(&x));
            prop_assert!(a.widened(&b).holds(&(&x + &y)) || b.is_unknown());
            let square = &x * &x;
            let root = (&a * &a).sqrt();
            prop_assert!(root.holds(&x.abs()), "{root} of {square}");
        }

        #[test]
        fn doubles_come_back(value in any::<f64>().prop_filter("finite", |value| value.is_finite())) {
            let ball = Ball::exactly(value).expect("finite");
            prop_assert_eq!(ball.nearest(), value);
            prop_assert_eq!(ball.radius(), 0.0);
            prop_assert_eq!(ball.minus(value), 0.0);
            let decimal: f64 = ball.to_decimal(17).parse().expect("a number");
            prop_assert_eq!(decimal, value);
        }
    }

    #[test]
    fn roundings_to_doubles_are_to_even() {
        let near =
            |whole: u64, exponent| Ball::from(BigInt::from(whole)).scaled(exponent).nearest();
        assert_eq!(near((1 << 54) + 2, 0), 2f64.powi(54));
        assert_eq!(near((1 << 54) + 6, 0), 2f64.powi(54) + 8.0);
        assert_eq!(near(1, -1075), 0.0);
        assert_eq!(near(3, -1075), 2.0 * f64::from_bits(1));
        assert_eq!(near(3, -1076), f64::from_bits(1));
        assert_eq!(near(u64::MAX, 960), f64::INFINITY);
    }

    #[test]
    fn decimals_round_and_carry() {
        let decimal = |value: f64, digits| Ball::exactly(value).expect("finite").to_decimal(digits);
        assert_eq!(decimal(0.1, 34), "1.000000000000000055511151231257827e-1");
        assert_eq!(decimal(-999.96875, 4), "-1.000e3");
        assert_eq!(decimal(999.5, 3), "1.00e3");
        assert_eq!(decimal(7.0, 1), "7e0");
        assert_eq!(decimal(0.0, 5), "0");
    }

    #[test]
    fn a_radius_that_reaches_a_rounding_boundary_leaves_the_digits_open() {
        let ball = |midpoint: i64, radius: u64| {
            Ball::new(midpoint.into(), radius.into(), -20, 64) // units of 2^-20, about 9.5e-7
        };
        assert_eq!(ball(1 << 20, 0).decided(3).as_deref(), Some("1.00e0"));
        assert_eq!(ball(1 << 20, 5).decided(5).as_deref(), Some("1.0000e0"));
        // From 1.0000499 to 1.0000516, across 1.00005.
        assert_eq!(ball((1 << 20) + 53, 1).decided(5), None);
        assert_eq!(
            ball((1 << 20) + 55, 1).decided(5).as_deref(),
            Some("1.0001e0")
        );
        assert_eq!(ball(0, 0).decided(5).as_deref(), Some("0"));
        assert_eq!(ball(0, 1).decided(5), None);
        assert_eq!(ball(0, 1).ceiling(), Some(-6));
        assert_eq!(ball(0, 0).ceiling(), None);
        assert_eq!(Ball::unknown(64).decided(5), None);
    }

    #[test]
    fn radii_are_rounded_up() {
        let third = Ball::from(1).with_bits(64) / Ball::from(3);
        assert!(third.radius() > 0.0 && third.radius() < 1e-18);
        assert!(third.holds(&BigRational::new(BigInt::one(), BigInt::from(3))));
        let tiny = Ball::new(BigInt::zero(), BigUint::one(), -2000, 64);
        assert_eq!(tiny.radius(), f64::from_bits(1));
        assert!(Ball::unknown(64).nearest().is_nan());
        assert_eq!(Ball::unknown(64).radius(), f64::INFINITY);
    }
}
