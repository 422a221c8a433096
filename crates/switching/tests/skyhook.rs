//! A quarter car with an on-off skyhook damper on a bump, against events and motions with 50 digits: exponentials of each piece
//! and roots of the laws by mpmath, with the damper held at v_body = 0 where neither damping keeps its sign.

use eigentone_modes::{GROUND, System};
use eigentone_response::{Harmonic, Quantity, Response, State, Versine};
use eigentone_switching::{
    ControlledDamper, DamperLaw, EventKind, Friction, Impact, Switch, SwitchedMotion, Switching,
};

use crate::row::in_a_row;

const EVENTS: [f64; 20] = [
    0.21370779073339738,
    0.29382013803284557,
    0.2975429802534863,
    0.3488662922943399,
    0.37763725547281346,
    0.4120357373692878,
    0.4129098383439543,
    0.46425771751169687,
    0.5086547516255974,
    0.5218602317598414,
    0.5297697352522655,
    0.5768677089140035,
    1.0602727225146027,
    1.080046310320081,
    1.5785070349028125,
    1.5982858343557895,
    2.096742119072574,
    2.116520918277756,
    2.6149772031854464,
    2.634756002390641,
];

/// Index of the sample, body and wheel in m.
const SAMPLES: [(u64, f64, f64); 5] = [
    (20, 0.00542220131019974, 0.07774470419265228),
    (40, 0.02102647965649586, 0.010518901020660132),
    (80, 0.0037722644158760315, -0.0003504969209231721),
    (150, 6.698324987952521e-05, 1.5997657838107317e-05),
    (299, -6.542989233527958e-10, -9.06462126630037e-09),
];

#[test]
fn a_skyhook_damper_over_a_bump_is_that_of_50_digits() {
    let car = System::builder()
        .mass("body", 290.0)
        .mass("wheel", 59.0)
        .support("road")
        .spring("wheel", "body", 16_812.0)
        .spring("road", "wheel", 190_000.0)
        .build()
        .expect("a car");
    let bump = Versine::of(0.08, 0.25).starting_at(0.1);
    let ask = Response::of(&car).motion("road", Quantity::Displacement, bump);
    let problem = ask.every(0.01).until(3.0).problem().expect("a problem");
    let damper = Switch::ControlledDamper(ControlledDamper {
        between: ["wheel".to_owned(), "body".to_owned()],
        low: 300.0,
        high: 3000.0,
        law: DamperLaw::OnOffSkyhook,
    });
    let motion = Switching::new(&problem, vec![damper])
        .expect("a damper")
        .run()
        .expect("a motion");
    assert_eq!(motion.events().len(), EVENTS.len());
    for (event, wanted) in motion.events().iter().zip(EVENTS) {
        assert_eq!(event.kind, EventKind::Switch);
        let rounding = wanted * f64::EPSILON / 2.0;
        let off = (event.time - wanted).abs();
        assert!(off <= event.bound + rounding, "{event:?} {wanted}");
        assert!(event.bound <= 1e-15, "{event:?}");
    }
    let found = motion.trajectory();
    for (index, body, wheel) in SAMPLES {
        let k = index as usize;
        let bound = found.displacement_bound()[k].expect("proven");
        assert!(bound <= 1e-16, "{bound:e}");
        for (i, wanted) in [body, wheel].into_iter().enumerate() {
            let off = (found.displacement()[(i, k)] - wanted).abs();
            assert!(
                off <= bound + wanted.abs() * f64::EPSILON,
                "{index} {i}: {off:e} {bound:e}"
            );
        }
    }
}

/// Of the ground nothing moves, so that each damper stays low, whichever else changes.
#[test]
fn dampers_of_a_body_that_never_moves_stay_low() {
    let on_off = |low: f64, high: f64| {
        Switch::ControlledDamper(ControlledDamper {
            between: ["a".to_owned(), GROUND.to_owned()],
            low,
            high,
            law: DamperLaw::OnOffSkyhook,
        })
    };
    let bare = || System::builder().mass("a", 1.0).spring(GROUND, "a", 9.0);
    let [switched, plain] = [bare(), bare().damper(GROUND, "a", 0.75)]
        .map(|builder| builder.build().expect("a system"));
    let from = State::at_rest().displace("a", 1.0);
    let ask = |system| {
        Response::of(system)
            .from(from.clone())
            .every(0.5)
            .until(2.0)
    };
    let problem = ask(&switched).problem().expect("a problem");
    let motion = Switching::new(&problem, vec![on_off(0.5, 2.0), on_off(0.25, 3.0)]);
    let motion = motion.expect("dampers").run().expect("a motion");
    let wanted = ask(&plain).run().expect("a motion");
    let off = motion.trajectory().displacement() - wanted.displacement();
    assert!(off.norm_max() < 1e-16, "{:e}", off.norm_max());
}

/// A friction that does not suffice holds a body together with a damper, which takes the rest: beside a time-stepping scheme
/// of order 1 (Moreau's), of steps of 1e-4 s.
#[test]
fn a_friction_and_a_damper_hold_a_body_together() {
    let system = System::builder()
        .mass("a", 1.0)
        .support("s")
        .spring(GROUND, "a", 9.0);
    let system = system.build().expect("a system");
    let motion = Harmonic::of(0.3, 2.0);
    let ask = Response::of(&system).from(State::at_rest().displace("a", 0.1));
    let ask = ask
        .motion("s", Quantity::Displacement, motion)
        .load("a", Harmonic::of(0.5, 1.0));
    let problem = ask.every(0.125).until(6.0).problem().expect("a problem");
    let friction = Switch::Friction(Friction {
        between: [GROUND.to_owned(), "a".to_owned()],
        force: 0.3,
        static_force: 0.3,
    });
    let damper = Switch::ControlledDamper(ControlledDamper {
        between: ["s".to_owned(), "a".to_owned()],
        low: 0.5,
        high: 2.0,
        law: DamperLaw::OnOffSkyhook,
    });
    let switching = Switching::new(&problem, vec![friction, damper]).expect("switches");
    let motion = switching.run().expect("a motion");
    let found = motion.trajectory();
    // The spring pulls with 0.9 N, of which the friction takes 0.3 and the damper 0.6 at a damping of 1.
    assert_eq!(found.velocity()[(0, 1)], 0.0);
    assert!((found.displacement()[(0, 1)] - 0.1).abs() < 1e-16);
    for (index, wanted) in [(24, 0.028140), (40, -0.103007), (48, -0.055584)] {
        let off = found.displacement()[(0, index)] - wanted;
        assert!(off.abs() < 2e-5, "{index}: {off:e}");
    }
}

/// Frictions between the same names do what one with the sum of their forces does, beside a damper that takes what they cannot: it has the
/// low damping again as soon as they suffice together.
#[test]
fn frictions_beside_a_damper_that_holds_add_up() {
    let chain = in_a_row(
        &[("a", 0.2), ("b", 1.1), ("c", 2.3)],
        &[190.0, 80.0, 190.0],
        &[0.25, 0.75, 0.6],
    );
    let start = State::at_rest()
        .displace("a", -0.042)
        .push("a", 0.075)
        .displace("b", -0.032)
        .push("b", 0.6)
        .displace("c", -0.019)
        .push("c", -0.68);
    let ask = Response::of(&chain).from(start);
    let ask = ask.load("c", Harmonic::of(3.3, 13.9));
    let problem = ask.every(0.0625).until(0.625).problem().expect("a problem");
    let moved = |forces: &[f64]| {
        let frictions = forces.iter().map(|force| {
            // Named the other way round it is the same.
            let between = match *force > 0.0 {
                true => [GROUND, "c"],
                false => ["c", GROUND],
            };
            Switch::Friction(Friction {
                between: between.map(str::to_owned),
                force: force.abs(),
                static_force: force.abs(),
            })
        });
        let damper = Switch::ControlledDamper(ControlledDamper {
            between: ["b".to_owned(), "c".to_owned()],
            low: 2.8,
            high: 11.2,
            law: DamperLaw::OnOffSkyhook,
        });
        let switches = frictions.chain([damper]).collect();
        let motion = Switching::new(&problem, switches).expect("switches").run();
        motion.expect("a motion")
    };
    let one = moved(&[1.25]);
    let switches = |motion: &SwitchedMotion| {
        let events = motion.events().iter();
        events
            .filter(|event| event.kind == EventKind::Switch)
            .count()
    };
    assert_eq!(switches(&one), 6);
    let splits: [&[f64]; 6] = [
        &[0.125, 1.125],
        &[1.125, 0.125],
        &[-0.25, 1.0],
        &[1.0, -0.25],
        &[-0.625, 0.25, 0.375],
        &[0.25, -0.5, -0.375, 0.125],
    ];
    for forces in splits {
        let several = moved(forces);
        assert_eq!(switches(&several), 6, "{forces:?}");
        let [x, y] = [&one, &several].map(|motion| motion.trajectory().displacement());
        for k in 0..x.ncols() {
            for i in 0..x.nrows() {
                let off = (x[(i, k)] - y[(i, k)]).abs();
                assert!(off < 1e-15, "{forces:?}: {off:e} at {k}, {i}");
            }
        }
    }
}

/// A body is pressed against a wall and pulled off while the damper would hold it: displacement and velocity in m and m/s against
/// steps of 1e-5 to 1e-6 s.
#[test]
fn a_body_that_a_damper_and_a_wall_would_hold_comes_off() {
    let system = System::builder().mass("b", 2.0).support("w");
    let system = system.build().expect("a system");
    let sway = Harmonic::of(0.1, 5.0);
    let ask = Response::of(&system).motion("w", Quantity::Displacement, sway);
    let ask = ask.load("b", Harmonic::of(50.0, 3.0));
    let problem = ask.every(0.1).until(3.0).problem().expect("a problem");
    let damper = Switch::ControlledDamper(ControlledDamper {
        between: ["w".to_owned(), "b".to_owned()],
        low: 0.0,
        high: 30.0,
        law: DamperLaw::OnOffSkyhook,
    });
    let wall = Switch::Impact(Impact {
        between: [GROUND.to_owned(), "b".to_owned()],
        gap: 0.01,
        restitution: 0.0,
    });
    let switching = Switching::new(&problem, vec![damper, wall]).expect("switches");
    let motion = switching.run().expect("a motion");
    let trajectory = motion.trajectory();
    let truth = [
        (8, 0.01, 0.0),
        (11, 0.01, 0.0),
        (12, 0.0074755, -0.09834),
        (15, -0.1782261, -1.203047),
        (20, -0.9761871, -1.214715),
        (25, -0.790602, 1.831168),
        (30, 0.01, 0.0),
    ];
    for (k, x, v) in truth {
        let found = [trajectory.displacement(), trajectory.velocity()].map(|of| of[(0, k)]);
        assert!((found[0] - x).abs() < 3e-6, "{k}: {found:?}");
        assert!((found[1] - v).abs() < 3e-5, "{k}: {found:?}");
    }
}
