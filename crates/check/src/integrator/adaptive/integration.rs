//! A method with steps of its own choice, at work on one problem.

use eigentone_response::{Problem, ResponseError, Trajectory};

use super::super::course::{self, Recorder, Stretch};
use super::super::equation::EquationOfMotion;
use super::super::{Limit, Prediction, Work, stopped};
use super::march::March;
use super::scale::largest;
use super::{Adaptive, Steps};

/// A method at work on one problem.
pub(super) struct Integration<'a, A> {
    name: &'static str,
    method: A,
    equation: &'a EquationOfMotion,
    /// A bound of all |λ| and load frequencies in rad/s.
    fastest: f64,
    longest_step: f64,
    restarts: u64,
    march: March,
}

impl<'a, A: Adaptive> Integration<'a, A> {
    /// No step is longer than stability allows for the fastest λ: where a longer one is taken
    /// nevertheless, because the fast motion has died down, that motion comes back between the
    /// steps. Nor is any longer than half a period of a harmonic load, which it would not see.
    ///
    /// The settings are the method's name, its tolerance and a limit.
    pub(super) fn of(
        (name, tolerance, limit): (&'static str, f64, Limit),
        method: A,
        equation: &'a EquationOfMotion,
        problem: &Problem<'_>,
    ) -> Integration<'a, A> {
        let loads = problem.timeline().fastest();
        let own = equation.fastest();
        let half_a_period = std::f64::consts::PI / loads;
        let longest_step = method.longest_stable_step(own).min(half_a_period);
        Integration {
            name,
            longest_step,
            method,
            equation,
            fastest: own.max(loads),
            restarts: 0,
            march: March::with(tolerance, longest_step, limit),
        }
    }

    pub(super) fn run(&mut self, problem: &Problem<'_>) -> Result<Trajectory, ResponseError> {
        let (name, equation) = (self.name, self.equation);
        course::follow(name, problem, equation, |stretch, state, recorder| {
            self.cross(stretch, state, recorder)
        })
    }

    pub(super) fn work(&self) -> Work {
        let method = self.method.work();
        Work {
            evaluations: method.evaluations + self.restarts,
            accepted: self.march.accepted,
            rejected: self.march.rejected + method.rejected,
            ..method
        }
    }

    /// The steps tried.
    pub(super) fn steps(&self) -> u64 {
        self.march.meter.steps()
    }

    /// Foresees what would be taken with steps shorter by a factor.
    pub(super) fn shorten(&mut self, factor: f64) {
        self.march.outlook.factor = factor;
    }

    /// What is foreseen for the whole way.
    pub(super) fn foreseen(&self, end: f64) -> Prediction {
        self.march.foreseen(end)
    }

    /// How many times longer steps may become until stability limits them.
    pub(super) fn freedom(&self) -> f64 {
        self.march.outlook.freedom()
    }

    /// Takes the state over one stretch.
    fn cross(
        &mut self,
        stretch: &Stretch<'_>,
        state: &mut Vec<f64>,
        recorder: &mut Recorder,
    ) -> Result<(), ResponseError> {
        let at_start = |index: &u64| stretch.elapsed(&stretch.stop(*index)) <= 0.0;
        let (now, later) = stretch
            .stops
            .split_at(stretch.stops.partition_point(at_start));
        for index in now {
            recorder.record(*index, state)?;
        }
        let length = stretch.length();
        if length <= 0.0 {
            return Ok(());
        }
        let careful = self.march.tolerance.powf(1.0 / self.method.order()) / self.fastest;
        let steps = Steps {
            careful: careful.min(length),
            last: self.march.last_step,
            longest: self.longest_step,
            whole: length,
        };
        self.restarts += 1;
        let mut pull = vec![0.0; state.len() / 2];
        self.equation
            .acceleration(state, &stretch.forces, 0.0, &mut pull);
        let push = self.equation.largest_push(&stretch.forces, steps.careful);
        let acceleration = largest(&pull) + push;
        let allowed = self.march.begin(state, acceleration, steps.careful);
        let (march, stopped) = (&mut self.march, stopped(self.name));
        let arrived = self
            .method
            .enter(stretch, state, steps, allowed, |passage| {
                march.lead(passage, stretch, later, recorder, stopped)?;
                Ok::<_, ResponseError>(passage.state().to_vec())
            });
        *state = arrived.map_err(stopped)??;
        Ok(())
    }
}
