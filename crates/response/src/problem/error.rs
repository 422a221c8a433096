//! Why there is no response.

use eigentone_modes::{ModesError, SparseError};
use thiserror::Error;

use super::load::LoadError;

/// Why there is no response.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ResponseError {
    /// The step is not a positive number.
    #[error("the step is {step:?}: it must be a finite number greater than 0")]
    Step {
        /// The step given, in s.
        step: f64,
    },
    /// The end is negative, infinite or NaN.
    #[error("the end is {end:?}: it must be a finite number, 0 or later")]
    End {
        /// The end given, in s.
        end: f64,
    },
    /// The grid has more than [`MAX_STEPS`](crate::MAX_STEPS) steps.
    #[error("from 0 to {end:?} in steps of {step:?} are more than 2^53 steps: take a larger step")]
    TooManySteps {
        /// The step given, in s.
        step: f64,
        /// The end given, in s.
        end: f64,
    },
    /// The last instant, to which the end is rounded up, is beyond the largest double.
    #[error(
        "the last instant, after {steps} steps of {step:?} s, is beyond the largest double: take a smaller step"
    )]
    LastInstant {
        /// The step given, in s.
        step: f64,
        /// How many steps make the end, rounded.
        steps: u64,
    },
    /// Neither a step nor an end was given.
    #[error("no instants are given: say every which step, and until when")]
    NoGrid,
    /// A load or an initial value names no coordinate.
    #[error("{name:?} is not a coordinate: known: {known}")]
    UnknownCoordinate {
        /// The name given.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// A load or an output names a coordinate by an index that the system does not have.
    #[error("there is no coordinate of index {index}: the system has {coordinates}, from 0 on")]
    NoCoordinate {
        /// The index given.
        index: usize,
        /// How many coordinates there are.
        coordinates: usize,
    },
    /// An initial displacement or velocity is infinite or NaN.
    #[error("an initial value of {name:?} is {value:?}: it must be a finite number")]
    InitialNotFinite {
        /// The coordinate.
        name: String,
        /// The value given.
        value: f64,
    },
    /// An undamped massless node has no state of its own.
    #[error(
        "{name:?} has neither mass nor damper, so it has no initial state: its displacement follows from equilibrium"
    )]
    InitialOnMassless {
        /// The coordinate.
        name: String,
    },
    /// A damped massless node has no free velocity.
    #[error("{name:?} has no mass, so it has no initial velocity: give it a displacement only")]
    VelocityOnMassless {
        /// The coordinate.
        name: String,
    },
    /// An impulse on a node that nothing resists at once.
    #[error(
        "load {index} is an impulse on {name:?}, where neither mass nor damper resists it: a displacement would be infinite"
    )]
    ImpulseOnMassless {
        /// Which load, from 0.
        index: usize,
        /// The coordinate.
        name: String,
    },
    /// A load is wrong by itself or does not fit the grid.
    #[error("load {index}: {error}")]
    Load {
        /// Which load, from 0.
        index: usize,
        /// What is wrong with it.
        error: LoadError,
    },
    /// The motion of a support is wrong by itself or does not fit the grid.
    #[error("motion {index}: {error}")]
    Motion {
        /// Which motion, from 0.
        index: usize,
        /// What is wrong with it.
        error: LoadError,
    },
    /// A jump of a support on a node that nothing resists at once.
    #[error(
        "{support:?} jumps, and a damper passes that on to {name:?}, where neither mass nor damper resists it: a displacement would be infinite"
    )]
    JumpOnMassless {
        /// The support.
        support: String,
        /// The coordinate.
        name: String,
    },
    /// A combination of motions that cannot be made.
    #[error("output {index}: {reason}")]
    Combination {
        /// Which one, from 0.
        index: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// A name that is neither a coordinate nor a point nor a support, where one is needed.
    #[error("{name:?} is not a support: known: {known}")]
    UnknownSupport {
        /// The name given.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// An instant was asked for that the grid does not have.
    #[error("step {index} is beyond the last one, {last}")]
    InstantBeyondEnd {
        /// The index given.
        index: u64,
        /// The last index of the grid.
        last: u64,
    },
    /// A time was asked for that is not finite or not within the grid.
    #[error("time {time:?} s is not between 0 and the end, {end:?} s")]
    Time {
        /// The time given, in s.
        time: f64,
        /// The end of the grid, in s.
        end: f64,
    },
    /// The answer would take too much memory.
    #[error(
        "instants {instants}, coordinates {coordinates}: together they take {gigabytes:.1} GB, more than the {limit:.1} GB allowed: ask for fewer instants"
    )]
    TooLarge {
        /// Instants asked for.
        instants: u64,
        /// Coordinates of the system.
        coordinates: usize,
        /// What they would take.
        gigabytes: f64,
        /// What is allowed.
        limit: f64,
    },
    /// The system is [large](eigentone_modes::System::is_large).
    #[error(
        "{coordinates} coordinates would take dense matrices of {gigabytes:.1} GB: take some of their modes"
    )]
    Large {
        /// How many coordinates there are.
        coordinates: usize,
        /// What M, C, K and one state matrix would take.
        gigabytes: f64,
    },
    /// The method does not apply to this problem.
    #[error("{method} does not apply: {reason}")]
    NotApplicable {
        /// The method's name.
        method: &'static str,
        /// Why not.
        reason: String,
    },
    /// The motion leaves the range of doubles.
    #[error(
        "the motion exceeds the largest double at step {index}: it grows too fast, or what drives it is too large"
    )]
    Overflow {
        /// The first step index affected.
        index: u64,
    },
    /// Every digit is lost on the way: errors grow faster than the digits in reach can make up for.
    #[error(
        "nothing is left to be known of the motion at step {index} with {digits} digits: errors grow faster along it than more digits can make up for: ask for an earlier end, or for plain doubles without proof"
    )]
    Lost {
        /// The first step index affected.
        index: u64,
        /// The decimal digits that were taken.
        digits: usize,
    },
    /// A method that is not exact did not reach the end.
    #[error("{method} stopped before the end: {reason}")]
    Stopped {
        /// The method's name.
        method: &'static str,
        /// What it reported.
        reason: String,
    },
    /// Modal truncation needs some modes, and they could not be computed.
    #[error(transparent)]
    Sparse(#[from] SparseError),
    /// Modal superposition needs modes, and they could not be computed.
    #[error(transparent)]
    Modes(#[from] ModesError),
}
