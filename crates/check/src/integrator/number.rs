//! Real and complex numbers alike, for implicit steps.

use std::ops::{Add, AddAssign, Mul, Sub};

use eigentone_digits::Entry;

/// A real or complex number.
pub(super) trait Number:
    Entry
    + Copy
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Mul<f64, Output = Self>
{
}

impl Number for f64 {}
impl Number for faer::c64 {}
