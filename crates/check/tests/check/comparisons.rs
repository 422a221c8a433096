//! Error against run time.

use std::time::Duration;

use eigentone_check::{
    Dop853, Effort, Integrator, Knob, Measurement, ModeComparison, ModeOutcome, Outcome, Progress,
    RungeKutta4, TrajectoryError, WorkPrecision, integrators,
};
use eigentone_modes::{GROUND, System, solvers};
use eigentone_response::{
    ByExponential, Problem, Response, ResponseError, ResponseMethod, State, Step, Trajectory,
    methods,
};
use faer::{Mat, mat};

use crate::scenes::{self, FREE};

fn two_masses() -> System {
    System::builder()
        .mass("a", 2.0)
        .mass("b", 1.0)
        .spring(GROUND, "a", 2.0)
        .spring("a", "b", 0.2)
        .damper(GROUND, "a", 0.5)
        .damper("a", "b", 0.1)
        .build()
        .expect("valid")
}

fn forced(system: &System, step: f64, end: f64) -> Problem<'_> {
    Response::of(system)
        .from(State::at_rest().displace("a", 1.0))
        .load("b", Step::of(1.0))
        .every(step)
        .until(end)
        .problem()
        .expect("valid")
}

fn measure(
    problem: &Problem<'_>,
    exact: &[&dyn ResponseMethod],
    integrators: &[Box<dyn Integrator>],
    effort: Effort,
) -> WorkPrecision {
    WorkPrecision::measure(
        problem,
        &ByExponential,
        exact,
        integrators,
        effort,
        &mut |_| {},
    )
    .expect("the reference applies")
}

fn measurement(outcome: &Outcome) -> Measurement {
    match outcome {
        Outcome::Measured(measurement) => *measurement,
        other => panic!("{other:?}"),
    }
}

fn trajectory(steps: &[u64], displacement: Mat<f64>, velocity: Mat<f64>) -> Trajectory {
    let times = steps.iter().map(|step| *step as f64).collect();
    Trajectory::new("given", steps.to_vec(), times, displacement, velocity)
}

/// By hand: relative to the largest value of any coordinate up to the same instant, in the order of
/// time.
#[test]
fn errors_are_relative_to_the_largest_so_far() {
    let reference = trajectory(
        &[0, 2, 1],
        mat![[1.0, -8.0, 0.0], [0.0, 0.5, 4.0]],
        mat![[0.0, 1.0, 2.0], [0.0, 0.0, 0.0]],
    );
    let answer = trajectory(
        &[0, 2, 1],
        mat![[1.0, -8.4, 0.0], [0.1, 0.5, 4.8]],
        mat![[0.0, 1.0, 2.0], [0.0, 0.5, 0.0]],
    );
    let error = TrajectoryError::between(&answer, &reference);
    // .1 of 1, .8 of 4, .4 of 8; then .5 of 2.
    assert!((error.displacement - 0.2).abs() < 1e-15);
    assert!((error.velocity - 0.25).abs() < 1e-15);
    let none = TrajectoryError::between(&reference, &reference);
    assert_eq!((none.displacement, none.velocity), (0.0, 0.0));
    let at_rest = trajectory(&[0], mat![[0.0]], mat![[0.0]]);
    let moving = trajectory(&[0], mat![[1e-300]], mat![[f64::NAN]]);
    let error = TrajectoryError::between(&moving, &at_rest);
    assert_eq!(
        (error.displacement, error.velocity),
        (f64::INFINITY, f64::INFINITY)
    );
}

/// One mass: the closed form is the reference and heads the table; everything is measured, the
/// exact methods are exact, and the integrators are as good as their tolerances.
#[test]
fn compares_with_the_closed_form() {
    let scene = &FREE[1];
    let system = scene.system();
    let problem = scene.problem(&system);
    let mut told = Vec::new();
    let table = WorkPrecision::measure(
        &problem,
        &ByExponential,
        methods(),
        &integrators(),
        Effort::default(),
        &mut |progress: Progress| told.push(progress),
    )
    .expect("the closed form applies");
    assert_eq!((table.reference, table.instants), ("closed form", 2000));
    let first = &table.rows[0];
    assert_eq!(first.method, "closed form");
    assert_eq!(measurement(&first.outcome).error, None);
    for row in &table.rows {
        let Measurement { error, time, work } = measurement(&row.outcome);
        assert!(0.0 < time.min && time.min <= time.median && time.median <= time.max);
        assert_eq!(work.is_some(), row.knob.is_some());
        match (row.knob, error) {
            (Some(Knob::Tolerance(tolerance)), Some(error)) => {
                // The errors of steps add up where an order is low and they are many.
                let times = match row.method {
                    "BDF" | "TR-BDF2" | "ESDIRK34" => 0.5 * work.expect("counted").accepted as f64,
                    _ => 20.0,
                };
                assert!(error.displacement < times * tolerance, "{row:?}");
            }
            (None, Some(error)) => assert!(error.displacement < 1e-13, "{row:?}"),
            _ => {}
        }
    }
    let done: Vec<usize> = told.iter().map(|progress| progress.done).collect();
    assert_eq!(done, (0..table.rows.len()).collect::<Vec<_>>());
    for (progress, row) in told.iter().zip(&table.rows) {
        assert_eq!(progress.total, table.rows.len());
        assert_eq!((progress.method, progress.knob), (row.method, row.knob));
    }
}

/// Several masses: the caller's method is the reference, and has no error of its own.
#[test]
fn compares_with_the_method_given() {
    let system = two_masses();
    let problem = forced(&system, 0.05, 50.0);
    let pairs: [Box<dyn Integrator>; 1] = [Box::new(Dop853::with_tolerance(1e-12))];
    let table = measure(&problem, methods(), &pairs, Effort::default());
    assert_eq!(table.reference, ByExponential.name());
    assert_eq!(table.instants, 1001);
    for row in &table.rows {
        match &row.outcome {
            Outcome::Measured(measured) if row.method == ByExponential.name() => {
                assert_eq!(measured.error, None);
            }
            Outcome::Measured(measured) => {
                let error = measured.error.expect("not the reference");
                assert!(
                    error.displacement < 1e-11 && error.velocity < 1e-11,
                    "{row:?}"
                );
            }
            other => assert!(matches!(other, Outcome::Refused { .. }), "{other:?}"),
        }
    }
}

/// Of a long grid only some instants are compared: first and last among them.
#[test]
fn thins_a_long_grid() {
    let system = two_masses();
    let problem = forced(&system, 0.01, 50.0);
    let effort = |instants| Effort {
        instants,
        ..Effort::default()
    };
    let one: [Box<dyn Integrator>; 1] = [Box::new(RungeKutta4::with_substeps(1))];
    let error = |instants| {
        let table = measure(&problem, &[], &one, effort(instants));
        assert_eq!(table.instants, instants);
        measurement(&table.rows[0].outcome)
            .error
            .expect("not the reference")
    };
    // The same steps are taken, so errors at fewer instants are among those at more.
    let [all, some, last] = [5001, 501, 1].map(error);
    assert!(all.displacement >= some.displacement && some.displacement > 0.0);
    let alone = problem.clone().at(&[5000]).expect("in range");
    let truth = ByExponential.run(&alone).expect("applies");
    let answer = RungeKutta4::with_substeps(1).run(&alone).expect("applies");
    assert_eq!(last, TrajectoryError::between(&answer, &truth));
}

/// A stiff system stops the explicit pair at its loosest tolerance, and the others are left out;
/// what needs a mass everywhere refuses a massless node; the table is made nevertheless.
#[test]
fn goes_on_after_failures() {
    let stiff = scenes::system(1.0, 1e13, 1.0);
    let problem = Response::of(&stiff)
        .from(State::at_rest().displace("m1", 1.0))
        .every(1.0)
        .until(10.0)
        .problem()
        .expect("valid");
    let effort = Effort {
        run: Duration::from_millis(300),
        ..Effort::default()
    };
    let table = measure(&problem, &[], &integrators(), effort);
    let outcomes = |name: &str| -> Vec<&Outcome> {
        let rows = table.rows.iter().filter(|row| row.method == name);
        rows.map(|row| &row.outcome).collect()
    };
    let eighth = outcomes("DOP853");
    assert!(matches!(
        eighth[0],
        Outcome::Failed(ResponseError::Stopped { .. })
    ));
    for outcome in &eighth[1..] {
        assert!(
            matches!(outcome, Outcome::LeftOut { reason } if reason.contains("tolerance 1e-6")),
            "{outcome:?}"
        );
    }
    // Implicit: no step is too long for it.
    for outcome in outcomes("Newmark") {
        measurement(outcome);
    }

    let massless = System::builder()
        .mass("a", 1.0)
        .mass("b", 0.0)
        .spring(GROUND, "a", 1.0)
        .spring("a", "b", 1.0)
        .damper("b", GROUND, 1.0)
        .build()
        .expect("valid");
    let table = measure(
        &forced(&massless, 0.1, 5.0),
        methods(),
        &integrators(),
        effort,
    );
    for row in table.rows.iter().filter(|row| row.knob.is_some()) {
        assert!(matches!(row.outcome, Outcome::Refused { .. }), "{row:?}");
    }
    let nothing = Effort {
        total: Duration::ZERO,
        ..Effort::default()
    };
    let plain = two_masses();
    let table = measure(&forced(&plain, 0.1, 5.0), &[], &integrators(), nothing);
    for row in table.rows {
        assert!(matches!(row.outcome, Outcome::LeftOut { .. }), "{row:?}");
    }
}

#[test]
fn mode_solvers_agree() {
    let chain = System::builder()
        .mass("a", 1.0)
        .mass("b", 2.0)
        .mass("c", 3.0)
        .spring("a", "b", 1e3)
        .spring("b", "c", 2.0);
    for grounded in [false, true] {
        let system = match grounded {
            true => chain
                .clone()
                .spring(GROUND, "a", 5.0)
                .damper("c", GROUND, 0.3),
            false => chain.clone(),
        };
        let system = system.build().expect("valid");
        let table = ModeComparison::measure(&system, &mut |_| {}).expect("has modes");
        assert_eq!(table.rows.len(), solvers().len());
        let mut answers = 0;
        for row in &table.rows {
            match &row.outcome {
                ModeOutcome::Measured { distance, time } => {
                    answers += 1;
                    assert_eq!(distance.is_none(), row.solver == table.reference);
                    assert!(distance.unwrap_or(0.0) < 1e-10, "{row:?}");
                    assert!(time.min > 0.0);
                }
                ModeOutcome::Refused { .. } => assert_ne!(row.solver, table.reference),
                ModeOutcome::Failed(error) => panic!("{error}"),
            }
        }
        assert!(answers >= 1);
    }
}
