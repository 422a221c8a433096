//! Motions printed in verification manuals. VM is the ANSYS Mechanical APDL Verification Manual, SDLD
//! the guide of VPCS and Code_Aster; units are coherent. What they print is rounded, or was integrated
//! numerically: each test states how far the exact motion lies from it, relative to the printed
//! number. That distance is known to one digit, and half of that digit is allowed for.

use std::f64::consts::TAU;

use eigentone::prelude::*;
use eigentone::response::receptance;
use num_complex::Complex;

/// Masses m1, m2, …; joins between them, 0 being the ground.
fn network(
    masses: &[f64],
    springs: &[(usize, usize, f64)],
    dampers: &[(usize, usize, f64)],
) -> System {
    let name = |i: usize| match i {
        0 => GROUND.to_owned(),
        i => format!("m{i}"),
    };
    let mut builder = System::builder();
    for (i, mass) in masses.iter().enumerate() {
        builder = builder.mass(name(i + 1), *mass);
    }
    for &(i, j, stiffness) in springs {
        builder = builder.spring(name(i), name(j), stiffness);
    }
    for &(i, j, damping) in dampers {
        builder = builder.damper(name(i), name(j), damping);
    }
    builder.build().expect("a system")
}

/// One mass on the ground.
fn oscillator(mass: f64, damping: f64, stiffness: f64) -> System {
    network(&[mass], &[(0, 1, stiffness)], &[(0, 1, damping)])
}

fn assert_printed(found: f64, printed: f64, relative: f64) {
    let off = (found - printed).abs() / printed.abs();
    assert!(off <= relative, "{found} for {printed}: {off:.1e}");
}

/// The motion at these step indices of the grid is the one printed.
fn assert_motion(asked: Response<'_>, coordinate: usize, printed: &[(usize, f64)], relative: f64) {
    let trajectory = asked.run().expect("a response");
    for &(step, printed) in printed {
        let found = trajectory.displacement()[(coordinate, step)];
        assert_printed(found, printed, relative);
    }
}

#[test]
fn vm71_transient_response_of_a_damped_oscillator() {
    let printed = [
        (3.52636, 0.4742),
        (1.76318, 0.18998),
        (0.352636, -0.52108),
        (0.0, -0.99688),
    ];
    for (damping, printed) in printed {
        let system = oscillator(0.02590673, damping, 30.0);
        let asked = Response::of(&system).from(State::at_rest().displace("m1", 1.0));
        assert_motion(asked.every(0.09).until(0.09), 0, &[(1, printed)], 2.5e-5);
    }
}

#[test]
fn vm74_response_to_an_impulse() {
    for (damping, printed) in [
        (0.0, &[(8, 0.99957), (10, 0.90930)][..]),
        (14.0, &[(10, 0.34180)]),
    ] {
        let system = oscillator(0.5, damping, 200.0);
        let asked = Response::of(&system).load("m1", Impulse::of(10.0));
        assert_motion(asked.every(0.01).until(0.1), 0, printed, 1.5e-5);
    }
}

#[test]
fn vm75_response_to_a_step() {
    for (damping, printed) in [(0.0, 1.6536), (10.0, 1.1531)] {
        let system = oscillator(0.5, damping, 200.0);
        let asked = || Response::of(&system).load("m1", Step::of(200.0));
        assert_motion(asked().every(0.1).until(0.2), 0, &[(2, printed)], 3.5e-5);
        if damping == 0.0 {
            // At half a period, π/20 s.
            let peak = asked().every(TAU / 40.0).until(TAU / 40.0);
            assert_motion(peak, 0, &[(1, 2.0)], 1e-15);
        }
    }
}

#[test]
fn sdld320_unsupported_masses_driven_at_one_end() {
    let system = network(
        &[1e6, 12e6, 12e6],
        &[(1, 2, 4e9), (2, 3, 5.33e8)],
        &[(1, 2, 1.2566e6), (2, 3, 9.0478e6)],
    );
    let asked = || {
        let asked = Response::of(&system).load("m3", Harmonic::of(5e4, 59.69026));
        asked.every(0.01).until(5.0)
    };
    let printed = [
        (9, 6.7395e-6),
        (32, 1.1019e-5),
        (118, 3.6683e-5),
        (492, 1.6615e-4),
    ];
    assert_motion(asked(), 2, &printed, 3.5e-5);
    let trajectory = asked().run().expect("a response");
    assert_printed(trajectory.velocity()[(2, 5)], 1.3425e-4, 3.5e-5);
}

#[test]
fn sdld321_critical_damping_at_resonance() {
    let system = oscillator(10.0, 1000.0, 25000.0);
    let modes = system.modes().expect("modes");
    assert!(modes.iter().all(|mode| mode.is_defective()));
    let printed = [
        (6, 1.18914e-4),
        (12, -0.942819e-4),
        (19, 0.997958e-4),
        (25, -0.997748e-4),
        (31, 0.978457e-4),
        (38, -0.988705e-4),
        (44, 0.999961e-4),
    ];
    let asked = Response::of(&system).load("m1", Harmonic::of(5.0, 50.0));
    assert_motion(asked.every(0.01).until(0.44), 0, &printed, 7.5e-7);
}

#[test]
fn sdld325_two_masses_under_a_pulse() {
    let system = network(
        &[10.0, 10.0],
        &[(0, 1, 2800.0), (1, 2, 28e4)],
        &[(0, 1, 50.0), (1, 2, 50.0)],
    );
    let printed = [
        (27, 3.0927e-3),
        (53, 8.7953e-4),
        (80, 2.4669e-3),
        (125, -1.098e-3),
        (151, 7.8754e-4),
    ];
    let asked = Response::of(&system)
        .load("m2", Step::of(5.0))
        .load("m2", Step::of(-5.0).starting_at(1.0));
    assert_motion(asked.every(0.01).until(1.6), 1, &printed, 2.5e-4);
}

#[test]
fn vm86_harmonic_response_at_resonance() {
    let system = oscillator(0.5, 6.0, 200.0);
    let column = receptance(&system, "m1", TAU * 3.1831).expect("it is damped");
    assert_printed(10.0 * column.displacement()[0].norm(), 0.0833, 4.5e-4);
}

#[test]
fn vm90_harmonic_response_of_two_masses() {
    let springs = [(0, 1, 200.0), (1, 2, 200.0), (0, 2, 200.0)];
    let system = network(&[0.5, 0.5], &springs, &[]);
    for (hertz, printed) in [
        (1.5, [0.82272, 0.46274]),
        (4.0, [-0.51145, -1.2153]),
        (6.5, [-0.58513, 0.26966]),
    ] {
        let column = receptance(&system, "m1", TAU * hertz).expect("no resonance");
        for (x, printed) in column.displacement().iter().zip(printed) {
            assert_eq!(x.im, 0.0);
            assert_printed(200.0 * x.re, printed, 4.5e-5);
        }
    }
}

#[test]
fn sdld21_receptance_of_a_damped_chain() {
    let joins = |value: f64| -> Vec<(usize, usize, f64)> {
        (0..9).map(|i| (i, (i + 1) % 9, value)).collect()
    };
    let system = network(&[10.0; 8], &joins(1e5), &joins(50.0));
    for (hertz, re, im) in [
        (5.0, 1.0237e-4, -8.5187e-6),
        (5.5, 4.5066e-4, -7.7914e-4),
        (10.0, 8.4143e-7, -1.0335e-6),
        (40.0, -2.5696e-6, -2.7554e-7),
    ] {
        let column = receptance(&system, "m4", TAU * hertz).expect("it is damped");
        let (found, printed) = (column.displacement()[3], Complex::new(re, im));
        let off = (found - printed).norm() / printed.norm();
        assert!(off <= 2.5e-5, "{found} for {printed}: {off:.1e}");
    }
}
