//! Systems in which some motions die down much faster than others.

use eigentone_check::{
    Dop853, GeneralizedAlpha, HhtAlpha, Integrator, Limit, Newmark, OneMass, Radau5,
};
use eigentone_modes::{GROUND, System};
use eigentone_response::{
    ByCertifiedExponential, Harmonic, Problem, Response, ResponseMethod, State, Step,
};

use super::{error, run};
use crate::scenes;

const TOLERANCES: [f64; 4] = [1e-4, 1e-6, 1e-8, 1e-10];

/// Answers within the tolerance, and in how many steps.
fn steps(problem: &Problem<'_>, truth: &dyn ResponseMethod) -> [u64; 4] {
    let truth = run(truth, problem);
    TOLERANCES.map(|tolerance| {
        let radau = Radau5 { tolerance };
        let answer = radau.integrate(problem, Limit::default());
        let (answer, work) = answer.expect("applies");
        let off = error(&answer, &truth) / tolerance;
        println!("{tolerance:e}: {off:.1e} tolerances, {work:?}");
        assert!(off < 20.0, "{tolerance:e}: {off}");
        assert!(work.rejected <= 3 + work.accepted / 10);
        work.accepted + work.rejected
    })
}

/// A hundred times as stiff takes but a few steps more, to grow from the shortest.
fn do_not_grow(steps: &[[u64; 4]]) {
    for pair in steps.windows(2) {
        for (soft, stiff) in pair[0].iter().zip(pair[1]) {
            assert!(stiff < 30 + soft + soft / 10, "{steps:?}");
        }
    }
}

#[test]
fn an_overdamped_mass_takes_few_steps() {
    let all = [1e3, 1e5, 1e7].map(|damping| {
        let system = scenes::system(1.0, damping, 1.0);
        let problem = Response::of(&system)
            .from(State::at_rest().displace("m1", 1.0))
            .load("m1", Step::of(3.0).starting_at(0.37 * damping))
            .every(damping / 64.0)
            .until(damping)
            .problem()
            .expect("valid");
        steps(&problem, &OneMass)
    });
    do_not_grow(&all);
}

/// A stiff damper between two of three masses, and a load.
#[test]
fn a_stiff_damper_takes_few_steps() {
    let system = |damping| -> System {
        System::builder()
            .mass("a", 1.0)
            .mass("b", 2.0)
            .mass("c", 0.5)
            .spring(GROUND, "a", 1.0)
            .spring("a", "b", 2.0)
            .spring("b", "c", 1.0)
            .damper("a", "b", damping)
            .damper("c", GROUND, 0.1)
            .build()
            .expect("valid")
    };
    let all = [1e4, 1e6, 1e8].map(|damping| {
        let system = system(damping);
        let problem = Response::of(&system)
            .from(State::at_rest().displace("c", 1.0))
            .load("b", Harmonic::of(1.0, 0.7))
            .every(0.25)
            .until(20.0)
            .problem()
            .expect("valid");
        let explicit = Dop853::with_tolerance(1e-6).predict(&problem);
        assert!(explicit.expect("applies").steps > damping);
        steps(&problem, &ByCertifiedExponential)
    });
    do_not_grow(&all);
}

/// The α methods restart without raising what is too fast for their steps: they are no worse than
/// the average-acceleration method.
#[test]
fn restarts_do_not_raise_fast_motion() {
    for (damping, stiffness) in [(1e6, 1.0), (0.0, 1e10)] {
        let system = scenes::system(1.0, damping, stiffness);
        let problem = Response::of(&system)
            .from(State::at_rest().displace("m1", 1.0))
            .load("m1", Step::of(3.0).starting_at(5.0))
            .every(0.1)
            .until(10.0)
            .problem()
            .expect("valid");
        let largest = |method: &dyn Integrator| {
            let answer = run(method, &problem);
            answer.displacement().norm_max()
        };
        let plain = largest(&Newmark::with_substeps(1));
        for method in [
            &HhtAlpha::with_substeps(1) as &dyn Integrator,
            &GeneralizedAlpha::with_substeps(1),
        ] {
            let ratio = largest(method) / plain;
            println!(
                "{}: {ratio} of the average-acceleration method",
                method.name()
            );
            assert!(ratio < 1.01, "{ratio}");
        }
    }
}
