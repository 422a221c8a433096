//! What runs for a given system, what is left out, and why.

use std::fmt;

/// The choice of a mode solver, as a value that can be printed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModePlan {
    /// The name of the solver that runs.
    pub solver: &'static str,
    /// Why it is the right one.
    pub reason: String,
    /// What the bounds rest on.
    pub bounds: String,
    /// What the scene does not need: a name, and the reason it is left out.
    pub left_out: Vec<(&'static str, String)>,
    /// Of some modes of a large system, what the proof lacks that none between them is missing.
    pub incomplete: Option<&'static str>,
}

impl fmt::Display for ModePlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "modes by {}: {}", self.solver, self.reason)?;
        write!(f, "\nbounds {}", self.bounds)?;
        for (name, reason) in &self.left_out {
            write!(f, "\nleft out {name}: {reason}")?;
        }
        match self.incomplete {
            Some(reason) => write!(f, "\nnot proved to be complete: {reason}"),
            None => Ok(()),
        }
    }
}
