//! Eigenpairs from elsewhere: closed forms and proven roots, spoilt by noise, with and without a factor; and what is no
//! eigenpair.

use std::f64::consts::PI;

use eigentone_modes::{
    Eigenpair, Eigenvalue, ExaminedPairs, Frequency, Modes, SparseError, SparseModes, System,
    examine_pairs,
};
use num_complex::Complex;
use proptest::prelude::*;

use crate::elements::{Ends, beam, membrane, rod};
use crate::networks::{name, network};
use crate::random::Random;

const NO_FACTOR: f64 = 0.0;
const FACTOR: f64 = 1e9;

fn lowest(system: &System, count: usize, pairs: Vec<Eigenpair>, operations: f64) -> ExaminedPairs {
    let target = Frequency::from_radians_per_second(0.0);
    examine_pairs(system, target, count, pairs, operations).unwrap()
}

impl Random {
    /// The same pair, less exact by a part.
    fn spoil(&mut self, pair: &Eigenpair, part: f64) -> Eigenpair {
        let largest = pair.shape.iter().map(|x| x.norm()).fold(0.0, f64::max);
        let mut noise = || -> Complex<f64> { Complex::new(self.signed(), self.signed()) * part };
        Eigenpair {
            value: pair.value * (Complex::<f64>::ONE + noise()),
            shape: pair.shape.iter().map(|x| x + noise() * largest).collect(),
        }
    }
}

/// Mode j of n masses of 1 between walls, by springs of 1.
fn of_chain(n: usize, j: usize) -> Eigenpair {
    let angle = j as f64 * PI / (n + 1) as f64;
    let shape = (1..=n).map(|i| Complex::from((i as f64 * angle).sin()));
    Eigenpair {
        value: Complex::new(0.0, 2.0 * (angle / 2.0).sin()),
        shape: shape.collect(),
    }
}

fn chain(n: usize, damping: f64) -> System {
    let mut builder = System::builder();
    for i in 1..=n {
        builder = builder.mass(name(i), 1.0);
    }
    for i in 0..=n {
        let ends = [i, (i + 1) % (n + 1)].map(name);
        builder = builder.spring(&ends[0], &ends[1], 1.0);
        if damping > 0.0 {
            builder = builder.damper(&ends[0], &ends[1], damping);
        }
    }
    builder.build().unwrap()
}

fn assert_near(root: Eigenvalue, exact: Complex<f64>, within: f64, what: &str) {
    let error = (root.value - exact).norm();
    let bound = root.bound.unwrap_or_else(|| panic!("{what}: {root:?}"));
    // Closed forms in doubles.
    let rounding = 8.0 * f64::EPSILON * exact.norm();
    assert!(
        error <= bound + rounding,
        "{what}: {root:?}, {exact}: {error:e}"
    );
    assert!(bound <= within * exact.norm(), "{what}: {root:?}");
}

#[test]
fn chains_by_closed_forms() {
    let n = 3000;
    let mut noise = Random(1);
    for damping in [0.0, 0.02] {
        let system = chain(n, damping);
        for (operations, part, within) in [
            (FACTOR, 1e-8, 2e-15),
            (FACTOR, 1e-5, 1e-14),
            (NO_FACTOR, 1e-15, 1e-13),
            (NO_FACTOR, 1e-10, 2e-3),
        ] {
            let what = format!("{damping}, {operations}, {part:e}");
            let mut pairs: Vec<Eigenpair> = (1..=7)
                .map(|j| noise.spoil(&of_chain(n, j), part))
                .collect();
            pairs.reverse();
            let found = lowest(&system, 6, pairs, operations);
            assert_eq!((found.modes.len(), found.unfit), (6, 0), "{what}");
            assert_eq!(found.modes.is_complete(), operations == FACTOR, "{what}");
            for (j, mode) in (1..).zip(&found.modes) {
                let omega = of_chain(n, j).value.im;
                let ratio = damping * omega / 2.0;
                let exact = Complex::new(-ratio, (1.0 - ratio * ratio).sqrt()) * omega;
                assert_near(mode.eigenvalue(), exact, within, &what);
                assert!(mode.backward_error() < 1e-6, "{what}");
            }
        }
    }
}

#[test]
fn a_missing_mode_is_found() {
    let system = chain(400, 0.0);
    let pairs = [1, 2, 4, 5, 6].map(|j| of_chain(400, j));
    let found = lowest(&system, 4, pairs.to_vec(), FACTOR);
    assert_eq!((found.modes.len(), found.unfit), (4, 0));
    assert!(found.missing > 0 && found.modes.is_complete());
    for (j, mode) in (1..).zip(&found.modes) {
        assert_near(mode.eigenvalue(), of_chain(400, j).value, 1e-15, "missing");
    }
    let found = lowest(&system, 4, pairs.to_vec(), NO_FACTOR);
    assert_eq!((found.modes.len(), found.missing), (4, 0));
    assert!(!found.modes.is_complete());
    assert!(found.modes.plan().to_string().contains("not proved"));
}

#[test]
fn what_is_no_eigenpair_is_left_out() {
    let n = 120;
    let mut noise = Random(2);
    for (operations, dashpot) in [
        (NO_FACTOR, false),
        (FACTOR, false),
        (NO_FACTOR, true),
        (FACTOR, true),
    ] {
        let what = format!("{operations}, {dashpot}");
        let system = match dashpot {
            false => chain(n, 0.0),
            true => {
                let nodes = 0..=n;
                let mut builder = System::builder();
                for i in 1..=n {
                    builder = builder.mass(name(i), 1.0);
                }
                for i in nodes {
                    builder = builder.spring(name(i), name((i + 1) % (n + 1)), 1.0);
                }
                builder.damper(name(0), name(7), 1e-3).build().unwrap()
            }
        };
        let truth: Vec<Eigenpair> = pairs_of(&system.modes().unwrap())
            .into_iter()
            .take(4)
            .collect();
        let mut pairs = truth.clone();
        pairs.push(truth[1].clone());
        pairs.push(Eigenpair {
            value: f64::NAN.into(),
            ..truth[0].clone()
        });
        pairs.push(Eigenpair {
            shape: vec![Complex::ZERO; n],
            ..truth[0].clone()
        });
        let mut broken = truth[2].clone();
        broken.shape[5].re = f64::INFINITY;
        pairs.push(broken);
        pairs.push(Eigenpair {
            value: Complex::new(0.0, 0.05),
            shape: (0..n).map(|_| Complex::from(noise.signed())).collect(),
        });
        let found = lowest(&system, 3, pairs, operations);
        assert_eq!((found.modes.len(), found.unfit), (3, 4), "{what}");
        for (mode, exact) in found.modes.iter().zip(&truth) {
            assert_near(mode.eigenvalue(), exact.value, 1e-6, &what);
        }
    }
}

#[test]
fn motions_that_nothing_holds_need_not_be_given() {
    let mut builder = System::builder();
    for i in 1..=50 {
        builder = builder.mass(name(i), i as f64);
    }
    for i in (1..50).filter(|i| *i != 20) {
        builder = builder.spring(name(i), name(i + 1), 1e3);
    }
    let system = builder.build().unwrap();
    let own = SparseModes::lowest(&system, 6).unwrap().modes().unwrap();
    let all = pairs_of(&system.modes().unwrap());
    for operations in [NO_FACTOR, FACTOR] {
        for pairs in [all[..6].to_vec(), all[1..6].to_vec()] {
            let found = lowest(&system, 6, pairs, operations);
            assert_eq!(found.unfit, 0);
            assert_eq!(found.modes.as_slice()[0].eigenvalue().bound, Some(0.0));
            assert_eq!(found.modes.as_slice()[0].roots(), 4);
            for (mode, own) in found.modes.iter().zip(&own) {
                let (mode, own) = (mode.eigenvalue(), own.eigenvalue());
                let apart = (mode.value - own.value).norm();
                assert!(
                    apart <= mode.bound.unwrap() + own.bound.unwrap(),
                    "{mode:?} {own:?}"
                );
            }
        }
    }
}

/// Every third node has no mass: its motion follows from equilibrium, and its residual is the rounding of that.
#[test]
fn nodes_without_mass() {
    let n = 90;
    let mut builder = System::builder();
    for i in 1..=n {
        let mass = if i % 3 == 0 { 0.0 } else { 1.0 };
        builder = builder.mass(name(i), mass);
    }
    for i in 0..=n {
        builder = builder.spring(name(i), name((i + 1) % (n + 1)), 100.0);
    }
    let system = builder.build().unwrap();
    let dense = system.modes().unwrap();
    let mut noise = Random(3);
    let pairs: Vec<Eigenpair> = pairs_of(&dense).into_iter().take(6).collect();
    let spoilt = pairs.iter().map(|pair| noise.spoil(pair, 1e-9)).collect();
    let found = lowest(&system, 5, spoilt, FACTOR);
    assert_eq!((found.modes.len(), found.unfit, found.missing), (5, 0, 0));
    assert!(found.modes.is_complete());
    for (mode, exact) in found.modes.iter().zip(&dense) {
        assert_near(
            mode.eigenvalue(),
            exact.eigenvalue().value,
            1e-14,
            "massless",
        );
    }
    // Without a factor nothing bounds them, which is said by having no bound.
    let found = lowest(&system, 5, pairs, NO_FACTOR);
    for (mode, exact) in found.modes.iter().zip(&dense) {
        let (root, exact) = (mode.eigenvalue(), exact.eigenvalue().value);
        let error = (root.value - exact).norm();
        assert!(root.bound.is_none_or(|bound| error <= bound), "{root:?}");
        assert!(error <= 1e-9 * exact.norm(), "{root:?}");
    }
}

#[test]
fn consistent_masses_without_a_factor() {
    let models = [
        (beam(Ends::Clamped, 60, 2.0, 1500.0, 3.1), 1e-4),
        (membrane(14), 1e-9),
        (rod(80, 3.0, 1.1, true), 1e-8),
    ];
    for (k, (model, within)) in models.iter().enumerate() {
        let system = model.system();
        let dense = system.modes().unwrap();
        let pairs: Vec<Eigenpair> = pairs_of(&dense).into_iter().take(9).collect();
        let found = lowest(&system, 8, pairs, NO_FACTOR);
        assert_eq!((found.modes.len(), found.unfit), (8, 0), "{k}");
        for (mode, exact) in found.modes.iter().zip(&dense) {
            let exact = exact.eigenvalue();
            assert_near(mode.eigenvalue(), exact.value, *within, &format!("{k}"));
        }
    }
}

/// A shape may have any size; a pair that is far from all modes is counted, and leaves the others alone.
#[test]
fn shapes_of_any_size_and_pairs_that_are_no_modes() {
    let n = 5;
    for damping in [0.0, 0.1] {
        let mut builder = System::builder();
        for i in 1..=n {
            builder = builder.mass(name(i), 1.0);
        }
        for i in 1..=n {
            builder = builder.spring(name(i - 1), name(i), 1.0);
        }
        // One damper couples all undamped shapes.
        let system = builder.damper(name(0), name(2), damping).build().unwrap();
        let all = pairs_of(&system.modes().unwrap());
        let good: Vec<Eigenpair> = all.into_iter().take(3).collect();
        for operations in [NO_FACTOR, FACTOR] {
            for size in [5e-324, 1e-170, 1e160, 1e300] {
                let mut pairs = good.clone();
                // What is left of a shape in the least double is a shape of no mode.
                let is_shape = size > 5e-324;
                pairs[1].shape.iter_mut().for_each(|x| *x *= size);
                let found = lowest(&system, 3, pairs, operations);
                let of = format!("{damping} {operations} {size:e}");
                assert!(!is_shape || found.unfit == 0, "{of}");
                assert!(found.modes.len() + found.unfit >= 3, "{of}");
                for mode in &found.modes {
                    let root = mode.eigenvalue();
                    let error = |pair: &Eigenpair| (pair.value - root.value).norm();
                    let error = good.iter().map(error).fold(f64::INFINITY, f64::min);
                    assert!(error <= 1e-9 || !is_shape, "{of}: {root:?}");
                }
            }
            for value in [1e100, 1e150, 1e154, 1e200, 1e300] {
                let mut pairs = good.clone();
                pairs.push(Eigenpair {
                    value: Complex::new(0.0, value),
                    shape: good[0].shape.clone(),
                });
                let found = lowest(&system, 3, pairs, operations);
                assert_eq!(found.modes.len(), 3, "{damping} {operations} {value:e}");
                assert!(
                    damping == 0.0 || found.unfit == 1,
                    "{damping} {operations} {value:e}"
                );
            }
        }
    }
}

#[test]
fn what_cannot_be_examined_says_why() {
    let system = chain(5, 0.0);
    let examined = |target: f64, count, pairs| {
        let target = Frequency::from_radians_per_second(target);
        examine_pairs(&system, target, count, pairs, FACTOR).unwrap_err()
    };
    let expected = SparseError::ShapeLength {
        given: 4,
        expected: 5,
    };
    assert_eq!(examined(0.0, 1, vec![of_chain(4, 1)]), expected);
    assert_eq!(examined(0.0, 0, vec![]), SparseError::NoneWanted);
    assert_eq!(
        examined(-1.0, 1, vec![]),
        SparseError::Target { target: -1.0 }
    );
    assert!(matches!(
        examined(f64::NAN, 1, vec![]),
        SparseError::Target { .. }
    ));
    // A count finds all of them missing.
    let found = lowest(&system, 3, vec![], FACTOR);
    assert_eq!((found.modes.len(), found.missing), (3, 3));
    assert!(lowest(&system, 3, vec![], NO_FACTOR).modes.is_empty());
}

/// The pairs of a dense answer, one for each shape of a mode.
fn pairs_of(modes: &Modes) -> Vec<Eigenpair> {
    let pair = |mode: &eigentone_modes::Mode| Eigenpair {
        value: mode.eigenvalue().value,
        shape: mode.shape().to_vec(),
    };
    modes.iter().map(pair).collect()
}

#[derive(Clone, Copy, Debug)]
enum Damping {
    None,
    Proportional,
    Coupling,
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn bounds_hold(
        n in 3usize..24,
        seed: u64,
        power in -13..-3,
        damping in prop::sample::select(vec![Damping::None, Damping::Proportional, Damping::Coupling]),
        factor: bool,
    ) {
        let mut noise = Random(seed);
        let mut number = |decades: f64| 10f64.powf(decades * noise.signed());
        let masses: Vec<f64> = (0..n).map(|_| number(1.0)).collect();
        let mut springs: Vec<(usize, usize, f64)> =
            (1..=n).map(|i| (i - 1, i, number(2.0))).collect();
        springs.push((1, n, number(1.0)));
        let system = match damping {
            Damping::None => network(masses, springs),
            _ => {
                let mut builder = System::builder();
                for (i, mass) in masses.iter().enumerate() {
                    builder = builder.mass(name(i + 1), *mass);
                }
                for (k, (a, b, stiffness)) in springs.iter().enumerate() {
                    builder = builder.spring(name(*a), name(*b), *stiffness);
                    let own = match damping {
                        Damping::Proportional => stiffness / 64.0,
                        _ if k % 3 == 0 => number(1.0) / 4.0,
                        _ => continue,
                    };
                    builder = builder.damper(name(*a), name(*b), own);
                }
                builder.build().unwrap()
            }
        };
        let dense = system.modes().unwrap();
        let part = 10f64.powi(power);
        let wanted = (n / 2).min(dense.len() - 1);
        let mut pairs: Vec<Eigenpair> = pairs_of(&dense);
        pairs.sort_by(|a, b| a.value.norm().total_cmp(&b.value.norm()));
        if let Damping::Coupling = damping {
            pairs.truncate(wanted + 1);
        }
        let pairs: Vec<Eigenpair> = pairs.iter().map(|pair| noise.spoil(pair, part)).collect();
        let operations = if factor { FACTOR } else { NO_FACTOR };
        let found = lowest(&system, wanted, pairs, operations);
        let mut free: Vec<Eigenvalue> = dense.eigenvalues().to_vec();
        let bounded = |root: &Eigenvalue| Some((root.bound?, *root));
        let mut roots: Vec<(f64, Eigenvalue)> =
            found.modes.eigenvalues().iter().filter_map(bounded).collect();
        roots.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (bound, root) in roots {
            let error = |exact: &Eigenvalue| (exact.value - root.value).norm();
            let nearest = (0..free.len()).min_by(|a, b| error(&free[*a]).total_cmp(&error(&free[*b])));
            let exact = free.swap_remove(nearest.unwrap());
            prop_assert!(
                error(&exact) <= bound + exact.bound.unwrap(),
                "{root:?} is not {exact:?}: {:e}", error(&exact)
            );
            prop_assert!(!factor || part > 1e-8 || bound <= 1e-12 * root.value.norm(), "{root:?}");
        }
        if part <= 1e-8 {
            prop_assert_eq!(found.modes.len(), wanted);
        }
    }
}
