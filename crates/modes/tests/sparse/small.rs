//! Small random systems: all their modes, and some, against the proven ones.

use eigentone_modes::{Bounds, Frequency, MatrixKind, Motion, SparseModes, System};
use faer::Mat;
use proptest::prelude::*;

use crate::networks::network;

/// ω² of every mode, rising, from the dense solvers: proven.
fn proven(system: &System) -> Vec<f64> {
    let modes = system.modes().unwrap();
    assert_eq!(modes.bounds(), Bounds::Proven);
    let mut squares = Vec::new();
    for mode in &modes {
        let value = mode.eigenvalue().value;
        match mode.motion() {
            // Two roots for each rigid motion.
            Motion::Rigid => squares.extend(vec![0.0; mode.roots() / 2]),
            Motion::Oscillating => squares.push(value.im * value.im),
            _ if value.re > 0.0 => squares.push(-value.re * value.re),
            _ => {}
        }
    }
    squares.sort_by(f64::total_cmp);
    squares
}

fn assert_same(modes: &SparseModes, expected: &[f64], within: f64) -> Result<(), TestCaseError> {
    prop_assert_eq!(modes.len(), expected.len());
    let found = modes.squares().iter().zip(modes.square_bounds());
    for ((found, bound), exact) in found.zip(expected) {
        let error = (found - exact).abs();
        prop_assert!(error <= within * exact.abs(), "{found:e} is not {exact:e}");
        let bound = bound.unwrap_or(f64::INFINITY);
        prop_assert!(
            error <= bound + 1e-15 * exact.abs(),
            "{error:e} beyond {bound:e}"
        );
    }
    Ok(())
}

/// Springs between random nodes; the least decades of stiffness 0.
fn springs(n: usize, decades: i32) -> impl Strategy<Value = Vec<(usize, usize, f64)>> {
    let tree = (1..=n).map(|i| (0..i, -decades..=decades, 1.0..9.0));
    let tree: Vec<_> = tree.collect();
    let extra = prop::collection::vec((0..=n, 0..=n, -decades..=decades, 1.0..9.0), 0..n);
    (tree, extra).prop_map(move |(tree, extra)| {
        let tree = tree.into_iter().enumerate();
        let tree = tree.map(|(i, (to, power, factor))| (to, i + 1, power, factor));
        tree.chain(extra)
            .filter(|(a, b, ..)| a != b)
            .map(|(a, b, power, factor)| (a, b, factor * 10f64.powi(power)))
            .collect()
    })
}

fn masses(n: usize) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec((-2..=2, 1.0..9.0), n)
        .prop_map(|masses| masses.into_iter().map(|(p, m)| m * 10f64.powi(p)).collect())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn all_modes_of_networks(
        (masses, springs) in (1usize..12).prop_flat_map(|n| (masses(n), springs(n, 2))),
    ) {
        let system = network(masses, springs);
        let modes = SparseModes::lowest(&system, system.len()).unwrap();
        prop_assert!(modes.is_counted());
        assert_same(&modes, &proven(&system), 1e-12)?;
    }

    #[test]
    fn lowest_modes_of_stiff_and_soft_networks(
        (masses, springs) in (2usize..40).prop_flat_map(|n| (masses(n), springs(n, 8))),
        count in 1usize..5,
    ) {
        let system = network(masses, springs);
        let modes = SparseModes::lowest(&system, count).unwrap();
        let expected = proven(&system);
        assert_same(&modes, &expected[..count.min(expected.len())], 1e-12)?;
    }

    #[test]
    fn floating_parts(
        (masses, springs) in (3usize..20).prop_flat_map(|n| (masses(n), springs(n, 2))),
        cut in 1usize..3,
    ) {
        // Without what holds it, and without one more.
        let springs: Vec<_> = springs.into_iter().filter(|s| s.0 != 0 && s.1 != 0 && s.0 != cut).collect();
        let system = network(masses, springs);
        let modes = SparseModes::lowest(&system, system.len()).unwrap();
        let expected = proven(&system);
        let zeros = expected.iter().filter(|square| **square == 0.0).count();
        prop_assert!(zeros > 0);
        prop_assert_eq!(modes.squares().iter().filter(|square| **square == 0.0).count(), zeros);
        assert_same(&modes, &expected, 1e-12)?;
    }

    #[test]
    fn modes_near_a_frequency(
        (masses, springs) in (2usize..25).prop_flat_map(|n| (masses(n), springs(n, 1))),
        place in 0.0..1.0f64,
    ) {
        let system = network(masses, springs);
        let all = proven(&system);
        let target = (all[0] + place * (all[all.len() - 1] - all[0])).sqrt();
        let mut nearest = all.clone();
        let distance = |square: &f64| (square.sqrt() - target).abs();
        nearest.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        let count = nearest.len().min(4);
        // Which of two at equal distances is taken is not determined.
        prop_assume!(nearest.len() == count
            || distance(&nearest[count]) > distance(&nearest[count - 1]) * (1.0 + 1e-9));
        nearest.truncate(count);
        nearest.sort_by(f64::total_cmp);
        let target = Frequency::from_radians_per_second(target);
        let modes = SparseModes::nearest(&system, target, count).unwrap();
        assert_same(&modes, &nearest, 1e-10)?;
    }

    #[test]
    fn negative_springs(
        (masses, springs) in (2usize..15).prop_flat_map(|n| (masses(n), springs(n, 1))),
        at in 1usize..3,
        push in 1.0..20.0f64,
    ) {
        let mut springs = springs;
        springs.push((0, at, -push));
        let system = network(masses, springs);
        let modes = SparseModes::lowest(&system, system.len()).unwrap();
        assert_same(&modes, &proven(&system), 1e-10)?;
    }
}

/// Hermite's cubic elements of an Euler–Bernoulli beam: stiffness and consistent mass, both ends free.
fn beam(elements: usize) -> [Mat<f64>; 2] {
    let n = 2 * (elements + 1);
    let h = 1.0;
    let k = [
        [12.0, 6.0 * h, -12.0, 6.0 * h],
        [6.0 * h, 4.0 * h * h, -6.0 * h, 2.0 * h * h],
        [-12.0, -6.0 * h, 12.0, -6.0 * h],
        [6.0 * h, 2.0 * h * h, -6.0 * h, 4.0 * h * h],
    ];
    let m = [
        [156.0, 22.0 * h, 54.0, -13.0 * h],
        [22.0 * h, 4.0 * h * h, 13.0 * h, -3.0 * h * h],
        [54.0, 13.0 * h, 156.0, -22.0 * h],
        [-13.0 * h, -3.0 * h * h, -22.0 * h, 4.0 * h * h],
    ];
    let (mut stiffness, mut mass) = (Mat::zeros(n, n), Mat::zeros(n, n));
    for e in 0..elements {
        for i in 0..4 {
            for j in 0..4 {
                stiffness[(2 * e + i, 2 * e + j)] += k[i][j];
                mass[(2 * e + i, 2 * e + j)] += m[i][j];
            }
        }
    }
    [stiffness, mass]
}

#[test]
fn beams_with_consistent_masses() {
    for elements in [2, 7, 25] {
        let [stiffness, mass] = beam(elements);
        let n = stiffness.nrows() - 2;
        // Clamped at the left: without its first two coordinates.
        let system = System::builder()
            .matrix(MatrixKind::Mass, mass.submatrix(2, 2, n, n))
            .matrix(MatrixKind::Stiffness, stiffness.submatrix(2, 2, n, n))
            .build()
            .unwrap();
        let modes = SparseModes::lowest(&system, 4).unwrap();
        assert!(modes.is_counted());
        assert_same(&modes, &proven(&system)[..4], 1e-11).unwrap();
    }
}

#[test]
fn a_free_beam_given_as_matrices() {
    // Both rigid motions are those of K itself, not of parts of a graph: 0 within their bounds.
    let [stiffness, mass] = beam(20);
    let system = System::from_matrices(
        mass.as_ref(),
        Mat::zeros(mass.nrows(), mass.nrows()).as_ref(),
        stiffness.as_ref(),
    )
    .unwrap();
    let modes = SparseModes::lowest(&system, 6).unwrap();
    let expected = proven(&system);
    assert_eq!(expected[..2], [0.0, 0.0]);
    for k in 0..2 {
        let bound = modes.square_bounds()[k].unwrap();
        assert!(
            modes.squares()[k].abs() <= bound && bound < 1e-15 * expected[2],
            "{modes:?}"
        );
    }
    for (square, exact) in modes.squares().iter().zip(&expected).skip(2) {
        assert!((square / exact - 1.0).abs() < 1e-11);
    }
    assert!(modes.is_counted());
}
