//! Integrators that locate events beside the exact motion between them.

use std::time::Instant;

use eigentone_digits::sort_by_number;
use eigentone_response::{Problem, ResponseError};
use eigentone_switching::{Event, Switch, SwitchedMotion, Switching, SwitchingError};

use super::{EventDriven, OneStep};
use crate::integrator::Limit;
use crate::run_time::RunTime;
use crate::trajectory_error::TrajectoryError;
use crate::truth::MotionTruth;
use crate::work_precision::{
    Effort, EventsFound, Measurement, Outcome, Pick, Progress, WorkPrecision, WorkPrecisionRow,
    thin,
};

impl WorkPrecision {
    /// The same of a system with switches: the exact motion, then each of these methods with 1, 2, 4 … substeps, halved until
    /// two answers in a row agree to 1e-10 of the peak, until it is stopped, or 4096. Errors are measured from the exact motion.
    ///
    /// # Errors
    /// [`SwitchingError`] where there is no exact motion.
    pub fn measure_switched(
        problem: &Problem<'_>,
        switches: &[Switch],
        methods: &[OneStep],
        effort: Effort,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<WorkPrecision, SwitchingError> {
        const MOST: u32 = 4096;
        const ALIKE: f64 = 1e-10;
        let started = Instant::now();
        let problem = &thin(problem, effort.instants)?;
        let total = 1 + methods.len() * (MOST.ilog2() as usize + 1);
        let exact = Switching::new(problem, switches.to_vec())?;
        let (exact, time) = RunTime::of(|| exact.run())?;
        let trajectory = exact.trajectory().clone();
        let name = trajectory.method();
        let truth = MotionTruth::Doubles(Box::new(trajectory));
        let mut rows = vec![WorkPrecisionRow {
            method: name,
            knob: None,
            outcome: Outcome::Measured(Measurement {
                error: None,
                stable: Some(true),
                bounds: exact.trajectory().bounds(),
                digits: exact.trajectory().digits(),
                operations: None,
                time,
                work: None,
                events: Some(found(exact.events(), &exact, 0.0)),
            }),
        }];
        for method in methods {
            let mut last = None;
            let settings = (0..=MOST.ilog2()).map(|power| 1 << power);
            for substeps in settings {
                let method = EventDriven {
                    method: *method,
                    substeps,
                };
                let step = problem.grid().step() / f64::from(substeps);
                let (name, knob) = (method.method.name(), Some(method.knob()));
                progress(Progress {
                    done: rows.len(),
                    total,
                    method: name,
                    knob,
                });
                let left = effort.total.saturating_sub(started.elapsed());
                let limit = Limit {
                    steps: u64::MAX,
                    time: Some(effort.run.min(left)),
                };
                let run = || method.integrate(problem, switches, limit);
                let (outcome, answer) = match RunTime::of(run) {
                    Ok((motion, time)) => {
                        let measured = Outcome::Measured(Measurement {
                            error: truth.error_of(&motion.trajectory),
                            stable: truth.is_stable(&motion.trajectory),
                            bounds: motion.trajectory.bounds(),
                            digits: motion.trajectory.digits(),
                            operations: None,
                            time,
                            work: Some(motion.work),
                            events: Some(found(&motion.events, &exact, step)),
                        });
                        (measured, Some(motion.trajectory))
                    }
                    Err(ResponseError::NotApplicable { reason, .. }) => {
                        (Outcome::Refused { reason }, None)
                    }
                    Err(error) => (Outcome::Failed(error), None),
                };
                // Shorter steps may be stable.
                let grows = matches!(&outcome, Outcome::Failed(ResponseError::Overflow { .. }));
                rows.push(WorkPrecisionRow {
                    method: name,
                    knob,
                    outcome,
                });
                if grows {
                    continue;
                }
                let Some(answer) = answer else { break };
                let agree = last.replace(answer).is_some_and(|before| {
                    let now = last.as_ref().expect("just put there");
                    TrajectoryError::between(&before, now).worst() < ALIKE
                });
                if agree {
                    break;
                }
            }
        }
        Ok(WorkPrecision {
            reference: name,
            instants: exact.trajectory().len(),
            span: problem.grid().time(problem.grid().last()),
            peaks: truth.peaks(),
            rows,
            pick: Some(Pick {
                row: 0,
                reason: "the motion between events is exact, and no event is missed".to_owned(),
                left_out: Vec::new(),
            }),
        })
    }
}

/// How events agree with the exact ones: those that are farther from them than a step are others.
fn found(events: &[Event], exact: &SwitchedMotion, step: f64) -> EventsFound {
    // Of events at one instant there is no order.
    const TOGETHER: f64 = 1e-6;
    let ordered = |events: &[Event]| {
        let mut events = events.to_vec();
        sort_by_number(&mut events, |event| event.time);
        let together = |a: &Event, b: &Event| b.time - a.time <= TOGETHER * step;
        let instants = events.chunk_by_mut(together);
        instants.for_each(|events| events.sort_by_key(|event| event.switch));
        events
    };
    let (all, wanted) = (ordered(events), ordered(exact.events()));
    let both = all.iter().zip(&wanted);
    let same = both.map_while(|(one, other)| {
        let apart = (one.time - other.time).abs();
        let alike = (one.switch, one.kind) == (other.switch, other.kind) && apart <= step;
        alike.then_some(apart)
    });
    let apart: Vec<f64> = same.collect();
    EventsFound {
        expected: exact.events().len(),
        found: events.len(),
        in_order: apart.len(),
        time: apart.into_iter().reduce(f64::max),
    }
}

#[cfg(test)]
mod tests {
    use eigentone_modes::{GROUND, System};
    use eigentone_response::{Response, State};
    use eigentone_switching::Impact;

    use super::*;

    /// A mass hits a wall after π/2 s, and after each π s again.
    #[test]
    fn an_event_of_another_time_is_another() {
        let system = System::builder().mass("m", 1.0).spring(GROUND, "m", 1.0);
        let system = system.build().expect("a system");
        let from = State::at_rest().displace("m", -1.0);
        let ask = Response::of(&system).from(from).every(0.5).until(8.0);
        let problem = ask.problem().expect("a problem");
        let wall = Switch::Impact(Impact {
            between: [GROUND, "m"].map(str::to_owned),
            gap: 0.0,
            restitution: 0.5,
        });
        let exact = Switching::new(&problem, vec![wall]).expect("a switch");
        let exact = exact.run().expect("a motion");
        assert_eq!(exact.events().len(), 3);
        for (late, in_order) in [(0.0, 3), (0.25, 3), (0.75, 1)] {
            let mut events = exact.events().to_vec();
            events[1..].iter_mut().for_each(|event| event.time += late);
            let found = found(&events, &exact, 0.5);
            assert_eq!((found.found, found.in_order), (3, in_order));
            let time = found.time.expect("the first is in order");
            assert!(in_order == 1 || (time - late).abs() < 1e-12);
        }
    }
}
