//! Damped modes against the dense solvers, and against counts of roots in small discs in 384 bits.

use eigentone_modes::{Frequency, MatrixKind, Modes, Motion, SparseModes, System};
use faer::sparse::{SparseColMat, Triplet};
use num_complex::Complex;

use crate::elements::{Ends, Model, beam, frame, membrane};
use crate::inertia::inside;
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

fn lowest(system: &System, count: usize) -> Modes {
    let modes = SparseModes::lowest(system, count).unwrap().modes().unwrap();
    assert_eq!(modes.as_slice().len(), count);
    modes
}

/// Asserts that these are the first modes of a dense answer, each root within its bound and those of the dense one.
fn assert_first(modes: &Modes, dense: &Modes, what: &str) {
    for (k, (mode, exact)) in modes.iter().zip(dense).enumerate() {
        let (root, exact) = (mode.eigenvalue(), exact.eigenvalue());
        let error = (root.value - exact.value).norm();
        let bound = root
            .bound
            .unwrap_or_else(|| panic!("{what}: {k}: no bound"));
        assert!(
            error <= bound + exact.bound.unwrap(),
            "{what}: {k}: {} is not {}: {error:e}, {bound:e}",
            root.value,
            exact.value
        );
        assert!(bound <= 1e-12 * root.value.norm(), "{what}: {k}: {root:?}");
    }
}

/// Asserts that each disc has as many roots as modes that share it.
fn assert_inside(model: &Model, modes: &Modes, what: &str) {
    let roots: Vec<_> = modes.iter().map(|mode| mode.eigenvalue()).collect();
    for root in &roots {
        let bound = root.bound.unwrap_or_else(|| panic!("{what}: {root:?}"));
        assert!(bound <= 1e-10 * root.value.norm(), "{what}: {root:?}");
        let near =
            |other: &&eigentone_modes::Eigenvalue| (other.value - root.value).norm() <= 3.0 * bound;
        let mates = roots.iter().filter(near).count() as i64;
        let radius = if mates > 1 { 4.0 * bound } else { 1.01 * bound };
        let found = inside(model, root.value, radius);
        assert_eq!(found, mates, "{what}: {root:?}");
    }
}

/// K = tridiag(−1, 2, −1), M = 1 and C = K²/100: λ² + s²λ/100 + s = 0 for each eigenvalue s of K, though C is no sum of both.
#[test]
fn coupling_dampers_below_a_target_above_all() {
    let n = 1000usize;
    let matrix = |diagonal: f64, corner: f64, beside: f64, next: f64| {
        let mut entries = Vec::new();
        for i in 0..n {
            let is_end = i == 0 || i + 1 == n;
            entries.push(Triplet::new(i, i, if is_end { corner } else { diagonal }));
            for (to, value) in [(i + 1, beside), (i + 2, next)] {
                if to < n && value != 0.0 {
                    entries.push(Triplet::new(i, to, value));
                    entries.push(Triplet::new(to, i, value));
                }
            }
        }
        SparseColMat::try_new_from_triplets(n, n, &entries).unwrap()
    };
    let system = System::builder()
        .sparse_matrix(MatrixKind::Mass, matrix(1.0, 1.0, 0.0, 0.0))
        .sparse_matrix(MatrixKind::Damping, matrix(0.06, 0.05, -0.04, 0.01))
        .sparse_matrix(MatrixKind::Stiffness, matrix(2.0, 2.0, -1.0, 0.0))
        .build()
        .unwrap();
    for factor in [1.5, 10.0] {
        for count in [1, 3] {
            let target = Frequency::from_radians_per_second(2.0 * factor);
            let modes = SparseModes::nearest(&system, target, count).unwrap();
            let modes = modes.modes().unwrap();
            let what = format!("{count} near {factor} times the highest");
            assert_eq!(modes.len(), count, "{what}");
            for (mode, j) in modes.iter().zip(n + 1 - count..) {
                let angle = j as f64 * std::f64::consts::PI / (n as f64 + 1.0);
                let square = 4.0 * (angle / 2.0).sin().powi(2);
                let half = square * square / 200.0;
                let exact = Complex::new(-half, (square - half * half).sqrt());
                let root = mode.eigenvalue().value;
                assert!((root - exact).norm() <= 1e-12, "{what}: {root} {exact}");
            }
        }
    }
}

#[test]
fn few_dampers_on_a_chain() {
    for (dampers, what) in [
        (vec![(0, 20, 0.05), (31, 32, 0.2), (60, 0, 0.1)], "weak"),
        (vec![(0, 20, 30.0), (31, 32, 20.0), (60, 0, 10.0)], "medium"),
        (vec![(0, 20, 3e4), (31, 35, 2e5)], "strong"),
    ] {
        let system = chain(60, dampers);
        let dense = system.modes().unwrap();
        for count in [3, 12, 25] {
            let modes = lowest(&system, count);
            assert!(modes.is_complete(), "{what}, {count}");
            assert_first(&modes, &dense, what);
        }
    }
}

#[test]
fn every_link_damped_in_its_own_way() {
    // Nothing proves that none is missing.
    let system = chain(60, (1..=60).map(|i| (i - 1, i, 0.3 * (1 + i % 4) as f64)));
    let modes = lowest(&system, 8);
    assert!(!modes.is_complete());
    assert_first(&modes, &system.modes().unwrap(), "many");
}

#[test]
fn rayleigh_damping() {
    for (alpha, beta) in [
        (0.0, 1.0 / 65536.0),
        (0.5, 1.0 / 131072.0),
        (2.0, 0.0),
        (0.0, 0.5),
    ] {
        let model = beam(Ends::Cantilever, 20, 2.0, 1500.0, 3.1).proportional(alpha, beta);
        let system = model.system();
        let modes = lowest(&system, 6);
        let dense = system.modes().unwrap();
        let what = format!("{alpha}, {beta}");
        if modes.is_complete() {
            assert_first(&modes, &dense, &what);
        }
        // Where β is large, small real roots of the modes left out lie below all others.
        assert_eq!(modes.is_complete(), beta < 0.1, "{what}");
        assert_inside(&model, &modes, &what);
    }
}

#[test]
fn a_cantilever_with_a_dashpot_at_its_tip() {
    for damping in [0.3, 40.0, 1e4, 2e4] {
        let mut model = beam(Ends::Cantilever, 300, 2.0, 1500.0, 3.1);
        model.damping.add(598, 598, damping);
        let modes = lowest(&model.system(), 12);
        let what = format!("dashpot of {damping}");
        assert!(modes.is_complete(), "{what}");
        assert_inside(&model, &modes, &what);
        assert!(modes.iter().all(|mode| mode.motion() != Motion::Growing));
        // Nothing of the large real root that the dashpot gives the tip.
        for mode in &modes {
            assert!(
                mode.natural_frequency().radians_per_second() < 1e5,
                "{what}"
            );
        }
    }
}

#[test]
fn a_membrane_with_one_dashpot_keeps_undamped_modes() {
    let side = 12;
    let mut model = membrane(side);
    let node = 3 * side + 5;
    model.damping.add(node, node, 0.7);
    let modes = lowest(&model.system(), 10);
    assert!(modes.is_complete());
    assert_inside(&model, &modes, "membrane");
    // One of each pair of equal shapes has a node at the dashpot.
    let still = modes
        .iter()
        .filter(|mode| mode.eigenvalue().value.re == 0.0);
    assert!(still.count() >= 3);
    for mode in &modes {
        assert_ne!(mode.motion(), Motion::Growing);
    }
}

/// A ring of unit masses and springs, m0 … .
fn ring(n: usize) -> eigentone_modes::SystemBuilder {
    let mut builder = System::builder();
    for i in 1..=n {
        builder = builder.mass(name(i), 1.0);
    }
    for i in 1..=n {
        builder = builder.spring(name(i), name(i % n + 1), 1.0);
    }
    builder
}

#[test]
fn a_ring_with_a_dashpot_does_not_grow() {
    let system = ring(600).damper("ground", "m1", 0.25).build().unwrap();
    let modes = lowest(&system, 12);
    assert!(modes.is_complete());
    assert_eq!(modes.as_slice()[0].motion(), Motion::Rigid);
    for mode in &modes {
        let root = mode.eigenvalue();
        assert!(root.value.re <= 0.0, "{root:?}");
        assert_ne!(mode.motion(), Motion::Growing);
    }
    // Of each double frequency of the ring one shape has a node at the dashpot.
    for k in 1..5 {
        let exact = 2.0 * (std::f64::consts::PI * f64::from(k) / 600.0).sin();
        let still = modes.iter().map(|mode| mode.eigenvalue()).filter(|root| {
            root.value.re == 0.0
                && (root.value.im - exact).abs() <= root.bound.unwrap() + 2e-16 * exact
        });
        assert_eq!(still.count(), 1, "{k}");
    }
}

#[test]
fn near_an_eigenvalue_of_a_ring() {
    for dashpot in [0.0, 0.25] {
        let system = ring(600).damper("ground", "m1", dashpot).build().unwrap();
        for target in [1.0, std::f64::consts::SQRT_2] {
            let found =
                SparseModes::nearest(&system, Frequency::from_radians_per_second(target), 5)
                    .unwrap();
            let modes = found.modes().unwrap();
            assert!(modes.is_complete(), "{dashpot}, {target}");
            let first = modes.iter().any(|mode| {
                let root = mode.eigenvalue();
                (root.value.im - target).abs() <= root.bound.unwrap() + 2e-16
            });
            assert!(first, "{dashpot}, {target}");
        }
    }
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
        assert!(modes.is_complete());
    }
}

#[test]
fn heavy_damping_has_real_roots() {
    let system = chain(30, [(0, 10, 500.0), (20, 21, 900.0)]);
    let modes = lowest(&system, 10);
    let dense = system.modes().unwrap();
    assert_first(&modes, &dense, "heavy");
    let real = |modes: &Modes| {
        let real = |root: &Complex<f64>| root.im == 0.0;
        modes
            .iter()
            .take(10)
            .map(|mode| mode.eigenvalue().value)
            .filter(real)
            .count()
    };
    assert_eq!(real(&modes), real(&dense));
    assert!(real(&modes) > 0);
}

#[test]
fn massless_coordinates_with_and_without_dampers() {
    let n = 40;
    let mut builder = System::builder();
    for i in 1..=n {
        builder = builder.mass(name(i), if i % 4 == 0 { 0.0 } else { 1.5 });
    }
    for i in 1..=n {
        builder = builder.spring(name(i - 1), name(i), 30.0 + i as f64);
    }
    for (at, damping) in [(8, 3.0), (20, 0.2), (21, 5.0)] {
        builder = builder.damper("ground", name(at), damping);
    }
    let system = builder.build().unwrap();
    let modes = lowest(&system, 9);
    assert!(modes.is_complete());
    assert_first(&modes, &system.modes().unwrap(), "massless");
}

#[test]
fn growth_survives() {
    let system = chain(50, [(0, 7, -0.4), (20, 21, 0.3)]);
    let modes = lowest(&system, 8);
    // Nothing is passive here, so nothing is proved.
    assert!(!modes.is_complete());
    let dense = system.modes().unwrap();
    assert_first(&modes, &dense, "negative");
    assert!(modes.iter().any(|mode| mode.motion() == Motion::Growing));
}

#[test]
fn free_beams_with_a_dashpot() {
    for damping in [0.5, 2e3] {
        let mut model = beam(Ends::Free, 60, 2.0, 1500.0, 3.1);
        model.damping.add(0, 0, damping);
        let what = format!("free beam, dashpot of {damping}");
        let modes = lowest(&model.system(), 8);
        for mode in &modes {
            let root = mode.eigenvalue();
            let Some(bound) = root.bound else { continue };
            if root.value.norm() == 0.0 {
                continue;
            }
            assert_eq!(
                inside(&model, root.value, 1.01 * bound),
                1,
                "{what}: {root:?}"
            );
        }
        let known = modes
            .iter()
            .filter(|mode| mode.eigenvalue().bound.is_some());
        assert!(known.count() >= 7, "{what}");
    }
}

#[test]
fn graded_stiffness_with_dashpots() {
    let mut model = crate::elements::rod(110, 1.0, 1.35, true);
    model.damping.add(0, 0, 0.3);
    model.damping.add(60, 60, 20.0);
    let modes = lowest(&model.system(), 6);
    for mode in &modes {
        let root = mode.eigenvalue();
        if let Some(bound) = root.bound {
            assert_eq!(inside(&model, root.value, 1.01 * bound), 1, "{root:?}");
        }
    }
    assert!(modes.iter().all(|mode| mode.eigenvalue().bound.is_some()));
}

#[test]
fn equal_roots_are_not_called_simple() {
    let modes = lowest(&membrane(9).system(), 3);
    let repeats: Vec<_> = modes
        .iter()
        .map(|mode| (mode.multiplicity(), mode.cluster()))
        .collect();
    assert_eq!(repeats[0].0, Some(1));
    assert_eq!(repeats[1..], [(None, Some(2)); 2]);
    // The other one of the last pair was not asked for.
    let modes = lowest(&membrane(9).system(), 2);
    assert_eq!(modes.as_slice()[1].multiplicity(), None);
}

#[test]
fn some_of_several_rigid_motions() {
    // Three loose pairs, held by dampers alone.
    let mut builder = System::builder();
    for i in 1..=6 {
        builder = builder.mass(name(i), 1.0 + i as f64);
    }
    for i in [1, 3, 5] {
        builder = builder.spring(name(i), name(i + 1), 7.0);
        builder = builder.damper("ground", name(i), 0.1 * i as f64);
    }
    let system = builder.build().unwrap();
    for count in [2, 3] {
        let modes = lowest(&system, count);
        for mode in &modes {
            assert_eq!(mode.eigenvalue().value, Complex::ZERO);
            assert_eq!(
                (mode.multiplicity(), mode.is_defective()),
                (Some(3), Some(false))
            );
        }
    }
}

#[test]
fn a_free_frame_with_dashpots() {
    // Rounding holds its rigid motions by 1e-10 in ω².
    let nodes: Vec<[f64; 2]> = (0..60).map(|i| [0.1 * f64::from(i), 0.0]).collect();
    let bars: Vec<[usize; 2]> = (1..60).map(|i| [i - 1, i]).collect();
    let mut model = frame(&nodes, &bars, [2e7, 300.0, 1.7]);
    model.damping.add(1, 1, 2.0);
    model.damping.add(4, 4, 0.5);
    let modes = lowest(&model.system(), 7);
    let mut known = 0;
    for mode in &modes {
        let root = mode.eigenvalue();
        let Some(bound) = root.bound else { continue };
        if root.value.norm() != 0.0 {
            assert_eq!(inside(&model, root.value, 1.01 * bound), 1, "{root:?}");
            known += 1;
        }
    }
    assert!(known >= 3);
}

/// Masses on springs of their own, 1 and 2 in turn, and a damper between the first two.
fn apart(n: usize) -> System {
    let mut builder = System::builder();
    for i in 1..=n {
        let mass = 1.0 + f64::from(i % 2 == 0);
        builder = builder.mass(name(i), mass).spring("ground", name(i), 1.0);
    }
    builder.damper(name(1), name(2), 0.01).build().unwrap()
}

#[test]
fn few_of_many_that_coincide() {
    // It would take a minute to find and refine all.
    let target = Frequency::from_radians_per_second(0.66);
    let found = SparseModes::nearest(&apart(450), target, 5).unwrap();
    let modes = found.modes().unwrap();
    assert_eq!(modes.len(), 5);
    assert!(!modes.is_complete());
    for mode in &modes {
        let root = mode.eigenvalue();
        let error = (root.value.norm() - std::f64::consts::FRAC_1_SQRT_2).abs();
        assert!(error <= root.bound.unwrap(), "{root:?}");
        assert_eq!(mode.multiplicity(), None);
    }
}

#[test]
fn slow_decay_of_a_free_chain_beside_rest() {
    // What decays at 5e-12 1/s is far slower than the first oscillation, and all of that than 1 rad/s.
    let n = 60;
    let mut builder = System::builder();
    for i in 1..=n {
        builder = builder.mass(name(i), 1.0);
    }
    for i in 1..n {
        builder = builder.spring(name(i), name(i + 1), 1e-12);
    }
    let damping = 3e-10;
    let system = builder.damper("ground", name(7), damping).build().unwrap();
    let first = 2e-6 * (std::f64::consts::PI / 120.0).sin();
    let near = |target, count| {
        let target = Frequency::from_radians_per_second(target);
        SparseModes::nearest(&system, target, count)
    };
    for (found, count) in [
        (SparseModes::lowest(&system, 1), 1),
        (SparseModes::lowest(&system, 3), 3),
        (near(0.3 * first, 3), 3),
    ] {
        let modes = found.unwrap().modes().unwrap();
        assert_eq!(modes.len(), count);
        assert!(modes.is_complete(), "{count}");
        assert_eq!(modes.as_slice()[0].motion(), Motion::Rigid);
        if count > 1 {
            let root = modes.as_slice()[1].eigenvalue();
            assert_eq!(root.value.im, 0.0);
            assert!(
                (root.value.re * 60.0 / damping + 1.0).abs() < 1e-3,
                "{root:?}"
            );
        }
    }
}

#[test]
fn how_many_coincide_is_not_said_where_it_is_not_known() {
    let mut builder = System::builder();
    for i in 1..=450 {
        builder = builder.mass(name(i), 1.0).spring("ground", name(i), 1.0);
    }
    let system = builder.damper(name(1), name(2), 0.01).build().unwrap();
    let modes = lowest(&system, 5);
    assert!(!modes.is_complete());
    // As many as were asked for are there.
    assert_ne!(
        modes.plan().incomplete,
        Some("fewer roots were found than were asked for")
    );
    for mode in &modes {
        assert_eq!((mode.multiplicity(), mode.cluster()), (None, None));
    }
}

#[test]
fn above_the_highest_frequencies_of_a_damped_chain() {
    let n = 500;
    let mut builder = System::builder();
    for i in 1..=n {
        builder = builder.mass(name(i), 1.0);
    }
    for i in 1..=n {
        builder = builder.spring(name(i - 1), name(i), 1.0);
    }
    let system = builder
        .damper(name(20), name(21), 1e-4)
        .damper("ground", name(333), 1e-3)
        .build()
        .unwrap();
    for (target, count) in [(2.1, 2), (4.0, 8)] {
        let target = Frequency::from_radians_per_second(target);
        let found = SparseModes::nearest(&system, target, count).unwrap();
        let modes = found.modes().unwrap();
        assert_eq!(modes.len(), count);
        for (mode, k) in modes.iter().zip(n - count..) {
            let angle =
                std::f64::consts::PI * (2.0 * k as f64 + 1.0) / (2.0 * (2.0 * n as f64 + 1.0));
            let exact = 2.0 * angle.sin();
            let root = mode.eigenvalue();
            assert!(root.bound.is_some_and(|bound| bound < 1e-12), "{root:?}");
            assert!((root.value.im - exact).abs() < 1e-6, "{exact}: {root:?}");
        }
    }
}
