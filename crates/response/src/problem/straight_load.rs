//! A force that runs straight, and how far it may be off.

use eigentone_digits::{Magnitude, Real};

/// A value and a bound of its error.
pub(crate) type Known<T> = (T, Magnitude);

/// A force that runs straight, from some instant on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StraightLoad<T> {
    /// In N, at that instant.
    pub(crate) value: Known<T>,
    /// In N/s.
    pub(crate) slope: Known<T>,
}

/// Each operation errs by a unit of its result, of which no part exceeds the sum of sizes.
pub(crate) fn units<T: Real>() -> Magnitude {
    T::unit() * Magnitude::from(8.0)
}

impl<T: Real> Default for StraightLoad<T> {
    fn default() -> StraightLoad<T> {
        let nothing = (T::ZERO, Magnitude::ZERO);
        StraightLoad {
            value: nothing,
            slope: nothing,
        }
    }
}

impl<T: Real> StraightLoad<T> {
    /// Whether it changes with time, or may.
    pub(crate) fn is_sloped(&self) -> bool {
        !(self.slope.0.is_zero() && self.slope.1.is_zero())
    }

    /// The same from `time` s later on, known to `error` s.
    pub(crate) fn after(&self, (time, error): Known<T>) -> StraightLoad<T> {
        if !self.is_sloped() {
            return *self;
        }
        let ((start, start_error), (slope, slope_error)) = (self.value, self.slope);
        let rise = slope * time;
        let rounding = (start.upper() + rise.upper()) * units::<T>() + T::floor();
        let error = start_error
            + rounding
            + (slope.upper() + slope_error) * error
            + slope_error * time.upper();
        StraightLoad {
            value: (start + rise, error),
            slope: self.slope,
        }
    }

    /// The sum of two from the same instant on.
    pub(super) fn plus(&self, other: &StraightLoad<T>) -> StraightLoad<T> {
        StraightLoad {
            value: sum(self.value, other.value),
            slope: sum(self.slope, other.slope),
        }
    }
}

/// a + b; what is added to 0 is not rounded.
pub(crate) fn sum<T: Real>((a, a_error): Known<T>, (b, b_error): Known<T>) -> Known<T> {
    let sum = a + b;
    let rounding = match a.is_zero() || b.is_zero() {
        true => Magnitude::ZERO,
        false => sum.upper() * T::unit(),
    };
    (sum, a_error + b_error + rounding)
}
