//! The problem of one stretch as the crate `diffsol` has it.

use std::cell::{Cell, OnceCell};

use ::diffsol::{NalgebraLU, NalgebraMat, OdeBuilder, OdeSolverProblem};

use super::super::Work;
use super::super::adaptive::{Adaptive, Allowed, Passage, Steps};
use super::super::course::Stretch;
use super::super::equation::EquationOfMotion;
use super::marching::{Marching, Recipe};

/// How many tolerances there can be within one stretch, each four times the one before or more. A
/// motion that grows further is held to the last.
const TOLERANCES: usize = 64;

type Solver = NalgebraLU<f64>;

/// Which of the crate's methods.
pub(super) enum Formula {
    Bdf,
    TrBdf2,
    Esdirk34,
}

/// One of the crate's methods, for one equation.
pub(super) struct Diffsol<'e> {
    formula: Formula,
    equation: &'e EquationOfMotion,
    work: Work,
}

impl Diffsol<'_> {
    pub(super) fn of(formula: Formula, equation: &EquationOfMotion) -> Diffsol<'_> {
        Diffsol {
            formula,
            equation,
            work: Work::default(),
        }
    }
}

impl Adaptive for Diffsol<'_> {
    fn order(&self) -> f64 {
        match self.formula {
            // Its highest.
            Formula::Bdf => 6.0,
            Formula::TrBdf2 => 3.0,
            Formula::Esdirk34 => 4.0,
        }
    }

    fn longest_stable_step(&self, _fastest: f64) -> f64 {
        f64::INFINITY
    }

    fn enter<R>(
        &mut self,
        stretch: &Stretch<'_>,
        state: &[f64],
        steps: Steps,
        allowed: Allowed,
        march: impl FnOnce(&mut dyn Passage) -> R,
    ) -> Result<R, String> {
        let n = self.equation.len();
        // The crate's own first step and shortest step are numbers of seconds; this makes them
        // fractions of the fastest motion.
        let rate = match self.equation.fastest() {
            fastest if fastest > 0.0 => fastest,
            _ => 1.0 / steps.whole,
        };
        let evaluations = Cell::new(0);
        let slope = |state: &[f64], slope: &mut [f64]| {
            evaluations.set(evaluations.get() + 1);
            for (slope, velocity) in slope.iter_mut().zip(&state[n..]) {
                *slope = velocity / rate;
            }
        };
        let faster = |acceleration: &mut [f64]| {
            for value in acceleration {
                *value /= rate;
            }
        };
        let motion = |x: &[f64], _: &[f64], t: f64, y: &mut [f64]| {
            slope(x, y);
            let forces = &stretch.forces;
            self.equation.acceleration(x, forces, t / rate, &mut y[n..]);
            faster(&mut y[n..]);
        };
        let along = |_: &[f64], _: &[f64], _: f64, v: &[f64], y: &mut [f64]| {
            slope(v, y);
            self.equation.pull(v, &mut y[n..]);
            faster(&mut y[n..]);
        };
        let problem = |allowed: Allowed| {
            let each = [allowed.displacement, allowed.velocity];
            // The crate bounds a root mean square.
            let share = (2.0 * n as f64).sqrt();
            OdeBuilder::<NalgebraMat<f64>>::new()
                .rtol(0.0)
                .atol(each.iter().flat_map(|each| vec![each / share; n]))
                .rhs_implicit(motion, along)
                .init(|_, _, y: &mut [f64]| y.copy_from_slice(state), 2 * n)
                .build()
        };
        let problems: Vec<_> = (0..TOLERANCES).map(|_| OnceCell::new()).collect();
        macro_rules! march_by {
            ($from:ident, $anew:ident) => {{
                let solver = |problem, state| match state {
                    Some(state) => OdeSolverProblem::$from::<Solver>(problem, state),
                    None => OdeSolverProblem::$anew::<Solver>(problem),
                };
                let recipe = Recipe { problem, solver };
                let mut marching = Marching::begin(&problems, recipe, rate, steps.whole, allowed)?;
                let result = march(&mut marching);
                (result, marching.work())
            }};
        }
        let (result, work) = match self.formula {
            Formula::Bdf => march_by!(bdf_solver, bdf),
            Formula::TrBdf2 => march_by!(tr_bdf2_solver, tr_bdf2),
            Formula::Esdirk34 => march_by!(esdirk34_solver, esdirk34),
        };
        self.work.evaluations += evaluations.get();
        self.work.rejected += work.rejected;
        self.work.factorisations += work.factorisations;
        self.work.solves += work.solves;
        Ok(result)
    }

    fn work(&self) -> Work {
        self.work
    }
}
