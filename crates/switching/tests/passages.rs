//! Supports that jump, beside ever steeper ramps and beside the same elements without switches.

use eigentone_modes::{GROUND, System};
use eigentone_response::{Load, Quantity, Ramp, Response, State, Step, Trajectory};
use eigentone_switching::{
    ControlledDamper, DamperLaw, Friction, Stop, Switch, SwitchedMotion, Switching,
};
use proptest::prelude::*;

const START: f64 = 0.375;

/// The support s at n masses in a chain, each of 1 kg, held by the ground.
fn chain(masses: usize) -> System {
    let mut builder = System::builder().support("s");
    for k in 0..masses {
        builder = builder.mass(format!("m{k}"), 1.0 + 0.5 * k as f64);
        builder = builder.spring(GROUND, format!("m{k}"), 16.0 + 7.0 * k as f64);
    }
    for k in 1..masses {
        builder = builder.damper(format!("m{}", k - 1), format!("m{k}"), 0.3);
    }
    builder.build().expect("a system")
}

fn controlled(a: &str, b: &str, [low, high]: [f64; 2], sky: Option<f64>) -> Switch {
    Switch::ControlledDamper(ControlledDamper {
        between: [a.to_owned(), b.to_owned()],
        low,
        high,
        law: match sky {
            Some(sky) => DamperLaw::ClippedSkyhook { sky },
            None => DamperLaw::OnOffSkyhook,
        },
    })
}

fn stop(a: &str, b: &str, gap: f64, damping: f64) -> Switch {
    Switch::Stop(Stop {
        between: [a.to_owned(), b.to_owned()],
        gap,
        stiffness: 4.0,
        damping,
    })
}

/// The support moves by a height at the start, at once or within a time.
fn ask<'a>(system: &'a System, state: &State, height: f64, within: Option<f64>) -> Response<'a> {
    let motions: Vec<Load> = match within {
        None => vec![Step::of(height).starting_at(START).into()],
        Some(time) => vec![
            Ramp::of(height / time).starting_at(START).into(),
            Ramp::of(-height / time).starting_at(START + time).into(),
        ],
    };
    let ask = Response::of(system)
        .from(state.clone())
        .every(0.125)
        .until(1.0);
    motions.into_iter().fold(ask, |ask, motion| {
        ask.motion("s", Quantity::Displacement, motion)
    })
}

fn run(ask: Response<'_>, switches: &[Switch]) -> Result<SwitchedMotion, String> {
    let problem = ask.problem().expect("a problem");
    let switching = Switching::new(&problem, switches.to_vec()).expect("switches");
    switching
        .with_losses()
        .run()
        .map_err(|error| error.to_string())
}

/// The largest difference after the jump, beside the largest velocity.
fn distance(a: &Trajectory, b: &Trajectory) -> f64 {
    let pairs = [
        (a.displacement(), b.displacement()),
        (a.velocity(), b.velocity()),
    ];
    let later = 4..a.displacement().ncols();
    let mut off = 0.0f64;
    for (a, b) in pairs {
        for k in later.clone() {
            for i in 0..a.nrows() {
                off = off.max((a[(i, k)] - b[(i, k)]).abs());
            }
        }
    }
    off / (a.velocity().norm_max() + 0.01)
}

/// Where nothing switches, a switch is the damper or the spring and damper that it is made of.
#[test]
fn a_jump_passes_what_it_passes_without_switches() {
    let system = chain(1);
    let state = State::at_rest();
    for (element, plain) in [
        (
            controlled("s", "m0", [2.0; 2], None),
            chain_with(|builder| builder.damper("s", "m0", 2.0)),
        ),
        (
            controlled("s", "m0", [2.0; 2], Some(3.0)),
            chain_with(|builder| builder.damper("s", "m0", 2.0)),
        ),
        // Beyond its gap all the time, and pulled back by as much.
        (
            stop("s", "m0", -100.0, 2.0),
            chain_with(|builder| builder.spring("s", "m0", 4.0).damper("s", "m0", 2.0)),
        ),
    ] {
        let pull = match element {
            Switch::Stop(_) => 400.0,
            _ => 0.0,
        };
        let pulled = ask(&system, &state, 1.0, None).load("m0", Step::of(pull));
        let found = run(pulled, std::slice::from_ref(&element)).expect("a motion");
        let wanted = ask(&plain, &state, 1.0, None).run().expect("a motion");
        let off = distance(found.trajectory(), &wanted);
        assert!(off < 1e-14, "{element:?}: {off:e}");
        assert!(wanted.velocity().norm_max() > 0.5);
        let losses = found.losses().expect("asked for");
        assert!(losses.switches[0].is_infinite(), "{losses:?}");
    }
}

fn chain_with(
    add: impl Fn(eigentone_modes::SystemBuilder) -> eigentone_modes::SystemBuilder,
) -> System {
    let builder = System::builder().mass("m0", 1.0).support("s");
    add(builder.spring(GROUND, "m0", 16.0))
        .build()
        .expect("a system")
}

/// A body that goes down at 1 m/s, and a support that jumps up by h: the high damping stops it after a part m/(c₂h) of the passage,
/// and the low one drives it up through the rest.
#[test]
fn a_body_that_turns_in_the_passage_is_driven_by_both_dampings() {
    let system = chain(1);
    let jump = Step::of(1.0);
    let ask = Response::of(&system).from(State::at_rest().push("m0", -1.0));
    let ask = ask
        .motion("s", Quantity::Displacement, jump)
        .every(0.125)
        .until(1.0);
    let motion = run(ask, &[controlled("s", "m0", [0.5, 4.0], None)]).expect("a motion");
    let found = motion.trajectory();
    let off = (found.velocity()[(0, 0)] - 0.5 * (1.0 - 0.25)).abs();
    assert!(off <= found.velocity_bound()[0].expect("proven"), "{off:e}");
}

/// What happens at the last instant has happened there; and a friction takes its force times the jump, the spring of a stop what
/// it then holds.
#[test]
fn a_jump_at_the_end_is_passed_on() {
    let system = chain(1);
    let between = ["s".to_owned(), "m0".to_owned()];
    let friction = Switch::Friction(Friction {
        between: between.clone(),
        force: 0.5,
        static_force: 0.5,
    });
    let switches = [
        friction,
        stop("s", "m0", 0.25, 0.0),
        stop("s", "m0", 0.75, 3.0),
    ];
    let ask = Response::of(&system).every(0.125).until(START);
    let ask = ask.motion(
        "s",
        Quantity::Displacement,
        Step::of(-1.0).starting_at(START),
    );
    let motion = run(ask, &switches).expect("a motion");
    // The second stop damps from 0.75 m on.
    let found = motion.trajectory();
    let off = found.velocity()[(0, 3)] + 3.0 * 0.25;
    assert!(
        off.abs() <= found.velocity_bound()[3].expect("proven"),
        "{off:e}"
    );
    let losses = motion.losses().expect("asked for");
    assert_eq!(
        losses.switches,
        [0.5, 0.5 * 4.0 * 0.75 * 0.75, f64::INFINITY]
    );
}

fn elements(masses: usize) -> impl Strategy<Value = Vec<Switch>> {
    let end = move || prop_oneof![2 => Just("s".to_owned()), 1 => (0..masses).prop_map(|k| format!("m{k}"))];
    let mass = move || (0..masses).prop_map(|k| format!("m{k}"));
    let one = (
        end(),
        mass(),
        0..4usize,
        0.0..3.0f64,
        0.0..3.0f64,
        -0.5..0.8f64,
        any::<bool>(),
    );
    let one = one.prop_filter_map("two ends", |(a, b, kind, low, more, gap, turned)| {
        let (a, b) = if turned { (b, a) } else { (a, b) };
        (a != b).then(|| match kind {
            0 => controlled(&a, &b, [low, low + more], None),
            1 => controlled(&a, &b, [low, low + more], Some(more)),
            2 => stop(&a, &b, gap, low),
            _ => Switch::Friction(Friction {
                between: [a, b],
                force: low,
                static_force: low,
            }),
        })
    });
    prop::collection::vec(one, 1..4)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, ..ProptestConfig::default() })]

    /// As a ramp gets steeper the motion tends to that of a jump.
    #[test]
    fn a_jump_is_the_limit_of_steep_ramps(
        masses in 1..4usize,
        switches in elements(3),
        height in prop_oneof![-2.0..2.0f64, -0.1..0.1f64],
        pushes in prop::collection::vec(-2.0..2.0f64, 3),
        rests in prop_oneof![1 => Just(true), 3 => Just(false)],
    ) {
        let masses = masses.max(1);
        let system = chain(masses);
        let mut state = State::at_rest();
        if !rests {
            for (k, push) in pushes.iter().enumerate().take(masses) {
                state = state.push(format!("m{k}"), *push);
            }
        }
        let known = |name: &str| name == "s" || (0..masses).any(|k| name == format!("m{k}"));
        let switches: Vec<Switch> = switches
            .into_iter()
            .filter(|switch| switch.between().iter().all(|name| known(name)))
            // Of what rests, frictions make the tiniest motions as a ramp passes, which take long.
            .filter(|switch| !rests || !matches!(switch, Switch::Friction(_)))
            .collect();
        let jump = run(ask(&system, &state, height, None), &switches);
        let ramps = [14, 20].map(|power| {
            run(ask(&system, &state, height, Some(2f64.powi(-power))), &switches)
        });
        let [Ok(coarse), Ok(fine)] = ramps else {
            return Ok(());
        };
        // Refused is what no law decides.
        let Ok(jump) = jump else {
            return Err(TestCaseError::reject("refused"));
        };
        let [coarse, fine] = [coarse, fine].map(|ramp| distance(ramp.trajectory(), jump.trajectory()));
        prop_assert!(fine < 1e-3 && fine <= 1e-7 + 0.125 * coarse, "{coarse:e} {fine:e}");
    }
}
