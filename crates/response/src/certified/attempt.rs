//! One attempt at a proven answer.

use crate::answer::Trajectory;

/// What came of an attempt.
pub(crate) enum Attempt {
    Found(Box<Trajectory>),
    /// An instant missed the tolerance.
    Missed,
    /// With so few digits a matrix to be divided by cannot be told from a singular one.
    Stuck,
    /// So many halvings of the step, and as many squarings, would take too long with so many digits.
    TooDear,
}
