//! Mode solvers behind one trait.
use thiserror::Error;

use crate::modes::Modes;
use crate::structure::Structure;
use crate::system::System;

/// A way to solve the quadratic eigenproblem.
pub trait ModeSolver: Sync {
    /// A short name for tables and plots.
    fn name(&self) -> &'static str;

    /// Why it cannot solve this system, or `None` if it can.
    fn refuses(&self, system: &System, structure: &Structure) -> Option<String>;

    /// All modes.
    ///
    /// # Errors
    /// [`ModesError`]
    fn solve(&self, system: &System, structure: &Structure) -> Result<Modes, ModesError>;
}

/// Every mode solver there is.
pub fn solvers() -> &'static [&'static dyn ModeSolver] {
    &[]
}

pub(crate) fn solve(_system: &System) -> Result<Modes, ModesError> {
    todo!()
}

/// Why there are no modes.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ModesError {
    /// The iteration did not converge.
    #[error("the eigenvalue iteration did not converge")]
    NoConvergence,
}
