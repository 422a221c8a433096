//! A one-mass system in units of an interval.

use eigentone_digits::{DoubleDouble, Magnitude, Real};

use super::base::BaseAcceleration;
use crate::problem::Rate;

/// A little more than the roundings of a dozen operations in doubles.
pub(super) const SLACK: f64 = 1e-14;

pub(super) struct Oscillator {
    /// ω in rad/s, and its relative error.
    pub(super) rate: (DoubleDouble, Magnitude),
    /// W = ωh, and its relative error.
    pub(super) phase: (DoubleDouble, Magnitude),
    /// The angle through which the base's acceleration turns in an interval, and its error.
    pub(super) angle: (DoubleDouble, Magnitude),
    pub(super) ratio: f64,
    /// W and the angle in doubles.
    pub(super) w: f64,
    pub(super) turn: f64,
    /// ‖A‖ = W(ζ + √(1 + ζ²)), rounded up.
    pub(super) norm: f64,
}

impl Oscillator {
    /// `None` where W is out of range.
    pub(super) fn of(frequency: f64, ratio: f64, base: &BaseAcceleration) -> Option<Oscillator> {
        let (pi, error) = Rate::HalfTurns(1, 1.0).value::<DoubleDouble>();
        let unit = DoubleDouble::unit();
        let relative = error + unit + unit;
        let rate = pi.mul_f64(2.0 * frequency);
        let phase = rate.mul_f64(base.interval());
        let turn = pi.mul_f64(base.half_turns());
        let w = phase.to_f64();
        let in_range = (1e-100..1e100).contains(&w) && ratio < 1e50 && rate.is_finite();
        in_range.then(|| Oscillator {
            rate: (rate, relative),
            phase: (phase, relative + unit),
            angle: (turn, turn.upper() * relative),
            ratio,
            w,
            turn: turn.to_f64(),
            norm: w * (ratio + (1.0 + ratio * ratio).sqrt()) * (1.0 + SLACK),
        })
    }

    /// W in two doubles.
    pub(super) fn parts(&self) -> (f64, f64) {
        (self.phase.0.high(), self.phase.0.low())
    }

    /// How many errors of single steps count together after `steps` of them, at most: free motions do not grow in the
    /// norm of (p, v), and of ζ < 1 decay as √((1 + ζ)/(1 − ζ)) e^{−ζωt}.
    pub(super) fn gathered(&self, steps: f64) -> f64 {
        let decay = self.ratio * self.w;
        if self.ratio >= 1.0 - SLACK || decay == 0.0 {
            return steps;
        }
        let spread = ((1.0 + self.ratio) / (1.0 - self.ratio)).sqrt();
        let all = spread / -(-decay).exp_m1() * (1.0 + 1e-2);
        steps.min(all)
    }
}
