//! The frequency weightings of ISO 2631-1:1997 for what people feel of vibration, as linear filters.
//!
//! Each is a product of a high pass and a low pass that limit the band, a transition from acceleration to velocity, and, in W_k, a
//! step upwards; their frequencies and quality factors are those of the standard (also in table 3 of ISO 8041:2005).

use std::f64::consts::TAU;

use eigentone_digits::{BallMatrix, Magnitude, Real};
use num_complex::Complex;

use crate::frequency_response::{StateForm, powers};
use crate::problem::Rate;
use crate::state_space::realisation::Realisation;

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

/// (n₀ + n₁σ + n₂σ²)/(1 + dσ + σ²) with σ = s/ω, for an ω of so many hertz: d is the inverse of a quality factor. By states it is
/// x′ = ωv and v′ = ω(u − x − dv).
struct Stage<T> {
    hertz: f64,
    above: [T; 3],
    damping: T,
}

impl<T: Real> Stage<T> {
    /// What it reads of x, of v and of u.
    fn reading(&self) -> [T; 3] {
        let [constant, first, second] = self.above;
        [constant - second, first - second * self.damping, second]
    }
}

impl Weighting {
    /// Its value at a frequency in rad/s.
    pub fn at(self, frequency: f64) -> Complex<f64> {
        let stages = self.stages::<f64>().into_iter();
        let factors = stages.map(|stage| {
            let omega = TAU * stage.hertz;
            // In powers of 1/σ where those of σ may leave the doubles.
            let is_far = frequency.abs() > 1e50;
            let sigma = match is_far {
                true => Complex::new(0.0, -omega / frequency),
                false => Complex::new(0.0, frequency / omega),
            };
            let value = |mut by: [f64; 3]| {
                if is_far {
                    by.reverse();
                }
                Complex::from(by[0]) + sigma * by[1] + sigma * sigma * by[2]
            };
            value(stage.above) / value([1.0, stage.damping, 1.0])
        });
        factors.product()
    }

    /// In the order in which they are passed, the high pass last. Frequencies and quality factors are the nearest doubles to those of
    /// the standard. What a stage reads is off by less than 100 units of T: differences lose less than a factor of 4.
    fn stages<T: Real>(self) -> Vec<Stage<T>> {
        let steep = T::from(2.0).sqrt();
        let of_quality = |quality: f64| T::ONE / T::from(quality);
        let transition = match self {
            Weighting::Vertical => 12.5,
            Weighting::Horizontal => 2.0,
        };
        let stage = |hertz, above: [f64; 3], damping| Stage {
            hertz,
            above: above.map(T::from),
            damping,
        };
        let mut stages = vec![
            stage(100.0, [1.0, 0.0, 0.0], steep),
            stage(transition, [1.0, 1.0, 0.0], of_quality(0.63)),
        ];
        if self == Weighting::Vertical {
            let (from, to) = (2.37, 3.35);
            let (ratio, damping) = (T::from(from) / T::from(to), of_quality(0.91));
            stages.push(Stage {
                hertz: to,
                above: [ratio * ratio, ratio * damping, T::ONE],
                damping,
            });
        }
        stages.push(stage(0.4, [0.0, 0.0, 1.0], steep));
        stages
    }

    /// How many states it has.
    pub(super) fn order(self) -> usize {
        2 * self.stages::<f64>().len()
    }

    /// What reads the output of a form through it; `None` where the output follows a derivative of an input.
    pub(super) fn after<T: Real>(self, form: StateForm<T>) -> Option<StateForm<T>> {
        let passes =
            |power: i32| power > 0 && (0..form.b.len()).any(|i| !form.direct(i, power).is_zero());
        if powers().any(passes) {
            return None;
        }
        let stages = self.stages::<f64>().into_iter();
        Some(stages.fold(form, |form, stage| {
            let omega = TAU * stage.hertz;
            let square = omega * omega;
            let [of_x, of_v, bend] = stage.reading();
            let back = [-square, -stage.damping * omega];
            form.followed(back, square, [of_x, of_v / omega], bend)
        }))
    }

    /// The form with one input that comes through it, beside what its outputs follow of derivatives and integrals of the input,
    /// from u/s² on. It begins with s² and falls with 1/s³, so that of all these from u/s² to u″ the states alone are read.
    pub(super) fn before<T: Real>(
        self,
        form: &Realisation<T>,
        direct: &[BallMatrix<T>],
        input: usize,
    ) -> (Realisation<T>, Vec<BallMatrix<T>>) {
        let (a, b, last) = self.states::<T>();
        // Of W sʲ⁻² for j = 0, 1, …, by s(s − A)⁻¹ = A(s − A)⁻¹ + 1.
        let mut readings = vec![last];
        while readings.len() < direct.len() {
            readings.push(readings[readings.len() - 1].times(&a));
        }
        let (own, rows, inputs) = (form.a.rows(), form.c.rows(), form.b.columns());
        let size = own + a.rows();
        let mut behind = form.clone();
        behind.a = BallMatrix::zeros(size, size);
        behind.b = BallMatrix::zeros(size, inputs);
        behind.c = BallMatrix::zeros(rows, size);
        behind.a.put(0, 0, &form.a);
        let pushed = form.b.block(0, input, own, 1).times(&readings[2]);
        behind.a.put(0, own, &pushed);
        behind.a.put(own, own, &a);
        behind.b.put(own, input, &b);
        let mut read = BallMatrix::zeros(rows, a.rows());
        let mut follows = vec![BallMatrix::zeros(rows, inputs); direct.len()];
        for (order, part) in direct.iter().enumerate() {
            let part = part.block(0, input, rows, 1);
            read = read.plus(&part.times(&readings[order]));
            for (back, reading) in readings[..order].iter().enumerate() {
                let passed = reading.times(&b);
                if !passed.is_zero(0, 0) {
                    // Powers of s from 0 on, which stand after two below.
                    let sum = &mut follows[order + 1 - back];
                    let more = sum.block(0, input, rows, 1).plus(&part.times(&passed));
                    sum.put(0, input, &more);
                }
            }
        }
        behind.c.put(0, 0, &form.c);
        behind.c.put(0, own, &read);
        (behind, follows)
    }

    /// A, b and c of W/s² = c(s − A)⁻¹b, the states of the last stage first.
    fn states<T: Real>(self) -> (BallMatrix<T>, BallMatrix<T>, BallMatrix<T>) {
        let stages = self.stages::<T>();
        let size = 2 * stages.len();
        let (turn, off) = Rate::HalfTurns(2, 1.0).value::<T>();
        let relative = off / turn.upper() + T::unit() * Magnitude::from(256.0);
        let set = |matrix: &mut BallMatrix<T>, i, j, value: T| {
            matrix.set(i, j, value, value.upper() * relative);
        };
        let (mut a, mut b) = (BallMatrix::zeros(size, size), BallMatrix::zeros(size, 1));
        let mut read = BallMatrix::zeros(1, size);
        // What the stages so far read of their states, and of what enters.
        let (mut row, mut entering) = (vec![T::ZERO; size], T::ONE);
        for (at, stage) in stages.iter().enumerate() {
            let x = size - 2 * (at + 1);
            let omega = turn * T::from(stage.hertz);
            set(&mut a, x, x + 1, omega);
            row[x] = -T::ONE;
            row[x + 1] = -stage.damping;
            for (j, entry) in row.iter().enumerate() {
                set(&mut a, x + 1, j, omega * *entry);
            }
            set(&mut b, x + 1, 0, omega * entering);
            let [of_x, of_v, of_u] = stage.reading();
            row.iter_mut().for_each(|entry| *entry = *entry * of_u);
            row[x] = of_x;
            row[x + 1] = of_v;
            entering = entering * of_u;
        }
        // σ²/s², of the high pass.
        let omega = turn * T::from(stages[stages.len() - 1].hertz);
        set(&mut read, 0, 0, T::ONE / (omega * omega));
        (a, b, read)
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
