//! Balls from numbers that are meant exactly.

use eigentone_digits::{Ball, Magnitude, Real, WideComplex};

/// re + i·im, exactly.
pub(crate) fn exact<T: Real>(re: T, im: T) -> Ball<T> {
    Ball::from(WideComplex { re, im })
}

/// A double, exactly.
pub(crate) fn real<T: Real>(value: f64) -> Ball<T> {
    exact(T::from(value), T::ZERO)
}

/// The midpoint alone.
pub(crate) fn middle<T: Real>(ball: Ball<T>) -> Ball<T> {
    Ball::from(ball.middle())
}

/// 2^power times the ball.
pub(crate) fn scaled<T: Real>(ball: Ball<T>, power: i64) -> Ball<T> {
    if ball.is_zero() {
        return ball;
    }
    let radius = ball.radius() * Magnitude::power_of_two(power) + T::floor();
    Ball::new(ball.middle().scale(power), radius)
}

/// A number as a sum of doubles, to be carried from one precision to another.
pub(crate) type Terms = [f64; 4];

/// The leading terms of a number: all of it in up to 200 bits.
pub(crate) fn terms<T: Real>(mut value: T) -> Terms {
    [(); 4].map(|()| {
        let term = value.to_f64();
        value = value - T::from(term);
        term
    })
}

/// An upper bound of |z|, as a double.
pub(crate) fn upper<T: Real>(ball: Ball<T>) -> f64 {
    ball.upper().to_f64()
}

/// A lower bound of |z|, as a double.
pub(crate) fn lower<T: Real>(ball: Ball<T>) -> f64 {
    let bound = ball.lower().to_f64();
    // Conversion rounds up where doubles end.
    if bound > f64::MIN_POSITIVE && bound.is_finite() {
        bound
    } else {
        0.0
    }
}

/// |middle|, to a few digits.
pub(crate) fn size<T: Real>(ball: Ball<T>) -> f64 {
    ball.middle().norm()
}

/// The radius, as a double that is no smaller.
pub(crate) fn radius<T: Real>(ball: Ball<T>) -> f64 {
    ball.radius().to_f64()
}
