//! The gallery is whole and agrees with itself.

use std::collections::BTreeSet;
use std::path::PathBuf;

use eigentone::gallery::cases;

fn files_in(folder: &str) -> BTreeSet<String> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("tests/gallery")
        .join(folder);
    std::fs::read_dir(folder)
        .expect("the gallery is there")
        .map(|entry| {
            entry
                .expect("it can be listed")
                .file_name()
                .into_string()
                .expect("ASCII")
        })
        .collect()
}

#[test]
fn every_file_is_in_the_list() {
    let names: Vec<String> = cases()
        .iter()
        .map(|case| format!("{}.json", case.name()))
        .collect();
    assert!(names.is_sorted());
    let names: BTreeSet<String> = names.into_iter().collect();
    assert_eq!(names.len(), cases().len(), "a case is listed twice");
    assert_eq!(names, files_in("scenes"));
    assert_eq!(names, files_in("truth"));
}

#[test]
fn truth_fits_its_scene() {
    for case in cases() {
        let (name, scene, truth) = (case.name(), case.scene(), case.truth());
        let system = scene.system();
        assert_eq!(truth.coordinates, system.names(), "{name}");

        let massless = system.masses().iter().filter(|mass| **mass == 0.0).count();
        let finite = truth.eigenvalues.len();
        assert!(finite <= 2 * system.len() - massless, "{name}");
        assert!(massless > 0 || finite == 2 * system.len(), "{name}");
        for eigenvalue in &truth.eigenvalues {
            let same = |other: &&eigentone::gallery::TrueEigenvalue| {
                (&other.re, &other.im) == (&eigenvalue.re, &eigenvalue.im)
            };
            let repeats = truth.eigenvalues.iter().filter(same).count();
            assert_eq!(repeats, eigenvalue.multiplicity, "{name}");
        }

        let problem = scene
            .problem()
            .map(|problem| problem.expect("checked when it was read"));
        assert_eq!(problem.is_none(), truth.response.is_empty(), "{name}");
        for sample in &truth.response {
            let last = problem.as_ref().map_or(0, |problem| problem.grid().last());
            assert!(sample.step <= last, "{name}");
            assert_eq!(sample.displacement.len(), system.len(), "{name}");
            assert_eq!(sample.velocity.len(), system.len(), "{name}");
        }
    }
}

/// Vieta: the eigenvalues of a system with regular M sum up to −trace(M⁻¹C). The sum sees every
/// eigenvalue.
#[test]
fn eigenvalues_sum_up_to_the_damping() {
    for case in cases() {
        let scene = case.scene();
        let system = scene.system();
        if system.masses().contains(&0.0) {
            continue;
        }
        let damping = system.damping_matrix();
        let trace: f64 = (0..system.len())
            .map(|i| damping[(i, i)] / system.masses()[i])
            .sum();
        let eigenvalues = case.truth().eigenvalues;
        let sum: f64 = eigenvalues
            .iter()
            .map(|eigenvalue| eigenvalue.re.to_f64())
            .sum();
        let size: f64 = eigenvalues
            .iter()
            .map(|eigenvalue| eigenvalue.re.to_f64().abs())
            .sum();
        let unit = f64::EPSILON * (eigenvalues.len() + 2) as f64;
        assert!(
            (sum + trace).abs() <= unit * size,
            "{}: {sum} {trace}",
            case.name()
        );
    }
}

#[test]
fn decimals_read_as_their_nearest_double() {
    let decimals = cases().iter().flat_map(|case| case.truth().response);
    for decimal in decimals.flat_map(|sample| sample.displacement) {
        let nearest = decimal.to_f64();
        let half_a_unit = (nearest.abs().next_up() - nearest.abs()) / 2.0;
        assert!(
            decimal.minus(nearest).abs() <= half_a_unit * (1.0 + 1e-12),
            "{decimal}"
        );
    }
}
