//! Error against run time, as in the work-precision diagrams of Hairer & Wanner (*Solving Ordinary
//! Differential Equations II*, §IV.10): a line for each method, a point for each setting.

use std::time::{Duration, Instant};

use eigentone_modes::Bounds;
use eigentone_response::{
    Operations, Problem, ResponseError, ResponseMethod, ResponsePlan, Trajectory,
};

use crate::closed_form::OneMass;
use crate::instants::wanted;
use crate::integrator::{
    Dop853, DormandPrince5, GeneralizedAlpha, HhtAlpha, Integrator, Knob, Limit, Newmark, Radau5,
    RungeKutta4, Work,
};
use crate::run_time::RunTime;
use crate::trajectory_error::TrajectoryError;
use crate::truth::MotionTruth;

/// Methods that answered the same problem, each with its error and its run time.
///
/// ```
/// use eigentone_check::{Dop853, Effort, Integrator, Newmark, WorkPrecision};
/// use eigentone_modes::{GROUND, System};
/// use eigentone_response::{Response, State, methods};
///
/// let system = System::builder().mass("m", 1.0).spring(GROUND, "m", 4.0).build()?;
/// let from = State::at_rest().displace("m", 1.0);
/// let problem = Response::of(&system).from(from).every(0.1).until(5.0).problem()?;
/// let integrators: [Box<dyn Integrator>; 2] = [
///     Box::new(Dop853::with_tolerance(1e-9)),
///     Box::new(Newmark::with_substeps(10)),
/// ];
/// let compared = WorkPrecision::measure(
///     &problem,
///     methods(),
///     &integrators,
///     Effort::default(),
///     &mut |_| {},
/// )?;
/// // The last row is Newmark's: no integrator is as accurate as the pick.
/// let pick = compared.pick.as_ref().ok_or("no pick")?.row;
/// assert!(compared.beating(pick).iter().all(|row| *row + 2 < compared.rows.len()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct WorkPrecision {
    /// What the errors are measured from.
    pub reference: &'static str,
    /// How many instants were asked for and compared.
    pub instants: usize,
    /// The time from 0 to the last instant of the grid, in s.
    pub span: f64,
    /// The largest displacement and the largest velocity of the reference at these instants; infinite beyond the largest double.
    pub peaks: [f64; 2],
    /// One row for each method and setting, in the order of the methods given.
    pub rows: Vec<WorkPrecisionRow>,
    /// What the plan picks, if that is among the rows.
    pub pick: Option<Pick>,
}

/// The choice of the plan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pick {
    /// Its row.
    pub row: usize,
    /// Why it is the right one.
    pub reason: String,
    /// The methods that the plan leaves out, and why.
    pub left_out: Vec<(&'static str, String)>,
}

/// One method at one setting.
#[derive(Clone, Debug)]
pub struct WorkPrecisionRow {
    /// The method's name.
    pub method: &'static str,
    /// Its setting; exact methods have none.
    pub knob: Option<Knob>,
    /// What came of it.
    pub outcome: Outcome,
}

/// What came of one method.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// It answered.
    Measured(Measurement),
    /// It does not apply.
    Refused {
        /// Why not.
        reason: String,
    },
    /// It gave up.
    Failed(ResponseError),
    /// It was not tried.
    LeftOut {
        /// Why not.
        reason: String,
    },
}

/// The error of one answer, and what it took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Its distance from the reference; `None` for the reference itself.
    pub error: Option<TrajectoryError>,
    /// Whether its displacements stay within ten times the largest one of the reference; `None` where that exceeds the largest double.
    pub stable: Option<bool>,
    /// What its own bounds are worth.
    pub bounds: Bounds,
    /// With how many decimal digits it was computed.
    pub digits: usize,
    /// How long it takes.
    pub time: RunTime,
    /// What an exact method counted.
    pub operations: Option<Operations>,
    /// What an integrator counted.
    pub work: Option<Work>,
    /// Of a system with switches, how its events agree with the exact ones.
    pub events: Option<EventsFound>,
}

/// The events of a motion beside those of the exact one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EventsFound {
    /// How many there are.
    pub expected: usize,
    /// How many were found.
    pub found: usize,
    /// How many from the first on are the same, of the same switches, in the same order, and not a step apart.
    pub in_order: usize,
    /// The largest error of the time of any of these, in s; `None` if there are none.
    pub time: Option<f64>,
}

/// How much a comparison may cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    /// The most instants compared; of a longer grid, as many are taken, evenly, and the last one.
    pub instants: usize,
    /// The longest that one integration may take.
    pub run: Duration,
    /// After this time no further integration starts.
    pub total: Duration,
}

impl Default for Effort {
    /// 2000 instants, 2 s, 20 s.
    fn default() -> Effort {
        Effort {
            instants: 2000,
            run: Duration::from_secs(2),
            total: Duration::from_secs(20),
        }
    }
}

/// How far a comparison has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Rows finished.
    pub done: usize,
    /// Rows in all.
    pub total: usize,
    /// The method that runs next.
    pub method: &'static str,
    /// Its setting, if it has one.
    pub knob: Option<Knob>,
}

/// The integrators worth comparing, each over its settings, the cheapest first: those
/// of adaptive step at tolerances 1e-6 to 1e-13 (1e-8 where the order is low), the methods of fixed
/// step with 1, 2, 4 … 128 substeps.
pub fn integrators() -> Vec<Box<dyn Integrator>> {
    const TOLERANCES: [f64; 8] = [1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13];
    let substeps = (0..8).map(|power| 1 << power);
    let mut all: Vec<Box<dyn Integrator>> = Vec::new();
    for tolerance in TOLERANCES {
        all.push(Box::new(Dop853::with_tolerance(tolerance)));
    }
    for tolerance in TOLERANCES {
        all.push(Box::new(DormandPrince5::with_tolerance(tolerance)));
    }
    for tolerance in TOLERANCES {
        all.push(Box::new(Radau5::with_tolerance(tolerance)));
    }
    #[cfg(feature = "stiff")]
    for tolerance in TOLERANCES {
        all.push(Box::new(crate::Bdf::with_tolerance(tolerance)));
    }
    #[cfg(feature = "stiff")]
    for tolerance in &TOLERANCES[..3] {
        all.push(Box::new(crate::TrBdf2::with_tolerance(*tolerance)));
    }
    #[cfg(feature = "stiff")]
    for tolerance in &TOLERANCES[..3] {
        all.push(Box::new(crate::Esdirk34::with_tolerance(*tolerance)));
    }
    for count in substeps.clone() {
        all.push(Box::new(RungeKutta4::with_substeps(count)));
    }
    for count in substeps.clone() {
        all.push(Box::new(Newmark::with_substeps(count)));
    }
    for count in substeps.clone() {
        all.push(Box::new(Newmark::central_difference(count)));
    }
    for count in substeps.clone() {
        all.push(Box::new(HhtAlpha::with_substeps(count)));
    }
    for count in substeps {
        all.push(Box::new(GeneralizedAlpha::with_substeps(count)));
    }
    all
}

impl WorkPrecision {
    /// Answers `problem` by every method and compares the answers: the closed form of one mass
    /// where it applies, the `exact` methods, then the `integrators`. Errors are measured from the
    /// [`Reference`](crate::Reference) with more digits, or from the method that the plan picks where that is too expensive. An integrator that is stopped at one
    /// setting is not tried at the settings that follow it. `progress` is reported before each row.
    ///
    /// # Errors
    /// What the reference reports, and [`ResponseError::NotApplicable`] where the plan finds no method;
    /// everything else is an [`Outcome`].
    pub fn measure(
        problem: &Problem<'_>,
        exact: &[&'static dyn ResponseMethod],
        integrators: &[Box<dyn Integrator>],
        effort: Effort,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<WorkPrecision, ResponseError> {
        let started = Instant::now();
        let problem = &thin(problem, effort.instants)?;
        let instants = wanted(problem)?.len();
        let plan = ResponsePlan::of(problem)?;
        let truth = MotionTruth::of(problem)?;
        let mut exact = exact.to_vec();
        if OneMass.refuses(problem).is_none() {
            exact.insert(0, &OneMass);
        }
        let total = exact.len() + integrators.len();
        let mut rows = Vec::with_capacity(total);
        for method in exact {
            progress(Progress {
                done: rows.len(),
                total,
                method: method.name(),
                knob: None,
            });
            let outcome = match method.refuses(problem) {
                Some(reason) => Outcome::Refused { reason },
                None => compare(&truth, || Ok((method.run(problem)?, None))),
            };
            rows.push(WorkPrecisionRow {
                method: method.name(),
                knob: None,
                outcome,
            });
        }
        let mut stopped: Option<(&'static str, Knob)> = None;
        for method in integrators {
            let (name, knob) = (method.name(), method.knob());
            progress(Progress {
                done: rows.len(),
                total,
                method: name,
                knob: Some(knob),
            });
            let left = effort.total.saturating_sub(started.elapsed());
            let limit = Limit {
                steps: u64::MAX,
                time: Some(effort.run.min(left)),
            };
            let left_out = match stopped {
                Some((stopped, knob)) if stopped == name => {
                    Some(format!("it was stopped at {knob} already"))
                }
                _ if left.is_zero() => Some("the time for the comparison is spent".to_owned()),
                _ => None,
            };
            let outcome = match (left_out, method.refuses(problem)) {
                (Some(reason), _) => Outcome::LeftOut { reason },
                (_, Some(reason)) => Outcome::Refused { reason },
                _ => compare(&truth, || {
                    let (trajectory, work) = method.integrate(problem, limit)?;
                    Ok((trajectory, Some(work)))
                }),
            };
            if let Outcome::Failed(ResponseError::Stopped { .. }) = outcome {
                stopped = Some((name, knob));
            }
            rows.push(WorkPrecisionRow {
                method: name,
                knob: Some(knob),
                outcome,
            });
        }
        let pick = rows
            .iter()
            .position(|row| row.method == plan.method.name())
            .map(|row| Pick {
                row,
                reason: plan.reason,
                left_out: plan.left_out,
            });
        Ok(WorkPrecision {
            reference: truth.name(),
            instants,
            span: problem.grid().time(problem.grid().last()),
            peaks: truth.peaks(),
            rows,
            pick,
        })
    }

    /// The rows that beat the given one: as accurate or better, and so much faster that
    /// the middle halves of their run times are apart. Errors are separated down to 2^-53. Empty where the row was not measured, or has no error that
    /// is finite.
    pub fn beating(&self, row: usize) -> Vec<usize> {
        let of = |row: &WorkPrecisionRow| match &row.outcome {
            Outcome::Measured(one) => {
                let error = one.error?.worst().max(f64::EPSILON / 2.0);
                error.is_finite().then_some((error, one.time))
            }
            _ => None,
        };
        let Some((error, time)) = self.rows.get(row).and_then(of) else {
            return Vec::new();
        };
        let beats = |other: &WorkPrecisionRow| {
            of(other)
                .is_some_and(|(off, taken)| off <= error && taken.quartiles[1] < time.quartiles[0])
        };
        let rows = self.rows.iter().enumerate();
        rows.filter(|(_, other)| beats(other))
            .map(|(at, _)| at)
            .collect()
    }

    /// Whether displacements or velocities of the motion itself exceed the largest double, so that no error is a number.
    pub fn exceeds_doubles(&self) -> bool {
        self.peaks.contains(&f64::INFINITY)
    }

    /// Whether velocities at these instants are so small that over the whole time they would not change the largest displacement
    /// in its last digit.
    pub fn is_still(&self) -> bool {
        let [x, v] = self.peaks;
        v > 0.0 && v * self.span < 0.5 * f64::EPSILON * x
    }

    /// The rows that no other beats: the front of error and run time, as the reader of a
    /// work-precision diagram sees it.
    pub fn front(&self) -> Vec<usize> {
        let measured = |row: &usize| matches!(&self.rows[*row].outcome, Outcome::Measured(one) if one.error.is_some_and(|error| error.worst().is_finite()));
        let rows = (0..self.rows.len()).filter(measured);
        rows.filter(|row| self.beating(*row).is_empty()).collect()
    }
}

/// Runs a method and measures it.
fn compare(
    truth: &MotionTruth,
    run: impl Fn() -> Result<(Trajectory, Option<Work>), ResponseError>,
) -> Outcome {
    match RunTime::of(run) {
        Ok(((answer, work), time)) => Outcome::Measured(Measurement {
            error: truth.error_of(&answer),
            stable: truth.is_stable(&answer),
            bounds: answer.bounds(),
            digits: answer.digits(),
            operations: work.is_none().then(|| answer.operations()),
            time,
            work,
            events: None,
        }),
        Err(error) => Outcome::Failed(error),
    }
}

/// The problem at no more than `most` of its instants, its last one among them.
pub(crate) fn thin<'a>(problem: &Problem<'a>, most: usize) -> Result<Problem<'a>, ResponseError> {
    let most = most.max(1) as u128;
    // Even choice of `most` from 0 … last, ends included.
    let pick = |last: u64| {
        let gaps = (most - 1).max(1);
        let first = if most == 1 { 1 } else { 0 };
        (first..=gaps).map(move |i| (u128::from(last) * i / gaps) as u64)
    };
    match problem.instants() {
        None if u128::from(problem.grid().last()) >= most => {
            let chosen: Vec<u64> = pick(problem.grid().last()).collect();
            problem.clone().at(&chosen)
        }
        Some(instants) if instants.len() as u128 > most => {
            let mut sorted = instants.to_vec();
            sorted.sort_unstable();
            let chosen: Vec<u64> = pick(sorted.len() as u64 - 1)
                .map(|position| sorted[position as usize])
                .collect();
            problem.clone().at(&chosen)
        }
        _ => Ok(problem.clone()),
    }
}
