//! What a solver is, what it refuses, and why there are no modes.

use thiserror::Error;

use crate::first_order::FirstOrderError;
use crate::modes::Modes;
use crate::system::System;

/// A way to solve the quadratic eigenproblem, as a value, so that solvers can be looped over.
pub trait ModeSolver: Sync {
    /// A short name for tables and plots.
    fn name(&self) -> &'static str;

    /// Why it cannot solve this system, or `None` if it can.
    fn refuses(&self, system: &System) -> Option<String>;

    /// Why a system that it could solve does not need it, or `None` if nothing simpler does as well.
    fn needless(&self, _system: &System) -> Option<String> {
        None
    }

    /// Why it is the right choice where it applies, as a clause for the plan.
    fn reason(&self) -> &'static str;

    /// All modes of a system that it does not refuse.
    ///
    /// # Errors
    /// [`ModesError::Refused`] where [`refuses`](Self::refuses) gives a reason, and what goes wrong
    /// on the way.
    fn solve(&self, system: &System) -> Result<Modes, ModesError>;
}

/// Refuses what is too large for dense matrices.
pub(super) fn admit_size(system: &System) -> Result<(), ModesError> {
    if !system.is_large() {
        return Ok(());
    }
    let coordinates = system.len();
    Err(ModesError::TooLarge {
        coordinates,
        gigabytes: dense_gigabytes(coordinates),
    })
}

/// What M, C, K and one state matrix of so many coordinates take as dense matrices, in 1e9 bytes.
pub fn dense_gigabytes(coordinates: usize) -> f64 {
    let order = coordinates as f64;
    (3.0 + 4.0) * order * order * 8e-9
}

/// Refuses with the solver's own reason.
pub(super) fn admit(solver: &dyn ModeSolver, system: &System) -> Result<(), ModesError> {
    admit_size(system)?;
    match solver.refuses(system) {
        Some(reason) => Err(ModesError::Refused {
            method: solver.name(),
            reason,
        }),
        None => Ok(()),
    }
}

/// Why there are no modes.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ModesError {
    /// An iteration of linear algebra did not converge.
    #[error("{method}: the iteration did not converge")]
    NoConvergence {
        /// The solver.
        method: &'static str,
    },
    /// The solver does not apply to this system.
    #[error("{method} does not apply: {reason}")]
    Refused {
        /// The solver.
        method: &'static str,
        /// Why not.
        reason: String,
    },
    /// The system has no first-order form.
    #[error(transparent)]
    FirstOrder(#[from] FirstOrderError),
    /// Rounding to doubles hides what determines the motion where there is no mass.
    #[error(
        "doubles do not determine how the parts without mass move, so that no modes are found in them: ask for certified precision, which takes more digits"
    )]
    Hidden,
    /// The system is [large](System::is_large): it has some modes at a time, as
    /// [`SparseModes`](crate::SparseModes).
    #[error(
        "all modes of {coordinates} coordinates would take dense matrices of {gigabytes:.1} GB: ask for some of them"
    )]
    TooLarge {
        /// How many coordinates there are.
        coordinates: usize,
        /// What M, C, K and one state matrix would take.
        gigabytes: f64,
    },
    /// A frequency leaves the range of doubles.
    #[error(
        "{method}: the frequencies lie too far apart for doubles; choose other units, or fewer orders of magnitude"
    )]
    OutOfRange {
        /// The solver.
        method: &'static str,
    },
}
