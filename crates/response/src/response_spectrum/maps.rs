//! The exact motion over parts of an interval.
//!
//! In units of the interval h, with W = ωh: p = ωy, y the displacement relative to the base, and v = y′ follow
//! p′ = W v, v′ = −W p − 2ζW v − a, where a, in m/s as it is multiplied by h, follows a law of its own:
//! a′ = α b, b′ = β (c − a), c′ = 0. A straight line has α = 1, β = 0; a sine α = β = its angle.

use std::collections::BTreeMap;

use eigentone_digits::{BallMatrix, DoubleDouble, Magnitude, Real};

use super::oscillator::Oscillator;
use crate::enclosed::{Normed, exponential, growth};

/// p, v and a, b, c after a part of an interval, from those before.
#[derive(Clone, Debug)]
pub(super) struct Map<T> {
    /// Rows of p, v, a, b.
    pub(super) rows: [[T; 5]; 4],
    /// What an application is off at most, in the 2-norm, in parts of that of what it is applied to.
    pub(super) error: f64,
}

/// p and v; a, b and c.
pub(super) type Place<T> = ([T; 2], [T; 3]);

impl<T: Real> Map<T> {
    pub(super) fn apply(&self, (z, x): &Place<T>) -> Place<T> {
        let of = |row: &[T; 5], first: usize| {
            let all = [z[0], z[1], x[0], x[1], x[2]];
            let products = (first..5).map(|i| row[i] * all[i]);
            products.fold(T::ZERO, |sum, product| sum + product)
        };
        let [p, v, a, b] = &self.rows;
        ([of(p, 0), of(v, 0)], [of(a, 2), of(b, 2), x[2]])
    }
}

/// Maps of 2^−level intervals, made when they are first asked for.
pub(super) struct Maps<T> {
    generator: Normed<DoubleDouble>,
    by_level: BTreeMap<i64, Map<T>>,
}

impl<T: Real> Maps<T> {
    /// After the base has come to rest: a, b and c count for nothing.
    pub(super) fn free(oscillator: &Oscillator) -> Maps<T> {
        Maps::of(&free(oscillator))
    }

    /// On the base that is shaken.
    pub(super) fn driven(oscillator: &Oscillator) -> Maps<T> {
        let mut generator = free(oscillator);
        generator.set(1, 2, -DoubleDouble::ONE, Magnitude::ZERO);
        let (angle, error) = oscillator.angle;
        if angle.is_zero() {
            generator.set(2, 3, DoubleDouble::ONE, Magnitude::ZERO);
        } else {
            generator.set(2, 3, angle, error);
            generator.set(3, 2, -angle, error);
            generator.set(3, 4, angle, error);
        }
        Maps::of(&generator)
    }

    fn of(generator: &BallMatrix<DoubleDouble>) -> Maps<T> {
        Maps {
            generator: Normed::of(generator, 2),
            by_level: BTreeMap::new(),
        }
    }

    pub(super) fn at(&mut self, level: i64) -> &Map<T> {
        let generator = &self.generator;
        self.by_level.entry(level).or_insert_with(|| {
            let scaled = generator.scaled(-level);
            let power = exponential(&scaled, DoubleDouble::ONE, Magnitude::ZERO);
            let entry = |i: usize, j: usize| {
                let exact = power.row(i)[j];
                let high = exact.to_f64();
                T::from(high) + T::from((exact - DoubleDouble::from(high)).to_f64())
            };
            let rows = [0, 1, 2, 3].map(|i| [0, 1, 2, 3, 4].map(|j| entry(i, j)));
            // Rounding to T, and sums of five products.
            let rounding = power.sizes() * growth::<T>(8);
            let error = (power.error() + rounding).to_f64();
            Map { rows, error }
        })
    }

    /// The largest error of any that was asked for.
    pub(super) fn error(&self) -> f64 {
        self.by_level
            .values()
            .map(|map| map.error)
            .fold(0.0, f64::max)
    }
}

/// The motion of p and v by themselves.
fn free(oscillator: &Oscillator) -> BallMatrix<DoubleDouble> {
    let (w, relative) = oscillator.phase;
    let error = w.upper() * relative;
    let mut generator = BallMatrix::<DoubleDouble>::zeros(5, 5);
    generator.set(0, 1, w, error);
    generator.set(1, 0, -w, error);
    let (twice, unit) = (2.0 * oscillator.ratio, DoubleDouble::unit());
    let drag = w.mul_f64(twice);
    let loss = error * Magnitude::from(twice) + drag.upper() * unit + DoubleDouble::floor();
    generator.set(1, 1, -drag, loss);
    generator
}
