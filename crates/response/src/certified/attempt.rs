//! One attempt at a proven answer.

use crate::answer::Trajectory;

/// What came of an attempt.
pub(crate) enum Attempt {
    Found(Box<Trajectory>),
    /// An instant missed the tolerance.
    Missed {
        /// How often its matrix asks for the step to be halved, in whatever digits.
        halvings: f64,
    },
    /// With so few digits a matrix to be divided by cannot be distinguished from a singular one.
    Stuck,
}
