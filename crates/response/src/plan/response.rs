//! The fluent way to ask for a response.

use eigentone_modes::{Precision, System};

use super::choice::ResponsePlan;
use crate::answer::{History, Output, ResponseMethod, Trajectory};
use crate::problem::{AppliedLoad, Load, Problem, ResponseError, State, TimeGrid};

/// Asks for the motion of a system, step by step; [`run`](Response::run) answers.
///
/// ```
/// use eigentone_modes::{GROUND, System};
/// use eigentone_response::{Response, State, Step};
///
/// let system = System::builder().mass("m", 1.0).spring(GROUND, "m", 4.0).build()?;
/// let response = Response::of(&system)
///     .from(State::at_rest().displace("m", 1.0))
///     .load("m", Step::of(4.0))
///     .every(0.25)
///     .until(10.0)
///     .run()?;
/// // It already rests where the step pulls it to.
/// assert!((response.displacement()[(0, 40)] - 1.0).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[must_use = "nothing is computed until `run` is called"]
pub struct Response<'a> {
    system: &'a System,
    initial: State,
    loads: Vec<(String, Load)>,
    step: Option<f64>,
    end: Option<f64>,
    acceleration: bool,
    precision: Precision,
}

impl<'a> Response<'a> {
    /// The motion of `system`, from rest and without loads until more is said.
    pub fn of(system: &'a System) -> Response<'a> {
        Response {
            system,
            initial: State::at_rest(),
            loads: Vec::new(),
            step: None,
            end: None,
            acceleration: false,
            precision: Precision::default(),
        }
    }

    /// Starts from `initial` at t = 0.
    pub fn from(self, initial: State) -> Response<'a> {
        Response { initial, ..self }
    }

    /// Adds a load on the coordinate `name`.
    pub fn load(mut self, name: impl Into<String>, load: impl Into<Load>) -> Response<'a> {
        self.loads.push((name.into(), load.into()));
        self
    }

    /// Sets the spacing of the instants, in s.
    pub fn every(self, step: f64) -> Response<'a> {
        Response {
            step: Some(step),
            ..self
        }
    }

    /// Sets the end, in s.
    pub fn until(self, end: f64) -> Response<'a> {
        Response {
            end: Some(end),
            ..self
        }
    }

    /// Sets the precision, as [`Problem::to`] does.
    pub fn to(self, precision: Precision) -> Response<'a> {
        Response { precision, ..self }
    }

    /// Asks for accelerations too.
    pub fn with_acceleration(self) -> Response<'a> {
        Response {
            acceleration: true,
            ..self
        }
    }

    /// The question as a checked value, to be given to any [`ResponseMethod`].
    ///
    /// # Errors
    /// [`ResponseError`] naming the first thing that is wrong.
    pub fn problem(self) -> Result<Problem<'a>, ResponseError> {
        let (Some(step), Some(end)) = (self.step, self.end) else {
            return Err(ResponseError::NoGrid);
        };
        let grid = TimeGrid::new(step, end)?;
        let loads = self
            .loads
            .into_iter()
            .map(|(name, load)| match self.system.index_of(&name) {
                Some(coordinate) => Ok(AppliedLoad { coordinate, load }),
                None => {
                    let known = self.system.names().join(", ");
                    Err(ResponseError::UnknownCoordinate { name, known })
                }
            });
        let loads = loads.collect::<Result<_, _>>()?;
        let problem = Problem::new(self.system, &self.initial, loads, grid)?.to(self.precision);
        Ok(if self.acceleration {
            problem.with_acceleration()
        } else {
            problem
        })
    }

    /// Answers by the method that the plan picks.
    ///
    /// # Errors
    /// What [`problem`](Self::problem) and the method report.
    pub fn run(self) -> Result<Trajectory, ResponseError> {
        let problem = self.problem()?;
        ResponsePlan::of(&problem)?.run(&problem)
    }

    /// Answers with the histories of these outputs alone; nothing else is stored.
    ///
    /// # Errors
    /// What [`problem`](Self::problem) and [`History::of`] report.
    pub fn follow(self, outputs: &[Output]) -> Result<History, ResponseError> {
        History::of(&self.problem()?, outputs)
    }

    /// Answers by the given method.
    ///
    /// # Errors
    /// What [`problem`](Self::problem) and the method report.
    pub fn run_by(self, method: &dyn ResponseMethod) -> Result<Trajectory, ResponseError> {
        method.run(&self.problem()?)
    }
}
