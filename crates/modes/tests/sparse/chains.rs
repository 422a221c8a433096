//! ω_j = 2 √(k/m) sin(θ_j/2), with θ_j by the ends (Blevins, table 6-2).

use std::f64::consts::PI;

use eigentone_modes::{Frequency, MatrixKind, SparseModes, System};
use faer::sparse::{SparseColMat, Triplet};

use crate::networks::{assert_shapes, assert_squares, name, network};

const M: f64 = 0.7;
const K: f64 = 340.0;

#[derive(Clone, Copy, Debug)]
enum Ends {
    Both,
    First,
    Free,
}

fn chain(ends: Ends, n: usize) -> System {
    let inner = (1..n).map(|i| (i, i + 1, K));
    let outer = match ends {
        Ends::Both => vec![(0, 1, K), (n, 0, K)],
        Ends::First => vec![(0, 1, K)],
        Ends::Free => vec![],
    };
    network(vec![M; n], inner.chain(outer))
}

/// λ_j for j = 1 … n.
fn square(ends: Ends, n: usize, j: usize) -> f64 {
    let (j, n) = (j as f64, n as f64);
    let half = match ends {
        Ends::Both => j / (n + 1.0),
        Ends::First => (2.0 * j - 1.0) / (2.0 * n + 1.0),
        Ends::Free => (j - 1.0) / n,
    } * PI
        / 2.0;
    4.0 * (K / M) * half.sin().powi(2)
}

#[test]
fn lowest_modes_of_chains_of_any_length() {
    for ends in [Ends::Both, Ends::First, Ends::Free] {
        for n in [1, 2, 3, 10, 57, 1000, 20_000] {
            let system = chain(ends, n);
            for count in [1, 3, 20] {
                let modes = SparseModes::lowest(&system, count).unwrap();
                let expected: Vec<f64> = (1..=count.min(n)).map(|j| square(ends, n, j)).collect();
                let what = format!("{ends:?}, n = {n}, {count} modes");
                assert_squares(&modes, &expected, &what);
                assert_shapes(&system, &modes, 1e-11, &what);
            }
        }
    }
}

#[test]
fn a_chain_of_a_hundred_thousand_masses_keeps_all_digits() {
    let n = 100_000;
    let modes = SparseModes::lowest(&chain(Ends::Both, n), 20).unwrap();
    for (j, found) in modes.squares().iter().enumerate() {
        let exact = square(Ends::Both, n, j + 1);
        let off = (found / exact - 1.0).abs();
        assert!(off < 2e-15, "mode {j}: {found:e}, {exact:e}");
    }
    assert!(modes.is_counted());
    // One entry of L for each spring between masses: no order has less fill.
    assert_eq!(modes.work().entries, n - 1);
}

#[test]
fn modes_inside_the_spectrum() {
    for n in [30, 5000] {
        let system = chain(Ends::First, n);
        let all: Vec<f64> = (1..=n).map(|j| square(Ends::First, n, j)).collect();
        for at in [0.1, 0.5, 0.999] {
            let target = 2.0 * (K / M).sqrt() * at;
            let modes =
                SparseModes::nearest(&system, Frequency::from_radians_per_second(target), 12)
                    .unwrap();
            let mut nearest = all.clone();
            let distance = |square: &f64| (square.sqrt() - target).abs();
            nearest.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
            nearest.truncate(12);
            nearest.sort_by(f64::total_cmp);
            assert_squares(&modes, &nearest, &format!("n = {n}, near {target}"));
        }
    }
}

#[test]
fn a_target_that_is_an_eigenvalue() {
    let system = chain(Ends::Both, 400);
    let target = square(Ends::Both, 400, 40).sqrt();
    let modes =
        SparseModes::nearest(&system, Frequency::from_radians_per_second(target), 3).unwrap();
    let expected: Vec<f64> = (39..=41).map(|j| square(Ends::Both, 400, j)).collect();
    assert_squares(&modes, &expected, "on an eigenvalue");
}

#[test]
fn massless_nodes_between_masses() {
    let n = 500;
    // Each spring is two of twice its stiffness in series: nodes 2i − 1 are massless.
    let masses = (1..=2 * n + 1).map(|i| if i % 2 == 0 { M } else { 0.0 });
    let springs = (0..=2 * n + 1).map(|i| (i, (i + 1) % (2 * n + 2), 2.0 * K));
    let modes = SparseModes::lowest(&network(masses, springs), 9).unwrap();
    let expected: Vec<f64> = (1..=9).map(|j| square(Ends::Both, n, j)).collect();
    assert_squares(&modes, &expected, "massless nodes");
    // A massless node halves the distance between its neighbours.
    for k in 0..9 {
        let shape = modes.shapes().col(k);
        let middle = (shape[1] + shape[3]) / 2.0;
        let off = (shape[2] - middle).abs();
        assert!(off < 1e-10 * middle.abs().max(1e-3), "mode {k}");
    }
}

/// A bar of n elements, held at both ends, with the consistent mass matrix tridiag(1, 4, 1)/6.
fn consistent(n: usize) -> System {
    let matrix = |diagonal: f64, beside: f64| {
        let mut entries = Vec::new();
        for i in 0..n {
            entries.push(Triplet::new(i, i, diagonal));
            if i + 1 < n {
                entries.push(Triplet::new(i, i + 1, beside));
                entries.push(Triplet::new(i + 1, i, beside));
            }
        }
        SparseColMat::try_new_from_triplets(n, n, &entries).unwrap()
    };
    System::builder()
        .sparse_matrix(MatrixKind::Mass, matrix(4.0, 1.0))
        .sparse_matrix(MatrixKind::Stiffness, matrix(2.0, -1.0))
        .build()
        .unwrap()
}

#[test]
fn a_consistent_mass_matrix() {
    for n in [5, 300, 6000] {
        let count = n.min(7);
        let modes = SparseModes::lowest(&consistent(n), count).unwrap();
        let square = |j: usize| {
            let half = j as f64 * PI / (2.0 * (n as f64 + 1.0));
            let sine = half.sin().powi(2);
            4.0 * sine / (6.0 - 4.0 * sine)
        };
        let expected: Vec<f64> = (1..=count).map(square).collect();
        assert_squares(&modes, &expected, &format!("consistent, n = {n}"));
    }
}

#[test]
fn soft_springs_between_stiff_ones() {
    // Pairs of masses on springs of 1e16 k: the pairs move on the soft ones as a chain of double masses.
    let n = 400;
    let springs = (0..2 * n).map(|i| (i, i + 1, if i % 2 == 0 { K } else { 1e16 * K }));
    let modes = SparseModes::lowest(&network(vec![M / 2.0; 2 * n], springs), 12).unwrap();
    let expected: Vec<f64> = (1..=12).map(|j| square(Ends::First, n, j)).collect();
    assert_squares(&modes, &expected, "pairs");
}

#[test]
fn a_sparse_matrix_makes_the_system_that_a_dense_one_makes() {
    let n = 40;
    let sparse = consistent(n);
    let whole = |kind| sparse.added(kind).unwrap().to_owned();
    let dense = System::builder()
        .matrix(MatrixKind::Mass, whole(MatrixKind::Mass).as_ref())
        .matrix(MatrixKind::Stiffness, whole(MatrixKind::Stiffness).as_ref())
        .build()
        .unwrap();
    assert_eq!(whole(MatrixKind::Stiffness)[(3, 4)], -1.0);
    assert!(sparse.added_sparse(MatrixKind::Mass).is_none());
    for kind in [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness] {
        assert!(sparse.terms(kind).eq(dense.terms(kind)));
    }
    assert_eq!(sparse.mass_matrix(), dense.mass_matrix());
    assert_eq!(sparse.stiffness_matrix(), dense.stiffness_matrix());
    let roots = |system: &System| system.modes().unwrap().eigenvalues().to_vec();
    assert_eq!(
        format!("{:?}", roots(&sparse)),
        format!("{:?}", roots(&dense))
    );
    assert_eq!(
        sparse.structure().to_string(),
        dense.structure().to_string()
    );
}

/// Modes near a target above all of them: the highest ones.
fn assert_highest(system: &System, squares: &[f64], target: f64, count: usize, what: &str) {
    let modes = SparseModes::nearest(system, Frequency::from_radians_per_second(target), count);
    let what = format!("{what}, {count} near {target}");
    let modes = modes.unwrap_or_else(|error| panic!("{what}: {error}"));
    let highest = &squares[squares.len().saturating_sub(count)..];
    assert_squares(&modes, highest, &what);
}

#[test]
fn targets_above_the_highest_frequency() {
    for (ends, n) in [
        (Ends::Both, 1),
        (Ends::Both, 4),
        (Ends::First, 60),
        (Ends::Free, 402),
        (Ends::Both, 402),
        (Ends::First, 5000),
    ] {
        let system = chain(ends, n);
        let squares: Vec<f64> = (1..=n).map(|j| square(ends, n, j)).collect();
        let top = squares[n - 1].sqrt();
        if top == 0.0 {
            continue;
        }
        for factor in [1.000_01, 1.1, 1.5, 5.0, 100.0, 1e9] {
            for count in [1, 2, 5, 20] {
                let what = format!("{ends:?}, n = {n}, {factor} times the highest");
                assert_highest(&system, &squares, factor * top, count, &what);
            }
        }
    }
}

#[test]
fn massless_nodes_below_a_target_above_all() {
    // Each spring is `parts` of so many times its stiffness in series.
    for (n, parts) in [(201, 2), (134, 3), (100, 10), (500, 10)] {
        let nodes = parts * (n + 1) - 1;
        let masses = (1..=nodes).map(|i| if i % parts == 0 { M } else { 0.0 });
        let springs = (0..=nodes).map(|i| (i, (i + 1) % (nodes + 1), parts as f64 * K));
        let system = network(masses, springs);
        let squares: Vec<f64> = (1..=n).map(|j| square(Ends::Both, n, j)).collect();
        let top = squares[n - 1].sqrt();
        for factor in [1.1, 1.5, 5.0, 100.0] {
            for count in [1, 2, 5, 20] {
                let what = format!("{n} masses, {parts} springs each");
                assert_highest(&system, &squares, factor * top, count, &what);
            }
        }
    }
}

#[test]
fn modes_between_two_bands_are_the_highest_of_the_lower_one() {
    // Two chains, one of springs 1e6 times as stiff: its lowest frequency is far above the other's highest one.
    let n = 300;
    let both = |scale: f64, from: usize| {
        let node = move |i: usize| if i == 0 || i == n + 1 { 0 } else { from + i };
        (0..=n).map(move |i| (node(i), node(i + 1), scale * K))
    };
    let grounded = (n + 1..=2 * n).map(|i| (i, 0, 1e6 * K));
    let system = network(
        vec![M; 2 * n],
        both(1.0, 0).chain(both(1e6, n)).chain(grounded),
    );
    let squares: Vec<f64> = (1..=n).map(|j| square(Ends::Both, n, j)).collect();
    let top = squares[n - 1].sqrt();
    for factor in [1.2, 10.0, 200.0] {
        for count in [1, 3, 20] {
            assert_highest(&system, &squares, factor * top, count, "two bands");
        }
    }
}

#[test]
fn proportional_damping_below_a_target_above_all() {
    let (n, alpha, beta) = (5000, 0.125, 1.0 / 16384.0);
    let name = crate::networks::name;
    let mut builder = System::builder();
    for i in 1..=n {
        builder = builder.mass(name(i), M).damper(name(0), name(i), alpha * M);
    }
    for i in 0..n {
        builder = builder.spring(name(i), name(i + 1), K);
        builder = builder.damper(name(i), name(i + 1), beta * K);
    }
    let system = builder.build().unwrap();
    let top = square(Ends::First, n, n).sqrt();
    for factor in [1.5, 100.0] {
        for count in [1, 5, 20] {
            let target = Frequency::from_radians_per_second(factor * top);
            let modes = SparseModes::nearest(&system, target, count).unwrap();
            let modes = modes.modes().unwrap();
            assert!(modes.is_complete(), "{factor}, {count}");
            assert_eq!(modes.len(), count);
            let mut found: Vec<f64> = modes
                .iter()
                .map(|mode| mode.eigenvalue().value.im)
                .collect();
            found.sort_by(f64::total_cmp);
            for (im, j) in found.iter().zip(n + 1 - count..) {
                let square = square(Ends::First, n, j);
                let half = (alpha + beta * square) / 2.0;
                let exact = (square - half * half).sqrt();
                assert!((im / exact - 1.0).abs() < 1e-12, "{im} {exact}");
            }
        }
    }
}

#[test]
fn the_lowest_of_many_that_nearly_coincide() {
    // Masses on ground springs of 1e-6 N/m whose joins part their roots by 1e-9, far less than their distance from 0.
    let mut state = 3u64;
    let mut coin = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005);
        state = state.wrapping_add(1_442_695_040_888_963_407);
        state >> 63 == 1
    };
    let n = 450;
    let mut builder = System::builder();
    for i in 1..=n {
        let mass = if coin() { 2e6 } else { 1e6 };
        let stiffness = if coin() { 1e-9 } else { 1e-15 };
        builder = builder.mass(name(i), mass).spring("ground", name(i), 1e-6);
        if i < n && coin() {
            builder = builder.spring(name(i), name(i + 1), stiffness);
        }
    }
    let modes = SparseModes::lowest(&builder.build().unwrap(), 5).unwrap();
    assert_eq!(modes.len(), 5);
    assert!(modes.is_counted());
    for square in modes.squares() {
        assert!((square / 5e-13 - 1.0).abs() < 1e-8, "{square}");
    }
}
