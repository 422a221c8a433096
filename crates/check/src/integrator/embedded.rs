//! What the embedded Runge–Kutta pairs share: steps sized by a tolerance, taken by the crate
//! `differential-equations`.
//!
//! Its own dense output is not used: in release 0.7.0 that of DOP853 was measured 2e4 times worse
//! than its steps (7e-9 at a tolerance of 1e-13), that of the fifth-order pair 20 times.

use std::cell::Cell;

use differential_equations::error::Error;
use differential_equations::methods::{DormandPrince, ExplicitRungeKutta, Ordinary};
use differential_equations::ode::{ODE, OrdinaryNumericalMethod};
use differential_equations::status::Status;
use differential_equations::tolerance::Tolerance;
use eigentone_response::{Problem, ResponseError, Trajectory};

use super::course::{self, Recorder, Stretch};
use super::equation::EquationOfMotion;
use super::interpolation::Jet;
use super::{Limit, Meter, Work};

/// A pair of order `ORDER` as the crate has it.
pub(super) type Pair<const ORDER: usize, const STAGES: usize, const ALL: usize> =
    ExplicitRungeKutta<Ordinary, DormandPrince, f64, Vec<f64>, ORDER, STAGES, ALL>;

/// Why a tolerance is out of range.
pub(super) fn refuses_tolerance(tolerance: f64) -> Option<String> {
    let allowed = 1e-15..=1.0;
    (!allowed.contains(&tolerance))
        .then(|| format!("its tolerance is {tolerance}: it must lie between 1e-15 and 1"))
}

/// [x; x′]′ within one stretch, over the seconds since its start.
struct FirstOrder<'a> {
    equation: &'a EquationOfMotion,
    stretch: &'a Stretch<'a>,
    evaluations: &'a Cell<u64>,
}

impl ODE<f64, Vec<f64>> for FirstOrder<'_> {
    fn diff(&self, t: f64, y: &Vec<f64>, dydt: &mut Vec<f64>) {
        let n = self.equation.len();
        self.evaluations.set(self.evaluations.get() + 1);
        dydt[..n].copy_from_slice(&y[n..]);
        let forces = &self.stretch.forces;
        self.equation.acceleration(y, forces, t, &mut dydt[n..]);
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
        let largest = |part: &[f64]| part.iter().fold(0.0, |max: f64, x| max.max(x.abs()));
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

    /// The absolute tolerances of [x; x′].
    fn tolerances(&self, tolerance: f64, into: &mut Tolerance<f64>) {
        if let Tolerance::Vector(each) = into {
            let n = each.len() / 2;
            each[..n].fill(tolerance * self.displacement);
            each[n..].fill(tolerance * self.velocity);
        }
    }
}

/// An embedded pair at work on one problem.
pub(super) struct Integration<'a, const ORDER: usize, const STAGES: usize, const ALL: usize> {
    name: &'static str,
    pair: fn() -> Pair<ORDER, STAGES, ALL>,
    tolerance: f64,
    equation: &'a EquationOfMotion,
    /// A bound of all |λ| and load frequencies in rad/s.
    fastest: f64,
    longest_step: f64,
    scale: Scale,
    last_step: Option<f64>,
    evaluations: Cell<u64>,
    work: Work,
    meter: Meter,
}

impl<const ORDER: usize, const STAGES: usize, const ALL: usize>
    Integration<'_, ORDER, STAGES, ALL>
{
    /// Integrates a whole problem. No step is longer than `stable`/|λ| for the fastest λ: a longer
    /// one is not stable, and where it is taken nevertheless, because the fast motion has died
    /// down, that motion comes back between the steps.
    pub(super) fn run(
        name: &'static str,
        pair: fn() -> Pair<ORDER, STAGES, ALL>,
        stable: f64,
        tolerance: f64,
        problem: &Problem<'_>,
        limit: Limit,
    ) -> Result<(Trajectory, Work), ResponseError> {
        let refused = |reason| ResponseError::NotApplicable {
            method: name,
            reason,
        };
        if let Some(reason) = refuses_tolerance(tolerance) {
            return Err(refused(reason));
        }
        let equation = EquationOfMotion::of(problem.system()).map_err(refused)?;
        let harmonics = problem.timeline().harmonics().iter();
        let fastest = harmonics.fold(equation.fastest(), |fastest, (_, harmonic)| {
            fastest.max(harmonic.frequency.abs())
        });
        let mut integration = Integration {
            name,
            pair,
            tolerance,
            equation: &equation,
            fastest,
            longest_step: stable / fastest,
            scale: Scale::default(),
            last_step: None,
            evaluations: Cell::new(0),
            work: Work::default(),
            meter: Meter::start(limit),
        };
        let cross = |stretch: &Stretch<'_>, state: &mut Vec<f64>, recorder: &mut Recorder| {
            integration.cross(stretch, state, recorder)
        };
        let trajectory = course::follow(name, problem, &equation, cross)?;
        let work = Work {
            evaluations: integration.evaluations.get(),
            ..integration.work
        };
        Ok((trajectory, work))
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
        let natural = self.tolerance.powf(1.0 / ORDER as f64) / self.fastest;
        let natural = natural.min(length);
        self.scale.include(state);
        let ode = FirstOrder {
            equation: self.equation,
            stretch,
            evaluations: &self.evaluations,
        };
        let mut slope = vec![0.0; state.len()];
        ode.diff(0.0, state, &mut slope);
        let pull = slope[state.len() / 2..]
            .iter()
            .fold(0.0, |most: f64, a| most.max(a.abs()));
        let push = self.equation.largest_push(&stretch.forces, natural);
        self.scale.include_acceleration(pull + push, natural);

        let mut solver = (self.pair)()
            .rtol(0.0)
            .atol(vec![0.0; state.len()])
            .h0(self.last_step.unwrap_or(natural).min(length))
            .h_max(self.longest_step)
            .max_steps(usize::MAX);
        self.scale.tolerances(self.tolerance, &mut solver.atol);
        let name = self.name;
        let stopped = |reason| ResponseError::Stopped {
            method: name,
            reason,
        };
        let failed = |error| stopped(reason(&error, stretch.start()));
        solver.init(&ode, 0.0, length, state).map_err(failed)?;
        solver.set_status(Status::Solving);
        let mut between = vec![0.0; state.len()];
        loop {
            let proposed = solver.h();
            let left = length - solver.t();
            // So short a rest changes nothing, and the solver takes it for a breakdown.
            if left <= 1e-13 * proposed {
                break;
            }
            let cut = proposed >= left;
            if cut {
                solver.set_h(left);
            }
            self.meter.step().map_err(stopped)?;
            solver.step(&ode).map_err(failed)?;
            if let Status::RejectedStep = solver.status() {
                self.work.rejected += 1;
                continue;
            }
            self.work.accepted += 1;
            self.last_step = Some(match cut {
                true => proposed.max(solver.h()),
                false => solver.h(),
            });
            self.scale.include(solver.y());
            self.scale.tolerances(self.tolerance, &mut solver.atol);
            if stops.peek().is_none_or(|index| after(index) >= solver.t()) {
                continue;
            }
            let jet = |elapsed, state: &[f64]| {
                let evaluations = self.evaluations.get() + Jet::EVALUATIONS;
                self.evaluations.set(evaluations);
                Jet::of(self.equation, &stretch.forces, elapsed, state)
            };
            let start = jet(solver.t_prev(), solver.y_prev());
            let end = jet(solver.t(), solver.y());
            while let Some(index) = stops.next_if(|index| after(index) < solver.t()) {
                start.state_before(&end, after(&index), &mut between);
                recorder.record(index, &between)?;
            }
        }
        for index in stops {
            recorder.record(index, solver.y())?;
        }
        state.clone_from(solver.y());
        Ok(())
    }
}

/// What the solver reports, without the state; its times count from `start`.
fn reason(error: &Error<f64, Vec<f64>>, start: f64) -> String {
    match error {
        Error::Stiffness { t, .. } => format!("it finds the motion stiff at {} s", start + t),
        Error::StepSize { t, .. } => format!("its step vanishes at {} s", start + t),
        Error::BadInput { msg } => msg.clone(),
        _ => "its solver failed".to_owned(),
    }
}
