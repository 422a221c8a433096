//! The methods under study, and how one of them answers one member of a family.

use std::time::{Duration, Instant};

use eigentone_modes::{ModeSolver, Modes, ModesError, Precision, solvers};
use eigentone_response::{
    ByExponential, Problem, ResponseError, ResponseMethod, ResponsePlan, Trajectory,
};

use super::family::{Case, Family};
use super::{Cell, seconds};
use crate::integrator::{
    Dop853, DormandPrince5, GeneralizedAlpha, HhtAlpha, Integrator, Limit, Newmark, Radau5,
    RungeKutta4,
};
use crate::truth::{ModesTruth, MotionTruth};

/// The longest that a cell may take, in s.
const LONGEST: f64 = 2.0;

/// The tolerance of integrators that choose their steps.
const TOLERANCE: f64 = 1e-9;

/// A method with its setting.
pub(super) struct Contender {
    pub(super) name: String,
    pub(super) kind: Kind,
}

/// What a method is.
pub(super) enum Kind {
    /// The motion by what the plan picks.
    Plan(Precision),
    /// The motion by a given exact method in doubles.
    Exact(&'static dyn ResponseMethod),
    /// An integrator of fixed step, with so many steps in a period of the family.
    Fixed {
        order: Order,
        steps: f64,
        make: fn(u32) -> Box<dyn Integrator>,
    },
    /// An integrator that chooses its steps.
    Adaptive {
        explicit: bool,
        make: fn(f64) -> Box<dyn Integrator>,
    },
    /// The modes by what the plan picks.
    PlannedModes(Precision),
    /// The modes by a given solver in doubles.
    Solver(&'static dyn ModeSolver),
}

/// What limits a fixed step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    /// Explicit.
    Explicit,
    /// Implicit and unconditionally stable, of second order.
    Second,
}

impl Contender {
    pub(super) fn is_planned(&self) -> bool {
        matches!(self.kind, Kind::Plan(_) | Kind::PlannedModes(_))
    }

    pub(super) fn is_for_modes(&self) -> bool {
        matches!(self.kind, Kind::PlannedModes(_) | Kind::Solver(_))
    }
}

/// The methods that are tried on a family.
pub(super) fn contenders(family: &Family) -> Vec<Contender> {
    let named = |name: &str, kind| Contender {
        name: name.to_owned(),
        kind,
    };
    let mut all = vec![
        named("plan", Kind::Plan(Precision::default())),
        named("plan, doubles", Kind::Plan(Precision::Double)),
        named(ByExponential.name(), Kind::Exact(&ByExponential)),
    ];
    for (explicit, make) in [
        (
            true,
            (|tolerance| Box::new(Dop853::with_tolerance(tolerance)) as _) as fn(f64) -> _,
        ),
        (true, |tolerance| {
            Box::new(DormandPrince5::with_tolerance(tolerance)) as _
        }),
        (false, |tolerance| {
            Box::new(Radau5::with_tolerance(tolerance)) as _
        }),
    ] {
        let method: Box<dyn Integrator> = make(TOLERANCE);
        let kind = Kind::Adaptive { explicit, make };
        all.push(named(&format!("{}, {TOLERANCE:e}", method.name()), kind));
    }
    for (order, steps, make) in [
        (
            Order::Explicit,
            500.0,
            (|substeps| Box::new(RungeKutta4::with_substeps(substeps)) as _) as fn(u32) -> _,
        ),
        (Order::Explicit, 20_000.0, |substeps| {
            Box::new(Newmark::central_difference(substeps)) as _
        }),
        (Order::Second, 20_000.0, |substeps| {
            Box::new(Newmark::with_substeps(substeps)) as _
        }),
        (Order::Second, 20_000.0, |substeps| {
            Box::new(HhtAlpha::with_substeps(substeps)) as _
        }),
        (Order::Second, 20_000.0, |substeps| {
            Box::new(GeneralizedAlpha::with_substeps(substeps)) as _
        }),
    ] {
        let method: Box<dyn Integrator> = make(1);
        let kind = Kind::Fixed { order, steps, make };
        all.push(named(&format!("{}, T/{steps}", method.name()), kind));
    }
    if family.modes {
        all.push(named("plan", Kind::PlannedModes(Precision::default())));
        all.push(named(
            "plan, doubles",
            Kind::PlannedModes(Precision::Double),
        ));
        let solver = solvers().last().copied().expect("there are solvers");
        all.push(named(solver.name(), Kind::Solver(solver)));
    }
    all
}

/// One member of a family with its true motion and modes.
pub(super) struct Member<'a> {
    family: &'a Family,
    case: Case,
    motion: MotionTruth,
    modes: Option<ModesTruth>,
}

impl Member<'_> {
    pub(super) fn of(family: &Family, value: f64) -> Result<Member<'_>, String> {
        let case = family.case(value).map_err(|error| error.to_string())?;
        let (motion, modes) = case.truth(family.modes)?;
        Ok(Member {
            motion,
            modes,
            family,
            case,
        })
    }

    /// The cell of one method.
    pub(super) fn answer(&self, contender: &Contender) -> Cell {
        let system = &self.case.system;
        let problem = match self.case.problem() {
            Ok(problem) => problem,
            Err(error) => return failed(&error),
        };
        match &contender.kind {
            Kind::Plan(precision) => {
                let problem = problem.to(*precision);
                self.motion(|| ResponsePlan::of(&problem)?.run(&problem))
            }
            Kind::Exact(method) => match method.refuses(&problem) {
                Some(reason) => Cell::Refused { reason },
                None => self.motion(|| method.run(&problem)),
            },
            Kind::Fixed { steps, make, .. } => self.advance(*steps, *make, &problem),
            Kind::Adaptive { make, .. } => self.integrate(&*make(TOLERANCE), &problem),
            Kind::PlannedModes(precision) => self.modes(|| system.modes_to(*precision)),
            Kind::Solver(solver) => match solver.refuses(system) {
                Some(reason) => Cell::Refused { reason },
                None => self.modes(|| solver.solve(system)),
            },
        }
    }

    /// Runs a method of fixed step, unless its steps take too long.
    fn advance(
        &self,
        per_period: f64,
        make: fn(u32) -> Box<dyn Integrator>,
        problem: &Problem<'_>,
    ) -> Cell {
        let longest = self.family.period / per_period;
        let substeps = (problem.grid().step() / longest).ceil().max(1.0);
        let last = problem.grid().last();
        let steps = substeps * last as f64;
        // A few steps show how long one takes.
        let few = trial(problem);
        let tried = substeps.min(few);
        let intervals = ((few / tried) as u64).clamp(1, last);
        let one = problem.clone().at(&[intervals]).and_then(|problem| {
            let method = make(tried as u32);
            let start = Instant::now();
            method.integrate(&problem, Limit::default())?;
            Ok(seconds(start) / (tried * intervals as f64))
        });
        let time = match one {
            Ok(one) => one * steps,
            Err(error) => return self.compare(Err(error), 0.0),
        };
        if time > LONGEST {
            return Cell::NotRun { steps, time };
        }
        self.run(&*make(substeps as u32), problem, steps)
    }

    /// Runs a method that chooses its steps, unless they take too long.
    fn integrate(&self, method: &dyn Integrator, problem: &Problem<'_>) -> Cell {
        if let Some(reason) = method.refuses(problem) {
            return Cell::Refused { reason };
        }
        let few = trial(problem);
        let limit = Limit {
            steps: few as u64,
            time: None,
        };
        let start = Instant::now();
        let answer = method.integrate(problem, limit);
        let taken = seconds(start);
        match answer {
            Err(ResponseError::Stopped { .. }) => {}
            Ok((motion, _)) => return self.compare(Ok(motion), taken),
            Err(error) => return self.compare(Err(error), taken),
        }
        let steps = match method.predict(problem) {
            Ok(prediction) => prediction.steps,
            Err(error) => return self.compare(Err(error), taken),
        };
        let time = taken / few * steps;
        if time > LONGEST {
            return Cell::NotRun { steps, time };
        }
        self.run(method, problem, steps)
    }

    /// Runs an integrator of so many steps for as long as a cell may take.
    fn run(&self, method: &dyn Integrator, problem: &Problem<'_>, steps: f64) -> Cell {
        let limit = Limit {
            steps: u64::MAX,
            time: Some(Duration::from_secs_f64(LONGEST)),
        };
        let start = Instant::now();
        let answer = method.integrate(problem, limit);
        let time = seconds(start);
        match answer {
            Err(ResponseError::Stopped { .. }) if time >= LONGEST => Cell::NotRun { steps, time },
            answer => self.compare(answer.map(|(motion, _)| motion), time),
        }
    }

    fn motion(&self, run: impl FnOnce() -> Result<Trajectory, ResponseError>) -> Cell {
        let start = Instant::now();
        let answer = run();
        self.compare(answer, seconds(start))
    }

    fn compare(&self, answer: Result<Trajectory, ResponseError>, time: f64) -> Cell {
        match answer {
            Ok(motion) if self.motion.is_stable(&motion) == Some(false) => Cell::Unstable,
            Ok(motion) => Cell::Answered {
                // The reference has no error of its own.
                error: self
                    .motion
                    .error_of(&motion)
                    .map_or(0.0, |error| error.displacement),
                time,
            },
            Err(ResponseError::Overflow { .. }) => Cell::Unstable,
            Err(error) => failed(&error),
        }
    }

    fn modes(&self, run: impl FnOnce() -> Result<Modes, ModesError>) -> Cell {
        let start = Instant::now();
        let answer = run();
        let time = seconds(start);
        match (answer, &self.modes) {
            (Ok(modes), Some(truth)) => Cell::Answered {
                error: truth.error_of(&modes).modulus,
                time,
            },
            (Ok(_), None) => Cell::Failed {
                reason: "the true modes are not known".to_owned(),
            },
            (Err(error), _) => Cell::Failed {
                reason: error.to_string(),
            },
        }
    }
}

/// So many steps show how long one takes.
fn trial(problem: &Problem<'_>) -> f64 {
    let n = problem.system().len() as f64;
    (2e7 / (n * n + 1e4)).max(20.0).round()
}

fn failed(error: &ResponseError) -> Cell {
    Cell::Failed {
        reason: error.to_string(),
    }
}
