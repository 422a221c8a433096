//! Why there is no response spectrum.

use thiserror::Error;

use crate::problem::LoadError;

/// Why there is no response spectrum.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SpectrumError {
    /// The acceleration of the base is wrong by itself.
    #[error("the acceleration of the base: {0}")]
    Base(#[from] LoadError),
    /// Sums of a record leave the range of doubles.
    #[error(
        "the motion of the base at the end of the record leaves the range of doubles: give accelerations and durations in units that bring them closer together"
    )]
    BaseRange,
    /// A frequency that none can have.
    #[error("frequency {index} is {frequency:?} Hz: it must be a finite number greater than 0")]
    Frequency {
        /// Which frequency, from 0.
        index: usize,
        /// The value given, in Hz.
        frequency: f64,
    },
    /// A damping ratio that is negative, or no number.
    #[error("the damping ratio is {ratio:?}: it must be a finite number, 0 or more")]
    Ratio {
        /// The value given.
        ratio: f64,
    },
    /// The search for the largest values ends before much is known of them.
    #[error(
        "the largest motion at {frequency:?} Hz is not known to six digits: within {interval:?} s, from one sample to the next or during a pulse, it turns too often or decays too fast: take a lower frequency or damping ratio, or give samples that are closer together"
    )]
    Undecided {
        /// In Hz.
        frequency: f64,
        /// Between two samples, or the duration of a pulse, in s.
        interval: f64,
    },
    /// Motions, or what they are computed from, leave the range of doubles.
    #[error(
        "the motion at {frequency:?} Hz leaves the range of doubles: give accelerations, durations and frequencies in units that bring them closer together"
    )]
    OutOfRange {
        /// In Hz.
        frequency: f64,
    },
}
