//! One trait for everything that answers a [`Problem`].

use super::trajectory::Trajectory;
use crate::problem::{Problem, ResponseError};

/// A way to compute a response. The exact methods of this crate implement it, and so do the
/// closed forms and integrators that check them, so that all can be looped over.
pub trait ResponseMethod {
    /// A short name for tables and plots.
    fn name(&self) -> &'static str;

    /// Why it cannot answer this problem, or `None` if it can.
    fn refuses(&self, problem: &Problem<'_>) -> Option<String>;

    /// The motion at the instants asked for.
    ///
    /// # Errors
    /// [`ResponseError::NotApplicable`] where [`refuses`](Self::refuses) gives a reason, and what
    /// goes wrong on the way.
    fn run(&self, problem: &Problem<'_>) -> Result<Trajectory, ResponseError>;
}
