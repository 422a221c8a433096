//! Numbers of about 106 bits as the unevaluated sum of two doubles (Dekker 1971, *Numer. Math.* 18;
//! error-free transformations as in Ogita, Rump & Oishi 2005, *SIAM J. Sci. Comput.* 26).

use std::cmp::Ordering;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// `high + low` with |low| ≤ ½ ulp(high). Addition and subtraction are accurate to 2^-104 of the
/// *result* (no loss by cancellation beyond that of the operands), products and quotients to
/// 2^-102, as long as nothing overflows and error terms stay above 2^-1022.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DoubleDouble {
    high: f64,
    low: f64,
}

/// a + b as sum and error, for any order of magnitudes.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

/// a + b as sum and error, for |a| ≥ |b| or a = 0.
fn quick_two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// a·b as product and error.
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    (product, a.mul_add(b, -product))
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
    pub fn new(high: f64, low: f64) -> DoubleDouble {
        let (high, low) = two_sum(high, low);
        DoubleDouble { high, low }
    }

    /// The product of two doubles, exactly (unless its error term underflows).
    pub fn product(a: f64, b: f64) -> DoubleDouble {
        let (high, low) = two_product(a, b);
        DoubleDouble { high, low }
    }

    /// The double nearest to the number.
    pub fn high(self) -> f64 {
        self.high
    }

    /// What `high` leaves.
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

    /// √x; NaN for negative x (Karp's trick, one Newton step).
    pub fn sqrt(self) -> DoubleDouble {
        if self.high == 0.0 {
            return DoubleDouble::ZERO;
        }
        let root = self.high.sqrt();
        let rest = self - DoubleDouble::product(root, root);
        let (high, low) = quick_two_sum(root, rest.high / (2.0 * root));
        DoubleDouble { high, low }
    }
}

impl From<f64> for DoubleDouble {
    fn from(high: f64) -> DoubleDouble {
        DoubleDouble { high, low: 0.0 }
    }
}

impl Neg for DoubleDouble {
    type Output = DoubleDouble;

    fn neg(self) -> DoubleDouble {
        DoubleDouble {
            high: -self.high,
            low: -self.low,
        }
    }
}

impl Add for DoubleDouble {
    type Output = DoubleDouble;

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

    fn add(self, other: f64) -> DoubleDouble {
        self + DoubleDouble::from(other)
    }
}

impl Sub for DoubleDouble {
    type Output = DoubleDouble;

    fn sub(self, other: DoubleDouble) -> DoubleDouble {
        self + -other
    }
}

impl AddAssign for DoubleDouble {
    fn add_assign(&mut self, other: DoubleDouble) {
        *self = *self + other;
    }
}

impl SubAssign for DoubleDouble {
    fn sub_assign(&mut self, other: DoubleDouble) {
        *self = *self - other;
    }
}

impl Mul for DoubleDouble {
    type Output = DoubleDouble;

    fn mul(self, other: DoubleDouble) -> DoubleDouble {
        let (high, error) = two_product(self.high, other.high);
        let cross = self.high * other.low + self.low * other.high;
        let (high, low) = quick_two_sum(high, error + cross);
        DoubleDouble { high, low }
    }
}

impl Mul<f64> for DoubleDouble {
    type Output = DoubleDouble;

    fn mul(self, other: f64) -> DoubleDouble {
        self * DoubleDouble::from(other)
    }
}

impl Div for DoubleDouble {
    type Output = DoubleDouble;

    fn div(self, other: DoubleDouble) -> DoubleDouble {
        let first = self.high / other.high;
        let rest = self - other * first;
        let second = rest.high / other.high;
        let rest = rest - other * second;
        let (high, low) = quick_two_sum(first, second);
        DoubleDouble { high, low } + rest.high / other.high
    }
}

impl PartialOrd for DoubleDouble {
    fn partial_cmp(&self, other: &DoubleDouble) -> Option<Ordering> {
        match self.high.partial_cmp(&other.high) {
            Some(Ordering::Equal) => self.low.partial_cmp(&other.low),
            order => order,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integers below 2^105 as exact witnesses.
    fn from_integer(value: i128) -> DoubleDouble {
        let high = value as f64;
        DoubleDouble::new(high, (value - high as i128) as f64)
    }

    #[test]
    fn two_pi_is_two_pi() {
        // 2π to 33 digits is 6.28318530717958647692528676655900577.
        let milli = DoubleDouble::TAU * 1e16 - DoubleDouble::from(62831853071795864.0);
        assert!((milli.to_f64() - 0.769_252_867_665_590_06).abs() < 1e-14);
    }

    proptest::proptest! {
        #[test]
        fn sums_are_exact_where_they_fit(a in -(1i128 << 100)..(1i128 << 100), b in -(1i128 << 100)..(1i128 << 100)) {
            let sum = from_integer(a) + from_integer(b);
            proptest::prop_assert_eq!(sum, from_integer(a + b));
        }

        #[test]
        fn quotient_times_divisor_gives_back(a in -1e100..1e100f64, b in 1e-100..1e100f64, low in -0.5..0.5f64) {
            let divisor = DoubleDouble::new(b, b * 1e-17 * low);
            let back = DoubleDouble::from(a) / divisor * divisor - DoubleDouble::from(a);
            proptest::prop_assert!(back.to_f64().abs() <= 2f64.powi(-100) * a.abs());
        }

        #[test]
        fn root_squared_gives_back(a in 1e-100..1e100f64) {
            let root = DoubleDouble::from(a).sqrt();
            proptest::prop_assert!((root * root - DoubleDouble::from(a)).to_f64().abs() <= 2f64.powi(-100) * a);
        }
    }
}
