//! The gallery's 34-digit answers against everything that computes them.
//!
//! `cargo test --release --test truth -- --nocapture` prints all errors.

use std::fmt::Write as _;
use std::sync::LazyLock;

use eigentone::gallery::{Case, TrueEigenvalue, TrueSample, cases};
use eigentone::modes::{Eigenvalue, Modes, solvers};
use eigentone::response::{Trajectory, methods};

/// Scenes whose numbers span so much that doubles must lose digits.
const EXTREME: [&str; 8] = [
    "alternating-1e12",
    "free-free",
    "mass-ratio",
    "micro-units",
    "stiff-contact",
    "stiff-overdamped",
    "triple-defect",
    "undamped-long",
];

/// How far one solver is off at one scene.
struct RootErrors {
    case: &'static str,
    solver: &'static str,
    /// Whether it is the default: the solver that the plan picks, with digits as needed.
    planned: bool,
    /// Worst |λ̂ − λ| in units of |λ|; infinite if a zero root is not exactly 0.
    relative: f64,
    /// Worst error of a real part in units of it, or of |λ| where it is truly 0.
    real: f64,
    /// Worst error in units of its bound, over all roots that have one; 0 without any.
    of_bound: f64,
    /// Roots without a bound.
    unbounded: usize,
}

/// How far one method is off at one scene.
struct MotionErrors {
    case: &'static str,
    method: &'static str,
    planned: bool,
    /// Worst error of a displacement in units of the largest one at its instant.
    displacement: f64,
    /// The same for velocities, where the unit is at least the slowest rate times the largest
    /// displacement.
    velocity: f64,
    of_bound: f64,
    /// The largest bound, in parts of the motion.
    loosest: f64,
    unbounded: usize,
}

/// error/unit, where no error needs no unit.
fn ratio(error: f64, unit: f64) -> f64 {
    assert!(!error.is_nan() && !unit.is_nan());
    if error == 0.0 {
        0.0
    } else {
        error.abs() / unit
    }
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |most, value| {
        assert!(!value.is_nan());
        most.max(value.abs())
    })
}

fn size(root: &TrueEigenvalue) -> f64 {
    root.re.to_f64().hypot(root.im.to_f64())
}

/// Error of the real and of the imaginary part.
fn difference(root: &TrueEigenvalue, found: &Eigenvalue) -> (f64, f64) {
    (root.re.minus(found.value.re), root.im.minus(found.value.im))
}

/// Pairs each root, largest first, with the nearest found one that is left.
fn pair<'a>(
    roots: &'a [TrueEigenvalue],
    found: &[Eigenvalue],
) -> Vec<(&'a TrueEigenvalue, Eigenvalue)> {
    assert_eq!(roots.len(), found.len(), "number of finite eigenvalues");
    let mut left = found.to_vec();
    let mut order: Vec<&TrueEigenvalue> = roots.iter().collect();
    order.sort_by(|a, b| size(b).total_cmp(&size(a)));
    let distance = |root: &TrueEigenvalue, found: &Eigenvalue| {
        let (re, im) = difference(root, found);
        re.hypot(im)
    };
    let nearest = |root: &'a TrueEigenvalue| {
        let index = (0..left.len())
            .min_by(|&a, &b| distance(root, &left[a]).total_cmp(&distance(root, &left[b])))
            .expect("as many are found as there are");
        (root, left.swap_remove(index))
    };
    order.into_iter().map(nearest).collect()
}

fn root_errors(
    case: &Case,
    solver: &'static str,
    planned: bool,
    roots: &[TrueEigenvalue],
    modes: &Modes,
) -> RootErrors {
    let mut errors = RootErrors {
        case: case.name(),
        solver,
        planned,
        relative: 0.0,
        real: 0.0,
        of_bound: 0.0,
        unbounded: 0,
    };
    for (root, found) in pair(roots, modes.eigenvalues()) {
        let (re, im) = difference(root, &found);
        let true_re = root.re.to_f64();
        let real_unit = if true_re == 0.0 {
            size(root)
        } else {
            true_re.abs()
        };
        errors.relative = errors.relative.max(ratio(re.hypot(im), size(root)));
        errors.real = errors.real.max(ratio(re, real_unit));
        for (error, bound) in [(re.hypot(im), found.bound), (re, found.real_bound)] {
            match bound {
                Some(bound) => errors.of_bound = errors.of_bound.max(ratio(error, bound)),
                None => errors.unbounded += 1,
            }
        }
    }
    errors
}

fn motion_errors(
    case: &Case,
    method: &'static str,
    planned: bool,
    roots: &[TrueEigenvalue],
    samples: &[TrueSample],
    found: &Trajectory,
) -> MotionErrors {
    let mut errors = MotionErrors {
        case: case.name(),
        method,
        planned,
        displacement: 0.0,
        velocity: 0.0,
        of_bound: 0.0,
        loosest: 0.0,
        unbounded: 0,
    };
    let slowest = roots.iter().map(size).filter(|size| *size > 0.0);
    let slowest = slowest.reduce(f64::min).unwrap_or(0.0);
    for (at, sample) in samples.iter().enumerate() {
        assert_eq!(found.steps()[at], sample.step);
        let n = sample.displacement.len();
        let off = |truth: &[eigentone::gallery::Decimal], found: faer::MatRef<'_, f64>| {
            largest((0..n).map(|i| truth[i].minus(found[(i, at)])))
        };
        let displacement = off(&sample.displacement, found.displacement());
        let velocity = off(&sample.velocity, found.velocity());
        let unit = largest(sample.displacement.iter().map(|x| x.to_f64()));
        let fastest = largest(sample.velocity.iter().map(|v| v.to_f64()));
        errors.displacement = errors.displacement.max(ratio(displacement, unit));
        let velocity_unit = fastest.max(slowest * unit);
        errors.velocity = errors.velocity.max(ratio(velocity, velocity_unit));
        for (error, unit, bound) in [
            (displacement, unit, found.displacement_bound()[at]),
            (velocity, velocity_unit, found.velocity_bound()[at]),
        ] {
            match bound {
                Some(bound) => {
                    errors.of_bound = errors.of_bound.max(ratio(error, bound));
                    errors.loosest = errors.loosest.max(ratio(bound, unit));
                }
                None => errors.unbounded += 1,
            }
        }
    }
    errors
}

/// Every solver and every method on every scene that it does not refuse.
static MEASURED: LazyLock<(Vec<RootErrors>, Vec<MotionErrors>)> = LazyLock::new(|| {
    let (mut roots, mut motions) = (Vec::new(), Vec::new());
    for case in cases() {
        let name = case.name();
        let (scene, truth) = (case.scene(), case.truth());
        let system = scene.system();
        let default = system.modes().expect(name);
        let roots_of = &truth.eigenvalues;
        roots.push(root_errors(case, "default", true, roots_of, &default));
        for solver in solvers() {
            if solver.refuses(system).is_some() {
                continue;
            }
            let modes = solver.solve(system).expect(name);
            let solver = solver.name();
            roots.push(root_errors(case, solver, false, roots_of, &modes));
        }
        let Some(problem) = scene.problem() else {
            continue;
        };
        let steps: Vec<u64> = truth.response.iter().map(|sample| sample.step).collect();
        let problem = problem.and_then(|problem| problem.at(&steps)).expect(name);
        let plan = eigentone::response::ResponsePlan::of(&problem).expect(name);
        for method in methods() {
            if method.refuses(&problem).is_some() {
                continue;
            }
            let found = method.run(&problem).expect(name);
            let method = method.name();
            let planned = method == plan.method.name();
            let (roots, samples) = (&truth.eigenvalues, &truth.response);
            motions.push(motion_errors(case, method, planned, roots, samples, &found));
        }
    }
    (roots, motions)
});

#[test]
fn the_gallery_has_17_plain_scenes() {
    let names: Vec<&str> = cases().iter().map(Case::name).collect();
    assert!(EXTREME.iter().all(|name| names.contains(name)));
    assert_eq!(names.len() - EXTREME.len(), 17);
}

#[test]
fn every_scene_is_solved_and_marched() {
    let (roots, motions) = &*MEASURED;
    for case in cases() {
        let planned = |case_of: &str, planned: bool| case_of == case.name() && planned;
        let solved = roots.iter().filter(|e| planned(e.case, e.planned)).count();
        assert_eq!(solved, 1, "{}", case.name());
        let marched = motions
            .iter()
            .filter(|e| planned(e.case, e.planned))
            .count();
        let asked = usize::from(!case.truth().response.is_empty());
        assert_eq!(marched, asked, "{}", case.name());
    }
}

#[test]
fn eigenvalues_of_plain_scenes_are_right_to_the_last_digits() {
    for errors in &MEASURED.0 {
        if !EXTREME.contains(&errors.case) {
            let name = format!("{} by {}", errors.case, errors.solver);
            assert!(errors.relative <= 5e-15, "{name}: {:e}", errors.relative);
        }
    }
}

#[test]
fn motions_of_plain_scenes_are_right_to_13_digits() {
    for errors in &MEASURED.1 {
        if !EXTREME.contains(&errors.case) {
            let name = format!("{} by {}", errors.case, errors.method);
            let (x, v) = (errors.displacement, errors.velocity);
            assert!(x <= 1e-13, "{name}: displacement {x:e}");
            assert!(v <= 1e-13, "{name}: velocity {v:e}");
        }
    }
}

/// However stiff, long or unsupported: the default answer is right to the last digits, and its
/// bounds say so.
#[test]
fn default_motions_of_all_scenes_are_right_to_the_last_digits() {
    for errors in MEASURED.1.iter().filter(|e| e.planned) {
        let (x, v) = (errors.displacement, errors.velocity);
        assert!(x <= 2e-15 && v <= 2e-15, "{}: {x:e}, {v:e}", errors.case);
        assert_eq!(errors.unbounded, 0, "{}", errors.case);
        assert!(
            errors.loosest <= 1e-13,
            "{}: {:e}",
            errors.case,
            errors.loosest
        );
    }
}

/// The README's table of errors, "rounded up", claims no less than there are.
#[test]
fn the_readme_does_not_flatter() {
    let readme = include_str!("../README.md");
    let (_, table) = readme.split_once("## How accurate").expect("it is there");
    let rows = table.lines().filter(|line| line.starts_with("| ")).skip(1);
    let (mut shown, mut plain) = (Vec::new(), false);
    for row in rows {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let claim = |cell: &str| cell.parse::<f64>().unwrap_or(0.0);
        let is_meant = |case: &str| match cells[0].starts_with("17 plain") {
            true => !EXTREME.contains(&case),
            false => cells[0] == case,
        };
        plain |= cells[0].starts_with("17 plain");
        shown.push(cells[0].to_owned());
        for errors in MEASURED.0.iter().filter(|e| e.planned && is_meant(e.case)) {
            assert!(
                errors.relative <= claim(cells[2]),
                "{}: {:e}",
                errors.case,
                errors.relative
            );
        }
        for errors in MEASURED.1.iter().filter(|e| e.planned && is_meant(e.case)) {
            let (x, v) = (errors.displacement, errors.velocity);
            assert!(
                x <= claim(cells[3]) && v <= claim(cells[4]),
                "{}: {x:e}, {v:e}",
                errors.case
            );
        }
    }
    assert!(
        plain
            && EXTREME
                .iter()
                .all(|name| shown.iter().any(|row| row == name))
    );
}

/// The roots of critical damping merge: in doubles alone they would be good to 8 digits.
#[test]
fn critical_damping_is_exact() {
    for errors in MEASURED.0.iter().filter(|e| e.case == "one-mass-critical") {
        assert_eq!(errors.relative, 0.0, "by {}", errors.solver);
    }
}

#[test]
fn bounds_hold() {
    for errors in &MEASURED.0 {
        let name = format!("{} by {}", errors.case, errors.solver);
        assert!(errors.of_bound <= 1.0, "{name}: {}", errors.of_bound);
    }
    for errors in &MEASURED.1 {
        let name = format!("{} by {}", errors.case, errors.method);
        assert!(errors.of_bound <= 1.0, "{name}: {}", errors.of_bound);
    }
}

/// Bounds that hold must also say something.
#[test]
fn plain_scenes_have_bounds() {
    let (roots, motions) = &*MEASURED;
    let roots = roots.iter().map(|e| (e.case, e.unbounded));
    let motions = motions.iter().map(|e| (e.case, e.unbounded));
    for (case, unbounded) in roots.chain(motions) {
        if !EXTREME.contains(&case) {
            assert_eq!(unbounded, 0, "{case}");
        }
    }
}

#[test]
fn listing() {
    let (roots, motions) = &*MEASURED;
    let mut text = String::from(
        "\nWorst relative errors (* is the default), and error / bound\n\n\
         scene                    solver                     |λ|     Re λ  /bound  no bound\n",
    );
    for e in roots {
        let solver = format!("{}{}", e.solver, if e.planned { " *" } else { "" });
        writeln!(
            text,
            "{:24} {:24} {:>8.1e} {:>8.1e} {:>7.0e} {:>9}",
            e.case, solver, e.relative, e.real, e.of_bound, e.unbounded
        )
        .expect("strings take text");
    }
    text +=
        "\nscene                    method                   displ.  velocity  /bound  no bound\n";
    for e in motions {
        let method = format!("{}{}", e.method, if e.planned { " *" } else { "" });
        writeln!(
            text,
            "{:24} {:24} {:>8.1e} {:>8.1e} {:>7.0e} {:>9}",
            e.case, method, e.displacement, e.velocity, e.of_bound, e.unbounded
        )
        .expect("strings take text");
    }
    println!("{text}");
}
