//! Why there is no table.

use eigentone_check::ReferenceError;
use eigentone_response::ResponseError;
use thiserror::Error;

/// Why a table cannot be given: none is printed with a digit in doubt.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TableError {
    /// The reference has no answer.
    #[error("no reference: {0}")]
    Reference(#[from] ReferenceError),
    /// The instants asked for do not fit.
    #[error(transparent)]
    Response(#[from] ResponseError),
    /// A number lies so close to a rounding boundary, or to 0, that its digits stay open.
    #[error(
        "{quantity} cannot be determined to {} digits, even from {digits}: it lies too near to halfway between two decimals, or is too small beside the largest",
        super::DIGITS
    )]
    Undecided {
        /// Which number.
        quantity: String,
        /// The digits that it was computed with.
        digits: u32,
    },
}
