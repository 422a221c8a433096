//! Why there is no limit cycle.

use thiserror::Error;

use crate::error::{SwitchingError, named};
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
        "no periodic motion was found near where the motion ends: it may come to rest, or keep a vibration or a drift that nothing damps; give more time, or a start nearer to the periodic motion"
    )]
    Lost,
    /// A motion that the search tries cannot be followed; the problem's own can.
    #[error(
        "the search for a periodic motion cannot go on: give more time, or a start nearer to the periodic motion; of a motion that it tries, not the scene's own, this is said: {0}"
    )]
    Halted(SwitchingError),
    /// It repeats itself, but doubles do not show whether its neighbours do so too.
    #[error(
        "a motion that repeats itself was found, but cannot be told from motions beside it, which may do so too, as without damping or where a friction or a contact holds all the time: start where it is wanted, and take the response"
    )]
    NotIsolated,
    /// What becomes of disturbances of a periodic motion that was found is not known.
    #[error(
        "a periodic motion was found, of {period:?} s, but no multipliers, so that it is not known whether it is stable: a controlled damper between what rests answers small disturbances by no linear law, or doubles do not give them"
    )]
    NoMultipliers {
        /// In s.
        period: f64,
    },
    /// It comes back after one period, but not after two.
    #[error(
        "with a period of {period:?} s the motion does not repeat itself, as loads or supports go another way in the next: give a period that is theirs too; loads that change but once must do so by t = 0, and supports at dampers must start from 0"
    )]
    NotRepeating {
        /// In s.
        period: f64,
    },
}

impl CycleError {
    /// The switch that it is about, by its place among those given.
    pub fn switch(&self) -> Option<usize> {
        match self {
            CycleError::Switching(error) | CycleError::Halted(error) => error.switch(),
            _ => None,
        }
    }

    /// The message with the name of the switch in place of its number; `names` are those of all switches, in order.
    pub fn with_names(&self, names: &[String]) -> String {
        named(self, self.switch(), names)
    }
}

impl From<Halt> for CycleError {
    fn from(halt: Halt) -> CycleError {
        CycleError::Switching(halt.into())
    }
}
