//! What is asked: a system, its state at t = 0, its loads, and the instants wanted.

use std::sync::OnceLock;

use eigentone_modes::{Precision, System};

use super::applied_load::AppliedLoad;
use super::error::ResponseError;
use super::grid::TimeGrid;
use super::instant::SampleGrid;
use super::load::Load;
use super::massless;
use super::state::State;
use super::timeline::Timeline;

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
