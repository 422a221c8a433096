//! The methods of the crate `diffsol`.

use eigentone_check::{Bdf, Esdirk34, Integrator, Limit, TrBdf2};
use eigentone_response::{ByCertifiedExponential, Harmonic, Response, State, Step};

use super::{chain, error, loaded, run};
use crate::scenes;

/// Errors follow the tolerance under every kind of load. They come to more tolerances than those of
/// other methods, since so many more steps add up.
#[test]
fn errors_follow_the_tolerance() {
    let system = chain();
    let problem = loaded(&system).problem().expect("valid");
    let truth = run(&ByCertifiedExponential, &problem);
    for power in [4, 6, 8] {
        let tolerance = 10f64.powi(-power);
        for method in [
            &Bdf { tolerance } as &dyn Integrator,
            &TrBdf2 { tolerance },
            &Esdirk34 { tolerance },
        ] {
            let (answer, work) = method
                .integrate(&problem, Limit::default())
                .expect("applies");
            let times = error(&answer, &truth) / tolerance;
            println!(
                "{} {tolerance:e}: {times:.1} tolerances, {work:?}",
                method.name()
            );
            assert!(times < 0.5 * work.accepted as f64, "{times}");
            assert!(work.factorisations > 0 && work.solves >= work.accepted);
        }
    }
}

/// A motion that begins far below its later size, and a stiff one.
#[test]
fn tolerances_grow_with_the_motion() {
    let system = scenes::system(1.0, 0.0, 4.0);
    let problem = Response::of(&system)
        .load("m1", Harmonic::of(1.0, 2.0))
        .every(0.5)
        .until(100.0)
        .problem()
        .expect("valid");
    let truth = run(&ByCertifiedExponential, &problem);
    let stiff = scenes::system(1.0, 1e6, 1.0);
    let overdamped = Response::of(&stiff)
        .from(State::at_rest().displace("m1", 1.0))
        .load("m1", Step::of(3.0).starting_at(3e5))
        .every(2e4)
        .until(1e6)
        .problem()
        .expect("valid");
    let slow = run(&ByCertifiedExponential, &overdamped);
    let tolerance = 1e-6;
    for method in [
        &Bdf { tolerance } as &dyn Integrator,
        &TrBdf2 { tolerance },
        &Esdirk34 { tolerance },
    ] {
        let off = |problem, truth| {
            let answer = method.integrate(problem, Limit::default());
            let (answer, work) = answer.expect("applies");
            let times = error(&answer, truth) / tolerance;
            println!("{}: {times:.1} tolerances, {work:?}", method.name());
            assert!(times < 0.5 * work.accepted as f64, "{times}");
            work.accepted
        };
        off(&problem, &truth);
        // An explicit method would take 1e11.
        assert!(off(&overdamped, &slow) < 2000);
    }
}
