//! Why there is no limit cycle.

use thiserror::Error;

use crate::error::SwitchingError;
use crate::march::Halt;

/// Why no periodic motion was found.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CycleError {
    /// There is no motion.
    #[error(transparent)]
    Switching(#[from] SwitchingError),
    /// A period is no time.
    #[error("a period of {seconds:?} s: give a finite one, greater than 0")]
    Period {
        /// What was given, in s.
        seconds: f64,
    },
    /// Cycles of a load are to be counted, and none is harmonic.
    #[error(
        "no load is harmonic, so that there are no cycles to count: give the period in seconds, or leave it free"
    )]
    NoHarmonic,
    /// Nothing switches, and the period is left free.
    #[error(
        "nothing switches, so that no events show a period: a free one takes a friction, a stop, an impact or a controlled damper; loads that repeat themselves set one, to be given in seconds or, of harmonic loads, in cycles"
    )]
    NothingSwitches,
    /// The free motion shows no period.
    #[error(
        "up to t = {end:?} s the events do not repeat themselves three times: give more time, a start nearer to the periodic motion, or the period"
    )]
    NoRepetition {
        /// The end of the motion, in s.
        end: f64,
    },
    /// Newton's method does not come to a periodic motion.
    #[error(
        "no periodic motion was found near where the motion ends, which may come to rest: give more time, or a start nearer to the periodic motion"
    )]
    Lost,
    /// Neighbours of the motion repeat themselves too.
    #[error(
        "motions beside it repeat themselves too, as without damping, so that no single one can be determined: start where it is wanted, and take the response"
    )]
    NotIsolated,
    /// It comes back after one period, but not after two.
    #[error(
        "with a period of {period:?} s the motion does not repeat itself, as loads or supports go another way in the next: give a period that is theirs too; loads that change but once must do so by t = 0, and supports at dampers must start from 0"
    )]
    NotRepeating {
        /// In s.
        period: f64,
    },
}

impl From<Halt> for CycleError {
    fn from(halt: Halt) -> CycleError {
        CycleError::Switching(halt.into())
    }
}
