//! What the embedded Runge–Kutta pairs share: steps taken by the crate `differential-equations`.
//!
//! Its own dense output is not used: in release 0.7.0 that of DOP853 was measured 2e4 times worse
//! than its steps (7e-9 at a tolerance of 1e-13), that of the fifth-order pair 20 times.

use std::cell::Cell;

use differential_equations::error::Error;
use differential_equations::methods::{DormandPrince, ExplicitRungeKutta, Ordinary};
use differential_equations::ode::{ODE, OrdinaryNumericalMethod};
use differential_equations::status::Status;
use differential_equations::tolerance::Tolerance;

use super::Work;
use super::adaptive::{Adaptive, Allowed, Passage, Steps};
use super::course::Stretch;
use super::equation::EquationOfMotion;
use super::interpolation::Jet;

/// A pair of order `ORDER` as the crate has it.
pub(super) type Pair<const ORDER: usize, const STAGES: usize, const ALL: usize> =
    ExplicitRungeKutta<Ordinary, DormandPrince, f64, Vec<f64>, ORDER, STAGES, ALL>;

/// A pair, for one equation.
pub(super) struct Embedded<'e, const ORDER: usize, const STAGES: usize, const ALL: usize> {
    pair: fn() -> Pair<ORDER, STAGES, ALL>,
    /// It is stable for |λ|h up to this.
    stable: f64,
    equation: &'e EquationOfMotion,
    evaluations: Cell<u64>,
}

impl<const ORDER: usize, const STAGES: usize, const ALL: usize> Embedded<'_, ORDER, STAGES, ALL> {
    pub(super) fn of(
        pair: fn() -> Pair<ORDER, STAGES, ALL>,
        stable: f64,
        equation: &EquationOfMotion,
    ) -> Embedded<'_, ORDER, STAGES, ALL> {
        Embedded {
            pair,
            stable,
            equation,
            evaluations: Cell::new(0),
        }
    }
}

impl<const ORDER: usize, const STAGES: usize, const ALL: usize> Adaptive
    for Embedded<'_, ORDER, STAGES, ALL>
{
    fn order(&self) -> f64 {
        ORDER as f64
    }

    fn longest_stable_step(&self, fastest: f64) -> f64 {
        self.stable / fastest
    }

    fn enter<R>(
        &mut self,
        stretch: &Stretch<'_>,
        state: &[f64],
        steps: Steps,
        allowed: Allowed,
        march: impl FnOnce(&mut dyn Passage) -> R,
    ) -> Result<R, String> {
        let motion = FirstOrder {
            equation: self.equation,
            stretch,
            evaluations: &self.evaluations,
        };
        let state = state.to_vec();
        let mut solver = (self.pair)()
            .rtol(0.0)
            .atol(vec![0.0; state.len()])
            .h0(steps.last.unwrap_or(steps.careful).min(steps.whole))
            .h_max(steps.longest)
            .max_steps(usize::MAX);
        set_tolerances(&mut solver.atol, allowed);
        solver
            .init(&motion, 0.0, steps.whole, &state)
            .map_err(|error| reason(&error))?;
        solver.set_status(Status::Solving);
        Ok(march(&mut Marching {
            motion,
            solver,
            ends: None,
        }))
    }

    fn work(&self) -> Work {
        Work {
            evaluations: self.evaluations.get(),
            ..Work::default()
        }
    }
}

/// [x; x′]′ within one stretch, over the seconds since its start.
struct FirstOrder<'a> {
    equation: &'a EquationOfMotion,
    stretch: &'a Stretch<'a>,
    evaluations: &'a Cell<u64>,
}

impl FirstOrder<'_> {
    fn count(&self, more: u64) {
        self.evaluations.set(self.evaluations.get() + more);
    }

    fn jet(&self, elapsed: f64, state: &[f64]) -> Jet {
        self.count(Jet::EVALUATIONS);
        Jet::of(self.equation, &self.stretch.forces, elapsed, state)
    }
}

impl ODE<f64, Vec<f64>> for FirstOrder<'_> {
    fn diff(&self, t: f64, y: &Vec<f64>, dydt: &mut Vec<f64>) {
        let n = self.equation.len();
        self.count(1);
        dydt[..n].copy_from_slice(&y[n..]);
        let forces = &self.stretch.forces;
        self.equation.acceleration(y, forces, t, &mut dydt[n..]);
    }
}

/// A pair at work within one stretch.
struct Marching<'s, const ORDER: usize, const STAGES: usize, const ALL: usize> {
    motion: FirstOrder<'s>,
    solver: Pair<ORDER, STAGES, ALL>,
    /// The ends of the last step, where it was looked back at.
    ends: Option<[Jet; 2]>,
}

impl<const ORDER: usize, const STAGES: usize, const ALL: usize> Passage
    for Marching<'_, ORDER, STAGES, ALL>
{
    fn elapsed(&self) -> f64 {
        self.solver.t()
    }

    fn state(&self) -> &[f64] {
        self.solver.y()
    }

    fn wanted(&self) -> f64 {
        self.solver.h()
    }

    fn attempt(&mut self, h: f64, allowed: Allowed) -> Result<bool, String> {
        set_tolerances(&mut self.solver.atol, allowed);
        // The time that a step takes is the difference of two doubles, or else what it lacks adds up.
        let (h, now) = (self.solver.h().min(h), self.solver.t());
        self.solver.set_h(now + h - now);
        match self.solver.step(&self.motion) {
            Ok(_) => Ok(!matches!(self.solver.status(), Status::RejectedStep)),
            Err(error) => Err(reason(&error)),
        }
    }

    fn look_back(&mut self) {
        let (solver, motion) = (&self.solver, &self.motion);
        let start = motion.jet(solver.t_prev(), solver.y_prev());
        self.ends = Some([start, motion.jet(solver.t(), solver.y())]);
    }

    fn between(&self, elapsed: f64, state: &mut [f64]) -> Result<(), String> {
        if let Some([start, end]) = &self.ends {
            start.state_before(end, elapsed, state);
        }
        Ok(())
    }
}

/// The crate bounds the root mean square of the ratios of errors to tolerances, by 1; so no ratio
/// is above the root of their number.
fn set_tolerances(tolerances: &mut Tolerance<f64>, allowed: Allowed) {
    if let Tolerance::Vector(each) = tolerances {
        let (n, share) = (each.len() / 2, (each.len() as f64).sqrt());
        each[..n].fill(allowed.displacement / share);
        each[n..].fill(allowed.velocity / share);
    }
}

/// What the solver reports, without the state and its time.
fn reason(error: &Error<f64, Vec<f64>>) -> String {
    match error {
        Error::Stiffness { .. } => "it finds the motion stiff".to_owned(),
        Error::StepSize { .. } => "its step vanishes".to_owned(),
        Error::BadInput { msg } => msg.clone(),
        _ => "its solver failed".to_owned(),
    }
}
