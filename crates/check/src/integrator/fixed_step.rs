//! What the methods of fixed step share: the division of the way into equal steps.

use eigentone_response::{Instant, Problem, ResponseError, TimeGrid, Trajectory};

use super::course::{self, Stretch};
use super::equation::{EquationOfMotion, Forces};
use super::{Limit, Meter, Work};

/// A step of fixed length.
pub(super) trait FixedStep {
    /// Evaluations of the acceleration in a restart and in a step.
    const EVALUATIONS: (u64, u64);

    /// Begins anew at the state [x; x′], `elapsed` s after the forces' piece began.
    fn restart(&mut self, state: &[f64], forces: &Forces<'_>, elapsed: f64);

    /// Takes the state from `elapsed` s over a step of `h` s, or says why it cannot.
    fn step(
        &mut self,
        state: &mut [f64],
        forces: &Forces<'_>,
        elapsed: f64,
        h: f64,
    ) -> Result<(), String>;
}

/// The equation that a method with so many substeps integrates.
pub(super) fn equation(
    name: &'static str,
    problem: &Problem<'_>,
    substeps: u32,
) -> Result<EquationOfMotion, ResponseError> {
    let refused = |reason| ResponseError::NotApplicable {
        method: name,
        reason,
    };
    match refuses_substeps(substeps) {
        Some(reason) => Err(refused(reason)),
        None => EquationOfMotion::of(problem.system()).map_err(refused),
    }
}

/// Why so many substeps cannot be.
pub(super) fn refuses_substeps(substeps: u32) -> Option<String> {
    (substeps == 0).then(|| "it has 0 substeps: it needs at least 1".to_owned())
}

/// Integrates a whole problem with `substeps` steps between neighbouring instants of the grid. Legs
/// that begin or end between instants get as many equal steps as keep them no longer than that.
/// The steps are the same whichever instants are asked for.
pub(super) fn run<'e, S: FixedStep>(
    name: &'static str,
    problem: &Problem<'_>,
    equation: &'e EquationOfMotion,
    method: impl FnOnce(&'e EquationOfMotion) -> S,
    substeps: u32,
    limit: Limit,
) -> Result<(Trajectory, Work), ResponseError> {
    let stopped = |reason| ResponseError::Stopped {
        method: name,
        reason,
    };
    let grid = problem.grid();
    let furthest = match problem.instants() {
        Some(instants) => instants.iter().copied().max().unwrap_or(0),
        None => grid.last(),
    };
    let needed = furthest.saturating_mul(substeps.into());
    if needed > limit.steps {
        let allowed = limit.steps;
        return Err(stopped(format!(
            "it needs {needed} steps, more than {allowed}"
        )));
    }
    let mut method = method(equation);
    let mut meter = Meter::start(limit);
    let mut restarts = 0;
    let trajectory = course::follow(name, problem, equation, |stretch, state, recorder| {
        let mut here = stretch.start;
        method.restart(state, &stretch.forces, 0.0);
        restarts += 1;
        for stop in milestones(stretch) {
            let next = stop.map_or(stretch.end, |index| stretch.stop(index));
            let base = stretch.elapsed(&here);
            let (count, h) = division(&here, &next, grid, substeps);
            for step in 0..count {
                meter.step().map_err(stopped)?;
                let elapsed = base + step as f64 * h;
                method
                    .step(state, &stretch.forces, elapsed, h)
                    .map_err(stopped)?;
            }
            if let Some(index) = stop {
                recorder.record(index, state)?;
            }
            here = next;
        }
        Ok(())
    })?;
    let (restart, step) = S::EVALUATIONS;
    let work = Work {
        evaluations: restarts * restart + meter.steps * step,
        accepted: meter.steps,
        rejected: 0,
    };
    Ok((trajectory, work))
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
    let mut all = stretch.stops.clone();
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
