//! Motions with switches on supports that move, drawn at random: the exact ones against integrators that locate events.

use eigentone_check::{EventDriven, Limit, OneStep, TrajectoryError};
use eigentone_modes::{GROUND, System};
use eigentone_response::{
    Harmonic, Problem, Quantity, Ramp, Response, ResponseError, State, Step, Trajectory,
};
use eigentone_switching::{
    ControlledDamper, DamperLaw, Event, EventKind, Friction, Impact, Stop, Switch, Switching,
    SwitchingError,
};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::row::in_a_row;

/// A chain of masses between the ground and a support, with the places of switches.
#[derive(Clone, Debug)]
struct Drawn {
    masses: Vec<f64>,
    springs: Vec<f64>,
    dampers: Vec<f64>,
    start: Vec<(f64, f64)>,
    /// Amplitude and frequency of the support, and the speed at which it goes on.
    shake: (f64, f64, f64),
    switches: Vec<(u8, usize, usize, [f64; 3])>,
}

fn drawn() -> impl Strategy<Value = Drawn> {
    (1usize..5).prop_flat_map(|n| {
        let numbers = [0.1..3.0f64, 1.0..1.6f64, 0.02..0.3f64];
        let switch = (0u8..6, 0..n + 2, 0..n + 2, numbers);
        (
            vec(0.2..3.0f64, n),
            vec(20.0..300.0f64, n + 1),
            vec(0.0..1.0f64, n + 1),
            vec((-0.015..0.015f64, -1.0..1.0f64), n),
            (0.0..0.02f64, 1.0..20.0f64, -0.3..0.3f64),
            vec(switch, 1..4),
        )
            .prop_map(|(masses, springs, dampers, start, shake, switches)| Drawn {
                masses,
                springs,
                dampers,
                start,
                shake,
                switches,
            })
    })
}

impl Drawn {
    fn name(&self, place: usize) -> String {
        match place {
            0 => GROUND.to_owned(),
            place if place > self.masses.len() => "support".to_owned(),
            place => format!("m{place}"),
        }
    }

    fn system(&self) -> System {
        let mut builder = System::builder().support("support");
        for (i, mass) in self.masses.iter().enumerate() {
            builder = builder.mass(self.name(i + 1), *mass);
        }
        for (i, (spring, damper)) in self.springs.iter().zip(&self.dampers).enumerate() {
            let [a, b] = [i, i + 1].map(|place| self.name(place));
            builder = builder.spring(&a, &b, *spring).damper(a, b, *damper);
        }
        builder.build().expect("a chain")
    }

    /// None between the ground and the support, and one controlled damper at most: what several share out at v_b = 0 is not
    /// unique.
    fn switches(&self) -> Vec<Switch> {
        let last = self.masses.len() + 1;
        let mut controlled = 0;
        let all = self
            .switches
            .iter()
            .filter_map(|&(kind, a, b, [force, ratio, gap])| {
                if a == b || a + b == last && a * b == 0 {
                    return None;
                }
                let between = [a, b].map(|place| self.name(place));
                Some(match kind {
                    0 | 1 => Switch::Friction(Friction {
                        between,
                        force,
                        static_force: force,
                    }),
                    2 => Switch::Stop(Stop {
                        between,
                        gap,
                        stiffness: 2e3 * ratio,
                        damping: force,
                    }),
                    3 => Switch::Impact(Impact {
                        between,
                        gap,
                        restitution: 3.0 * gap,
                    }),
                    _ => {
                        controlled += 1;
                        if controlled > 1 {
                            return None;
                        }
                        let law = match kind {
                            4 => DamperLaw::OnOffSkyhook,
                            _ => DamperLaw::ClippedSkyhook { sky: 3.0 * force },
                        };
                        Switch::ControlledDamper(ControlledDamper {
                            between,
                            low: force,
                            high: 4.0 * force,
                            law,
                        })
                    }
                })
            });
        all.collect()
    }
}

fn examine(drawn: &Drawn) -> Result<(), TestCaseError> {
    let system = drawn.system();
    let mut state = State::at_rest();
    for (i, (x, v)) in drawn.start.iter().enumerate() {
        state = state
            .displace(drawn.name(i + 1), *x)
            .push(drawn.name(i + 1), *v);
    }
    let (amplitude, frequency, speed) = drawn.shake;
    let problem = Response::of(&system)
        .from(state)
        .motion(
            "support",
            Quantity::Displacement,
            Harmonic::of(amplitude, frequency),
        )
        .motion("support", Quantity::Displacement, Ramp::of(speed))
        .every(0.0625)
        .until(1.0)
        .problem()
        .expect("a problem");
    let switches = drawn.switches();
    let exact = Switching::new(&problem, switches.clone()).and_then(|switching| switching.run());
    let exact = match exact {
        Ok(exact) => exact,
        Err(SwitchingError::Dependent { .. } | SwitchingError::Switch { .. }) => return Ok(()),
        Err(SwitchingError::Undecided { reason, .. }) if reason.contains("die out") => {
            return Ok(());
        }
        // A mass that is squeezed between a wall and a support has no way out.
        Err(SwitchingError::Endless { .. })
            if switches
                .iter()
                .filter(|one| matches!(one, Switch::Impact(_)))
                .count()
                > 1 =>
        {
            return Ok(());
        }
        Err(error) => return Err(TestCaseError::fail(error.to_string())),
    };
    // Bounces that die out are cut short by the integrators, each in its own way.
    let bounces = exact
        .events()
        .iter()
        .filter(|event| event.kind == EventKind::Impact);
    if bounces.count() > 20 {
        return Ok(());
    }
    // What comes and goes within a step they miss.
    let shortest = 2.0 * 0.0625 / 128.0;
    let hurries = |switch: usize| {
        let own = exact.events().iter().filter(|event| event.switch == switch);
        let times: Vec<f64> = own.map(|event| event.time).collect();
        times.windows(2).any(|pair| pair[1] - pair[0] < shortest)
    };
    if (0..switches.len()).any(hurries) {
        return Ok(());
    }
    let integrated = |substeps: u32| {
        let method = EventDriven {
            method: OneStep::Dop853,
            substeps,
        };
        method.integrate(&problem, &switches, Limit::default())
    };
    let (Ok(coarse), Ok(fine)) = (integrated(64), integrated(128)) else {
        return Ok(());
    };
    let apart = TrajectoryError::between(&coarse.trajectory, &fine.trajectory).worst();
    if apart > 1e-7 {
        return Ok(());
    }
    let off = TrajectoryError::between(&fine.trajectory, exact.trajectory()).worst();
    prop_assert!(
        off < 1e-6 + 100.0 * apart,
        "{off:e}, two integrations {apart:e}\n{:?}\n{:?}",
        exact.events(),
        fine.events
    );
    Ok(())
}

fn friction(between: [&str; 2], force: f64, static_force: f64) -> Switch {
    Switch::Friction(Friction {
        between: between.map(str::to_owned),
        force,
        static_force,
    })
}

/// The same in every order, each from either end.
fn orders(switches: &[Switch]) -> Vec<Vec<Switch>> {
    let Some((first, others)) = switches.split_first() else {
        return vec![Vec::new()];
    };
    let mut turned = first.clone();
    if let Switch::Friction(friction) = &mut turned {
        friction.between.reverse();
    }
    let mut all = Vec::new();
    for other in orders(others) {
        for at in 0..=other.len() {
            for one in [first, &turned] {
                let mut own = other.clone();
                own.insert(at, one.clone());
                all.push(own);
            }
        }
    }
    all
}

/// Bounces that die out, impacts that do not rebound and contacts that open again, and a damper that sets out from rest.
#[test]
fn what_comes_to_lie_and_what_sets_out_is_followed() {
    let impact = |[a, b]: [&str; 2], gap: f64, restitution: f64| {
        let between = [a, b].map(str::to_owned);
        Switch::Impact(Impact {
            between,
            gap,
            restitution,
        })
    };
    let mass = || System::builder().mass("m", 1.0);
    let free = mass().build().expect("a system");
    let held = mass().spring(GROUND, "m", 100.0).build();
    let held = held.expect("a system");
    let pair = in_a_row(&[("w", 1.0), ("b", 1.0)], &[100.0, 20.0], &[]);
    let ball = Response::of(&free).from(State::at_rest().displace("m", 1.0));
    let ball = ball.load("m", Step::of(-9.81));
    let driven = || Response::of(&held).load("m", Harmonic::of(30.0, 3.0));
    let sky = Response::of(&pair).load("b", Harmonic::of(10.0, 4.0));
    let damper = Switch::ControlledDamper(ControlledDamper {
        between: ["w", "b"].map(str::to_owned),
        low: 0.5,
        high: 5.0,
        law: DamperLaw::OnOffSkyhook,
    });
    for (ask, switch, is_counted) in [
        (ball, impact(["m", GROUND], 0.0, 0.5), false),
        (driven(), impact([GROUND, "m"], 0.1, 0.0), true),
        (driven(), impact([GROUND, "m"], 0.1, 0.5), false),
        (sky, damper, true),
    ] {
        let problem = ask.every(0.01).until(2.0).problem().expect("a problem");
        let switches = [switch];
        let method = EventDriven {
            method: OneStep::Dop853,
            substeps: 2,
        };
        let motion = method.integrate(&problem, &switches, Limit::default());
        let motion = motion.unwrap_or_else(|error| panic!("{error}"));
        let exact = Switching::new(&problem, switches.to_vec()).expect("switches");
        let exact = exact.run().unwrap_or_else(|error| panic!("{error}"));
        let error = TrajectoryError::between(&motion.trajectory, exact.trajectory());
        assert!(error.worst() < 1e-10, "{error:?}");
        // Bounces that are too small to be seen are not counted.
        assert!(!is_counted || motion.events.len() == exact.events().len());
        let last = |events: &[Event]| events.last().map(|event| (event.kind, event.time));
        let (Some((kind, time)), Some((wanted, exact))) =
            (last(&motion.events), last(exact.events()))
        else {
            panic!("there are events");
        };
        assert!(
            kind == wanted && (time - exact).abs() < 1e-5,
            "{time} {exact}"
        );
    }
}

fn stepped(problem: &Problem<'_>, switches: &[Switch]) -> Result<Trajectory, ResponseError> {
    let method = EventDriven {
        method: OneStep::RungeKutta4,
        substeps: 4,
    };
    let motion = method.integrate(problem, switches, Limit::default());
    motion.map(|motion| motion.trajectory)
}

/// Two masses on each other, the upper one pulled by 2.5 N. Where the ground gives way first, both go with (2.5 − 1)/2 m/s², or
/// else the upper one alone with 1.5 m/s².
#[test]
fn the_friction_that_is_first_at_its_limit_gives_way() {
    let system = in_a_row(&[("a", 1.0), ("b", 1.0)], &[], &[]);
    let ask = Response::of(&system).load("b", Step::of(2.5));
    let problem = ask.every(0.5).until(1.0).problem().expect("a problem");
    let limits = [
        ([1.9, 2.0], Some([0.375, 0.375])),
        ([2.0, 1.9], Some([0.0, 0.75])),
        ([2.0, 2.0], None),
    ];
    for ([lower, upper], wanted) in limits {
        let switches = [
            friction([GROUND, "a"], 1.0, lower),
            friction(["a", "b"], 1.0, upper),
        ];
        for switches in orders(&switches) {
            match (stepped(&problem, &switches), wanted) {
                (Ok(motion), Some(wanted)) => {
                    for (i, wanted) in wanted.into_iter().enumerate() {
                        let found = motion.displacement()[(i, 2)];
                        assert!((found - wanted).abs() < 1e-12, "{found} {wanted}");
                    }
                }
                (Err(error), None) => {
                    assert!(error.to_string().contains("is not determined"), "{error}");
                }
                (found, _) => panic!("{:?} for {wanted:?}", found.map(|_| ())),
            }
        }
    }
}

/// What frictions hold stays where it is: rounding does not move it, be there springs or none.
#[test]
fn what_is_held_does_not_move_at_all() {
    let springs: [&[f64]; 2] = [&[], &[0.0, 0.702]];
    for springs in springs {
        let system = in_a_row(&[("a", 0.533), ("b", 1.58), ("c", 1.29)], springs, &[]);
        let ask = Response::of(&system).load("b", Step::of(0.702));
        let problem = ask.every(0.1).until(1.0).problem();
        let problem = problem.expect("a problem");
        let switches = [
            friction([GROUND, "a"], 0.528, 0.792),
            friction(["a", "b"], 0.918, 1.84),
            friction(["b", "c"], 1.27, 1.91),
        ];
        for switches in orders(&switches) {
            let motion = stepped(&problem, &switches).expect("a motion");
            assert_eq!(motion.displacement().norm_max(), 0.0);
            assert_eq!(motion.velocity().norm_max(), 0.0);
        }
    }
}

/// Two frictions hold a block by 1.4 N, and one holds the upper block on it by 4.3 N, or 1 N if it slides. A pull on the upper block
/// that rises by 1 N/s reaches 1.4 N first: both go, by ∫∫(s + 0.1)/2, s being the seconds since.
#[test]
fn what_is_not_at_its_limit_does_not_give_way() {
    let system = in_a_row(&[("a", 1.0), ("b", 1.0)], &[], &[]);
    let ask = Response::of(&system).load("b", Ramp::of(1.0));
    let problem = ask.every(0.5).until(2.0).problem().expect("a problem");
    let switches = [
        friction([GROUND, "a"], 0.5, 0.6),
        friction([GROUND, "a"], 0.8, 0.8),
        friction(["a", "b"], 1.0, 4.3),
    ];
    let s = 0.6f64;
    let wanted = (0.05 * s * s + s * s * s / 6.0) / 2.0;
    for switches in orders(&switches) {
        let motion = stepped(&problem, &switches).expect("a motion");
        for i in 0..2 {
            let found = motion.displacement()[(i, 4)];
            assert!((found - wanted).abs() < 1e-9, "{found} {wanted}");
        }
    }
}

/// A clipped damper beside a friction that holds the same has no force, however fast its body goes.
#[test]
fn a_clipped_damper_at_rest_has_no_force() {
    let drawn = Drawn {
        masses: vec![1.250166977258449, 0.2781491104187939],
        springs: vec![284.97613586460574, 274.8512969630013, 166.52655298405844],
        dampers: vec![0.9113313668253504, 0.41366007991860665, 0.6837489033685955],
        start: vec![
            (-0.004350165487809985, 0.17901565174310338),
            (-0.009742390893167537, 0.8648692066738319),
        ],
        shake: (
            0.001093310396973162,
            18.106678678989873,
            0.17897747604677117,
        ),
        switches: vec![
            (
                5,
                1,
                3,
                [1.1398081709455257, 1.5636878559970735, 0.24213908205359588],
            ),
            (
                3,
                0,
                2,
                [1.8546488920575042, 1.2306295788250887, 0.13425831611900382],
            ),
            (
                0,
                1,
                3,
                [2.6136300008289677, 1.4373441602166253, 0.20283589029799665],
            ),
        ],
    };
    examine(&drawn).unwrap_or_else(|error| panic!("{error}"));
}

/// A body that a friction holds to the ground has the low damping of an on-off damper, though rounding leaves it a velocity as it stops:
/// the damper does not hold it in place of the friction.
#[test]
fn an_on_off_damper_leaves_a_body_to_the_friction_that_holds_it() {
    let drawn = Drawn {
        masses: vec![
            1.786070322168181,
            1.9543911619372776,
            1.0279127589262473,
            2.747098552037626,
        ],
        springs: vec![
            119.81004514467256,
            199.12021719849662,
            245.54294601605807,
            173.54901434321891,
            124.92209446214761,
        ],
        dampers: vec![
            0.9559547119128554,
            0.5811068699281355,
            0.04536287882156308,
            0.11718213819930073,
            0.454474088477724,
        ],
        start: vec![
            (-0.012423013663629821, -0.39083377304951034),
            (-0.0021238029465071974, 0.8854721677946515),
            (-0.009424148868575798, 0.8002961634976806),
            (-0.01174590143267334, -0.1681305063371516),
        ],
        shake: (
            0.013624585276576551,
            19.612226318182785,
            0.24908620027270428,
        ),
        switches: vec![
            (1, 0, 3, [1.1512728377118806, 1.0, 0.0]),
            (4, 1, 3, [1.9722045208313195, 1.0, 0.0]),
        ],
    };
    examine(&drawn).unwrap_or_else(|error| panic!("{error}"));
}

/// A mass of 1 kg at −1 m/s, pulled by 1.5 N against a friction of 1 N, rests after 0.4 s at −0.2 m, as what holds it is up to 2 N.
#[test]
fn what_comes_to_rest_below_its_static_limit_stays() {
    let system = System::builder().mass("m", 1.0).build().expect("a system");
    let ask = Response::of(&system)
        .from(State::at_rest().push("m", -1.0))
        .load("m", Step::of(1.5));
    let problem = ask.every(0.125).until(1.0).problem().expect("a problem");
    let switches = [friction([GROUND, "m"], 1.0, 2.0)];
    for switches in orders(&switches) {
        let motion = stepped(&problem, &switches).expect("a motion");
        for k in 4..=8 {
            let found = motion.displacement()[(0, k)];
            assert!((found + 0.2).abs() < 1e-12, "{found}");
        }
    }
}

/// Masses without springs or with, under loads that jump, with frictions between each other, the ground and a support.
#[derive(Clone, Debug)]
struct Held {
    masses: Vec<(f64, f64, f64, f64)>,
    stiffness: f64,
    frequency: f64,
    frictions: Vec<(usize, usize, f64, f64)>,
}

fn held() -> impl Strategy<Value = Held> {
    (1usize..4).prop_flat_map(|n| {
        let friction = (0..n + 1, 1..n + 2, 0.5..3.0f64, 1.0..2.0f64);
        (
            vec((0.5..3.0f64, -0.5..0.5f64, -4.0..4.0f64, -4.0..4.0f64), n),
            prop_oneof![Just(0.0), 20.0..200.0f64],
            1.0..8.0f64,
            vec(friction, 2..4),
        )
            .prop_map(|(masses, stiffness, frequency, frictions)| Held {
                masses,
                stiffness,
                frequency,
                frictions,
            })
    })
}

fn examine_orders(held: &Held) -> Result<(), TestCaseError> {
    let last = held.masses.len() + 1;
    let name = |place: usize| match place {
        0 => GROUND.to_owned(),
        place if place == last => "support".to_owned(),
        place => format!("m{place}"),
    };
    let mut builder = System::builder().support("support");
    for (i, (mass, ..)) in held.masses.iter().enumerate() {
        builder = builder.mass(name(i + 1), *mass);
        if held.stiffness > 0.0 {
            builder = builder.spring(name(i), name(i + 1), held.stiffness);
        }
    }
    let system = builder.build().expect("a system");
    let mut ask = Response::of(&system);
    let mut state = State::at_rest();
    for (i, (_, speed, load, later)) in held.masses.iter().enumerate() {
        // Half of all start at rest.
        state = state.push(name(i + 1), speed.max(0.0));
        ask = ask
            .load(name(i + 1), Step::of(*load))
            .load(name(i + 1), Step::of(*later).starting_at(0.5));
    }
    let shake = Harmonic::of(0.05, held.frequency);
    let ask = ask.from(state);
    let ask = ask.motion("support", Quantity::Displacement, shake);
    let problem = ask.every(0.125).until(1.0).problem().expect("a problem");
    let each = held.frictions.iter().filter_map(|&(a, b, force, ratio)| {
        let apart = a != b && (a, b) != (0, last);
        apart.then(|| friction([&name(a), &name(b)], force, force * ratio))
    });
    let switches: Vec<Switch> = each.collect();
    let mut known: Option<Result<Trajectory, ResponseError>> = None;
    for switches in orders(&switches) {
        let found = stepped(&problem, &switches);
        match (&known, &found) {
            (Some(Ok(known)), Ok(found)) => {
                let pairs = (0..last - 1).flat_map(|i| (0..=8).map(move |k| (i, k)));
                let off =
                    pairs.map(|at| (known.displacement()[at] - found.displacement()[at]).abs());
                let off = off.fold(0.0, f64::max);
                prop_assert!(off < 1e-6, "{off:e} {switches:?}");
            }
            (Some(Ok(_)), Err(error)) | (Some(Err(error)), Ok(_)) => {
                return Err(TestCaseError::fail(format!("{error} {switches:?}")));
            }
            _ => {}
        }
        known = Some(found);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, max_shrink_iters: 8, ..ProptestConfig::default() })]

    #[test]
    fn motions_with_switches_are_those_of_integrators(drawn in drawn()) {
        examine(&drawn)?;
    }

    #[test]
    fn the_order_of_frictions_does_not_matter(held in held()) {
        examine_orders(&held)?;
    }
}
