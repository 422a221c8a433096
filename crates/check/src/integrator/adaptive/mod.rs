//! What the methods share that size their steps by a tolerance.

mod integration;
mod march;
mod outlook;
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
    /// The order of the error estimate: a step of h errs by h to this power.
    fn order(&self) -> f64;

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
    let settings = (scheme.name(), scheme.tolerance(), limit);
    let mut integration = Integration::of(settings, method, &equation, problem);
    let trajectory = integration.run(problem)?;
    Ok((trajectory, integration.work()))
}

/// Tries the first steps. Where they do not reach the end, tries again with looser tolerances, whose
/// steps are longer, and shortens those by the order of the error.
pub(in crate::integrator) fn predict(
    scheme: &impl Scheme,
    problem: &Problem<'_>,
) -> Result<Prediction, ResponseError> {
    /// Steps in a trial.
    const TRIAL: u64 = 1000;
    /// What steps still follow a motion with.
    const LOOSEST: f64 = 1e-3;
    let equation = equation(scheme, problem).map_err(refused(scheme.name()))?;
    let last = course::last_instant(problem);
    let end = last.map_or(0.0, |index| problem.grid().time(index));
    let short = problem.clone().at(last.as_slice())?;
    let limit = Limit {
        steps: TRIAL,
        time: None,
    };
    let asked = scheme.tolerance();
    let order = scheme.method(&equation).order();
    let trial = |tolerance: f64| {
        let method = scheme.method(&equation);
        let settings = (scheme.name(), tolerance, limit);
        let mut integration = Integration::of(settings, method, &equation, &short);
        integration.shorten((asked / tolerance).powf(1.0 / order));
        let arrived = match integration.run(&short) {
            Ok(_) => true,
            Err(ResponseError::Stopped { .. }) if integration.steps() == TRIAL => false,
            Err(error) => return Err(error),
        };
        Ok((arrived, integration.foreseen(end), integration.freedom()))
    };
    let (arrived, first, freedom) = trial(asked)?;
    if arrived {
        return Ok(Prediction {
            basis: Basis::Counted,
            ..first
        });
    }
    // Looser than this, and stability would limit the steps and hide what accuracy asks for.
    let loosest = LOOSEST.min(asked * (0.5 * freedom).powf(order));
    let mut prediction = first;
    // The second of these is as near to what is asked as a trial that reaches the end can be.
    for _ in 0..2 {
        let fewer = 0.7 * TRIAL as f64 / prediction.steps;
        let looser = (asked * fewer.powf(-order)).min(loosest);
        if looser <= asked {
            break;
        }
        prediction = trial(looser)?.1;
    }
    // A motion that goes on as it began is better predicted by its own first steps.
    let goes_on = (0.7..1.4).contains(&(prediction.steps / first.steps));
    Ok(if goes_on { first } else { prediction })
}
