//! What is asked: a system, its state at t = 0, its loads, and the instants wanted.

use std::sync::OnceLock;

use eigentone_modes::{ModesError, Precision, SparseError, System};
use thiserror::Error;

use crate::grid::TimeGrid;
use crate::load::{Load, LoadError};
use crate::massless;
use crate::state::State;
use crate::timeline::{SampleGrid, Timeline};

/// A checked question: the motion of `system` from `initial` under `loads` at chosen instants of a
/// grid. Every [`ResponseMethod`](crate::ResponseMethod) answers it.
#[derive(Clone, Debug)]
pub struct Problem<'a> {
    system: &'a System,
    initial_displacement: Vec<f64>,
    initial_velocity: Vec<f64>,
    loads: Vec<AppliedLoad>,
    grid: TimeGrid,
    /// Made when it is first asked for: long samples have as many pieces.
    timeline: OnceLock<Timeline>,
    instants: Option<Vec<u64>>,
    acceleration: bool,
    precision: Precision,
}

/// A load and the index of the coordinate it acts on.
#[derive(Clone, Debug, PartialEq)]
pub struct AppliedLoad {
    /// Index of the coordinate.
    pub coordinate: usize,
    /// The force on it.
    pub load: Load,
}

impl<'a> Problem<'a> {
    /// Checks the parts against each other.
    ///
    /// # Errors
    /// [`ResponseError`] naming the first thing that is wrong: a load, its fit to the grid, a
    /// load or initial value that a massless node cannot take, an instant beyond the grid.
    pub fn new(
        system: &'a System,
        initial: &State,
        loads: Vec<AppliedLoad>,
        grid: TimeGrid,
    ) -> Result<Problem<'a>, ResponseError> {
        for (index, applied) in loads.iter().enumerate() {
            let wrong = |error| ResponseError::Load { index, error };
            applied.load.check().map_err(wrong)?;
            if let Load::Samples(samples) = &applied.load {
                SampleGrid::of(samples.step, grid.step()).map_err(wrong)?;
            }
        }
        massless::check(system, initial, &loads)?;
        Ok(Problem {
            initial_displacement: resolve(system, &initial.displacements)?,
            initial_velocity: resolve(system, &initial.velocities)?,
            timeline: OnceLock::new(),
            system,
            loads,
            grid,
            instants: None,
            acceleration: false,
            precision: Precision::default(),
        })
    }

    /// The same problem, answered only at these indices of the grid, in this order.
    ///
    /// # Errors
    /// [`ResponseError::InstantBeyondEnd`].
    pub fn at(mut self, instants: &[u64]) -> Result<Problem<'a>, ResponseError> {
        let last = self.grid.last();
        if let Some(&index) = instants.iter().find(|index| **index > last) {
            return Err(ResponseError::InstantBeyondEnd { index, last });
        }
        self.instants = Some(instants.to_vec());
        Ok(self)
    }

    /// The same problem, answered to this precision. The tolerance of a certified answer is relative
    /// to the largest coordinate of each instant, for displacements and for velocities.
    pub fn to(self, precision: Precision) -> Problem<'a> {
        Problem { precision, ..self }
    }

    /// The same problem with accelerations in the answer.
    pub fn with_acceleration(self) -> Problem<'a> {
        Problem {
            acceleration: true,
            ..self
        }
    }

    /// The system that moves.
    pub fn system(&self) -> &'a System {
        self.system
    }

    /// Displacements at t = 0 in m, one for each coordinate.
    pub fn initial_displacement(&self) -> &[f64] {
        &self.initial_displacement
    }

    /// Velocities at t = 0 in m/s, one for each coordinate.
    pub fn initial_velocity(&self) -> &[f64] {
        &self.initial_velocity
    }

    /// The loads as pieces between the instants at which they change.
    pub fn timeline(&self) -> &Timeline {
        self.timeline
            .get_or_init(|| Timeline::of(&self.loads, &self.grid))
    }

    /// The loads in the order given.
    pub fn loads(&self) -> &[AppliedLoad] {
        &self.loads
    }

    /// The grid of instants.
    pub fn grid(&self) -> &TimeGrid {
        &self.grid
    }

    /// The indices asked for, or `None` for all of the grid.
    pub fn instants(&self) -> Option<&[u64]> {
        self.instants.as_deref()
    }

    /// The precision asked for.
    pub fn precision(&self) -> Precision {
        self.precision
    }

    /// Why an impulse on this coordinate, which neither mass nor damper resists, is refused.
    pub(crate) fn unresisted(&self, coordinate: usize) -> ResponseError {
        let is_it = |applied: &AppliedLoad| {
            applied.coordinate == coordinate && matches!(applied.load, Load::Impulse(_))
        };
        ResponseError::ImpulseOnMassless {
            index: self.loads.iter().position(is_it).unwrap_or(0),
            name: self.system.names()[coordinate].clone(),
        }
    }

    /// Whether accelerations are asked for.
    pub fn wants_acceleration(&self) -> bool {
        self.acceleration
    }
}

/// Values by index, from values by name.
fn resolve(system: &System, named: &[(String, f64)]) -> Result<Vec<f64>, ResponseError> {
    let mut values = vec![0.0; system.len()];
    for (name, value) in named {
        let index = system
            .index_of(name)
            .ok_or_else(|| ResponseError::UnknownCoordinate {
                name: name.clone(),
                known: system.names().join(", "),
            })?;
        if !value.is_finite() {
            return Err(ResponseError::InitialNotFinite {
                name: name.clone(),
                value: *value,
            });
        }
        values[index] = *value;
    }
    Ok(values)
}

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
    /// Neither a step nor an end was given.
    #[error("no instants are given: say every which step, and until when")]
    NoGrid,
    /// A load or an initial value names no coordinate.
    #[error("{name:?} is not a coordinate: known are {known}")]
    UnknownCoordinate {
        /// The name given.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// An output names a coordinate by an index that the system does not have.
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
        "{instants} instants of {coordinates} coordinates take {gigabytes:.1} GB, more than the {limit:.1} GB allowed: ask for fewer instants"
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
    /// The system is [large](System::is_large).
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
    /// Modal truncation needs some modes, and they could not be had.
    #[error(transparent)]
    Sparse(#[from] SparseError),
    /// Modal superposition needs modes, and they could not be had.
    #[error(transparent)]
    Modes(#[from] ModesError),
}
