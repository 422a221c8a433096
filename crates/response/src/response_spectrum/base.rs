//! How a base is shaken.

use crate::problem::{HalfSine, Hold, Load, LoadError, Samples, Versine};

/// The acceleration of a base, in m/s² where forces are in N; it is at rest before, and moves on evenly after it.
#[derive(Clone, Debug, PartialEq)]
pub enum BaseAcceleration {
    /// A record. Unlike a load it ends: with [`Hold::First`] at its last sample, with [`Hold::Zero`] a step later.
    Record(Samples),
    /// Half a sine.
    HalfSine(HalfSine),
    /// A whole period of 1 − cosine.
    Versine(Versine),
}

macro_rules! into_base {
    ($($from:ident => $kind:ident),*) => {$(
        impl From<$from> for BaseAcceleration {
            fn from(base: $from) -> BaseAcceleration {
                BaseAcceleration::$kind(base)
            }
        }
    )*};
}
into_base!(Samples => Record, HalfSine => HalfSine, Versine => Versine);

impl BaseAcceleration {
    pub(super) fn check(&self) -> Result<(), LoadError> {
        match self {
            BaseAcceleration::Record(samples) => {
                Load::from(samples.clone()).check()?;
                // Of a load that is part of the fit to a grid.
                match samples.step.is_finite() && samples.step > 0.0 {
                    true => Ok(()),
                    false => Err(LoadError::SampleStep { step: samples.step }),
                }
            }
            BaseAcceleration::HalfSine(pulse) => Load::from(*pulse).check(),
            BaseAcceleration::Versine(pulse) => Load::from(*pulse).check(),
        }
    }

    /// The unit of time within which it follows one law, in s.
    pub(super) fn interval(&self) -> f64 {
        match self {
            BaseAcceleration::Record(samples) => samples.step,
            BaseAcceleration::HalfSine(pulse) => pulse.duration,
            BaseAcceleration::Versine(pulse) => pulse.duration,
        }
    }

    /// When it begins, in s.
    pub(super) fn start(&self) -> f64 {
        match self {
            BaseAcceleration::Record(_) => 0.0,
            BaseAcceleration::HalfSine(pulse) => pulse.start,
            BaseAcceleration::Versine(pulse) => pulse.start,
        }
    }

    /// How many intervals it has.
    pub(super) fn intervals(&self) -> usize {
        match self {
            BaseAcceleration::Record(samples) => match samples.hold {
                Hold::Zero => samples.values.len(),
                Hold::First => samples.values.len() - 1,
            },
            _ => 1,
        }
    }

    /// Half turns in an interval; 0 for what is straight.
    pub(super) fn half_turns(&self) -> f64 {
        match self {
            BaseAcceleration::Record(_) => 0.0,
            BaseAcceleration::HalfSine(_) => 1.0,
            BaseAcceleration::Versine(_) => 2.0,
        }
    }

    /// The law of a pulse at its beginning: acceleration, its rate over the angular one, and what it swings about.
    pub(super) fn pulse(&self) -> [f64; 3] {
        match self {
            BaseAcceleration::Record(_) => [0.0; 3],
            BaseAcceleration::HalfSine(pulse) => [0.0, pulse.force, 0.0],
            BaseAcceleration::Versine(pulse) => [0.0, 0.0, 0.5 * pulse.force],
        }
    }
}
