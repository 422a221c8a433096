//! Numbers that a factor can be made of.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Sub, SubAssign};

use eigentone_digits::{DoubleDouble, Real};
use num_complex::Complex;

/// A number that a factor can be made of.
pub(crate) trait Entry:
    Copy
    + Debug
    + PartialEq
    + From<f64>
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + SubAssign
    + Mul<Output = Self>
    + Div<Output = Self>
{
    /// The relative error of one operation, rounded up.
    const UNIT: f64;

    fn rounded(value: DoubleDouble) -> Self;

    /// |x|, in doubles.
    fn size(self) -> f64;

    /// Whether x is real and not negative.
    fn is_non_negative(self) -> bool;

    /// Whether x is real and negative.
    fn is_negative(self) -> bool;
}

impl Entry for f64 {
    const UNIT: f64 = f64::EPSILON / 2.0;

    fn rounded(value: DoubleDouble) -> f64 {
        value.high()
    }

    fn size(self) -> f64 {
        self.abs()
    }

    fn is_non_negative(self) -> bool {
        self >= 0.0
    }

    fn is_negative(self) -> bool {
        self < 0.0
    }
}

impl Entry for DoubleDouble {
    const UNIT: f64 = {
        assert!(<DoubleDouble as Real>::UNIT_LOG2 <= -98);
        // 2^-98.
        f64::from_bits((1023 - 98) << 52)
    };

    fn rounded(value: DoubleDouble) -> DoubleDouble {
        value
    }

    fn size(self) -> f64 {
        self.high().abs()
    }

    fn is_non_negative(self) -> bool {
        self.high() >= 0.0
    }

    fn is_negative(self) -> bool {
        self.high() < 0.0
    }
}

impl Entry for Complex<f64> {
    const UNIT: f64 = 4.0 * f64::EPSILON;

    fn rounded(value: DoubleDouble) -> Complex<f64> {
        Complex::from(value.high())
    }

    fn size(self) -> f64 {
        self.norm()
    }

    fn is_non_negative(self) -> bool {
        false
    }

    fn is_negative(self) -> bool {
        false
    }
}
