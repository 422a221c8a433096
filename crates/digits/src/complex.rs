//! Complex numbers with parts of any precision.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

use crate::{DoubleDouble, Magnitude, Real};

/// `re + i·im`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WideComplex<T> {
    /// The real part.
    pub re: T,
    /// The imaginary part.
    pub im: T,
}

/// `re + i·im` with double-double parts.
pub type ComplexDoubleDouble = WideComplex<DoubleDouble>;

impl<T: Real> WideComplex<T> {
    /// 0.
    pub const ZERO: WideComplex<T> = WideComplex {
        re: T::ZERO,
        im: T::ZERO,
    };

    /// From its parts.
    pub fn new(re: impl Into<T>, im: impl Into<T>) -> WideComplex<T> {
        WideComplex {
            re: re.into(),
            im: im.into(),
        }
    }

    /// |z|, in double.
    pub fn norm(self) -> f64 {
        modulus(self.re.to_f64(), self.im.to_f64())
    }

    /// `re − i·im`.
    pub fn conj(self) -> WideComplex<T> {
        WideComplex {
            re: self.re,
            im: -self.im,
        }
    }

    /// z·2^power, within the floor of [`Real`].
    pub fn scale(self, power: i64) -> WideComplex<T> {
        WideComplex {
            re: self.re.scale(power),
            im: self.im.scale(power),
        }
    }

    /// Whether both parts are numbers in range.
    pub fn is_finite(self) -> bool {
        self.re.is_finite() && self.im.is_finite()
    }

    /// An upper bound of |z|, within a relative 2^-48; infinite where z is not finite.
    #[inline]
    pub fn upper(self) -> Magnitude {
        self.magnitude().above()
    }

    /// A lower bound of |z|, within a relative 2^-48; 0 where z is not finite.
    #[inline]
    pub fn lower(self) -> Magnitude {
        self.magnitude().below()
    }

    /// |z| within a relative 2^-50.
    #[inline]
    pub(crate) fn magnitude(self) -> Magnitude {
        self.re.magnitude().hypot(self.im.magnitude())
    }
}

/// |re + i·im| within two units in the last place, quickly where squares stay within the range of doubles.
#[inline]
pub fn modulus(re: f64, im: f64) -> f64 {
    const RANGE: std::ops::Range<f64> = 1e-280..1e300;
    let square = re * re + im * im;
    if RANGE.contains(&square) {
        square.sqrt()
    } else {
        re.hypot(im)
    }
}

impl<T: Real> Neg for WideComplex<T> {
    type Output = WideComplex<T>;

    fn neg(self) -> WideComplex<T> {
        WideComplex {
            re: -self.re,
            im: -self.im,
        }
    }
}

impl<T: Real> Add for WideComplex<T> {
    type Output = WideComplex<T>;

    fn add(self, other: WideComplex<T>) -> WideComplex<T> {
        WideComplex {
            re: self.re + other.re,
            im: self.im + other.im,
        }
    }
}

impl<T: Real> AddAssign for WideComplex<T> {
    fn add_assign(&mut self, other: WideComplex<T>) {
        *self = *self + other;
    }
}

impl<T: Real> Sub for WideComplex<T> {
    type Output = WideComplex<T>;

    fn sub(self, other: WideComplex<T>) -> WideComplex<T> {
        WideComplex {
            re: self.re - other.re,
            im: self.im - other.im,
        }
    }
}

impl<T: Real> Mul for WideComplex<T> {
    type Output = WideComplex<T>;

    fn mul(self, other: WideComplex<T>) -> WideComplex<T> {
        // A quarter of the work. Without damping all are real.
        if self.im.is_zero() && other.im.is_zero() {
            return WideComplex {
                re: self.re * other.re,
                im: T::ZERO,
            };
        }
        WideComplex {
            re: self.re * other.re - self.im * other.im,
            im: self.re * other.im + self.im * other.re,
        }
    }
}

impl<T: Real> Mul<f64> for WideComplex<T> {
    type Output = WideComplex<T>;

    fn mul(self, factor: f64) -> WideComplex<T> {
        WideComplex {
            re: self.re.mul_f64(factor),
            im: self.im.mul_f64(factor),
        }
    }
}

impl<T: Real> Div for WideComplex<T> {
    type Output = WideComplex<T>;

    /// The textbook formula, with both numbers scaled by powers of two so that nothing overflows or
    /// underflows on the way. Not finite for a divisor of 0.
    fn div(self, other: WideComplex<T>) -> WideComplex<T> {
        let (above, below) = (self.magnitude().exponent(), other.magnitude().exponent());
        let divisor = other.scale(-below);
        let square = divisor.re * divisor.re + divisor.im * divisor.im;
        let product = self.scale(-above) * divisor.conj();
        WideComplex {
            re: product.re / square,
            im: product.im / square,
        }
        .scale(above - below)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Wide;

    proptest::proptest! {
        #[test]
        fn quotient_times_divisor_gives_back(
            a in -1e100..1e100f64, b in -1e100..1e100f64, c in -1e200..1e200f64, d in -1e200..1e200f64,
        ) {
            let (z, w) = (ComplexDoubleDouble::new(a, b), ComplexDoubleDouble::new(c, d));
            let back = z / w * w - z;
            proptest::prop_assert!(back.norm() <= 2f64.powi(-96) * z.norm());
            let (z, w) = (WideComplex::<Wide<4>>::new(a, b), WideComplex::new(c, d));
            let back = z / w * w - z;
            proptest::prop_assert!(back.norm() <= 2f64.powi(-250) * z.norm());
        }
    }

    #[test]
    fn quotients_reach_the_ends_of_the_doubles() {
        let w = ComplexDoubleDouble::new(f64::MAX, f64::MAX);
        assert_eq!(w / w, ComplexDoubleDouble::new(1.0, 0.0));
        let w = ComplexDoubleDouble::new(5e-324, -5e-324);
        assert_eq!(w / w, ComplexDoubleDouble::new(1.0, 0.0));
        assert!(!(w / ComplexDoubleDouble::ZERO).norm().is_finite());
        assert!(!(ComplexDoubleDouble::ZERO / ComplexDoubleDouble::ZERO).is_finite());
    }
}
