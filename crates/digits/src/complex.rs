//! Complex numbers with double-double parts.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

use crate::DoubleDouble;

/// `re + i·im`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ComplexDoubleDouble {
    /// The real part.
    pub re: DoubleDouble,
    /// The imaginary part.
    pub im: DoubleDouble,
}

impl ComplexDoubleDouble {
    /// 0.
    pub const ZERO: ComplexDoubleDouble = ComplexDoubleDouble {
        re: DoubleDouble::ZERO,
        im: DoubleDouble::ZERO,
    };

    /// From its parts.
    pub fn new(re: impl Into<DoubleDouble>, im: impl Into<DoubleDouble>) -> ComplexDoubleDouble {
        ComplexDoubleDouble {
            re: re.into(),
            im: im.into(),
        }
    }

    /// |z|, in double.
    pub fn norm(self) -> f64 {
        self.re.to_f64().hypot(self.im.to_f64())
    }
}

impl Neg for ComplexDoubleDouble {
    type Output = ComplexDoubleDouble;

    fn neg(self) -> ComplexDoubleDouble {
        ComplexDoubleDouble {
            re: -self.re,
            im: -self.im,
        }
    }
}

impl Add for ComplexDoubleDouble {
    type Output = ComplexDoubleDouble;

    fn add(self, other: ComplexDoubleDouble) -> ComplexDoubleDouble {
        ComplexDoubleDouble {
            re: self.re + other.re,
            im: self.im + other.im,
        }
    }
}

impl AddAssign for ComplexDoubleDouble {
    fn add_assign(&mut self, other: ComplexDoubleDouble) {
        *self = *self + other;
    }
}

impl Sub for ComplexDoubleDouble {
    type Output = ComplexDoubleDouble;

    fn sub(self, other: ComplexDoubleDouble) -> ComplexDoubleDouble {
        self + -other
    }
}

impl Mul for ComplexDoubleDouble {
    type Output = ComplexDoubleDouble;

    fn mul(self, other: ComplexDoubleDouble) -> ComplexDoubleDouble {
        ComplexDoubleDouble {
            re: self.re * other.re - self.im * other.im,
            im: self.re * other.im + self.im * other.re,
        }
    }
}

impl Mul<f64> for ComplexDoubleDouble {
    type Output = ComplexDoubleDouble;

    fn mul(self, factor: f64) -> ComplexDoubleDouble {
        ComplexDoubleDouble {
            re: self.re * factor,
            im: self.im * factor,
        }
    }
}

impl Div for ComplexDoubleDouble {
    type Output = ComplexDoubleDouble;

    /// The textbook formula, with the divisor scaled by a power of two so that its square neither
    /// overflows nor underflows.
    fn div(self, other: ComplexDoubleDouble) -> ComplexDoubleDouble {
        let exponent = other
            .re
            .to_f64()
            .abs()
            .max(other.im.to_f64().abs())
            .log2()
            .floor();
        if !exponent.is_finite() {
            let quotient = self.re / other.re.abs();
            return ComplexDoubleDouble {
                re: quotient,
                im: quotient,
            };
        }
        let half = (exponent / 2.0).floor();
        let (first, second) = ((-half).exp2(), (half - exponent).exp2());
        let other = other * first * second;
        let square = other.re * other.re + other.im * other.im;
        let conjugate = ComplexDoubleDouble {
            re: other.re,
            im: -other.im,
        };
        let product = self * conjugate;
        ComplexDoubleDouble {
            re: product.re / square,
            im: product.im / square,
        } * first
            * second
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    proptest::proptest! {
        #[test]
        fn quotient_times_divisor_gives_back(
            a in -1e100..1e100f64, b in -1e100..1e100f64, c in -1e200..1e200f64, d in -1e200..1e200f64,
        ) {
            let (z, w) = (ComplexDoubleDouble::new(a, b), ComplexDoubleDouble::new(c, d));
            let back = z / w * w - z;
            proptest::prop_assert!(back.norm() <= 2f64.powi(-96) * z.norm());
        }
    }
}
