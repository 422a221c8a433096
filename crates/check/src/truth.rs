//! What answers are compared with: the reference with more digits where it can be afforded, else what
//! the plan proves.

use eigentone_modes::{Eigenvalue, Modes, ModesError, System};
use eigentone_response::{Problem, ResponseError, ResponsePlan, Trajectory};
use num_complex::Complex;

use crate::reference::{Ball, EigenvalueError, Reference, ReferenceModes, ReferenceResponse};
use crate::trajectory_error::TrajectoryError;

/// Digits that show how far a double is off its nearest neighbour.
const DIGITS: u32 = 24;

/// Multiplications of long numbers: a few seconds.
const WORK: f64 = 3e7;

/// The name of the reference.
const REFERENCE: &str = "reference";

/// The true motion.
pub(crate) enum MotionTruth {
    Reference {
        motion: ReferenceResponse,
        peaks: [f64; 2],
    },
    /// Of the plan's method, or rounded from a closed form.
    Doubles(Box<Trajectory>),
}

impl MotionTruth {
    /// # Errors
    /// What the plan and its method report, where the reference is too expensive.
    pub(crate) fn of(problem: &Problem<'_>) -> Result<MotionTruth, ResponseError> {
        let reference = Reference::with_digits(DIGITS).within(WORK);
        match reference.response(problem) {
            Ok(motion) => {
                let largest = |of: fn(&ReferenceResponse, usize) -> &[Ball]| {
                    let values = (0..motion.steps().len()).flat_map(|k| of(&motion, k));
                    values.map(|x| x.nearest().abs()).fold(0.0, f64::max)
                };
                let peaks = [
                    largest(ReferenceResponse::displacement),
                    largest(ReferenceResponse::velocity),
                ];
                Ok(MotionTruth::Reference { motion, peaks })
            }
            Err(_) => {
                let motion = ResponsePlan::of(problem)?.run(problem)?;
                Ok(MotionTruth::Doubles(Box::new(motion)))
            }
        }
    }

    pub(crate) fn name(&self) -> &'static str {
        match self {
            MotionTruth::Reference { .. } => REFERENCE,
            MotionTruth::Doubles(motion) => motion.method(),
        }
    }

    /// The largest displacement and velocity; infinite beyond the largest double.
    pub(crate) fn peaks(&self) -> [f64; 2] {
        match self {
            MotionTruth::Reference { peaks, .. } => *peaks,
            MotionTruth::Doubles(motion) => {
                [motion.displacement(), motion.velocity()].map(|of| of.norm_max())
            }
        }
    }

    /// Whether an answer's displacements stay within ten times the largest one there is; `None` where that is no double.
    pub(crate) fn is_stable(&self, answer: &Trajectory) -> Option<bool> {
        const UNSTABLE: f64 = 10.0;
        let [peak, _] = self.peaks();
        (peak < f64::INFINITY).then(|| answer.displacement().norm_max() <= UNSTABLE * peak)
    }

    /// How far an answer to the same problem is off; `None` for the reference itself.
    pub(crate) fn error_of(&self, answer: &Trajectory) -> Option<TrajectoryError> {
        match self {
            MotionTruth::Reference { motion, .. } => {
                Some(motion.error_of(answer).unwrap_or(TrajectoryError {
                    displacement: f64::INFINITY,
                    velocity: f64::INFINITY,
                }))
            }
            MotionTruth::Doubles(motion) if motion.method() == answer.method() => None,
            MotionTruth::Doubles(motion) => Some(TrajectoryError::between(answer, motion)),
        }
    }
}

/// The true modes.
pub(crate) enum ModesTruth {
    Reference(ReferenceModes),
    /// With the bounds of the plan, or rounded from a closed form.
    Doubles(Vec<Complex<f64>>),
}

impl ModesTruth {
    /// # Errors
    /// What the plan's solver reports, where the reference is too expensive.
    pub(crate) fn of(system: &System) -> Result<ModesTruth, ModesError> {
        let reference = Reference::with_digits(DIGITS).within(WORK);
        match reference.modes(system) {
            Ok(modes) => Ok(ModesTruth::Reference(modes)),
            Err(_) => {
                let modes = system.modes()?;
                let values = modes.eigenvalues().iter().map(|one| one.value);
                Ok(ModesTruth::Doubles(values.collect()))
            }
        }
    }

    /// The name of the reference, or of the plan's answer.
    pub(crate) fn name(&self, planned: &'static str) -> &'static str {
        match self {
            ModesTruth::Reference(_) => REFERENCE,
            ModesTruth::Doubles(_) => planned,
        }
    }

    /// How far an answer for the same system is off; infinite where it has another number of roots.
    pub(crate) fn error_of(&self, answer: &Modes) -> EigenvalueError {
        match self {
            ModesTruth::Reference(modes) => {
                let nothing = EigenvalueError {
                    modulus: f64::INFINITY,
                    real_part: f64::INFINITY,
                };
                modes.error_of(answer).unwrap_or(nothing)
            }
            ModesTruth::Doubles(values) => between(answer.eigenvalues(), values),
        }
    }
}

/// The distance of `eigenvalues` from a `reference` sorted by size, the largest of which is matched first with the nearest that is left.
fn between(eigenvalues: &[Eigenvalue], reference: &[Complex<f64>]) -> EigenvalueError {
    let mut worst = EigenvalueError {
        modulus: 0.0,
        real_part: 0.0,
    };
    let mut left: Vec<_> = eigenvalues.iter().map(|one| one.value).collect();
    for truth in reference.iter().rev().copied() {
        let distances = left.iter().map(|value| (value - truth).norm());
        let nearest = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        let off = match nearest {
            Some((position, _)) => left.swap_remove(position) - truth,
            None => truth * f64::INFINITY,
        };
        let relative = |off: f64, of: f64| if off == 0.0 { 0.0 } else { off / of };
        worst.modulus = worst.modulus.max(relative(off.norm(), truth.norm()));
        let size = if truth.re == 0.0 {
            truth.norm()
        } else {
            truth.re.abs()
        };
        worst.real_part = worst.real_part.max(relative(off.re.abs(), size));
    }
    if !left.is_empty() {
        worst.modulus = f64::INFINITY;
    }
    worst
}
