//! Forces on points, motions of supports, pulses, and sums of motions.

use eigentone_modes::{Bounds, GROUND, Precision, System};
use eigentone_response::{
    ByCertifiedExponential, ByExponential, BySuperposition, HalfSine, Harmonic, Hold, Impulse,
    Load, LoadError, ModalTruncation, Output, Polynomial, Quantity, Ramp, Response, ResponseError,
    ResponseMethod, Samples, State, Step, Summary, Sweep, Versine,
};
use eigentone_response::{Destination, Trajectory};

use crate::systems::{answers, car, in_a_row, quarter_car};

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |top, value| top.max(value.abs()))
}

fn asked(system: &System) -> Response<'_> {
    Response::of(system).every(0.01).until(2.0)
}

/// Differences of motions, pulls and accelerations are those that the coordinates give, and their bounds hold.
#[test]
fn sums_and_pulls_are_what_they_say() {
    let car = quarter_car();
    let road = Versine::of(0.05, 0.25).starting_at(0.5);
    let ask = asked(&car)
        .motion("road", Quantity::Displacement, road)
        .sum(
            "travel",
            [
                (Quantity::Displacement, "body", 1.0),
                (Quantity::Displacement, "wheel", -1.0),
            ],
        )
        .sum(
            "over the road",
            [
                (Quantity::Displacement, "wheel", 1.0),
                (Quantity::Displacement, "road", -1.0),
            ],
        )
        .sum("comfort", [(Quantity::Acceleration, "body", 1.0)])
        .pull("tyre", "tyre")
        .pull("absorber", "shock absorber")
        .with_acceleration();
    for (method, proven) in [
        (&ByCertifiedExponential as &dyn ResponseMethod, true),
        (&ByExponential, false),
        (&BySuperposition, false),
    ] {
        let motion = ask.clone().run_by(method).expect("a motion");
        assert_eq!(motion.bounds() == Bounds::Proven, proven);
        let names: Vec<&str> = motion.outputs().collect();
        assert_eq!(
            names,
            ["travel", "over the road", "comfort", "tyre", "absorber"]
        );
        let (x, v) = (motion.displacement(), motion.velocity());
        let a = motion.acceleration().expect("asked for");
        for (k, &t) in motion.times().iter().enumerate() {
            let phase = std::f64::consts::TAU * (t - 0.5) / 0.25;
            let lasts = (0.5..0.75).contains(&t);
            let bump = if lasts {
                0.025 * (1.0 - phase.cos())
            } else {
                0.0
            };
            let wanted = [
                x[(0, k)] - x[(1, k)],
                x[(1, k)] - bump,
                a[(0, k)],
                // The tyre is between road and wheel.
                190_000.0 * (x[(1, k)] - bump),
                1000.0 * (v[(0, k)] - v[(1, k)]),
            ];
            for (row, wanted) in wanted.into_iter().enumerate() {
                let found = motion.output(row)[k];
                let bound = motion.output_bound(row)[k].expect("a bound");
                let largest = largest(motion.output(row));
                let off = (found - wanted).abs();
                assert!(off < 1e-12 * largest, "{row} at {k}: {found} {wanted}");
                let limit = if proven { 1e-15 } else { 1e-8 };
                assert!(
                    bound <= limit * largest,
                    "{row} at {k}: {bound:e} of {largest:e}"
                );
            }
        }
    }
}

/// The motion of what the ground shakes, seen from the ground, is that of forces −m u″; its bound is relative to its own
/// size, however far the ground has moved.
#[test]
fn relative_motion_keeps_its_digits_far_away() {
    let tower = System::builder()
        .mass("floor", 3.0)
        .mass("roof", 2.0)
        .support("soil")
        .spring("soil", "floor", 700.0)
        .damper("soil", "floor", 5.0)
        .spring("floor", "roof", 500.0)
        .damper("floor", "roof", 3.0)
        .build()
        .expect("a system");
    let fixed = in_a_row(
        &[("floor", 3.0), ("roof", 2.0)],
        &[700.0, 500.0],
        &[5.0, 3.0],
    );
    let record = |factor: f64| Samples {
        step: 0.02,
        values: (0..400)
            .map(|j| factor * f64::from(j * 37 % 101) / 64.0)
            .collect(),
        hold: Hold::First,
    };
    let drift = [
        (Quantity::Displacement, "roof", 1.0),
        (Quantity::Displacement, "soil", -1.0),
    ];
    let shaken = Response::of(&tower).motion("soil", Quantity::Acceleration, record(1.0));
    let shaken = shaken
        .sum("drift", drift)
        .every(0.02)
        .until(8.0)
        .run()
        .expect("a motion");
    let pushed = Response::of(&fixed)
        .load("floor", record(-3.0))
        .load("roof", record(-2.0));
    let pushed = pushed.every(0.02).until(8.0).run().expect("a motion");
    assert_eq!(shaken.bounds(), Bounds::Proven);
    for k in 1..shaken.len() {
        let (found, wanted) = (shaken.output(0)[k], pushed.displacement()[(1, k)]);
        let bound = shaken.output_bound(0)[k].expect("proven");
        let other = pushed.displacement_bound()[k].expect("proven");
        let off = (found - wanted).abs();
        assert!(off <= bound + other, "{k}: {found} {wanted} {bound:e}");
        assert!(bound <= 2.3e-16 * wanted.abs().max(1e-4), "{k}: {bound:e}");
    }
    // By then the soil is far away.
    assert!(shaken.displacement()[(1, 400)] > 20.0 && shaken.output(0)[400].abs() < 0.1);
    // In doubles the estimate is honest about it.
    let doubles = Response::of(&tower).motion("soil", Quantity::Acceleration, record(1.0));
    let doubles = doubles
        .sum("drift", drift)
        .every(0.02)
        .until(8.0)
        .to(Precision::Double);
    let doubles = doubles.run().expect("a motion");
    for k in 0..doubles.len() {
        let off = (doubles.output(0)[k] - shaken.output(0)[k]).abs();
        let bound = doubles.output_bound(0)[k];
        assert!(
            bound.is_none_or(|bound| off <= bound),
            "{k}: {off:e} {bound:?}"
        );
        assert!(off < 1e-11, "{k}: {off:e}");
    }
}

/// A displacement that jumps passes an impulse −c u through the damper: the motion of a system at rest whose frame jumps.
#[test]
fn a_jump_of_the_road_is_a_jump_of_the_frame() {
    let car = quarter_car();
    let kerb = asked(&car).motion("road", Quantity::Displacement, Step::of(0.08));
    let kerb = kerb.run().expect("a motion");
    let fixed = System::builder()
        .mass("body", 290.0)
        .mass("wheel", 59.0)
        .spring("wheel", "body", 16812.0)
        .damper("wheel", "body", 1000.0)
        .spring(GROUND, "wheel", 190_000.0)
        .damper(GROUND, "wheel", 50.0)
        .build()
        .expect("a system");
    let start = State::at_rest()
        .displace("body", -0.08)
        .displace("wheel", -0.08);
    let frame = asked(&fixed)
        .from(start)
        .load("wheel", Impulse::of(0.08 * 50.0));
    let frame = frame.run().expect("a motion");
    for k in 0..kerb.len() {
        for i in 0..2 {
            let (x, y) = (kerb.displacement()[(i, k)], frame.displacement()[(i, k)]);
            assert!((x - 0.08 - y).abs() < 1e-16 * 3.0, "{i} {k}: {x} {y}");
            let (x, y) = (kerb.velocity()[(i, k)], frame.velocity()[(i, k)]);
            assert!((x - y).abs() < 1e-14, "{i} {k}: {x} {y}");
        }
    }
}

fn lever() -> System {
    System::builder()
        .mass("heave", 4.0)
        .mass("pitch", 1.5)
        .point("front", [("heave", 1.0), ("pitch", -1.1)], 0.0)
        .point("rear", [("heave", 1.0), ("pitch", 1.4)], 0.5)
        .spring(GROUND, "front", 300.0)
        .damper(GROUND, "front", 2.0)
        .spring(GROUND, "rear", 200.0)
        .build()
        .expect("a system")
}

/// A force on a point is shared out: the same as forces on the coordinates.
#[test]
fn forces_on_points_are_shared() {
    let system = lever();
    let (step, pulse) = (Step::of(2.0), HalfSine::of(8.0, 0.5).starting_at(0.25));
    let wave = Harmonic::of(4.0, 3.0).with_phase(0.5);
    let impulse = Impulse::of(0.5).at(0.75);
    let on_point = asked(&system).load("rear", step).load("rear", pulse);
    let on_point = on_point
        .load("rear", wave)
        .load("rear", impulse)
        .load("front", Ramp::of(0.5));
    let mut shared = asked(&system)
        .load("heave", Ramp::of(0.5))
        .load("pitch", Ramp::of(-0.5 * 1.1));
    for (on, share) in [("heave", 1.0), ("pitch", 1.4)] {
        let (force, amplitude, magnitude) = (8.0 * share, 4.0 * share, 0.5 * share);
        shared = shared
            .load(on, Step::of(2.0 * share))
            .load(on, HalfSine { force, ..pulse })
            .load(on, Harmonic { amplitude, ..wave })
            .load(
                on,
                Impulse {
                    magnitude,
                    ..impulse
                },
            );
    }
    let close = |one: &Trajectory, other: &Trajectory| {
        (one.displacement() - other.displacement()).norm_max() < 1e-14
            && (one.velocity() - other.velocity()).norm_max() < 1e-13
    };
    let shared = shared.run().expect("a motion");
    for method in [
        &ByCertifiedExponential as &dyn ResponseMethod,
        &ByExponential,
        &BySuperposition,
    ] {
        let motion = on_point.clone().run_by(method).expect("a motion");
        assert!(close(&motion, &shared), "{}", method.name());
    }
}

/// Where a road leads is where the car comes to rest, and a road that goes on takes it along.
#[test]
fn summaries_know_where_supports_lead() {
    let car = quarter_car();
    let modes = car.modes().expect("modes");
    let rest = |quantity, load: eigentone_response::Load| {
        let problem = Response::of(&car).motion("road", quantity, load);
        let problem = problem
            .every(0.05)
            .until(40.0)
            .problem()
            .expect("a problem");
        let motion = ByCertifiedExponential.run(&problem).expect("a motion");
        Summary::of(&problem, &motion, &modes)
            .expect("instants")
            .coordinates()[0]
            .destination
    };
    match rest(Quantity::Displacement, Step::of(0.08).into()) {
        Destination::Rest { displacement, .. } => assert!((displacement - 0.08).abs() < 1e-12),
        other => panic!("{other:?}"),
    }
    match rest(Quantity::Velocity, HalfSine::of(0.08, 0.5).into()) {
        Destination::Rest { displacement, .. } => {
            let way = 0.08 * 0.5 * 2.0 / std::f64::consts::PI;
            assert!((displacement - way).abs() < 1e-12, "{displacement}");
        }
        other => panic!("{other:?}"),
    }
    assert!(matches!(
        rest(Quantity::Displacement, Ramp::of(0.1).into()),
        Destination::Drift
    ));
    assert!(matches!(
        rest(Quantity::Velocity, Step::of(0.1).into()),
        Destination::Drift
    ));
    assert!(matches!(
        rest(Quantity::Displacement, Harmonic::of(0.1, 9.0).into()),
        Destination::Oscillation
    ));
}

/// A body that its road takes along does not turn: what rounding leaves of that in an equilibrium is no drift.
#[test]
fn rounding_is_no_drift() {
    let system = System::builder()
        .mass("heave", 1000.0)
        .mass("pitch", 1200.0)
        .point("front", [("heave", 1.0), ("pitch", -1.1)], 0.0)
        .point("middle", [("heave", 1.0), ("pitch", 0.3)], 75.0)
        .point("rear", [("heave", 1.0), ("pitch", 1.4)], 0.0)
        .support("road")
        .spring("road", "front", 21000.0)
        .spring("road", "middle", 731.0)
        .spring("road", "rear", 24000.0)
        .damper("road", "front", 1400.0)
        .damper("road", "rear", 1700.0)
        .build()
        .expect("a system");
    let modes = system.modes().expect("modes");
    let ask = Response::of(&system).motion("road", Quantity::Velocity, Step::of(0.1));
    let problem = ask.every(0.05).until(20.0).problem().expect("a problem");
    let motion = ByCertifiedExponential.run(&problem).expect("a motion");
    let summary = Summary::of(&problem, &motion, &modes).expect("instants");
    let [heave, pitch] = [0, 1].map(|i| summary.coordinates()[i].destination);
    assert!(matches!(heave, Destination::Drift), "{heave:?}");
    match pitch {
        Destination::Rest { displacement, .. } => assert!(displacement.abs() < 1e-12, "{pitch:?}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let car = quarter_car();
    // Neither sweeps nor truncated modes know of supports, or keep more than displacements and velocities.
    let driven = asked(&car).motion("road", Quantity::Displacement, Step::of(1.0));
    for ask in [driven, asked(&car).with_forces()] {
        let problem = ask.problem().expect("a problem");
        assert!(Sweep::of(&problem).is_err());
        let truncated = ModalTruncation { modes: 1 }.run(&problem);
        assert!(matches!(
            truncated,
            Err(ResponseError::NotApplicable { .. })
        ));
    }
    let wrong = |ask: Response<'_>| ask.problem().map(|_| ()).expect_err("refused");
    let moved =
        |name: &str, load: Load| wrong(asked(&car).motion(name, Quantity::Displacement, load));
    assert!(matches!(
        moved("body", Step::of(1.0).into()),
        ResponseError::UnknownSupport { .. }
    ));
    let early = HalfSine::of(1.0, 0.5).starting_at(-0.1);
    let wrong_loads: [(Load, LoadError); 3] = [
        (Impulse::of(1.0).into(), LoadError::ImpulseOfMotion),
        (early.into(), LoadError::PulseBeforeStart { start: -0.1 }),
        (
            Versine::of(1.0, 0.0).into(),
            LoadError::Duration { duration: 0.0 },
        ),
    ];
    for (load, error) in wrong_loads {
        assert_eq!(
            moved("road", load),
            ResponseError::Motion { index: 0, error }
        );
    }
    let roof = [(Quantity::Velocity, "roof", 1.0)];
    for ask in [asked(&car).pull("f", "spring"), asked(&car).sum("f", roof)] {
        let unknown = wrong(ask);
        let is_named = matches!(unknown, ResponseError::Combination { index: 0, .. });
        assert!(is_named, "{unknown}");
    }
    let carried = System::builder()
        .mass("x", 1.0)
        .support("s")
        .point("p", [("x", 1.0), ("s", 1.0)], 1.0)
        .spring("x", GROUND, 1.0)
        .build()
        .expect("a system");
    let jump = asked(&carried).motion("s", Quantity::Displacement, Step::of(1.0));
    let ResponseError::Motion { index: 0, error } = wrong(jump) else {
        panic!("another error")
    };
    assert!(matches!(error, LoadError::JumpOfMass { .. }), "{error}");
    // A damper passes the jump on to a node on which another one pushes as much.
    let massless = System::builder()
        .mass("a", 1.0)
        .mass("p", 0.0)
        .support("s")
        .spring("a", "p", 1.0)
        .spring("p", GROUND, 1.0)
        .damper("s", "p", 1.0)
        .damper("p", GROUND, -1.0)
        .build()
        .expect("a system");
    let jump = asked(&massless).motion("s", Quantity::Displacement, Step::of(1.0));
    let (support, name) = ("s".to_owned(), "p".to_owned());
    assert_eq!(
        jump.run(),
        Err(ResponseError::JumpOnMassless { support, name })
    );
}

/// Chosen outputs along a long road are those of the whole motion.
#[test]
fn long_roads_are_followed_in_strides() {
    let car = car().build().expect("a system");
    for hold in [Hold::Zero, Hold::First] {
        let road = Samples {
            step: 0.01,
            values: (0..3000)
                .map(|j| f64::from(j * 7919 % 1009) / 2e4)
                .collect(),
            hold,
        };
        let ask = Response::of(&car).motion("road", Quantity::Displacement, road);
        let ask = ask
            .load("body", Step::of(9.0))
            .every(0.01)
            .until(40.0)
            .to(Precision::Double);
        let outputs = [Output::Displacement(0), Output::Velocity(1)];
        let history = ask.clone().follow(&outputs).expect("a history");
        let whole = ask.run_by(&ByCertifiedExponential).expect("a motion");
        for k in 0..whole.len() {
            let (x, v) = (whole.displacement()[(0, k)], whole.velocity()[(1, k)]);
            assert!((history.values()[(0, k)] - x).abs() < 1e-14, "{hold:?} {k}");
            assert!((history.values()[(1, k)] - v).abs() < 1e-12, "{hold:?} {k}");
        }
    }
}

/// With a damper at the road, and as an acceleration, the whole of a long motion and sums of it are taken in strides too: within
/// their estimates of what is proven, to 1e-12 of their size.
#[test]
fn long_motions_are_whole_in_strides() {
    let car = quarter_car();
    let values = (0..3000).map(|j| f64::from(j * 7919 % 1009 - 504) / 2e4);
    let road = Samples {
        step: 0.02,
        values: values.collect(),
        hold: Hold::First,
    };
    for quantity in [
        Quantity::Displacement,
        Quantity::Velocity,
        Quantity::Acceleration,
    ] {
        let ask = Response::of(&car)
            .motion("road", quantity, road.clone())
            .load("body", Step::of(9.0).starting_at(0.5))
            .every(0.01)
            .until(65.0);
        let ask = match quantity {
            Quantity::Displacement => ask.pull("tyre", "tyre").sum(
                "over the road",
                [
                    (Quantity::Velocity, "wheel", 1.0),
                    (Quantity::Velocity, "road", -1.0),
                ],
            ),
            _ => ask.pull("suspension", "suspension"),
        };
        let quick = ask.clone().run_by(&ByExponential).expect("a motion");
        let proven = ask.run_by(&ByCertifiedExponential).expect("a motion");
        assert!(
            quick.operations().steps < 6_500 / 2,
            "{:?}",
            quick.operations()
        );
        let near = |found: f64, wanted: f64, bound: Option<f64>, size: f64| {
            let off = (found - wanted).abs();
            assert!(
                off <= bound.expect("an estimate") && off <= 1e-12 * size,
                "{off:e} of {size}"
            );
        };
        let both = [&quick, &proven];
        let x = proven.displacement().norm_max();
        let v = proven.velocity().norm_max();
        for k in 0..proven.len() {
            for i in 0..2 {
                let [found, wanted] = both.map(|motion| motion.displacement()[(i, k)]);
                near(found, wanted, quick.displacement_bound()[k], x);
                let [found, wanted] = both.map(|motion| motion.velocity()[(i, k)]);
                near(found, wanted, quick.velocity_bound()[k], v);
            }
            for row in 0..proven.outputs().count() {
                let size = largest(proven.output(row));
                let [found, wanted] = both.map(|motion| motion.output(row)[k]);
                near(found, wanted, quick.output_bound(row)[k], size);
            }
        }
    }
}

/// What a support moves that is given by its velocity or acceleration drives real and complex modes alike: samples, pulses,
/// sinusoids slow and fast, and powers of time.
#[test]
fn modes_follow_what_is_integrated() {
    let tower = |factor: f64| {
        System::builder()
            .mass("floor", 3.0)
            .mass("roof", 2.0)
            .support("soil")
            .spring("soil", "floor", 700.0)
            .damper("soil", "floor", factor * 700.0 / 1024.0)
            .spring("floor", "roof", 500.0)
            .damper("floor", "roof", 500.0 / 1024.0)
            .point("carried", [("floor", 0.5), ("soil", 0.5)], 0.8)
            .build()
            .expect("a system")
    };
    let record = |hold| Samples {
        step: 0.04,
        values: (0..90).map(|j| f64::from(j * 37 % 101) / 64.0).collect(),
        hold,
    };
    let kinds: [eigentone_response::Load; 7] = [
        record(Hold::First).into(),
        record(Hold::Zero).into(),
        Harmonic::of(0.5, 1e-7).with_phase(0.3).into(),
        Harmonic::of(0.5, 40.0).into(),
        HalfSine::of(2.0, 0.33).starting_at(0.21).into(),
        Versine::of(2.0, 3.0).into(),
        Polynomial::of([0.1, 0.2, 0.0, -0.05])
            .starting_at(0.5)
            .into(),
    ];
    // With 1 the damping is that of the springs, with 3 it couples the modes.
    for factor in [1.0, 3.0] {
        let system = tower(factor);
        assert_eq!(system.structure().is_classical(), factor == 1.0);
        for kind in &kinds {
            for quantity in [Quantity::Velocity, Quantity::Acceleration] {
                let ask = Response::of(&system)
                    .motion("soil", quantity, kind.clone())
                    .from(State::at_rest().displace("roof", 0.1))
                    .sum(
                        "drift",
                        [
                            (Quantity::Displacement, "roof", 1.0),
                            (Quantity::Displacement, "soil", -1.0),
                        ],
                    )
                    .every(0.02)
                    .until(4.0)
                    .with_acceleration();
                let modal = ask.clone().run_by(&BySuperposition).expect("a motion");
                let proven = ask.run_by(&ByCertifiedExponential).expect("a motion");
                let size = proven.displacement().norm_max();
                let near = |off: f64, bound: Option<f64>, k: usize| {
                    let is_near = off.abs() <= bound.expect("an estimate");
                    assert!(is_near, "{kind:?} {quantity:?} {k}: {off:e}");
                };
                for k in 0..proven.len() {
                    for i in 0..2 {
                        let off = modal.displacement()[(i, k)] - proven.displacement()[(i, k)];
                        near(off, modal.displacement_bound()[k], k);
                        near(off, Some(1e-12 * size), k);
                        let off = modal.velocity()[(i, k)] - proven.velocity()[(i, k)];
                        near(off, modal.velocity_bound()[k], k);
                    }
                    let off = modal.output(0)[k] - proven.output(0)[k];
                    near(off, modal.output_bound(0)[k], k);
                }
            }
        }
    }
}

/// The chain of SDLD02, 8 masses of 10 kg and 9 springs of 1e5 N/m, between ends that are both moved with the acceleration
/// 2e5·t². Displacement, velocity and the motion relative to the ends, from the closed form by modes with 60 digits:
/// y = −Σ φⱼ Γⱼ a (t²/ω² − 2/ω⁴·(1 − cos ωt)) beside a t⁴/12.
#[test]
fn a_chain_follows_ends_whose_acceleration_is_a_polynomial() {
    const WANTED: [(usize, [[f64; 3]; 4]); 3] = [
        (
            8,
            [
                [0.12750154915719777, 9.6638252704243, -0.12681160188446888],
                [0.05580913151138504, 5.16152952673473, -0.19850401953028163],
                [
                    0.02045510583766064,
                    2.3785932132504395,
                    -0.23385804520400602,
                ],
                [
                    0.007120327299814155,
                    1.0625848171113879,
                    -0.2471928237418525,
                ],
            ],
        ),
        (
            32,
            [
                [60.31008305190275, 1004.4436297926064, -4.794083614763917],
                [56.74098701258156, 976.8738886248817, -8.363179654085107],
                [54.37541601113694, 958.7028299632298, -10.728750655529726],
                [53.196868209065094, 949.7037924508606, -11.90729845760157],
            ],
        ),
        (
            64,
            [
                [1021.775129740398, 8249.21576232589, -19.89153692626863],
                [1006.8702762912146, 8185.58604261615, -34.79639037545201],
                [996.9408931317662, 8142.931779404218, -44.7257735349005],
                [991.97859922906, 8121.573421550188, -49.68806743760667],
            ],
        ),
    ];
    let mut chain = System::builder().support("ends");
    let names: Vec<String> = (1..=8).map(|i| format!("m{i}")).collect();
    for name in &names {
        chain = chain.mass(name, 10.0);
    }
    let mut before = "ends";
    for name in names.iter().map(String::as_str).chain(["ends"]) {
        chain = chain.spring(before, name, 1e5);
        before = name;
    }
    let chain = chain.build().expect("a system");
    let swell = Polynomial::of([0.0, 0.0, 2e5]);
    let mut ask = Response::of(&chain).motion("ends", Quantity::Acceleration, swell);
    for name in &names {
        let relative = [(name.as_str(), 1.0), ("ends", -1.0)];
        let relative = relative.map(|(of, factor)| (Quantity::Displacement, of, factor));
        ask = ask.sum(name, relative);
    }
    let problem = ask
        .every(0.0078125)
        .until(0.5)
        .problem()
        .expect("a problem");
    let motion = ByCertifiedExponential.run(&problem).expect("a motion");
    let each = |(k, wanted): (usize, [[f64; 3]; 4])| {
        wanted
            .into_iter()
            .enumerate()
            .map(move |(i, wanted)| (k, i, wanted))
    };
    for (k, i, [x, v, y]) in WANTED.into_iter().flat_map(each) {
        let found = [
            (motion.displacement()[(i, k)], x),
            (motion.velocity()[(i, k)], v),
            (motion.output(i)[k], y),
        ];
        for (found, wanted) in found {
            let off = (found - wanted).abs();
            assert!(
                off <= 2.3e-16 * wanted.abs(),
                "{i} at {k}: {found:?} {wanted:?}"
            );
        }
        // Both halves of the chain move alike.
        assert_eq!(motion.output(i)[k], motion.output(7 - i)[k]);
        let bound = motion.output_bound(i)[k].expect("proven");
        assert!(bound <= 2.3e-16 * y.abs(), "{i} at {k}: {bound:e}");
    }
}

/// A polynomial of degree 1 is a step and a ramp, on a coordinate and at a point; one of degree 2 on a free mass is a
/// polynomial of degree 4.
#[test]
fn polynomials_are_what_they_say() {
    let system = lever();
    let all = |load: &dyn Fn(Response<'_>) -> Response<'_>| {
        let ask = load(Response::of(&system)).every(0.25).until(4.0);
        ask.run().expect("a motion")
    };
    for on in ["heave", "front"] {
        let whole = Polynomial::of([2.0, -3.0]).starting_at(0.4);
        let whole = all(&|ask| ask.load(on, whole.clone()));
        let parts = all(&|ask| {
            ask.load(on, Step::of(2.0).starting_at(0.4))
                .load(on, Ramp::of(-3.0).starting_at(0.4))
        });
        for k in 0..whole.len() {
            let bound = whole.displacement_bound()[k].expect("proven")
                + parts.displacement_bound()[k].expect("proven");
            for i in 0..2 {
                let off = (whole.displacement()[(i, k)] - parts.displacement()[(i, k)]).abs();
                assert!(off <= bound, "{on} {i} {k}: {off:e} {bound:e}");
            }
        }
    }
    let free = System::builder().mass("m", 3.0).build().expect("a system");
    let ask = Response::of(&free).load("m", Polynomial::of([0.0, 0.0, 1.0]));
    let ask = ask.every(0.5).until(3.0);
    for method in [
        &ByCertifiedExponential as &dyn ResponseMethod,
        &ByExponential,
    ] {
        let motion = ask.clone().run_by(method).expect("a motion");
        for (k, t) in motion.times().iter().enumerate() {
            let wanted = t.powi(4) / 36.0;
            let off = (motion.displacement()[(0, k)] - wanted).abs();
            assert!(off <= 1e-14 * wanted, "{k}: {off:e}");
        }
    }
    // Its bounds do not end where it does not.
    let summary = ask.problem().expect("a problem");
    let motion = ByCertifiedExponential.run(&summary).expect("a motion");
    let modes = free.modes().expect("modes");
    let summary = Summary::of(&summary, &motion, &modes).expect("instants");
    assert_eq!(summary.coordinates()[0].destination, Destination::Drift);
    assert!(matches!(
        Response::of(&free)
            .load("m", Polynomial::of([1.0; 8]))
            .every(0.5)
            .until(3.0)
            .run(),
        Err(ResponseError::Load {
            index: 0,
            error: LoadError::Coefficients { count: 8 }
        })
    ));
}

/// An impulse that nothing resists is named by its place among all loads, and is the one that acts at that instant.
#[test]
fn impulses_that_nothing_resists_are_named_as_given() {
    let system = System::builder()
        .mass("m", 1.0)
        .mass("p", 0.0)
        .point("half", [("m", 0.5), ("p", 0.5)], 0.0)
        .spring(GROUND, "m", 2.0)
        .spring("m", "p", 3.0)
        .build()
        .expect("a system");
    let ask = || {
        Response::of(&system)
            .load("half", Step::of(1.0))
            .load("m", Impulse::of(1.0))
    };
    let ask = ask()
        .load("half", Impulse::of(0.0).at(1.0))
        .load("half", Impulse::of(2.0).at(2.0));
    let refused = ask.every(0.5).until(3.0).run().expect_err("refused");
    let ResponseError::ImpulseOnMassless { index, name } = refused else {
        panic!("{refused}");
    };
    assert_eq!((index, name.as_str()), (3, "p"));
}

/// A support that jumps takes what a damper holds with it: of two nodes without mass on springs of 2 and 1 N/m, whose distance it
/// holds, −1/3 and 2/3.
#[test]
fn what_a_damper_holds_jumps_with_its_support() {
    let system = System::builder()
        .mass("p", 0.0)
        .mass("q", 0.0)
        .support("s")
        .point("both", [("p", 1.0), ("q", -1.0), ("s", 1.0)], 0.0)
        .spring("p", GROUND, 2.0)
        .spring("q", GROUND, 1.0)
        .damper("both", GROUND, 1.0)
        .build()
        .expect("a system");
    let jump = asked(&system).motion("s", Quantity::Displacement, Step::of(1.0));
    let motion = jump.run().expect("a motion");
    for (i, wanted) in [-1.0, 2.0].into_iter().enumerate() {
        assert!((motion.displacement()[(i, 0)] - wanted / 3.0).abs() < 1e-15);
    }
}

/// Two nodes without mass on springs, and a damper that their distance moves: what it resists displaces them at once, to
/// ∓3e^(−t/2)/2, though neither has a damper that would resist it alone.
#[test]
fn an_impulse_on_what_a_damper_moves_is_resisted() {
    let system = System::builder()
        .mass("a", 0.0)
        .mass("b", 0.0)
        .point("p", [("a", -1.0), ("b", 1.0)], 0.0)
        .spring(GROUND, "a", 1.0)
        .spring(GROUND, "b", 1.0)
        .damper(GROUND, "p", 1.0);
    let system = system.build().expect("a system");
    for precision in [Precision::default(), Precision::Double] {
        let ask = Response::of(&system).load("p", Impulse::of(3.0));
        let ask = ask.every(1.0).until(2.0).to(precision);
        let motion = ask.run().expect("a motion");
        for (k, t) in motion.times().iter().enumerate() {
            for (i, way) in [-1.5, 1.5].into_iter().enumerate() {
                let found = motion.displacement()[(i, k)];
                let wanted = way * (-t / 2.0).exp();
                assert!((found - wanted).abs() < 1e-14, "{t}: {found} {wanted}");
            }
        }
    }
}

/// Where stiffness is a quotient that does not end in binary digits, what rounding leaves of 0 is not what loads are measured by.
#[test]
fn what_follows_by_a_damper_and_stays_is_known() {
    let system = System::builder().mass("a", 0.0).mass("b", 0.0);
    let system = system.spring(GROUND, "b", 3.0).damper("a", "b", 1.0);
    let system = system.build().expect("a system");
    let loads = [
        (Load::from(Step::of(1.0)), 1.0 / 3.0),
        (Load::from(Versine::of(1.0, 0.5)), 0.0),
    ];
    for (load, wanted) in loads {
        let ask = Response::of(&system).load("b", load);
        let motion = ask.every(1.0).until(2.0).run().expect("a motion");
        for i in 0..2 {
            let found = motion.displacement()[(i, 2)];
            assert!((found - wanted).abs() < 1e-16, "{found} {wanted}");
        }
    }
}

/// A free mass beside a support that is pushed and holds nothing goes on at its speed, by every method.
#[test]
fn a_support_that_holds_nothing_moves_nothing() {
    let system = System::builder()
        .mass("m", 1.0)
        .support("s")
        .point("p", [("s", 1.0)], 0.0);
    let system = system.build().expect("a system");
    let asked = Response::of(&system)
        .every(0.25)
        .until(2.0)
        .from(State::at_rest().displace("m", 0.25).push("m", -1.0))
        .load("p", Step::of(1.0).starting_at(0.5));
    let problem = asked.problem().expect("a problem");
    let mut ran = 0;
    for (method, motion) in answers(&problem) {
        ran += 1;
        for (k, t) in motion.times().iter().enumerate() {
            let found = motion.displacement()[(0, k)];
            let off = (found - (0.25 - t)).abs();
            assert!(off < 1e-15, "{method}: {found} at {t}");
        }
    }
    assert!(ran > 1, "{ran}");
}
