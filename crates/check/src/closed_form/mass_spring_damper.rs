//! One mass on a spring and a damper to ground, m x″ + c x′ + k x = f(t), in closed form (any
//! textbook: Rao, *Mechanical Vibrations*, §§2.6 and 4.2).
//!
//! With σ = c/2m, ω = √(k/m), δ = σ² − ω², everything is made of one function, the velocity after
//! an impulse that gives the velocity 1, integrated or differentiated:
//!
//! | | δ < 0, ω_d = √−δ | δ ≥ 0, s = √δ, slow root a = ω²/(σ + s), fast root b = σ + s |
//! |---|---|---|
//! | impulse B | e^(−σt) sin(ω_d t)/ω_d | e^(−at) (1 − e^(−2st))/2s |
//! | its rate B′ | e^(−σt) (cos ω_d t − σ sin(ω_d t)/ω_d) | e^(−bt) − a B |
//! | release A | e^(−σt) (cos ω_d t + σ sin(ω_d t)/ω_d) | e^(−at) + a B |
//! | step m S | (1 − A)/ω² | ((1 − e^(−at))/a − B)/b |
//!
//! The mass moves as x₀ A + v₀ B + p B/m + F S. These forms cancel nowhere but where the motion
//! itself passes through zero; critical damping is s = 0, no support a = 0, and both are reached
//! continuously. Where b t or ω t is below 1, S comes from its Taylor series. The sign of δ is
//! exact, and phases and exponents carry about 32 digits up to their last use.

use eigentone_digits::DoubleDouble;
use thiserror::Error;

/// The range outside of which products of coefficients would leave that of doubles.
const RANGE: std::ops::RangeInclusive<f64> = 1e-70..=1e70;

/// One mass with a spring and a damper to ground, either of which may be missing.
///
/// Displacements and velocities are exact to a few units in the last place of the current
/// amplitude while ω t < 2^48 rad.
///
/// ```
/// use eigentone_check::{Damping, MassSpringDamper};
///
/// let door = MassSpringDamper::new(1.0, 4.0, 4.0)?;
/// assert_eq!(door.damping(), Damping::Critical);
/// let moving = door.free(1.0, 0.0, 0.5);
/// assert!((moving.displacement - 2.0 * (-1f64).exp()).abs() < 1e-15);
/// # Ok::<(), eigentone_check::OneMassError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassSpringDamper {
    mass: DoubleDouble,
    stiffness: DoubleDouble,
    /// σ = c/2m.
    decay: DoubleDouble,
    /// ω² = k/m.
    natural_squared: DoubleDouble,
    roots: Roots,
}

/// The roots of λ² + 2σλ + ω².
#[derive(Clone, Copy, Debug, PartialEq)]
enum Roots {
    /// −σ ± i·`damped`.
    Complex { damped: DoubleDouble },
    /// −`slow` and −`fast`, which differ by `gap`.
    Real {
        slow: DoubleDouble,
        fast: DoubleDouble,
        gap: DoubleDouble,
    },
}

/// How strongly a mass is damped; the distinction is exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damping {
    /// c = 0 with a spring: it oscillates for ever.
    Undamped,
    /// c² < 4mk.
    Underdamped,
    /// c² = 4mk: it returns fastest without oscillating.
    Critical,
    /// c² > 4mk, with a spring.
    Overdamped,
    /// No spring: it drifts, with or without a damper.
    Unsupported,
}

/// Where a coordinate is and how it moves at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Kinematics {
    /// In m.
    pub displacement: f64,
    /// In m/s.
    pub velocity: f64,
    /// In m/s².
    pub acceleration: f64,
}

impl std::ops::Add for Kinematics {
    type Output = Kinematics;

    fn add(self, other: Kinematics) -> Kinematics {
        Kinematics {
            displacement: self.displacement + other.displacement,
            velocity: self.velocity + other.velocity,
            acceleration: self.acceleration + other.acceleration,
        }
    }
}

/// Why there is no closed form for given coefficients.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum OneMassError {
    /// The mass is out of range.
    #[error("the mass is {value}: it must lie between 1e-70 and 1e70")]
    Mass {
        /// The value given, in kg.
        value: f64,
    },
    /// The damping is out of range.
    #[error("the damping is {value}: it must be 0 or lie between 1e-70 and 1e70")]
    Damping {
        /// The value given, in N·s/m.
        value: f64,
    },
    /// The stiffness is out of range.
    #[error("the stiffness is {value}: it must be 0 or lie between 1e-70 and 1e70")]
    Stiffness {
        /// The value given, in N/m.
        value: f64,
    },
}

impl MassSpringDamper {
    /// A mass in kg, a damping in N·s/m and a stiffness in N/m, both to ground.
    ///
    /// # Errors
    /// [`OneMassError`] unless each lies between 1e-70 and 1e70; damping and stiffness may be 0.
    pub fn new(mass: f64, damping: f64, stiffness: f64) -> Result<MassSpringDamper, OneMassError> {
        MassSpringDamper::from_sums(mass.into(), damping.into(), stiffness.into())
    }

    /// The same from coefficients that are sums of several elements.
    pub(crate) fn from_sums(
        mass: DoubleDouble,
        damping: DoubleDouble,
        stiffness: DoubleDouble,
    ) -> Result<MassSpringDamper, OneMassError> {
        let [m, c, k] = [mass, damping, stiffness].map(DoubleDouble::to_f64);
        if !RANGE.contains(&m) {
            return Err(OneMassError::Mass { value: m });
        }
        if c != 0.0 && !RANGE.contains(&c) {
            return Err(OneMassError::Damping { value: c });
        }
        if k != 0.0 && !RANGE.contains(&k) {
            return Err(OneMassError::Stiffness { value: k });
        }
        let twice_mass = mass * 2.0;
        let decay = damping / twice_mass;
        let natural_squared = stiffness / mass;
        // Both products of doubles are exact, so the sign of their difference is.
        let discriminant = damping * damping - mass * stiffness * 4.0;
        let root = discriminant.abs().sqrt() / twice_mass;
        let roots = if discriminant < DoubleDouble::ZERO {
            Roots::Complex { damped: root }
        } else {
            let fast = decay + root;
            let slow = match fast > DoubleDouble::ZERO {
                true => natural_squared / fast,
                false => DoubleDouble::ZERO,
            };
            let gap = root * 2.0;
            Roots::Real { slow, fast, gap }
        };
        Ok(MassSpringDamper {
            mass,
            stiffness,
            decay,
            natural_squared,
            roots,
        })
    }

    /// How strongly it is damped.
    pub fn damping(&self) -> Damping {
        match self.roots {
            _ if self.stiffness == DoubleDouble::ZERO => Damping::Unsupported,
            Roots::Complex { .. } if self.decay == DoubleDouble::ZERO => Damping::Undamped,
            Roots::Complex { .. } => Damping::Underdamped,
            Roots::Real { gap, .. } if gap == DoubleDouble::ZERO => Damping::Critical,
            Roots::Real { .. } => Damping::Overdamped,
        }
    }

    /// The free motion at `t` s ≥ 0 from displacement `x0` m and velocity `v0` m/s at t = 0:
    ///
    /// - underdamped and released, x = x₀ e^(−ζωt)/√(1−ζ²) · sin(ω_d t + θ), θ = arccos ζ;
    /// - undamped, x = x₀ cos ωt + (v₀/ω) sin ωt;
    /// - critical, x = (x₀ + (v₀ + ω x₀) t) e^(−ωt);
    /// - overdamped, x = ((v₀ + b x₀) e^(−at) − (v₀ + a x₀) e^(−bt))/(b − a) with
    ///   b = (c + √(c² − 4mk))/2m and a = 2k/(c + √(c² − 4mk));
    /// - unsupported, x = x₀ + v₀ t, or with a damper x₀ + v₀ (1 − e^(−ct/m)) m/c.
    pub fn free(&self, x0: f64, v0: f64, t: f64) -> Kinematics {
        self.free_after(x0, v0, t.into())
    }

    /// The motion from rest `t` s after a constant force of `force` N sets in; none for t < 0:
    ///
    /// - with a spring, x = (F/k) (1 − A), where A is the motion released from 1 m;
    /// - unsupported, x = F t²/2m, or with a damper (F m/c²) (ct/m − 1 + e^(−ct/m)).
    pub fn step(&self, force: f64, t: f64) -> Kinematics {
        self.step_after(force, t.into())
    }

    /// The motion from rest `t` s after an impulse of `momentum` N·s, which adds the velocity p/m;
    /// none for t < 0. It is the [free motion](Self::free) from that velocity.
    pub fn impulse(&self, momentum: f64, t: f64) -> Kinematics {
        self.impulse_after(momentum, t.into())
    }

    pub(crate) fn free_after(&self, x0: f64, v0: f64, t: DoubleDouble) -> Kinematics {
        let ImpulseResponse {
            displacement, rate, ..
        } = self.impulse_response(t);
        let natural_squared = self.natural_squared.to_f64();
        Kinematics {
            displacement: x0 * self.release(t) + v0 * displacement,
            velocity: v0 * rate - natural_squared * (x0 * displacement),
            acceleration: v0 * self.impulse_acceleration(displacement, rate)
                - natural_squared * (x0 * rate),
        }
    }

    pub(crate) fn step_after(&self, force: f64, t: DoubleDouble) -> Kinematics {
        if t < DoubleDouble::ZERO {
            return Kinematics::default();
        }
        let ImpulseResponse { displacement, rate } = self.impulse_response(t);
        let pull = force / self.mass.to_f64();
        Kinematics {
            displacement: pull * self.unit_step(t),
            velocity: pull * displacement,
            acceleration: pull * rate,
        }
    }

    pub(crate) fn impulse_after(&self, momentum: f64, t: DoubleDouble) -> Kinematics {
        if t < DoubleDouble::ZERO {
            return Kinematics::default();
        }
        self.free_after(0.0, momentum / self.mass.to_f64(), t)
    }

    /// The largest phase ω_d t in rad that is reached until `t` s.
    pub(crate) fn phase(&self, t: f64) -> f64 {
        match self.roots {
            Roots::Complex { damped } => damped.to_f64() * t,
            Roots::Real { .. } => 0.0,
        }
    }

    fn impulse_response(&self, t: DoubleDouble) -> ImpulseResponse {
        match self.roots {
            Roots::Complex { damped } => {
                let envelope = exp(-(self.decay * t));
                let (sin, cos) = sin_cos(damped * t);
                let ratio = self.decay.to_f64() / damped.to_f64();
                ImpulseResponse {
                    displacement: envelope * sin / damped.to_f64(),
                    rate: envelope * (cos - ratio * sin),
                }
            }
            Roots::Real { slow, fast, gap } => {
                let displacement = exp(-(slow * t)) * t.to_f64() * mean_decay(gap * t);
                let rate = exp(-(fast * t)) - slow.to_f64() * displacement;
                ImpulseResponse { displacement, rate }
            }
        }
    }

    /// B″ = −2σ B′ − ω² B.
    fn impulse_acceleration(&self, displacement: f64, rate: f64) -> f64 {
        -(2.0 * self.decay.to_f64() * rate + self.natural_squared.to_f64() * displacement)
    }

    /// A.
    fn release(&self, t: DoubleDouble) -> f64 {
        match self.roots {
            Roots::Complex { damped } => {
                let (sin, cos) = sin_cos(damped * t);
                let ratio = self.decay.to_f64() / damped.to_f64();
                exp(-(self.decay * t)) * (cos + ratio * sin)
            }
            Roots::Real { slow, .. } => {
                exp(-(slow * t)) + slow.to_f64() * self.impulse_response(t).displacement
            }
        }
    }

    /// m S.
    fn unit_step(&self, t: DoubleDouble) -> f64 {
        let natural_squared = self.natural_squared.to_f64();
        let fastest = match self.roots {
            Roots::Complex { .. } => natural_squared.sqrt(),
            Roots::Real { fast, .. } => fast.to_f64(),
        };
        if fastest * t.to_f64() < 1.0 {
            return self.unit_step_series(t.to_f64());
        }
        match self.roots {
            Roots::Complex { damped } => {
                let exponent = -(self.decay * t);
                let phase = reduce(damped * t);
                let (half, _) = sin_cos(phase * 0.5);
                let (sin, _) = sin_cos(phase);
                let ratio = self.decay.to_f64() / damped.to_f64();
                let swing = 2.0 * half * half - ratio * sin;
                (exp(exponent) * swing - exponent.to_f64().exp_m1()) / natural_squared
            }
            Roots::Real { slow, fast, .. } => {
                let drift = t.to_f64() * mean_decay(slow * t);
                (drift - self.impulse_response(t).displacement) / fast.to_f64()
            }
        }
    }

    /// m S by its Taylor series, for roots of modulus below 1/t. Its coefficients follow from the
    /// equation of motion: x_(j+2) (j+1)(j+2) = −2σ (j+1) x_(j+1) − ω² x_j. The term in t^(j+2) is
    /// at most (j+1)/(j+2)! t²: 20 of them reach 1e-18 t².
    fn unit_step_series(&self, t: f64) -> f64 {
        let first = 2.0 * self.decay.to_f64() * t;
        let second = self.natural_squared.to_f64() * t * t;
        let (mut before, mut last) = (0.0, 0.5);
        let mut sum = last;
        for j in 1..20 {
            let j = f64::from(j);
            let next = -(first * (j + 1.0) * last + second * before) / ((j + 1.0) * (j + 2.0));
            (before, last) = (last, next);
            sum += next;
        }
        sum * t * t
    }
}

/// B and B′.
struct ImpulseResponse {
    displacement: f64,
    rate: f64,
}

/// e^x for x ≤ 0 with the error of a double exponent removed.
fn exp(x: DoubleDouble) -> f64 {
    // Beyond the range of doubles the low part may be NaN.
    if x.high() < -750.0 {
        return 0.0;
    }
    x.high().exp() * (1.0 + x.low())
}

/// (1 − e^(−x))/x for x ≥ 0.
fn mean_decay(x: DoubleDouble) -> f64 {
    let x = x.high();
    if x == 0.0 { 1.0 } else { -(-x).exp_m1() / x }
}

/// The angle in −π … π, from one below 2^48.
fn reduce(angle: DoubleDouble) -> DoubleDouble {
    let turns = (angle.high() / std::f64::consts::TAU).round();
    angle - DoubleDouble::TAU * turns
}

fn sin_cos(angle: DoubleDouble) -> (f64, f64) {
    let angle = reduce(angle);
    let (sin, cos) = angle.high().sin_cos();
    (sin + angle.low() * cos, cos - angle.low() * sin)
}
