//! Steps predicted before they are taken.

use eigentone_check::{
    Basis, Dop853, DormandPrince5, GeneralizedAlpha, HhtAlpha, Integrator, Limit, Newmark,
    Prediction, Radau5, RungeKutta4,
};
use eigentone_modes::System;
use eigentone_response::{Harmonic, Problem, Response, ResponseError, State, Step};

use super::{chain, loaded};
use crate::row::in_a_row;
use crate::scenes;

fn predicted(method: &dyn Integrator, problem: &Problem<'_>) -> Prediction {
    method.predict(problem).expect("applies")
}

fn taken(method: &dyn Integrator, problem: &Problem<'_>) -> f64 {
    let (_, work) = method
        .integrate(problem, Limit::default())
        .expect("applies");
    (work.accepted + work.rejected) as f64
}

fn counts(method: &dyn Integrator, problem: &Problem<'_>) -> bool {
    let steps = taken(method, problem);
    let basis = Basis::Counted;
    predicted(method, problem) == Prediction { steps, basis }
}

/// Events off the grid and on it, and any instants asked for.
#[test]
fn fixed_steps_are_counted() {
    let system = chain();
    let problem = loaded(&system).problem().expect("valid");
    let some = problem.clone().at(&[7, 3]).expect("in range");
    let none = problem.clone().at(&[]).expect("in range");
    for substeps in [1, 3, 10] {
        for method in [
            Box::new(RungeKutta4::with_substeps(substeps)) as Box<dyn Integrator>,
            Box::new(Newmark::central_difference(substeps)),
            Box::new(HhtAlpha::with_substeps(substeps)),
            Box::new(GeneralizedAlpha::with_substeps(substeps)),
        ] {
            for problem in [&problem, &some, &none] {
                assert!(counts(&*method, problem));
            }
        }
    }
    let endless = Response::of(&system).every(1e-12).until(1e3).problem();
    let steps = predicted(&RungeKutta4::with_substeps(7), &endless.expect("valid")).steps;
    assert!((steps / 7e15 - 1.0).abs() < 1e-12);
}

fn driven(system: &System, end: f64) -> Problem<'_> {
    let response = Response::of(system)
        .from(State::at_rest().displace("a", 1.0))
        .load("c", Harmonic::of(1.0, 3.0))
        .load("a", Step::of(1.0).starting_at(0.3 * end));
    response.every(0.1).until(end).problem().expect("valid")
}

/// A motion that goes on as it began, and one that dies down.
#[test]
fn a_tolerance_is_tried_and_extended() {
    let damped = chain();
    let undamped = in_a_row(&[("a", 2.0), ("c", 1.0)], &[3.0, 7.0], &[]);
    for (system, within) in [(&undamped, 1.2), (&damped, 1.4)] {
        for (tolerance, end) in [(1e-6, 4e3), (1e-9, 1e3), (1e-12, 1e3)] {
            for method in [
                Box::new(Dop853 { tolerance }) as Box<dyn Integrator>,
                Box::new(DormandPrince5 { tolerance }),
                Box::new(Radau5 {
                    tolerance: tolerance.max(1e-9),
                }),
            ] {
                let long = driven(system, end);
                let prediction = predicted(&*method, &long);
                let ratio = prediction.steps / taken(&*method, &long);
                println!("{} {tolerance:e}: {ratio} of what it takes", method.name());
                assert_eq!(prediction.basis, Basis::Accuracy, "{prediction:?}");
                assert!((1.0 / within..within).contains(&ratio));
                // So short that the trial is all of it.
                assert!(counts(&*method, &driven(system, 0.25)));
            }
        }
    }
}

/// A slow motion beside a fast one that has died down: only stability limits the step.
#[test]
fn stability_is_foreseen() {
    let stiff = scenes::system(1.0, 1e4, 1.0);
    let problem = Response::of(&stiff)
        .from(State::at_rest().displace("m1", 1.0))
        .every(1.0)
        .until(20.0)
        .problem()
        .expect("valid");
    for method in [
        Box::new(Dop853::with_tolerance(1e-6)) as Box<dyn Integrator>,
        Box::new(DormandPrince5::with_tolerance(1e-6)),
    ] {
        let prediction = predicted(&*method, &problem);
        let ratio = prediction.steps / taken(&*method, &problem);
        println!(
            "{}: {prediction:?}, {ratio} of what it takes",
            method.name()
        );
        assert_eq!(prediction.basis, Basis::Stability);
        assert!((0.99..1.01).contains(&ratio), "{ratio}");
    }
}

#[test]
fn what_is_refused_is_not_predicted() {
    let problem = |system| Response::of(system).every(0.5).until(1.0).problem();
    let massless = scenes::system(0.0, 1.0, 1.0);
    for method in super::all() {
        let error = method.predict(&problem(&massless).expect("valid"));
        assert!(matches!(error, Err(ResponseError::NotApplicable { .. })));
    }
}
