//! The fluent way to ask for a response.

use eigentone_modes::{Precision, System};

use super::choice::ResponsePlan;
use crate::answer::{History, Output, ResponseMethod, Trajectory};
use crate::problem::{
    AppliedLoad, Combination, Drive, Load, Problem, Quantity, ResponseError, State, Sum, TimeGrid,
};

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
    motions: Vec<(String, Quantity, Load)>,
    outputs: Vec<Combination>,
    step: Option<f64>,
    end: Option<f64>,
    acceleration: bool,
    forces: bool,
    precision: Precision,
}

impl<'a> Response<'a> {
    /// The motion of `system`, from rest and without loads until more is said.
    pub fn of(system: &'a System) -> Response<'a> {
        Response {
            system,
            initial: State::at_rest(),
            loads: Vec::new(),
            motions: Vec::new(),
            outputs: Vec::new(),
            step: None,
            end: None,
            acceleration: false,
            forces: false,
            precision: Precision::default(),
        }
    }

    /// Starts from `initial` at t = 0.
    pub fn from(self, initial: State) -> Response<'a> {
        Response { initial, ..self }
    }

    /// Adds a load on the coordinate or point `name`.
    pub fn load(mut self, name: impl Into<String>, load: impl Into<Load>) -> Response<'a> {
        self.loads.push((name.into(), load.into()));
        self
    }

    /// Gives the support `name` a motion: its displacement, velocity or acceleration follows the course of a load, whose
    /// forces are meters here, or m/s or m/s². It is at rest at 0 before t = 0; several motions of a support add up. A
    /// displacement that jumps passes an impulse through the dampers at the support.
    ///
    /// ```
    /// use eigentone_modes::System;
    /// use eigentone_response::{Quantity, Response, Step};
    ///
    /// let car = System::builder()
    ///     .mass("body", 290.0)
    ///     .mass("wheel", 59.0)
    ///     .support("road")
    ///     .spring("wheel", "body", 16812.0)
    ///     .damper("wheel", "body", 1000.0)
    ///     .spring("road", "wheel", 190_000.0)
    ///     .named("tyre")
    ///     .build()?;
    /// let kerb = Response::of(&car).motion("road", Quantity::Displacement, Step::of(0.08));
    /// let motion = kerb.pull("tyre force", "tyre").every(0.01).until(30.0).run()?;
    /// // At first the tyre is pressed by all of the kerb; in the end the car stands on it.
    /// assert_eq!(motion.output(0)[0], -0.08 * 190_000.0);
    /// assert!((motion.displacement()[(0, 3000)] - 0.08).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn motion(
        mut self,
        name: impl Into<String>,
        quantity: Quantity,
        course: impl Into<Load>,
    ) -> Response<'a> {
        self.motions.push((name.into(), quantity, course.into()));
        self
    }

    /// Asks for a sum of motions too: which quantity, of which coordinate, point or support, times what.
    pub fn sum<N: Into<String>>(
        mut self,
        name: impl Into<String>,
        motions: impl IntoIterator<Item = (Quantity, N, f64)>,
    ) -> Response<'a> {
        let motions = motions.into_iter();
        let motions = motions.map(|(quantity, of, factor)| (quantity, of.into(), factor));
        self.outputs.push(Combination {
            name: name.into(),
            of: Sum::Motions(motions.collect()),
        });
        self
    }

    /// Asks for the pull of the spring or damper named `element` too.
    pub fn pull(mut self, name: impl Into<String>, element: impl Into<String>) -> Response<'a> {
        self.outputs.push(Combination {
            name: name.into(),
            of: Sum::Pull(element.into()),
        });
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

    /// Asks for what every spring and every damper carries too.
    pub fn with_forces(self) -> Response<'a> {
        Response {
            forces: true,
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
        let system = self.system;
        let (mut loads, mut drives) = (Vec::new(), Vec::new());
        let mut numbers = Vec::new();
        for (index, (name, load)) in self.loads.into_iter().enumerate() {
            if let Some(coordinate) = system.index_of(&name) {
                loads.push(AppliedLoad { coordinate, load });
                numbers.push(index);
                continue;
            }
            let point = system.points().iter().find(|point| point.name == name);
            let Some(point) = point else {
                let points = system.points().iter().map(|point| &point.name);
                let known: Vec<_> = system.names().iter().chain(points).cloned().collect();
                let known = known.join(", ");
                return Err(ResponseError::UnknownCoordinate { name, known });
            };
            let on = point.form.clone();
            drives.push(Drive::Force { index, on, load });
        }
        for (index, (name, quantity, course)) in self.motions.into_iter().enumerate() {
            let support = system.supports().iter().position(|known| *known == name);
            let Some(support) = support else {
                let known = match system.supports() {
                    [] => "none".to_owned(),
                    supports => supports.join(", "),
                };
                return Err(ResponseError::UnknownSupport { name, known });
            };
            drives.push(Drive::Motion {
                index,
                support,
                quantity,
                course,
            });
        }
        let as_given = |mut error| {
            if let ResponseError::Load { index, .. }
            | ResponseError::ImpulseOnMassless { index, .. } = &mut error
            {
                *index = numbers[*index];
            }
            error
        };
        let problem = Problem::new(system, &self.initial, loads, grid)
            .map_err(as_given)?
            .numbered(&numbers)
            .driven(drives)?
            .with_combinations(self.outputs)?
            .to(self.precision);
        let problem = match self.forces {
            true => problem.with_forces(),
            false => problem,
        };
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
