//! Grids of equal masses and springs: λ is a sum of two eigenvalues of chains, so that square grids
//! have double eigenvalues and rings in two directions have eightfold ones.

use std::f64::consts::PI;

use eigentone_modes::{Frequency, SparseModes, System};

use crate::networks::{assert_squares, network};

/// a × b masses, every one with four springs, at the rim to the ground.
fn held(a: usize, b: usize) -> System {
    let node = |i: usize, j: usize| match (1..=a).contains(&i) && (1..=b).contains(&j) {
        true => (i - 1) * b + j,
        false => 0,
    };
    let mut springs = Vec::new();
    for i in 0..=a {
        springs.extend((1..=b).map(|j| (node(i, j), node(i + 1, j), 1.0)));
    }
    for i in 1..=a {
        springs.extend((0..=b).map(|j| (node(i, j), node(i, j + 1), 1.0)));
    }
    network(vec![1.0; a * b], springs)
}

/// a × b masses, closed to a ring in both directions, floating.
fn torus(a: usize, b: usize) -> System {
    let node = |i: usize, j: usize| (i % a) * b + j % b + 1;
    let mut springs = Vec::new();
    for i in 0..a {
        for j in 0..b {
            springs.push((node(i, j), node(i + 1, j), 1.0));
            springs.push((node(i, j), node(i, j + 1), 1.0));
        }
    }
    network(vec![1.0; a * b], springs)
}

fn sums(
    first: impl Fn(usize) -> f64,
    a: usize,
    second: impl Fn(usize) -> f64,
    b: usize,
) -> Vec<f64> {
    let mut all: Vec<f64> = (0..a)
        .flat_map(|i| (0..b).map(move |j| (i, j)))
        .map(|(i, j)| first(i) + second(j))
        .collect();
    all.sort_by(f64::total_cmp);
    all
}

fn held_squares(a: usize, b: usize) -> Vec<f64> {
    let one = |n: usize| {
        move |i: usize| {
            4.0 * ((i + 1) as f64 * PI / (2.0 * (n as f64 + 1.0)))
                .sin()
                .powi(2)
        }
    };
    sums(one(a), a, one(b), b)
}

fn torus_squares(a: usize, b: usize) -> Vec<f64> {
    let one = |n: usize| move |i: usize| 4.0 * (i.min(n - i) as f64 * PI / n as f64).sin().powi(2);
    sums(one(a), a, one(b), b)
}

#[test]
fn double_eigenvalues_of_square_grids() {
    for (a, b) in [(4, 4), (9, 9), (40, 40), (60, 30)] {
        let all = held_squares(a, b);
        // 3, 6 and 13 cut pairs of the square grids in two.
        for count in [1, 2, 3, 6, 13] {
            let modes = SparseModes::lowest(&held(a, b), count).unwrap();
            assert_squares(&modes, &all[..count], &format!("{a} × {b}, {count} modes"));
        }
    }
}

#[test]
fn eightfold_eigenvalues_of_rings() {
    for (a, b) in [(5, 5), (24, 24), (30, 15)] {
        let all = torus_squares(a, b);
        for count in [1, 2, 9, 20] {
            let modes = SparseModes::lowest(&torus(a, b), count).unwrap();
            let what = format!("ring {a} × {b}, {count} modes");
            assert_eq!(modes.squares()[0], 0.0, "{what}: the rigid motion");
            assert_eq!(modes.square_bounds()[0], Some(0.0));
            assert_squares(&modes, &all[..count], &what);
        }
    }
}

#[test]
fn inside_the_spectrum_of_a_ring() {
    let (a, b) = (20, 20);
    let all = torus_squares(a, b);
    let target: f64 = 1.3;
    let modes =
        SparseModes::nearest(&torus(a, b), Frequency::from_radians_per_second(target), 12).unwrap();
    let mut nearest = all.clone();
    let distance = |square: &f64| (square.sqrt() - target).abs();
    nearest.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    // Up to a whole number of multiples.
    let last = distance(&nearest[11]);
    assert!(distance(&nearest[12]) > last + 1e-6);
    nearest.truncate(12);
    nearest.sort_by(f64::total_cmp);
    assert_squares(&modes, &nearest, "inside a ring");
}

#[test]
fn equal_parts_that_nothing_joins() {
    // Seven chains, three of them held: every eigenvalue three- or fourfold.
    let (parts, n) = (7, 30);
    let mut springs = Vec::new();
    for part in 0..parts {
        let at = |i: usize| part * n + i;
        springs.extend((1..n).map(|i| (at(i), at(i + 1), 1.0)));
        if part < 3 {
            springs.push((0, at(1), 1.0));
        }
    }
    let system = network(vec![1.0; parts * n], springs);
    let mut all = Vec::new();
    for j in 0..n {
        let held = (2 * j + 1) as f64 * PI / (2.0 * (2 * n + 1) as f64);
        let free = j as f64 * PI / (2.0 * n as f64);
        all.extend([4.0 * held.sin().powi(2); 3]);
        all.extend([4.0 * free.sin().powi(2); 4]);
    }
    all.sort_by(f64::total_cmp);
    for count in [2, 4, 5, 7, 12, 25] {
        let modes = SparseModes::lowest(&system, count).unwrap();
        assert_squares(
            &modes,
            &all[..count],
            &format!("{count} modes of equal chains"),
        );
    }
}

#[test]
fn a_grid_of_ten_thousand_masses() {
    let modes = SparseModes::lowest(&held(100, 100), 10).unwrap();
    assert_squares(&modes, &held_squares(100, 100)[..10], "100 × 100");
}
