//! Motions with switches by integrators that locate events: what people have without exact solutions.
//!
//! Steps of fixed length; where a guard is negative at the end of a step, the step is shortened by bisection until it ends
//! there. Which phases follow is found by trying all. An event that comes and goes within a step is missed, as it is by all such integrators.

mod choice;
mod comparison;
mod law;
mod one_step;

use std::cell::Cell;

use eigentone_response::{Problem, ResponseError, Trajectory};
use eigentone_switching::{Event, EventKind, Switch};

use crate::integrator::fixed_step::legs;
use crate::integrator::{EquationOfMotion, Knob, Limit, Meter, Stretch, Work, follow};
use law::{Law, Phase, Place};
use one_step::Flow;

pub use one_step::OneStep;

/// An integrator of fixed steps that locates events.
///
/// ```
/// use eigentone_check::{EventDriven, Limit, OneStep};
/// use eigentone_modes::{GROUND, System};
/// use eigentone_response::{Response, State};
/// use eigentone_switching::{Impact, Switch};
///
/// let system = System::builder().mass("ball", 1.0).spring(GROUND, "ball", 4.0).build()?;
/// let from = State::at_rest().displace("ball", -1.0);
/// let problem = Response::of(&system).from(from).every(0.125).until(1.0).problem()?;
/// let wall = Impact { between: [GROUND.to_owned(), "ball".to_owned()], gap: 0.0, restitution: 0.5 };
/// let method = EventDriven { method: OneStep::Dop853, substeps: 4 };
/// let motion = method.integrate(&problem, &[Switch::Impact(wall)], Limit::default())?;
/// // After a quarter of the period of π s.
/// assert!((motion.events[0].time - std::f64::consts::FRAC_PI_4).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EventDriven {
    /// How it steps between events.
    pub method: OneStep,
    /// Equal steps between two neighbouring instants of the grid; at least 1.
    pub substeps: u32,
}

/// What an [`EventDriven`] integrator finds.
#[derive(Clone, Debug)]
pub struct EventDrivenMotion {
    /// The motion at the instants asked for.
    pub trajectory: Trajectory,
    /// The events, without bounds (0).
    pub events: Vec<Event>,
    /// What it took.
    pub work: Work,
}

impl EventDriven {
    /// What it is set by.
    pub fn knob(&self) -> Knob {
        Knob::Substeps(self.substeps)
    }

    /// The motion and its events.
    ///
    /// # Errors
    /// [`ResponseError::NotApplicable`] for a singular mass matrix, unknown names, no substeps, or a support that jumps at what
    /// damps and switches;
    /// [`ResponseError::Stopped`] where the limit is reached, or where no phases agree with a state or which of several do is not
    /// determined; [`ResponseError::Overflow`] and [`ResponseError::TooLarge`].
    pub fn integrate(
        &self,
        problem: &Problem<'_>,
        switches: &[Switch],
        limit: Limit,
    ) -> Result<EventDrivenMotion, ResponseError> {
        let name = self.method.name();
        let refused = |reason| ResponseError::NotApplicable {
            method: name,
            reason,
        };
        let stopped = |reason| ResponseError::Stopped {
            method: name,
            reason,
        };
        if self.substeps == 0 {
            return Err(refused("it has 0 substeps: it needs at least 1".to_owned()));
        }
        let equation = EquationOfMotion::of(problem.system()).map_err(refused)?;
        let law = Law::of(&equation, problem, switches).map_err(refused)?;
        if let Some(reason) = law.refuses() {
            return Err(refused(reason));
        }
        let evaluations = Cell::new(0);
        let mut march = March {
            method: self.method,
            phases: Vec::new(),
            forces: vec![0.0; law.len()],
            events: Vec::new(),
            evaluations: &evaluations,
            law,
        };
        let mut meter = Meter::start(limit);
        let trajectory = follow(name, problem, &equation, |stretch, state, recorder| {
            march.settle(stretch, state, 0.0).map_err(stopped)?;
            for leg in legs(stretch, self.substeps) {
                for step in 0..leg.count {
                    meter.step().map_err(stopped)?;
                    let from = leg.start + step as f64 * leg.h;
                    march.step(stretch, state, from, leg.h).map_err(stopped)?;
                }
                if let Some(index) = leg.stop {
                    recorder.record(index, state)?;
                }
            }
            Ok(())
        })?;
        Ok(EventDrivenMotion {
            trajectory,
            work: Work {
                evaluations: evaluations.get(),
                accepted: meter.steps(),
                ..Work::default()
            },
            events: march.events,
        })
    }
}

/// A state on its way.
struct March<'a> {
    method: OneStep,
    law: Law<'a>,
    /// None before the start.
    phases: Vec<Phase>,
    /// Of each switch.
    forces: Vec<f64>,
    events: Vec<Event>,
    evaluations: &'a Cell<u64>,
}

impl March<'_> {
    /// Finds the phases that follow.
    fn settle(
        &mut self,
        stretch: &Stretch<'_>,
        state: &mut [f64],
        elapsed: f64,
    ) -> Result<(), String> {
        let piece = stretch.forces.piece;
        let time = stretch.start() + elapsed;
        self.law.see(Place {
            piece,
            elapsed,
            state,
        });
        let hit = self
            .law
            .apply_impacts(&self.phases, piece, elapsed, state)?;
        let place = Place {
            piece,
            elapsed,
            state,
        };
        let (phases, moment) = self
            .law
            .phases(place, (&self.phases, &self.forces))
            .map_err(|reason| format!("{reason} at {time} s"))?;
        let event = |switch, kind| Event {
            time,
            bound: 0.0,
            switch,
            kind,
        };
        if !self.phases.is_empty() {
            self.events
                .extend(hit.iter().map(|switch| event(*switch, EventKind::Impact)));
            let changes = self.phases.iter().zip(&phases).enumerate();
            let changes =
                changes.filter_map(|(switch, (old, new))| Some(event(switch, old.becomes(*new)?)));
            self.events.extend(changes);
        }
        self.phases = phases;
        self.forces = moment.forces;
        self.law.project(&self.phases, piece, elapsed, state);
        Ok(())
    }

    /// Takes the state `h` s further, through all events on the way.
    fn step(
        &mut self,
        stretch: &Stretch<'_>,
        state: &mut Vec<f64>,
        from: f64,
        h: f64,
    ) -> Result<(), String> {
        /// A step in which more happens is of no use.
        const MOST: usize = 10_000;
        let end = from + h;
        let mut now = from;
        for _ in 0..MOST {
            let flow = Flow {
                law: &self.law,
                phases: &self.phases,
                piece: stretch.forces.piece,
                evaluations: self.evaluations,
            };
            let ends = |h: f64| {
                let next = self.method.step(&flow, now, state, h);
                let place = Place {
                    piece: flow.piece,
                    elapsed: now + h,
                    state: &next,
                };
                let moment = flow.law.moment(flow.phases, place);
                let lasts = moment.as_ref().is_some_and(|moment| {
                    let mut phases = flow.phases.iter().enumerate();
                    phases.all(|(k, phase)| flow.law.guard(k, *phase, place, moment) >= 0.0)
                });
                (next, lasts, moment.map(|moment| moment.forces))
            };
            let left = end - now;
            let (next, lasts, forces) = ends(left);
            if !next.iter().all(|value| value.is_finite()) {
                *state = next;
                return Ok(());
            }
            if let (true, Some(forces)) = (lasts, &forces) {
                *state = next;
                self.forces.clone_from(forces);
                self.law.see(Place {
                    piece: stretch.forces.piece,
                    elapsed: end,
                    state,
                });
                return Ok(());
            }
            let (mut low, mut high, mut beyond) = (0.0, left, (next, forces));
            for _ in 0..60 {
                let middle = f64::midpoint(low, high);
                if middle <= low || middle >= high || high - low <= 1e-15 * end {
                    break;
                }
                match ends(middle) {
                    (_, true, _) => low = middle,
                    (next, false, forces) => (high, beyond) = (middle, (next, forces)),
                }
            }
            now += high;
            *state = beyond.0;
            self.forces = beyond.1.unwrap_or_else(|| self.forces.clone());
            self.settle(stretch, state, now)?;
            if now >= end {
                return Ok(());
            }
        }
        Err(format!(
            "{MOST} events lie within a step at {} s",
            stretch.start() + now
        ))
    }
}
