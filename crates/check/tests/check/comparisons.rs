//! Error against run time.

use std::time::Duration;

use approx::assert_relative_eq;
use eigentone_check::{
    Dop853, Effort, ExponentialComparison, Integrator, Knob, Limit, Measurement, ModeComparison,
    ModeOutcome, Newmark, Outcome, Progress, Reference, RunTime, RungeKutta4, TrajectoryError,
    WorkPrecision, WorkPrecisionRow, integrators,
};
use eigentone_modes::{Bounds, GROUND, System, solvers};
use eigentone_response::{
    ByCertifiedExponential, Problem, Ramp, Response, ResponseError, ResponseMethod, State, Step,
    Trajectory, methods,
};
use faer::{Mat, mat};

use crate::row::in_a_row;
use crate::scenes::{self, FREE};

fn two_masses() -> System {
    in_a_row(&[("a", 2.0), ("b", 1.0)], &[2.0, 0.2], &[0.5, 0.1])
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
    exact: &[&'static dyn ResponseMethod],
    integrators: &[Box<dyn Integrator>],
    effort: Effort,
) -> WorkPrecision {
    WorkPrecision::measure(problem, exact, integrators, effort, &mut |_| {})
        .expect("a plan applies")
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

/// By hand: relative to the largest value of any coordinate at any instant.
#[test]
fn errors_are_relative_to_the_peak() {
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
    // .8 of 8; .5 of 2.
    assert!((error.displacement - 0.1).abs() < 1e-15);
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

/// What is pushed from rest moves little at first. There a Newmark scheme is off by a large part of so little, but
/// by far less of the peak, and that is its error beside either truth.
#[test]
fn a_late_start_is_no_error() {
    let system = in_a_row(&[("m", 1.0)], &[1.0], &[0.1]);
    let ask = Response::of(&system).load("m", Ramp::of(1.0));
    let problem = ask.every(0.2).until(30.0).problem().expect("valid");
    let exact = ByCertifiedExponential.run(&problem).expect("a motion");
    let newmark = Newmark::with_substeps(1);
    let (motion, _) = newmark
        .integrate(&problem, Limit::default())
        .expect("a motion");
    let (x, truth) = (motion.displacement(), exact.displacement());
    let off = (0..x.ncols()).map(|k| (x[(0, k)] - truth[(0, k)]).abs());
    let wanted = off.fold(0.0, f64::max) / truth.norm_max();
    assert!((1e-4..1e-2).contains(&wanted), "{wanted:e}");
    // At the first step it is off by half of what has been so far.
    assert!((x[(0, 1)] / truth[(0, 1)] - 1.0).abs() > 0.4);
    let reference = Reference::default()
        .response(&problem)
        .expect("it is small");
    let measured = reference.error_of(&motion).expect("the same problem");
    assert!((measured.displacement / wanted - 1.0).abs() < 1e-9);
    let between = TrajectoryError::between(&motion, &exact);
    assert!((between.displacement / wanted - 1.0).abs() < 1e-9);
}

/// One mass: the closed form heads the table; everything is measured, the exact methods are exact, and the
/// integrators are as good as their tolerances.
#[test]
fn every_method_meets_the_reference() {
    let scene = &FREE[1];
    let system = scene.system();
    let problem = scene.problem(&system);
    let mut reported = Vec::new();
    let table = WorkPrecision::measure(
        &problem,
        methods(),
        &integrators(),
        Effort::default(),
        &mut |progress: Progress| reported.push(progress),
    )
    .expect("a plan applies");
    assert_eq!((table.reference, table.instants), ("reference", 2000));
    assert_eq!(table.rows[0].method, "closed form");
    for row in &table.rows {
        let measured = measurement(&row.outcome);
        let time = measured.time;
        assert!(0.0 < time.min && time.min <= time.quartiles[0]);
        assert!(time.quartiles[0] <= time.median && time.median <= time.quartiles[1]);
        assert!(time.quartiles[1] <= time.max);
        assert_eq!(measured.work.is_some(), row.knob.is_some());
        assert_eq!(measured.operations.is_some(), row.knob.is_none());
        assert_eq!(measured.stable, Some(true));
        let error = measured.error.expect("the reference is none of them");
        match row.knob {
            Some(Knob::Tolerance(tolerance)) => {
                let times = match (row.method, measured.work) {
                    // Their order is low: the errors of many steps add up.
                    ("BDF" | "TR-BDF2" | "ESDIRK34", Some(work)) => 0.5 * work.accepted as f64,
                    _ => 20.0,
                };
                assert!(error.displacement < times * tolerance.max(1e-12), "{row:?}");
            }
            None => assert!(error.displacement < 1e-13, "{row:?}"),
            _ => {}
        }
    }
    let done: Vec<usize> = reported.iter().map(|progress| progress.done).collect();
    assert_eq!(done, (0..table.rows.len()).collect::<Vec<_>>());
    for (progress, row) in reported.iter().zip(&table.rows) {
        assert_eq!(progress.total, table.rows.len());
        assert_eq!((progress.method, progress.knob), (row.method, row.knob));
    }
}

/// The plan's pick is given with its reason, is right to the last digit, and counts its work; whatever
/// beats it would have to be as accurate.
#[test]
fn the_pick_is_among_the_rows() {
    let system = two_masses();
    let problem = forced(&system, 0.05, 50.0);
    let pairs: [Box<dyn Integrator>; 1] = [Box::new(Dop853::with_tolerance(1e-12))];
    let table = measure(&problem, methods(), &pairs, Effort::default());
    assert_eq!((table.reference, table.instants), ("reference", 1001));
    let pick = table.pick.as_ref().expect("the plan picks one of them");
    let picked = &table.rows[pick.row];
    assert_eq!(picked.method, ByCertifiedExponential.name());
    assert!(!pick.reason.is_empty());
    let own = measurement(&picked.outcome);
    assert!(own.error.expect("measured").worst() <= f64::EPSILON / 2.0);
    assert_eq!(own.bounds, Bounds::Proven);
    let operations = own.operations.expect("an exact method");
    assert_eq!(operations.exponentials, 1);
    assert!(operations.products > 5.0 && operations.steps == 1000);
    // The integrator is never as accurate, and so does not beat it.
    assert!(!table.beating(pick.row).contains(&(table.rows.len() - 1)));
    let front = table.front();
    for row in 0..table.rows.len() {
        assert_eq!(front.contains(&row), table.beating(row).is_empty());
    }
}

/// What beats another is as accurate and faster beyond the spread.
#[test]
fn the_front_is_of_error_and_time() {
    let time = |median: f64, spread: f64| RunTime {
        median,
        quartiles: [median - spread, median + spread],
        min: median - spread,
        max: median + spread,
        runs: 5,
    };
    let row = |error: f64, time: RunTime| WorkPrecisionRow {
        method: "given",
        knob: None,
        outcome: Outcome::Measured(Measurement {
            error: Some(TrajectoryError {
                displacement: error,
                velocity: 0.0,
            }),
            stable: Some(true),
            bounds: Bounds::Estimated,
            digits: 16,
            time,
            operations: None,
            work: None,
            events: None,
        }),
    };
    let table = WorkPrecision {
        reference: "given",
        instants: 1,
        span: 1.0,
        peaks: [1.0; 2],
        rows: vec![
            row(1e-6, time(3.0, 0.1)),
            row(1e-6, time(2.0, 0.1)),
            row(1e-6, time(2.1, 0.1)),
            row(1e-3, time(1.0, 0.1)),
            row(1e-17, time(2.5, 0.1)),
            row(1e-16, time(2.2, 0.1)),
        ],
        pick: None,
    };
    // Both lie below what doubles distinguish: the faster one wins.
    assert_eq!(table.beating(4), [5]);
    assert_eq!(table.beating(0), [1, 2, 4, 5]);
    assert_eq!(table.front(), [1, 2, 3, 5]);
}

/// One mass of 1 kg on a spring of 1 N/m that a negative damper drives beyond the largest double: x grows as e^(t/2).
#[test]
fn what_exceeds_doubles_is_not_called_stable() {
    let system = System::builder().mass("a", 1.0).spring(GROUND, "a", 1.0);
    let system = system.damper(GROUND, "a", -1.0).build().expect("a system");
    let from = State::at_rest().displace("a", 1e300);
    let problem = Response::of(&system).from(from).every(1.0).until(40.0);
    let problem = problem.problem().expect("a problem");
    let table = measure(&problem, &[], &integrators(), Effort::default());
    assert!(table.exceeds_doubles() && !table.is_still());
    assert!(table.front().is_empty());
    for (at, row) in table.rows.iter().enumerate() {
        assert!(table.beating(at).is_empty());
        if let Outcome::Measured(one) = &row.outcome {
            assert_eq!(one.stable, None, "{row:?}");
        }
    }
}

/// What creeps at 1e-100 m/s is still beside 1 m.
#[test]
fn velocities_that_are_as_good_as_0_are_told() {
    let system = System::builder().mass("a", 1.0).damper(GROUND, "a", 1e-3);
    let system = system.build().expect("a system");
    let still = |v: f64| {
        let from = State::at_rest().displace("a", 1.0).push("a", v);
        let problem = Response::of(&system).from(from).every(1.0).until(4.0);
        let problem = problem.problem().expect("a problem");
        let table = measure(&problem, &[], &[], Effort::default());
        assert_eq!(table.peaks[1], v);
        table.is_still()
    };
    let all = [1e-100, 1e-17, 1e-16, 0.0].map(still);
    assert_eq!(all, [true, true, false, false]);
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
    let truth = ByCertifiedExponential.run(&alone).expect("applies");
    let answer = RungeKutta4::with_substeps(1).run(&alone).expect("applies");
    let between = TrajectoryError::between(&answer, &truth);
    assert_relative_eq!(last.displacement, between.displacement, max_relative = 1e-6);
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
        assert_eq!(table.rows.len(), solvers().len() + 1);
        assert_eq!(table.reference, "reference");
        let mut answers = 0;
        for row in &table.rows {
            match &row.outcome {
                ModeOutcome::Measured { error, time, .. } => {
                    answers += 1;
                    let error = error.expect("the reference is none of them");
                    assert!(error.modulus < 1e-10, "{row:?}");
                    assert!(time.min > 0.0);
                }
                ModeOutcome::Refused { .. } => assert_ne!(row.solver, table.pick),
                ModeOutcome::Failed(error) => panic!("{error}"),
            }
        }
        let ModeOutcome::Measured { error, bounds, .. } = &table.rows[0].outcome else {
            panic!("{:?}", table.rows[0]);
        };
        let error = error.expect("measured");
        assert_eq!(*bounds, Bounds::Proven);
        assert!(error.modulus <= f64::EPSILON && error.real_part <= f64::EPSILON);
        assert!(answers >= 1);
    }
}

/// Of a rotation by 100 rad, whose norm determines the squarings: all are right, and count their products.
#[test]
fn exponentials_agree() {
    let system = in_a_row(&[("m", 1.0)], &[1.0], &[]);
    let table = ExponentialComparison::measure(&system, 100.0, &mut |_| {}).expect("it applies");
    assert_eq!((table.order, table.step), (2, 100.0));
    assert_relative_eq!(table.norm, 100.0);
    for row in &table.rows {
        assert!(row.error < 1e-13, "{row:?}");
        // Five squarings of what is below 4.25 at least, and a polynomial.
        assert!((8.0..20.0).contains(&row.products), "{row:?}");
        assert!(row.time.median > 0.0);
    }
}
