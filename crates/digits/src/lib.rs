//! Arithmetic with more digits than a double has.
//!
//! [`DoubleDouble`] is an unevaluated sum of two doubles, about 32 digits.

mod complex;
mod double_double;

pub use complex::ComplexDoubleDouble;
pub use double_double::DoubleDouble;
