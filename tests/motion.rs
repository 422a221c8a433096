//! Proven responses against motions known to 34 digits: the gallery, and the scenes in `tests/motion`
//! that are stiff, long, resonant, defective, unstable, badly scaled, or crowded with events.
//!
//! `cargo test --release --test motion -- --nocapture` prints what each one reaches.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use eigentone::gallery::{Decimal, TrueEigenvalue, Truth, cases};
use eigentone::modes::Bounds;
use eigentone::response::{ResponsePlan, Trajectory};
use eigentone::scene::Scene;

/// Where digits end, relative to the largest displacement or velocity so far.
const HIDDEN: f64 = 1e-30;

/// What the truth's own 34 digits leave open, and a difference of it to a double.
const TRUTH: f64 = 1e-29;

struct Known {
    name: String,
    scene: Scene,
    truth: Truth,
}

fn folder(name: &str) -> PathBuf {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/motion");
    tests.join(name)
}

static KNOWN: LazyLock<Vec<Known>> = LazyLock::new(|| {
    let gallery = cases().iter().map(|case| Known {
        name: case.name().to_owned(),
        scene: case.scene(),
        truth: case.truth(),
    });
    let listed = std::fs::read_dir(folder("scenes")).expect("it is there");
    let mut files: Vec<PathBuf> = listed
        .map(|entry| entry.expect("it can be listed").path())
        .collect();
    files.sort();
    let own = files.into_iter().map(|path| {
        let file = path.file_name().expect("a file");
        let truth = std::fs::read_to_string(folder("truth").join(file)).expect("each has its own");
        Known {
            name: path.file_stem().expect("a file").display().to_string(),
            scene: Scene::read(&path).unwrap_or_else(|error| panic!("{error}")),
            truth: serde_json::from_str(&truth).unwrap_or_else(|error| panic!("{path:?}: {error}")),
        }
    });
    let all = gallery.chain(own);
    all.filter(|known| !known.truth.response.is_empty())
        .collect()
});

/// The answers at the instants known, and how long each took.
static FOUND: LazyLock<Vec<(&Known, Trajectory, Duration)>> = LazyLock::new(|| {
    let answered = |known: &'static Known| {
        let steps: Vec<u64> = known.truth.response.iter().map(|at| at.step).collect();
        let began = Instant::now();
        let problem = known.scene.problem().expect("it has a time");
        let problem = problem.and_then(|problem| problem.at(&steps)).ok()?;
        let found = ResponsePlan::of(&problem).and_then(|plan| plan.run(&problem));
        Some((known, found.ok()?, began.elapsed()))
    };
    KNOWN.iter().filter_map(answered).collect()
});

/// Displacements or velocities at one instant.
struct Sample<'a> {
    kind: &'static str,
    step: u64,
    error: f64,
    bound: f64,
    /// The largest coordinate; for velocities at least the slowest rate times the largest
    /// displacement.
    unit: f64,
    /// The largest coordinate by itself.
    top: f64,
    /// The largest so far, of the instants known.
    so_far: f64,
    known: &'a Known,
}

fn size(root: &TrueEigenvalue) -> f64 {
    root.re.to_f64().hypot(root.im.to_f64())
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |most, value| {
        assert!(!value.is_nan());
        most.max(value.abs())
    })
}

fn top(values: &[Decimal]) -> f64 {
    largest(values.iter().map(Decimal::to_f64))
}

fn samples<'a>(known: &'a Known, found: &Trajectory) -> Vec<Sample<'a>> {
    let rates = known.truth.eigenvalues.iter().map(size);
    let slowest = rates.filter(|rate| *rate > 0.0).reduce(f64::min);
    let slowest = slowest.unwrap_or(0.0);
    let mut so_far = [0.0_f64; 2];
    let mut samples = Vec::new();
    for (at, truth) in known.truth.response.iter().enumerate() {
        assert_eq!(found.steps()[at], truth.step);
        let displaced = top(&truth.displacement);
        let both = [
            (
                "displacement",
                &truth.displacement,
                found.displacement(),
                found.displacement_bound(),
            ),
            (
                "velocity",
                &truth.velocity,
                found.velocity(),
                found.velocity_bound(),
            ),
        ];
        for ((kind, truths, values, bounds), so_far) in both.into_iter().zip(&mut so_far) {
            let own = top(truths);
            *so_far = so_far.max(own);
            let floor = if kind == "velocity" {
                slowest * displaced
            } else {
                0.0
            };
            let errors = truths.iter().enumerate();
            samples.push(Sample {
                kind,
                step: truth.step,
                error: largest(errors.map(|(i, truth)| truth.minus(values[(i, at)]))),
                bound: bounds[at].expect("certified responses have bounds everywhere"),
                unit: own.max(floor),
                top: own,
                so_far: *so_far,
                known,
            });
        }
    }
    samples
}

/// Fails with everything that is wrong, not only the first.
fn each_sample(mut check: impl FnMut(&Sample<'_>) -> Option<String>) {
    let mut wrong = Vec::new();
    for (known, found, _) in FOUND.iter() {
        for sample in samples(known, found) {
            wrong.extend(check(&sample).map(|what| {
                let (name, kind, step) = (&sample.known.name, sample.kind, sample.step);
                format!("{name}: {kind} at {step}: {what}")
            }));
        }
    }
    assert!(wrong.is_empty(), "\n{}\n", wrong.join("\n"));
}

#[test]
fn every_scene_is_answered_with_proof() {
    assert!(KNOWN.len() >= 90);
    let proven = |known: &&Known| {
        let mut answers = FOUND.iter().filter(|(found, ..)| found.name == known.name);
        answers.any(|(_, found, _)| found.bounds() == Bounds::Proven)
    };
    let unproven: Vec<&str> = KNOWN
        .iter()
        .filter(|known| !proven(known))
        .map(|known| known.name.as_str())
        .collect();
    assert!(unproven.is_empty(), "{unproven:?}");
}

#[test]
fn motions_are_right_to_the_last_digits() {
    each_sample(|sample| {
        let hidden = HIDDEN * sample.so_far;
        let allowed = (2e-15 * sample.unit).max(hidden);
        (sample.error > allowed).then(|| format!("{:e} of {:e}", sample.error, sample.unit))
    });
}

#[test]
fn bounds_hold() {
    each_sample(|sample| {
        let allowed = sample.bound * (1.0 + 1e-12) + TRUTH * sample.top;
        (sample.error > allowed).then(|| format!("{:e} > {:e}", sample.error, sample.bound))
    });
}

/// A bound is relative to what moves, but for what cannot be distinguished from 0.
#[test]
fn bounds_say_something() {
    each_sample(|sample| {
        let still = sample.so_far == 0.0;
        let allowed = (1e-13 * sample.top).max(1.01 * HIDDEN * sample.so_far);
        (!still && sample.bound > allowed)
            .then(|| format!("a bound of {:e} for {:e}", sample.bound, sample.top))
    });
}

/// What stays at 0 is printed as 0.
#[test]
fn what_does_not_move_is_0() {
    let mut still = 0;
    each_sample(|sample| {
        still += usize::from(sample.so_far == 0.0);
        (sample.so_far == 0.0 && sample.error != 0.0).then(|| format!("{:e}", sample.error))
    });
    assert!(still > 4);
}

#[test]
fn listing() {
    let mut text = String::from(
        "\nWorst errors and loosest bounds in units of the largest coordinate\n\n\
         scene                       digits   displ.  velocity    bounds            ms\n",
    );
    for (known, found, taken) in FOUND.iter() {
        let mut most = [[0.0_f64; 2]; 2];
        let seen = |sample: &Sample<'_>| sample.top > HIDDEN * sample.so_far;
        for sample in samples(known, found).iter().filter(|sample| seen(sample)) {
            let kind = usize::from(sample.kind == "velocity");
            for (most, size) in most.iter_mut().zip([sample.error, sample.bound]) {
                most[kind] = most[kind].max(size / sample.unit);
            }
        }
        let [[x, v], [x_bound, v_bound]] = most;
        let (name, digits) = (&known.name, found.digits());
        let ms = taken.as_secs_f64() * 1e3;
        writeln!(
            text,
            "{name:27} {digits:>6} {x:>8.1e} {v:>9.1e} {x_bound:>8.1e} {v_bound:>8.1e} {ms:>8.1}"
        )
        .expect("strings take text");
    }
    println!("{text}");
}
