//! What can be proved of a system from its parameters, in exact arithmetic.
pub(crate) mod determinant;
use crate::system::System;

/// Proofs.
#[derive(Clone, Debug, PartialEq)]
pub struct Structure {}

impl Structure {
    pub(crate) fn of(_system: &System) -> Structure {
        todo!()
    }
}
