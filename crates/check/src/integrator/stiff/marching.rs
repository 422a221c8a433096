//! Steps of the crate `diffsol` within one stretch.

use std::cell::OnceCell;

use ::diffsol::error::DiffsolError;
use ::diffsol::{
    NalgebraMat, NalgebraVec, OdeEquations, OdeSolverMethod, OdeSolverProblem, OdeSolverStopReason,
    Vector,
};

use super::super::Work;
use super::super::adaptive::{Allowed, Passage};

/// Where the problems of one stretch are kept.
type Places<'p, E> = &'p [OnceCell<OdeSolverProblem<E>>];

/// How the crate's problem and solver are made.
pub(super) struct Recipe<P, M> {
    /// A problem with this tolerance.
    pub(super) problem: P,
    /// A solver of a problem, from another one's state or from the problem's own.
    pub(super) solver: M,
}

/// The crate's solver at work within one stretch. It holds fast to the problem, and that to its
/// tolerance; so a motion that grows takes one problem after the other.
pub(super) struct Marching<'p, E: OdeEquations, S, P, M> {
    problems: Places<'p, E>,
    recipe: Recipe<P, M>,
    solver: S,
    /// The crate's units of time in a second.
    rate: f64,
    /// The length of the stretch in s.
    whole: f64,
    allowed: Allowed,
    arrived: bool,
    state: Vec<f64>,
    /// What former solvers took.
    work: Work,
}

impl<'p, E, S, P, M> Marching<'p, E, S, P, M>
where
    E: OdeEquations<T = f64, V = NalgebraVec<f64>, M = NalgebraMat<f64>> + 'p,
    S: OdeSolverMethod<'p, E>,
    P: Fn(Allowed) -> Result<OdeSolverProblem<E>, DiffsolError>,
    M: Fn(&'p OdeSolverProblem<E>, Option<S::State>) -> Result<S, DiffsolError>,
{
    pub(super) fn begin(
        problems: Places<'p, E>,
        recipe: Recipe<P, M>,
        rate: f64,
        whole: f64,
        allowed: Allowed,
    ) -> Result<Marching<'p, E, S, P, M>, String> {
        let (solver, problems) =
            solver(&recipe, problems, None, allowed, rate * whole).map_err(text)?;
        Ok(Marching {
            state: solver.state().y.clone_as_vec(),
            problems,
            recipe,
            solver,
            rate,
            whole,
            allowed,
            arrived: false,
            work: Work::default(),
        })
    }

    /// What was taken so far, but for the steps.
    pub(super) fn work(&self) -> Work {
        let more = self.solver.get_statistics();
        let failed = more.number_of_error_test_failures + more.number_of_nonlinear_solver_fails;
        Work {
            rejected: self.work.rejected + failed as u64,
            factorisations: self.work.factorisations + more.number_of_linear_solver_setups as u64,
            solves: self.work.solves + more.number_of_nonlinear_solver_iterations as u64,
            ..self.work
        }
    }

    /// Goes on with a new tolerance, if there is a place left for its problem.
    fn renew(&mut self, allowed: Allowed) -> Result<(), DiffsolError> {
        if self.problems.is_empty() {
            return Ok(());
        }
        self.work = self.work();
        let state = Some(self.solver.checkpoint());
        let end = self.rate * self.whole;
        (self.solver, self.problems) = solver(&self.recipe, self.problems, state, allowed, end)?;
        self.allowed = allowed;
        Ok(())
    }
}

/// A solver of a new problem, and the places for problems that are left.
fn solver<'p, E, S, P, M>(
    recipe: &Recipe<P, M>,
    problems: Places<'p, E>,
    state: Option<S::State>,
    allowed: Allowed,
    end: f64,
) -> Result<(S, Places<'p, E>), DiffsolError>
where
    E: OdeEquations<T = f64, V = NalgebraVec<f64>, M = NalgebraMat<f64>> + 'p,
    S: OdeSolverMethod<'p, E>,
    P: Fn(Allowed) -> Result<OdeSolverProblem<E>, DiffsolError>,
    M: Fn(&'p OdeSolverProblem<E>, Option<S::State>) -> Result<S, DiffsolError>,
{
    let (place, left) = problems.split_first().expect("there is a place left");
    let problem = (recipe.problem)(allowed)?;
    let mut solver = (recipe.solver)(place.get_or_init(|| problem), state)?;
    solver.set_stop_time(end)?;
    Ok((solver, left))
}

impl<'p, E, S, P, M> Passage for Marching<'p, E, S, P, M>
where
    E: OdeEquations<T = f64, V = NalgebraVec<f64>, M = NalgebraMat<f64>> + 'p,
    S: OdeSolverMethod<'p, E>,
    P: Fn(Allowed) -> Result<OdeSolverProblem<E>, DiffsolError>,
    M: Fn(&'p OdeSolverProblem<E>, Option<S::State>) -> Result<S, DiffsolError>,
{
    fn elapsed(&self) -> f64 {
        match self.arrived {
            true => self.whole,
            false => self.solver.state().t / self.rate,
        }
    }

    fn state(&self) -> &[f64] {
        &self.state
    }

    fn wanted(&self) -> f64 {
        self.solver.state().h / self.rate
    }

    /// One step of the crate, which tries for itself until it is accurate enough, and ends none
    /// beyond the stretch.
    fn attempt(&mut self, _h: f64, allowed: Allowed) -> Result<bool, String> {
        let grown = |now: f64, then: f64| now > 4.0 * then;
        if grown(allowed.displacement, self.allowed.displacement)
            || grown(allowed.velocity, self.allowed.velocity)
        {
            self.renew(allowed).map_err(text)?;
        }
        let ended = self.solver.step().map_err(text)?;
        self.arrived = matches!(ended, OdeSolverStopReason::TstopReached);
        self.state = self.solver.state().y.clone_as_vec();
        Ok(true)
    }

    fn between(&self, elapsed: f64, state: &mut [f64]) -> Result<(), String> {
        let at = (elapsed * self.rate).min(self.solver.state().t);
        let values = self.solver.interpolate(at).map_err(text)?;
        state.copy_from_slice(&values.clone_as_vec());
        Ok(())
    }
}

fn text(error: DiffsolError) -> String {
    format!("its solver says: {error}")
}
