//! Why there is no reference.

use thiserror::Error;

/// Why a reference cannot be given.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ReferenceError {
    /// More work than a reference is worth.
    #[error(
        "it would take about {work:.0e} multiplications, more than the {limit:.0e} allowed: ask for fewer coordinates, instants or digits"
    )]
    TooMuchWork {
        /// An estimate of the multiplications of whole numbers.
        work: f64,
        /// The most that is allowed.
        limit: f64,
    },
    /// The digits asked for were not reached.
    #[error("{digits} digits were not reached with numbers of {bits} bits")]
    TooManyBits {
        /// The digits asked for.
        digits: u32,
        /// The bits of the last attempt.
        bits: u64,
    },
    /// The motion may grow beyond all that doubles span.
    #[error(
        "a motion of the system may grow by more than 2^2200 until the end: ask for an earlier end"
    )]
    TooFast,
    /// M is singular and not only by coordinates without mass.
    #[error("the mass matrix is singular although no row and column of it vanishes")]
    SingularMass,
    /// A damper between a coordinate without mass and one with mass is met by another that cancels it.
    #[error("the dampers on coordinates without mass act on some of them in one direction only")]
    MasslessDampers,
    /// The springs on coordinates without mass leave one of them free.
    #[error("the springs on coordinates without mass cancel, which makes them a constraint")]
    MasslessConstraint,
    /// An impulse on a coordinate that neither mass nor damper resists.
    #[error("load {load} is an impulse that neither mass nor damper resists")]
    ImpulseGivesWay {
        /// Which load, from 0.
        load: usize,
    },
    /// A load of a kind that the reference does not know.
    #[error("load {load} is of a kind that the reference does not know")]
    UnknownLoad {
        /// Which load, from 0.
        load: usize,
    },
    /// What is compared with the reference belongs to another problem.
    #[error("the answer has other coordinates, instants or eigenvalues than the reference")]
    OtherProblem,
}
