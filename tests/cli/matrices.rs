//! `export --matrices`: sparse M, C and K of scenes, in both formats and back.

use std::fs;
use std::path::Path;

use eigentone::modes::{MatrixKind, System};
use eigentone::scene::Scene;

use super::{eigentone, fresh, printed, refused, scene};

const FORMATS: [(&str, &str); 2] = [("market", "mtx"), ("petsc", "petsc")];

fn system(file: &Path) -> System {
    Scene::read(file).expect("a scene").system().clone()
}

/// The entries of a matrix that are not 0.
fn entries(system: &System, kind: MatrixKind) -> Vec<(usize, usize, f64)> {
    let matrix = match kind {
        MatrixKind::Mass => system.mass_matrix(),
        MatrixKind::Damping => system.damping_matrix(),
        MatrixKind::Stiffness => system.stiffness_matrix(),
    };
    let places = (0..system.len()).flat_map(|i| (0..system.len()).map(move |j| (i, j)));
    let all = places.map(|(i, j)| (i, j, matrix[(i, j)]));
    all.filter(|entry| entry.2 != 0.0).collect()
}

#[test]
fn matrices_come_back_entry_by_entry() {
    let files = [
        "two-mass-free",
        "three-mass-1",
        "free-free",
        "stiff-contact",
        "../machines/scenes/cantilever",
        "../machines/scenes/double-pendulum",
    ];
    for file in files.map(scene) {
        let given = system(Path::new(&file));
        for (format, ending) in FORMATS {
            let folder = fresh(&format!("matrices-{format}"));
            let out = folder.to_str().expect("a UTF-8 path");
            let said = printed(&["export", &file, "--matrices", format, "--out", out]);
            assert!(said.contains(&format!("stiffness.{ending}: ")), "{said}");
            let read = system(&folder.join("matrices.json"));
            for kind in [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness] {
                assert_eq!(
                    entries(&read, kind),
                    entries(&given, kind),
                    "{file}: {kind}"
                );
            }
            let has_damping = folder.join(format!("damping.{ending}")).exists();
            let is_damped = !entries(&given, MatrixKind::Damping).is_empty();
            assert_eq!(has_damping, is_damped, "{file}");
        }
    }
}

/// A grid of 160 000 masses: a dense matrix of it would take 200 GB.
#[test]
fn a_large_grid_is_written_and_read() {
    let side = 400usize;
    let n = side * side;
    let folder = fresh("matrices-grid");
    fs::create_dir_all(&folder).expect("it can be made");
    let mut text = String::from("{\"masses\": [");
    let name = |i: usize, j: usize| format!("\"{i}-{j}\"");
    for i in 0..side {
        for j in 0..side {
            let comma = if (i, j) == (0, 0) { "" } else { "," };
            text += &format!("{comma}{{\"name\": {}, \"mass\": 1}}", name(i, j));
        }
    }
    text += "], \"springs\": [{\"between\": [\"ground\", \"0-0\"], \"stiffness\": 1}";
    for i in 0..side {
        for j in 0..side {
            for (i1, j1) in [(i + 1, j), (i, j + 1)] {
                if i1 < side && j1 < side {
                    text += &format!(
                        ",{{\"between\": [{}, {}], \"stiffness\": 2}}",
                        name(i, j),
                        name(i1, j1)
                    );
                }
            }
        }
    }
    text += "]}";
    let file = folder.join("grid.json");
    fs::write(&file, text).expect("it can be written");
    let file = file.to_str().expect("a UTF-8 path");
    let counts = FORMATS.map(|(format, ending)| {
        let out = folder.join(format);
        let said = printed(&[
            "export",
            file,
            "--matrices",
            format,
            "--out",
            out.to_str().unwrap(),
        ]);
        // Each mass, and two entries for each spring between two.
        let entries = n + 4 * side * (side - 1);
        assert!(
            said.contains(&format!(
                "stiffness.{ending}: {n} × {n}, {entries} entries, symmetric"
            )),
            "{said}"
        );
        let again = out.join("again");
        let back = out.join("matrices.json");
        printed(&[
            "export",
            back.to_str().unwrap(),
            "--matrices",
            "petsc",
            "--out",
            again.to_str().unwrap(),
        ]);
        fs::read(again.join("stiffness.petsc")).expect("it is there")
    });
    assert_eq!(counts[0], counts[1]);
    assert_eq!(
        counts[0].len(),
        16 + 4 * n + 12 * (n + 4 * side * (side - 1))
    );
}

#[test]
fn what_does_not_go_together_is_refused() {
    let file = scene("two-mass-free");
    for more in [
        &["--matrices", "petsc"][..],
        &["--matrices", "dense", "--out", "x"],
        &["--matrices", "petsc", "--out", "x", "--json"],
        &[
            "--matrices",
            "petsc",
            "--out",
            "x",
            "--hold",
            "zero",
            "--step",
            "0.1",
        ],
    ] {
        refused(&[&["export", &file], more].concat(), 2);
    }
}

#[test]
fn what_rounding_leaves_unsymmetric_is_noted() {
    let folder = fresh("unsymmetric");
    fs::create_dir_all(&folder).expect("a folder");
    let noted = |below: f64| {
        let stiffness = [[3.0, -1.0], [below, 2.0]];
        let mass = [[1.0, 0.0], [0.0, 1.0]];
        let given = serde_json::json!({ "matrices": { "mass": mass, "stiffness": stiffness } });
        let file = folder.join("scene.json");
        fs::write(&file, given.to_string()).expect("a file");
        let output = eigentone(&["modes", file.to_str().expect("a UTF-8 path")]);
        assert!(output.status.success());
        String::from_utf8(output.stderr).expect("UTF-8")
    };
    let note = noted((-1f64).next_up());
    let said = "the stiffness matrix differs from its transpose by 4.5e-17 of";
    assert!(note.starts_with("note: ") && note.contains(said), "{note}");
    assert_eq!(noted(-1.0), "");
    assert_eq!(noted(-0.9), "");
}

/// 0.1 + 0.2 beside 0.3: the free motion of two masses is a pole of 5e-9 rad/s, of which lists of modes and peaks say what it may be.
#[test]
fn rigid_motions_that_rounding_moved_are_said_to_be() {
    let folder = fresh("rounded-rigid");
    fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("two.json");
    let text = r#"{"matrices": {"mass": [[1, 0], [0, 1]],
        "stiffness": [[0.30000000000000004, -0.3], [-0.3, 0.3]]}}"#;
    fs::write(&file, text).expect("a file");
    let file = file.to_str().expect("a UTF-8 path");
    for arguments in [
        &["modes", file][..],
        &["frf", file, "--from", "x1", "--to", "x2"],
    ] {
        let output = eigentone(arguments);
        assert!(output.status.success(), "{arguments:?}");
        let said = String::from_utf8(output.stderr).expect("UTF-8");
        let note = "mode 1 (5.3e-9 rad/s) may be a rigid motion: rounding";
        assert!(said.contains(note), "{said}");
    }
}
