//! Damped modes by projection, against the dense solvers.

use eigentone_modes::{Mode, Modes, Precision, SparseModes, System};
use num_complex::Complex;

use crate::networks::name;

fn chain(n: usize, dampers: impl IntoIterator<Item = (usize, usize, f64)>) -> System {
    let mut builder = System::builder();
    for i in 1..=n {
        let mass = 1.0 + 0.3 * (i % 3) as f64;
        builder = builder
            .mass(name(i), mass)
            .spring(name(i - 1), name(i), 50.0);
    }
    for (a, b, damping) in dampers {
        builder = builder.damper(name(a), name(b), damping);
    }
    builder.build().unwrap()
}

/// The mode of a dense answer nearest to a root.
fn nearest(modes: &Modes, value: Complex<f64>) -> &Mode {
    let distance = |mode: &&Mode| (mode.eigenvalue().value - value).norm();
    modes
        .iter()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .unwrap()
}

#[test]
fn proportional_damping_couples_no_shapes() {
    let n = 60;
    let beta = 2e-3;
    let system = chain(n, (1..=n).map(|i| (i - 1, i, 50.0 * beta)));
    assert!(system.structure().is_classical());
    let found = SparseModes::lowest(&system, 10).unwrap();
    let modes = found.modes().unwrap();
    assert_eq!(modes.as_slice().len(), 10);
    for (mode, square) in modes.iter().zip(found.squares()) {
        let omega = square.sqrt();
        let zeta = beta * omega / 2.0;
        let exact = Complex::new(-zeta * omega, omega * (1.0 - zeta * zeta).sqrt());
        let root = mode.eigenvalue();
        let error = (root.value - exact).norm();
        assert!(error <= 1e-13 * omega, "{} is not {exact}", root.value);
        assert!(
            error <= root.bound.unwrap() + 1e-15 * omega,
            "{error:e} {root:?}"
        );
        assert!(mode.backward_error() < 1e-13);
    }
}

#[test]
fn all_modes_are_those_of_the_dense_solvers() {
    // With every shape there the projection leaves nothing out.
    let system = chain(14, [(0, 3, 0.7), (5, 9, 2.0), (14, 13, 0.4)]);
    let modes = SparseModes::lowest(&system, 14).unwrap().modes().unwrap();
    let dense = system.modes().unwrap();
    assert_eq!(modes.eigenvalues().len(), dense.eigenvalues().len());
    for (mode, exact) in modes.iter().zip(&dense) {
        let (value, exact) = (mode.eigenvalue().value, exact.eigenvalue().value);
        assert!(
            (value - exact).norm() <= 1e-12 * exact.norm(),
            "{value} is not {exact}"
        );
        assert!(mode.backward_error() < 1e-12);
    }
}

#[test]
fn bounds_cover_what_the_projection_leaves_out() {
    let system = chain(60, [(0, 20, 0.05), (31, 32, 0.2), (60, 0, 0.1)]);
    let dense = system.modes_to(Precision::Double).unwrap();
    let (mut covered, mut moved) = (0, 0);
    for count in [6, 12, 24] {
        let modes = SparseModes::lowest(&system, count)
            .unwrap()
            .modes()
            .unwrap();
        for mode in &modes {
            let root = mode.eigenvalue();
            let exact = nearest(&dense, root.value).eigenvalue().value;
            let error = (root.value - exact).norm();
            let Some(bound) = root.bound else { continue };
            assert!(
                error <= bound,
                "{count}: {} off by {error:e}, bound {bound:e}",
                root.value
            );
            covered += 1;
            moved += usize::from(error > 1e-12 * exact.norm());
        }
    }
    assert!(covered >= 30, "{covered} bounds");
    assert!(
        moved >= 20,
        "only {moved} roots were moved by what was left out"
    );
}

#[test]
fn rigid_motions_with_and_without_dampers() {
    // Two floating parts, one of them held by a damper alone.
    let mut builder = System::builder();
    for i in 1..=20 {
        builder = builder.mass(name(i), 1.0);
        if i != 1 && i != 11 {
            builder = builder.spring(name(i - 1), name(i), 3.0);
        }
    }
    let undamped = builder.clone().build().unwrap();
    let system = builder.damper("ground", "m15", 0.5).build().unwrap();
    for system in [&undamped, &system] {
        let modes = SparseModes::lowest(system, 6).unwrap().modes().unwrap();
        let zeros = modes
            .eigenvalues()
            .iter()
            .filter(|root| root.value.norm() == 0.0);
        assert_eq!(Some(zeros.count()), system.structure().zero_roots());
    }
}
