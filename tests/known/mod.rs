//! Systems whose answers are known to 34 digits: the gallery, and those in `tests/extreme`, whose
//! numbers or structure are meant to defeat doubles.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use eigentone::gallery::{TrueEigenvalue, Truth, cases};
use eigentone::modes::{Eigenvalue, Modes};
use eigentone::scene::Scene;

/// The unit of rounding.
pub const U: f64 = f64::EPSILON / 2.0;

/// A system and its answers.
pub struct Known {
    pub name: String,
    pub scene: Scene,
    pub truth: Truth,
    /// Or else in `tests/extreme`.
    #[allow(dead_code)] // not every test distinguishes them
    pub in_gallery: bool,
}

fn extreme(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/extreme")
        .join(folder)
}

/// All of them.
pub static KNOWN: LazyLock<Vec<Known>> = LazyLock::new(|| {
    let mut known: Vec<Known> = cases()
        .iter()
        .map(|case| Known {
            name: case.name().to_owned(),
            scene: case.scene(),
            truth: case.truth(),
            in_gallery: true,
        })
        .collect();
    let folder = std::fs::read_dir(extreme("scenes")).expect("it is there");
    let mut files: Vec<PathBuf> = folder
        .map(|entry| entry.expect("it can be listed").path())
        .collect();
    files.sort();
    known.extend(files.into_iter().map(|path| {
        let file = path.file_name().expect("a file");
        let truth = std::fs::read_to_string(extreme("truth").join(file)).expect("each has its own");
        Known {
            name: path.file_stem().expect("a file").display().to_string(),
            scene: Scene::read(&path).unwrap_or_else(|error| panic!("{error}")),
            truth: serde_json::from_str(&truth).unwrap_or_else(|error| panic!("{path:?}: {error}")),
            in_gallery: false,
        }
    }));
    known
});

/// A true root and the one found for it.
pub struct Pair {
    #[allow(dead_code)] // not every test shows it
    pub truth: TrueEigenvalue,
    pub found: Eigenvalue,
    pub size: f64,
    #[allow(dead_code)] // nor this
    pub re: f64,
    /// Errors of λ and of its real part.
    pub error: f64,
    pub real_error: f64,
}

/// |λ|.
pub fn size(root: &TrueEigenvalue) -> f64 {
    root.re.to_f64().hypot(root.im.to_f64())
}

/// Pairs each root, largest first, with the nearest that is left; `None` where counts differ.
pub fn pairs(truth: &Truth, modes: &Modes) -> Option<Vec<Pair>> {
    let mut left = modes.eigenvalues().to_vec();
    let mut order: Vec<&TrueEigenvalue> = truth.eigenvalues.iter().collect();
    if order.len() != left.len() {
        return None;
    }
    order.sort_by(|a, b| size(b).total_cmp(&size(a)));
    let pair = |root: &TrueEigenvalue| {
        let errors = |found: &Eigenvalue| {
            let re = root.re.minus(found.value.re);
            let im = root.im.minus(found.value.im);
            (re.hypot(im), re.abs())
        };
        // Of those equally near, as rounded near-repeats are, the one whose bounds hold closest.
        let rank = |found: &Eigenvalue| {
            let (error, real_error) = errors(found);
            let bound = found.bound.unwrap_or(f64::INFINITY);
            let real_bound = found.real_bound.unwrap_or(f64::INFINITY);
            let holds = error <= bound && real_error <= real_bound;
            (error, !holds, bound)
        };
        let index = (0..left.len())
            .min_by(|&a, &b| {
                let ((a, fails_a, bound_a), (b, fails_b, bound_b)) =
                    (rank(&left[a]), rank(&left[b]));
                a.total_cmp(&b)
                    .then(fails_a.cmp(&fails_b))
                    .then(bound_a.total_cmp(&bound_b))
            })
            .expect("as many are found as there are");
        let found = left.swap_remove(index);
        let (error, real_error) = errors(&found);
        Pair {
            found,
            size: size(root),
            re: root.re.to_f64(),
            error,
            real_error,
            truth: root.clone(),
        }
    };
    Some(order.into_iter().map(pair).collect())
}

/// Fails with everything that is wrong, not only the first.
pub fn none_wrong(wrong: &[String]) {
    assert!(wrong.is_empty(), "\n{}\n", wrong.join("\n"));
}
