//! Arithmetic with more digits than a double has, and with proven error bounds.
//!
//! [`DoubleDouble`] is an unevaluated sum of two doubles, about 32 digits. [`Wide`] is a binary
//! float of a fixed number of limbs. Both are [`Real`] numbers, as doubles are, so that kernels can
//! be written once for all; [`Lanes`] of double-doubles are summed together. [`WideComplex`] pairs them, [`Magnitude`] bounds sizes and errors, and a
//! [`Ball`] is a complex number with a proven bound of its error, a [`BallMatrix`] a real matrix of
//! such numbers.

mod ball;
mod ball_matrix;
mod complex;
mod double_double;
mod lanes;
mod magnitude;
#[cfg(test)]
mod rational;
mod real;
mod wide;

pub use ball::Ball;
pub use ball_matrix::BallMatrix;
pub use complex::{ComplexDoubleDouble, WideComplex};
pub use double_double::DoubleDouble;
pub use lanes::Lanes;
pub use magnitude::Magnitude;
pub use real::Real;
pub use wide::Wide;
