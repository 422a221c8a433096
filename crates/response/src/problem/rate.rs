//! Angular frequencies, as far as they are known exactly.

use eigentone_digits::{Magnitude, Real};

use super::straight_load::Known;

/// An angular frequency in rad/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Rate {
    /// A double.
    Given(f64),
    /// So many half turns in so many seconds.
    HalfTurns(u8, f64),
}

impl Rate {
    /// Its value and a bound of the error.
    pub(crate) fn value<T: Real>(self) -> Known<T> {
        match self {
            Rate::Given(rate) => (T::from(rate), Magnitude::ZERO),
            Rate::HalfTurns(count, duration) => {
                let (pi, error) = pi::<T>();
                let factor = T::from(f64::from(count));
                let rate = pi * factor / T::from(duration);
                let relative = error + T::unit() * Magnitude::from(4.0);
                (rate, rate.upper() * relative + T::floor())
            }
        }
    }

    pub(crate) fn to_f64(self) -> f64 {
        match self {
            Rate::Given(rate) => rate,
            Rate::HalfTurns(count, duration) => f64::from(count) * std::f64::consts::PI / duration,
        }
    }
}

/// The seconds of so many turns at an angular frequency in rad/s.
pub fn turns<T: Real>(count: u32, frequency: f64) -> T {
    let (half_turn, _) = pi::<T>();
    half_turn * T::from(2.0 * f64::from(count)) / T::from(frequency)
}

/// π by Machin's formula, 16 arctan(1/5) − 4 arctan(1/239), and a bound of the relative error.
fn pi<T: Real>() -> Known<T> {
    let mut terms = 0.0;
    let mut arctan = |inverse: f64| {
        let (x, square) = (T::ONE / T::from(inverse), T::from(inverse * inverse));
        let (mut power, mut sum, mut k) = (x, x, 1.0);
        while power.upper() > T::unit() * T::unit() {
            power = -power / square;
            k += 2.0;
            sum = sum + power / T::from(k);
            terms += 1.0;
        }
        sum
    };
    let sixteenth = arctan(5.0);
    let pi = T::from(16.0) * sixteenth - T::from(4.0) * arctan(239.0);
    // No sum on the way exceeds π, and each term errs by as many units as it has divisions.
    (pi, T::unit() * Magnitude::from(16.0 * (terms + 4.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentone_digits::{DoubleDouble, Wide};

    #[test]
    fn pi_is_known_to_its_bound() {
        let (fine, _) = pi::<Wide<16>>();
        let (mut middle, bound) = pi::<Wide<4>>();
        let mut rest = fine;
        for _ in 0..6 {
            let part = middle.to_f64();
            (middle, rest) = (middle - Wide::from(part), rest - Wide::from(part));
        }
        let off = rest.abs().to_f64();
        assert!(off <= 4.0 * bound.to_f64() && off < 1e-70, "{off:e}");
        let (coarse, bound) = pi::<DoubleDouble>();
        let off = (coarse - DoubleDouble::TAU * 0.5).to_f64().abs();
        assert!(off <= bound.to_f64() * 4.0 && off < 1e-30, "{off:e}");
    }
}
