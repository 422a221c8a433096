//! Numbers of about 106 bits as the unevaluated sum of two doubles (Dekker 1971, *Numer. Math.* 18),
//! by the algorithms whose bounds are proved in Joldes, Muller & Popescu 2017, *ACM Trans. Math.
//! Softw.* 44(2), "Tight and rigorous error bounds for basic building blocks of double-word
//! arithmetic" (JMP), corrected and checked in Coq by Muller & Rideau 2022, *ACM Trans. Math.
//! Softw.* 48(1) (MR). With u = 2^-53:
//!
//! | operation | algorithm | relative error |
//! |---|---|---|
//! | + − | JMP 6, AccurateDWPlusDW | 3u²/(1 − 4u) |
//! | · | JMP 10, DWTimesDW1 | 7u² (JMP), 5u² (MR) |
//! | · by a double | JMP 8, DWTimesFP2 | 3u² |
//! | / | JMP 17, DWDivDW2 | 15u² + 56u³ |
//! | √ | SQRTDWtoDW of Lefèvre et al. 2023, *ACM Trans. Math. Softw.* 49(1) | 25/8 u² |
//!
//! All are below 16u² = 2^-102, the unit of [`Real`].

use std::cmp::Ordering;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Range, Sub, SubAssign};

use crate::multiples::add_multiples;
use crate::{Magnitude, Real};

/// `high + low` with |low| ≤ ½ ulp(high). Every operation errs by less than 2^-102 of the *result*
/// (a difference does not lose more by cancellation than its operands had lost). Where error terms
/// underflow, products and quotients err by up to 2^-1060 in addition. What overflows becomes
/// infinite or NaN, and so does what is computed from it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DoubleDouble {
    high: f64,
    low: f64,
}

/// Doubles with the same sum, most often fewer, and none where it is 0; not finite where it leaves their range (Shewchuk 1997,
/// *Discrete Comput. Geom.* 18, section 2.4).
///
/// ```
/// use eigentone_digits::parts;
///
/// assert_eq!(parts(&[0.1, -0.1]), []);
/// assert_eq!(parts(&[16_812.0, 190_000.0, 0.5]), [206_812.5]);
/// assert_eq!(parts(&[1.0, 1e-40]), [1.0, 1e-40]);
/// assert_eq!(parts(&[1e300, 1.0, -1e300]), [1.0]);
/// ```
pub fn parts(terms: &[f64]) -> Vec<f64> {
    let mut parts: Vec<f64> = Vec::new();
    for &term in terms {
        let mut rest = term;
        for part in &mut parts {
            (*part, rest) = two_sum(*part, rest);
        }
        parts.push(rest);
        parts.retain(|part| *part != 0.0);
    }
    parts
}

/// a + b as sum and error, for any order of magnitudes.
#[inline]
pub(crate) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

/// a + b as sum and error, for |a| ≥ |b| or a = 0.
#[inline]
fn quick_two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// a·b as product and error: exactly, if the last bit of the product is at least 2^-1074.
#[inline]
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    if cfg!(target_feature = "fma") {
        return (product, a.mul_add(b, -product));
    }
    // Dekker's product: the function that stands in for the instruction is five times slower.
    let ((a1, a2), (b1, b2)) = (split(a), split(b));
    let error = ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2;
    if error.is_finite() {
        (product, error)
    } else {
        (product, fused_error(a, b, product))
    }
}

/// The error of a product where the splitting overflows, above 2^996. Without an instruction for it this costs as much as
/// ten products, and compilers would compute it for every product if it were part of the caller.
#[cold]
#[inline(never)]
fn fused_error(a: f64, b: f64, product: f64) -> f64 {
    a.mul_add(b, -product)
}

/// Two halves of at most 26 bits (Veltkamp's splitting).
#[inline]
pub(crate) fn split(a: f64) -> (f64, f64) {
    let scaled = a * 134_217_729.0;
    let high = scaled - (scaled - a);
    (high, a - high)
}

impl DoubleDouble {
    /// 0.
    pub const ZERO: DoubleDouble = DoubleDouble {
        high: 0.0,
        low: 0.0,
    };

    /// 2π.
    pub const TAU: DoubleDouble = DoubleDouble {
        high: std::f64::consts::TAU,
        low: 2.449_293_598_294_706_4e-16,
    };

    /// The sum of two doubles, exactly.
    #[inline]
    pub fn new(high: f64, low: f64) -> DoubleDouble {
        let (high, low) = two_sum(high, low);
        DoubleDouble { high, low }
    }

    /// The product, given how two doubles are multiplied exactly.
    #[inline(always)]
    pub(crate) fn times(
        self,
        other: DoubleDouble,
        two_product: impl Fn(f64, f64) -> (f64, f64),
    ) -> DoubleDouble {
        let (high, error) = two_product(self.high, other.high);
        let cross = self.high * other.low + self.low * other.high;
        let (high, low) = quick_two_sum(high, error + cross);
        DoubleDouble { high, low }
    }

    /// The product of two doubles, exactly (unless its error term underflows).
    #[inline]
    pub fn product(a: f64, b: f64) -> DoubleDouble {
        let (high, low) = two_product(a, b);
        DoubleDouble { high, low }
    }

    /// The double nearest to the number.
    #[inline]
    pub fn high(self) -> f64 {
        self.high
    }

    /// What `high` leaves.
    #[inline]
    pub fn low(self) -> f64 {
        self.low
    }

    /// The double nearest to the number.
    pub fn to_f64(self) -> f64 {
        self.high
    }

    /// |x|.
    pub fn abs(self) -> DoubleDouble {
        if self.high < 0.0 { -self } else { self }
    }

    /// √x; NaN for negative x.
    pub fn sqrt(self) -> DoubleDouble {
        if self.high == 0.0 {
            return DoubleDouble::ZERO;
        }
        if self.high.abs() < DIVIDES.start {
            return self.scale(600).sqrt().scale(-300);
        }
        let root = self.high.sqrt();
        let (square, error) = two_product(root, root);
        let rest = (self.high - square - error) + self.low;
        let (high, low) = quick_two_sum(root, rest / (2.0 * root));
        DoubleDouble { high, low }
    }

    /// x·2^power. The low part may lose bits below 2^-1074.
    fn scale(self, power: i64) -> DoubleDouble {
        DoubleDouble {
            high: self.high.scale(power),
            low: self.low.scale(power),
        }
    }
}

/// Where no error term of a division or a root underflows.
const DIVIDES: Range<f64> = f64::from_bits((1023 - 500) << 52)..f64::from_bits((1023 + 500) << 52);

impl From<f64> for DoubleDouble {
    #[inline]
    fn from(high: f64) -> DoubleDouble {
        DoubleDouble { high, low: 0.0 }
    }
}

impl Neg for DoubleDouble {
    type Output = DoubleDouble;

    #[inline]
    fn neg(self) -> DoubleDouble {
        DoubleDouble {
            high: -self.high,
            low: -self.low,
        }
    }
}

impl Add for DoubleDouble {
    type Output = DoubleDouble;

    #[inline]
    fn add(self, other: DoubleDouble) -> DoubleDouble {
        let (high, error) = two_sum(self.high, other.high);
        let (low, rest) = two_sum(self.low, other.low);
        let (high, error) = quick_two_sum(high, error + low);
        let (high, low) = quick_two_sum(high, error + rest);
        DoubleDouble { high, low }
    }
}

impl Add<f64> for DoubleDouble {
    type Output = DoubleDouble;

    #[inline]
    fn add(self, other: f64) -> DoubleDouble {
        self + DoubleDouble::from(other)
    }
}

impl Sub for DoubleDouble {
    type Output = DoubleDouble;

    #[inline]
    fn sub(self, other: DoubleDouble) -> DoubleDouble {
        self + -other
    }
}

impl AddAssign for DoubleDouble {
    #[inline]
    fn add_assign(&mut self, other: DoubleDouble) {
        *self = *self + other;
    }
}

impl SubAssign for DoubleDouble {
    #[inline]
    fn sub_assign(&mut self, other: DoubleDouble) {
        *self = *self - other;
    }
}

impl Mul for DoubleDouble {
    type Output = DoubleDouble;

    #[inline]
    fn mul(self, other: DoubleDouble) -> DoubleDouble {
        self.times(other, two_product)
    }
}

impl Mul<f64> for DoubleDouble {
    type Output = DoubleDouble;

    #[inline]
    fn mul(self, other: f64) -> DoubleDouble {
        self.mul_f64(other)
    }
}

impl Div for DoubleDouble {
    type Output = DoubleDouble;

    fn div(self, other: DoubleDouble) -> DoubleDouble {
        let divides = |x: DoubleDouble| DIVIDES.contains(&x.high.abs());
        if !(divides(self) && divides(other)) {
            return scaled_quotient(self, other);
        }
        let first = self.high / other.high;
        // The product is JMP 7, DWTimesFP1, for which the bound is proved.
        let (product, error) = two_product(other.high, first);
        let (high, low) = quick_two_sum(product, other.low * first);
        let (high, low) = quick_two_sum(high, low + error);
        let rest = (self.high - high) + (self.low - low);
        let (high, low) = quick_two_sum(first, rest / other.high);
        DoubleDouble { high, low }
    }
}

/// The quotient by way of one near 1; NaN for a division by 0 or of what is not finite.
#[cold]
fn scaled_quotient(a: DoubleDouble, b: DoubleDouble) -> DoubleDouble {
    if b.high == 0.0 || !Real::is_finite(a) || !Real::is_finite(b) {
        return DoubleDouble::from(f64::NAN);
    }
    if a.high == 0.0 {
        return DoubleDouble::ZERO;
    }
    let (above, below) = (a.magnitude().exponent(), b.magnitude().exponent());
    (a.scale(-above) / b.scale(-below)).scale(above - below)
}

impl PartialOrd for DoubleDouble {
    fn partial_cmp(&self, other: &DoubleDouble) -> Option<Ordering> {
        match self.high.partial_cmp(&other.high) {
            Some(Ordering::Equal) => self.low.partial_cmp(&other.low),
            order => order,
        }
    }
}

impl Real for DoubleDouble {
    const ZERO: DoubleDouble = DoubleDouble::ZERO;
    const ONE: DoubleDouble = DoubleDouble {
        high: 1.0,
        low: 0.0,
    };
    const UNIT_LOG2: i32 = -102;

    /// An underflow costs each of the seven products of an error term half of 2^-1074, and rounding
    /// their sum to 53 bits as much again.
    fn sqrt(self) -> DoubleDouble {
        DoubleDouble::sqrt(self)
    }

    fn floor() -> Magnitude {
        Magnitude::power_of_two(-1060)
    }

    fn to_f64(self) -> f64 {
        self.high
    }

    fn is_finite(self) -> bool {
        self.high.is_finite() && self.low.is_finite()
    }

    #[inline]
    fn magnitude(self) -> Magnitude {
        if self.is_finite() {
            Magnitude::from(self.high)
        } else {
            Magnitude::INFINITY
        }
    }

    fn scale(self, power: i64) -> DoubleDouble {
        DoubleDouble::scale(self, power)
    }

    fn add_multiples(sum: &mut [DoubleDouble], terms: &[(DoubleDouble, &[DoubleDouble])]) {
        add_multiples(sum, terms);
    }

    #[inline]
    fn mul_f64(self, factor: f64) -> DoubleDouble {
        let (high, error) = two_product(self.high, factor);
        let (high, low) = quick_two_sum(high, error + self.low * factor);
        DoubleDouble { high, low }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rational::{Exact, dyadic};
    use num_rational::BigRational;
    use num_traits::Signed;
    use proptest::prelude::*;

    /// Integers below 2^105 as exact witnesses.
    fn from_integer(value: i128) -> DoubleDouble {
        let high = value as f64;
        DoubleDouble::new(high, (value - high as i128) as f64)
    }

    #[test]
    fn two_pi_is_two_pi() {
        // 2π to 33 digits is 6.28318530717958647692528676655900577.
        let milli = DoubleDouble::TAU * 1e16 - DoubleDouble::from(62831853071795864.0);
        assert!((milli.to_f64() - 0.769_252_867_665_590_1).abs() < 1e-14);
    }

    /// |computed − truth| ≤ units·u²·min(|computed|, |truth|) + floor.
    fn assert_close(
        computed: DoubleDouble,
        truth: &BigRational,
        units: f64,
        floor: bool,
    ) -> Result<(), TestCaseError> {
        if !Real::is_finite(computed) {
            return prop_assert_overflow(truth);
        }
        let computed = computed.exact();
        let size = computed.abs().min(truth.abs());
        let floor = if floor {
            dyadic(1.0, -1060)
        } else {
            dyadic(0.0, 0)
        };
        prop_assert!((computed - truth).abs() <= dyadic(units, -106) * size + floor);
        Ok(())
    }

    /// Only what is near the end of the doubles may leave them.
    fn prop_assert_overflow(truth: &BigRational) -> Result<(), TestCaseError> {
        prop_assert!(truth.abs() > dyadic(1.0, 1022));
        Ok(())
    }

    fn assert_operations(a: DoubleDouble, b: DoubleDouble) -> Result<(), TestCaseError> {
        let (x, y) = (a.exact(), b.exact());
        let cubic = 56.0 * 2f64.powi(-53);
        assert_close(a + b, &(&x + &y), 3.0 + cubic, false)?;
        assert_close(a - b, &(&x - &y), 3.0 + cubic, false)?;
        assert_close(a * b, &(&x * &y), 5.0 + cubic, true)?;
        assert_close(a * b.high, &(&x * dyadic(b.high, 0)), 3.0 + cubic, true)?;
        assert_close(a / b, &(&x / &y), 15.0 + 2.0 * cubic, true)?;
        let root = a.abs().sqrt().exact();
        let error = &root * &root - x.abs();
        prop_assert!(error.abs() <= dyadic(6.26, -106) * x.abs());
        Ok(())
    }

    prop_compose! {
        fn any_double(reach: i64)(fraction in prop_oneof![Just(1.0), 1.0..2.0f64, Just(2.0 - f64::EPSILON)], sign in any::<bool>(), power in -reach..reach) -> f64 {
            let size = Real::scale(fraction, power);
            if sign { -size } else { size }
        }
    }

    prop_compose! {
        fn any_double_double(reach: i64)(high in any_double(reach), low in -0.5..=0.5f64, gap in prop_oneof![Just(53i64), 53..120i64]) -> DoubleDouble {
            DoubleDouble::new(high, Real::scale(high, -gap) * 2.0 * low)
        }
    }

    proptest! {
            #[test]
            fn operations_keep_their_bounds(
                a in prop_oneof![any_double_double(40), any_double_double(1023)],
                b in prop_oneof![any_double_double(40), any_double_double(1023)],
                low in -1.0..1.0f64, ulps in -3..4i64,
            ) {
                let tilt = Real::scale(a.high, -52) * ulps as f64;
                let near = DoubleDouble::new(a.high + tilt, a.low * low);
                for b in [b, near, DoubleDouble::from(b.high), DoubleDouble::new(a.high, -a.low)] {
                    assert_operations(a, b)?;
                }
            }

            #[test]
    fn products_of_doubles_are_exact(a in any_double(1023), b in any_double(1), sum in -966i64..1021) {
                let power = (sum - a.magnitude().exponent()).clamp(-1021, 1021);
                let b = Real::scale(b, power);
                prop_assert_eq!(DoubleDouble::product(a, b).exact(), dyadic(a, 0) * dyadic(b, 0));
            }
        }

    #[test]
    fn out_of_range_stays_out_of_range() {
        let (large, one) = (DoubleDouble::from(f64::MAX), DoubleDouble::from(1.0));
        let nothing = large * large;
        for outside in [
            nothing,
            large + large,
            large - nothing,
            nothing * DoubleDouble::ZERO,
            nothing / one,
            one / DoubleDouble::ZERO,
            DoubleDouble::ZERO / DoubleDouble::ZERO,
            large / DoubleDouble::from(0.5),
            (-one).sqrt(),
            DoubleDouble::from(-1e-300).sqrt(),
        ] {
            assert!(!Real::is_finite(outside));
            assert_eq!(outside.magnitude(), Magnitude::INFINITY);
        }
    }

    proptest! {
        #[test]
        fn sums_are_exact_where_they_fit(a in -(1i128 << 100)..(1i128 << 100), b in -(1i128 << 100)..(1i128 << 100)) {
            let sum = from_integer(a) + from_integer(b);
            prop_assert_eq!(sum, from_integer(a + b));
        }
    }
}
