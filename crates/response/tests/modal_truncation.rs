//! Modal truncation beside the whole response.

use eigentone_modes::{GROUND, System};
use eigentone_response::{
    Harmonic, Hold, Impulse, ModalTruncation, Polynomial, Ramp, Response, Samples, State, Step,
    Trajectory,
};

use crate::systems::in_a_row;

fn name(i: usize) -> String {
    match i {
        0 => GROUND.to_owned(),
        i => format!("m{i}"),
    }
}

/// A chain with proportional damping.
fn chain(n: usize, beta: f64) -> System {
    let mut builder = System::builder();
    for i in 1..=n {
        let k = 40.0 + (i % 4) as f64;
        builder = builder
            .mass(name(i), 1.0 + 0.2 * (i % 3) as f64)
            .spring(name(i - 1), name(i), k);
        if beta != 0.0 {
            builder = builder.damper(name(i - 1), name(i), beta * k);
        }
    }
    builder.build().unwrap()
}

fn question(system: &System) -> Response<'_> {
    let mut start = State::at_rest().push("m7", 0.2);
    for i in 1..=system.len() {
        start = start.displace(name(i), (i as f64 * 0.08).sin());
    }
    Response::of(system)
        .from(start)
        .load("m20", Step::of(2.0).starting_at(0.35))
        .load("m11", Ramp::of(0.5))
        .load("m30", Harmonic::of(0.8, 0.7))
        .load("m5", Impulse::of(0.1).at(1.0))
        .load(
            "m20",
            Samples {
                step: 0.5,
                values: vec![0.0, 1.0, -0.5],
                hold: Hold::First,
            },
        )
        .every(0.1)
        .until(6.0)
}

/// The largest errors of displacements and velocities, each checked against its bound.
fn errors(found: &Trajectory, exact: &Trajectory, bounded: bool) -> [f64; 2] {
    assert_eq!(found.steps(), exact.steps());
    for motion in [found, exact] {
        assert_eq!(
            motion.displacement_of("m7"),
            Ok(motion.displacement().row(6))
        );
        assert_eq!(motion.velocity_of("m7"), Ok(motion.velocity().row(6)));
        assert_eq!(motion.acceleration_of("m7"), Ok(None));
        assert!(motion.displacement_of("m0").is_err());
    }
    let mut worst = [0.0; 2];
    for column in 0..found.len() {
        let pairs = [
            (
                found.displacement(),
                exact.displacement(),
                found.displacement_bound()[column],
            ),
            (
                found.velocity(),
                exact.velocity(),
                found.velocity_bound()[column],
            ),
        ];
        for (worst, (found, exact, bound)) in worst.iter_mut().zip(pairs) {
            let error = (found.col(column) - exact.col(column)).norm_max();
            assert_eq!(bound.is_some(), bounded);
            if let Some(bound) = bound {
                assert!(
                    error <= bound + 1e-11,
                    "column {column}: {error:e} beyond {bound:e}"
                );
            }
            *worst = f64::max(*worst, error);
        }
    }
    worst
}

#[test]
fn bounds_hold_and_more_modes_are_nearer() {
    // A power of two, so that C is a multiple of K exactly.
    for beta in [0.0, 1.0 / 1024.0] {
        let system = chain(40, beta);
        let exact = question(&system).run().unwrap();
        let problem = question(&system).problem().unwrap();
        let mut last = [f64::INFINITY; 2];
        for modes in [3, 10, 25] {
            let found = ModalTruncation { modes }.run(&problem).unwrap();
            let worst = errors(&found, &exact, true);
            assert!(
                worst[0] < last[0] && worst[1] < last[1],
                "{modes}: {worst:?}, {last:?}"
            );
            last = worst;
        }
        let all = ModalTruncation { modes: 40 }.run(&problem).unwrap();
        let worst = errors(&all, &exact, true);
        assert!(worst[0] < 1e-11 && worst[1] < 1e-11, "{worst:?}");
    }
}

#[test]
fn the_static_correction_is_exact_for_loads_that_hardly_change() {
    let system = chain(40, 0.0);
    // So slow that all modes follow.
    let question = || {
        Response::of(&system)
            .load("m40", Harmonic::of(3.0, 1e-4))
            .every(1.0)
            .until(50.0)
    };
    let exact = question().run().unwrap();
    let found = ModalTruncation { modes: 4 }
        .run(&question().problem().unwrap())
        .unwrap();
    let scale = exact.displacement().norm_max();
    let worst = errors(&found, &exact, true);
    assert!(worst[0] < 1e-3 * scale, "{worst:?} of {scale}");
}

#[test]
fn without_bounds_where_none_can_be_given() {
    // A single damper couples shapes that are kept with those that are not.
    let mut builder = System::builder();
    for i in 1..=30 {
        builder = builder
            .mass(name(i), 1.0)
            .spring(name(i - 1), name(i), 40.0);
    }
    let system = builder.damper("m30", GROUND, 0.01).build().unwrap();
    let question = || {
        Response::of(&system)
            .load("m30", Step::of(1.0))
            .every(0.2)
            .until(8.0)
    };
    let exact = question().run().unwrap();
    let found = ModalTruncation { modes: 12 }
        .run(&question().problem().unwrap())
        .unwrap();
    let worst = errors(&found, &exact, false);
    assert!(
        worst[0] < 0.02 * exact.displacement().norm_max(),
        "{worst:?}"
    );
}

#[test]
fn a_floating_chain_drifts() {
    let mut builder = System::builder().mass("m1", 1.0);
    for i in 2..=20 {
        builder = builder
            .mass(name(i), 1.0)
            .spring(name(i - 1), name(i), 25.0);
    }
    let system = builder.build().unwrap();
    let question = || {
        Response::of(&system)
            .load("m3", Step::of(1.0))
            .every(0.5)
            .until(10.0)
    };
    let exact = question().run().unwrap();
    let found = ModalTruncation { modes: 20 }
        .run(&question().problem().unwrap())
        .unwrap();
    let worst = errors(&found, &exact, false);
    assert!(
        worst[0] < 1e-11 * exact.displacement().norm_max(),
        "{worst:?}"
    );
}

/// Stiff springs between soft ones: shapes in doubles are off by more than a unit of rounding, and at the start already.
#[test]
fn bounds_count_errors_of_shapes_and_rounding() {
    let mut builder = System::builder();
    for i in 1..=5 {
        let stiffness = if i % 2 == 1 { 1.0 } else { 1e4 };
        builder = builder.mass(name(i), 1.0);
        builder = builder.spring(name(i - 1), name(i), stiffness);
    }
    let stiff = builder.build().unwrap();
    let single = in_a_row(&[("m3", 0.552)], &[67.3], &[]);
    for system in [&stiff, &single] {
        let start = State::at_rest().displace("m3", -0.06).push("m3", 0.7);
        let asked = Response::of(system).from(start).every(0.25).until(20.0);
        let asked = asked.load("m3", Step::of(0.3).starting_at(0.6));
        let exact = asked.clone().run().unwrap();
        let modes = system.len();
        let found = ModalTruncation { modes }.run(&asked.problem().unwrap());
        let found = found.unwrap();
        for column in 0..found.len() {
            let pairs = [
                (
                    found.displacement(),
                    exact.displacement(),
                    found.displacement_bound(),
                ),
                (found.velocity(), exact.velocity(), found.velocity_bound()),
            ];
            for (found, exact, bounds) in pairs {
                let error = (found.col(column) - exact.col(column)).norm_max();
                let bound = bounds[column].expect("held and passive");
                // What is proved is rounded to doubles.
                let rounded = f64::EPSILON / 2.0 * exact.col(column).norm_max();
                assert!(error <= bound + rounded, "{column}: {error:e} {bound:e}");
                assert!(bound < 1e-6, "{column}: {bound:e}");
            }
        }
    }
}

#[test]
fn polynomials_are_refused_as_such() {
    let system = chain(3, 0.0);
    let asked = Response::of(&system).load("m2", Polynomial::of([1.0, 2.0]));
    let problem = asked.every(0.1).until(1.0).problem().unwrap();
    let error = ModalTruncation { modes: 2 }.run(&problem).unwrap_err();
    assert!(error.to_string().contains("polynomials"), "{error}");
}
