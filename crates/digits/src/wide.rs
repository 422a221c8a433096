//! Binary floats of a fixed size: L limbs of 64 bits, with the schoolbook methods (Knuth, *The Art
//! of Computer Programming* 2, §4.3.1; Brent & Zimmermann 2010, *Modern Computer Arithmetic*, ch. 3).

use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::real::power_of_two;
use crate::{DoubleDouble, Magnitude, Real};

/// ±m·2^e with m in [½, 1) of 64·L bits, L ≥ 2, and |e| ≤ 2^60; or 0; or undefined.
///
/// Every operation errs by less than one unit in the last place: |z − ẑ| ≤ 2^(1−64L)·min(|z|, |ẑ|)
/// for the computed z and the exact ẑ ([`Real::UNIT_LOG2`]), [`Wide::sqrt`] by less than two. The
/// undefined number stands for what has no value or lies out of range: what comes from ±∞, NaN, a
/// division by zero or a root of a negative number, and whatever is computed from it. It compares
/// with nothing, and turns into NaN as a double.
#[derive(Clone, Copy, Debug)]
pub struct Wide<const L: usize> {
    negative: bool,
    exponent: i64,
    /// The least significant first; the top bit is set unless all are 0.
    limbs: [u64; L],
}

/// Beyond it numbers are undefined.
const LIMIT: i64 = 1 << 60;

const TOP: u64 = 1 << 63;

impl<const L: usize> Wide<L> {
    const UNDEFINED: Wide<L> = Wide {
        negative: false,
        exponent: i64::MAX,
        limbs: [0; L],
    };

    #[inline]
    fn new(negative: bool, exponent: i64, limbs: [u64; L]) -> Wide<L> {
        const { assert!(L >= 2) };
        if exponent.unsigned_abs() > LIMIT as u64 {
            return Wide::UNDEFINED;
        }
        Wide {
            negative,
            exponent,
            limbs,
        }
    }

    /// 0 or undefined.
    #[inline]
    fn is_special(&self) -> bool {
        self.exponent.unsigned_abs() > LIMIT as u64
    }

    fn is_undefined(&self) -> bool {
        self.exponent == i64::MAX
    }

    #[cfg(test)]
    pub(crate) fn parts(&self) -> (bool, i64, [u64; L]) {
        (self.negative, self.exponent, self.limbs)
    }

    /// e with |x| < 2^e, the least there is for 0; `None` of the undefined number.
    pub(crate) fn top(&self) -> Option<i64> {
        (!self.is_undefined()).then_some(self.exponent)
    }

    /// Cuts |x|·2^-top < 1 into so many whole numbers below 2^width, the first of weight 2^-width, and what is left below the last of
    /// them; gives each with the sign of x that is not 0.
    pub(crate) fn slices(
        &self,
        top: i64,
        width: u32,
        count: usize,
        mut give: impl FnMut(usize, f64),
    ) {
        if self.is_special() {
            return;
        }
        let limb = |at: i64| match usize::try_from(at) {
            Ok(at) if at < L => self.limbs[L - 1 - at],
            _ => 0,
        };
        let sign = if self.negative { -1.0 } else { 1.0 };
        let before = top.saturating_sub(self.exponent);
        let first = usize::try_from(before / i64::from(width)).unwrap_or(usize::MAX);
        for at in first..count {
            let from = at as i64 * i64::from(width) - before;
            let (place, bits) = (from.div_euclid(64), from.rem_euclid(64));
            let window = limb(place) << bits | limb(place + 1) >> 1 >> (63 - bits);
            let value = window >> (64 - width);
            if value != 0 {
                give(at, sign * value as f64);
            }
        }
    }

    /// Σ digitᵢ·2^(-width·(n + 1 − i)) over i = 0 … n − 1, cut off within a unit; the digits are of any sign, below 2^62 each, and are lost.
    pub(crate) fn from_slices(digits: &mut [i64], width: u32) -> Wide<L> {
        let mask = (1i64 << width) - 1;
        let carried = |digits: &mut [i64], sign: i64| {
            let mut carry = 0;
            for digit in digits.iter_mut() {
                let sum = carry + sign * *digit;
                (*digit, carry) = (sum & mask, sum >> width);
            }
            carry
        };
        let mut top = carried(digits, 1);
        let negative = top < 0;
        if negative {
            top = carried(digits, -1) - top;
        }
        // From the first bit that is set on, into limbs from the highest on.
        let (mut limbs, mut filled, mut exponent) = ([0u64; L], 0, 0);
        let parts = std::iter::once(top).chain(digits.iter().rev().copied());
        for (place, part) in (1..).zip(parts) {
            let part = part as u64;
            let bits = match (filled, part) {
                (0, 0) => continue,
                (0, _) => 64 - part.leading_zeros(),
                _ => width,
            };
            if filled == 0 {
                exponent = i64::from(bits) - place * i64::from(width);
            }
            let (at, used) = (filled / 64, filled % 64);
            if at >= L {
                break;
            }
            let part = part << (64 - bits);
            limbs[L - 1 - at] |= part >> used;
            if used > 0 && at + 1 < L {
                limbs[L - 2 - at] |= part << (64 - used);
            }
            filled += bits as usize;
        }
        match filled {
            0 => Wide::ZERO,
            _ => Wide::new(negative, exponent, limbs),
        }
    }

    /// The same with M limbs: exact for M ≥ L, else cut off, within one unit of the result.
    pub fn resize<const M: usize>(self) -> Wide<M> {
        let mut limbs = [0; M];
        for (to, from) in limbs.iter_mut().rev().zip(self.limbs.iter().rev()) {
            *to = *from;
        }
        Wide {
            negative: self.negative,
            exponent: self.exponent,
            limbs,
        }
    }

    /// √x within two units: Newton's steps from the root in doubles, the last of which adds to its
    /// own rounding at most half the square of the previous error.
    pub fn sqrt(self) -> Wide<L> {
        if self.is_special() {
            return self;
        }
        if self.negative {
            return Wide::UNDEFINED;
        }
        let half = self.exponent.div_euclid(2);
        let fraction = self.scale(-2 * half);
        let mut root = Wide::from(fraction.to_f64().sqrt());
        let mut bits = 52;
        while bits < 64 * L {
            root = (root + fraction / root).scale(-1);
            bits *= 2;
        }
        root.scale(half)
    }

    /// −1, 0 or 1 as |self| is below, at or above |other|, both defined.
    fn compare_size(&self, other: &Wide<L>) -> Ordering {
        let limbs = || self.limbs.iter().rev().cmp(other.limbs.iter().rev());
        self.exponent.cmp(&other.exponent).then_with(limbs)
    }

    /// |a| + |b|·2^-distance, with the sign and exponent of a. What is shifted out of b and, after a
    /// carry, out of the sum, makes less than one unit of the result.
    #[inline]
    fn sum(a: &Wide<L>, b: &Wide<L>, distance: u64) -> Wide<L> {
        let (mut limbs, _) = shift_right(&b.limbs, distance);
        let mut carry = false;
        for (limb, a) in limbs.iter_mut().zip(&a.limbs) {
            let (sum, first) = limb.overflowing_add(*a);
            let (sum, second) = sum.overflowing_add(u64::from(carry));
            (*limb, carry) = (sum, first | second);
        }
        if !carry {
            return Wide::new(a.negative, a.exponent, limbs);
        }
        let (mut limbs, _) = shift_right(&limbs, 1);
        limbs[L - 1] |= TOP;
        Wide::new(a.negative, a.exponent + 1, limbs)
    }

    /// |a| − |b|·2^-distance with the sign of a, for |a| at least as large. One guard limb: up to a
    /// distance of 64 nothing is lost before the final cut, beyond it at most one bit cancels.
    #[inline]
    fn difference(a: &Wide<L>, b: &Wide<L>, distance: u64) -> Wide<L> {
        let (mut limbs, guard) = shift_right(&b.limbs, distance);
        let mut borrow = guard != 0;
        let guard = guard.wrapping_neg();
        for (limb, a) in limbs.iter_mut().zip(&a.limbs) {
            let (rest, first) = a.overflowing_sub(*limb);
            let (rest, second) = rest.overflowing_sub(u64::from(borrow));
            (*limb, borrow) = (rest, first | second);
        }
        if limbs[L - 1] & TOP != 0 {
            return Wide::new(a.negative, a.exponent, limbs);
        }
        let top = limbs.iter().rposition(|limb| *limb != 0);
        let (words, bits) = match top {
            Some(top) => (L - 1 - top, limbs[top].leading_zeros()),
            None if guard == 0 => return Wide::ZERO,
            None => (L, guard.leading_zeros()),
        };
        // Limbs counted from the guard on.
        let at = |k: Option<usize>| match k {
            None => 0,
            Some(0) => guard,
            Some(k) => limbs[k - 1],
        };
        let mut out = [0; L];
        for (i, limb) in out.iter_mut().enumerate() {
            let below = at(i.checked_sub(words));
            *limb = at((i + 1).checked_sub(words)) << bits | below >> 1 >> (63 - bits);
        }
        let lost = (64 * words) as i64 + i64::from(bits);
        Wide::new(a.negative, a.exponent - lost, out)
    }

    /// a + b, for one of them 0 or undefined.
    #[cold]
    fn special_sum(a: Wide<L>, b: Wide<L>) -> Wide<L> {
        if a.is_undefined() || b.is_undefined() {
            Wide::UNDEFINED
        } else if a.is_special() {
            b
        } else {
            a
        }
    }
}

/// The limbs over 2^distance, and the limb below them.
#[inline]
fn shift_right<const L: usize>(limbs: &[u64; L], distance: u64) -> ([u64; L], u64) {
    let (words, bits) = ((distance / 64) as usize, distance % 64);
    let mut out = [0; L];
    if words > L {
        return (out, 0);
    }
    let guard = if words == 0 { 0 } else { limbs[words - 1] };
    let at = |i: usize| if i < L { limbs[i] } else { 0 };
    for (i, limb) in out.iter_mut().enumerate() {
        *limb = at(i + words) >> bits | at(i + words + 1) << 1 << (63 - bits);
    }
    (out, guard >> bits | at(words) << 1 << (63 - bits))
}

impl<const L: usize> Neg for Wide<L> {
    type Output = Wide<L>;

    #[inline]
    fn neg(self) -> Wide<L> {
        Wide {
            negative: !self.negative && !self.is_special(),
            ..self
        }
    }
}

impl<const L: usize> Add for Wide<L> {
    type Output = Wide<L>;

    #[inline]
    fn add(self, other: Wide<L>) -> Wide<L> {
        if self.is_special() || other.is_special() {
            return Wide::special_sum(self, other);
        }
        let swap = self.exponent < other.exponent
            || self.negative != other.negative && self.compare_size(&other) == Ordering::Less;
        let (a, b) = if swap {
            (&other, &self)
        } else {
            (&self, &other)
        };
        let distance = (a.exponent - b.exponent) as u64;
        if a.negative == b.negative {
            Wide::sum(a, b, distance)
        } else {
            Wide::difference(a, b, distance)
        }
    }
}

impl<const L: usize> Sub for Wide<L> {
    type Output = Wide<L>;

    #[inline]
    fn sub(self, other: Wide<L>) -> Wide<L> {
        self + -other
    }
}

impl<const L: usize> Mul for Wide<L> {
    type Output = Wide<L>;

    /// Column by column from the second below the result on, and rounded to nearest: the columns
    /// left out weigh less than L units of the limb below the result, 2^-63·L of its last place.
    #[inline]
    fn mul(self, other: Wide<L>) -> Wide<L> {
        if self.is_special() || other.is_special() {
            let undefined = self.is_undefined() || other.is_undefined();
            return if undefined {
                Wide::UNDEFINED
            } else {
                Wide::ZERO
            };
        }
        let (a, b) = (&self.limbs, &other.limbs);
        let mut limbs = [0; L];
        let mut guard = 0;
        let mut column: u128 = 0;
        for k in L - 2..2 * L - 1 {
            let mut carry = 0;
            let first = (k + 1).saturating_sub(L);
            let (a, b) = (&a[first..=k - first], &b[first..=k - first]);
            for (a, b) in a.iter().zip(b.iter().rev()) {
                let (sum, over) = column.overflowing_add(u128::from(*a) * u128::from(*b));
                column = sum;
                carry += u128::from(over);
            }
            match k.checked_sub(L) {
                Some(place) => limbs[place] = column as u64,
                None => guard = column as u64,
            }
            column = column >> 64 | carry << 64;
        }
        limbs[L - 1] = column as u64;
        let mut exponent = self.exponent + other.exponent;
        if limbs[L - 1] & TOP == 0 {
            for i in (1..L).rev() {
                limbs[i] = limbs[i] << 1 | limbs[i - 1] >> 63;
            }
            limbs[0] = limbs[0] << 1 | guard >> 63;
            guard <<= 1;
            exponent -= 1;
        }
        let mut carry = guard & TOP != 0;
        for limb in &mut limbs {
            if !carry {
                break;
            }
            (*limb, carry) = limb.overflowing_add(1);
        }
        if carry {
            limbs[L - 1] = TOP;
            exponent += 1;
        }
        Wide::new(self.negative != other.negative, exponent, limbs)
    }
}

impl<const L: usize> Div for Wide<L> {
    type Output = Wide<L>;

    /// Long division, cut off. The dividend, halved where it is not below the divisor, leaves a
    /// quotient in [½, 1).
    fn div(self, other: Wide<L>) -> Wide<L> {
        if self.is_special() || other.is_special() {
            let undefined = self.is_undefined() || other.is_special();
            return if undefined {
                Wide::UNDEFINED
            } else {
                Wide::ZERO
            };
        }
        let divisor = &other.limbs;
        let mut exponent = self.exponent - other.exponent;
        let (mut rest, mut next) = (self.limbs, 0);
        if rest.iter().rev().ge(divisor.iter().rev()) {
            (rest, next) = shift_right(&rest, 1);
            exponent += 1;
        }
        let mut limbs = [0; L];
        for limb in limbs.iter_mut().rev() {
            *limb = divide_step(&mut rest, next, divisor);
            next = 0;
        }
        Wide::new(self.negative != other.negative, exponent, limbs)
    }
}

/// One digit of the quotient: ⌊(rest·2^64 + next)/divisor⌋, leaving the remainder in `rest`, for
/// rest < divisor and the divisor's top bit set. The digit guessed from the leading limbs is at
/// most 2 too large.
fn divide_step<const L: usize>(rest: &mut [u64; L], next: u64, divisor: &[u64; L]) -> u64 {
    let lead = u128::from(rest[L - 1]) << 64 | u128::from(rest[L - 2]);
    let mut digit = (lead / u128::from(divisor[L - 1])).min(u128::from(u64::MAX)) as u64;
    let mut above = rest[L - 1];
    rest.copy_within(0..L - 1, 1);
    rest[0] = next;
    let mut carry = 0;
    for (r, d) in rest.iter_mut().zip(divisor) {
        let product = u128::from(digit) * u128::from(*d) + u128::from(carry);
        let (difference, borrow) = r.overflowing_sub(product as u64);
        *r = difference;
        carry = (product >> 64) as u64 + u64::from(borrow);
    }
    let mut negative = above < carry;
    above = above.wrapping_sub(carry);
    while negative {
        digit -= 1;
        let mut carry = false;
        for (r, d) in rest.iter_mut().zip(divisor) {
            let (sum, first) = r.overflowing_add(*d);
            let (sum, second) = sum.overflowing_add(u64::from(carry));
            (*r, carry) = (sum, first | second);
        }
        let (sum, over) = above.overflowing_add(u64::from(carry));
        (above, negative) = (sum, !over);
    }
    digit
}

impl<const L: usize> PartialEq for Wide<L> {
    fn eq(&self, other: &Wide<L>) -> bool {
        self.partial_cmp(other) == Some(Ordering::Equal)
    }
}

impl<const L: usize> PartialOrd for Wide<L> {
    fn partial_cmp(&self, other: &Wide<L>) -> Option<Ordering> {
        if self.is_undefined() || other.is_undefined() {
            return None;
        }
        Some(match (self.negative, other.negative) {
            (false, false) => self.compare_size(other),
            (true, true) => other.compare_size(self),
            (false, true) => Ordering::Greater,
            (true, false) => Ordering::Less,
        })
    }
}

/// Exactly; undefined for ±∞ and NaN.
impl<const L: usize> From<f64> for Wide<L> {
    fn from(x: f64) -> Wide<L> {
        if x == 0.0 {
            return Wide::ZERO;
        }
        if !x.is_finite() {
            return Wide::UNDEFINED;
        }
        let (biased, fraction) = (x.to_bits() >> 52 & 0x7ff, x.to_bits() & ((1 << 52) - 1));
        let integer = if biased == 0 {
            fraction
        } else {
            fraction | 1 << 52
        };
        let lead = integer.leading_zeros();
        let mut limbs = [0; L];
        limbs[L - 1] = integer << lead;
        let exponent = biased.max(1) as i64 - 1075 + 64 - i64::from(lead);
        Wide::new(x < 0.0, exponent, limbs)
    }
}

/// Within one unit, and exactly if the parts fit; undefined for what is not finite.
impl<const L: usize> From<DoubleDouble> for Wide<L> {
    fn from(x: DoubleDouble) -> Wide<L> {
        Wide::from(x.high()) + Wide::from(x.low())
    }
}

impl<const L: usize> Real for Wide<L> {
    const ZERO: Wide<L> = Wide {
        negative: false,
        exponent: i64::MIN,
        limbs: [0; L],
    };

    const ONE: Wide<L> = {
        let mut limbs = [0; L];
        limbs[L - 1] = TOP;
        Wide {
            negative: false,
            exponent: 1,
            limbs,
        }
    };

    const UNIT_LOG2: i32 = 1 - 64 * L as i32;

    fn sqrt(self) -> Wide<L> {
        Wide::sqrt(self)
    }

    fn matrix_product(shape: [usize; 3], a: &[Wide<L>], b: &[Wide<L>]) -> Option<Vec<Wide<L>>> {
        crate::slices::product(shape, a, b)
    }

    fn floor() -> Magnitude {
        Magnitude::ZERO
    }

    fn to_f64(self) -> f64 {
        if self.is_special() {
            return if self.is_undefined() { f64::NAN } else { 0.0 };
        }
        let sign = u64::from(self.negative) << 63;
        if self.exponent > 1024 {
            return f64::from_bits(sign | f64::INFINITY.to_bits());
        }
        // 53 bits are kept of a normal number, as many as lie above 2^-1074 of a subnormal one.
        let cut = 11 + (-1021 - self.exponent).max(0);
        if cut > 64 {
            return f64::from_bits(sign);
        }
        let lead = u128::from(self.limbs[L - 1]);
        let (kept, rest) = ((lead >> cut) as u64, lead & ((1 << cut) - 1));
        let half = 1 << (cut - 1);
        let more = self.limbs[..L - 1].iter().any(|limb| *limb != 0);
        let up = rest > half || rest == half && (more || kept & 1 == 1);
        // The leading bit of a normal number adds one to the exponent, as does a carry.
        let biased = (self.exponent + 1021).max(0) as u64;
        f64::from_bits(sign | ((biased << 52) + kept + u64::from(up)))
    }

    fn is_finite(self) -> bool {
        !self.is_undefined()
    }

    #[inline]
    fn magnitude(self) -> Magnitude {
        if self.is_special() {
            return if self.is_undefined() {
                Magnitude::INFINITY
            } else {
                Magnitude::ZERO
            };
        }
        let blocks = (self.exponent + 255).div_euclid(512);
        let power = power_of_two(self.exponent - 512 * blocks - 64);
        Magnitude::new(self.limbs[L - 1] as f64 * power, blocks)
    }

    #[inline]
    fn scale(self, power: i64) -> Wide<L> {
        if self.is_special() {
            return self;
        }
        let exponent = self.exponent.saturating_add(power);
        Wide::new(self.negative, exponent, self.limbs)
    }

    fn abs(self) -> Wide<L> {
        Wide {
            negative: false,
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rational::{Exact, dyadic, integer};
    use num_bigint::BigInt;
    use num_rational::BigRational;
    use num_traits::Signed;
    use proptest::prelude::*;

    /// Limbs with long runs of equal bits, where carries and borrows run far.
    fn any_limb() -> impl Strategy<Value = u64> {
        prop_oneof![
            any::<u64>(),
            Just(0),
            Just(u64::MAX),
            Just(TOP),
            Just(1),
            (0..64u32).prop_map(|k| u64::MAX << k),
            (0..64u32).prop_map(|k| u64::MAX >> k),
        ]
    }

    fn any_wide<const L: usize>(reach: i64) -> impl Strategy<Value = Wide<L>> {
        let limbs = prop::array::uniform::<_, L>(any_limb());
        (any::<bool>(), -reach..=reach, limbs).prop_map(|(negative, exponent, mut limbs)| {
            limbs[L - 1] |= TOP;
            Wide::new(negative, exponent, limbs)
        })
    }

    fn unit<const L: usize>(units: u32) -> BigRational {
        integer(BigInt::from(units), i64::from(Wide::<L>::UNIT_LOG2))
    }

    fn assert_close<const L: usize>(
        computed: Wide<L>,
        truth: &BigRational,
    ) -> Result<(), TestCaseError> {
        let computed = computed.exact();
        let size = computed.abs().min(truth.abs());
        prop_assert!((computed - truth).abs() <= unit::<L>(1) * size);
        Ok(())
    }

    fn assert_operations<const L: usize>(a: Wide<L>, b: Wide<L>) -> Result<(), TestCaseError> {
        let (x, y) = (a.exact(), b.exact());
        assert_close(a + b, &(&x + &y))?;
        assert_close(a - b, &(&x - &y))?;
        assert_close(a * b, &(&x * &y))?;
        assert_close(a / b, &(&x / &y))?;
        prop_assert_eq!(a.partial_cmp(&b), x.partial_cmp(&y));
        let root = a.abs().sqrt().exact();
        prop_assert!((&root * &root - x.abs()).abs() <= unit::<L>(4) * x.abs());
        let magnitude = a.magnitude();
        prop_assert!(magnitude.above().log2() < a.exponent as f64 + 1e-9);
        prop_assert!(magnitude.log2() > a.exponent as f64 - 1.0 - 1e-9);
        Ok(())
    }

    /// b, and what cancels with a, in the sum or but for a few bits.
    fn partners<const L: usize>(a: Wide<L>, b: Wide<L>, low: u64, shift: i64) -> [Wide<L>; 4] {
        let mut near = a;
        near.limbs[0] ^= low;
        [b, near, near.scale(shift), a.scale(shift)]
    }

    proptest! {
        #[test]
        fn operations_stay_within_a_unit_of_192_bits(
            a in any_wide::<3>(300), b in any_wide::<3>(300), low in any_limb(), shift in -2..3i64,
        ) {
            for b in partners(a, b, low, shift) {
                assert_operations(a, b)?;
            }
        }

        #[test]
        fn operations_stay_within_a_unit_of_256_bits(
            a in any_wide::<4>(5), b in any_wide::<4>(5), low in any_limb(), shift in -70..70i64,
        ) {
            for b in partners(a, b, low, shift) {
                assert_operations(a, b)?;
            }
        }

        #[test]
        fn operations_stay_within_a_unit_of_1024_bits(
            a in any_wide::<16>(1100), b in any_wide::<16>(1100), low in any_limb(), shift in -2..3i64,
        ) {
            for b in partners(a, b, low, shift) {
                assert_operations(a, b)?;
            }
        }

        #[test]
        fn doubles_go_in_exactly_and_come_back(bits in any::<u64>()) {
            let x = f64::from_bits(bits);
            let wide = Wide::<3>::from(x);
            prop_assert_eq!(wide.is_finite(), x.is_finite());
            if x.is_finite() {
                prop_assert_eq!(wide.exact(), dyadic(x, 0));
                prop_assert_eq!(wide.to_f64(), x);
                prop_assert_eq!(wide.resize::<8>().exact(), dyadic(x, 0));
            }
        }

        #[test]
        fn to_double_rounds_to_nearest_even(bits in any::<u64>(), part in 0..9u32, low in any::<bool>(), sign in any::<bool>()) {
            // Between a double and its upper neighbour, and a hair above or below that point.
            let x = f64::from_bits(bits).abs();
            prop_assume!(x < f64::MAX);
            let step = Wide::<4>::from(x.next_up()) - Wide::from(x);
            let point = Wide::from(x) + step * Wide::from(f64::from(part)) * Wide::from(0.125);
            let hair = step.scale(-100);
            let even = |x: f64| x.to_bits() & 1 == 0;
            let exact = match part {
                0..4 => x,
                4 if even(x) => x,
                _ => x.next_up(),
            };
            let beyond = match (part, low) {
                (4, true) => x,
                (4, false) => x.next_up(),
                _ => exact,
            };
            let aside = if low { point - hair } else { point + hair };
            let turn = |w: Wide<4>| if sign { -(-w).to_f64() } else { w.to_f64() };
            prop_assert_eq!(turn(point), exact);
            prop_assert_eq!(turn(aside), beyond);
        }
    }

    #[test]
    fn doubles_end_where_they_should() {
        let wide = |x: f64| Wide::<4>::from(x);
        let half_step = wide(f64::MAX) - wide(f64::MAX.next_down());
        let border = wide(f64::MAX) + half_step.scale(-1);
        assert_eq!(border.to_f64(), f64::INFINITY);
        assert_eq!((border - wide(1e250)).to_f64(), f64::MAX);
        assert_eq!((-border.scale(5000)).to_f64(), f64::NEG_INFINITY);
        let least = wide(f64::from_bits(1));
        assert_eq!(least.scale(-1).to_f64(), 0.0);
        assert_eq!(
            (least.scale(-1) + least.scale(-150)).to_f64(),
            f64::from_bits(1)
        );
        assert_eq!(least.scale(-5000).to_f64(), 0.0);
    }

    #[test]
    fn far_apart_the_larger_stays() {
        let large = Wide::<4>::from(1.5).scale(1 << 59);
        let small = Wide::<4>::from(1.25).scale(-(1 << 59));
        assert_eq!(large + small, large);
        assert_eq!(small - large, -large);
        assert_eq!(large * small, Wide::from(1.875));
        assert_eq!(large - large, Wide::ZERO);
        assert!(-large < -small && -small < Wide::ZERO && Wide::ZERO < small && small < large);
    }

    #[test]
    fn what_has_no_value_stays_undefined() {
        let (zero, one) = (Wide::<3>::ZERO, Wide::<3>::ONE);
        let nothing = one / zero;
        let outside = one.scale(LIMIT - 1);
        for undefined in [
            nothing,
            zero / zero,
            nothing + one,
            zero - nothing,
            nothing * zero,
            zero / nothing,
            nothing / nothing,
            -nothing,
            nothing.abs(),
            nothing.sqrt(),
            (-one).sqrt(),
            Wide::from(f64::NEG_INFINITY),
            outside * outside,
            one / outside / outside,
            outside + outside,
            outside.scale(i64::MAX),
            (one / outside).scale(i64::MIN),
        ] {
            assert!(!undefined.is_finite() && undefined.to_f64().is_nan());
            assert_eq!(undefined.partial_cmp(&undefined), None);
            assert_eq!(undefined.magnitude(), Magnitude::INFINITY);
        }
        assert!(outside.is_finite());
        assert_eq!(-zero, zero);
    }

    #[test]
    fn root_of_two_to_4096_bits() {
        let two = Wide::<64>::from(2.0);
        let root = two.sqrt();
        let rest = (root * root - two).abs();
        assert!(rest.magnitude() <= Magnitude::power_of_two(-4091));
        assert_eq!(root.to_f64(), std::f64::consts::SQRT_2);
    }
}
