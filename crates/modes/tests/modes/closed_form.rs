//! Uniform chains, two masses on very different springs, and a gyroscopic pair.

use eigentone_digits::DoubleDouble;
use eigentone_modes::{Bounds, MatrixKind, Precision, System};
use faer::mat;

use crate::root::{Join, Root, assert_roots, network, quadratic};

/// sin x for 0 ≤ x ≤ π/2, by its series.
fn sine(x: DoubleDouble) -> DoubleDouble {
    let square = x * x;
    let (mut term, mut sum) = (x, x);
    for k in 1..20 {
        term = -(term * square / f64::from(2 * k * (2 * k + 1)).into());
        sum += term;
    }
    sum
}

#[test]
fn the_sine_is_right() {
    let eighth = DoubleDouble::TAU / 8.0.into();
    let half = DoubleDouble::from(0.5);
    assert!((sine(eighth) - half.sqrt()).to_f64().abs() < 1e-30);
    let twelfth = DoubleDouble::TAU / 12.0.into();
    assert!((sine(twelfth) - half).to_f64().abs() < 1e-30);
}

#[derive(Clone, Copy, Debug)]
enum Ends {
    FixedFixed,
    FixedFree,
    FreeFree,
}

impl Ends {
    const ALL: [Ends; 3] = [Ends::FixedFixed, Ends::FixedFree, Ends::FreeFree];

    fn joins(self, n: usize, coefficient: f64) -> Vec<Join> {
        let first = usize::from(matches!(self, Ends::FreeFree));
        let mut joins: Vec<Join> = (first..n).map(|i| (i, i + 1, coefficient)).collect();
        if matches!(self, Ends::FixedFixed) {
            joins.push((n, 0, coefficient));
        }
        joins
    }

    /// All ω for k/m = `rate`².
    fn frequencies(self, n: usize, rate: f64) -> Vec<DoubleDouble> {
        let (start, step, parts) = match self {
            Ends::FixedFixed => (1, 1, 2 * (n + 1)),
            Ends::FixedFree => (1, 2, 2 * (2 * n + 1)),
            Ends::FreeFree => (0, 1, 2 * n),
        };
        let half_turn = DoubleDouble::TAU * 0.5;
        let frequency = |j: usize| {
            let angle = half_turn * ((start + j * step) as f64) / (parts as f64).into();
            sine(angle) * (2.0 * rate)
        };
        (0..n).map(frequency).collect()
    }
}

/// Roots for c = βk: ζ = βω/2.
fn roots(frequencies: &[DoubleDouble], beta: f64) -> Vec<Root> {
    let roots = frequencies.iter().flat_map(|&omega| {
        if omega.to_f64() == 0.0 {
            [Root::new(0.0, 0.0); 2]
        } else {
            quadratic(omega, omega * (beta / 2.0))
        }
    });
    roots.collect()
}

const SIZES: [usize; 11] = [3, 4, 5, 6, 7, 8, 12, 19, 30, 45, 64];

#[test]
fn uniform_chains_without_damping() {
    for ends in Ends::ALL {
        for n in SIZES {
            // k/m = 2^20.
            let system = network(&vec![0.75; n], &ends.joins(n, 786_432.0), &[]);
            let modes = system.modes().expect("modes");
            let what = format!("{ends:?} {n}");
            assert_eq!(modes.bounds(), Bounds::Proven, "{what}");
            let roots = roots(&ends.frequencies(n, 1024.0), 0.0);
            assert_roots(&roots, &modes, 4.0, &what);
            let real = |mode: &eigentone_modes::Mode| mode.eigenvalue().value.im == 0.0;
            assert!(
                modes
                    .iter()
                    .all(|mode| real(mode) || mode.damping_ratio() == Some(0.0))
            );
        }
    }
}

#[test]
fn uniform_chains_with_dampers_beside_the_springs() {
    for ends in Ends::ALL {
        for n in SIZES {
            // Light damping; then half the modes beyond critical.
            for beta in [0.015_625, 2.0] {
                let (springs, dampers) = (ends.joins(n, 4.0), ends.joins(n, 4.0 * beta));
                let system = network(&vec![1.0; n], &springs, &dampers);
                let modes = system.modes().expect("modes");
                let what = format!("{ends:?} {n} β = {beta}");
                assert_eq!(modes.bounds(), Bounds::Proven, "{what}");
                let roots = roots(&ends.frequencies(n, 2.0), beta);
                assert_roots(&roots, &modes, 4.0, &what);
            }
        }
    }
}

#[test]
fn long_uniform_chains() {
    let n = 200;
    for ends in Ends::ALL {
        for beta in [0.0, 0.015_625] {
            let dampers = if beta == 0.0 {
                Vec::new()
            } else {
                ends.joins(n, 4.0 * beta)
            };
            let system = network(&vec![1.0; n], &ends.joins(n, 4.0), &dampers);
            let modes = system.modes().expect("modes");
            let roots = roots(&ends.frequencies(n, 2.0), beta);
            let what = format!("{ends:?} {n} β = {beta}");
            assert_eq!(modes.bounds(), Bounds::Proven, "{what}");
            assert_roots(&roots, &modes, 4.0, &what);
        }
    }
}

#[test]
fn critical_modes_of_a_uniform_chain() {
    // Three masses fixed at both ends: ω² = 2 for the middle mode, so β = √2 is critical but for
    // its rounding; with k = 2, ω = 2 and β = 1 exactly.
    let ends = Ends::FixedFixed;
    let system = network(&[1.0; 3], &ends.joins(3, 2.0), &ends.joins(3, 2.0));
    let modes = system.modes().expect("modes");
    let two = DoubleDouble::from(2.0);
    let frequency = |square: DoubleDouble| square.sqrt();
    let four = DoubleDouble::from(4.0);
    let spread = two.sqrt() * 2.0;
    let frequencies = [frequency(four - spread), two, frequency(four + spread)];
    assert_roots(&roots(&frequencies, 1.0), &modes, 4.0, "critical");
    let critical = modes
        .iter()
        .find(|mode| mode.is_defective() == Some(true))
        .expect("one is critical");
    assert_eq!(critical.multiplicity(), Some(2));
    assert_eq!(critical.eigenvalue().value, (-2.0).into());
    assert_eq!(critical.motion(), eigentone_modes::Motion::Decaying);
}

/// ω₊² = (k₁ + 2k₂ + √(k₁² + 4k₂²))/2, ω₋² = k₁k₂/ω₊².
#[test]
fn two_masses_on_very_different_springs() {
    for (k1, k2) in [(1.0, 1e16), (1e16, 1.0), (1.0, 1e25), (3.0, 1e-20)] {
        let (a, b) = (DoubleDouble::from(k1), DoubleDouble::from(k2));
        let upper = (a + b * 2.0 + (a * a + b * b * 4.0).sqrt()) * 0.5;
        let lower = a * b / upper;
        let roots = roots(&[upper.sqrt(), lower.sqrt()], 0.0);
        let system = network(&[1.0; 2], &[(0, 1, k1), (1, 2, k2)], &[]);
        let modes = system.modes().expect("modes");
        assert_eq!(modes.bounds(), Bounds::Proven);
        assert_roots(&roots, &modes, 4.0, &format!("{k1} {k2}"));
    }
}

/// z″ − igz′ + kz = 0 turns at σ = (g ± √(g² + 4k))/2, for ever.
#[test]
fn a_gyroscopic_pair_turns_for_ever() {
    for (g, k) in [
        (1.0, 1.0),
        (0.3, 2.0),
        (1e6, 1.0),
        (1e-9, 3.0),
        (7.0, 1e-12),
    ] {
        let system = System::builder()
            .mass("x", 1.0)
            .mass("y", 1.0)
            .spring("ground", "x", k)
            .spring("ground", "y", k)
            .matrix(MatrixKind::Damping, mat![[0.0, g], [-g, 0.0]].as_ref())
            .build()
            .expect("a regular system");
        let (a, b) = (DoubleDouble::from(g), DoubleDouble::from(k));
        let fast = (a + (a * a + b * 4.0).sqrt()) * 0.5;
        let roots: Vec<Root> = [fast, b / fast]
            .into_iter()
            .flat_map(|turn| [Root::new(0.0, turn), Root::new(0.0, -turn)])
            .collect();
        let modes = system.modes().expect("modes");
        assert_eq!(modes.bounds(), Bounds::Proven);
        assert_roots(&roots, &modes, 4.0, &format!("g = {g}, k = {k}"));
    }
}

/// Two masses of one frequency, 2 rad/s, joined by a damper alone: C = [2 −2; −2 5] has the eigenvalues 1 and 6, thus
/// λ² + λ + 4 and λ² + 6λ + 4, whose shapes only C determines.
#[test]
fn equal_frequencies_with_unlike_damping() {
    let system = network(
        &[1.0, 1.0],
        &[(0, 1, 4.0), (0, 2, 4.0)],
        &[(1, 2, 2.0), (0, 2, 3.0)],
    );
    let roots = [0.25, 1.5].map(|zeta| quadratic(2.0.into(), zeta.into()));
    for precision in [Precision::default(), Precision::Double] {
        let modes = system.modes_to(precision).expect("modes");
        assert_roots(&roots.concat(), &modes, 8.0, &format!("{precision:?}"));
        // (2, 1) belongs to the damping of 1, and (1, −2) to that of 6.
        for mode in modes.iter() {
            let ratio = (mode.shape()[1] / mode.shape()[0]).re;
            let wanted = if mode.eigenvalue().value.im == 0.0 {
                -2.0
            } else {
                0.5
            };
            let off = (ratio - wanted).abs();
            assert!(off < 1e-13, "{precision:?}: {ratio} {wanted}");
        }
    }
}

/// One mass, from light damping to far beyond critical.
#[test]
fn one_mass() {
    for c in [
        1e-28,
        1e-16,
        1e-8,
        0.1,
        1.999_999,
        2.0 - 4e-16,
        2.0 + 4e-16,
        3.0,
        1e8,
        1e16,
    ] {
        let system = network(&[1.0], &[(0, 1, 1.0)], &[(0, 1, c)]);
        let modes = system.modes().expect("modes");
        assert_eq!(modes.bounds(), Bounds::Proven);
        let roots = quadratic(1.0.into(), DoubleDouble::from(c) * 0.5);
        assert_roots(&roots, &modes, 4.0, &format!("c = {c:e}"));
    }
}
