//! The frequency weightings of ISO 2631-1:1997 for what people feel of vibration, as linear filters.
//!
//! Each is a product of a high pass and a low pass that limit the band, a transition from acceleration to velocity, and, in W_k, a
//! step upwards; their frequencies and quality factors are those of the standard (also in table 3 of ISO 8041:2005).

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use eigentone_digits::Real;
use num_complex::Complex;

use crate::frequency_response::{StateForm, powers};

/// A frequency weighting of acceleration.
///
/// ```
/// use eigentone_response::Weighting;
///
/// // At 100 rad/s.
/// assert!((Weighting::Vertical.at(100.0).norm() - 0.7718).abs() < 5e-5);
/// assert!((Weighting::Horizontal.at(100.0).norm() - 0.1261).abs() < 5e-5);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Weighting {
    /// W_k, for vertical vibration of those who sit, stand or lie.
    Vertical,
    /// W_d, for horizontal vibration of those who sit or stand.
    Horizontal,
}

/// (n₀ + n₁s + n₂s²)/(1 + d₁s + d₂s²).
struct Stage {
    above: [f64; 3],
    below: [f64; 2],
}

impl Weighting {
    /// Its value at a frequency in rad/s.
    pub fn at(self, frequency: f64) -> Complex<f64> {
        // In powers of 1/s where those of s may leave the doubles.
        let is_far = frequency.abs() > 1e50;
        let s = match is_far {
            true => Complex::new(0.0, -1.0 / frequency),
            false => Complex::new(0.0, frequency),
        };
        let value = |mut by: [f64; 3]| {
            if is_far {
                by.reverse();
            }
            Complex::from(by[0]) + s * by[1] + s * s * by[2]
        };
        let stages = self.stages().into_iter();
        let factors =
            stages.map(|Stage { above, below }| value(above) / value([1.0, below[0], below[1]]));
        factors.product()
    }

    fn stages(self) -> Vec<Stage> {
        let rate = |hertz: f64| 1.0 / (TAU * hertz);
        let (low, high) = (rate(0.4), rate(100.0));
        let transition = match self {
            Weighting::Vertical => rate(12.5),
            Weighting::Horizontal => rate(2.0),
        };
        let second = |time: f64, quality: f64| [time / quality, time * time];
        let mut stages = vec![
            Stage {
                above: [0.0, 0.0, low * low],
                below: second(low, FRAC_1_SQRT_2),
            },
            Stage {
                above: [1.0, 0.0, 0.0],
                below: second(high, FRAC_1_SQRT_2),
            },
            Stage {
                above: [1.0, transition, 0.0],
                below: second(transition, 0.63),
            },
        ];
        if self == Weighting::Vertical {
            let (from, to) = (rate(2.37), rate(3.35));
            let gain = (to / from) * (to / from);
            let [first, square] = second(from, 0.91);
            stages.push(Stage {
                above: [gain, gain * first, gain * square],
                below: second(to, 0.91),
            });
        }
        stages
    }

    /// What reads the output of a form through it; `None` where the output follows a derivative of an input.
    pub(super) fn after<T: Real>(self, form: StateForm<T>) -> Option<StateForm<T>> {
        let passes =
            |power: i32| power > 0 && (0..form.b.len()).any(|i| !form.direct(i, power).is_zero());
        if powers().any(passes) {
            return None;
        }
        let stages = self.stages().into_iter();
        Some(stages.fold(
            form,
            |form,
             Stage {
                 above,
                 below: [first, square],
             }| {
                // x″ = (u − x − d₁x′)/d₂, and the output n₀x + n₁x′ + n₂x″.
                let bend = above[2] / square;
                let read = [above[0] - bend, above[1] - bend * first];
                form.followed([-1.0 / square, -first / square], 1.0 / square, read, bend)
            },
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_frequencies_are_filtered_out() {
        for weighting in [Weighting::Vertical, Weighting::Horizontal] {
            // It falls with the square of the frequency by the low pass, and once more by the transition.
            let [near, far] = [1e49, 1e51].map(|frequency| weighting.at(frequency));
            assert!((far.norm() / near.norm() * 1e6 - 1.0).abs() < 1e-12);
            for frequency in [1e160, 1e300, f64::MAX, f64::INFINITY, -1e300] {
                assert_eq!(weighting.at(frequency).norm(), 0.0, "{frequency}");
            }
        }
    }
}
