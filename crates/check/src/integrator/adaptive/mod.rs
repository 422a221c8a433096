//! What the methods share that size their steps by a tolerance.

mod integration;
mod march;
mod scale;

use eigentone_response::{Problem, ResponseError, Trajectory};

use super::course::{self, Stretch};
use super::equation::EquationOfMotion;
use super::{Basis, Knob, Limit, Prediction, Work, refused};
use integration::Integration;

/// An integrator with steps sized by a tolerance.
pub(in crate::integrator) trait Scheme {
    fn name(&self) -> &'static str;

    /// The error allowed in each step.
    fn tolerance(&self) -> f64;

    /// The method for one equation.
    fn method<'e>(&self, equation: &'e EquationOfMotion) -> impl Adaptive + 'e;
}

/// A method with steps of its own choice.
pub(in crate::integrator) trait Adaptive {
    /// The order of the error estimate: a step of h errs by h^`ORDER`.
    const ORDER: i32;

    /// The longest step that stability allows, where all |λ| lie below `fastest` rad/s; infinite
    /// if none does harm.
    fn longest_stable_step(&self, fastest: f64) -> f64;

    /// Begins anew at the start of a stretch, and lets `march` lead it through.
    fn enter<R>(
        &mut self,
        stretch: &Stretch<'_>,
        state: &[f64],
        steps: Steps,
        allowed: Allowed,
        march: impl FnOnce(&mut dyn Passage) -> R,
    ) -> Result<R, String>;

    /// What it took so far, but for the steps that were tried one by one.
    fn work(&self) -> Work;
}

/// A method at work within one stretch; times count from its start, in s.
pub(in crate::integrator) trait Passage {
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
    fn between(&self, elapsed: f64, state: &mut [f64]) -> Result<(), String>;
}

/// Lengths of steps within one stretch, in s.
#[derive(Clone, Copy)]
pub(in crate::integrator) struct Steps {
    /// So short that even the fastest motion is followed.
    pub(in crate::integrator) careful: f64,
    /// What was wanted at the end of the stretch before.
    pub(in crate::integrator) last: Option<f64>,
    /// No step is longer.
    pub(in crate::integrator) longest: f64,
    /// The length of the stretch.
    pub(in crate::integrator) whole: f64,
}

/// The errors allowed in one step.
#[derive(Clone, Copy)]
pub(in crate::integrator) struct Allowed {
    /// Of every displacement.
    pub(in crate::integrator) displacement: f64,
    /// Of every velocity.
    pub(in crate::integrator) velocity: f64,
}

pub(in crate::integrator) fn knob(scheme: &impl Scheme) -> Knob {
    Knob::Tolerance(scheme.tolerance())
}

/// The equation that a scheme integrates, or why it does not.
pub(in crate::integrator) fn equation(
    scheme: &impl Scheme,
    problem: &Problem<'_>,
) -> Result<EquationOfMotion, String> {
    match knob(scheme).misfit() {
        Some(reason) => Err(reason),
        None => EquationOfMotion::of(problem.system()),
    }
}

/// Integrates a whole problem.
pub(in crate::integrator) fn integrate(
    scheme: &impl Scheme,
    problem: &Problem<'_>,
    limit: Limit,
) -> Result<(Trajectory, Work), ResponseError> {
    let equation = equation(scheme, problem).map_err(refused(scheme.name()))?;
    let method = scheme.method(&equation);
    let mut integration = Integration::of(scheme, method, &equation, problem, limit);
    let trajectory = integration.run(problem)?;
    Ok((trajectory, integration.work()))
}

/// Tries the first steps and extends them to the rest of the way.
pub(in crate::integrator) fn predict(
    scheme: &impl Scheme,
    problem: &Problem<'_>,
) -> Result<Prediction, ResponseError> {
    const TRIAL: u64 = 1000;
    let equation = equation(scheme, problem).map_err(refused(scheme.name()))?;
    let last = course::last_instant(problem);
    let trial = problem.clone().at(last.as_slice())?;
    let limit = Limit {
        steps: TRIAL,
        time: None,
    };
    let method = scheme.method(&equation);
    let mut integration = Integration::of(scheme, method, &equation, &trial, limit);
    match integration.run(&trial) {
        Ok(_) => Ok(Prediction {
            steps: integration.steps() as f64,
            basis: Basis::Counted,
        }),
        Err(ResponseError::Stopped { .. }) if integration.steps() == TRIAL => {
            let end = last.map_or(0.0, |index| problem.grid().time(index));
            Ok(integration.extended(end))
        }
        Err(error) => Err(error),
    }
}
