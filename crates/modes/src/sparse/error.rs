//! Why there are no modes of a large system.

use thiserror::Error;

use crate::model::MatrixKind;
use crate::solver::ModesError;

/// Why there are no sparse modes.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SparseError {
    /// No mode was asked for.
    #[error("0 modes were asked for: ask for at least one")]
    NoneWanted,
    /// The frequency to look near is negative or too large.
    #[error(
        "the frequency to look near is {target:?} rad/s: it must be a finite number, 0 or more"
    )]
    Target {
        /// The frequency given, in rad/s.
        target: f64,
    },
    /// A shape that is given has another length than the system has coordinates.
    #[error("a shape has length {given}: it must be {expected}, the number of coordinates")]
    ShapeLength {
        /// The entries it has.
        given: usize,
        /// The coordinates of the system.
        expected: usize,
    },
    /// There are other than as many loss factors as springs.
    #[error("there are {given} loss factors: give one for each of the {springs} springs, or none")]
    LossFactors {
        /// How many loss factors there are.
        given: usize,
        /// How many springs there are.
        springs: usize,
    },
    /// A matrix is not symmetric.
    #[error(
        "the {kind} matrix is not symmetric: modes of large systems are found for symmetric matrices alone"
    )]
    NotSymmetric {
        /// Which matrix.
        kind: MatrixKind,
    },
    /// Nothing has a mass.
    #[error("nothing has a mass, so nothing vibrates: give at least one mass")]
    NoMass,
    /// M has a negative eigenvalue.
    #[error(
        "the mass matrix is not positive semidefinite: some motion would have a negative energy"
    )]
    MassNotDefinite,
    /// The factor of K − σM would not fit into memory.
    #[error(
        "the factor of the stiffness matrix would have more than {} entries: the joins are too dense for it",
        super::pencil::MOST_ENTRIES
    )]
    TooDense,
    /// More parts float than a mass matrix that is not diagonal allows.
    #[error(
        "{count} parts that nothing holds are too many beside a mass matrix that is not diagonal"
    )]
    TooManyParts {
        /// How many float.
        count: usize,
    },
    /// The equation projected on the shapes was not solved.
    #[error("on the shapes found: {0}")]
    Projected(#[from] ModesError),
    /// The iteration for the modes did not converge.
    #[error(
        "the iteration did not converge: the modes lie too close together beside their distance from the frequency to look near; look near one closer to them, or ask for fewer"
    )]
    NoConvergence,
    /// The factor of K − σM leaves the range of doubles, or no shift makes it regular.
    #[error(
        "the stiffness matrix cannot be factorised in doubles: choose other units, or fewer orders of magnitude"
    )]
    OutOfRange,
}
