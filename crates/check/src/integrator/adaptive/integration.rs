//! The march of a method with steps of its own choice through a problem.

use eigentone_response::{Problem, ResponseError, Trajectory};

use super::super::course::{self, Recorder, Stretch};
use super::super::equation::EquationOfMotion;
use super::super::limit::Meter;
use super::super::{Basis, Limit, Prediction, Work, stopped};
use super::scale::{Scale, largest};
use super::{Adaptive, Passage, Scheme, Steps};

/// A method at work on one problem.
pub(super) struct Integration<'a, A> {
    name: &'static str,
    method: A,
    tolerance: f64,
    equation: &'a EquationOfMotion,
    /// A bound of all |λ| and load frequencies in rad/s.
    fastest: f64,
    longest_step: f64,
    scale: Scale,
    last_step: Option<f64>,
    restarts: u64,
    accepted: u64,
    rejected: u64,
    meter: Meter,
    /// The time in s that the steps have come to, and had come to with half of those allowed.
    reached: f64,
    halfway: f64,
}

impl<'a, A: Adaptive> Integration<'a, A> {
    /// No step is longer than stability allows for the fastest λ: where a longer one is taken
    /// nevertheless, because the fast motion has died down, that motion comes back between the
    /// steps. Nor is any longer than half a period of a harmonic load, which it would not see.
    pub(super) fn of(
        scheme: &impl Scheme,
        method: A,
        equation: &'a EquationOfMotion,
        problem: &Problem<'_>,
        limit: Limit,
    ) -> Integration<'a, A> {
        let harmonics = problem.timeline().harmonics().iter();
        let loads = harmonics.fold(0.0, |fastest: f64, (_, harmonic)| {
            fastest.max(harmonic.frequency.abs())
        });
        let own = equation.fastest();
        let half_a_period = std::f64::consts::PI / loads;
        Integration {
            name: scheme.name(),
            longest_step: method.longest_stable_step(own).min(half_a_period),
            method,
            tolerance: scheme.tolerance(),
            equation,
            fastest: own.max(loads),
            scale: Scale::default(),
            last_step: None,
            restarts: 0,
            accepted: 0,
            rejected: 0,
            meter: Meter::start(limit),
            reached: 0.0,
            halfway: 0.0,
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
            accepted: self.accepted,
            rejected: self.rejected,
            ..method
        }
    }

    /// The steps tried.
    pub(super) fn steps(&self) -> u64 {
        self.meter.steps()
    }

    /// What is foreseen, where the steps allowed did not reach the end.
    pub(super) fn extended(&self, end: f64) -> Prediction {
        let left = end - self.reached;
        let pace = (self.reached - self.halfway) / (self.steps() / 2) as f64;
        let as_before = left / pace.max(f64::MIN_POSITIVE);
        let stable = left / self.longest_step;
        // Rejected steps, and those cut short at a break, make it a little more than stable.
        let (more, basis) = match stable >= 0.9 * as_before {
            true => (stable.max(as_before), Basis::Stability),
            false => (as_before, Basis::Accuracy),
        };
        Prediction {
            steps: self.steps() as f64 + more,
            basis,
        }
    }

    /// Takes the state over one stretch.
    fn cross(
        &mut self,
        stretch: &Stretch<'_>,
        state: &mut Vec<f64>,
        recorder: &mut Recorder,
    ) -> Result<(), ResponseError> {
        let after = |index: &u64| stretch.elapsed(&stretch.stop(*index));
        let mut stops = stretch.stops.iter().copied().peekable();
        while let Some(index) = stops.next_if(|index| after(index) <= 0.0) {
            recorder.record(index, state)?;
        }
        let length = stretch.length();
        if length <= 0.0 {
            return Ok(());
        }
        let natural = self.tolerance.powf(1.0 / f64::from(A::ORDER)) / self.fastest;
        let natural = natural.min(length);
        self.scale.include(state);
        self.restarts += 1;
        let mut pull = vec![0.0; state.len() / 2];
        self.equation
            .acceleration(state, &stretch.forces, 0.0, &mut pull);
        let push = self.equation.largest_push(&stretch.forces, natural);
        self.scale
            .include_acceleration(largest(&pull) + push, natural);

        let (stopped, start) = (stopped(self.name), stretch.start());
        let steps = Steps {
            careful: natural,
            last: self.last_step,
            longest: self.longest_step,
            whole: length,
        };
        let allowed = self.scale.allowed(self.tolerance);
        let passage = self.method.enter(stretch, state, steps, allowed);
        let mut passage = passage.map_err(stopped)?;
        let mut between = vec![0.0; state.len()];
        loop {
            let wanted = passage.wanted();
            let left = length - passage.elapsed();
            // So short a rest changes nothing, and the solver takes it for a breakdown.
            if left <= 1e-13 * wanted {
                break;
            }
            self.meter.step().map_err(stopped)?;
            let allowed = self.scale.allowed(self.tolerance);
            if !passage.attempt(left, allowed).map_err(|reason| {
                let at = start + passage.elapsed();
                stopped(format!("{reason} at {at} s"))
            })? {
                self.rejected += 1;
                continue;
            }
            self.accepted += 1;
            self.last_step = Some(match wanted >= left {
                true => wanted.max(passage.wanted()),
                false => passage.wanted(),
            });
            self.reached = start + passage.elapsed();
            if self.meter.is_in_first_half() {
                self.halfway = self.reached;
            }
            self.scale.include(passage.state());
            let within = |index: &u64| after(index) < passage.elapsed();
            if !stops.peek().is_some_and(within) {
                continue;
            }
            passage.look_back();
            while let Some(index) = stops.next_if(|index| after(index) < passage.elapsed()) {
                passage.between(after(&index), &mut between);
                recorder.record(index, &between)?;
            }
        }
        state.clear();
        state.extend_from_slice(passage.state());
        for index in stops {
            recorder.record(index, state)?;
        }
        Ok(())
    }
}
