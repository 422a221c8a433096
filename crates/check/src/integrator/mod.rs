//! Numerical integrators: methods that are not exact, to be compared with those that are.

mod course;
mod dop853;
mod dormand_prince;
mod embedded;
mod equation;
mod fixed_step;
mod interpolation;
mod newmark;
mod runge_kutta;

use std::time::{Duration, Instant};

use eigentone_response::{Problem, ResponseError, ResponseMethod, Trajectory};

pub use dop853::Dop853;
pub use dormand_prince::DormandPrince5;
pub use newmark::Newmark;
pub use runge_kutta::RungeKutta4;

/// A [`ResponseMethod`] that advances in small steps, so that its error depends on a knob and its
/// work can be counted. None of them takes a system with a singular mass matrix. All restart
/// wherever a load changes its law.
pub trait Integrator: ResponseMethod {
    /// What its accuracy is set by.
    fn knob(&self) -> Knob;

    /// The motion at the instants asked for, and the work it took.
    ///
    /// # Errors
    /// [`ResponseError::NotApplicable`] where [`refuses`](ResponseMethod::refuses) gives a reason,
    /// [`ResponseError::Stopped`] where the limit is reached first or the steps become too small,
    /// [`ResponseError::Overflow`] and [`ResponseError::TooLarge`].
    fn integrate(
        &self,
        problem: &Problem<'_>,
        limit: Limit,
    ) -> Result<(Trajectory, Work), ResponseError>;
}

/// What the accuracy of an integrator is set by.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Knob {
    /// The error allowed in each step, relative to the largest displacement (or velocity) so far.
    Tolerance(f64),
    /// How many equal steps are taken between two neighbouring instants of the grid.
    Substeps(u32),
}

impl std::fmt::Display for Knob {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Knob::Tolerance(tolerance) => write!(f, "tolerance {tolerance:e}"),
            Knob::Substeps(1) => f.write_str("1 substep"),
            Knob::Substeps(count) => write!(f, "{count} substeps"),
        }
    }
}

/// How far an integrator may go before it stops with [`ResponseError::Stopped`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limit {
    /// The most steps it may try.
    pub steps: u64,
    /// The longest time it may run, if there is one.
    pub time: Option<Duration>,
}

impl Default for Limit {
    /// A million steps, however long they take.
    fn default() -> Limit {
        Limit {
            steps: 1_000_000,
            time: None,
        }
    }
}

/// What an integration took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// How often the acceleration was evaluated.
    pub evaluations: u64,
    /// Steps taken.
    pub accepted: u64,
    /// Steps tried and found too inaccurate.
    pub rejected: u64,
}

/// Counts steps against a limit.
struct Meter {
    limit: Limit,
    started: Instant,
    steps: u64,
}

impl Meter {
    fn start(limit: Limit) -> Meter {
        Meter {
            limit,
            started: Instant::now(),
            steps: 0,
        }
    }

    /// Counts one more step, or says that it is one too many.
    fn step(&mut self) -> Result<(), String> {
        /// Reading the clock costs as much as a small step.
        const STEPS_BETWEEN_READINGS: u64 = 64;
        if self.steps == self.limit.steps {
            return Err(format!("{} steps did not suffice", self.limit.steps));
        }
        self.steps += 1;
        match self.limit.time {
            Some(time)
                if self.steps.is_multiple_of(STEPS_BETWEEN_READINGS)
                    && self.started.elapsed() > time =>
            {
                Err(format!("{:.1} s did not suffice", time.as_secs_f64()))
            }
            _ => Ok(()),
        }
    }
}
