//! The reference in more digits against answers known to 34 digits that were computed without it:
//! the gallery, its machines and the scenes in `tests/extreme` and `tests/motion`; and what it says of doubles.
//!
//! `cargo test --release --test reference -- --nocapture` prints what each scene reaches and takes.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use eigentone::check::{Ball, Reference, ReferenceModes, ReferenceResponse};
use eigentone::gallery::{Decimal, TrueEigenvalue, Truth, cases, machines};
use eigentone::response::{Problem, Trajectory};
use eigentone::scene::Scene;
use faer::Mat;

/// How closely it agrees, in parts of each value.
const AGREEMENT: f64 = 1e-28;

/// What is smaller than this part of λ, or of the largest displacement or velocity until then, is
/// not resolved to so many digits of itself.
const RESOLUTION: f64 = 1e-34;

struct Known {
    name: String,
    scene: Scene,
    truth: Truth,
}

static KNOWN: LazyLock<Vec<Known>> = LazyLock::new(|| {
    let gallery = cases().iter().chain(machines()).map(|case| Known {
        name: case.name().to_owned(),
        scene: case.scene(),
        truth: case.truth(),
    });
    let mut known: Vec<Known> = gallery.collect();
    for folder in ["extreme", "motion"] {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
        let root = root.join(folder);
        let listed = std::fs::read_dir(root.join("scenes")).expect("it is there");
        let mut files: Vec<PathBuf> = listed
            .map(|entry| entry.expect("it can be listed").path())
            .collect();
        files.sort();
        known.extend(files.into_iter().map(|path| {
            let file = path.file_name().expect("a file");
            let truth = std::fs::read_to_string(root.join("truth").join(file));
            let truth = truth.expect("each has its own");
            Known {
                name: path.file_stem().expect("a file").display().to_string(),
                scene: Scene::read(&path).unwrap_or_else(|error| panic!("{error}")),
                truth: serde_json::from_str(&truth)
                    .unwrap_or_else(|error| panic!("{path:?}: {error}")),
            }
        }));
    }
    known
});

/// Systems of more coordinates have tests of their own, so that all run side by side.
const SMALL: usize = 14;

fn problem(known: &Known) -> Problem<'_> {
    let steps: Vec<u64> = known.truth.response.iter().map(|at| at.step).collect();
    let problem = known.scene.problem().expect("it has a time");
    let problem = problem.and_then(|problem| problem.at(&steps));
    problem.unwrap_or_else(|error| panic!("{}: {error}", known.name))
}

/// The difference of two numbers, each of which has more digits than a double.
fn difference(truth: &Decimal, found: &Ball) -> f64 {
    let near = found.nearest();
    (truth.minus(near) - found.minus(near)).abs()
}

fn size(root: &TrueEigenvalue) -> f64 {
    root.re.to_f64().hypot(root.im.to_f64())
}

/// The largest difference of a part of an eigenvalue from the truth, in parts of it.
fn disagreement_of_modes(known: &Known, found: &ReferenceModes) -> f64 {
    let name = &known.name;
    let truth = &known.truth.eigenvalues;
    let count = |found: &ReferenceModes| found.eigenvalues().iter().map(|e| e.multiplicity).sum();
    let (finite, all): (usize, usize) = (count(found), 2 * known.scene.system().len());
    assert_eq!(
        (finite, found.infinite()),
        (truth.len(), all - finite),
        "{name}"
    );
    let mut left: Vec<_> = found
        .eigenvalues()
        .iter()
        .flat_map(|root| std::iter::repeat_n(root, root.multiplicity))
        .collect();
    let mut worst = 0.0f64;
    for root in truth {
        let parts = |found: &eigentone::check::ReferenceEigenvalue| {
            let (re, im) = (
                difference(&root.re, &found.re),
                difference(&root.im, &found.im),
            );
            [re, im]
        };
        let distance = |index: usize| {
            let [re, im] = parts(left[index]);
            re.hypot(im)
        };
        let nearest = (0..left.len()).min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
        let found = left.swap_remove(nearest.expect("as many as there are"));
        assert_eq!(found.multiplicity, root.multiplicity, "{name}: {}", root.im);
        for (off, truth) in parts(found).into_iter().zip([&root.re, &root.im]) {
            let unit = truth.to_f64().abs().max(RESOLUTION * size(root));
            if off > 0.0 {
                worst = worst.max(off / unit);
            }
        }
    }
    worst
}

/// The same of a displacement or velocity, in parts of the largest at its instant.
fn disagreement_of_response(known: &Known, found: &ReferenceResponse) -> f64 {
    let mut worst = 0.0f64;
    let mut largest = [0.0f64; 2];
    for (k, sample) in known.truth.response.iter().enumerate() {
        assert_eq!(found.steps()[k], sample.step);
        let kinds = [
            (&sample.displacement, found.displacement(k)),
            (&sample.velocity, found.velocity(k)),
        ];
        for ((truth, found), largest) in kinds.into_iter().zip(&mut largest) {
            let here = truth.iter().map(|x| x.to_f64().abs()).fold(0.0, f64::max);
            *largest = largest.max(here);
            for (truth, found) in truth.iter().zip(found) {
                let off = difference(truth, found);
                if off > 0.0 {
                    worst = worst.max(off / here.max(RESOLUTION * *largest));
                }
            }
        }
    }
    worst
}

fn modes_agree(chosen: impl Fn(&Known) -> bool) {
    let mut wrong = Vec::new();
    for known in KNOWN.iter().filter(|known| chosen(known)) {
        let (found, time) = timed(|| Reference::default().modes(known.scene.system()));
        let found = found.unwrap_or_else(|error| panic!("{}: {error}", known.name));
        let off = disagreement_of_modes(known, &found);
        println!("{:24} eigenvalues {off:8.1e} {time:9.1?}", known.name);
        if off > AGREEMENT {
            wrong.push(format!("{}: {off:e}", known.name));
        }
    }
    assert!(wrong.is_empty(), "\n{}\n", wrong.join("\n"));
}

fn responses_agree(chosen: impl Fn(&Known) -> bool) {
    let mut wrong = Vec::new();
    let asked = KNOWN
        .iter()
        .filter(|known| !known.truth.response.is_empty());
    for known in asked.filter(|known| chosen(known)) {
        let problem = problem(known);
        let (found, time) = timed(|| Reference::default().response(&problem));
        let found = found.unwrap_or_else(|error| panic!("{}: {error}", known.name));
        let off = disagreement_of_response(known, &found);
        let bits = found.bits();
        println!(
            "{:24} response {off:8.1e} {time:9.1?} {bits} bits",
            known.name
        );
        if off > AGREEMENT {
            wrong.push(format!("{}: {off:e}", known.name));
        }
    }
    assert!(wrong.is_empty(), "\n{}\n", wrong.join("\n"));
}

fn timed<T>(run: impl FnOnce() -> T) -> (T, Duration) {
    let began = Instant::now();
    (run(), began.elapsed())
}

fn is_small(known: &Known) -> bool {
    known.scene.system().len() <= SMALL
}

#[test]
fn eigenvalues_agree_to_28_digits() {
    modes_agree(is_small);
}

#[test]
fn responses_agree_to_28_digits() {
    responses_agree(is_small);
}

/// Up to 80 coordinates, which take seconds each.
#[test]
fn eigenvalues_of_large_systems_agree_to_28_digits() {
    modes_agree(|known| !is_small(known));
}

#[test]
fn responses_of_large_systems_agree_to_28_digits() {
    responses_agree(|known| !is_small(known));
}

/// The error of an answer in doubles, measured from the reference and from the 34 digits.
#[test]
fn errors_of_doubles_are_measured_below_their_last_place() {
    for known in KNOWN.iter().filter(|known| is_small(known)).take(25) {
        let modes = known.scene.system().modes().expect("the gallery has modes");
        let reference = Reference::default().modes(known.scene.system());
        let error = reference.and_then(|reference| reference.error_of(&modes));
        let error = error.expect("there is a reference of each");
        assert!(error.modulus <= 4e-16, "{}: {error:?}", known.name);
        assert!(error.real_part <= 1e-15, "{}: {error:?}", known.name);
        if known.truth.response.is_empty() {
            continue;
        }
        // The nearest doubles: off by what is left of the truth.
        let samples = &known.truth.response;
        let (n, count) = (known.truth.coordinates.len(), samples.len());
        let displacement = Mat::from_fn(n, count, |i, k| samples[k].displacement[i].to_f64());
        let velocity = Mat::from_fn(n, count, |i, k| samples[k].velocity[i].to_f64());
        let problem = problem(known);
        let steps: Vec<u64> = samples.iter().map(|sample| sample.step).collect();
        let times = steps.iter().map(|k| problem.grid().time(*k)).collect();
        let rounded = Trajectory::new("rounded", steps, times, displacement, velocity);
        let error = Reference::default().response(&problem);
        let error = error.and_then(|reference| reference.error_of(&rounded));
        let error = error.expect("there is a reference of each");
        let all = || samples.iter().flat_map(|sample| &sample.displacement);
        let peak = all().map(|x| x.to_f64().abs()).fold(0.0, f64::max);
        let off = all().map(|x| x.minus(x.to_f64()).abs());
        let off = off.fold(0.0, f64::max);
        let expected = if off > 0.0 { off / peak } else { 0.0 };
        let (found, name) = (error.displacement, &known.name);
        approx::assert_relative_eq!(found, expected, max_relative = 1e-10, epsilon = 1e-28);
        assert!(found <= f64::EPSILON / 2.0, "{name}: {found:e}");
    }
}
