//! Forces on points, motions of supports, pulses, and sums of motions.

use eigentone_modes::{Bounds, GROUND, Precision, System};
use eigentone_response::{
    ByCertifiedExponential, ByExponential, BySuperposition, HalfSine, Harmonic, Hold, Impulse,
    LoadError, ModalTruncation, Output, Quantity, Ramp, Response, ResponseError, ResponseMethod,
    Samples, State, Step, Summary, Sweep, Versine,
};
use eigentone_response::{Destination, Trajectory};

fn quarter_car() -> System {
    System::builder()
        .mass("body", 290.0)
        .mass("wheel", 59.0)
        .support("road")
        .spring("wheel", "body", 16812.0)
        .named("suspension")
        .damper("wheel", "body", 1000.0)
        .named("shock absorber")
        .spring("road", "wheel", 190_000.0)
        .named("tyre")
        .damper("road", "wheel", 50.0)
        .build()
        .expect("a system")
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
                let largest = motion
                    .output(row)
                    .iter()
                    .fold(0.0f64, |top, y| top.max(y.abs()));
                assert!(
                    (found - wanted).abs() < 1e-12 * largest,
                    "{row} at {k}: {found} {wanted}"
                );
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
    let fixed = System::builder()
        .mass("floor", 3.0)
        .mass("roof", 2.0)
        .spring(GROUND, "floor", 700.0)
        .damper(GROUND, "floor", 5.0)
        .spring("floor", "roof", 500.0)
        .damper("floor", "roof", 3.0)
        .build()
        .expect("a system");
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
        assert!(
            (found - wanted).abs() <= bound + other,
            "{k}: {found} {wanted} {bound:e}"
        );
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
    let blow = Impulse::of(0.5).at(0.75);
    let on_point = asked(&system).load("rear", step).load("rear", pulse);
    let on_point = on_point
        .load("rear", wave)
        .load("rear", blow)
        .load("front", Ramp::of(0.5));
    let shared = asked(&system)
        .load("heave", Step::of(2.0))
        .load("pitch", Step::of(2.0 * 1.4))
        .load(
            "heave",
            HalfSine {
                force: 8.0,
                ..pulse
            },
        )
        .load(
            "pitch",
            HalfSine {
                force: 8.0 * 1.4,
                ..pulse
            },
        )
        .load("heave", wave)
        .load(
            "pitch",
            Harmonic {
                amplitude: 4.0 * 1.4,
                ..wave
            },
        )
        .load("heave", blow)
        .load(
            "pitch",
            Impulse {
                magnitude: 0.5 * 1.4,
                ..blow
            },
        )
        .load("heave", Ramp::of(0.5))
        .load("pitch", Ramp::of(-0.5 * 1.1));
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
    let moved = |name: &str, load: eigentone_response::Load| {
        wrong(asked(&car).motion(name, Quantity::Displacement, load))
    };
    assert!(matches!(
        moved("body", Step::of(1.0).into()),
        ResponseError::UnknownSupport { .. }
    ));
    let impulse = moved("road", Impulse::of(1.0).into());
    assert_eq!(
        impulse,
        ResponseError::Motion {
            index: 0,
            error: LoadError::ImpulseOfMotion
        }
    );
    let early = moved("road", HalfSine::of(1.0, 0.5).starting_at(-0.1).into());
    assert_eq!(
        early,
        ResponseError::Motion {
            index: 0,
            error: LoadError::PulseBeforeStart { start: -0.1 }
        }
    );
    let short = moved("road", Versine::of(1.0, 0.0).into());
    assert_eq!(
        short,
        ResponseError::Motion {
            index: 0,
            error: LoadError::Duration { duration: 0.0 }
        }
    );
    let unknown = wrong(asked(&car).pull("f", "spring"));
    assert!(
        matches!(unknown, ResponseError::Combination { index: 0, .. }),
        "{unknown}"
    );
    let unknown = wrong(asked(&car).sum("f", [(Quantity::Velocity, "roof", 1.0)]));
    assert!(
        matches!(unknown, ResponseError::Combination { index: 0, .. }),
        "{unknown}"
    );
    let carried = System::builder()
        .mass("x", 1.0)
        .support("s")
        .point("p", [("x", 1.0), ("s", 1.0)], 1.0)
        .spring("x", GROUND, 1.0)
        .build()
        .expect("a system");
    let jump = asked(&carried).motion("s", Quantity::Displacement, Step::of(1.0));
    let jump = wrong(jump);
    assert!(
        matches!(
            jump,
            ResponseError::Motion {
                index: 0,
                error: LoadError::JumpOfMass { .. }
            }
        ),
        "{jump}"
    );
    // A damper passes the jump on to a node that only a spring holds: b has a damper to the support alone.
    let massless = System::builder()
        .mass("a", 1.0)
        .mass("p", 0.0)
        .mass("q", 0.0)
        .support("s")
        .point("both", [("p", 1.0), ("q", -1.0), ("s", 1.0)], 0.0)
        .spring("a", "p", 1.0)
        .spring("p", GROUND, 1.0)
        .spring("q", GROUND, 1.0)
        .damper("both", GROUND, 1.0)
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
    let car = System::builder()
        .mass("body", 290.0)
        .mass("wheel", 59.0)
        .support("road")
        .spring("wheel", "body", 16812.0)
        .damper("wheel", "body", 1000.0)
        .spring("road", "wheel", 190_000.0)
        .build()
        .expect("a system");
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
