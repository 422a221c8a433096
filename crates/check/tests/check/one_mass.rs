//! The closed form of one mass.

use eigentone_check::{Damping, MassSpringDamper, OneMass, OneMassError};
use eigentone_modes::{GROUND, MatrixKind, System};
use eigentone_response::{
    Harmonic, Hold, Impulse, Load, Polynomial, Problem, Quantity, Ramp, Response, ResponseError,
    ResponseMethod, Samples, State, Step, Trajectory,
};
use faer::mat;
use proptest::prelude::*;

use crate::scenes::{self, FREE, RESONANCE};

const ULP: f64 = f64::EPSILON;

fn one(mass: f64, damping: f64, stiffness: f64) -> MassSpringDamper {
    MassSpringDamper::new(mass, damping, stiffness).expect("in range")
}

#[track_caller]
fn assert_close(value: f64, truth: f64, relative: f64) {
    let off = (value - truth).abs();
    assert!(
        off <= relative * truth.abs(),
        "{value:e} is {:.2e} off {truth:e}",
        off / truth.abs()
    );
}

/// The scenes decay by up to 16 orders of magnitude; every truth holds to 3 ulp of the amplitude
/// that is left.
#[test]
fn reproduces_every_digit_of_the_gallery() {
    for scene in &FREE {
        let system = scene.system();
        let answer = OneMass.run(&scene.problem(&system)).expect("applies");
        let omega = (scene.stiffness / scene.mass).sqrt();
        for truth in scene.truth() {
            let column = truth.step as usize;
            let amplitude = truth.displacement.abs().max(truth.velocity.abs() / omega);
            let off_displacement = answer.displacement()[(0, column)] - truth.displacement;
            let off_velocity = answer.velocity()[(0, column)] - truth.velocity;
            let place = format!("{} at step {}", scene.title, truth.step);
            assert!(off_displacement.abs() <= 3.0 * ULP * amplitude, "{place}");
            assert!(
                off_velocity.abs() <= 3.0 * ULP * omega * amplitude,
                "{place}"
            );
        }
    }
}

/// Mass, damping, stiffness and time; then displacement released from 1, displacement after a
/// velocity of 1, their rates, and displacement under a force of 1. Computed with 250 digits from
/// the eigenvalues. Near-critical damping, a damper 1e8 times critical, 2.5e8 oscillations, both
/// sides of where the series ends, no support, extreme units.
#[rustfmt::skip]
const TRUTHS: &[([f64; 4], [f64; 5])] = &[
    ([1.0, 2.000000000002, 1.0, 3.0], [0.1991482734719039, 0.14936120510359183, -0.14936120510359183, -0.09957413673557851, 0.8008517265280961]),
    ([1.0, 1.999999999998, 1.0, 3.0], [0.1991482734710077, 0.14936120510359183, -0.14936120510359183, -0.09957413673587724, 0.8008517265289923]),
    ([1.0, 2.000000000000002, 1.0, 30.0], [2.900863120341389e-12, 2.807286890652894e-12, -2.807286890652894e-12, -2.7137106609644048e-12, 0.9999999999970991]),
    ([1.0, 100000000.0, 1.0, 100000000.0], [0.36787944117144233, 3.6787944117144235e-09, -3.6787944117144235e-09, -3.678794411714424e-17, 0.6321205588285577]),
    ([1.0, 100000000.0, 1.0, 1e-08], [1.0, 6.321205588285577e-09, -6.321205588285577e-09, 0.3678794411714423, 3.678794411714423e-17]),
    ([1.0, 100000000.0, 1.0, 3e-09], [1.0, 2.591817793182821e-09, -2.591817793182821e-09, 0.7408182206817179, 4.0818220681717865e-18]),
    ([1.0, 100000000.0, 1.0, 1.1e-08], [1.0, 6.671289163019204e-09, -6.671289163019204e-09, 0.33287108369807955, 4.328710836980795e-17]),
    ([0.3, 0.0, 770000.0, 1000000.0], [0.5461067367133564, 0.0005228918460281341, -1342.089071472211, 0.5461067367133564, 5.894717705021346e-07]),
    ([0.3, 1e-09, 770000.0, 1000000.0], [0.5451973168800806, 0.0005220210854534641, -1339.854119330558, 0.5451973168783405, 5.906528352206747e-07]),
    ([2.0, 0.1, 5.0, 0.0001], [0.9999999875000208, 9.999974958375104e-05, -0.0002499993739593776, 0.9999949875125417, 2.499995828130219e-09]),
    ([2.0, 0.1, 5.0, 0.6], [0.5868307900224737, 0.5063325923498294, -1.2658314808745736, 0.5615141604049823, 0.08263384199550526]),
    ([2.0, 0.1, 5.0, 0.65], [0.5218527253653336, 0.5327638866027135, -1.3319097165067837, 0.4952145310351979, 0.09562945492693328]),
    ([2.0, 9.0, 5.0, 0.27], [0.9376969157910622, 0.1516939086816451, -0.37923477170411274, 0.2550743267236593, 0.012460616841787554]),
    ([2.0, 9.0, 5.0, 0.3], [0.9260495795836442, 0.15868621149937054, -0.39671552874842636, 0.21196162783647673, 0.014790084083271168]),
    ([3.0, 0.7, 0.0, 1e-06], [1.0, 9.999998833333425e-07, 0.0, 0.9999997666666939, 1.6666665370370444e-13]),
    ([3.0, 0.7, 0.0, 4.0], [1.0, 2.6003969105631506, 0.0, 0.3932407208685983, 1.9994329849097854]),
    ([3.0, 0.7, 0.0, 5.0], [1.0, 2.95112904036601, 0.0, 0.3114032239145977, 2.926958513762843]),
    ([3.0, 0.7, 0.0, 100000.0], [1.0, 4.285714285714286, 0.0, 0.0, 142851.02040816328]),
    ([1e-12, 3e-09, 0.004, 2e-05], [0.3145182014584765, 1.4634301289255908e-05, -58537.205157023636, 0.27061529759070874, 171.37044963538088]),
    ([5.0, 1e-40, 1e-30, 1e+20], [-0.7051751781242741, -1585446259192342.0, 3.170892518384684e-16, -0.7051751781242741, 1.705175178124274e+30]),
    ([7.0, 2.0, 1e-60, 1e+50], [0.99999999995, 3.499999999825, -4.99999999975e-61, -1.7499999999125e-60, 4.999999999875e+49]),
];

#[test]
fn keeps_every_digit_at_the_extremes() {
    for ([mass, damping, stiffness, t], truths) in TRUTHS {
        let system = one(*mass, *damping, *stiffness);
        let released = system.free(1.0, 0.0, *t);
        let pushed = system.free(0.0, 1.0, *t);
        let values = [
            released.displacement,
            pushed.displacement,
            released.velocity,
            pushed.velocity,
            system.step(1.0, *t).displacement,
        ];
        for (value, truth) in values.into_iter().zip(truths) {
            assert_close(value, *truth, 3.0 * ULP);
        }
    }
}

#[test]
fn the_kind_of_damping_is_decided_exactly() {
    let critical = |mass: f64, damping: f64, stiffness: f64| {
        let next = damping.next_up();
        let before = damping.next_down();
        [before, damping, next].map(|damping| one(mass, damping, stiffness).damping())
    };
    let around = [Damping::Underdamped, Damping::Critical, Damping::Overdamped];
    assert_eq!(critical(1.0, 4.0, 4.0), around);
    // 2·√(0.3·0.3) is exactly twice the double 0.3.
    assert_eq!(critical(0.3, 0.6, 0.3), around);
    assert_eq!(critical(1e-40, 2e-3 * 1e3 * 1e-40, 1e-40), around);
    assert_eq!(one(1.0, 0.0, 4.0).damping(), Damping::Undamped);
    assert_eq!(one(1.0, 1e-70, 4.0).damping(), Damping::Underdamped);
    assert_eq!(one(1.0, 3.0, 0.0).damping(), Damping::Unsupported);
    assert_eq!(one(1.0, 0.0, 0.0).damping(), Damping::Unsupported);
}

/// Each formula of [`MassSpringDamper::free`] as it is written there.
#[test]
fn documented_free_motions_hold() {
    let (mass, t) = (2.0, 0.7);
    for (damping, stiffness) in [(0.3, 5.0), (3.0, 5.0), (1e-6, 40.0)] {
        let omega = f64::sqrt(stiffness / mass);
        let zeta = damping / (2.0 * f64::sqrt(stiffness * mass));
        let damped = omega * f64::sqrt(1.0 - zeta * zeta);
        let theta = zeta.acos();
        let x =
            (-zeta * omega * t).exp() / f64::sqrt(1.0 - zeta * zeta) * (damped * t + theta).sin();
        let released = one(mass, damping, stiffness).free(1.5, 0.0, t);
        assert_close(released.displacement, 1.5 * x, 1e-14);
    }
    let (x0, v0) = (0.3, -1.1);
    let omega = f64::sqrt(5.0 / mass);
    let undamped = one(mass, 0.0, 5.0).free(x0, v0, t).displacement;
    assert_close(
        undamped,
        x0 * (omega * t).cos() + v0 / omega * (omega * t).sin(),
        1e-14,
    );
    // m = 2, k = 8, so that ω = 2 and critical damping is 8.
    let critical = one(mass, 8.0, 8.0).free(x0, v0, t).displacement;
    assert_close(
        critical,
        (x0 + (v0 + 2.0 * x0) * t) * (-2.0 * t).exp(),
        1e-14,
    );
    for damping in [9.0, 80.0] {
        let root = f64::sqrt(damping * damping - 4.0 * mass * 8.0);
        let b = (damping + root) / (2.0 * mass);
        let a = 2.0 * 8.0 / (damping + root);
        let x = ((v0 + b * x0) * (-a * t).exp() - (v0 + a * x0) * (-b * t).exp()) / (b - a);
        let overdamped = one(mass, damping, 8.0).free(x0, v0, t);
        assert_close(overdamped.displacement, x, 1e-13);
    }
    let drifting = one(mass, 0.0, 0.0).free(x0, v0, t).displacement;
    assert_close(drifting, x0 + v0 * t, 1e-15);
    let braked = one(mass, 3.0, 0.0).free(x0, v0, t).displacement;
    let decay = 1.0 - f64::exp(-3.0 * t / mass);
    assert_close(braked, x0 + v0 * decay * mass / 3.0, 1e-14);
}

/// Each formula of [`MassSpringDamper::step`] and [`MassSpringDamper::impulse`].
#[test]
fn documented_forced_motions_hold() {
    let (mass, t, force) = (2.0, 3.1, 7.0);
    for damping in [0.0, 0.3, 8.0, 80.0] {
        let system = one(mass, damping, 8.0);
        let released = system.free(1.0, 0.0, t).displacement;
        let pushed = system.step(force, t).displacement;
        assert_close(pushed, force / 8.0 * (1.0 - released), 1e-14);
        let moved = system.impulse(force, t);
        assert_eq!(moved, system.free(0.0, force / mass, t));
    }
    assert_close(
        one(mass, 0.0, 0.0).step(force, t).displacement,
        force * t * t / (2.0 * mass),
        1e-15,
    );
    let h = 3.0 * t / mass;
    assert_close(
        one(mass, 3.0, 0.0).step(force, t).displacement,
        force * mass / 9.0 * (h - 1.0 + (-h).exp()),
        1e-14,
    );
    assert_eq!(one(1.0, 0.0, 4.0).step(force, -0.1), Default::default());
    assert_eq!(one(1.0, 0.0, 4.0).impulse(force, -0.1), Default::default());
}

proptest! {
    /// The equation of motion itself, for free motion, impulse and step at once.
    #[test]
    fn obeys_newton(
        mass in 0.01..100.0f64,
        ratio in prop_oneof![Just(0.0), Just(1.0), 0.0..3.0f64, 0.999_999..1.000_001f64],
        stiffness in prop_oneof![Just(0.0), 0.01..100.0f64],
        x0 in -1.0..1.0f64, v0 in -1.0..1.0f64, force in -1.0..1.0f64, t in 0.0..20.0f64,
    ) {
        let damping = ratio * 2.0 * f64::sqrt(mass * stiffness.max(0.01));
        let system = one(mass, damping, stiffness);
        let moving = system.free(x0, v0, t) + system.impulse(force, t) + system.step(force, t);
        let pulls = [
            mass * moving.acceleration,
            damping * moving.velocity,
            stiffness * moving.displacement,
        ];
        let rest = pulls.iter().sum::<f64>() - force;
        // Superposed motions may cancel: the scale is that of their parts.
        let rate = f64::sqrt(stiffness.max(0.01) / mass) * (1.0 + ratio);
        let speed = v0.abs() + force.abs() / mass * (1.0 + 1.0 / rate) + rate * x0.abs();
        let scale = (mass * rate + damping + stiffness / rate) * speed + force.abs() + stiffness * x0.abs();
        prop_assert!(rest.abs() <= 40.0 * ULP * scale, "{} of {}", rest, scale);
    }

    /// Going on from where it is gives the same motion.
    #[test]
    fn free_motion_is_a_flow(
        ratio in prop_oneof![Just(0.0), Just(1.0), 0.0..3.0f64],
        x0 in -1.0..1.0f64, v0 in -1.0..1.0f64, first in 0u32..4000, second in 0u32..4000,
    ) {
        let system = one(1.0, 2.0 * ratio, 1.0);
        let [first, second] = [first, second].map(|k| f64::from(k) / 256.0);
        let there = system.free(x0, v0, first);
        let on = system.free(there.displacement, there.velocity, second);
        let whole = system.free(x0, v0, first + second);
        let scale = 100.0 * ULP * (x0.abs() + v0.abs());
        prop_assert!((on.displacement - whole.displacement).abs() <= scale);
        prop_assert!((on.velocity - whole.velocity).abs() <= scale);
    }
}

#[test]
fn refuses_coefficients_out_of_range() {
    let wrong = |mass, damping, stiffness| MassSpringDamper::new(mass, damping, stiffness).err();
    assert_eq!(
        wrong(0.0, 1.0, 1.0),
        Some(OneMassError::Mass { value: 0.0 })
    );
    assert_eq!(
        wrong(1.0, -1.0, 1.0),
        Some(OneMassError::Damping { value: -1.0 })
    );
    assert_eq!(
        wrong(1.0, 1.0, 1e-71),
        Some(OneMassError::Stiffness { value: 1e-71 })
    );
    assert!(wrong(f64::NAN, 1.0, 1.0).is_some() && wrong(1.0, f64::INFINITY, 1.0).is_some());
}

/// A value printed in a manual, whose last digit stands for `unit`; some are cut, not rounded.
#[track_caller]
fn assert_printed(value: f64, published: f64, unit: f64) {
    assert!((value - published).abs() <= unit, "{value}, {published}");
}

/// x(.09) of a mass released from 1 m: ANSYS Mechanical APDL Verification Manual, VM71.
#[test]
fn reproduces_vm71() {
    let after = |damping| {
        one(0.02590673, damping, 30.0)
            .free(1.0, 0.0, 0.09)
            .displacement
    };
    assert_printed(after(3.52636), 0.4742, 1e-4);
    assert_printed(after(1.76318), 0.18998, 1e-5);
    assert_printed(after(0.352636), -0.52108, 1e-5);
    assert_printed(after(0.0), -0.99688, 1e-5);
}

/// The answer to an impulse of 10: VM74.
#[test]
fn reproduces_vm74() {
    let after = |damping, t| one(0.5, damping, 200.0).impulse(10.0, t).displacement;
    assert_printed(after(0.0, 0.08), 0.99957, 1e-5);
    assert_printed(after(0.0, 0.1), 0.90930, 1e-5);
    assert_printed(after(14.0, 0.1), 0.34180, 1e-5);
}

/// The answer to a step of 200: VM75.
#[test]
fn reproduces_vm75() {
    let after = |damping, t| one(0.5, damping, 200.0).step(200.0, t).displacement;
    assert_close(after(0.0, std::f64::consts::PI / 20.0), 2.0, ULP);
    assert_printed(after(0.0, 0.2), 1.6536, 1e-4);
    assert_printed(after(10.0, 0.2), 1.1531, 1e-4);
}

fn run(problem: Result<Problem<'_>, ResponseError>) -> Trajectory {
    OneMass.run(&problem.expect("valid")).expect("applies")
}

/// Loads at an instant of the grid act there, exactly; others wherever they are; those from before
/// 0 are already running.
#[test]
fn superposes_steps_and_impulses_at_their_instants() {
    let system = scenes::system(2.0, 0.3, 5.0);
    let loads: [(f64, Load); 5] = [
        (0.0, Step::of(1.0).starting_at(-3.0).into()),
        (0.3, Step::of(-2.0).starting_at(0.3).into()),
        (0.1 + 0.2, Impulse::of(0.7).at(0.1 + 0.2).into()),
        (0.55, Step::of(4.0).starting_at(0.55).into()),
        (1.0, Impulse::of(-0.2).at(1.0).into()),
    ];
    let mut response = Response::of(&system)
        .from(State::at_rest().displace("m1", 0.1).push("m1", -0.2))
        .every(0.1)
        .until(1.0)
        .with_acceleration();
    for (_, load) in &loads {
        response = response.load("m1", load.clone());
    }
    let answer = run(response.problem());
    let single = one(2.0, 0.3, 5.0);
    for index in 0..=10 {
        let t = index as f64 * 0.1;
        let mut sum = single.free(0.1, -0.2, t);
        for (start, load) in &loads {
            // 3·0.1 is the double after 0.3, and 0.1 + 0.2 is that double: the impulse hits the
            // third instant, the step comes 6e-17 s before.
            let elapsed = (t - start).max(if t >= *start { 0.0 } else { -1.0 });
            sum = sum
                + match load {
                    Load::Step(step) => single.step(step.force, elapsed),
                    Load::Impulse(impulse) => single.impulse(impulse.magnitude, elapsed),
                    _ => unreachable!("listed above"),
                };
        }
        let column = index as usize;
        let acceleration = answer.acceleration().expect("asked for")[(0, column)];
        assert!((answer.displacement()[(0, column)] - sum.displacement).abs() < 4.0 * ULP);
        assert!((answer.velocity()[(0, column)] - sum.velocity).abs() < 8.0 * ULP);
        assert!((acceleration - sum.acceleration).abs() < 32.0 * ULP);
    }
}

/// Parallel elements and an added matrix are summed without rounding: 1e16 springs of 1 beside one
/// of 1 leave a frequency that a rounded sum would miss by 1e-16, seen after 1e12 oscillations.
#[test]
fn sums_parallel_elements_exactly() {
    let system = System::builder()
        .mass("m1", 1.0)
        .spring(GROUND, "m1", 1e16)
        .spring("m1", GROUND, 1.0)
        .matrix(MatrixKind::Stiffness, mat![[-1e16]].as_ref())
        .build()
        .expect("valid");
    let response = Response::of(&system).from(State::at_rest().displace("m1", 1.0));
    let answer = run(response.every(0.5).until(10.0).problem());
    assert_close(answer.displacement()[(0, 20)], 10f64.cos(), ULP);
}

/// A phase of 2e9 rad keeps its digits.
#[test]
fn long_times_keep_their_phase() {
    let system = scenes::system(1.0, 0.0, 4.0);
    let response = Response::of(&system).from(State::at_rest().displace("m1", 1.0));
    let problem = response.every(0.1).until(1e9).problem().expect("valid");
    let problem = problem.at(&[10_000_000_000]).expect("in range");
    let answer = OneMass.run(&problem).expect("applies");
    // cos(2·10^10·h), where h is the double nearest to 0.1.
    let truth = 0.4041097558346262;
    assert_close(answer.displacement()[(0, 0)], truth, ULP);
}

#[test]
fn says_why_it_refuses() {
    let refused = |system: &System, load: Option<Load>| {
        let mut response = Response::of(system).every(0.5).until(1.0);
        if let Some(load) = load {
            response = response.load(system.names()[0].clone(), load);
        }
        let problem = response.problem().expect("valid");
        let reason = OneMass.refuses(&problem).expect("refuses");
        let error = OneMass.run(&problem).expect_err("refuses");
        assert!(
            matches!(error, ResponseError::NotApplicable { .. }),
            "{error}"
        );
        reason
    };
    let one = scenes::system(1.0, 0.5, 4.0);
    let samples = Samples {
        step: 0.5,
        values: vec![1.0],
        hold: Hold::Zero,
    };
    assert!(refused(&one, Some(Ramp::of(1.0).into())).contains("load 0 is a ramp"));
    assert!(refused(&one, Some(Harmonic::of(1.0, 1.0).into())).contains("harmonic"));
    assert!(refused(&one, Some(samples.into())).contains("samples"));
    let polynomial = Polynomial {
        coefficients: vec![1.0, 2.0, 3.0],
        start: 0.0,
    };
    assert!(refused(&one, Some(polynomial.into())).contains("polynomial loads are not covered"));
    // Its motion is not 0, and there is no load on the mass itself.
    let moved = System::builder()
        .mass("m1", 1.0)
        .support("s")
        .spring("s", "m1", 4.0)
        .point("p", [("m1", 2.0)], 0.0)
        .build()
        .expect("valid");
    let ask = || Response::of(&moved).every(0.5).until(1.0);
    let support = ask().motion("s", Quantity::Displacement, Step::of(1.0));
    for response in [support, ask().load("p", Step::of(1.0))] {
        let reason = OneMass.refuses(&response.problem().expect("valid"));
        let right = "motions of supports, forces on points and polynomial loads are not covered";
        assert_eq!(reason.as_deref(), Some(right));
    }
    assert!(refused(&scenes::system(1.0, -0.5, 4.0), None).contains("damping is -0.5"));
    assert!(refused(&scenes::system(0.0, 0.5, 4.0), None).contains("mass is 0"));
    let two = System::builder()
        .mass("a", 1.0)
        .mass("b", 1.0)
        .spring("a", "b", 1.0);
    assert!(refused(&two.build().expect("valid"), None).contains("2 coordinates"));
    let resonance = RESONANCE.system();
    assert!(OneMass.refuses(&RESONANCE.problem(&resonance)).is_some());
    let fast = scenes::system(1e-40, 0.0, 1e40);
    assert!(refused(&fast, None).contains("phase"));
}

#[test]
fn reports_a_motion_beyond_doubles() {
    let system = scenes::system(1e-60, 0.0, 0.0);
    let response = Response::of(&system).load("m1", Step::of(1e300));
    let error = OneMass.run(&response.every(1.0).until(3.0).problem().expect("valid"));
    assert_eq!(error, Err(ResponseError::Overflow { index: 0 }));
}
