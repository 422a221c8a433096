//! Matrices in the binary format of PETSc: bytes that petsc4py 3.18 wrote (`five-real.petsc` and `five-complex.petsc`, of PETScs of
//! real and of complex scalars) are read and written, and every cut and change of them is read or refused.

use std::fs;

use eigentone::modes::{MatrixKind, System};
use eigentone::report::SparseMatrixReport;
use eigentone::scene::Scene;

use super::directory;

const REAL: &[u8] = include_bytes!("five-real.petsc");
const COMPLEX: &[u8] = include_bytes!("five-complex.petsc");

const ENTRIES: [(usize, usize, f64); 10] = [
    (0, 0, 4.0),
    (0, 1, -1.5),
    (0, 4, 0.1),
    (1, 0, -1.25),
    (1, 1, 3.0),
    (3, 0, 1e-300),
    (3, 3, 2.0),
    (3, 4, -1e300),
    (4, 1, 1.0 / 3.0),
    (4, 4, 7.0),
];

fn read(name: &str, file: &[u8]) -> Result<System, String> {
    let directory = directory(name);
    fs::write(directory.join("k.petsc"), file).expect("written");
    let unit = |i: usize| -> Vec<u8> { (0..5).map(|j| u8::from(i == j)).collect() };
    let mass: Vec<Vec<u8>> = (0..5).map(unit).collect();
    let scene = format!(r#"{{"matrices": {{"mass": {mass:?}, "stiffness": "k.petsc"}}}}"#);
    let path = directory.join("scene.json");
    fs::write(&path, scene).expect("written");
    Scene::read(&path)
        .map(|scene| scene.system().clone())
        .map_err(|error| error.to_string())
}

#[test]
fn what_petsc4py_wrote_is_read_and_written_to_the_byte() {
    for (name, bytes) in [("real", REAL), ("complex", COMPLEX)] {
        let system = read(name, bytes).unwrap();
        let stiffness = system.stiffness_matrix();
        for i in 0..5 {
            for j in 0..5 {
                let entry = ENTRIES
                    .iter()
                    .find(|(row, column, _)| (*row, *column) == (i, j));
                assert_eq!(
                    stiffness[(i, j)],
                    entry.map_or(0.0, |entry| entry.2),
                    "{name}"
                );
            }
        }
        let mut written = Vec::new();
        let report = SparseMatrixReport::of(&system, MatrixKind::Stiffness);
        report.petsc(name == "complex", &mut written).unwrap();
        assert_eq!(written, bytes, "{name}");
        assert!(!report.is_symmetric());
        assert_eq!(report.entries(), 10);
    }
}

#[test]
fn files_that_are_cut_off_or_go_on_are_refused() {
    for bytes in [REAL, COMPLEX] {
        for end in 4..bytes.len() {
            let error = read("cut", &bytes[..end]).map(|_| end).unwrap_err();
            assert!(error.contains("matrices.stiffness"), "{end}: {error}");
            assert!(error.contains("k.petsc:byte "), "{end}: {error}");
            assert!(error.contains("cut off"), "{end}: {error}");
        }
        let two = [bytes, bytes].concat();
        let error = read("twice", &two).map(|_| ()).unwrap_err();
        assert!(error.contains("more than one matrix"), "{error}");
    }
}

/// REAL with another whole number at a place.
fn with(at: usize, number: i32) -> Vec<u8> {
    let mut bytes = REAL.to_vec();
    bytes[at..at + 4].copy_from_slice(&number.to_be_bytes());
    bytes
}

/// COMPLEX with another double at a place.
fn with_value(at: usize, number: f64) -> Vec<u8> {
    let mut bytes = COMPLEX.to_vec();
    bytes[at..at + 8].copy_from_slice(&number.to_be_bytes());
    bytes
}

#[test]
fn what_is_wrong_is_named_with_its_byte() {
    let wide: Vec<u8> = [&[0; 4], REAL].concat();
    let cases: [(&str, Vec<u8>, &str, &str); 15] = [
        ("wide", wide, "byte 0", "32-bit indices"),
        ("negative-rows", with(4, -5), "byte 4", "0 or more"),
        (
            "no-rows",
            [&with(4, 0)[..8], &[0; 8]].concat(),
            "byte 4",
            "0 × 0",
        ),
        (
            "oblong",
            with(8, 6),
            "byte 4",
            "5 × 6: M, C and K must be square",
        ),
        ("dense", with(12, -1), "byte 12", "dense"),
        ("negative", with(12, -2), "byte 12", "0 or more"),
        ("fewer", with(12, 9), "byte 12", "9 entries in 5 rows take"),
        (
            "longer-row",
            with(16, 30),
            "byte 16",
            "more entries than announced, 10",
        ),
        ("shorter-row", with(16, 2), "byte 12", "9 entries together"),
        ("negative-row", with(20, -1), "byte 20", "0 or more"),
        (
            "column",
            with(36, 5),
            "byte 36",
            "column 5 in row 0: there are 5",
        ),
        (
            "twice",
            with(40, 0),
            "byte 40",
            "entry (0, 0) is given before",
        ),
        ("nan", with_value(76, f64::NAN), "byte 76", "finite"),
        (
            "infinite",
            with_value(92, f64::INFINITY),
            "byte 92",
            "finite",
        ),
        (
            "imaginary",
            with_value(84, 0.5),
            "byte 76",
            "imaginary part 0.5",
        ),
    ];
    for (name, bytes, spot, problem) in cases {
        let error = read(name, &bytes).map(|_| ()).unwrap_err();
        assert!(
            error.contains(&format!("k.petsc:{spot}: ")),
            "{name}: {error}"
        );
        assert!(error.contains(problem), "{name}: {error}");
    }
}

#[test]
fn no_changed_byte_is_a_panic() {
    for at in 0..REAL.len() {
        for byte in [0x00, 0x01, 0x7f, 0x80, 0xff] {
            let mut bytes = REAL.to_vec();
            bytes[at] = byte;
            let _ = read("changed", &bytes); // read or refused
        }
    }
    // As many entries as numbers can say, and no room for them.
    let head: Vec<u8> = [1_211_216, 9_999_999, 9_999_999, i32::MAX]
        .into_iter()
        .flat_map(i32::to_be_bytes)
        .collect();
    assert!(
        read("vast", &head)
            .map(|_| ())
            .unwrap_err()
            .contains("cut off")
    );
}
