//! Motions that formulas give, by every method that takes them: displacement, velocity and acceleration, of
//! a mass and of a node without one.

use eigentone_digits::DoubleDouble;
use eigentone_modes::{Bounds, GROUND, MatrixKind, Precision, System};
use eigentone_response::{
    ByCertifiedExponential, ByExponential, Extrema, Harmonic, Hold, Impulse, Quantity, Ramp,
    Response, ResponseMethod, Samples, State, Step, methods,
};

use crate::systems::{CANTILEVER, answers, beam, in_a_row, sum as total};

/// A value with its first two derivatives.
type Course = [f64; 3];

fn sum(parts: &[Course]) -> Course {
    [0, 1, 2].map(|k| parts.iter().map(|part| part[k]).sum())
}

fn times(factor: f64, [x, v, a]: Course) -> Course {
    [factor * x, factor * v, factor * a]
}

/// sin(ωt + φ).
fn sine(omega: f64, t: f64, phase: f64) -> Course {
    let (sine, cosine) = (omega * t + phase).sin_cos();
    [sine, omega * cosine, -omega * omega * sine]
}

/// Of the time since `start`, which has passed or not.
fn since(start: f64, t: f64, course: impl Fn(f64) -> Course) -> Course {
    if t > start {
        course(t - start)
    } else {
        [0.0; 3]
    }
}

/// 1e-20 kg on 1 N/m and on 2 N/m, and 1 kg on the difference of the two: det M = 2e-20 kg², which rounding to doubles makes 0. By the
/// exponential of the exact doubles with 240 digits.
#[test]
fn light_masses_within_a_heavy_one_are_no_constraint() {
    let system = System::builder()
        .mass("a", 1e-20)
        .mass("b", 1e-20)
        .point("p", [("a", 1.0), ("b", -1.0)], 1.0)
        .spring(GROUND, "a", 1.0)
        .spring(GROUND, "b", 2.0)
        .build()
        .expect("a system");
    let response = Response::of(&system).from(State::at_rest().displace("a", 1.0));
    let motion = response.every(0.5).until(1.0).run().expect("a motion");
    let truth = [
        [0.290_136_607_276_965_2, -0.627_681_055_857_589_6],
        [0.744_292_533_294_37, 0.059_514_007_770_819_72],
    ];
    for (k, truth) in truth.into_iter().enumerate() {
        for (i, truth) in truth.into_iter().enumerate() {
            let found = motion.displacement()[(i, k + 1)];
            assert!((found - truth).abs() < 1e-15, "{i}, {k}: {found}");
        }
    }
}

/// A mass on a spring to a node without mass, and that on another to the ground.
fn beside_a_node() -> System {
    let system = System::builder().mass("m", 2.0).mass("p", 0.0);
    let system = system.spring("m", "p", 3.0).spring("p", GROUND, 6.0);
    system.build().expect("a system")
}

/// 2 kg on 3 N/m to a node without mass, and that on 6 N/m to the ground: ω = 1/s, and a force f on the
/// node moves the mass as f/3 would. The node itself is at (3x + f)/9.
#[test]
fn a_node_without_mass_follows_its_force_at_once() {
    let system = beside_a_node();
    let (omega, phase) = (0.5, 0.3);
    let (step, ramp, impulse) = (0.75, 1.5, 2.25);
    let asked = Response::of(&system)
        .from(State::at_rest().displace("m", 0.25).push("m", -0.5))
        .load("p", Harmonic::of(9.0, omega).with_phase(phase))
        .load("p", Step::of(9.0).starting_at(step))
        .load("p", Ramp::of(9.0).starting_at(ramp))
        .load("m", Impulse::of(4.0))
        .load("m", Impulse::of(-3.0).at(impulse))
        .every(0.4)
        .until(40.0)
        .with_acceleration();
    let swing = |t: f64| sine(1.0, t, 0.0);
    let motion = |t: f64| {
        // x″ + x = 3/2 sin(t/2 + φ): twice the sine, and what brings the start to rest.
        let forced = sum(&[
            times(2.0, sine(omega, t, phase)),
            times(
                -2.0 * phase.sin(),
                sine(1.0, t, std::f64::consts::FRAC_PI_2),
            ),
            times(-2.0 * omega * phase.cos(), swing(t)),
        ]);
        let stepped = since(step, t, |s| {
            [1.5 * (1.0 - s.cos()), 1.5 * s.sin(), 1.5 * s.cos()]
        });
        let pulled = since(ramp, t, |s| {
            [1.5 * (s - s.sin()), 1.5 * (1.0 - s.cos()), 1.5 * s.sin()]
        });
        let swung = since(impulse, t, |s| times(-1.5, swing(s)));
        let begun = sum(&[
            times(0.25, sine(1.0, t, std::f64::consts::FRAC_PI_2)),
            times(-0.5 + 2.0, swing(t)),
        ]);
        sum(&[forced, stepped, pulled, swung, begun])
    };
    let force = |t: f64| {
        sum(&[
            times(9.0, sine(omega, t, phase)),
            since(step, t, |_| [9.0, 0.0, 0.0]),
            since(ramp, t, |s| [9.0 * s, 9.0, 0.0]),
        ])
    };
    let problem = asked.problem().expect("well posed");
    let answers = answers(&problem);
    for (method, found) in &answers {
        let acceleration = found.acceleration().expect("asked for");
        let kinds = [found.displacement(), found.velocity(), acceleration];
        assert_eq!(found.len(), 101);
        for j in 0..found.len() {
            let t = 0.4 * found.steps()[j] as f64;
            let mass = motion(t);
            let node = times(1.0 / 9.0, sum(&[times(3.0, mass), force(t)]));
            for (kind, values) in kinds.iter().enumerate() {
                for (i, wanted) in [mass[kind], node[kind]].into_iter().enumerate() {
                    let off = (values[(i, j)] - wanted).abs();
                    // The ramp ends at 350 N and the mass at 60 m.
                    assert!(off < 1e-12, "{method}: {kind} of {i} at {t}: {off:e}");
                }
            }
        }
    }
    for name in ["exponential", "superposition"] {
        assert!(answers.iter().any(|(method, _)| *method == name), "{name}");
    }
}

/// The same two under forces of any size that set in at once: the node stands at f/9 and moves at f′/9 from the first
/// instant on, and the mass is accelerated by 3/2 of where the node stands.
#[test]
fn forces_of_any_size_act_at_once() {
    let system = beside_a_node();
    for size in [1e-9, 1.0, 1e9] {
        let asked = Response::of(&system)
            .load("p", Step::of(9.0 * size))
            .load("p", Ramp::of(18.0 * size))
            .every(0.5)
            .until(5.0)
            .with_acceleration();
        let problem = asked.problem().expect("well posed");
        for (method, found) in answers(&problem) {
            let acceleration = found.acceleration().expect("asked for");
            let kinds = [found.displacement(), found.velocity(), acceleration];
            let wanted = [[0.0, 0.0, 1.5], [1.0, 2.0, 0.5]];
            for (kind, values) in kinds.iter().enumerate() {
                for (i, wanted) in wanted.iter().enumerate() {
                    let off = (values[(i, 0)] / size - wanted[kind]).abs();
                    assert!(off < 1e-14, "{method}: {kind} of {i}: {off:e}");
                }
            }
        }
    }
}

/// A damper of 2 and a spring of 4 without a mass under 5 sin t, 2r′ + 4r = 5 sin t, beside a spring of 6 under 3 N that nothing slows:
/// r = sin t − ½ cos t + ½ e^(−2t), whose velocity follows the force at once.
#[test]
fn a_damped_node_without_mass_moves_as_fast_as_its_force_says() {
    let system = System::builder()
        .mass("r", 0.0)
        .mass("p", 0.0)
        .damper(GROUND, "r", 2.0)
        .spring(GROUND, "r", 4.0)
        .spring(GROUND, "p", 6.0)
        .build()
        .expect("a system");
    let asked = Response::of(&system)
        .load("r", Harmonic::of(5.0, 1.0))
        .load("p", Step::of(3.0));
    let problem = asked.every(0.3).until(9.0).with_acceleration();
    let problem = problem.problem().expect("well posed");
    let answers = answers(&problem);
    for (method, found) in &answers {
        let acceleration = found.acceleration().expect("asked for");
        let kinds = [found.displacement(), found.velocity(), acceleration];
        for j in 0..found.len() {
            let t = 0.3 * found.steps()[j] as f64;
            let (sine, cosine) = t.sin_cos();
            let fading = 0.5 * (-2.0 * t).exp();
            let relaxing = [
                sine - 0.5 * cosine + fading,
                cosine + 0.5 * sine - 2.0 * fading,
                -sine + 0.5 * cosine + 4.0 * fading,
            ];
            let still = [0.5, 0.0, 0.0];
            for (kind, values) in kinds.iter().enumerate() {
                for (i, wanted) in [relaxing[kind], still[kind]].into_iter().enumerate() {
                    let off = (values[(i, j)] - wanted).abs();
                    assert!(off < 1e-13, "{method}: {kind} of {i} at {t}: {off:e}");
                }
            }
        }
    }
    assert!(answers.iter().any(|(method, _)| *method == "exponential"));
}

/// A spring alone is f/k long at once: no state, no step, and yet what is rounded has an estimate.
#[test]
fn what_follows_at_once_has_an_estimate() {
    let stiffness = 6e5;
    let system = in_a_row(&[("m", 0.0)], &[stiffness], &[]);
    let values: Vec<f64> = (0..40).map(|k| (1.0 + f64::from(k)).sqrt()).collect();
    let load = Samples {
        step: 0.1,
        values: values.clone(),
        hold: Hold::First,
    };
    let asked = Response::of(&system).load("m", load);
    let asked = asked.every(0.1).until(3.9).to(Precision::Double);
    let found = asked.run().expect("it takes every system");
    assert_eq!(found.bounds(), Bounds::Estimated);
    for (k, force) in values.iter().enumerate() {
        let exact = DoubleDouble::from(*force) / DoubleDouble::from(stiffness);
        let off = (DoubleDouble::from(found.displacement()[(0, k)]) - exact).to_f64();
        let bound = found.displacement_bound()[k].expect("it is passive and held");
        assert!(off.abs() <= bound, "{k}: {off:e} {bound:e}");
        assert!(
            bound <= 1e-14 * found.displacement()[(0, k)],
            "{k}: {bound:e}"
        );
    }
}

/// x″ + 2x′ + x = sin t ends in −½ cos t: after a million seconds, 159155 turns, the angle must still be
/// right to the last digit. cos 1e6 = 0.93675212753314478693…
#[test]
fn angles_are_right_after_a_million_seconds() {
    let system = in_a_row(&[("m", 1.0)], &[1.0], &[2.0]);
    let asked = Response::of(&system).load("m", Harmonic::of(1.0, 1.0));
    let found = asked.every(10.0).until(1e6).run_by(&ByExponential);
    let found = found.expect("it takes every system");
    let off = found.displacement()[(0, found.len() - 1)] + 0.5 * 0.936_752_127_533_144_8;
    assert!(off.abs() < 1e-14, "{off:e}");
}

/// Two unit masses on 1 N/m each and 1.5 N/m between them: ω = 1 and 2. Released from (1, 0) they move as
/// (cos t ± cos 2t)/2, which turn where cos t = ∓1/4, at ∓9/16, and at π.
#[test]
fn extrema_of_every_coordinate_lie_between_the_instants() {
    let system = System::builder()
        .mass("a", 1.0)
        .mass("b", 1.0)
        .spring(GROUND, "a", 1.0)
        .spring(GROUND, "b", 1.0)
        .spring("a", "b", 1.5)
        .build()
        .expect("a system");
    let asked = Response::of(&system).from(State::at_rest().displace("a", 1.0));
    let asked = asked.every(0.7).until(5.6);
    let trajectory = asked.clone().run().expect("a response");
    let problem = asked.problem().expect("well posed");
    let found = Extrema::of(&problem, &trajectory).expect("few enough");
    let turn = 0.25f64.acos();
    let (high, low) = (found.highest(), found.lowest());
    for (extremum, value, time) in [
        (high[0], 1.0, 0.0),
        (low[0], -0.5625, std::f64::consts::PI - turn),
        (high[1], 0.5625, turn),
        (low[1], -1.0, std::f64::consts::PI),
    ] {
        let off = (extremum.displacement - value).abs();
        assert!(off < 1e-12, "{extremum:?} for {value}");
        let off = (extremum.time - time).abs();
        assert!(off < 1e-6, "{extremum:?} at {time}");
    }
}

/// 6 N on 4 N/m move what has no mass to 1.5 at once, and there it stays: it never is at 0.
#[test]
fn what_has_no_mass_begins_where_it_is_moved_to() {
    let system = System::builder()
        .mass("m", 1.0)
        .mass("p", 0.0)
        .spring(GROUND, "m", 1.0)
        .spring(GROUND, "p", 4.0)
        .build()
        .expect("a system");
    let asked = Response::of(&system).load("p", Step::of(6.0));
    let asked = asked.every(0.5).until(2.0);
    let trajectory = asked.clone().run().expect("a response");
    let problem = asked.problem().expect("well posed");
    let found = Extrema::of(&problem, &trajectory).expect("few enough");
    assert_eq!(found.lowest()[1].displacement, 1.5);
    assert_eq!(found.highest()[1].displacement, 1.5);
    assert_eq!(found.lowest()[0].displacement, 0.0);
}

/// Masses on springs with dampers that couple their modes.
fn two_damped_masses() -> System {
    let builder = System::builder().mass("a", 1.0).mass("b", 0.7);
    let builder = builder.spring(GROUND, "a", 4.0).spring("a", "b", 2.0);
    let builder = builder.damper("a", "b", 0.05).damper(GROUND, "b", 0.02);
    builder.build().expect("a system")
}

/// Sinusoids are reduced by whole turns with all digits of 2π that they take, and those that are faster than the system are no part of
/// its exponential: estimates hold for them as for others. An event at 0.37 s makes steps that are no doubles.
#[test]
fn large_phases_and_frequencies_lose_no_digits() {
    let system = two_damped_masses();
    let phases = [1e4, 1e9, 1e17, -1e100, 1.7e308].map(|phase| (2.5, phase));
    let frequencies = [1e2, 1e4, 1e6, 1e9].map(|frequency| (frequency, 0.3));
    for (frequency, phase) in phases.into_iter().chain(frequencies) {
        let load = Harmonic::of(1.0, frequency).with_phase(phase);
        let asked = Response::of(&system).load("a", load).every(0.1).until(10.0);
        let asked = asked.load("b", Step::of(0.01 / frequency).starting_at(0.37));
        let exact = asked.clone().run().expect("well posed");
        assert_eq!(exact.bounds(), Bounds::Proven);
        let problem = asked.to(Precision::Double).problem().expect("well posed");
        for method in &methods()[1..] {
            let found = method.run(&problem).expect("well posed");
            let pairs = [
                (
                    found.displacement(),
                    exact.displacement(),
                    found.displacement_bound(),
                ),
                (found.velocity(), exact.velocity(), found.velocity_bound()),
            ];
            for (kind, (found, exact, bounds)) in pairs.into_iter().enumerate() {
                for (k, bound) in bounds.iter().enumerate() {
                    let bound = bound.expect("passive and held");
                    let off = (found.col(k) - exact.col(k)).norm_max();
                    let proven = 1e-3 * bound;
                    assert!(
                        off <= bound + proven,
                        "{}, {frequency:e}, {phase:e}, order {kind} of step {k}: {off:e} {bound:e}",
                        method.name()
                    );
                    assert!(
                        bound < 1e-8 / frequency,
                        "{frequency:e} {phase:e}: {bound:e}"
                    );
                }
            }
        }
    }
}

/// What is unstable and at rest stays so, however large its motion would become: an oscillator beside it moves as without it,
/// by every method, whatever holds the other, and on long grids too.
#[test]
fn what_nothing_moves_stays_at_rest() {
    let beside = || {
        System::builder()
            .mass("moves", 1.0)
            .mass("rests", 1.0)
            .spring(GROUND, "moves", 4.0)
    };
    let systems = [
        beside().spring(GROUND, "rests", -1e8),
        beside().damper(GROUND, "rests", -1e6),
        beside()
            .damper(GROUND, "moves", 0.0)
            .mass("relaxes", 0.0)
            .damper("rests", "relaxes", 1.0)
            .spring("relaxes", GROUND, -1e8),
        // It drives the other, which does nothing to it.
        beside().spring(GROUND, "rests", -1e8).matrix(
            MatrixKind::Stiffness,
            faer::mat![[0.0, 3.0], [0.0, 0.0]].as_ref(),
        ),
    ];
    for (number, builder) in systems.into_iter().enumerate() {
        let system = builder.build().expect("a system");
        for (step, end) in [(0.5, 10.0), (0.01, 20.0)] {
            let from = State::at_rest().displace("moves", 1.0);
            let asked = Response::of(&system).from(from).every(step).until(end);
            let kicked = asked.clone().load("moves", Impulse::of(2.0).at(0.0));
            for (asked, kick) in [(asked, 0.0), (kicked, 1.0)] {
                let problem = asked.problem().expect("well posed");
                for method in methods() {
                    // Superposition finds no modes of matrices that are not symmetric.
                    if method.refuses(&problem).is_some() {
                        assert_ne!(method.name(), "certified exponential");
                        continue;
                    }
                    let found = method.run(&problem);
                    let found = found.unwrap_or_else(|error| panic!("{}: {error}", method.name()));
                    let place = (system.index_of("moves"), system.index_of("rests"));
                    let (Some(moves), Some(rests)) = place else {
                        panic!("both are there");
                    };
                    for k in 0..found.len() {
                        let t = step * k as f64;
                        let exact = (2.0 * t).cos() + kick * (2.0 * t).sin();
                        let off = (found.displacement()[(moves, k)] - exact).abs();
                        assert!(off < 1e-12, "{number}, {}, {t}: {off:e}", method.name());
                        assert_eq!(found.displacement()[(rests, k)], 0.0);
                        assert_eq!(found.velocity()[(rests, k)], 0.0);
                    }
                }
            }
        }
    }
}

/// A coupling in one way is seen in that way: what moves drives the unstable mass, whose motion exceeds the doubles.
#[test]
fn what_is_driven_does_not_rest() {
    let system = System::builder()
        .mass("moves", 1.0)
        .mass("driven", 1.0)
        .spring(GROUND, "moves", 4.0)
        .spring(GROUND, "driven", -1.0)
        .matrix(
            MatrixKind::Stiffness,
            faer::mat![[0.0, 0.0], [-5.0, 0.0]].as_ref(),
        );
    let system = system.build().expect("a system");
    let from = State::at_rest().displace("moves", 1.0);
    let asked = Response::of(&system).from(from).every(0.5);
    let problem = asked.clone().until(10.0).problem().expect("well posed");
    for (method, found) in answers(&problem) {
        for k in 0..found.len() {
            // y″ = y + 5 cos 2t from rest.
            let t = 0.5 * k as f64;
            let exact = t.cosh() - (2.0 * t).cos();
            let off = (found.displacement()[(1, k)] - exact).abs();
            assert!(off < 1e-11 * t.exp(), "{method}, {t}: {off:e}");
        }
    }
    let overflow = asked.until(1000.0).run();
    assert!(overflow.is_err(), "e^1000 is no double");
}

/// An output whose parts cancel is exactly 0, which no number of digits would show.
#[test]
fn what_is_always_0_takes_few_digits() {
    let system = System::builder()
        .mass("a", 1.0)
        .mass("b", 2.0)
        .point("p", [("a", 0.1)], 0.0)
        .spring(GROUND, "a", 10.0)
        .spring("a", "b", 11.0);
    let system = system.build().expect("a system");
    let displaced = Quantity::Displacement;
    let motions = [
        (displaced, "a", 0.05),
        (displaced, "p", -1.0),
        (displaced, "a", 0.05),
    ];
    let ask = Response::of(&system).from(State::at_rest().displace("a", 1.0));
    let problem = ask.every(0.1).until(2.0).problem().expect("a problem");
    let problem = problem.with_combinations(vec![total("nothing", &motions)]);
    let motion = ByCertifiedExponential.run(&problem.expect("known names"));
    let motion = motion.expect("a motion");
    assert_eq!(motion.digits(), 32);
    assert!(motion.output(0).iter().all(|value| *value == 0.0));
}

/// A cantilever of 40 elements with a dashpot at its tip, of which steps are 2000 radians long: roundings of products count by the
/// norm of sizes, near 1 where a matrix is near I, so that 32 digits suffice. The tip swings about F L³/3EI.
#[test]
fn many_elements_take_few_digits() {
    let beam = beam("b", 40, [2.0, 100.0, 1.2], CANTILEVER);
    let system = System::builder().beam(beam).damper(GROUND, "b.40.w", 1.0);
    let system = system.build().expect("a beam");
    let ask = Response::of(&system).load("b.40.w", Step::of(1.0));
    let problem = ask.every(0.002).until(2.0).problem().expect("a problem");
    let motion = ByCertifiedExponential.run(&problem).expect("a motion");
    assert_eq!(motion.digits(), 32);
    let tip = system.index_of("b.40.w").expect("the tip");
    let peak = (0..motion.len()).map(|k| motion.displacement()[(tip, k)]);
    let (peak, settled) = (peak.fold(0.0, f64::max), 8.0 / 300.0);
    assert!(peak > 1.5 * settled && peak < 2.0 * settled, "{peak}");
}
