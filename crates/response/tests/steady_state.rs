//! Steady states against answers with 32 digits, computed from the exact systems with mpmath.

use std::f64::consts::FRAC_PI_6;

use eigentone_modes::{GROUND, MatrixKind, System};
use eigentone_response::{
    Extrema, Harmonic, HarmonicMotion, Quantity, Response, SteadyState, SteadyStateError, Summary,
    receptance,
};
use faer::mat;
use num_complex::Complex;
use proptest::prelude::*;

use crate::systems::in_a_row;

/// Real and imaginary part, each as the sum of two doubles.
type Truth = [f64; 4];

/// Masses m1, m2, …; springs and dampers between them, 0 for the ground.
fn network(masses: &[f64], springs: &[(u8, u8, f64)], dampers: &[(u8, u8, f64)]) -> System {
    let name = |i: u8| match i {
        0 => GROUND.to_owned(),
        i => format!("m{i}"),
    };
    let mut builder = System::builder();
    for (i, mass) in masses.iter().enumerate() {
        builder = builder.mass(format!("m{}", i + 1), *mass);
    }
    for &(i, j, stiffness) in springs {
        builder = builder.spring(name(i), name(j), stiffness);
    }
    for &(i, j, damping) in dampers {
        builder = builder.damper(name(i), name(j), damping);
    }
    builder.build().expect("a system")
}

fn steady(system: &System, loads: &[(&str, Harmonic)]) -> Result<SteadyState, SteadyStateError> {
    let start = Response::of(system).every(1.0).until(1.0);
    let asked = loads
        .iter()
        .fold(start, |asked, (name, load)| asked.load(*name, *load));
    SteadyState::of(&asked.problem().expect("well posed"))
}

/// Each amplitude is within its bound of the truth, and the bound is that of a last digit.
fn assert_true(motion: &HarmonicMotion, truth: &[Truth]) {
    assert_eq!(motion.displacement().len(), truth.len());
    for (i, ((x, bound), truth)) in motion
        .displacement()
        .iter()
        .zip(motion.bound())
        .zip(truth)
        .enumerate()
    {
        let off = |part: f64, high: f64, low: f64| (part - high) - low;
        let off = off(x.re, truth[0], truth[1]).hypot(off(x.im, truth[2], truth[3]));
        assert!(off <= *bound, "{i}: {x} is off by {off:e}, not {bound:e}");
        assert!(*bound <= f64::EPSILON * x.norm(), "{i}: {x} ± {bound:e}");
    }
}

fn alone(system: &System, loads: &[(&str, Harmonic)]) -> HarmonicMotion {
    let steady = steady(system, loads).expect("a steady state");
    assert_eq!(steady.motions().len(), 1);
    steady.motions()[0].clone()
}

#[test]
fn a_spring_of_1_beside_one_of_1e20() {
    let system = network(&[1.0, 2.0], &[(0, 1, 1.0), (1, 2, 1e20)], &[(0, 2, 0.3)]);
    let motion = alone(&system, &[("m2", Harmonic::of(2.0, 0.7).with_phase(0.4))]);
    let truth = [
        [
            -2.6499684173323734,
            1.609134102929786e-16,
            -2.841127770759787,
            -1.4615450918389003e-16,
        ],
        [
            -2.6499684173323734,
            1.608998954540502e-16,
            -2.841127770759787,
            -1.461689989355209e-16,
        ],
    ];
    assert_true(&motion, &truth);
}

/// The double nearest to √3 is no resonance, only very near to one.
#[test]
fn as_near_to_resonance_as_doubles_come() {
    let system = network(&[0.1], &[(0, 1, 0.3)], &[]);
    let motion = alone(&system, &[("m1", Harmonic::of(1.0, 3f64.sqrt()))]);
    assert_true(
        &motion,
        &[[1.4271492040157221e17, -2.6119191507226267, 0.0, 0.0]],
    );
}

#[test]
fn graded_springs_and_loads_of_both_signs_of_frequency() {
    let springs = [
        (0, 1, 1e12),
        (1, 2, 1e-6),
        (2, 3, 1e6),
        (3, 4, 1.0),
        (4, 5, 1e9),
        (5, 6, 1e3),
        (0, 6, 1e-3),
    ];
    let dampers = [(1, 2, 0.2), (4, 6, 10.0), (0, 5, 1e-4)];
    let system = network(&[1.0, 0.5, 2.0, 1e-3, 3.0, 0.25], &springs, &dampers);
    let loads = [
        ("m2", Harmonic::of(1.5, 3.3).with_phase(0.7)),
        ("m6", Harmonic::of(-0.3, -3.3).with_phase(-2.0)),
    ];
    let truth = [
        [
            2.4860380785514698e-14,
            -7.076179909781316e-31,
            -2.8369872906515922e-14,
            9.384642844761108e-31,
        ],
        [
            -0.04298459884679064,
            1.8692886171971885e-18,
            -0.03766730874221445,
            7.214388249684628e-19,
        ],
        [
            -0.04298548719855006,
            -1.1395742127000228e-18,
            -0.037668098340122115,
            1.2564462752591878e-18,
        ],
        [
            0.004886664565156496,
            2.735137094253559e-19,
            -0.006854824153648395,
            -3.6207091253034174e-19,
        ],
        [
            0.004886664621497541,
            -1.4771219332832206e-19,
            -0.006854824119351441,
            -2.7977634444179013e-19,
        ],
        [
            0.004783360594660838,
            -3.1527197605786653e-19,
            -0.0065965784485250405,
            -2.8832792322256226e-19,
        ],
    ];
    assert_true(&alone(&system, &loads), &truth);
}

#[test]
fn without_any_symmetry() {
    let damping = mat![[0.0, 0.5, 0.0], [-0.5, 0.0, 0.25], [0.0, -0.25, 0.1]];
    let stiffness = mat![[3.0, -1.0, 0.5], [-2.0, 4.0, 0.0], [0.0, -1.5, 6.0]];
    let system = System::builder()
        .mass("m1", 2.0)
        .mass("m2", 1.0)
        .mass("m3", 3.0)
        .spring(GROUND, "m1", 5.0)
        .damper("m1", "m3", 0.1)
        .matrix(MatrixKind::Damping, damping.as_ref())
        .matrix(MatrixKind::Stiffness, stiffness.as_ref())
        .build()
        .expect("a system");
    let truth = [
        [
            0.1519652327714637,
            -2.370555977687177e-19,
            0.29160438623038243,
            -1.1349314371255757e-17,
        ],
        [
            -0.1658712416224609,
            1.0689890516733559e-17,
            0.4648816502562371,
            -8.882696969822229e-18,
        ],
        [
            -0.31029384242413954,
            -1.9551201983064408e-17,
            -1.0013382632251924,
            9.948106446592312e-18,
        ],
    ];
    assert_true(&receptance(&system, "m3", 1.5).expect("a motion"), &truth);
}

#[test]
fn a_phase_of_1e22_is_the_double_1e22() {
    let system = network(&[1.0], &[(0, 1, 2.0)], &[(0, 1, 0.5)]);
    let motion = alone(&system, &[("m1", Harmonic::of(1.0, 1.0).with_phase(1e22))]);
    let truth = [
        0.07769148840923563,
        1.206529526312306e-18,
        -0.8910465939718066,
        1.3432734358888204e-17,
    ];
    assert_true(&motion, &[truth]);
}

#[test]
fn nodes_without_mass() {
    let springs = [(0, 1, 4.0), (1, 2, 3.0), (2, 3, 7.0), (0, 3, 0.5)];
    let system = network(&[1.0, 0.0, 0.0], &springs, &[(0, 2, 0.8)]);
    let motion = alone(&system, &[("m3", Harmonic::of(1.0, 2.5).with_phase(0.1))]);
    let truth = [
        [
            -0.4029431680598367,
            2.037167449952998e-17,
            -0.13811692479701154,
            -6.1521663965652064e-18,
        ],
        [
            -0.10073579201495918,
            5.092918624882495e-18,
            -0.034529231199252886,
            -1.5380415991413016e-18,
        ],
        [
            0.03864714948977487,
            2.5057774871772694e-18,
            -0.01891616023305894,
            1.2878281260098505e-18,
        ],
    ];
    assert_true(&motion, &truth);
}

#[test]
fn frequency_0_is_a_constant_force() {
    let system = network(&[1.0, 1.0], &[(0, 1, 3.0), (1, 2, 0.1)], &[(0, 1, 1.0)]);
    let load = Harmonic::of(4.0, 0.0).with_phase(0.5);
    let truth = [
        [0.0, 0.0, 0.6392340514722706, 3.0202141006763866e-17],
        [0.0, 0.0, 19.81625559564039, 1.0929731551939461e-15],
    ];
    assert_true(&alone(&system, &[("m2", load)]), &truth);
    // Without a phase it is no force at all.
    let none = alone(&system, &[("m2", Harmonic::of(4.0, 0.0))]);
    assert!(none.displacement().iter().all(|x| x.norm() == 0.0));
}

#[test]
fn each_frequency_has_its_motion() {
    let system = network(&[1.0], &[(0, 1, 2.0)], &[(0, 1, 0.5)]);
    let loads = [
        ("m1", Harmonic::of(1.0, 3.0)),
        ("m1", Harmonic::of(2.0, 1.0)),
        ("m1", Harmonic::of(-1.0, 3.0)),
    ];
    let steady = steady(&system, &loads).expect("a steady state");
    let frequencies = steady.motions().iter().map(HarmonicMotion::frequency);
    assert_eq!(frequencies.collect::<Vec<_>>(), [3.0, 1.0]);
    // The loads at 3 rad/s cancel, and 2 / (1 + 0.5i) = 1.6 − 0.8i.
    assert_eq!(steady.motions()[0].displacement()[0].norm(), 0.0);
    let x = steady.motions()[1].displacement()[0];
    assert!((x.re - 1.6).abs() < 1e-15 && (x.im + 0.8).abs() < 1e-15);
    let (v, a) = (
        steady.motions()[1].velocity(),
        steady.motions()[1].acceleration(),
    );
    assert_eq!((v[0].re, v[0].im), (-x.im, x.re));
    assert_eq!(a[0], -x);
}

#[test]
fn undamped_resonance_is_proved() {
    let single = network(&[0.1], &[(0, 1, 0.4)], &[]);
    let at = |system: &System, name, frequency| receptance(system, name, frequency);
    let resonance = |frequency| Err(SteadyStateError::Resonance { frequency });
    assert_eq!(at(&single, "m1", 2.0), resonance(2.0));
    assert!(at(&single, "m1", 2f64.next_up()).is_ok());
    // ω = 2 sin(10π/60) = 1 is a mode of 59 equal masses between walls.
    let springs: Vec<(u8, u8, f64)> = (0..60).map(|i| (i, (i + 1) % 60, 1.0)).collect();
    let chain = network(&[1.0; 59], &springs, &[]);
    assert_eq!(at(&chain, "m7", 1.0), resonance(1.0));
    assert!(at(&chain, "m7", 1.0 + 1e-9).is_ok());
    // The same with decimal numbers: 0.7·2² = 2.8 holds for their doubles too.
    let springs = [
        (0, 1, 2.8),
        (1, 2, 0.3),
        (2, 3, 0.3),
        (0, 3, 2.8),
        (0, 2, 2.8),
    ];
    let decimal = network(&[0.7, 0.7, 0.7], &springs, &[]);
    assert_eq!(at(&decimal, "m1", 2.0), resonance(2.0));
    // A damper elsewhere in the mode ends it, one at a node of the mode does not.
    let springs = [(0, 1, 4.0), (1, 2, 1.0), (2, 3, 1.0), (0, 3, 4.0)];
    let damped = |at| network(&[1.25, 1.0, 1.25], &springs, &[(0, at, 0.1)]);
    assert_eq!(at(&damped(2), "m1", 2.0), resonance(2.0));
    assert!(at(&damped(3), "m1", 2.0).is_ok());
}

#[test]
fn what_no_load_reaches_may_resonate() {
    let system = network(&[1.0, 1.0], &[(0, 1, 4.0), (0, 2, 9.0)], &[]);
    let motion = receptance(&system, "m2", 2.0).expect("m1 stands still");
    assert_eq!(motion.displacement()[0].norm(), 0.0);
    assert_eq!(motion.displacement()[1].re, 0.2);
    assert_eq!(motion.transmissibility(1, 0).map(|t| t.norm()), Some(0.0));
    assert_eq!(motion.transmissibility(0, 1), None);
    assert_eq!(motion.transmissibility(0, 2), None);
}

#[test]
fn what_nothing_holds_has_no_equilibrium() {
    let free = network(&[1.0, 2.0], &[(1, 2, 3.0)], &[(0, 1, 1.0)]);
    let load = Harmonic::of(1.0, 0.0).with_phase(1.0);
    let error = steady(&free, &[("m1", load)]).expect_err("nothing holds it");
    assert_eq!(error, SteadyStateError::Unsupported);
    assert!(receptance(&free, "m1", 1e-150).is_ok());
}

/// What is constant is a load that lasts, and no reason to have no steady state, unless a support takes a spring along.
#[test]
fn what_is_constant_leaves_a_steady_state() {
    let still = Harmonic::of(2.0, 0.0).with_phase(FRAC_PI_6);
    let amplitudes = |system: &System, ask: &dyn Fn(Response<'_>) -> Response<'_>| {
        let response = Response::of(system).load("m", Harmonic::of(5.0, 2.0));
        let problem = ask(response.every(1.0).until(1.0))
            .problem()
            .expect("a problem");
        let steady = SteadyState::of(&problem)?;
        let motions = steady.motions().iter();
        Ok(motions
            .map(|motion| (motion.frequency(), motion.displacement()[0]))
            .collect())
    };
    let near = |found: Result<Vec<(f64, Complex<f64>)>, SteadyStateError>,
                wanted: &[(f64, Complex<f64>)]| {
        let found = found.expect("a steady state");
        assert_eq!(found.len(), wanted.len(), "{found:?}");
        for ((frequency, x), (at, truth)) in found.iter().zip(wanted) {
            assert!(frequency == at && (x - truth).norm() < 1e-15, "{found:?}");
        }
    };
    let mass = || System::builder().mass("m", 1.0).support("road");
    // 5/(−4 + 2i) on a dashpot, which a steady force drags along.
    let dashpot = mass().damper(GROUND, "m", 1.0).build().expect("a system");
    let free = (2.0, 5.0 / Complex::new(-4.0, 2.0));
    near(
        amplitudes(&dashpot, &|response| response.load("m", still)),
        &[free],
    );
    // Nothing touches the road.
    let held = mass().damper(GROUND, "m", 1.0).spring(GROUND, "m", 8.0);
    let held = held.build().expect("a system");
    let own = (2.0, 5.0 / Complex::new(4.0, 2.0));
    for quantity in [Quantity::Velocity, Quantity::Acceleration] {
        let moved = amplitudes(&held, &|response| response.motion("road", quantity, still));
        near(moved, &[own, (0.0, Complex::ZERO)]);
    }
    // A damper pulls with c·v = 2·sin(π/6), and sees an acceleration grow.
    let pulled = mass().damper("road", "m", 1.0).spring(GROUND, "m", 8.0);
    let pulled = pulled.build().expect("a system");
    let by = |quantity: Quantity| {
        amplitudes(&pulled, &|response| {
            response.motion("road", quantity, still)
        })
    };
    near(
        by(Quantity::Velocity),
        &[own, (0.0, Complex::new(0.0, 0.125))],
    );
    assert_eq!(by(Quantity::Acceleration), Err(SteadyStateError::Drift));
    // A spring, and what nothing else holds, follow.
    let sprung = mass().damper(GROUND, "m", 1.0).spring("road", "m", 8.0);
    let towed = mass().damper("road", "m", 1.0);
    for system in [sprung, towed].map(|system| system.build().expect("a system")) {
        let moved = amplitudes(&system, &|response| {
            response.motion("road", Quantity::Velocity, still)
        });
        assert_eq!(moved, Err(SteadyStateError::Drift));
    }
}

#[test]
fn wrong_questions_are_refused() {
    let system = network(&[1.0], &[(0, 1, 1.0)], &[]);
    let error = receptance(&system, "m2", 1.0).expect_err("there is no m2");
    assert!(error.to_string().contains("m1"), "{error}");
    assert!(receptance(&system, "m1", f64::NAN).is_err());
    // Ω² does not fit into a double, but the receptance −1/Ω² may be as small as it likes.
    assert_eq!(
        receptance(&system, "m1", 1e200).map(|m| m.displacement()[0].norm()),
        Ok(0.0)
    );
    let soft = network(&[1.0], &[(0, 1, 5e-324)], &[]);
    let error = receptance(&soft, "m1", 0.0).expect_err("1/5e-324 is no double");
    assert_eq!(error, SteadyStateError::OutOfRange { frequency: 0.0 });
}

/// F/(k − Ω²m + iΩc) has digits of its own in tiny units too.
#[test]
fn tiny_and_huge_units() {
    for unit in [1e-300, 1e-30, 1e280] {
        let system = network(&[unit], &[(0, 1, 2.0 * unit)], &[(0, 1, unit)]);
        let x = receptance(&system, "m1", 1.0)
            .expect("a motion")
            .displacement()[0];
        // 1/(1 + i)
        let off = (x.re * unit - 0.5).hypot(x.im * unit + 0.5);
        assert!(off <= 4.0 * f64::EPSILON, "{unit:e}: {x}");
    }
}

/// Where all free motion has decayed, the response is the steady state.
#[test]
fn transients_end_in_the_steady_state() {
    let springs = [(0, 1, 3.0), (1, 2, 2.0), (2, 3, 1.0)];
    let dampers = [(0, 1, 0.5), (1, 2, 0.7), (2, 3, 0.9)];
    let system = network(&[1.0, 2.0, 0.5], &springs, &dampers);
    let problem = Response::of(&system)
        .load("m2", Harmonic::of(1.0, 0.8).with_phase(0.3))
        .load("m3", Harmonic::of(0.5, 2.0).with_phase(-1.0))
        .every(0.5)
        .until(1000.0)
        .problem()
        .expect("well posed");
    let steady = SteadyState::of(&problem).expect("a steady state");
    let plan = eigentone_response::ResponsePlan::of(&problem).expect("a plan");
    let trajectory = plan.run(&problem).expect("a response");
    for k in 1900..=2000 {
        let t = trajectory.times()[k];
        for i in 0..3 {
            let term = |motion: &HarmonicMotion| {
                let x = motion.displacement()[i];
                x.norm() * (motion.frequency() * t + x.arg()).sin()
            };
            let x: f64 = steady.motions().iter().map(term).sum();
            let off = (x - trajectory.displacement()[(i, k)]).abs();
            assert!(off < 1e-12, "{k}: {off:e}");
        }
    }
}

/// Equal masses and springs whose doubles are no short numbers: the determinant's last possible bit is
/// some thousand bits below 1.
#[test]
fn resonance_of_decimal_numbers_is_proved() {
    // ω = √(k/m)·2 sin(π/6) for the mode (n + 1)/3 of n masses between walls.
    for n in [5u8, 20, 59] {
        let springs: Vec<(u8, u8, f64)> = (0..=n).map(|i| (i, (i + 1) % (n + 1), 0.1)).collect();
        let chain = network(&vec![0.1; usize::from(n)], &springs, &[]);
        let error = receptance(&chain, "m1", 1.0).expect_err("a mode");
        assert_eq!(error, SteadyStateError::Resonance { frequency: 1.0 });
        assert!(receptance(&chain, "m1", 1f64.next_up()).is_ok());
    }
}

proptest! {
    /// Whole numbers for masses, springs, Ω and X make whole forces: X must come back.
    #[test]
    fn planted_amplitudes_are_found(
        masses in prop::collection::vec(1..100u32, 1..6),
        stiff in prop::collection::vec((0..6u8, 0..6u8, 0..20u32), 1..9),
        planted in prop::collection::vec(-99..100i32, 5),
        frequency in 1..30u32,
    ) {
        let n = masses.len();
        let masses: Vec<f64> = masses.into_iter().map(f64::from).collect();
        let springs = stiff.into_iter().map(|(i, j, power)| (i % (n as u8 + 1), j % (n as u8 + 1), 2f64.powi(power as i32)));
        let springs: Vec<(u8, u8, f64)> = springs.filter(|(i, j, _)| i != j).collect();
        let system = network(&masses, &springs, &[]);
        let stiffness = system.stiffness_matrix();
        let omega = f64::from(frequency);
        let loads: Vec<(String, Harmonic)> = (0..n).map(|i| {
            // Below 2^53, so that nothing is rounded.
            let row = (0..n).map(|j| stiffness[(i, j)] * f64::from(planted[j]));
            let force = row.sum::<f64>() - omega * omega * masses[i] * f64::from(planted[i]);
            (format!("m{}", i + 1), Harmonic::of(force, omega))
        }).collect();
        let loads: Vec<(&str, Harmonic)> = loads.iter().map(|(name, load)| (name.as_str(), *load)).collect();
        prop_assume!(loads.iter().any(|(_, load)| load.amplitude != 0.0));
        // Elsewhere X is the only solution.
        prop_assume!(system.names().iter().all(|name| receptance(&system, name, omega).is_ok()));
        let motion = alone(&system, &loads);
        let found = motion.displacement().iter().zip(motion.bound());
        for ((x, bound), planted) in found.zip(planted) {
            let off = (x - f64::from(planted)).norm();
            prop_assert!(off <= *bound && x.im == 0.0, "{} for {}", x, planted);
            prop_assert!(*bound <= 1e-13, "{:e}", bound);
        }
    }
}

/// What would need dense matrices of a large system says so at once.
#[test]
fn large_systems_are_refused() {
    let n = 5_000;
    let mut builder = System::builder();
    for i in 0..n {
        builder = builder.mass(format!("m{i}"), 1.0);
    }
    for i in 1..n {
        builder = builder.spring(format!("m{}", i - 1), format!("m{i}"), 1.0);
    }
    let system = builder.spring(GROUND, "m0", 1.0).build().expect("a chain");
    assert!(system.is_large());
    let refused = |error: SteadyStateError| {
        let right = matches!(
            error,
            SteadyStateError::TooLarge {
                coordinates: 5_000,
                ..
            }
        );
        assert!(right, "{error}");
    };
    refused(receptance(&system, "m7", 0.5).expect_err("it is large"));
    let problem = Response::of(&system)
        .load("m7", Harmonic::of(1.0, 0.5))
        .every(1.0)
        .until(1.0)
        .problem()
        .expect("well posed");
    refused(SteadyState::of(&problem).expect_err("it is large"));

    let small = in_a_row(&[("m", 1.0)], &[1.0], &[]);
    let motion = Response::of(&small).every(1.0).until(1.0).run();
    let motion = motion.expect("well posed");
    let modes = small.modes().expect("it has modes");
    assert!(Summary::of(&problem, &motion, &modes).is_none());
    assert!(Extrema::of(&problem, &motion).is_none());
}
