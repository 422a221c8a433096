//! Machines: points, supports that move, damping of the whole and outputs, against answers to 34 digits.
//!
//! `cargo test --release --test machines -- --nocapture` prints all errors.

use std::collections::BTreeSet;
use std::path::Path;

use eigentone::gallery::{Case, Decimal, TrueSample, machines};
use eigentone::modes::{Bounds, Precision};
use eigentone::response::{ResponsePlan, Trajectory, methods};

/// What a bound may be exceeded by, for its error is measured in double-doubles.
const MEASURED: f64 = 1.0 + 1e-12;

fn largest<'a>(values: impl IntoIterator<Item = &'a Decimal>) -> f64 {
    let sizes = values.into_iter().map(|value| value.to_f64().abs());
    sizes.fold(0.0, f64::max)
}

#[test]
fn every_file_is_in_the_list() {
    let names: Vec<&str> = machines().iter().map(Case::name).collect();
    assert!(names.is_sorted());
    for folder in ["scenes", "truth"] {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gallery/machines");
        let files = std::fs::read_dir(root.join(folder)).expect("it is there");
        let files: BTreeSet<String> = files
            .map(|file| file.expect("it can be listed").path())
            .map(|file| file.file_stem().expect("a name").display().to_string())
            .collect();
        assert_eq!(files, names.iter().map(|name| (*name).to_owned()).collect());
    }
}

#[test]
fn modes_are_right_to_the_last_digits() {
    for case in machines() {
        let (name, scene, truth) = (case.name(), case.scene(), case.truth());
        assert_eq!(truth.coordinates, scene.system().names(), "{name}");
        let modes = scene.system().modes().expect(name);
        assert_eq!(modes.bounds(), Bounds::Proven, "{name}");
        let mut left = modes.eigenvalues().to_vec();
        assert_eq!(left.len(), truth.eigenvalues.len(), "{name}");
        for root in &truth.eigenvalues {
            let off = |k: usize| {
                let found = left[k].value;
                root.re.minus(found.re).hypot(root.im.minus(found.im))
            };
            let nearest = (0..left.len()).min_by(|a, b| off(*a).total_cmp(&off(*b)));
            let nearest = nearest.expect("as many as there are");
            let error = off(nearest);
            let found = left.swap_remove(nearest);
            let size = root.re.to_f64().hypot(root.im.to_f64());
            println!("{name}: {:.1e} of {size:.3e}", error);
            assert!(
                error <= 4.0 * f64::EPSILON / 2.0 * size,
                "{name}: {error:e} of {size:e}"
            );
            let bound = found.bound.expect("proven");
            assert!(
                error <= bound * MEASURED,
                "{name}: {error:e} beyond {bound:e}"
            );
            assert!(bound <= 1e-15 * size, "{name}: {bound:e} says nothing");
        }
    }
}

/// Checks all that one method says of one machine; the errors of displacements, velocities and outputs in parts of the
/// largest of their kind.
fn errors(name: &str, samples: &[TrueSample], found: &Trajectory, idle: f64) -> [f64; 3] {
    let mut worst = [0.0; 3];
    let mut note = |kind: usize, error: f64, size: f64, bound: Option<f64>| {
        let what = ["displacement", "velocity", "output"][kind];
        if let Some(bound) = bound {
            assert!(
                error <= bound * MEASURED,
                "{name}: {what} {error:e} beyond {bound:e}"
            );
            assert!(
                bound <= idle * size,
                "{name}: {what} of {size:e} has {bound:e}"
            );
        }
        if size > 0.0 {
            worst[kind] = f64::max(worst[kind], error / size);
        }
    };
    let moved = largest(samples.iter().flat_map(|sample| &sample.displacement));
    let fastest = largest(samples.iter().flat_map(|sample| &sample.velocity));
    for (k, sample) in samples.iter().enumerate() {
        assert_eq!(found.steps()[k], sample.step);
        let kinds = [
            (
                &sample.displacement,
                found.displacement(),
                found.displacement_bound()[k],
                moved,
            ),
            (
                &sample.velocity,
                found.velocity(),
                found.velocity_bound()[k],
                fastest,
            ),
        ];
        for (kind, (truth, found, bound, size)) in kinds.into_iter().enumerate() {
            for (i, truth) in truth.iter().enumerate() {
                note(kind, truth.minus(found[(i, k)]).abs(), size, bound);
            }
        }
        assert_eq!(found.outputs().count(), sample.outputs.len());
        for (i, output) in found.outputs().enumerate() {
            let size = largest(samples.iter().map(|sample| &sample.outputs[output]));
            let error = sample.outputs[output].minus(found.output(i)[k]).abs();
            note(2, error, size, found.output_bound(i)[k]);
        }
    }
    worst
}

#[test]
fn motions_and_outputs_are_right_to_the_last_digits() {
    for case in machines() {
        let (name, scene, truth) = (case.name(), case.scene(), case.truth());
        let steps: Vec<u64> = truth.response.iter().map(|sample| sample.step).collect();
        let problem = scene.problem().expect(name);
        let problem = problem.and_then(|problem| problem.at(&steps)).expect(name);
        let plan = ResponsePlan::of(&problem).expect(name);
        let certified = plan.run(&problem).expect(name);
        assert_eq!(certified.bounds(), Bounds::Proven, "{name}");
        let off = errors(name, &truth.response, &certified, 1e-14);
        println!("{name}: certified {off:?}");
        assert!(
            off[0] <= 2e-15 && off[1] <= 2e-15 && off[2] <= 1e-14,
            "{name}: {off:?}"
        );
        let problem = problem.to(Precision::Double);
        for method in methods() {
            if method.refuses(&problem).is_some() {
                continue;
            }
            let found = method.run(&problem).expect(name);
            let off = errors(name, &truth.response, &found, f64::INFINITY);
            println!("{name}: {} {off:?}", method.name());
            assert!(off.iter().all(|off| *off <= 1e-11), "{name}: {off:?}");
        }
    }
}
