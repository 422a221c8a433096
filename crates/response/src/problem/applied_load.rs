//! A load and where it acts.

use super::load::Load;

/// A load and the index of the coordinate it acts on.
#[derive(Clone, Debug, PartialEq)]
pub struct AppliedLoad {
    /// Index of the coordinate.
    pub coordinate: usize,
    /// The force on it.
    pub load: Load,
}
