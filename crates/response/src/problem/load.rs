//! Forces on the coordinates, as functions of time that the response treats without error.

use thiserror::Error;

/// A force on one coordinate, in N (or a torque in N·m). Loads on the same coordinate add up.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Load {
    /// A constant force from an instant on.
    Step(Step),
    /// A force that grows in proportion to time from an instant on.
    Ramp(Ramp),
    /// An impulse that changes the velocity at once.
    Impulse(Impulse),
    /// A sinusoidal force from t = 0 on.
    Harmonic(Harmonic),
    /// A force given by equally spaced samples from t = 0 on.
    Samples(Samples),
    /// Half a period of a sine.
    HalfSine(HalfSine),
    /// A whole period of 1 − cosine.
    Versine(Versine),
    /// A polynomial of time from an instant on.
    Polynomial(Polynomial),
}

/// `force` N for t ≥ `start`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// In N.
    pub force: f64,
    /// In s. A step that starts before 0 is already on at 0.
    pub start: f64,
}

impl Step {
    /// A force in N that is on from t = 0.
    pub fn of(force: f64) -> Step {
        Step { force, start: 0.0 }
    }

    /// The same step from `start` s on.
    pub fn starting_at(self, start: f64) -> Step {
        Step { start, ..self }
    }
}

/// `rate`·(t − `start`) N for t ≥ `start`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    /// In N/s.
    pub rate: f64,
    /// In s. A ramp that starts before 0 is already running at 0.
    pub start: f64,
}

impl Ramp {
    /// A force growing by `rate` N/s from t = 0.
    pub fn of(rate: f64) -> Ramp {
        Ramp { rate, start: 0.0 }
    }

    /// The same ramp from `start` s on.
    pub fn starting_at(self, start: f64) -> Ramp {
        Ramp { start, ..self }
    }
}

/// A momentum of `magnitude` N·s given at the instant `at`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impulse {
    /// In N·s.
    pub magnitude: f64,
    /// In s, not before 0.
    pub at: f64,
}

impl Impulse {
    /// An impulse of `magnitude` N·s at t = 0.
    pub fn of(magnitude: f64) -> Impulse {
        Impulse { magnitude, at: 0.0 }
    }

    /// The same impulse at the instant `at`, in s.
    pub fn at(self, at: f64) -> Impulse {
        Impulse { at, ..self }
    }
}

/// `amplitude`·sin(`frequency`·t + `phase`) N for t ≥ 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Harmonic {
    /// In N.
    pub amplitude: f64,
    /// In rad/s.
    pub frequency: f64,
    /// In rad.
    pub phase: f64,
}

impl Harmonic {
    /// amplitude·sin(frequency·t), with the amplitude in N and the frequency in rad/s.
    pub fn of(amplitude: f64, frequency: f64) -> Harmonic {
        Harmonic {
            amplitude,
            frequency,
            phase: 0.0,
        }
    }

    /// The same with a phase in rad.
    pub fn with_phase(self, phase: f64) -> Harmonic {
        Harmonic { phase, ..self }
    }
}

/// `force`·sin(π(t − `start`)/`duration`) N from `start` on for `duration` s, else 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSine {
    /// Its largest value, in N.
    pub force: f64,
    /// In s, greater than 0.
    pub duration: f64,
    /// In s, not before 0.
    pub start: f64,
}

impl HalfSine {
    /// A force that swells to so many N and fades within so many s, from t = 0 on.
    pub fn of(force: f64, duration: f64) -> HalfSine {
        HalfSine {
            force,
            duration,
            start: 0.0,
        }
    }

    /// The same from `start` s on.
    pub fn starting_at(self, start: f64) -> HalfSine {
        HalfSine { start, ..self }
    }
}

/// `force`/2·(1 − cos(2π(t − `start`)/`duration`)) N from `start` on for `duration` s, else 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Versine {
    /// Its largest value, in N.
    pub force: f64,
    /// In s, greater than 0.
    pub duration: f64,
    /// In s, not before 0.
    pub start: f64,
}

impl Versine {
    /// A force that swells to so many N and fades within so many s, smoothly, from t = 0 on.
    pub fn of(force: f64, duration: f64) -> Versine {
        Versine {
            force,
            duration,
            start: 0.0,
        }
    }

    /// The same from `start` s on.
    pub fn starting_at(self, start: f64) -> Versine {
        Versine { start, ..self }
    }
}

/// c₀ + c₁τ + c₂τ² + … N for τ = t − `start` ≥ 0, of degree 6 at most.
#[derive(Clone, Debug, PartialEq)]
pub struct Polynomial {
    /// Of τ⁰, τ¹, …: in N, N/s, N/s², ….
    pub coefficients: Vec<f64>,
    /// In s, not before 0.
    pub start: f64,
}

impl Polynomial {
    /// k! by k, as far as a polynomial goes.
    const FACTORIALS: [u32; 7] = [1, 1, 2, 6, 24, 120, 720];

    /// A force with these coefficients of t⁰, t¹, … from t = 0 on.
    pub fn of(coefficients: impl Into<Vec<f64>>) -> Polynomial {
        Polynomial {
            coefficients: coefficients.into(),
            start: 0.0,
        }
    }

    /// The same from `start` s on.
    pub fn starting_at(self, start: f64) -> Polynomial {
        Polynomial { start, ..self }
    }

    /// The same as steps, each integrated so many times: cₖτᵏ is the k-fold integral of k!·cₖ, which is a sum of multiples of cₖ by
    /// powers of two, so that nothing is rounded.
    pub(super) fn steps(&self) -> impl Iterator<Item = (usize, Step)> + '_ {
        let terms = self.coefficients.iter().zip(Polynomial::FACTORIALS);
        let terms = terms.enumerate().filter(|(_, (value, _))| **value != 0.0);
        terms.flat_map(move |(k, (value, factorial))| {
            let powers = (0..u32::BITS).map(|bit| 1 << bit);
            let powers = powers.filter(move |power: &u32| factorial & power != 0);
            powers.map(move |power| {
                let force = value * f64::from(power);
                (k, Step::of(force).starting_at(self.start))
            })
        })
    }
}

/// What a sampled force does between its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hold {
    /// It keeps the last sample (zero-order hold).
    Zero,
    /// It runs straight from one sample to the next (first-order hold).
    First,
}

/// Sample j holds at t = j·`step`; after the last sample its value stays.
///
/// ```
/// use eigentone_modes::{GROUND, System};
/// use eigentone_response::{Hold, Response, Samples};
///
/// let system = System::builder().mass("m", 1.0).spring(GROUND, "m", 1.0).build()?;
/// let measured = Samples {
///     step: 0.5,
///     values: vec![0.0, 1.0, 0.25, 0.0],
///     hold: Hold::First,
/// };
/// // Answers every 0.1 s: the samples' step is five times that.
/// let answer = Response::of(&system).load("m", measured).every(0.1).until(3.0).run()?;
/// assert_eq!(answer.len(), 31);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    /// In s; the response's step times or divided by a whole number.
    pub step: f64,
    /// In N; at least one.
    pub values: Vec<f64>,
    /// What happens in between.
    pub hold: Hold,
}

macro_rules! into_load {
    ($($kind:ident),*) => {$(
        impl From<$kind> for Load {
            fn from(load: $kind) -> Load {
                Load::$kind(load)
            }
        }
    )*};
}
into_load!(
    Step, Ramp, Impulse, Harmonic, Samples, HalfSine, Versine, Polynomial
);

/// What can be wrong with a load by itself.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LoadError {
    /// A parameter is infinite or NaN.
    #[error("its {parameter} is {value:?}: it must be a finite number")]
    NotFinite {
        /// The parameter's name.
        parameter: &'static str,
        /// The value given.
        value: f64,
    },
    /// An impulse before the response starts.
    #[error("its instant is {at:?}: an impulse must not come before 0")]
    ImpulseBeforeStart {
        /// The instant given.
        at: f64,
    },
    /// A pulse that takes no time.
    #[error("its duration is {duration:?}: it must be at least 1e-300")]
    Duration {
        /// The duration given.
        duration: f64,
    },
    /// A polynomial without coefficients, or of too high a degree.
    #[error("it has {count} coefficients: give 1 to 7, of the powers 0 to 6 of time")]
    Coefficients {
        /// How many there are.
        count: usize,
    },
    /// A coefficient is infinite, NaN or too large.
    #[error("its coefficient {index} is {value:?}: it must be a finite number below 1e305")]
    CoefficientNotFinite {
        /// Of which power.
        index: usize,
        /// The value given.
        value: f64,
    },
    /// A pulse or a polynomial before the response starts.
    #[error("its start is {start:?}: a pulse or a polynomial must not start before 0")]
    PulseBeforeStart {
        /// The start given.
        start: f64,
    },
    /// The motion of a support given as an impulse.
    #[error("it is an impulse, which only a force can be: give a step of the velocity instead")]
    ImpulseOfMotion,
    /// A support that carries mass jumps.
    #[error(
        "the displacement jumps, and {support:?} carries mass, which would take an infinite force: give a motion that begins at 0 and has no jumps"
    )]
    JumpOfMass {
        /// The support.
        support: String,
    },
    /// A sampled force without samples.
    #[error("it has no values: give at least one sample")]
    NoSamples,
    /// A sample is infinite or NaN.
    #[error("its sample {index} is {value:?}: it must be a finite number")]
    SampleNotFinite {
        /// Which sample, from 0.
        index: usize,
        /// The value given.
        value: f64,
    },
    /// The samples' spacing is not positive.
    #[error("its step is {step:?}: it must be greater than 0")]
    SampleStep {
        /// The spacing given.
        step: f64,
    },
    /// The samples' spacing does not fit the response's grid.
    #[error(
        "its step is {step:?}, but the response's is {grid:?}: it must be that times or divided by a whole number"
    )]
    SampleGrid {
        /// The spacing given.
        step: f64,
        /// The response's step.
        grid: f64,
    },
}

impl Load {
    /// The last time in s at which it changes its law.
    pub(super) fn last_change(&self) -> f64 {
        match self {
            Load::Step(step) => step.start,
            Load::Ramp(ramp) => ramp.start,
            Load::Impulse(impulse) => impulse.at,
            Load::Harmonic(_) => 0.0,
            Load::Samples(samples) => samples.step * (samples.values.len() as f64 - 1.0),
            Load::HalfSine(pulse) => pulse.start.max(0.0) + pulse.duration,
            Load::Versine(pulse) => pulse.start.max(0.0) + pulse.duration,
            Load::Polynomial(polynomial) => polynomial.start,
        }
    }

    /// Whether it is 0 at all times.
    pub(super) fn is_zero(&self) -> bool {
        let all_zero = |values: &[f64]| values.iter().all(|value| *value == 0.0);
        match self {
            Load::Step(step) => step.force == 0.0,
            Load::Ramp(ramp) => ramp.rate == 0.0,
            Load::Impulse(impulse) => impulse.magnitude == 0.0,
            Load::Harmonic(harmonic) => harmonic.amplitude == 0.0,
            Load::Samples(samples) => all_zero(&samples.values),
            Load::HalfSine(pulse) => pulse.force == 0.0,
            Load::Versine(pulse) => pulse.force == 0.0,
            Load::Polynomial(polynomial) => all_zero(&polynomial.coefficients),
        }
    }

    /// Whether it jumps, as the motion of what is at rest before t = 0.
    pub(crate) fn jumps(&self) -> bool {
        match self {
            Load::Step(step) => step.force != 0.0,
            Load::Ramp(ramp) => ramp.rate != 0.0 && ramp.start < 0.0,
            Load::Harmonic(harmonic) => harmonic.amplitude != 0.0 && harmonic.phase != 0.0,
            Load::Samples(samples) => {
                let mut values = samples.values.iter();
                let first = samples.values.first().is_some_and(|value| *value != 0.0);
                first || samples.hold == Hold::Zero && values.any(|value| *value != 0.0)
            }
            Load::HalfSine(_) | Load::Versine(_) => false,
            Load::Polynomial(polynomial) => {
                let first = polynomial.coefficients.first();
                first.is_some_and(|value| *value != 0.0)
            }
            Load::Impulse(_) => true,
        }
    }

    /// Checks the parameters by themselves; the fit of a sample step to a time grid is checked
    /// where both are known.
    pub(crate) fn check(&self) -> Result<(), LoadError> {
        let finite = |parameters: &[(&'static str, f64)]| match parameters
            .iter()
            .find(|(_, value)| !value.is_finite())
        {
            Some(&(parameter, value)) => Err(LoadError::NotFinite { parameter, value }),
            None => Ok(()),
        };
        match self {
            Load::Step(step) => finite(&[("force", step.force), ("start", step.start)]),
            Load::Ramp(ramp) => finite(&[("rate", ramp.rate), ("start", ramp.start)]),
            Load::Impulse(impulse) => {
                finite(&[("magnitude", impulse.magnitude), ("at", impulse.at)])?;
                if impulse.at < 0.0 {
                    return Err(LoadError::ImpulseBeforeStart { at: impulse.at });
                }
                Ok(())
            }
            Load::Harmonic(harmonic) => finite(&[
                ("amplitude", harmonic.amplitude),
                ("frequency", harmonic.frequency),
                ("phase", harmonic.phase),
            ]),
            Load::HalfSine(HalfSine {
                force,
                duration,
                start,
            })
            | Load::Versine(Versine {
                force,
                duration,
                start,
            }) => {
                finite(&[
                    ("force", *force),
                    ("duration", *duration),
                    ("start", *start),
                ])?;
                if *duration < 1e-300 || (start + duration).is_infinite() {
                    return Err(LoadError::Duration {
                        duration: *duration,
                    });
                }
                if *start < 0.0 {
                    return Err(LoadError::PulseBeforeStart { start: *start });
                }
                Ok(())
            }
            Load::Polynomial(Polynomial {
                coefficients,
                start,
            }) => {
                const LARGEST: f64 = 1e305;
                finite(&[("start", *start)])?;
                let count = coefficients.len();
                if !(1..=Polynomial::FACTORIALS.len()).contains(&count) {
                    return Err(LoadError::Coefficients { count });
                }
                let mut all = coefficients.iter().copied().enumerate();
                if let Some((index, value)) =
                    all.find(|(_, value)| !(-LARGEST..LARGEST).contains(value))
                {
                    return Err(LoadError::CoefficientNotFinite { index, value });
                }
                if *start < 0.0 {
                    return Err(LoadError::PulseBeforeStart { start: *start });
                }
                Ok(())
            }
            Load::Samples(samples) => {
                finite(&[("step", samples.step)])?;
                if samples.step <= 0.0 {
                    return Err(LoadError::SampleStep { step: samples.step });
                }
                if samples.values.is_empty() {
                    return Err(LoadError::NoSamples);
                }
                match samples.values.iter().position(|value| !value.is_finite()) {
                    Some(index) => {
                        let value = samples.values[index];
                        Err(LoadError::SampleNotFinite { index, value })
                    }
                    None => Ok(()),
                }
            }
        }
    }
}
