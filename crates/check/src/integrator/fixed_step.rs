//! What the methods of fixed step share: the division of the way into equal steps.

use eigentone_response::{Instant, Problem, ResponseError, TimeGrid, Trajectory};

use super::course::{self, Stretch};
use super::equation::{EquationOfMotion, Forces};
use super::limit::Meter;
use super::{Basis, Knob, Limit, Prediction, Work, refused, stopped};

/// An integrator with steps of fixed length.
pub(super) trait Scheme {
    fn name(&self) -> &'static str;

    /// Steps between two neighbouring instants of the grid.
    fn substeps(&self) -> u32;

    /// Why its other parameters are out of range.
    fn misfit(&self) -> Option<String> {
        None
    }

    /// The method for one equation.
    fn method<'e>(&self, equation: &'e EquationOfMotion) -> impl FixedStep + 'e;
}

/// A step of fixed length.
pub(super) trait FixedStep {
    /// Forgets what it knows of the motion, since a load changes its law here.
    fn restart(&mut self) {}

    /// Takes the state from `elapsed` s over a step of `h` s, or says why it cannot.
    fn step(
        &mut self,
        state: &mut [f64],
        forces: &Forces<'_>,
        elapsed: f64,
        h: f64,
    ) -> Result<(), String>;

    /// What it took so far, but for the steps.
    fn work(&self) -> Work;
}

pub(super) fn knob(scheme: &impl Scheme) -> Knob {
    Knob::Substeps(scheme.substeps())
}

/// The equation that a scheme integrates, or why it does not.
pub(super) fn equation(
    scheme: &impl Scheme,
    problem: &Problem<'_>,
) -> Result<EquationOfMotion, String> {
    match knob(scheme).misfit().or_else(|| scheme.misfit()) {
        Some(reason) => Err(reason),
        None => EquationOfMotion::of(problem.system()),
    }
}

/// Counts the steps.
pub(super) fn predict(
    scheme: &impl Scheme,
    problem: &Problem<'_>,
) -> Result<Prediction, ResponseError> {
    equation(scheme, problem).map_err(refused(scheme.name()))?;
    Ok(Prediction {
        steps: needed(scheme, problem) as f64,
        basis: Basis::Counted,
    })
}

/// The number of steps that a problem takes.
fn needed(scheme: &impl Scheme, problem: &Problem<'_>) -> u64 {
    let last: Vec<u64> = course::last_instant(problem).into_iter().collect();
    let counts = course::stretches(problem, &last).map(|stretch| {
        let legs = legs(&stretch, scheme.substeps());
        legs.map(|leg| leg.count).fold(0, u64::saturating_add)
    });
    counts.fold(0, u64::saturating_add)
}

/// Integrates a whole problem with `substeps` steps between neighbouring instants of the grid. Legs
/// that begin or end between instants get as many equal steps as keep them no longer than that.
/// The steps are the same whichever instants are asked for.
pub(super) fn integrate(
    scheme: &impl Scheme,
    problem: &Problem<'_>,
    limit: Limit,
) -> Result<(Trajectory, Work), ResponseError> {
    let name = scheme.name();
    let equation = equation(scheme, problem).map_err(refused(name))?;
    let stopped = stopped(name);
    let (needed, allowed) = (needed(scheme, problem), limit.steps);
    if needed > allowed {
        return Err(stopped(format!(
            "it needs {needed} steps, more than {allowed}"
        )));
    }
    let mut method = scheme.method(&equation);
    let mut meter = Meter::start(limit);
    let trajectory = course::follow(name, problem, &equation, |stretch, state, recorder| {
        method.restart();
        for leg in legs(stretch, scheme.substeps()) {
            for step in 0..leg.count {
                meter.step().map_err(stopped)?;
                let elapsed = leg.start + step as f64 * leg.h;
                method
                    .step(state, &stretch.forces, elapsed, leg.h)
                    .map_err(stopped)?;
            }
            if let Some(index) = leg.stop {
                recorder.record(index, state)?;
            }
        }
        Ok(())
    })?;
    let work = Work {
        accepted: meter.steps(),
        ..method.work()
    };
    Ok((trajectory, work))
}

/// A part of a stretch that is divided into equal steps.
pub(crate) struct Leg {
    /// Seconds since the stretch began.
    pub(crate) start: f64,
    pub(crate) count: u64,
    pub(crate) h: f64,
    /// The grid index at its end, if it is one of the stretch's.
    pub(crate) stop: Option<u64>,
}

/// The legs of a stretch, in order.
pub(crate) fn legs(stretch: &Stretch<'_>, substeps: u32) -> impl Iterator<Item = Leg> {
    let mut here = stretch.start;
    milestones(stretch).map(move |stop| {
        let next = stop.map_or(stretch.end, |index| stretch.stop(index));
        let start = stretch.elapsed(&here);
        let (count, h) = division(&here, &next, stretch.grid, substeps);
        here = next;
        Leg {
            start,
            count,
            h,
            stop,
        }
    })
}

/// Where the legs of a stretch end: at every stop, at the first and last instant of the grid within
/// it, and (`None`) at its own end.
fn milestones(stretch: &Stretch<'_>) -> impl Iterator<Item = Option<u64>> {
    let within = |index: &u64| {
        let instant = stretch.stop(*index);
        instant.order(&stretch.start).is_ge() && instant.order(&stretch.end).is_lt()
    };
    let nearest = |instant: &Instant| {
        // One place either side, for what the division rounds.
        let index = (instant.time().to_f64() / stretch.grid.step()).round() as u64;
        index.saturating_sub(1)..=index.saturating_add(1)
    };
    let mut all = stretch.stops.to_vec();
    all.extend(nearest(&stretch.start).find(within));
    all.extend(nearest(&stretch.end).rev().find(within));
    all.sort_unstable();
    all.dedup();
    all.into_iter().map(Some).chain([None])
}

/// How many steps a leg gets, and their length in s.
fn division(from: &Instant, to: &Instant, grid: &TimeGrid, substeps: u32) -> (u64, f64) {
    let longest = grid.step() / f64::from(substeps);
    match (from.index(), to.index()) {
        (Some(a), Some(b)) => ((b - a).saturating_mul(substeps.into()), longest),
        _ => {
            let leg = to.elapsed(from, grid).to_f64();
            let count = (leg / longest).ceil();
            (count as u64, leg / count)
        }
    }
}
