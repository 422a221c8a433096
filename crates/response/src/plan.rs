//! Which method answers a problem, what is left out, and why.

use std::fmt;

use crate::method::ResponseMethod;
use crate::problem::{Problem, ResponseError};
use crate::trajectory::Trajectory;

/// The choice of a response method, as a value that can be printed and run.
pub struct ResponsePlan {
    /// The method that runs.
    pub method: &'static dyn ResponseMethod,
    /// Why it is the right one.
    pub reason: String,
    /// What the problem does not need: a name, and the reason it is left out.
    pub left_out: Vec<(&'static str, String)>,
}

impl ResponsePlan {
    /// Picks a method for the problem.
    ///
    /// # Errors
    /// [`ResponseError::NotApplicable`] where no exact method applies.
    pub fn of(_problem: &Problem<'_>) -> Result<ResponsePlan, ResponseError> {
        todo!()
    }

    /// Answers the problem by the method picked.
    ///
    /// # Errors
    /// What the method reports.
    pub fn run(&self, problem: &Problem<'_>) -> Result<Trajectory, ResponseError> {
        self.method.run(problem)
    }
}

impl fmt::Display for ResponsePlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "response by {}: {}", self.method.name(), self.reason)?;
        for (name, reason) in &self.left_out {
            write!(f, "\nleft out {name}: {reason}")?;
        }
        Ok(())
    }
}
