//! Error against run time, as in the work-precision diagrams of Hairer & Wanner (*Solving Ordinary
//! Differential Equations II*, §IV.10): a line for each method, a point for each setting.

use std::time::{Duration, Instant};

use eigentone_response::{Problem, ResponseError, ResponseMethod, Trajectory};
use faer::MatRef;

use crate::closed_form::OneMass;
use crate::integrator::{
    Dop853, DormandPrince5, GeneralizedAlpha, HhtAlpha, Integrator, Knob, Limit, Newmark, Radau5,
    RungeKutta4, Work,
};
use crate::run_time::RunTime;

/// Methods that answered the same problem, each with its error and its run time.
#[derive(Clone, Debug)]
pub struct WorkPrecision {
    /// The method whose answer the errors are measured from.
    pub reference: &'static str,
    /// How many instants were asked for and compared.
    pub instants: usize,
    /// One row for each method and setting, in the order of the methods given.
    pub rows: Vec<WorkPrecisionRow>,
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
    /// How long it takes.
    pub time: RunTime,
    /// What an integrator counted.
    pub work: Option<Work>,
}

/// How far a trajectory lies from a reference: at each instant, the largest difference over the
/// coordinates, relative to the largest value of any coordinate of the reference up to then; over
/// the instants, the largest of these. Instants before the reference moves at all are counted with
/// the first at which it does; if it never does, any difference is infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrajectoryError {
    /// Of the displacements.
    pub displacement: f64,
    /// Of the velocities.
    pub velocity: f64,
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
    /// closed form where it applies, else from `reference`. An integrator that is stopped at one
    /// setting is not tried at the settings that follow it. `progress` is told before each row.
    ///
    /// # Errors
    /// What the reference reports; everything else is an [`Outcome`].
    pub fn measure(
        problem: &Problem<'_>,
        reference: &dyn ResponseMethod,
        exact: &[&dyn ResponseMethod],
        integrators: &[Box<dyn Integrator>],
        effort: Effort,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<WorkPrecision, ResponseError> {
        let started = Instant::now();
        let problem = &thin(problem, effort.instants)?;
        let closed_form = OneMass.refuses(problem).is_none();
        let reference: &dyn ResponseMethod = if closed_form { &OneMass } else { reference };
        let truth = reference.run(problem)?;
        let mut exact = exact.to_vec();
        if closed_form && exact.iter().all(|method| method.name() != OneMass.name()) {
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
            let is_reference = method.name() == reference.name();
            let outcome = match method.refuses(problem) {
                Some(reason) => Outcome::Refused { reason },
                None => outcome((!is_reference).then_some(&truth), || {
                    Ok((method.run(problem)?, None))
                }),
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
                _ => outcome(Some(&truth), || {
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
        Ok(WorkPrecision {
            reference: reference.name(),
            instants: truth.len(),
            rows,
        })
    }
}

/// Runs a method and measures it.
fn outcome(
    truth: Option<&Trajectory>,
    run: impl Fn() -> Result<(Trajectory, Option<Work>), ResponseError>,
) -> Outcome {
    match RunTime::of(run) {
        Ok(((trajectory, work), time)) => Outcome::Measured(Measurement {
            error: truth.map(|truth| TrajectoryError::between(&trajectory, truth)),
            time,
            work,
        }),
        Err(error) => Outcome::Failed(error),
    }
}

impl TrajectoryError {
    /// The distance of `trajectory` from `reference`, which must be of the same problem.
    ///
    /// # Panics
    /// If the two differ in coordinates or instants.
    pub fn between(trajectory: &Trajectory, reference: &Trajectory) -> TrajectoryError {
        assert_eq!(trajectory.steps(), reference.steps(), "the same instants");
        // The running maximum follows time, not the order in which instants were asked for.
        let mut order: Vec<usize> = (0..reference.len()).collect();
        order.sort_by_key(|column| reference.steps()[*column]);
        TrajectoryError {
            displacement: distance(trajectory.displacement(), reference.displacement(), &order),
            velocity: distance(trajectory.velocity(), reference.velocity(), &order),
        }
    }
}

fn distance(values: MatRef<'_, f64>, reference: MatRef<'_, f64>, order: &[usize]) -> f64 {
    assert_eq!(values.nrows(), reference.nrows(), "the same coordinates");
    let (mut largest, mut worst, mut at_rest) = (0.0f64, 0.0f64, 0.0f64);
    for &column in order {
        let mut off = at_rest;
        for i in 0..reference.nrows() {
            let (value, truth) = (values[(i, column)], reference[(i, column)]);
            largest = largest.max(truth.abs());
            let difference = (value - truth).abs();
            off = match difference.is_nan() {
                true => f64::INFINITY,
                false => off.max(difference),
            };
        }
        if largest > 0.0 {
            worst = worst.max(off / largest);
            at_rest = 0.0;
        } else {
            at_rest = off;
        }
    }
    if at_rest > 0.0 { f64::INFINITY } else { worst }
}

/// The problem at no more than `most` of its instants, its last one among them.
fn thin<'a>(problem: &Problem<'a>, most: usize) -> Result<Problem<'a>, ResponseError> {
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
