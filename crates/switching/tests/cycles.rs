//! Periodic motions against closed forms and against what the motion itself tends to.

use std::f64::consts::{PI, TAU};

use eigentone_modes::{GROUND, System};
use eigentone_response::{Harmonic, Problem, Quantity, Ramp, Response, State, Step};
use eigentone_switching::{
    ControlledDamper, CycleError, DamperLaw, EventKind, Friction, Impact, LimitCycle, Period, Stop,
    Switch, Switching,
};

use crate::row::in_a_row;

fn friction(a: &str, b: &str, force: f64, static_force: f64) -> Switch {
    Switch::Friction(Friction {
        between: [a.into(), b.into()],
        force,
        static_force,
    })
}

fn cycle(
    problem: &Problem<'_>,
    switches: &[Switch],
    period: Period,
) -> Result<LimitCycle, CycleError> {
    let switching = Switching::new(problem, switches.to_vec()).expect("switches");
    switching.limit_cycle(period)
}

fn close(found: f64, wanted: f64, relative: f64) {
    let off = (found - wanted).abs();
    assert!(off <= relative * wanted.abs(), "{found:?} for {wanted:?}");
}

/// What starts on it comes back after each period: three of them, by the motion from doubles.
fn comes_back<'s>(
    system: &System,
    ask: impl Fn(State) -> Response<'s>,
    switches: &[Switch],
    cycle: &LimitCycle,
) {
    let ask = ask(cycle.state(system))
        .every(cycle.period)
        .until(3.0 * cycle.period);
    let problem = ask.problem().expect("a problem");
    let switching = Switching::new(&problem, switches.to_vec()).expect("switches");
    let motion = switching.run().expect("a motion");
    let [x, v] = [
        motion.trajectory().displacement(),
        motion.trajectory().velocity(),
    ];
    for i in 0..system.len() {
        for k in 0..4 {
            for (found, wanted) in [
                (x[(i, k)], cycle.displacement[i]),
                (v[(i, k)], cycle.velocity[i]),
            ] {
                let off = (found - wanted).abs();
                assert!(off < 1e-11, "{i} {k}: {found:?} for {wanted:?}");
            }
        }
    }
    // Three times the events of one, but for those at its very start.
    assert_eq!(motion.events().len(), 3 * cycle.events.len());
}

/// Stick until x = fs/k, then a slip about fk/k: all of the last period is forgotten in the next stick.
#[test]
fn a_mass_on_a_belt() {
    let (m, k, u, fk, fs) = (1.0, 100.0, 0.5, 3.0, 5.0);
    let system = System::builder()
        .mass("m", m)
        .spring(GROUND, "m", k)
        .support("belt")
        .damper("belt", "m", 0.0);
    let system = system.build().expect("a system");
    let ask = |state| {
        Response::of(&system)
            .motion("belt", Quantity::Displacement, Ramp::of(u))
            .from(state)
    };
    let switches = [friction("belt", "m", fk, fs)];
    let problem = ask(State::at_rest().push("m", u))
        .every(0.01)
        .until(4.0)
        .problem()
        .expect("a problem");
    let found = cycle(&problem, &switches, Period::Free).expect("a cycle");
    let w = (k / m).sqrt();
    let slip = 2.0 * (PI - ((fs - fk) / k * w / u).atan()) / w;
    let stick = 2.0 * (fs - fk) / k / u;
    close(found.period, slip + stick, 1e-15);
    assert!(found.period_bound < 1e-15);
    let [x, v] = [found.displacement[0], found.velocity[0]];
    close(
        (x - fk / k).hypot(v / w),
        ((fs - fk) / k).hypot(u / w),
        1e-15,
    );
    assert_eq!(found.multipliers.len(), 1);
    assert!(
        found.multipliers[0].norm() < 1e-14,
        "{:?}",
        found.multipliers
    );
    assert_eq!(found.stable, Some(true));
    let kinds: Vec<EventKind> = found.events.iter().map(|event| event.kind).collect();
    assert_eq!(kinds, [EventKind::Stick, EventKind::Slip]);
    comes_back(&system, ask, &switches, &found);
}

/// Without switches it is the steady state, and disturbances go as e^{λT}.
#[test]
fn a_linear_oscillator_under_a_harmonic_force() {
    let (m, c, k, f, o) = (2.0, 0.6, 18.0, 5.0, 2.2);
    let system = in_a_row(&[("m", m)], &[k], &[c]);
    let problem = Response::of(&system)
        .load("m", Harmonic::of(f, o))
        .every(0.1)
        .until(5.0);
    let problem = problem.problem().expect("a problem");
    let found = cycle(&problem, &[], Period::Cycles(1)).expect("a cycle");
    close(found.period, TAU / o, 1e-15);
    // x = Im(H e^{iΩt}), H = F/(k − mΩ² + icΩ).
    let (re, im) = (k - m * o * o, c * o);
    let size = re * re + im * im;
    close(found.displacement[0], -f * im / size, 1e-14);
    close(found.velocity[0], f * o * re / size, 1e-14);
    let decay = (-c / (2.0 * m) * TAU / o).exp();
    for multiplier in &found.multipliers {
        close(multiplier.norm(), decay, 1e-13);
    }
    let turn = (k / m - (c / (2.0 * m)).powi(2)).sqrt() * TAU / o;
    close(found.multipliers[0].re, decay * turn.cos(), 1e-12);
    assert_eq!(found.stable, Some(true));
    let wrong = cycle(&problem, &[], Period::Seconds(2.0));
    assert_eq!(wrong, Err(CycleError::NotRepeating { period: 2.0 }));
    let none = cycle(&problem, &[], Period::Seconds(f64::NAN));
    assert!(matches!(none, Err(CycleError::Period { .. })));
}

/// An undamped mass that touches a rigid stop at its place of rest, driven at Ω: with θ = 2πω/Ω the phase φ of the impact has
/// tan φ = (1 + r)Ω / ((1 − r) ω tan θ/2), and an impact shrinks areas of (x, v) by r² (Shaw and Holmes, J. Sound Vib. 90,
/// 1983).
#[test]
fn a_driven_mass_hits_a_stop_once_a_cycle() {
    let (m, k, f, o, r) = (1.0, 1.0, 1.0, 2.6, 0.7);
    let w: f64 = 1.0;
    let system = in_a_row(&[("m", m)], &[k], &[]);
    let ask = |state| {
        Response::of(&system)
            .load("m", Harmonic::of(f, o))
            .from(state)
    };
    let switches = [Switch::Impact(Impact {
        between: [GROUND.into(), "m".into()],
        gap: 0.0,
        restitution: r,
    })];
    let problem = ask(State::at_rest().displace("m", -1.0))
        .every(0.1)
        .until(300.0);
    let problem = problem.problem().expect("a problem");
    let found = cycle(&problem, &switches, Period::Cycles(1)).expect("a cycle");
    assert_eq!(found.events.len(), 1);
    let half = PI * w / o;
    let phase = ((1.0 + r) * o / ((1.0 - r) * w * half.tan())).atan();
    let found_phase = o * found.events[0].time;
    let turns = (found_phase - phase) / PI;
    let off = (turns - turns.round()).abs();
    assert!(off < 1e-14, "{found_phase} for {phase}");
    let area = found
        .multipliers
        .iter()
        .map(|multiplier| multiplier.norm())
        .product::<f64>();
    close(area, r * r, 1e-13);
    assert_eq!(found.stable, Some(true));
    // The motion from its start tends to one of three periods.
    assert!(!found.is_reached);
    comes_back(&system, ask, &switches, &found);
}

/// Two masses on a belt, and a damper that is switched over a road that swings: what the motion tends to.
#[test]
fn machines_tend_to_it() {
    let system = System::builder()
        .mass("a", 1.0)
        .mass("b", 2.0)
        .spring(GROUND, "a", 90.0)
        .spring("a", "b", 60.0);
    let system = system
        .damper("a", "b", 0.4)
        .support("belt")
        .damper("belt", "a", 0.0);
    let system = system.build().expect("a system");
    let ask = |state| {
        Response::of(&system)
            .motion("belt", Quantity::Displacement, Ramp::of(0.3))
            .from(state)
    };
    let switches = [
        friction("belt", "a", 4.0, 9.0),
        friction("belt", "b", 0.1, 0.1),
    ];
    let problem = ask(State::at_rest())
        .every(0.1)
        .until(60.0)
        .problem()
        .expect("a problem");
    let found = cycle(&problem, &switches, Period::Free).expect("a cycle");
    assert_eq!(found.stable, Some(true));
    comes_back(&system, ask, &switches, &found);

    let system = System::builder()
        .mass("body", 300.0)
        .mass("wheel", 40.0)
        .support("road");
    let system = system
        .spring("road", "wheel", 180e3)
        .spring("wheel", "body", 18e3)
        .damper("wheel", "body", 200.0);
    let system = system.build().expect("a system");
    let ask = |state| {
        let road = Harmonic::of(0.02, 9.0);
        Response::of(&system)
            .motion("road", Quantity::Displacement, road)
            .from(state)
    };
    let laws = [
        DamperLaw::OnOffSkyhook,
        DamperLaw::ClippedSkyhook { sky: 2000.0 },
    ];
    for law in laws {
        let switches = [Switch::ControlledDamper(ControlledDamper {
            between: ["wheel".into(), "body".into()],
            low: 100.0,
            high: 3000.0,
            law,
        })];
        let problem = ask(State::at_rest())
            .every(0.1)
            .until(12.0)
            .problem()
            .expect("a problem");
        let found = cycle(&problem, &switches, Period::Cycles(1)).expect("a cycle");
        assert_eq!(found.stable, Some(true));
        comes_back(&system, ask, &switches, &found);
        // It is what 12 s leave of the motion from rest, but for the largest multiplier to that many periods.
        let left = found.multipliers[0].norm().powf(12.0 / found.period);
        assert!(left < 1e-3 && found.is_reached, "{left}");
    }
}

/// Symmetric stops and negative damping: disturbances of the cycle shrink by its multiplier.
#[test]
fn a_self_excited_mass_between_stops() {
    let system = in_a_row(&[("m", 1.0)], &[4.0], &[-0.2]);
    let ask = |state| Response::of(&system).from(state);
    let stop = |between: [&str; 2]| {
        Switch::Stop(Stop {
            between: between.map(String::from),
            gap: 1.0,
            stiffness: 50.0,
            damping: 3.0,
        })
    };
    let switches = [stop([GROUND, "m"]), stop(["m", GROUND])];
    let problem = ask(State::at_rest().displace("m", 0.5))
        .every(0.1)
        .until(60.0)
        .problem();
    let problem = problem.expect("a problem");
    let found = cycle(&problem, &switches, Period::Free).expect("a cycle");
    assert_eq!(found.stable, Some(true));
    comes_back(&system, ask, &switches, &found);
    // The distance from the section across the cycle, one and three periods on.
    let rate = |x: f64, v: f64| [v, -4.0 * x + 0.2 * v];
    let [x, v] = [found.displacement[0], found.velocity[0]];
    let [fx, fv] = rate(x, v);
    let e = 1e-5;
    let disturbed = State::at_rest()
        .displace("m", x - e * fv)
        .push("m", v + e * fx);
    let problem = ask(disturbed)
        .every(found.period)
        .until(3.0 * found.period)
        .problem();
    let problem = problem.expect("a problem");
    let motion = Switching::new(&problem, switches.to_vec())
        .expect("switches")
        .run();
    let motion = motion.expect("a motion");
    let [xs, vs] = [
        motion.trajectory().displacement(),
        motion.trajectory().velocity(),
    ];
    let across = |k: usize| (vs[(0, k)] - v) * fx - (xs[(0, k)] - x) * fv;
    let multiplier = found.multipliers[0].re;
    assert!(multiplier > 1e-4, "{multiplier}");
    close(across(1) / across(0), multiplier, 1e-3);
    close(across(2) / across(1), multiplier, 1e-3);
}

/// What is no cycle is said to be none.
#[test]
fn what_does_not_repeat_itself_is_refused() {
    let system = System::builder()
        .mass("m", 1.0)
        .spring(GROUND, "m", 4.0)
        .build();
    let system = system.expect("a system");
    let problem = Response::of(&system)
        .from(State::at_rest().displace("m", 1.0))
        .every(0.1)
        .until(60.0);
    let problem = problem.problem().expect("a problem");
    let free = |switches: &[Switch]| cycle(&problem, switches, Period::Free);
    assert_eq!(
        free(&[friction(GROUND, "m", 0.3, 0.3)]),
        Err(CycleError::NoRepetition { end: 60.0 })
    );
    assert_eq!(free(&[]), Err(CycleError::NothingSwitches));
    assert_eq!(
        cycle(&problem, &[], Period::Cycles(1)),
        Err(CycleError::NoHarmonic)
    );
    // Every swing of an undamped mass between stops is periodic.
    let stop = Switch::Stop(Stop {
        between: [GROUND.into(), "m".into()],
        gap: 0.5,
        stiffness: 9.0,
        damping: 0.0,
    });
    assert_eq!(free(&[stop]), Err(CycleError::NotIsolated));
}

/// A whole step of the search leads beyond a rigid stop, where no motion starts: it is shortened, or said to be the search's
/// own, as the motion itself is followed to its end.
#[test]
fn steps_beyond_a_rigid_stop_are_those_of_the_search() {
    // Mass, stiffness and damping of a chain; force on its end and frequency; gap and restitution at its first mass; the end.
    let mended: &[[f64; 3]] = &[[1.17, 38.2, 1.0], [1.82, 41.3, 0.51]];
    let ended: &[[f64; 3]] = &[[1.42, 62.5, 0.26]];
    let cases = [
        (mended, [14.12, 9.42, 0.074, 0.32, 40.0]),
        (ended, [6.51, 14.64, 0.033, 0.87, 20.0]),
    ];
    for (chain, [force, frequency, gap, restitution, end]) in cases {
        let names = ["m0", "m1"];
        let mut system = System::builder();
        let mut before = GROUND;
        for (name, [m, k, c]) in names.into_iter().zip(chain) {
            system = system
                .mass(name, *m)
                .spring(before, name, *k)
                .damper(before, name, *c);
            before = name;
        }
        let system = system.build().expect("a system");
        let ask = |state| {
            Response::of(&system)
                .load(before, Harmonic::of(force, frequency))
                .from(state)
        };
        let switches = [Switch::Impact(Impact {
            between: [GROUND.into(), "m0".into()],
            gap,
            restitution,
        })];
        let problem = ask(State::at_rest()).every(0.1).until(end).problem();
        let problem = problem.expect("a problem");
        match cycle(&problem, &switches, Period::Cycles(1)) {
            Ok(found) if chain == mended => comes_back(&system, ask, &switches, &found),
            Err(error @ CycleError::Halted(_)) if chain == ended => {
                assert_eq!(error.switch(), Some(0));
                assert!(error.with_names(&["wall".to_owned()]).contains("wall"));
                let switching = Switching::new(&problem, switches.to_vec());
                switching.expect("switches").run().expect("a motion");
            }
            other => panic!("{other:?}"),
        }
    }
}

/// A free mass under a constant force is faster after each period: no motion repeats itself, though a friction holds another
/// mass where it is.
#[test]
fn where_none_repeats_itself_none_is_said_to() {
    let system = System::builder().mass("m", 2.0).mass("held", 1.0).build();
    let system = system.expect("a system");
    let problem = Response::of(&system)
        .load("m", Step::of(1.0))
        .every(0.1)
        .until(10.0)
        .problem()
        .expect("a problem");
    let holds = friction(GROUND, "held", 1.0, 1.0);
    let found = cycle(&problem, &[holds], Period::Seconds(2.0));
    assert_eq!(found, Err(CycleError::Lost));
}

/// A mass whose impacts die out in every cycle: in the next it does the same, and forgets all that was before the contact.
#[test]
fn bounces_that_die_out_in_every_cycle() {
    let system = in_a_row(&[("m", 1.3)], &[92.568], &[1.82]);
    let ask = Response::of(&system).load("m", Harmonic::of(2.6, 4.85));
    let problem = ask.every(0.1).until(32.388).problem().expect("a problem");
    let stop = Switch::Impact(Impact {
        between: [GROUND.into(), "m".into()],
        gap: 0.0,
        restitution: 0.5,
    });
    let switching = Switching::new(&problem, vec![stop]).expect("switches");
    let cycle = switching.limit_cycle(Period::Cycles(1)).expect("a cycle");
    close(cycle.period, TAU / 4.85, 1e-15);
    assert_eq!(cycle.stable, Some(true));
    assert!(cycle.multipliers.iter().all(|one| one.norm() < 1e-9));
    // The contact is left as m x″ turns away from the stop: the load alone passes 0 there, once a cycle.
    let leaves = cycle
        .events
        .iter()
        .filter(|event| event.kind == EventKind::Release);
    let leaves: Vec<f64> = leaves.map(|event| event.time).collect();
    assert_eq!(leaves.len(), 1);
    close(leaves[0], PI / 4.85, 1e-14);
}

/// A stable motion of one period, while the motion itself tends to one of two.
#[test]
fn what_the_motion_does_not_come_to_is_said() {
    let system = in_a_row(&[("m", 0.782)], &[53.7], &[0.33]);
    let stop = |between: [&str; 2], [gap, stiffness, damping]: [f64; 3]| {
        Switch::Stop(Stop {
            between: between.map(String::from),
            gap,
            stiffness,
            damping,
        })
    };
    let switches = [
        stop(["m", GROUND], [0.139, 134.0, 0.0]),
        stop([GROUND, "m"], [0.0532, 1180.0, 0.181]),
    ];
    let start = State::at_rest().displace("m", 0.0242);
    let start = start.push("m", 0.851_251_169_965_867_2);
    let found = |end: f64, count: u32| {
        let ask = Response::of(&system)
            .load("m", Harmonic::of(2.48, 20.7).with_phase(0.7))
            .load("m", Step::of(1.42))
            .from(start.clone());
        let problem = ask.every(0.1).until(end).problem().expect("a problem");
        let found = cycle(&problem, &switches, Period::Cycles(count)).expect("a cycle");
        assert_eq!(found.stable, Some(true));
        found
    };
    let (one, two) = (found(5.0, 1), found(40.0, 2));
    // After 5 s it is on its way to that of two periods, by the factor 0.87 in each of them.
    let reached = [&one, &two, &found(5.0, 2)].map(|cycle| cycle.is_reached);
    assert_eq!(reached, [false, true, false]);
    close(two.period, 2.0 * TAU / 20.7, 1e-15);
    assert!((one.displacement[0] - two.displacement[0]).abs() > 1e-3);
}

/// A motion that dies out comes to rest, which any period fits: with one that its events showed, and with a given one; about 1 cm and
/// about 0.
#[test]
fn what_comes_to_rest_has_no_period() {
    let system = in_a_row(&[("m", 1.0)], &[100.0], &[0.3]);
    for force in [1.0, 0.0] {
        let stop = Switch::Stop(Stop {
            between: [GROUND.into(), "m".into()],
            gap: 0.01 * force + 0.002,
            stiffness: 50.0,
            damping: 0.0,
        });
        let problem = Response::of(&system)
            .load("m", Step::of(force))
            .from(State::at_rest().displace("m", 0.5))
            .every(0.01)
            .until(5.0)
            .problem()
            .expect("a problem");
        let stop = [stop];
        for (switches, period) in [
            (&stop[..], Period::Free),
            (&stop, Period::Seconds(0.6)),
            (&[], Period::Seconds(0.6)),
        ] {
            let found = cycle(&problem, switches, period);
            assert_eq!(found, Err(CycleError::Lost), "{force}: {period:?}");
        }
    }
}

/// A support that swings and touches nothing moves nothing.
#[test]
fn what_rests_beside_a_support_that_swings_has_no_period() {
    let system = System::builder().mass("m", 1.0).support("s");
    let system = system.spring(GROUND, "m", 4.0).damper(GROUND, "m", 0.5);
    let system = system.build().expect("a system");
    for quantity in [Quantity::Displacement, Quantity::Acceleration] {
        let asked = Response::of(&system).motion("s", quantity, Harmonic::of(1.0, 2.0));
        let problem = asked.every(0.5).until(50.0).problem().expect("a problem");
        let found = cycle(&problem, &[], Period::Cycles(1));
        assert_eq!(found, Err(CycleError::Lost));
    }
}

/// Beside a driven mass another rests on a damper that is controlled: beside the ground on-off damping is high, as v_b² is never
/// negative, and a clipped one is that of the sky, so that disturbances fall by e^{−cT/2m}. Between two that rest no law is linear.
#[test]
fn dampers_at_rest_answer_disturbances_by_their_laws() {
    let clipped = |sky| DamperLaw::ClippedSkyhook { sky };
    let cases = [
        (DamperLaw::OnOffSkyhook, 4.0),
        (clipped(3.0), 3.0),
        (clipped(0.25), 0.5),
        (clipped(7.0), 4.0),
    ];
    let chain = || {
        System::builder()
            .mass("a", 1.0)
            .mass("b", 1.0)
            .mass("c", 1.0)
            .spring(GROUND, "a", 9.0)
            .spring(GROUND, "b", 9.0)
            .spring(GROUND, "c", 9.0)
            .damper(GROUND, "a", 0.5)
            .damper(GROUND, "c", 0.25)
    };
    let damper = |from: &str, law| {
        Switch::ControlledDamper(ControlledDamper {
            between: [from.to_owned(), "b".to_owned()],
            law,
            low: 0.5,
            high: 4.0,
        })
    };
    let system = chain().damper(GROUND, "b", -1.0).build().expect("a system");
    let found = |system: &System, damper: Switch| {
        let ask = Response::of(system).load("a", Harmonic::of(1.0, 2.0));
        let problem = ask.every(1.0).until(60.0).problem().expect("a problem");
        cycle(&problem, &[damper], Period::Cycles(1))
    };
    for (law, damping) in cases {
        let found = found(&system, damper(GROUND, law)).expect("a cycle");
        // Over a period of π s.
        let decays = [0.5, 0.25, damping - 1.0].map(|c| (-0.5 * c * std::f64::consts::PI).exp());
        for decay in decays {
            let each = found.multipliers.iter();
            let near = each.filter(|one| (one.norm() - decay).abs() < 1e-9 * decay);
            assert_eq!(near.count(), 2, "{law:?}");
        }
        assert_eq!(found.stable, Some(damping > 1.0), "{law:?}");
        assert!(found.events.is_empty());
    }
    let system = chain().build().expect("a system");
    let none = found(&system, damper("c", DamperLaw::OnOffSkyhook));
    let is_none = matches!(none, Err(CycleError::NoMultipliers { .. }));
    assert!(is_none, "{none:?}");
}
