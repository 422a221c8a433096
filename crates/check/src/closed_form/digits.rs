//! Closed forms evaluated with as many bits as their digits take.

use num_rational::BigRational;
use thiserror::Error;

use crate::reference::Ball;

/// Where a coordinate is and how it moves at one instant, each value within a radius that is proven.
#[derive(Clone, Debug)]
pub struct ExactMotion {
    /// In m.
    pub displacement: Ball,
    /// In m/s.
    pub velocity: Ball,
}

/// Why there is no closed form for what was given.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ClosedFormError {
    /// A mass is not a positive number.
    #[error("a mass is {value:?}: it must be a finite number greater than 0")]
    Mass {
        /// The value given, in kg.
        value: f64,
    },
    /// A stiffness or damping is negative or not a number.
    #[error("a stiffness or damping is {value:?}: it must be a finite number, 0 or greater")]
    Coefficient {
        /// The value given.
        value: f64,
    },
    /// A chain has no masses.
    #[error("a chain of 0 masses does not move: it must have one at least")]
    NoMasses,
    /// A state has more or fewer entries than there are masses.
    #[error("the state has length {given}: it must be {masses}, the number of masses")]
    State {
        /// The entries given.
        given: usize,
        /// The masses.
        masses: usize,
    },
}

/// A mass as the rational number that it is.
pub(super) fn mass(value: f64) -> Result<BigRational, ClosedFormError> {
    let exact = BigRational::from_float(value).filter(|_| value > 0.0);
    exact.ok_or(ClosedFormError::Mass { value })
}

/// The same of a stiffness or damping.
pub(super) fn coefficient(value: f64) -> Result<BigRational, ClosedFormError> {
    let exact = BigRational::from_float(value).filter(|_| value >= 0.0);
    exact.ok_or(ClosedFormError::Coefficient { value })
}

/// A double to so many bits; unknown if it is infinite or NaN.
pub(super) fn exactly(value: f64, bits: u64) -> Ball {
    let exact = Ball::exactly(value).map(|exact| exact.with_bits(bits));
    exact.unwrap_or_else(|| Ball::unknown(bits))
}

/// The longest numbers that are tried.
const MOST_BITS: u64 = 1 << 13;

/// The values of a form, with more and more bits until each is known to 10^−digits of itself or
/// 10^−(2·digits) of the largest: what cancels is a matter of more bits. Values that are not known so
/// well with 2^13 bits are left with the radius that they have.
pub(super) fn to_digits(digits: u32, form: impl Fn(u64) -> Vec<Ball>) -> Vec<Ball> {
    let wanted = f64::from(digits) * std::f64::consts::LOG2_10;
    let mut bits = wanted as u64 + 64;
    loop {
        let values = form(bits);
        let largest = values
            .iter()
            .map(Ball::log2)
            .fold(f64::NEG_INFINITY, f64::max);
        let unit = |value: &Ball| value.log2().max(largest - wanted);
        let known = |value: &Ball| value.radius_log2() <= unit(value) - wanted;
        if bits >= MOST_BITS || values.iter().all(known) {
            return values;
        }
        bits *= 2;
    }
}

/// Displacements, then as many velocities.
pub(super) fn motions(values: Vec<Ball>) -> Vec<ExactMotion> {
    let (displacements, velocities) = values.split_at(values.len() / 2);
    let both = displacements.iter().zip(velocities);
    let motion = |(displacement, velocity): (&Ball, &Ball)| ExactMotion {
        displacement: displacement.clone(),
        velocity: velocity.clone(),
    };
    both.map(motion).collect()
}
