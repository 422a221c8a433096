//! Random scenes, right ones and nearly right ones: no panic, numbers or an error, and bounds that agree with
//! each other at every precision. The generators also serve the fuzz targets in `fuzz/`; what those found stands in
//! `tests/random/cases`.

mod choices;
mod damage;
mod edge;
mod estimates;
mod everything;
mod examine;
mod number;
mod scene;

use std::fs;
use std::path::{Path, PathBuf};

use eigentone::modes::{GROUND, System};
use eigentone::scene::{Scene, SceneError};
use proptest::collection::vec;
use proptest::prelude::*;

use choices::Choices;
use estimates::agree_with_estimates;
use everything::{every_command, every_quick_command, peaks_and_settling_hold};
use examine::{Proven, examined, examined_with_switches};

fn parse(text: &str) -> Result<Scene, SceneError> {
    Scene::parse(text, Path::new("scene.json"))
}

/// A refusal is one line that names the file.
fn check_message(error: &SceneError) {
    let message = error.to_string();
    assert!(message.starts_with("scene.json:"), "{message}");
    assert!(message.len() < 1000 && !message.contains('\n'), "{message}");
}

fn bytes() -> impl Strategy<Value = Vec<u8>> {
    vec(any::<u8>(), 0..600)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn scenes_are_answered_in_doubles_or_refused(bytes in bytes()) {
        let text = scene::text(&mut Choices::of(&bytes));
        match parse(&text) {
            Ok(scene) => drop(examined(&scene, Proven::Nothing)),
            Err(error) => check_message(&error),
        }
    }

    #[test]
    fn damaged_scenes_are_answered_or_refused(bytes in bytes(), damage in vec(any::<u8>(), 0..40)) {
        let text = scene::text(&mut Choices::of(&bytes));
        let damaged = damage::damaged(&text, &mut Choices::of(&damage));
        let text = String::from_utf8_lossy(&damaged);
        match parse(&text) {
            // Bytes that are no text are refused before there is a text to parse.
            Ok(_) if matches!(text, std::borrow::Cow::Owned(_)) => {}
            Ok(scene) => drop(examined(&scene, Proven::Nothing)),
            Err(error) => check_message(&error),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Points, supports that move, outputs: proven, and through every command.
    #[test]
    fn machines_are_answered_or_refused(bytes in vec(any::<u8>(), 1..300)) {
        let text = scene::machine(&mut Choices::of(&bytes));
        match parse(&text) {
            Ok(scene) => {
                drop(examined(&scene, Proven::Nothing));
                every_quick_command(&scene);
            }
            Err(error) => check_message(&error),
        }
    }

    #[test]
    fn switched_machines_are_answered_or_refused(bytes in vec(any::<u8>(), 1..300)) {
        let text = scene::switched_machine(&mut Choices::of(&bytes));
        match parse(&text) {
            Ok(scene) => examined_with_switches(&scene),
            Err(error) => check_message(&error),
        }
    }

    /// Few coordinates and instants: proofs of more take longer, and fuzzing looks at those.
    #[test]
    fn proofs_do_not_contradict_each_other(mut bytes in vec(any::<u8>(), 1..400)) {
        bytes[0] %= 3;
        let text = scene::text(&mut Choices::of(&bytes));
        if let Ok(scene) = parse(&text) {
            let few = scene.problem().is_none_or(|problem| problem.is_ok_and(|p| p.grid().last() <= 8));
            let proven = if few { Proven::All } else { Proven::Modes };
            agree_with_estimates(&scene, &examined(&scene, proven));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Free, massless, unstable and resting systems through every command.
    #[test]
    fn every_command_answers_or_refuses(bytes in vec(any::<u8>(), 4..80)) {
        let text = edge::still(&mut Choices::of(&bytes));
        match parse(&text) {
            Ok(scene) => every_command(&scene),
            Err(error) => check_message(&error),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn no_jump_is_missed(bytes in vec(any::<u8>(), 8..80)) {
        let text = edge::jumping(&mut Choices::of(&bytes));
        peaks_and_settling_hold(&parse(&text).expect("it is a scene"));
    }
}

#[test]
fn what_fuzzing_found_stays_mended() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/random/cases");
    let mut files: Vec<PathBuf> = fs::read_dir(folder)
        .expect("it is there")
        .map(|entry| entry.expect("it can be listed").path())
        .collect();
    files.sort();
    assert!(files.len() >= 10);
    for file in files {
        println!("{}", file.display());
        let bytes = fs::read(&file).expect("it can be read");
        // A scene as text, or the choices that make one.
        let text = match file.extension().and_then(|ending| ending.to_str()) {
            Some("json") => String::from_utf8_lossy(&bytes).into_owned(),
            _ => scene::text(&mut Choices::of(&bytes)),
        };
        match parse(&text) {
            Ok(scene) => {
                println!("{text}");
                examined(&scene, Proven::All);
            }
            Err(error) => check_message(&error),
        }
    }
}

fn answered(system: &System) {
    use eigentone::modes::Precision;
    let modes = system.modes().expect("it has modes");
    assert_eq!(
        modes.eigenvalues().len() + modes.infinite(),
        2 * system.len()
    );
    assert!(system.modes_to(Precision::Double).is_ok());
}

/// Alike, apart, without dampers, at the ends of the doubles: what is easily thought of and easily breaks.
#[test]
fn odd_systems_are_answered() {
    let identical = |count: usize| {
        (0..count).fold(System::builder(), |builder, i| {
            builder
                .mass(format!("m{i}"), 2.0)
                .spring(GROUND, format!("m{i}"), 3.0)
        })
    };
    // The same root 300 times.
    let many = identical(300).build().expect("a system");
    answered(&many);
    let roots = many.modes().expect("modes");
    assert!(roots.iter().all(|mode| mode.multiplicity() == Some(300)));
    // Damped alike, and in separate pieces.
    let damped = (0..40).fold(identical(40), |builder, i| {
        builder.damper(GROUND, format!("m{i}"), 0.5)
    });
    answered(&damped.build().expect("a system"));
    let pieces = (0..20).fold(identical(40), |builder, i| {
        builder.spring(format!("m{}", 2 * i), format!("m{}", 2 * i + 1), 1.0)
    });
    answered(&pieces.build().expect("a system"));
    // No springs, no dampers.
    answered(
        &System::builder()
            .mass("a", 1.0)
            .mass("b", 5e-324)
            .build()
            .expect("a system"),
    );
    for (mass, stiffness, damping) in [
        (1e300, 1e-300, 1e-300),
        (1e-300, 1e300, 1e-10),
        (5e-324, 5e-324, 5e-324),
        (2.2250738585072014e-308, 1e-310, 0.0),
        (1.7e308, 1.7e308, 1.7e308),
    ] {
        let system = System::builder()
            .mass("a", mass)
            .spring(GROUND, "a", stiffness)
            .damper(GROUND, "a", damping)
            .build()
            .expect("a system");
        answered(&system);
    }
}

#[test]
fn loads_of_nothing_move_nothing() {
    let text = r#"{"masses": [{"name": "a", "mass": 1}, {"name": "b", "mass": 0}],
        "springs": [{"between": ["a", "b"], "stiffness": 2}, {"between": ["b", "ground"], "stiffness": 2}],
        "loads": [{"on": "a", "step": {"force": 0}}, {"on": "b", "ramp": {"rate": 0}},
            {"on": "a", "impulse": {"magnitude": 0, "at": 0.3}}, {"on": "a", "harmonic": {"amplitude": 0, "frequency": 1}},
            {"on": "b", "samples": {"step": 0.5, "values": [0, 0], "hold": "first"}}],
        "time": {"end": 10, "step": 0.5}}"#;
    let answers = examined(&parse(text).expect("a scene"), Proven::All);
    for motion in [answers.motion, answers.estimated_motion] {
        let motion = motion.expect("a motion");
        assert_eq!(motion.displacement().norm_max(), 0.0);
        assert_eq!(motion.velocity().norm_max(), 0.0);
    }
}

/// Node b has no mass, so that the force on it moves its damper at once: c v = f(t) − K x.
#[test]
fn dampers_without_mass_yield_at_once() {
    let text = r#"{"masses": [{"name": "a", "mass": 2}, {"name": "b", "mass": 0}],
        "springs": [{"between": ["a", "ground"], "stiffness": 2}, {"between": ["b", "ground"], "stiffness": 5}],
        "dampers": [{"between": ["b", "ground"], "damping": 4}],
        "initial": {"b": {"displacement": 0.5}},
        "loads": [{"on": "b", "step": {"force": 8}}],
        "time": {"end": 1, "step": 0.5}}"#;
    let answers = examined(&parse(text).expect("a scene"), Proven::All);
    for motion in [answers.motion, answers.estimated_motion] {
        let motion = motion.expect("a motion");
        // x = 8/5 + (1/2 − 8/5) e^(−5t/4).
        for (k, t) in [0.0, 0.5, 1.0].into_iter().enumerate() {
            let x = 1.6 - 1.1 * (-1.25_f64 * t).exp();
            let v = 1.375 * (-1.25_f64 * t).exp();
            assert!((motion.displacement()[(1, k)] - x).abs() < 1e-15);
            assert!(
                (motion.velocity()[(1, k)] - v).abs() < 1e-15,
                "{}",
                motion.method()
            );
        }
    }
}
