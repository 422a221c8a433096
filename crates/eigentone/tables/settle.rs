//! More digits until every number is decided.

use eigentone_check::{Ball, Reference, ReferenceError};

use super::error::TableError;
use super::value::Value;

/// The digits of the first attempt; each further one has twice as many.
const FIRST: u32 = 40;

/// The digits of the last attempt. A number that is not distinguished from 0 by then is given by a bound.
const LAST: u32 = 320;

/// The multiplications that each of the reference's steps may take if nobody says how many: a minute or two.
pub(super) const MOST_WORK: f64 = 1e9;

/// One attempt: turns enclosures into decided numbers, and remembers whether one was left open.
pub(super) struct Attempt {
    pub(super) reference: Reference,
    digits: u32,
    open: bool,
    undecided: Option<String>,
}

impl Attempt {
    /// The rounding that `ball` decides; what takes its place where there will be another attempt
    /// is of no account.
    pub(super) fn settle(&mut self, ball: &Ball, quantity: impl FnOnce() -> String) -> Value {
        if let Some(value) = Value::decided(ball) {
            return value;
        }
        self.open = true;
        Value::below(ball).unwrap_or_else(|| {
            self.undecided.get_or_insert_with(quantity);
            Value::ONE
        })
    }

    /// Asks for another attempt.
    pub(super) fn leave_open(&mut self) {
        self.open = true;
    }
}

/// What `of` finds with enough digits, where no step of the reference takes more than so many multiplications.
///
/// # Errors
/// [`TableError`] of the reference, or naming a number at a rounding boundary.
pub(super) fn settled<T>(
    work: f64,
    mut of: impl FnMut(&mut Attempt) -> Result<T, ReferenceError>,
) -> Result<T, TableError> {
    let mut digits = FIRST;
    loop {
        let mut attempt = Attempt {
            reference: Reference::with_digits(digits).within(work),
            digits,
            open: false,
            undecided: None,
        };
        let found = of(&mut attempt)?;
        if !attempt.open {
            return Ok(found);
        }
        if digits >= LAST {
            return match attempt.undecided {
                Some(quantity) => Err(TableError::Undecided {
                    quantity,
                    digits: attempt.digits,
                }),
                None => Ok(found),
            };
        }
        digits *= 2;
    }
}
