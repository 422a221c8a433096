//! The bounds hold, and are not idle.

use eigentone_digits::{DoubleDouble, sort_by_number};
use faer::Mat;

use super::*;
use crate::inclusion::quadratic::Damped;
use crate::system::System;

use crate::inclusion::{self, Approximation};
use crate::modes::{Bounds, Modes, Precision};
use crate::solver::solvers;
use crate::{GROUND, SystemBuilder};
use proptest::prelude::*;

const UNIT: f64 = f64::EPSILON / 2.0;

fn names(n: usize) -> Vec<String> {
    (0..n).map(|i| format!("m{i}")).collect()
}

/// Masses in a row; of n + 1 springs the first and the last lead to the ground, if not 0.
fn chain(masses: &[f64], springs: &[f64]) -> System {
    let n = masses.len();
    let names = names(n);
    let end = |i: usize| {
        if i == 0 || i > n {
            GROUND
        } else {
            &names[i - 1]
        }
    };
    let masses = names.iter().zip(masses);
    let system = masses.fold(System::builder(), |b, (name, mass)| b.mass(name, *mass));
    let springs = springs.iter().enumerate().filter(|(_, k)| **k != 0.0);
    springs
        .fold(system, |b, (i, k)| b.spring(end(i), end(i + 1), *k))
        .build()
        .unwrap()
}

/// Every mass joined to every other one.
fn complete(n: usize, mass: f64, spring: f64, ground: f64) -> System {
    let names = names(n);
    let mut builder = SystemBuilder::default();
    for (i, name) in names.iter().enumerate() {
        builder = builder.mass(name, mass);
        if ground != 0.0 {
            builder = builder.spring(GROUND, name, ground);
        }
        for other in &names[..i] {
            builder = builder.spring(other, name, spring);
        }
    }
    builder.build().unwrap()
}

fn approximate(system: &System) -> Modes {
    system.modes_to(Precision::Double).unwrap()
}

fn certified(system: &System) -> Option<Vec<Damped>> {
    certify(system, approximate(system).as_slice(), 4.0 * UNIT)
}

/// sin x by its series.
fn sine(x: DoubleDouble) -> DoubleDouble {
    let (mut term, mut sum) = (x, x);
    for k in 1..30 {
        term = -(term * x * x) / DoubleDouble::from(f64::from(2 * k * (2 * k + 1)));
        sum += term;
    }
    sum
}

/// Each frequency is its truth within the bound, and the bound within `tolerance`.
fn assert_true(found: &[Damped], truth: &[DoubleDouble], tolerance: f64) {
    assert_eq!(found.len(), truth.len());
    for (mode, truth) in found.iter().zip(truth) {
        let error = (*truth - DoubleDouble::from(mode.value.im)).to_f64().abs();
        assert!(
            error <= mode.bound + 1e-30 * mode.value.im,
            "{error:e} {mode:?}"
        );
        assert!(mode.bound <= tolerance * mode.value.im, "{mode:?}");
    }
}

#[test]
fn uniform_chains_of_200() {
    let n = 200;
    let (m, k) = (0.5, 3.0);
    let whole = vec![k; n + 1];
    let (mut hanging, mut free) = (whole.clone(), whole.clone());
    hanging[n] = 0.0;
    (free[0], free[n]) = (0.0, 0.0);
    let quarter = DoubleDouble::TAU * 0.25;
    // The argument of the sine is (j·p + q)/r quarter turns.
    for (springs, first, p, q, r) in [
        (whole, 1, 1.0, 0.0, n + 1),
        (hanging, 1, 2.0, -1.0, 2 * n + 1),
        (free, 1, 1.0, 0.0, n),
    ] {
        let count = n - usize::from(springs[0] == 0.0);
        let truth: Vec<DoubleDouble> = (first..first + count)
            .map(|j| {
                let turns = DoubleDouble::from(j as f64 * p + q) / DoubleDouble::from(r as f64);
                let root = DoubleDouble::from(4.0 * k / m).sqrt();
                root * sine(quarter * turns)
            })
            .collect();
        let system = chain(&vec![m; n], &springs);
        assert_true(&certified(&system).unwrap(), &truth, 1.01 * UNIT);
    }
}

#[test]
fn one_root_of_99() {
    for ground in [0.0, 0.25] {
        let system = complete(100, 2.0, 0.125, ground);
        let found = certified(&system).unwrap();
        let root = |square: f64| DoubleDouble::from(square).sqrt();
        let mut truth = vec![root((12.5 + ground) / 2.0); 99];
        if ground != 0.0 {
            truth.insert(0, root(ground / 2.0));
        }
        assert_true(&found, &truth, 1.01 * UNIT);
        assert_eq!(found.last().unwrap().multiplicity, 99);
        let modes = system.modes().unwrap();
        assert_eq!(modes.bounds(), Bounds::Proven);
        assert_eq!(modes.eigenvalues().len(), 200);
    }
}

#[test]
fn a_bar_of_finite_elements() {
    // K = tridiag(−1, 2, −1) and M = tridiag(1, 4, 1): σ = (2 − 2 cos θ)/(4 + 2 cos θ).
    let n = 99;
    let band = |a: f64, b: f64| {
        Mat::from_fn(n, n, |i, j| match i.abs_diff(j) {
            0 => a,
            1 => b,
            _ => 0.0,
        })
    };
    let (mass, stiffness) = (band(4.0, 1.0), band(2.0, -1.0));
    let none = Mat::<f64>::zeros(n, n);
    let system = System::from_matrices(mass.as_ref(), none.as_ref(), stiffness.as_ref()).unwrap();
    let truth: Vec<DoubleDouble> = (1..=n)
        .map(|j| {
            let share = DoubleDouble::from(j as f64) / DoubleDouble::from(400.0);
            let s = sine(DoubleDouble::TAU * share);
            let below = DoubleDouble::from(6.0) - s * s * 4.0;
            (s * s * 4.0 / below).sqrt()
        })
        .collect();
    assert_true(&certified(&system).unwrap(), &truth, 1.01 * UNIT);
}

#[test]
fn soft_beside_stiff() {
    // σ² − (k₁ + 2k₂)σ + k₁k₂ = 0.
    for stiff in [1e8, 1e16, 1e24] {
        let found = certified(&chain(&[1.0, 1.0], &[1.0, stiff, 0.0])).unwrap();
        let (one, k) = (DoubleDouble::from(1.0), DoubleDouble::from(stiff));
        let high = (one + k * 2.0 + (one + k * k * 4.0).sqrt()) * 0.5;
        assert_true(&found, &[(k / high).sqrt(), high.sqrt()], 1.01 * UNIT);
    }
    let n = 100;
    let springs: Vec<f64> = (0..=n)
        .map(|i| if i % 2 == 0 { 1.0 } else { 1e12 })
        .collect();
    let found = certified(&chain(&vec![1.0; n], &springs)).unwrap();
    assert!(
        found
            .iter()
            .all(|mode| mode.bound <= 4.0 * UNIT * mode.value.im)
    );
}

#[test]
fn nearly_equal_is_not_equal() {
    for coupling in [1e-9, 1e-13, 1e-16] {
        let found = certified(&chain(&[1.0, 1.0], &[1.0, coupling, 1.0])).unwrap();
        let apart = DoubleDouble::from(1.0) + DoubleDouble::from(2.0 * coupling);
        let truth = [DoubleDouble::from(1.0), apart.sqrt()];
        assert_true(&found, &truth, 1.01 * UNIT);
        assert!(found.iter().all(|mode| mode.multiplicity == 1));
    }
}

#[test]
fn no_proof_without_its_conditions() {
    // A node without mass follows where springs hold it, and does not where they push.
    assert!(certified(&chain(&[1.0, 0.0, 1.0], &[1.0; 4])).is_some_and(|found| found.len() == 2));
    assert!(certified(&chain(&[1.0, 0.0, 1.0], &[1.0, -1.0, -1.0, 1.0])).is_none());
    let damped = System::builder().mass("a", 1.0).spring(GROUND, "a", 1.0);
    assert!(certified(&damped.damper(GROUND, "a", 0.1).build().unwrap()).is_none());
    // A mode is missing, and one is given twice.
    let system = chain(&[1.0, 2.0], &[1.0, 2.0, 3.0]);
    let modes = approximate(&system).as_slice().to_vec();
    assert!(certify(&system, &modes[..1], 4.0 * UNIT).is_none());
    let twice = [modes[0].clone(), modes[0].clone()];
    assert!(certify(&system, &twice, 4.0 * UNIT).is_none());
}

/// What Weierstrass corrections prove of the same frequencies.
fn by_discs(system: &System) -> Option<Vec<(f64, f64)>> {
    let roots: Vec<Approximation<'_>> = approximate(system)
        .eigenvalues()
        .iter()
        .map(|root| Approximation::of(root.value))
        .filter(|root| root.value.norm() > 0.0)
        .collect();
    let (found, _) = inclusion::certify(system, &roots, 4.0 * UNIT, f64::INFINITY)?;
    let mut found: Vec<(f64, f64)> = found
        .iter()
        .flat_map(|root| root.members.iter().map(|_| (root.value.im, root.bound)))
        .collect();
    sort_by_number(&mut found, |pair| pair.0);
    Some(found)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn agrees_with_the_determinant(
        masses in prop::collection::vec(-3.0..3.0f64, 2..7),
        springs in prop::collection::vec(-6.0..6.0f64, 7),
        cross in prop::collection::vec(-6.0..6.0f64, 3),
        free in any::<bool>(),
    ) {
        let n = masses.len();
        let power = |x: &f64| 10f64.powf(*x);
        let masses: Vec<f64> = masses.iter().map(power).collect();
        let mut springs: Vec<f64> = springs[..=n].iter().map(power).collect();
        springs[n] = 0.0;
        if free {
            springs[0] = 0.0;
        }
        let mut builder = SystemBuilder::default();
        let names = names(n);
        for (name, mass) in names.iter().zip(&masses) {
            builder = builder.mass(name, *mass);
        }
        for (i, k) in springs.iter().enumerate().filter(|(_, k)| **k != 0.0) {
            let from = if i == 0 { GROUND } else { &names[i - 1] };
            builder = builder.spring(from, &names[i], *k);
        }
        for (i, k) in cross.iter().enumerate().filter(|(i, _)| i + 2 < n) {
            builder = builder.spring(&names[i], &names[i + 2], power(k));
        }
        let system = builder.build().unwrap();
        let found = certified(&system).expect("it is far from the end of the digits");
        let discs = by_discs(&system).expect("so few roots have discs");
        prop_assert_eq!(found.len(), discs.len());
        for (mode, (frequency, bound)) in found.iter().zip(discs) {
            prop_assert!(mode.bound <= 1.01 * UNIT * mode.value.im);
            prop_assert!((mode.value.im - frequency).abs() <= (mode.bound + bound) * 1.0001);
        }
    }
}

#[test]
fn a_negative_square_is_two_real_roots() {
    // K = [[2, −1], [−1, −2]], M = I: σ = ±√5.
    let found = certified(&chain(&[1.0, 1.0], &[1.0, 1.0, -3.0])).unwrap();
    let size = DoubleDouble::from(5.0).sqrt().sqrt();
    let near = |value: f64| (size - DoubleDouble::from(value.abs())).to_f64().abs();
    let values: Vec<_> = found.iter().map(|mode| mode.value).collect();
    assert_eq!(found.len(), 3);
    assert!(values[0].im == 0.0 && values[0].re < 0.0 && values[1] == -values[0]);
    assert!(values[2].re == 0.0 && values[2].im > 0.0);
    for mode in &found {
        assert!(near(mode.value.norm()) <= mode.bound && mode.bound <= 1.01 * UNIT * 1.5);
    }
}

#[test]
fn every_undamped_solver_leads_to_the_same_doubles() {
    let springs: Vec<f64> = (0..31).map(|i| 1.0 + f64::from(i % 7)).collect();
    let system = chain(&[1.5; 30], &springs);
    let undamped = solvers()
        .iter()
        .filter(|solver| solver.refuses(&system).is_none());
    let found: Vec<Vec<f64>> = undamped
        .map(|solver| {
            let modes = solver.solve(&system).unwrap();
            let found = certify(&system, modes.as_slice(), 4.0 * UNIT).unwrap();
            found.iter().map(|mode| mode.value.im).collect()
        })
        .collect();
    assert!(found.len() > 1);
    assert!(found.iter().all(|list| *list == found[0]));
}

/// 2 and 2.5, each to an eighth, lie between 1.75 and 2.8125.
#[test]
fn a_ball_about_several_squares_holds_what_is_open_of_each() {
    let squares = Squares {
        values: vec![DoubleDouble::from(2.0), DoubleDouble::from(2.5)],
        shapes: Vec::new(),
        columns: Vec::new(),
        reach: vec![0.25, 0.3125],
        null: 0,
    };
    let ball = squares.around(&(0..2));
    let (centre, reach) = (ball.middle().re.to_f64(), ball.radius().to_f64());
    assert!(
        centre - reach <= 1.75 && centre + reach >= 2.8125,
        "{centre} {reach}"
    );
    assert!(reach < 1.0);
}
