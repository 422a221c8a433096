//! One mass on a spring and a damper to ground, m x″ + c x′ + k x = f(t), in any number of digits
//! (S. S. Rao, *Mechanical Vibrations*, §§2.6, 3.3 and 4.2).
//!
//! With σ = c/2m, ω² = k/m and δ = σ² − ω², all follows from B, the motion after an impulse that gives
//! the velocity 1:
//!
//! | | δ < 0, ω_d = √−δ | δ = 0 | δ > 0, b = σ + √δ, a = ω²/b |
//! |---|---|---|---|
//! | B | e^(−σt) sin(ω_d t)/ω_d | t e^(−σt) | (e^(−at) − e^(−bt))/(2√δ) |
//! | B′ | e^(−σt) (cos ω_d t − σ sin(ω_d t)/ω_d) | (1 − σt) e^(−σt) | e^(−bt) − a B |
//!
//! - released from 1: A = B′ + 2σB, since A″ + 2σA′ + ω²A = 0 with A(0) = 1, A′(0) = 0; A′ = −ω²B;
//! - m times the motion under a force of 1: S = ∫B = (1 − A)/ω², without a spring
//!   (t − B)/2σ, and t²/2 without a damper either;
//! - m times that under a force t: R = ∫S = (t − B − 2σS)/ω², without a spring (t²/2 − S)/2σ, and
//!   t³/6 without a damper either;
//! - under F sin(Ωt + φ): the particular motion F (p sin(Ωt + φ) − q cos(Ωt + φ))/(p² + q²) with
//!   p = k − mΩ² and q = cΩ, less the free motion from where that starts. At resonance of an
//!   undamped mass, p = q = 0, the particular motion is −F t cos(Ωt + φ)/(2mΩ).
//!
//! The signs of δ, and whether k, c, p and q vanish, are decided exactly.

use std::cmp::Ordering;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::Zero;

use super::digits::{ClosedFormError, ExactMotion, coefficient, exactly, mass, motions, to_digits};
use super::mass_spring_damper::Damping;
use crate::reference::Ball;

/// One mass with a spring and a damper to ground, either of which may be missing, in any number of
/// digits. Every double is taken as exact.
///
/// ```
/// use eigentone_check::ExactMass;
///
/// // Released from 1 m at critical damping: x = (1 + 2t) e^(−2t).
/// let door = ExactMass::new(1.0, 4.0, 4.0)?.with_digits(34);
/// let moving = door.free(1.0, 0.0, 0.5);
/// assert_eq!(moving.displacement.to_decimal(34), "7.357588823428846431910475403229217e-1");
/// assert!(moving.displacement.radius() < 1e-34);
/// # Ok::<(), eigentone_check::ClosedFormError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ExactMass {
    mass: BigRational,
    damping: BigRational,
    stiffness: BigRational,
    digits: u32,
}

/// B, B′, A and S after some time, with σ and ω².
struct ImpulseResponse {
    displacement: Ball,
    rate: Ball,
    release: Ball,
    step: Ball,
    twice_decay: Ball,
    natural_squared: Ball,
    time: Ball,
}

impl ExactMass {
    /// A mass in kg, a damping in N·s/m and a stiffness in N/m, both to ground; 34 digits.
    ///
    /// # Errors
    /// [`ClosedFormError`] unless all are finite, the mass positive and the others not negative.
    pub fn new(m: f64, damping: f64, stiffness: f64) -> Result<ExactMass, ClosedFormError> {
        Ok(ExactMass {
            mass: mass(m)?,
            damping: coefficient(damping)?,
            stiffness: coefficient(stiffness)?,
            digits: 34,
        })
    }

    /// The same to another number of decimal digits of every value.
    pub fn with_digits(self, digits: u32) -> ExactMass {
        ExactMass { digits, ..self }
    }

    /// How strongly it is damped.
    pub fn damping(&self) -> Damping {
        match self.discriminant().cmp(&BigRational::zero()) {
            _ if self.stiffness.is_zero() => Damping::Unsupported,
            _ if self.damping.is_zero() => Damping::Undamped,
            Ordering::Less => Damping::Underdamped,
            Ordering::Equal => Damping::Critical,
            Ordering::Greater => Damping::Overdamped,
        }
    }

    /// The motion at `t` s ≥ 0 from displacement `x0` m and velocity `v0` m/s at t = 0:
    /// x = x₀ A + v₀ B.
    pub fn free(&self, x0: f64, v0: f64, t: f64) -> ExactMotion {
        self.motion(|bits| {
            let response = self.impulse_response(t, bits);
            response.free(&exactly(x0, bits), &exactly(v0, bits))
        })
    }

    /// The motion from rest `t` s after a constant force of `force` N sets in: x = (F/m) S.
    pub fn step(&self, force: f64, t: f64) -> ExactMotion {
        self.motion(|bits| {
            let ImpulseResponse {
                displacement, step, ..
            } = self.impulse_response(t, bits);
            let pull = exactly(force, bits) / self.ball(&self.mass, bits);
            [&pull * step, pull * displacement]
        })
    }

    /// The motion from rest `t` s after a force begins to grow by `rate` N/s: x = (rate/m) R.
    pub fn ramp(&self, rate: f64, t: f64) -> ExactMotion {
        self.motion(|bits| {
            let response = self.impulse_response(t, bits);
            let pull = exactly(rate, bits) / self.ball(&self.mass, bits);
            [&pull * self.unit_ramp(&response), pull * response.step]
        })
    }

    /// The motion from rest `t` s after an impulse of `momentum` N·s: x = (p/m) B.
    pub fn impulse(&self, momentum: f64, t: f64) -> ExactMotion {
        self.motion(|bits| {
            let ImpulseResponse {
                displacement, rate, ..
            } = self.impulse_response(t, bits);
            let kick = exactly(momentum, bits) / self.ball(&self.mass, bits);
            [&kick * displacement, kick * rate]
        })
    }

    /// The motion from rest at t = 0, at `t` s ≥ 0, under the force
    /// `amplitude`·sin(`frequency`·t + `phase`) in N, with the frequency in rad/s.
    pub fn harmonic(&self, amplitude: f64, frequency: f64, phase: f64, t: f64) -> ExactMotion {
        self.motion(|bits| {
            let response = self.impulse_response(t, bits);
            let phase = exactly(phase, bits);
            let driven = Driven {
                force: exactly(amplitude, bits),
                frequency: exactly(frequency, bits),
                angle: (exactly(frequency, bits) * &response.time + &phase).sin_cos(),
                start: phase.sin_cos(),
            };
            self.driven(&response, &driven, frequency, bits)
        })
    }

    /// By the particular motion and the free motion from where that starts.
    fn driven(
        &self,
        response: &ImpulseResponse,
        driven: &Driven,
        frequency: f64,
        bits: u64,
    ) -> [Ball; 2] {
        let mass = self.ball(&self.mass, bits);
        let Driven {
            force,
            frequency: omega,
            angle: (sin, cos),
            start: (start_sin, start_cos),
        } = driven;
        let exact = BigRational::from_float(frequency).unwrap_or_default();
        let p = &self.stiffness - &self.mass * &exact * &exact;
        let q = &self.damping * &exact;
        let ([x, v], [x0, v0]) = if !p.is_zero() || !q.is_zero() {
            let square = self.ball(&(&p * &p + &q * &q), bits);
            let [p, q] = [p, q].map(|part| self.ball(&part, bits));
            let size = force / &square;
            let at = |sin: &Ball, cos: &Ball| {
                let velocity = omega * (&p * cos + &q * sin);
                [&size * (&p * sin - &q * cos), &size * velocity]
            };
            (at(sin, cos), at(start_sin, start_cos))
        } else if exact.is_zero() {
            // A constant force on a free mass.
            let pull = force / mass * start_sin;
            return [&pull * &response.step, pull * &response.displacement];
        } else {
            let size = force / (&mass * omega).scaled(1);
            let swing = cos - omega * &response.time * sin;
            let particular = [-(&size * &response.time * cos), -(&size * swing)];
            (particular, [Ball::zero(), -(size * start_cos)])
        };
        let [free_x, free_v] = response.free(&x0, &v0);
        [x - free_x, v - free_v]
    }

    /// R.
    fn unit_ramp(&self, response: &ImpulseResponse) -> Ball {
        let ImpulseResponse { time, step, .. } = response;
        let square = (time * time).scaled(-1);
        match (self.stiffness.is_zero(), self.damping.is_zero()) {
            (false, _) => {
                (time - &response.displacement - &response.twice_decay * step)
                    / &response.natural_squared
            }
            (true, false) => (square - step) / &response.twice_decay,
            (true, true) => square * time / Ball::from(3),
        }
    }

    fn impulse_response(&self, t: f64, bits: u64) -> ImpulseResponse {
        let ball = |value: &BigRational| self.ball(value, bits);
        let time = exactly(t, bits);
        let twice_decay = ball(&(&self.damping / &self.mass));
        let natural_squared = ball(&(&self.stiffness / &self.mass));
        let decay = twice_decay.clone().scaled(-1);
        let root = ball(&self.discriminant()).abs().sqrt();
        let (displacement, rate) = match self.discriminant().cmp(&BigRational::zero()) {
            Ordering::Less => {
                let envelope = (-(&decay * &time)).exp();
                let (sin, cos) = (&root * &time).sin_cos();
                let displacement = &envelope * sin / root;
                let rate = envelope * cos - decay * &displacement;
                (displacement, rate)
            }
            Ordering::Equal => {
                let envelope = (-(&decay * &time)).exp();
                let displacement = &envelope * &time;
                let rate = envelope - decay * &displacement;
                (displacement, rate)
            }
            Ordering::Greater => {
                let fast = decay + &root;
                let slow = &natural_squared / &fast;
                let [slowly, quickly] = [&slow, &fast].map(|root| (-(root * &time)).exp());
                let displacement = (slowly - &quickly) / root.scaled(1);
                let rate = quickly - slow * &displacement;
                (displacement, rate)
            }
        };
        let release = &rate + &twice_decay * &displacement;
        let one = Ball::from(1);
        let step = match (self.stiffness.is_zero(), self.damping.is_zero()) {
            (false, _) => (one - &release) / &natural_squared,
            (true, false) => (&time - &displacement) / &twice_decay,
            (true, true) => (&time * &time).scaled(-1),
        };
        ImpulseResponse {
            displacement,
            rate,
            release,
            step,
            twice_decay,
            natural_squared,
            time,
        }
    }

    /// δ = (c² − 4mk)/4m².
    fn discriminant(&self) -> BigRational {
        let half = &self.damping / (&self.mass * BigInt::from(2));
        &half * &half - &self.stiffness / &self.mass
    }

    fn ball(&self, value: &BigRational, bits: u64) -> Ball {
        Ball::rational(value, bits)
    }

    fn motion(&self, form: impl Fn(u64) -> [Ball; 2]) -> ExactMotion {
        let mut motion = motions(to_digits(self.digits, |bits| form(bits).into()));
        motion.remove(0)
    }
}

/// A harmonic force, its sine and cosine now, and at t = 0.
struct Driven {
    force: Ball,
    frequency: Ball,
    angle: (Ball, Ball),
    start: (Ball, Ball),
}

impl ImpulseResponse {
    fn free(&self, x0: &Ball, v0: &Ball) -> [Ball; 2] {
        let displacement = x0 * &self.release + v0 * &self.displacement;
        let velocity = v0 * &self.rate - x0 * &self.natural_squared * &self.displacement;
        [displacement, velocity]
    }
}
