//! Any calls of the builder: names twice, unknown or empty, values that are no numbers, matrices of any shape.

#![no_main]

#[path = "../../tests/random/choices.rs"]
mod choices;

use choices::Choices;
use eigentone::modes::{GROUND, MatrixKind, Participation, Precision, Sensitivity, System, solvers};
use faer::Mat;
use faer::sparse::{SparseColMat, Triplet};
use libfuzzer_sys::fuzz_target;

const NAMES: [&str; 10] = ["a", "b", "c", "d", "e", "x1", "x2", "x3", GROUND, ""];

fn value(choices: &mut Choices<'_>) -> f64 {
    const KNOWN: [f64; 12] = [
        1.0, 2.0, 0.5, 100.0, 0.0, -0.0, -1.0, 1e-300, 1e300, 5e-324, f64::NAN, f64::INFINITY,
    ];
    match choices.below(14) {
        13 => f64::from_bits(choices.bits()),
        12 => f64::from(choices.byte()),
        known => KNOWN[known],
    }
}

fuzz_target!(|bytes: &[u8]| {
    let mut choices = Choices::of(bytes);
    let mut builder = System::builder();
    let mut calls = 0;
    while !choices.is_over() && calls < 60 {
        calls += 1;
        let call = choices.below(8);
        let (first, second) = (choices.pick(&NAMES), choices.pick(&NAMES));
        builder = match call {
            0 | 1 => builder.mass(first, value(&mut choices)),
            2 | 3 => builder.spring(first, second, value(&mut choices)),
            4 | 5 => builder.damper(first, second, value(&mut choices)),
            call => {
                let kinds = [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness];
                let kind = choices.pick(&kinds);
                let (rows, columns) = match choices.below(8) {
                    7 => (choices.below(5), choices.below(5)),
                    n => (n, n),
                };
                let entries: Vec<f64> = (0..rows * columns).map(|_| value(&mut choices)).collect();
                let matrix = Mat::from_fn(rows, columns, |i, j| entries[i + rows * j]);
                if call == 6 {
                    builder.matrix(kind, matrix.as_ref())
                } else {
                    let places = (0..columns).flat_map(|j| (0..rows).map(move |i| (i, j)));
                    let triplets: Vec<Triplet<usize, usize, f64>> = places
                        .filter(|&at| matrix[at] != 0.0)
                        .map(|at| Triplet::new(at.0, at.1, matrix[at]))
                        .collect();
                    let sparse = SparseColMat::try_new_from_triplets(rows, columns, &triplets);
                    builder.sparse_matrix(kind, sparse.expect("indices within the matrix"))
                }
            }
        };
    }
    let system = match builder.build() {
        Ok(system) => system,
        Err(error) => {
            assert!(!error.to_string().contains('\n'));
            return;
        }
    };
    assert!(!system.structure().to_string().is_empty());
    for solver in solvers() {
        if solver.refuses(&system).is_none() {
            let _ = solver.solve(&system);
        }
    }
    let _ = Participation::of(&system);
    if let Ok(modes) = system.modes_to(Precision::default()) {
        let count = modes.eigenvalues().len() + modes.infinite();
        assert_eq!(count, 2 * system.len());
        for mode in &modes {
            let _ = Sensitivity::of(&system, mode);
        }
    }
});
