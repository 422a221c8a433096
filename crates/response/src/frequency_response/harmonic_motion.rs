//! The amplitudes of all coordinates under forces of one frequency, with proven bounds.

use eigentone_modes::{System, dense_gigabytes};
use num_complex::Complex;
use thiserror::Error;

use super::dynamic_stiffness::{DynamicStiffness, Part};
use super::enclosure::{Asked, Enclosed, Question, Value, enclose};
use super::ports::{Push, Reading};

/// A motion x(t) = Im(X e^{iΩt}) of all coordinates with one frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct HarmonicMotion {
    frequency: f64,
    displacement: Vec<Complex<f64>>,
    bound: Vec<f64>,
}

impl HarmonicMotion {
    /// Ω in rad/s.
    pub fn frequency(&self) -> f64 {
        self.frequency
    }

    /// X: the complex amplitude of each coordinate, in m.
    pub fn displacement(&self) -> &[Complex<f64>] {
        &self.displacement
    }

    /// For each coordinate a proven bound of how far [`displacement`](Self::displacement) is from
    /// the exact amplitude, in m. It is a few units in the last place of the amplitude itself,
    /// unless that is less than 1e-30 of the largest one.
    pub fn bound(&self) -> &[f64] {
        &self.bound
    }

    /// iΩX: the amplitudes of the velocities, in m/s, rounded once more.
    pub fn velocity(&self) -> Vec<Complex<f64>> {
        let turned = |x: &Complex<f64>| Complex::new(-x.im, x.re) * self.frequency;
        self.displacement.iter().map(turned).collect()
    }

    /// −Ω²X: the amplitudes of the accelerations, in m/s², rounded twice more.
    pub fn acceleration(&self) -> Vec<Complex<f64>> {
        let twice = |x: &Complex<f64>| -*x * self.frequency * self.frequency;
        self.displacement.iter().map(twice).collect()
    }

    /// X_to / X_from, the transmissibility from one coordinate to another, by their indices; `None`
    /// where an index is out of range or the first coordinate stands still.
    pub fn transmissibility(&self, from: usize, to: usize) -> Option<Complex<f64>> {
        let (from, to) = (self.displacement.get(from)?, self.displacement.get(to)?);
        let ratio = to / from;
        ratio.is_finite().then_some(ratio)
    }
}

/// Why there is no steady state.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SteadyStateError {
    /// K − Ω²M + iΩC is proved to be singular.
    #[error(
        "{frequency:?} rad/s is a natural frequency without damping: the motion there grows or is not determined"
    )]
    Resonance {
        /// Ω in rad/s.
        frequency: f64,
    },
    /// K is proved to be singular, and a constant load asks for an equilibrium.
    #[error("a load of frequency 0 is constant, and no springs hold what it acts on")]
    Unsupported,
    /// The highest precision does not distinguish K − Ω²M + iΩC from a singular matrix.
    #[error(
        "{frequency:?} rad/s cannot be distinguished from a natural frequency without damping, even with {digits} digits"
    )]
    Undecided {
        /// Ω in rad/s.
        frequency: f64,
        /// The digits that were tried.
        digits: usize,
    },
    /// A velocity or acceleration that is constant moves a support ever further.
    #[error(
        "a motion of frequency 0 is constant: a support of constant velocity or acceleration has no place where it stays"
    )]
    Drift,
    /// An amplitude exceeds the largest double.
    #[error("an amplitude at {frequency:?} rad/s exceeds the largest double")]
    OutOfRange {
        /// Ω in rad/s.
        frequency: f64,
    },
    /// The system is [large](System::is_large).
    #[error(
        "amplitudes need all {coordinates} coordinates as dense matrices with many digits, {gigabytes:.1} GB in doubles alone: look at its lowest modes, by ModalTruncation"
    )]
    TooLarge {
        /// How many coordinates there are.
        coordinates: usize,
        /// What M, C, K and one state matrix would take.
        gigabytes: f64,
    },
    /// A frequency is infinite or NaN.
    #[error("the frequency is {frequency:?}: it must be a finite number")]
    FrequencyNotFinite {
        /// The frequency given.
        frequency: f64,
    },
    /// A name that is no coordinate.
    #[error("{name:?} is not a coordinate: known: {known}")]
    UnknownCoordinate {
        /// The name given.
        name: String,
        /// The names that exist.
        known: String,
    },
}

/// The amplitudes under what acts with one frequency.
pub(super) fn motion(
    system: &System,
    frequency: f64,
    pushes: &[Push],
) -> Result<HarmonicMotion, SteadyStateError> {
    if system.is_large() {
        let coordinates = system.len();
        return Err(SteadyStateError::TooLarge {
            coordinates,
            gigabytes: dense_gigabytes(coordinates),
        });
    }
    let stiffness = DynamicStiffness::of(system, &[]);
    let block = stiffness.block(&stiffness.reached(pushes.iter().map(|push| push.coordinate)));
    let readings: Vec<Reading> = block
        .coordinates()
        .iter()
        .map(|&i| Reading {
            of: vec![(i, Part::of(0, [1.0; 2]))],
            more: Vec::new(),
        })
        .collect();
    let question = Question {
        block: &block,
        modes: None,
        modal: &[],
        frequency: frequency.into(),
        columns: &[(pushes, &readings)],
        asked: Asked::Value,
    };
    let mut found = match enclose(&question) {
        Enclosed::Values(found, _) => found,
        Enclosed::Singular if frequency == 0.0 => return Err(SteadyStateError::Unsupported),
        Enclosed::Singular => return Err(SteadyStateError::Resonance { frequency }),
        Enclosed::Undecided(digits) => {
            return Err(SteadyStateError::Undecided { frequency, digits });
        }
    };
    let found = found.pop().expect("one right-hand side");
    let is_finite = |known: &Value| known.value.is_finite() && known.bound.is_finite();
    if !found.iter().all(is_finite) {
        return Err(SteadyStateError::OutOfRange { frequency });
    }
    let mut displacement = vec![Complex::ZERO; system.len()];
    let mut bound = vec![0.0; system.len()];
    for (&coordinate, known) in block.coordinates().iter().zip(found) {
        (displacement[coordinate], bound[coordinate]) = (known.value, known.bound);
    }
    Ok(HarmonicMotion {
        frequency,
        displacement,
        bound,
    })
}
