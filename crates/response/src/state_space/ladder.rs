//! More and more digits, until every entry is known to its last one or no more can be afforded.

use eigentone_digits::{DoubleDouble, Real, Wide};

use super::error::StateSpaceError;

/// The most that is spent with one number of digits, in multiplications of doubles.
const LIMIT: f64 = 2e11;

/// What is computed with as many digits as it takes.
pub(super) trait Question {
    type Answer;

    /// The answer and whether it is as good as doubles are; `None` where the digits of T leave nothing of it.
    fn attempt<T: Real>(&self) -> Found<Self::Answer>;
}

type Attempt<Q> = fn(&Q) -> Found<<Q as Question>::Answer>;

pub(super) type Found<A> = Result<Option<(A, bool)>, StateSpaceError>;

/// What a multiplication costs with the fewest digits, in those of doubles.
const LEAST_COST: f64 = 8.0;

/// Refuses what not even the fewest digits can be afforded for.
pub(super) fn affordable(states: usize, operations: f64) -> Result<(), StateSpaceError> {
    afford(states, operations * LEAST_COST)
}

fn afford(states: usize, operations: f64) -> Result<(), StateSpaceError> {
    let limit = LIMIT;
    match operations > limit {
        true => Err(StateSpaceError::TooMuchWork {
            states,
            operations: operations.min(f64::MAX),
            limit,
        }),
        false => Ok(()),
    }
}

/// The best answer for so many states, with so many operations.
pub(super) fn climb<Q: Question>(
    question: &Q,
    states: usize,
    operations: f64,
) -> Result<Q::Answer, StateSpaceError> {
    // What a multiplication costs, in those of doubles.
    let rungs: [(f64, Attempt<Q>); 6] = [
        (LEAST_COST, Q::attempt::<DoubleDouble>),
        (40.0, Q::attempt::<Wide<4>>),
        (100.0, Q::attempt::<Wide<8>>),
        (300.0, Q::attempt::<Wide<16>>),
        (1e3, Q::attempt::<Wide<32>>),
        (4e3, Q::attempt::<Wide<64>>),
    ];
    let mut best = None;
    let mut tried = false;
    for (cost, attempt) in rungs {
        if let Err(error) = afford(states, operations * cost) {
            return best.ok_or(if tried { StateSpaceError::Lost } else { error });
        }
        tried = true;
        if let Some((answer, good)) = attempt(question)? {
            best = Some(answer);
            if good {
                break;
            }
        }
    }
    best.ok_or(StateSpaceError::Lost)
}
