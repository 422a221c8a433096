//! Which method answers a problem, what is left out, and why.

use std::fmt;

use crate::by_exponential::ByExponential;
use crate::by_superposition::BySuperposition;
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

/// Every exact method, in the order in which the plan prefers them where both apply well.
pub fn methods() -> &'static [&'static dyn ResponseMethod] {
    &[&BySuperposition, &ByExponential]
}

impl ResponsePlan {
    /// Picks a method for the problem: superposition where the damping is proved to be classical,
    /// else the exponential.
    ///
    /// # Errors
    /// [`ResponseError::NotApplicable`] where no exact method applies.
    pub fn of(problem: &Problem<'_>) -> Result<ResponsePlan, ResponseError> {
        let mut left_out = Vec::new();
        let structure = problem.system().structure();
        if structure.is_undamped() || structure.is_classical() {
            match BySuperposition.refuses(problem) {
                Some(reason) => left_out.push((BySuperposition.name(), reason)),
                None => {
                    left_out.push((ByExponential.name(), "not needed".to_owned()));
                    let reason = "each real mode moves by itself, in O(n) a step".to_owned();
                    return Ok(ResponsePlan {
                        method: &BySuperposition,
                        reason,
                        left_out,
                    });
                }
            }
        } else {
            let reason = "the damping couples the real modes".to_owned();
            left_out.push((BySuperposition.name(), reason));
        }
        match ByExponential.refuses(problem) {
            Some(reason) => Err(ResponseError::NotApplicable {
                method: ByExponential.name(),
                reason,
            }),
            None => {
                let reason = "exact for any damping, one exponential for each length of step";
                Ok(ResponsePlan {
                    method: &ByExponential,
                    reason: reason.to_owned(),
                    left_out,
                })
            }
        }
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
