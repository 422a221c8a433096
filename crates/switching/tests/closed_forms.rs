//! Motions with events against their closed forms.

use std::f64::consts::PI;

use eigentone_modes::{Bounds, GROUND, Precision, System};
use eigentone_response::{Harmonic, Quantity, Ramp, Response, ResponseError, State, Step};
use eigentone_switching::{
    ControlledDamper, DamperLaw, EventKind, Friction, Impact, Stop, Switch, SwitchedMotion,
    Switching, SwitchingError,
};

use crate::row::in_a_row;

/// In which three frictions may be listed.
const ORDERS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [0, 2, 1],
    [1, 0, 2],
    [1, 2, 0],
    [2, 0, 1],
    [2, 1, 0],
];

fn friction(a: &str, b: &str, force: f64, static_force: f64) -> Switch {
    Switch::Friction(Friction {
        between: [a.into(), b.into()],
        force,
        static_force,
    })
}

fn impact(a: &str, b: &str, gap: f64, restitution: f64) -> Switch {
    Switch::Impact(Impact {
        between: [a.into(), b.into()],
        gap,
        restitution,
    })
}

fn run(response: Response<'_>, switches: Vec<Switch>) -> SwitchedMotion {
    let problem = response.problem().expect("a problem");
    let motion = Switching::new(&problem, switches).expect("switches").run();
    motion.unwrap_or_else(|error| panic!("{error}"))
}

fn close(found: f64, wanted: f64, relative: f64) {
    let off = (found - wanted).abs();
    assert!(off <= relative * wanted.abs(), "{found:?} for {wanted:?}");
}

/// Three frictions hold 3.754 N at most, and a mass is pulled by 3.5 N; but two of them are on a support that sets out, so that they
/// do not hold it to the ground with the third. All slide, with 2.4 N, in whatever order they are listed.
#[test]
fn what_nothing_holds_together_slides() {
    let system = System::builder().support("s").mass("m", 2.8);
    let system = system.build().expect("a system");
    let given = [("s", 0.6, 0.623), (GROUND, 1.4, 2.451), ("s", 0.4, 0.68)];
    for (order, turned) in ORDERS
        .iter()
        .flat_map(|order| (0..8).map(move |turned| (order, turned)))
    {
        let switches = order.map(|k| {
            let (a, force, most) = given[k];
            match turned >> k & 1 {
                0 => friction(a, "m", force, most),
                _ => friction("m", a, force, most),
            }
        });
        let ask = Response::of(&system).load("m", Step::of(-3.5));
        let ask = ask.motion("s", Quantity::Velocity, Harmonic::of(0.13, 3.86));
        let motion = run(ask.every(0.25).until(0.75), switches.to_vec());
        let found = motion.trajectory().displacement();
        (0..4).for_each(|k| {
            let t = 0.25 * k as f64;
            close(found[(0, k)], -1.1 / 2.8 * t * t / 2.0, 1e-14);
        });
    }
}

/// Frictions hold one mass to the ground, twice, another to the ground, and both to each other, so that how they share what they
/// hold is free. They hold until no forces within their limits do: that of the masses on each other holds 2.7 N, more than the
/// 2.5 N of those that hold the first mass, and so a pull at the second moves both, at 3.6 N, in whatever order they are listed.
#[test]
fn frictions_in_a_loop_give_way_at_the_limit_load() {
    const RATE: f64 = 4.0;
    let system = in_a_row(&[("a", 1.0), ("b", 2.0)], &[], &[]);
    let given = [
        (GROUND, "a", 1.4, 1.8),
        (GROUND, "a", 0.5, 0.7),
        (GROUND, "b", 1.1, 1.1),
        ("a", "b", 1.9, 2.7),
    ];
    let pick = |number: usize| {
        let mut rest: Vec<usize> = (0..4).collect();
        [number % 4, number / 4 % 3, number / 12, 0].map(|at| rest.remove(at))
    };
    for number in 0..24 {
        let order = pick(number);
        let switches = order.map(|k| {
            let (a, b, force, most) = given[k];
            friction(a, b, force, most)
        });
        let ask = Response::of(&system).load("b", Ramp::of(RATE));
        let motion = run(ask.every(0.25).until(1.25), switches.to_vec());
        let start = 3.6 / RATE;
        let first: Vec<usize> = motion
            .events()
            .iter()
            .map(|event| order[event.switch])
            .collect();
        assert!(
            motion
                .events()
                .iter()
                .all(|event| (event.time - start).abs() < 1e-14)
        );
        assert!(
            first.len() == 3 && !first.contains(&3),
            "{order:?}: {first:?}"
        );
        // 3 a″ = 4 t − 3 from there on, until the masses part at 1.35 s.
        let t = 1.25 - start;
        let moved = (0.6 * t * t / 2.0 + RATE * t * t * t / 6.0) / 3.0;
        let found = motion.trajectory().displacement();
        (0..2).for_each(|i| close(found[(i, 5)], moved, 1e-14));
    }
}

/// Each half swing of π/ω loses 2F/k: x turns at x₀ − 2jF/k, and rests once that is within F/k.
#[test]
fn friction_takes_the_same_from_every_swing() {
    let (m, k, f, x0) = (1.3, 57.0, 2.0, 0.3);
    let system = in_a_row(&[("m", m)], &[k], &[]);
    let swing = PI / (k / m).sqrt();
    for precision in [Precision::default(), Precision::Double] {
        let ask = Response::of(&system).from(State::at_rest().displace("m", x0));
        let ask = ask.every(swing / 7.3).until(12.0 * swing).to(precision);
        let motion = run(ask, vec![friction(GROUND, "m", f, f)]);
        let events = motion.events();
        // 0.3 − 2j·0.0351 is within 0.0351 at j = 4.
        let halves = (1..)
            .find(|j| x0 - 2.0 * f64::from(*j) * f / k <= f / k)
            .expect("it rests");
        for event in events {
            println!("{event:?}");
        }
        assert_eq!(
            events.len(),
            halves as usize + usize::from(events[0].time == 0.0)
        );
        let last = events.last().expect("events");
        assert_eq!(last.kind, EventKind::Stick);
        close(last.time, f64::from(halves) * swing, 1e-14);
        let rest =
            (x0 - 2.0 * f64::from(halves) * f / k) * if halves % 2 == 0 { 1.0 } else { -1.0 };
        let found = motion.trajectory().displacement();
        let digits = if precision == Precision::Double {
            1e-12
        } else {
            1e-14
        };
        close(found[(0, found.ncols() - 1)], rest, digits);
        println!("{:?}", motion.trajectory().displacement_bound().last());
    }
}

/// A support moves as 1e6 m·sin(t/µs) below 1 kg that 5e17 N drag along, so that in units of 1e6 m and µs the speeds are cos t and t/2 until they
/// meet. However far a support moves, the mass stays a mass.
#[test]
fn what_a_support_drags_very_far_has_a_mass() {
    let system = System::builder().support("s").mass("m", 1.0);
    let system = system.build().expect("a system");
    let ask = Response::of(&system);
    let ask = ask.motion("s", Quantity::Displacement, Harmonic::of(1e6, 1e6));
    let motion = run(
        ask.every(1e-7).until(2e-6),
        vec![friction("s", "m", 5e17, 5e17)],
    );
    close(motion.events()[0].time, 1.0298665293222589 * 1e-6, 1e-13);
}

/// Two masses stick together and slide on the ground until they stop at 1/3 s, where 5 N turn them round. While the force of the ground
/// turns from 1 N to 2 N the other way, the friction between them carries 2 to 3.5 N of its 4 N: it holds. In whatever order they are listed.
#[test]
fn what_has_held_outlasts_what_turns_round() {
    let system = in_a_row(&[("a", 1.0), ("b", 1.0)], &[], &[]);
    let switches = || {
        vec![
            friction("a", "b", 2.0, 4.0),
            friction(GROUND, "b", 1.0, 2.0),
        ]
    };
    for precision in [Precision::default(), Precision::Double] {
        for listed in [switches(), switches().into_iter().rev().collect()] {
            let from = State::at_rest().push("a", -1.0);
            let ask = Response::of(&system)
                .from(from.push("b", -1.0))
                .load("a", Step::of(5.0));
            let motion = run(ask.every(0.5).until(1.0).to(precision), listed);
            for i in 0..2 {
                close(
                    motion.trajectory().displacement()[(i, 2)],
                    5.0 / 18.0,
                    1e-14,
                );
            }
        }
    }
}

/// Of two masses on each other, pulled by 2.5 N, the lower one slides on the ground and the upper one stays on it, or the upper one slides and
/// the lower one stays: each friction would hold 2 N, and both are asked for 2.5 N at once.
#[test]
fn what_gives_way_of_two_at_once_is_not_guessed() {
    let system = in_a_row(&[("a", 1.0), ("b", 1.0)], &[], &[]);
    let run = |limits: [f64; 2], turned: u8| {
        let [mut lower, mut upper] = [[GROUND, "a"], ["a", "b"]];
        match turned {
            1 => lower.reverse(),
            2 => upper.reverse(),
            _ => {}
        }
        let switches = vec![
            friction(lower[0], lower[1], 1.0, limits[0]),
            friction(upper[0], upper[1], 1.0, limits[1]),
        ];
        let ask = Response::of(&system).load("b", Step::of(2.5));
        let problem = ask.every(0.5).until(1.0).problem().expect("a problem");
        Switching::new(&problem, switches).expect("switches").run()
    };
    for turned in 0..3 {
        let error = run([2.0, 2.0], turned).expect_err("either may give way");
        assert!(
            matches!(error, SwitchingError::Undecided { time: 0.0, .. })
                && error.to_string().contains("at their limits at once"),
            "{error}"
        );
        let names = ["lower".to_owned(), "upper".to_owned()];
        let (said, named) = (error.to_string(), error.with_names(&names));
        let switch = error.switch().expect("a switch");
        assert_eq!(
            named,
            said.replace(&format!("switch {switch}"), &names[switch])
        );
        assert_ne!(named, said);
        // The one with the lower limit: both at 0.75 m/s², or the upper one alone at 1.5 m/s².
        for (limits, wanted) in [([1.9, 2.0], [0.375, 0.375]), ([2.0, 1.9], [0.0, 0.75])] {
            let motion = run(limits, turned).expect("a motion");
            for (i, wanted) in wanted.into_iter().enumerate() {
                let found = motion.trajectory().displacement()[(i, 2)];
                let off = (found - wanted).abs();
                assert!(off <= 1e-14, "{turned}: {found} {wanted}");
            }
        }
    }
}

/// The lower of two masses needs 1.9 N of the 2 N that hold it on the ground. As loads rise to 2.2 N on the upper one and 2.1 N in
/// all, be it at once or in a while, the ground is asked for 2 N when the upper mass is asked for 1.1 N: both slide on it
/// with (2.1 − 1)/2 m/s².
#[test]
fn loads_that_jump_are_the_limit_of_ramps() {
    let system = in_a_row(&[("a", 1.0), ("b", 1.0)], &[], &[]);
    for rise in [0.0, 1e-3, 1e-6] {
        let mut ask = Response::of(&system).load("a", Step::of(1.9));
        for (mass, force) in [("a", -2.0), ("b", 2.2)] {
            ask = match rise {
                0.0 => ask.load(mass, Step::of(force).starting_at(1.0)),
                rise => ask
                    .load(mass, Ramp::of(force / rise).starting_at(1.0))
                    .load(mass, Ramp::of(-force / rise).starting_at(1.0 + rise)),
            };
        }
        let ask = ask.every(0.5).until(2.0);
        let [ground, upper] = [
            friction(GROUND, "a", 1.0, 2.0),
            friction("a", "b", 1.0, 2.0),
        ];
        for switches in [[ground.clone(), upper.clone()], [upper, ground]] {
            let motion = run(ask.clone(), switches.to_vec());
            for i in 0..2 {
                let found = motion.trajectory().displacement()[(i, 4)];
                let off = (found - 0.275).abs();
                assert!(off <= 1e-15 + 2.0 * rise, "{rise}: {found}");
            }
        }
    }
}

/// A mass that lies on the ground stays there as a plate on it turns, though the plate could as well take it along; one that moves
/// with the plate does so until that turns, where it would have to slide on the ground the other way.
#[test]
fn what_turns_under_a_mass_takes_nothing_along() {
    let (amplitude, frequency) = (0.05, 4.0);
    let system = System::builder()
        .mass("m", 1.0)
        .support("plate")
        .build()
        .expect("a system");
    let swing = Harmonic::of(amplitude, frequency);
    let from = |speed| {
        Response::of(&system)
            .from(State::at_rest().push("m", speed))
            .motion("plate", Quantity::Displacement, swing)
            .every(0.125)
            .until(2.0)
    };
    let cases = [
        // At the turns m a = 0.8 N: the plate could hold that and the ground's 1 N.
        (0.0, [1.0, 3.0], [1.0, 2.0]),
        // It holds 2.5 N − 0.8 N before the turn, and would hold 2.5 N + 0.8 N after it.
        (amplitude * frequency, [2.5, 3.45], [1.92, 2.98]),
    ];
    for (speed, on_ground, on_plate) in cases {
        let ground = friction(GROUND, "m", on_ground[0], on_ground[1]);
        let plate = friction("plate", "m", on_plate[0], on_plate[1]);
        for switches in [[ground.clone(), plate.clone()], [plate, ground]] {
            let motion = run(from(speed), switches.to_vec());
            let x = motion.trajectory().displacement();
            for (k, time) in motion.trajectory().times().iter().enumerate() {
                let wanted = match speed {
                    0.0 => 0.0,
                    _ => amplitude * (frequency * time.min(PI / 2.0 / frequency)).sin(),
                };
                assert!(
                    (x[(0, k)] - wanted).abs() < 1e-15,
                    "{time}: {} {wanted}",
                    x[(0, k)]
                );
            }
        }
    }
}

/// Two masses that are held by the ground and by each other stay wherever some share of the loads is within all limits: with r on the
/// second one by the first, the ground holds them with r − L₀ and −r − L₁.
#[test]
fn three_frictions_hold_what_some_share_of_them_holds() {
    let system = in_a_row(&[("a", 1.3), ("b", 2.13)], &[], &[]);
    let limits = [7.68, 6.78, 6.54];
    let each = [
        friction(GROUND, "a", 7.25, limits[0]),
        friction(GROUND, "b", 4.42, limits[1]),
        friction("a", "b", 5.1, limits[2]),
    ];
    let mut held = 0;
    for (i, j) in (0..18).flat_map(|i| (0..18).map(move |j| (i, j))) {
        let loads = [i, j].map(|k| 1.7 * f64::from(k) - 14.9);
        let least = (loads[0] - limits[0])
            .max(-loads[1] - limits[1])
            .max(-limits[2]);
        let most = (loads[0] + limits[0])
            .min(-loads[1] + limits[1])
            .min(limits[2]);
        if most < least + 1e-3 {
            continue;
        }
        held += 1;
        for order in ORDERS {
            let ask = Response::of(&system).load("a", Step::of(loads[0]));
            let ask = ask.load("b", Step::of(loads[1])).every(0.5).until(1.0);
            let motion = run(ask, order.map(|k| each[k].clone()).to_vec());
            let x = motion.trajectory().displacement();
            assert!(
                x[(0, 2)] == 0.0 && x[(1, 2)] == 0.0,
                "{loads:?} {order:?} {x:?}"
            );
        }
    }
    assert!(held > 100, "{held}");
}

/// A ball that falls from h bounces after √(2h/g)·(1 + 2r + 2r² + …) s.
#[test]
fn a_ball_bounces_until_it_lies() {
    let (m, g, h, r) = (0.7, 9.81, 1.0, 0.8);
    let system = System::builder().mass("ball", m).build().expect("a system");
    for precision in [Precision::default(), Precision::Double] {
        let ask = Response::of(&system)
            .from(State::at_rest().displace("ball", h))
            .load("ball", Step::of(-m * g));
        let ask = ask.every(0.125).until(6.0).to(precision);
        // ground − ball reaches 0.
        let motion = run(ask, vec![impact("ball", GROUND, 0.0, r)]);
        let fall = (2.0 * h / (m * g / m)).sqrt();
        let hits: Vec<f64> = motion
            .events()
            .iter()
            .filter(|e| e.kind == EventKind::Impact)
            .map(|e| e.time)
            .collect();
        let mut time = fall;
        for (j, hit) in hits.iter().take(30).enumerate() {
            close(*hit, time, 1e-14);
            time += 2.0 * fall * r.powi(j as i32 + 1);
        }
        let last = motion.events().last().expect("events");
        println!(
            "{} {last:?} {:?}",
            hits.len(),
            motion.trajectory().displacement_bound()
        );
        assert_eq!(last.kind, EventKind::Contact);
        close(last.time, fall * (1.0 + r) / (1.0 - r), 1e-14);
        assert!((motion.trajectory().displacement()[(0, 48)]).abs() < 1e-15);
        if precision == Precision::default() {
            assert_eq!(motion.trajectory().bounds(), Bounds::Proven);
        }
    }
}

/// A mass on a belt of speed u sticks until the spring has stretched to F_s/k, and then slides.
#[test]
fn a_belt_makes_stick_and_slip() {
    let (m, k, u, fk, fs) = (1.0, 100.0, 0.5, 3.0, 5.0);
    let system = System::builder()
        .mass("m", m)
        .spring(GROUND, "m", k)
        .support("belt")
        .damper("belt", "m", 0.0)
        .build();
    let system = system.expect("a system");
    for precision in [Precision::default(), Precision::Double] {
        let ask = Response::of(&system)
            .motion("belt", Quantity::Displacement, Ramp::of(u))
            .from(State::at_rest().push("m", u));
        let ask = ask.every(0.01).until(4.0).to(precision);
        let motion = run(ask, vec![friction("belt", "m", fk, fs)]);
        let events = motion.events();
        for event in events.iter().take(8) {
            println!("{event:?}");
        }
        close(events[0].time, fs / k / u, 1e-14);
        assert_eq!(events[0].kind, EventKind::Slip);
        // From x = fs/k, v = u about fk/k: back at v = u after the slip of 2(π − atan(Δ ω/u))/ω, Δ = (fs − fk)/k.
        let w = (k / m).sqrt();
        let slip = 2.0 * (PI - ((fs - fk) / k * w / u).atan()) / w;
        close(events[1].time - events[0].time, slip, 1e-13);
        let stick = 2.0 * (fs - fk) / k / u;
        close(events[2].time - events[1].time, stick, 1e-13);
    }
}

/// A ball is pushed against a block that a friction holds: each impact lets the block slide a little, by the square of the
/// speed, so that speeds and times shrink by one ratio σ, and bounces have died out after v τ/(1 − σ).
#[test]
fn bounces_on_a_block_that_slides_die_out_in_time() {
    let (block, ball, force, push, r, gap) = (3.0, 1.0, 12.0, 2.0, 0.5, 0.25);
    let system = System::builder()
        .mass("block", block)
        .mass("ball", ball)
        .build();
    let system = system.expect("a system");
    let speed = (2.0 * push / ball * gap).sqrt();
    let first = speed / (push / ball);
    let total = block + ball;
    let slide = (1.0 + r) * ball / total;
    let back = 1.0 - (1.0 + r) * block / total;
    let way = slide * slide * block / (2.0 * force);
    let ratio = (back * back + 2.0 * push / ball * way).sqrt();
    let time = (ratio - back) / (push / ball);
    for precision in [
        Precision::default(),
        Precision::Certified { tolerance: 1e-6 },
        Precision::Double,
    ] {
        let ask = Response::of(&system)
            .load("ball", Step::of(push))
            .every(0.1)
            .until(3.0)
            .to(precision);
        let impacts = impact("block", "ball", gap, r);
        let motion = run(ask, vec![impacts, friction(GROUND, "block", force, force)]);
        let contact = motion
            .events()
            .iter()
            .find(|event| event.kind == EventKind::Contact);
        let contact = contact.expect("it comes to rest on the block");
        let wanted = first + speed * time / (1.0 - ratio);
        let off = (contact.time - wanted).abs();
        assert!(off <= contact.bound + 1e-15, "{contact:?} {wanted:?}");
        assert!(contact.bound < 1e-8, "{contact:?}");
        // Where the block has come to: all ways that it slid.
        let x = motion.trajectory().displacement();
        close(
            x[(0, x.ncols() - 1)],
            speed * speed * way / (1.0 - ratio * ratio),
            1e-12,
        );
    }
}

/// A force that grows and swings breaks a mass loose.
#[test]
fn a_load_breaks_a_mass_loose() {
    let system = System::builder().mass("m", 2.0).build().expect("a system");
    let ask = Response::of(&system)
        .load("m", Harmonic::of(3.0, 2.0))
        .every(0.05)
        .until(10.0);
    let motion = run(ask, vec![friction(GROUND, "m", 1.5, 1.5)]);
    close(motion.events()[0].time, (0.5f64).asin() / 2.0, 1e-14);
    assert_eq!(motion.events()[0].kind, EventKind::Slip);
}

/// A wall that jumps over a mass leaves it nowhere to be; one that jumps away does nothing.
/// A jaw that moves down at 1 m/s takes a mass along from 1.9 s on, and has it on the floor at 2.5 s.
#[test]
fn what_is_jammed_between_stops_is_told() {
    let system = System::builder().mass("m", 1.0).support("jaw");
    let system = system.build().expect("a system");
    let press = |restitution: f64, until: f64| {
        let ask = Response::of(&system).from(State::at_rest().displace("m", 0.1));
        let ask = ask.motion("jaw", Quantity::Displacement, Ramp::of(-1.0));
        let problem = ask.every(0.5).until(until).problem().expect("a problem");
        let jaw = impact("jaw", "m", 2.0, restitution);
        let floor = impact("m", GROUND, 0.5, restitution);
        let switches = Switching::new(&problem, vec![jaw, floor]);
        switches.expect("switches").run()
    };
    let error = press(0.0, 5.0).expect_err("no room is left");
    let SwitchingError::Jammed {
        time,
        switch: 0 | 1,
    } = error
    else {
        panic!("{error}");
    };
    assert!((time - 2.5).abs() < 1e-9, "{time}");
    let motion = press(0.0, 2.0).expect("there is room");
    let found = motion.trajectory();
    assert!((found.displacement()[(0, 4)] - 0.0).abs() < 1e-15);
    let error = press(0.5, 5.0).expect_err("no room is left");
    assert!(
        matches!(error, SwitchingError::Jammed { time, .. } if (time - 2.5).abs() < 1e-9),
        "{error}"
    );
}

#[test]
fn a_wall_may_not_jump_over_a_mass() {
    let system = System::builder()
        .mass("m", 1.0)
        .support("wall")
        .spring(GROUND, "m", 100.0)
        .build()
        .expect("a system");
    let jump = |height: f64| {
        let ask = Response::of(&system).from(State::at_rest().displace("m", 0.1));
        let ask = ask.motion(
            "wall",
            Quantity::Displacement,
            Step::of(height).starting_at(1.0),
        );
        let problem = ask.every(0.5).until(3.0).problem().expect("a problem");
        let switches = vec![impact("wall", "m", 0.12, 0.5)];
        Switching::new(&problem, switches).expect("switches").run()
    };
    assert!(jump(0.3).expect("a motion").events().is_empty());
    let error = jump(-0.3).expect_err("it is inside the wall").to_string();
    assert!(
        error.contains("at t = 1.0 s the stretch is 0.216"),
        "{error}"
    );
}

/// What dampers, friction, a stop and impacts take is what a motion from rest loses: of two masses, the second between a wall
/// and a stop on the first; at least so many events happen.
fn energy_closes(masses: &[f64], end: f64, events: usize) {
    let (spring, damping, gap, stiffness) = (40.0, 1e-4, 0.01, 300.0);
    let names: Vec<String> = (0..masses.len()).map(|i| format!("m{i}")).collect();
    let before = |i: usize| if i == 0 { GROUND } else { &names[i - 1] };
    let mut builder = System::builder();
    for (i, mass) in masses.iter().enumerate() {
        builder = builder
            .mass(&names[i], *mass)
            .spring(before(i), &names[i], spring)
            .damper(before(i), &names[i], damping);
    }
    let system = builder.build().expect("a system");
    let last = names.len() - 1;
    let stop = Stop {
        between: [before(last).into(), names[last].clone()],
        gap,
        stiffness,
        damping: 2e-3,
    };
    let switches = vec![
        impact(GROUND, &names[last], 0.02, 0.9999),
        friction(GROUND, &names[0], 1e-5, 1e-5),
        Switch::Stop(stop),
    ];
    let start = State::at_rest().displace("m0", -1.0);
    let ask = Response::of(&system).from(start).every(end).until(end);
    let problem = ask.to(Precision::Double).problem().expect("a problem");
    let motion = Switching::new(&problem, switches).expect("switches");
    let motion = motion.with_losses().run().expect("a motion");
    let found = motion.events().len();
    assert!(found > events, "{found}");
    // Of all, and of what the stop holds.
    let energy = |k: usize| {
        let trajectory = motion.trajectory();
        let [x, v] = [trajectory.displacement(), trajectory.velocity()];
        let stretch = |i: usize| x[(i, k)] - if i == 0 { 0.0 } else { x[(i - 1, k)] };
        let own = |i: usize| masses[i] * v[(i, k)].powi(2) + spring * stretch(i).powi(2);
        let held = 0.5 * stiffness * (stretch(last) - gap).max(0.0).powi(2);
        (0.5 * (0..=last).map(own).sum::<f64>(), held)
    };
    let (first, last) = (energy(0), energy(1));
    let losses = motion.losses().expect("asked for");
    let all = || losses.dampers.iter().chain(&losses.switches);
    let taken: f64 = all().sum();
    let off = first.0 - last.0 - taken;
    let whole = first.0 + first.1;
    let by_stop = losses.switches[2] - (last.1 - first.1);
    assert!(
        off.abs() < 1e-13 * whole,
        "{off:e} of {whole} J: {losses:?}"
    );
    // Each takes a part that is seen.
    let mut each = all().take(all().count() - 1).chain([&by_stop]);
    assert!(each.all(|taken| *taken > 1e-6 * whole), "{losses:?}");
}

#[test]
fn energy_closes_over_ten_thousand_events() {
    energy_closes(&[1.3], 4000.0, 10_000);
    energy_closes(&[1.3, 0.7], 40.0, 250);
}

/// Two masses, the first on a spring of force kx + qx³: a chain of stops whose force is right at its corners tends to it as
/// the square of their distance.
#[test]
fn a_chain_of_stops_tends_to_a_cubic_spring() {
    let (k, q, between, reach, end) = (40.0, 900.0, 25.0, 0.5, 2.0);
    let start = [0.4, 0.1];
    // Kutta's method of order 4, by small steps.
    let slope = |[a, b, u, v]: [f64; 4]| {
        let pull = between * (b - a);
        [u, v, pull - k * a - q * a.powi(3), -pull - 0.2 * v]
    };
    let plus = |z: [f64; 4], d: [f64; 4], h: f64| std::array::from_fn(|i| z[i] + h * d[i]);
    let (mut z, steps) = ([start[0], start[1], 0.0, 0.0], 20_000);
    let h = end / f64::from(steps);
    for _ in 0..steps {
        let first = slope(z);
        let second = slope(plus(z, first, 0.5 * h));
        let third = slope(plus(z, second, 0.5 * h));
        let last = slope(plus(z, third, h));
        z = std::array::from_fn(|i| {
            z[i] + h / 6.0 * (first[i] + 2.0 * second[i] + 2.0 * third[i] + last[i])
        });
    }
    let off = [8u32, 16, 32].map(|pieces| {
        let corner = |j: u32| reach * f64::from(j) / f64::from(pieces);
        let chord = |j: u32| {
            let (a, b) = (corner(j), corner(j + 1));
            k + q * (a * a + a * b + b * b)
        };
        let system = System::builder()
            .mass("a", 1.0)
            .mass("b", 1.0)
            .spring(GROUND, "a", chord(0))
            .spring("a", "b", between)
            .damper(GROUND, "b", 0.2)
            .build()
            .expect("a system");
        let stops = (1..pieces).flat_map(|j| {
            [[GROUND, "a"], ["a", GROUND]].map(|ends| {
                Switch::Stop(Stop {
                    between: ends.map(str::to_owned),
                    gap: corner(j),
                    stiffness: chord(j) - chord(j - 1),
                    damping: 0.0,
                })
            })
        });
        let from = State::at_rest()
            .displace("a", start[0])
            .displace("b", start[1]);
        let motion = run(
            Response::of(&system).from(from).every(end).until(end),
            stops.collect(),
        );
        let found = motion.trajectory().displacement();
        (found[(0, 1)] - z[0]).hypot(found[(1, 1)] - z[1])
    });
    assert!(off[2] < 2e-3, "{off:?}");
    for pair in off.windows(2) {
        assert!((3.0..6.0).contains(&(pair[0] / pair[1])), "{off:?}");
    }
}

/// A damper that is high while the body rises, against a ground that sinks: where the body turns round it is low, and the
/// friction holds what the high damping would tear loose.
#[test]
fn friction_holds_beside_the_damping_that_follows() {
    let system = System::builder()
        .mass("body", 1.0)
        .support("wheel")
        .build()
        .expect("a system");
    let ask = Response::of(&system)
        .from(State::at_rest().push("body", 1.0))
        .motion("wheel", Quantity::Displacement, Ramp::of(-1.0))
        .every(0.125)
        .until(1.0);
    let damper = Switch::ControlledDamper(ControlledDamper {
        between: ["wheel".to_owned(), "body".to_owned()],
        low: 2.0,
        high: 10.0,
        law: DamperLaw::OnOffSkyhook,
    });
    let hold = friction(GROUND, "body", 1.0, 3.0);
    for switches in [vec![hold.clone(), damper.clone()], vec![damper, hold]] {
        let motion = run(ask.clone(), switches);
        // v′ = −10 (v + 1) − 1.
        let stop = (2.1f64 / 1.1).ln() / 10.0;
        let mut kinds: Vec<EventKind> = motion.events().iter().map(|event| event.kind).collect();
        kinds.sort_by_key(|kind| *kind == EventKind::Switch);
        assert_eq!(kinds, [EventKind::Stick, EventKind::Switch]);
        for event in motion.events() {
            close(event.time, stop, 1e-14);
        }
        let x = motion.trajectory().displacement();
        close(x[(0, x.ncols() - 1)], 0.1 - 1.1 * stop, 1e-14);
    }
}

/// Without switches it is the linear motion.
#[test]
fn no_switch_leaves_the_motion_linear() {
    let system = in_a_row(&[("m", 1.0)], &[4.0], &[]);
    let ask = Response::of(&system).from(State::at_rest().displace("m", 1.0));
    let motion = run(ask.every(0.25).until(10.0), Vec::new());
    assert!(motion.events().is_empty());
    let x = motion.trajectory().displacement();
    for (k, time) in motion.trajectory().times().iter().enumerate() {
        assert!((x[(0, k)] - (2.0 * time).cos()).abs() < 1e-15);
    }
}

/// A mass between two frictions, one on the ground and one on a support that swings: the stronger one holds it, and the
/// other slides the other way at each turn.
#[test]
fn the_stronger_of_two_frictions_holds() {
    let (amplitude, frequency) = (0.1, 4.0);
    let system = System::builder()
        .mass("m", 0.1)
        .support("plate")
        .build()
        .expect("a system");
    let swing = Harmonic::of(amplitude, frequency);
    for (on_ground, on_plate, speed) in [(2.0, 1.0, 0.0), (1.0, 2.0, amplitude * frequency)] {
        let ask = Response::of(&system)
            .from(State::at_rest().push("m", speed))
            .motion("plate", Quantity::Displacement, swing)
            .every(0.125)
            .until(4.0);
        let ground = friction(GROUND, "m", on_ground, on_ground);
        let plate = friction("plate", "m", on_plate, on_plate);
        for switches in [[ground.clone(), plate.clone()], [plate, ground]] {
            let motion = run(ask.clone(), switches.to_vec());
            let turns = motion.events().iter().zip(0..);
            for (event, k) in turns {
                assert_eq!(event.kind, EventKind::Slip);
                close(event.time, (f64::from(k) + 0.5) * PI / frequency, 1e-14);
            }
            assert_eq!(motion.events().len(), 5);
            let x = motion.trajectory().displacement();
            for (k, time) in motion.trajectory().times().iter().enumerate() {
                let wanted = if speed == 0.0 {
                    0.0
                } else {
                    amplitude * (frequency * time).sin()
                };
                assert!(
                    (x[(0, k)] - wanted).abs() < 1e-16,
                    "{time}: {} {wanted}",
                    x[(0, k)]
                );
            }
        }
    }
}

/// A force of 2 N pushes 1 kg over a gap of 1 m: it hits at tₖ = 3 − 2^(1−k) s, and leaves with 2^−k m/s. A load that ends before
/// 3 s leaves it a speed that lasts; one that ends at 3 s leaves none.
#[test]
fn a_load_that_ends_while_bounces_die_out_leaves_their_speed() {
    let system = System::builder().mass("m", 1.0).build().expect("a system");
    let end = 3e6;
    for before in [2f64.powi(-40), 2f64.powi(-44), 2f64.powi(-51), 0.0] {
        for precision in [Precision::default(), Precision::Double] {
            let ask = Response::of(&system)
                .load("m", Step::of(2.0))
                .load("m", Step::of(-2.0).starting_at(3.0 - before));
            let ask = ask.every(1e6).until(end).to(precision);
            let motion = run(ask, vec![impact(GROUND, "m", 1.0, 0.5)]);
            // The load ends as the mass hits with `before`, and so it leaves with half of that.
            let leaves = before / 2.0;
            let wanted = 1.0 - leaves * (end - (3.0 - before));
            let found = motion.trajectory();
            let [x, v] = [found.displacement(), found.velocity()].map(|all| all[(0, 3)]);
            let bound = found.displacement_bound()[3].expect("a bound");
            assert!((x - wanted).abs() <= bound, "{before:e}: {x} for {wanted}");
            assert!(bound < 1e-15, "{bound:e}");
            close(v, -leaves, 1e-14);
        }
    }
}

/// The same mass under a lasting force hits with 2^(1−k) m/s, k = 0, 1, …, and lies there from 3 s on. It leaves with more than
/// 1e-19 of the largest speed 63 times, whether or not the motion is asked for at 3 s.
#[test]
fn bounces_are_those_of_the_motion_at_any_output_step() {
    let system = System::builder().mass("m", 1.0).build().expect("a system");
    for precision in [
        Precision::default(),
        Precision::Certified { tolerance: 1e-6 },
        Precision::Double,
    ] {
        for step in [4.0, 0.8, 0.5, 2f64.powi(-6)] {
            let ask = Response::of(&system).load("m", Step::of(2.0));
            let ask = ask.every(step).until(4.0).to(precision);
            let motion = run(ask, vec![impact(GROUND, "m", 1.0, 0.5)]);
            let (contact, impacts) = motion.events().split_last().expect("events");
            assert_eq!(impacts.len(), 63, "{precision:?} {step}");
            for (impact, k) in impacts.iter().zip(0..) {
                assert_eq!(impact.kind, EventKind::Impact);
                close(impact.time, 3.0 - 2f64.powi(1 - k), 1e-15);
            }
            assert_eq!(contact.kind, EventKind::Contact);
            close(contact.time, 3.0, 1e-15);
            let found = motion.trajectory();
            let bounds = [found.displacement_bound(), found.velocity_bound()];
            for (k, time) in found.times().iter().enumerate() {
                let bounds = bounds.map(|bounds| bounds[k].expect("a bound"));
                assert!(bounds.iter().all(|bound| *bound < 1e-15), "{bounds:?}");
                if *time >= 3.0 {
                    let [x, v] = [found.displacement(), found.velocity()].map(|all| all[(0, k)]);
                    assert!((x - 1.0).abs() <= bounds[0] && v.abs() <= bounds[1]);
                }
            }
        }
    }
}

/// The load ends as the mass hits with 1 m/s: it leaves with the restitution, be it as small as it may.
#[test]
fn a_load_that_ends_at_an_impact_leaves_its_rebound() {
    let system = System::builder().mass("m", 1.0).build().expect("a system");
    for restitution in [1e-13, 1e-30] {
        let ask = Response::of(&system)
            .load("m", Step::of(1.0))
            .load("m", Step::of(-1.0).starting_at(1.0));
        let ask = ask.every(1e6).until(1e6);
        let motion = run(ask, vec![impact(GROUND, "m", 0.5, restitution)]);
        let found = motion.trajectory();
        close(found.velocity()[(0, 1)], -restitution, 1e-14);
        close(
            found.displacement()[(0, 1)],
            0.5 - restitution * (1e6 - 1.0),
            1e-15,
        );
        assert_eq!(motion.events().len(), 1);
    }
}

/// Two masses bounce to rest on the ground, each by itself: at 3 s, and d m nearer at 3 √(1 − d) s. Where both do so at once the
/// motion is refused.
#[test]
fn bounces_side_by_side_die_out_each_in_its_time() {
    let system = in_a_row(&[("a", 1.0), ("b", 1.0)], &[], &[]);
    let run = |nearer: f64| {
        let ask = Response::of(&system)
            .from(State::at_rest().displace("b", nearer))
            .load("a", Step::of(2.0))
            .load("b", Step::of(2.0));
        let problem = ask.every(0.8).until(4.0).problem().expect("a problem");
        let impacts = ["a", "b"].map(|name| impact(GROUND, name, 1.0, 0.5));
        Switching::new(&problem, impacts.to_vec())
            .expect("switches")
            .run()
    };
    for nearer in [1e-4, 1e-9] {
        let motion = run(nearer).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(motion.events().len(), 2 * 64);
        for (switch, wanted) in [3.0, 3.0 * (1.0 - nearer).sqrt()].into_iter().enumerate() {
            let contact = motion.events().iter().rev();
            let mut contact = contact.filter(|event| event.switch == switch);
            let contact = contact.next().expect("events");
            assert_eq!(contact.kind, EventKind::Contact);
            close(contact.time, wanted, 1e-15);
        }
    }
    // Both at once.
    let motion = run(0.0).unwrap_or_else(|error| panic!("{error}"));
    let [.., one, other] = motion.events() else {
        panic!("events")
    };
    for (event, switch) in [(one, 0), (other, 1)] {
        assert_eq!((event.switch, event.kind), (switch, EventKind::Contact));
        close(event.time, 3.0, 1e-15);
    }
}

/// Masses fall on each other and on the ground, where all bounces die out together, and are lifted later. The instants at which all
/// lie still are those of a simulation with 600 digits.
#[test]
fn bounces_on_each_other_die_out_together() {
    let gravity = 9.8125;
    let run = |masses: &[f64], gaps: &[f64], restitutions: &[f64]| {
        let names = [GROUND, "a", "b", "c"];
        let all = masses.iter().zip(&names[1..]);
        let mut system = System::builder();
        for (mass, name) in all.clone() {
            system = system.mass(*name, *mass);
        }
        let system = system.build().expect("a system");
        let weight: f64 = masses.iter().map(|mass| mass * gravity).sum();
        let mut ask = Response::of(&system).load("a", Step::of(-2.0 * weight).starting_at(4.0));
        for (mass, name) in all {
            ask = ask.load(*name, Step::of(mass * gravity));
        }
        let impacts = gaps.iter().zip(restitutions).zip(names.windows(2));
        let impacts = impacts.map(|((gap, r), names)| impact(names[0], names[1], *gap, *r));
        let problem = ask.every(5.0).until(5.0).problem().expect("a problem");
        Switching::new(&problem, impacts.collect())
            .expect("switches")
            .run()
    };
    for (masses, gaps, restitutions, wanted) in [
        (
            &[1.0, 2.0][..],
            &[1.0, 0.5][..],
            &[0.25, 0.125][..],
            0.560_527_360_684_709_2,
        ),
        (
            &[1.0, 0.125],
            &[1.0, 0.5],
            &[0.25, 0.0],
            0.648_682_061_867_357,
        ),
    ] {
        let motion = run(masses, gaps, restitutions).unwrap_or_else(|error| panic!("{error}"));
        let contacts = motion.events().iter();
        let contacts: Vec<_> = contacts
            .filter(|event| event.kind == EventKind::Contact)
            .collect();
        assert!(contacts.len() >= masses.len());
        close(contacts[contacts.len() - 1].time, wanted, 1e-15);
        let (mut place, trajectory) = (0.0, motion.trajectory());
        for (i, gap) in gaps.iter().enumerate() {
            place += gap;
            // Lifted for 1 s by twice the weight.
            close(
                trajectory.displacement()[(i, 1)],
                place - 0.5 * gravity,
                1e-14,
            );
        }
    }
    // Where those of one mass die out between two bounces of another, digits run out.
    let refused = run(&[4.0, 1.0], &[1.0, 1.5], &[0.5, 0.75]);
    assert!(matches!(refused, Err(SwitchingError::Undecided { .. })));
}

/// A ball that keeps 0.9995 of its speed lies still after 87 500 bounces.
#[test]
fn bounces_that_die_out_slowly_have_an_end() {
    let (speed, r) = (1.0, 0.9995);
    let system = System::builder().mass("m", 1.0).build().expect("a system");
    let ask = Response::of(&system)
        .from(State::at_rest().push("m", -speed))
        .load("m", Step::of(1.0));
    // So long after that all the last bounces come in next to no time.
    let ask = ask.every(1e6).until(1e6);
    let motion = run(ask, vec![impact(GROUND, "m", 0.0, r)]);
    let (contact, impacts) = motion.events().split_last().expect("events");
    assert_eq!(contact.kind, EventKind::Contact);
    close(contact.time, 2.0 * speed / (1.0 - r), 1e-12);
    let most = (1e-19f64.ln() / r.ln()).floor();
    assert_eq!(impacts.len() as f64, most);
}

#[test]
fn steps_that_cannot_be_counted_are_no_number() {
    let (steps, rate) = (f64::INFINITY, 1e10);
    let text = SwitchingError::TooLong { steps, rate }.to_string();
    let expected = "it would take over 1e308 more short steps, as the quickest motion is of about 1.0e10 rad/s";
    assert!(text.starts_with(expected), "{text}");
}

/// As many instants as there may be are refused before any memory is taken.
#[test]
fn too_many_instants_are_refused() {
    let body = System::builder().mass("m", 1.0).build().expect("a system");
    let at_rest = || Response::of(&body).every(1e-3).until(1e-3 * 2f64.powi(53));
    let problem = at_rest().problem().expect("a problem");
    let all = Switching::new(&problem, vec![friction(GROUND, "m", 1.0, 1.0)]).expect("switches");
    let error = all.run().expect_err("they are too many");
    let too_large = |error: &SwitchingError| matches!(error, SwitchingError::Response(ResponseError::TooLarge { instants, .. }) if *instants > 1 << 52);
    assert!(too_large(&error), "{error}");
}

/// A mass slides on another that a friction holds, and turns under a pull beyond what either friction holds: the one that has held goes
/// on, and the mass slides back about F/k to rest.
#[test]
fn of_two_frictions_the_one_that_has_held_goes_on() {
    let (speed, k) = (0.5608f64, 10.0);
    let system = System::builder()
        .mass("m0", 2.0)
        .mass("m1", 1.0)
        .spring(GROUND, "m0", k)
        .build()
        .expect("a system");
    let ask = Response::of(&system).from(State::at_rest().push("m0", speed));
    let ask = ask.every(0.5).until(2.0);
    for limit in [1.0, 1.4, 1.6] {
        let switches = vec![
            friction(GROUND, "m1", 1.5, 1.5),
            friction("m1", "m0", 1.0, limit),
        ];
        let motion = run(ask.clone(), switches);
        let found = motion.trajectory().displacement();
        let amplitude = f64::hypot(1.0 / k, speed * (2.0 / k).sqrt());
        close(found[(0, 4)], 3.0 / k - amplitude, 1e-13);
        assert!((0..5).all(|step| found[(1, step)] == 0.0), "{limit}");
    }
}
