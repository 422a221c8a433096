//! The numerical integrators: `convergence` observes their order, `damping` what their documentation
//! says of numerical damping and stability, `stiffness` what becomes of motions that die down fast,
//! `prediction` what they predict before they run, `diffsol` the methods of that crate.

mod convergence;
mod damping;
#[cfg(feature = "stiff")]
mod diffsol;
mod prediction;
mod stiffness;

use std::time::Duration;

use eigentone_check::{
    Dop853, DormandPrince5, GeneralizedAlpha, HhtAlpha, Integrator, Knob, Limit, Newmark, OneMass,
    Radau5, RungeKutta4, TrajectoryError,
};
use eigentone_modes::{GROUND, MatrixKind, System};
use eigentone_response::{
    ByExponential, Harmonic, Hold, Impulse, Problem, Ramp, Response, ResponseError, ResponseMethod,
    Samples, State, Step, Trajectory,
};
use faer::mat;
use proptest::prelude::*;

use crate::scenes::{self, FREE, RESONANCE};

fn error(answer: &Trajectory, truth: &Trajectory) -> f64 {
    let error = TrajectoryError::between(answer, truth);
    error.displacement.max(error.velocity)
}

fn run(method: &dyn ResponseMethod, problem: &Problem<'_>) -> Trajectory {
    method.run(problem).expect("applies")
}

/// One of each.
fn all() -> Vec<Box<dyn Integrator>> {
    let all: Vec<Box<dyn Integrator>> = vec![
        Box::new(Dop853::with_tolerance(1e-9)),
        Box::new(DormandPrince5::with_tolerance(1e-9)),
        Box::new(Radau5::with_tolerance(1e-9)),
        Box::new(RungeKutta4::with_substeps(8)),
        Box::new(Newmark::with_substeps(8)),
        Box::new(Newmark::central_difference(8)),
        Box::new(HhtAlpha::with_substeps(8)),
        Box::new(GeneralizedAlpha::with_substeps(8)),
    ];
    #[cfg(feature = "stiff")]
    let all = {
        use eigentone_check::{Bdf, Esdirk34, TrBdf2};
        let mut all = all;
        all.push(Box::new(Bdf::with_tolerance(1e-9)));
        all.push(Box::new(TrBdf2::with_tolerance(1e-6)));
        all.push(Box::new(Esdirk34::with_tolerance(1e-6)));
        all
    };
    all
}

/// Halving the step divides the error by 2^order. The step load sets in between two instants, so
/// that the order is lost if the method does not restart there.
#[test]
fn fixed_steps_have_their_order() {
    let system = scenes::system(1.0, 0.4, 4.0);
    let response = Response::of(&system)
        .from(State::at_rest().displace("m1", 1.0))
        .load("m1", Step::of(3.0).starting_at(2.03))
        .every(0.1)
        .until(10.0);
    let problem = response.problem().expect("valid");
    let truth = run(&OneMass, &problem);
    let order = |method: &dyn Fn(u32) -> Box<dyn Integrator>, substeps: u32| {
        let error = |substeps| error(&run(&*method(substeps), &problem), &truth);
        (error(substeps) / error(2 * substeps)).log2()
    };
    for substeps in [1, 2, 4, 8] {
        let runge_kutta = order(
            &|count| Box::new(RungeKutta4::with_substeps(count)),
            substeps,
        );
        assert!((runge_kutta - 4.0).abs() < 0.1, "{runge_kutta}");
        let newmark = order(&|count| Box::new(Newmark::with_substeps(count)), substeps);
        assert!((newmark - 2.0).abs() < 0.1, "{newmark}");
    }
}

/// Errors follow the tolerance over 9 decades: they come to the tolerance of each step times the
/// steps of 6 oscillations, no more. Nearly all instants lie between two steps.
#[test]
fn errors_follow_the_tolerance() {
    for scene in &FREE {
        let system = scene.system();
        let problem = scene.problem(&system);
        let truth = run(&OneMass, &problem);
        for power in 4..=12 {
            let tolerance = 10f64.powi(-power);
            let eighth = error(&run(&Dop853 { tolerance }, &problem), &truth);
            let fifth = error(&run(&DormandPrince5 { tolerance }, &problem), &truth);
            let implicit = error(&run(&Radau5 { tolerance }, &problem), &truth);
            for error in [eighth, fifth, implicit] {
                let times = error / tolerance;
                assert!(
                    (1e-4..20.0).contains(&times),
                    "{} {tolerance:e}: {times}",
                    scene.title
                );
            }
        }
    }
}

/// DOP853 at 1e-13 reaches the truths to 5e-12 of the largest value so far.
#[test]
fn dop853_reaches_the_truth() {
    for scene in FREE.iter().chain([&RESONANCE]) {
        let system = scene.system();
        let problem = scene.problem(&system);
        let answer = run(&Dop853::with_tolerance(1e-13), &problem);
        let (mut largest, mut fastest) = (0.0f64, 0.0f64);
        let mut column = 0;
        for truth in scene.truth() {
            while column <= truth.step as usize {
                largest = largest.max(answer.displacement()[(0, column)].abs());
                fastest = fastest.max(answer.velocity()[(0, column)].abs());
                column += 1;
            }
            let at = truth.step as usize;
            let off = (answer.displacement()[(0, at)] - truth.displacement).abs() / largest;
            let off_velocity = (answer.velocity()[(0, at)] - truth.velocity).abs() / fastest;
            assert!(off < 5e-12, "{} {}: {off:e}", scene.title, truth.step);
            assert!(
                off_velocity < 5e-12,
                "{} {}: {off_velocity:e}",
                scene.title,
                truth.step
            );
        }
    }
}

fn chain() -> System {
    System::builder()
        .mass("a", 2.0)
        .mass("b", 0.5)
        .mass("c", 1.0)
        .spring(GROUND, "a", 3.0)
        .spring("a", "b", 7.0)
        .spring("b", "c", 1.0)
        .damper("a", "b", 0.2)
        .damper("c", GROUND, 0.1)
        .build()
        .expect("valid")
}

/// Every kind of load, on the grid and off it.
fn loaded(system: &System) -> Response<'_> {
    let samples = |step, hold| Samples {
        step,
        values: vec![0.5, -1.0, 2.0, 0.0, 1.0],
        hold,
    };
    Response::of(system)
        .from(State::at_rest().displace("b", 0.3).push("c", -1.0))
        .load("a", Step::of(1.0).starting_at(-1.0))
        .load("a", Step::of(-2.0).starting_at(1.23))
        .load("b", Ramp::of(0.3).starting_at(2.0))
        .load("b", Impulse::of(0.4).at(3.0))
        .load("c", Impulse::of(-0.7).at(3.71))
        .load("c", Harmonic::of(0.8, 2.1).with_phase(0.4))
        .load("a", samples(0.5, Hold::Zero))
        .load("c", samples(0.125, Hold::First))
        .every(0.25)
        .until(8.0)
}

/// Against the exact response by the exponential, which shares no code with them.
#[test]
fn take_every_load() {
    let system = chain();
    let problem = loaded(&system).problem().expect("valid");
    let truth = run(&ByExponential, &problem);
    for tolerance in [1e-7, 1e-9, 1e-11] {
        let eighth = error(&run(&Dop853 { tolerance }, &problem), &truth);
        let fifth = error(&run(&DormandPrince5 { tolerance }, &problem), &truth);
        let implicit = error(&run(&Radau5 { tolerance }, &problem), &truth);
        assert!(implicit < 20.0 * tolerance, "{tolerance:e}: {implicit:e}");
        assert!(eighth < 20.0 * tolerance, "{tolerance:e}: {eighth:e}");
        assert!(fifth < 20.0 * tolerance, "{tolerance:e}: {fifth:e}");
    }
    let of_order = |order: i32, error: [f64; 2]| {
        let observed = (error[0] / error[1]).log2();
        assert!((observed - f64::from(order)).abs() < 0.1, "{observed}");
    };
    let counts = [32, 64];
    let off = |method: &dyn ResponseMethod| error(&run(method, &problem), &truth);
    of_order(
        4,
        counts.map(|count| off(&RungeKutta4::with_substeps(count))),
    );
    let of_order_2: [fn(u32) -> Box<dyn Integrator>; 4] = [
        |count| Box::new(Newmark::with_substeps(count)),
        |count| Box::new(Newmark::central_difference(count)),
        |count| Box::new(HhtAlpha::with_substeps(count)),
        |count| Box::new(GeneralizedAlpha::with_substeps(count)),
    ];
    for method in of_order_2 {
        of_order(2, counts.map(|count| off(&*method(count))));
    }
}

/// With a mass matrix that is not diagonal.
#[test]
fn take_any_mass_matrix() {
    let system = System::builder()
        .matrix(MatrixKind::Mass, mat![[2.0, 0.5], [0.5, 1.0]].as_ref())
        .matrix(MatrixKind::Damping, mat![[0.1, 0.0], [0.0, 0.3]].as_ref())
        .matrix(
            MatrixKind::Stiffness,
            mat![[5.0, -2.0], [-2.0, 4.0]].as_ref(),
        )
        .build()
        .expect("valid");
    let problem = Response::of(&system)
        .from(State::at_rest().displace("x1", 1.0))
        .load("x2", Impulse::of(1.0).at(1.5))
        .load("x1", Step::of(1.0))
        .every(0.5)
        .until(10.0)
        .problem()
        .expect("valid");
    let truth = run(&ByExponential, &problem);
    let off = error(&run(&Dop853::with_tolerance(1e-12), &problem), &truth);
    assert!(off < 2e-11, "{off:e}");
}

/// Instants come in any order and any number, and each is what it is among all of them.
#[test]
fn answer_at_any_instants() {
    let system = chain();
    let problem = loaded(&system).problem().expect("valid");
    let chosen = [32, 5, 12, 5, 0, 31];
    for method in all() {
        let whole = run(&*method, &problem);
        let few = run(&*method, &problem.clone().at(&chosen).expect("in range"));
        assert_eq!(few.steps(), chosen);
        for (column, index) in chosen.iter().enumerate() {
            let at = *index as usize;
            assert_eq!(few.displacement().col(column), whole.displacement().col(at));
            assert_eq!(few.velocity().col(column), whole.velocity().col(at));
        }
        let none = run(&*method, &problem.clone().at(&[]).expect("in range"));
        assert_eq!(none.len(), 0);
    }
}

/// M x″ + C x′ + K x = f at every instant, those of an impulse or a step among them.
#[test]
fn accelerations_obey_newton() {
    let system = chain();
    let problem = loaded(&system)
        .with_acceleration()
        .problem()
        .expect("valid");
    let (m, c, k) = (
        system.mass_matrix(),
        system.damping_matrix(),
        system.stiffness_matrix(),
    );
    let timeline = problem.timeline();
    for method in all() {
        let answer = run(&*method, &problem);
        let acceleration = answer.acceleration().expect("asked for");
        let pull = &m * acceleration + &c * answer.velocity() + &k * answer.displacement();
        for (column, t) in answer.times().iter().enumerate() {
            let running = timeline
                .pieces()
                .iter()
                .rposition(|piece| piece.start() <= *t);
            let mut force = [0.0; 3];
            let running = running.expect("the first begins at 0");
            problem.forces(running, *t, 0, |i, value| force[i] += value);
            for i in 0..3 {
                let rest = pull[(i, column)] - force[i];
                assert!(rest.abs() < 1e-13, "{} at {t}: {rest:e}", method.name());
            }
        }
    }
}

/// Nothing depends on units: lengths, times and masses in powers of two give the same digits.
#[test]
fn units_do_not_matter() {
    let answer = |method: &dyn Integrator, length: f64, time: f64, mass: f64| {
        let system = System::builder()
            .mass("a", 3.0 * mass)
            .mass("b", 0.7 * mass)
            .spring(GROUND, "a", 5.0 * mass / time / time)
            .spring("a", "b", 1.3 * mass / time / time)
            .damper("b", GROUND, 0.2 * mass / time)
            .build()
            .expect("valid");
        let force = mass * length / time / time;
        let problem = Response::of(&system)
            .load("a", Step::of(force))
            .load("b", Impulse::of(force * time).at(1.7 * time))
            .every(0.3 * time)
            .until(20.0 * time)
            .problem()
            .expect("valid");
        let answer = run(method, &problem);
        (
            answer.displacement() / length,
            answer.velocity() / (length / time),
        )
    };
    for method in all() {
        let plain = answer(&*method, 1.0, 1.0, 1.0);
        let [length, time, mass] = [-30, 40, -20].map(|power| 2f64.powi(power));
        assert!(
            answer(&*method, length, time, mass) == plain,
            "{}",
            method.name()
        );
    }
}

#[test]
fn count_their_work() {
    let system = scenes::system(1.0, 0.0, 1.0);
    let response = Response::of(&system).from(State::at_rest().displace("m1", 1.0));
    let problem = response.every(0.5).until(10.0).problem().expect("valid");
    let work = |method: &dyn Integrator| {
        method
            .integrate(&problem, Limit::default())
            .expect("applies")
            .1
    };
    let runge_kutta = work(&RungeKutta4::with_substeps(3));
    assert_eq!((runge_kutta.accepted, runge_kutta.evaluations), (60, 240));
    assert_eq!((runge_kutta.factorisations, runge_kutta.solves), (0, 0));
    // At the start the acceleration is evaluated once, and its slope is solved for where it stands
    // for another instant.
    for (method, more) in [
        (&Newmark::with_substeps(3) as &dyn Integrator, 0),
        (&HhtAlpha::with_substeps(3), 1),
        (&GeneralizedAlpha::with_substeps(3), 1),
    ] {
        let work = work(method);
        assert_eq!((work.accepted, work.evaluations), (60, 61 + more));
        assert_eq!((work.factorisations, work.solves), (1, 60 + more));
    }
    let radau = work(&Radau5::with_tolerance(1e-8));
    let tried = radau.accepted + radau.rejected;
    assert!((4 * tried..4 * tried + 10).contains(&radau.evaluations));
    assert!((3 * tried..3 * tried + 10).contains(&radau.solves));
    assert!(radau.factorisations % 2 == 0 && radau.factorisations < tried);
    // With a relative error of h⁹ in a step, a thousandth of the tolerance makes h 1000^(1/8)
    // times smaller; with h⁶ in the other pair, 1000^(1/5) times.
    let steps = |method: &dyn Integrator| work(method).accepted as f64;
    let eighth = [1e-9, 1e-12].map(|tolerance| steps(&Dop853 { tolerance }));
    let off = (eighth[1] / eighth[0] - 1000f64.powf(1.0 / 8.0)).abs();
    assert!(off < 0.2, "{eighth:?}");
    let fifth = [1e-9, 1e-12].map(|tolerance| steps(&DormandPrince5 { tolerance }));
    let off = (fifth[1] / fifth[0] - 1000f64.powf(1.0 / 5.0)).abs();
    assert!(off < 0.2, "{fifth:?}");
}

#[test]
fn stop_where_the_limit_is() {
    // 1.6e7 oscillations a second.
    let system = scenes::system(1.0, 0.0, 1e16);
    let response = Response::of(&system).from(State::at_rest().displace("m1", 1.0));
    let problem = response.every(1.0).until(100.0).problem().expect("valid");
    let stopped = |method: &dyn Integrator, limit| match method.integrate(&problem, limit) {
        Err(ResponseError::Stopped { reason, .. }) => reason,
        other => panic!("{other:?}"),
    };
    let few = Limit {
        steps: 1000,
        time: None,
    };
    let short = Limit {
        steps: u64::MAX,
        time: Some(Duration::from_millis(5)),
    };
    for tolerance in [1e-3, 1e-12] {
        assert!(stopped(&Dop853 { tolerance }, few).contains("steps, 1000"));
        assert!(stopped(&DormandPrince5 { tolerance }, few).contains("steps, 1000"));
        assert!(stopped(&Dop853 { tolerance }, short).contains("0.0 s"));
    }
    let many = RungeKutta4::with_substeps(1_000_000);
    assert!(stopped(&many, few).contains("needs 100000000 steps"));
    assert!(stopped(&many, short).contains("0.0 s"));
}

#[test]
fn refuse_what_they_cannot_do() {
    let refused = |method: &dyn Integrator, system: &System| {
        let problem = Response::of(system)
            .every(0.5)
            .until(1.0)
            .problem()
            .expect("valid");
        let reason = method.refuses(&problem).expect("refuses");
        let error = method.run(&problem).expect_err("refuses");
        assert!(
            matches!(error, ResponseError::NotApplicable { .. }),
            "{error}"
        );
        reason
    };
    let massless = System::builder()
        .mass("a", 1.0)
        .mass("between", 0.0)
        .spring(GROUND, "a", 1.0)
        .spring("a", "between", 1.0)
        .damper("between", GROUND, 1.0)
        .build()
        .expect("valid");
    let singular = System::builder()
        .matrix(MatrixKind::Mass, mat![[1.0, 1.0], [1.0, 1.0]].as_ref())
        .matrix(MatrixKind::Stiffness, mat![[1.0, 0.0], [0.0, 1.0]].as_ref())
        .build()
        .expect("valid");
    for method in all() {
        assert!(refused(&*method, &massless).contains("\"between\" has no mass"));
        assert!(refused(&*method, &singular).contains("singular"));
    }
    let plain = scenes::system(1.0, 0.0, 1.0);
    for tolerance in [0.0, -1e-6, f64::NAN, 1e-16, 2.0] {
        assert!(refused(&Dop853 { tolerance }, &plain).contains("tolerance"));
        assert!(refused(&DormandPrince5 { tolerance }, &plain).contains("tolerance"));
        assert!(refused(&Radau5 { tolerance }, &plain).contains("tolerance"));
    }
    assert!(refused(&RungeKutta4 { substeps: 0 }, &plain).contains("at least 1"));
    assert!(refused(&Newmark::with_substeps(0), &plain).contains("at least 1"));
    let newmark = Newmark {
        gamma: f64::NAN,
        ..Newmark::with_substeps(1)
    };
    assert!(refused(&newmark, &plain).contains("its γ is NaN"));
    for alpha in [0.1, -0.4, f64::NAN] {
        let substeps = 1;
        assert!(refused(&HhtAlpha { substeps, alpha }, &plain).contains("-1/3 and 0"));
    }
    for spectral_radius in [-0.1, 1.1, f64::NAN] {
        let method = GeneralizedAlpha {
            substeps: 1,
            spectral_radius,
        };
        assert!(refused(&method, &plain).contains("between 0 and 1"));
    }
    assert_eq!(Knob::Substeps(2).to_string(), "2 substeps");
    assert_eq!(Knob::Tolerance(1e-6).to_string(), "tolerance 1e-6");
}

#[test]
fn report_a_motion_beyond_doubles() {
    // It grows by e^100 in each second.
    let system = scenes::system(1.0, -100.0, 1.0);
    let response = Response::of(&system).from(State::at_rest().displace("m1", 1.0));
    let problem = response.every(1.0).until(10.0).problem().expect("valid");
    for method in [
        &RungeKutta4::with_substeps(1000) as &dyn ResponseMethod,
        &Newmark::with_substeps(1000),
    ] {
        let error = method.run(&problem).expect_err("leaves the doubles");
        assert!(
            matches!(error, ResponseError::Overflow { index: 8 }),
            "{error}"
        );
    }
    assert!(Dop853::with_tolerance(1e-6).run(&problem).is_err());
    assert!(Radau5::with_tolerance(1e-6).run(&problem).is_err());
}

proptest! {
    /// Between their steps as on them: landing on more instants changes nothing by more than the
    /// tolerance does.
    #[test]
    fn instants_between_steps_are_as_good(
        damping in 0.0..10.0f64, start in 0.0..3.0f64, power in 5i32..12,
    ) {
        let system = scenes::system(1.0, damping, 4.0);
        let problem = Response::of(&system)
            .from(State::at_rest().displace("m1", 1.0))
            .load("m1", Step::of(2.0).starting_at(start))
            .every(0.01)
            .until(5.0)
            .problem()
            .expect("valid");
        let truth = run(&OneMass, &problem);
        let tolerance = 10f64.powi(-power);
        let eighth = error(&run(&Dop853 { tolerance }, &problem), &truth) / tolerance;
        let fifth = error(&run(&DormandPrince5 { tolerance }, &problem), &truth) / tolerance;
        let implicit = error(&run(&Radau5 { tolerance }, &problem), &truth) / tolerance;
        let all = [eighth, fifth, implicit];
        prop_assert!(all.iter().all(|times| *times < 20.0), "{:?}", all);
    }
}
