//! What the methods share that size their steps by a tolerance.

use eigentone_response::{Problem, ResponseError, Trajectory};

use super::course::{self, Recorder, Stretch};
use super::equation::EquationOfMotion;
use super::limit::Meter;
use super::{Basis, Knob, Limit, Prediction, Work};

/// An integrator with steps sized by a tolerance.
pub(super) trait Scheme {
    fn name(&self) -> &'static str;

    /// The error allowed in each step.
    fn tolerance(&self) -> f64;

    /// The method for one equation.
    fn method<'e>(&self, equation: &'e EquationOfMotion) -> impl Adaptive + 'e;
}

/// A method with steps of its own choice.
pub(super) trait Adaptive {
    /// The order of the error estimate: a step of h errs by h^`ORDER`.
    const ORDER: i32;

    /// It at work within one stretch.
    type Passage<'s>: Passage
    where
        Self: 's;

    /// The longest step that stability allows, where all |λ| lie below `fastest` rad/s; infinite
    /// if none does harm.
    fn longest_stable_step(&self, fastest: f64) -> f64;

    /// Begins anew at the start of a stretch.
    fn enter<'s>(
        &'s mut self,
        stretch: &'s Stretch<'s>,
        state: &[f64],
        steps: Steps,
        allowed: Allowed,
    ) -> Result<Self::Passage<'s>, String>;

    /// What it took so far, but for the steps.
    fn work(&self) -> Work;
}

/// A method at work within one stretch; times count from its start, in s.
pub(super) trait Passage {
    /// How far it has come.
    fn elapsed(&self) -> f64;

    /// The state [x; x′] there.
    fn state(&self) -> &[f64];

    /// How long it wants its next step to be.
    fn wanted(&self) -> f64;

    /// Tries a step of that length, or of `h` s if that is shorter; says whether it is accurate
    /// enough to be taken.
    fn attempt(&mut self, h: f64, allowed: Allowed) -> Result<bool, String>;

    /// Prepares for [`between`](Self::between) within the step just taken.
    fn look_back(&mut self) {}

    /// The state at an instant within the step just taken, after [`look_back`](Self::look_back).
    fn between(&self, elapsed: f64, state: &mut [f64]);
}

/// Lengths of steps within one stretch, in s.
#[derive(Clone, Copy)]
pub(super) struct Steps {
    /// So short that even the fastest motion is followed.
    pub(super) careful: f64,
    /// What was wanted at the end of the stretch before.
    pub(super) last: Option<f64>,
    /// No step is longer.
    pub(super) longest: f64,
    /// The length of the stretch.
    pub(super) whole: f64,
}

/// The errors allowed in one step.
#[derive(Clone, Copy)]
pub(super) struct Allowed {
    /// Of every displacement.
    pub(super) displacement: f64,
    /// Of every velocity.
    pub(super) velocity: f64,
}

pub(super) fn knob(scheme: &impl Scheme) -> Knob {
    Knob::Tolerance(scheme.tolerance())
}

/// The equation that a scheme integrates, or why it does not.
pub(super) fn equation(
    scheme: &impl Scheme,
    problem: &Problem<'_>,
) -> Result<EquationOfMotion, String> {
    match knob(scheme).misfit() {
        Some(reason) => Err(reason),
        None => EquationOfMotion::of(problem.system()),
    }
}

/// [`equation`], with the error that says so.
fn applicable(
    scheme: &impl Scheme,
    problem: &Problem<'_>,
) -> Result<EquationOfMotion, ResponseError> {
    equation(scheme, problem).map_err(|reason| ResponseError::NotApplicable {
        method: scheme.name(),
        reason,
    })
}

/// Integrates a whole problem.
pub(super) fn integrate(
    scheme: &impl Scheme,
    problem: &Problem<'_>,
    limit: Limit,
) -> Result<(Trajectory, Work), ResponseError> {
    let equation = applicable(scheme, problem)?;
    let method = scheme.method(&equation);
    let mut integration = Integration::of(scheme, method, &equation, problem, limit);
    let trajectory = integration.run(problem)?;
    Ok((trajectory, integration.work()))
}

/// Tries the first steps and extends them to the rest of the way.
pub(super) fn predict(
    scheme: &impl Scheme,
    problem: &Problem<'_>,
) -> Result<Prediction, ResponseError> {
    const TRIAL: u64 = 1000;
    let equation = applicable(scheme, problem)?;
    let last = course::last_instant(problem);
    let trial = problem.clone().at(last.as_slice())?;
    let limit = Limit {
        steps: TRIAL,
        time: None,
    };
    let method = scheme.method(&equation);
    let mut integration = Integration::of(scheme, method, &equation, &trial, limit);
    let counted = |meter: &Meter| Prediction {
        steps: meter.steps() as f64,
        basis: Basis::Counted,
    };
    match integration.run(&trial) {
        Ok(_) => Ok(counted(&integration.meter)),
        Err(ResponseError::Stopped { .. }) if integration.meter.is_full() => {
            let end = last.map_or(0.0, |index| problem.grid().time(index));
            let left = end - integration.reached;
            let pace = (integration.reached - integration.halfway) / (TRIAL / 2) as f64;
            let pace = pace.max(f64::MIN_POSITIVE);
            let (as_before, stable) = (left / pace, left / integration.longest_step);
            // Rejected steps, and those cut short at a break, make it a little more than stable.
            let (more, basis) = match stable >= 0.9 * as_before {
                true => (stable.max(as_before), Basis::Stability),
                false => (as_before, Basis::Accuracy),
            };
            Ok(Prediction {
                steps: TRIAL as f64 + more,
                basis,
            })
        }
        Err(error) => Err(error),
    }
}

/// The largest displacement and velocity so far, which a tolerance is relative to.
#[derive(Default)]
struct Scale {
    displacement: f64,
    velocity: f64,
}

impl Scale {
    fn include(&mut self, state: &[f64]) {
        let (displacement, velocity) = state.split_at(state.len() / 2);
        self.displacement = self.displacement.max(largest(displacement));
        self.velocity = self.velocity.max(largest(velocity));
    }

    /// Where something does not move yet, what an acceleration in m/s² does within `time` s.
    fn include_acceleration(&mut self, acceleration: f64, time: f64) {
        let at_least = |value: f64| value.max(f64::MIN_POSITIVE);
        self.velocity = at_least(self.velocity.max(acceleration * time));
        self.displacement = at_least(self.displacement.max(self.velocity * time));
    }

    fn allowed(&self, tolerance: f64) -> Allowed {
        Allowed {
            displacement: tolerance * self.displacement,
            velocity: tolerance * self.velocity,
        }
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most: f64, x| most.max(x.abs()))
}

/// A method at work on one problem.
struct Integration<'a, A> {
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
    fn of(
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

    fn run(&mut self, problem: &Problem<'_>) -> Result<Trajectory, ResponseError> {
        let (name, equation) = (self.name, self.equation);
        course::follow(name, problem, equation, |stretch, state, recorder| {
            self.cross(stretch, state, recorder)
        })
    }

    fn work(&self) -> Work {
        let method = self.method.work();
        Work {
            evaluations: method.evaluations + self.restarts,
            accepted: self.accepted,
            rejected: self.rejected,
            ..method
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

        let (name, start) = (self.name, stretch.start());
        let stopped = |reason| ResponseError::Stopped {
            method: name,
            reason,
        };
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
