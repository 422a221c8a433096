//! What cannot be answered says why.

use eigentone_modes::{Frequency, MatrixKind, SparseError, SparseModes, System};
use faer::mat;

use crate::networks::network;

#[test]
fn none_wanted_and_targets_that_are_no_frequencies() {
    let system = network([1.0], [(0, 1, 1.0)]);
    assert_eq!(
        SparseModes::lowest(&system, 0).unwrap_err(),
        SparseError::NoneWanted
    );
    for target in [-1.0, f64::NAN, f64::INFINITY, 1e200] {
        let found = SparseModes::nearest(&system, Frequency::from_radians_per_second(target), 1);
        assert!(
            matches!(found, Err(SparseError::Target { .. })),
            "{target}: {found:?}"
        );
    }
}

#[test]
fn matrices_that_are_not_symmetric_or_not_definite() {
    let unit = mat![[1.0, 0.0], [0.0, 1.0]];
    let none = mat![[0.0, 0.0], [0.0, 0.0]];
    let skew = mat![[2.0, -1.0], [1.0, 2.0]];
    let system = System::from_matrices(unit.as_ref(), none.as_ref(), skew.as_ref()).unwrap();
    let error = SparseModes::lowest(&system, 1).unwrap_err();
    assert_eq!(
        error,
        SparseError::NotSymmetric {
            kind: MatrixKind::Stiffness
        }
    );
    let indefinite = mat![[1.0, 2.0], [2.0, 1.0]];
    let system = System::from_matrices(indefinite.as_ref(), none.as_ref(), unit.as_ref()).unwrap();
    assert_eq!(
        SparseModes::lowest(&system, 1).unwrap_err(),
        SparseError::MassNotDefinite
    );
    let system = System::builder()
        .mass("m", 0.0)
        .spring("ground", "m", 1.0)
        .damper("ground", "m", 1.0)
        .build()
        .unwrap();
    assert_eq!(
        SparseModes::lowest(&system, 1).unwrap_err(),
        SparseError::NoMass
    );
}
