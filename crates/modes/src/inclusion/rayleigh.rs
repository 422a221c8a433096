//! All roots of a system with damping in proportion and by modes, from proven squares of its undamped frequencies.
//!
//! With C = αM + βK + MΦ diag(2ζω) ΦᵀM the roots are those of λ² + γλ + σ, γ = α + βσ + 2ζ√σ, for each eigenvalue σ of (K, M).
//! Where σ is known within a bound and α and β to 29 digits, so is γ. Of a node without mass, on which K is definite, Q(λ) is
//! (1 + βλ)K: where β ≠ 0 it adds a root −1/β.

use std::ops::Range;

use eigentone_digits::{Ball, DoubleDouble};

use super::bounded_shape::Shape;
use super::congruence::{Goal, squares};
use super::exactly::real;
use super::gram::UPWARD;
use super::quadratic::{Damped, Modal, around, roots};
use crate::system::System;

/// Proves a bound for every nonzero root of a system with such damping, given the same without dampers, or itself where no node
/// without mass is damped, and its elastic shapes approximately. `None` where no proof was reached.
pub(crate) fn certify(
    system: &System,
    undamped: &System,
    shapes: Vec<Vec<f64>>,
    tolerance: f64,
) -> Option<Vec<Damped>> {
    let structure = system.structure();
    let (proportion, ratios) = structure.law_with_massless()?;
    let (alpha, beta) = (known(proportion.of_mass), known(proportion.of_stiffness));
    let floating = structure.spring_floating();
    let drifts = proportion.of_mass == DoubleDouble::ZERO;
    // Of a lightly damped root the real part is small against the whole.
    let squares = squares(undamped, shapes, Goal::always(1e-27), tolerance)?;
    let rigid = floating.len() + squares.null;
    if structure.zero_roots() != Some(rigid * if drifts { 2 } else { 1 }) {
        return None;
    }
    // Which of several modes has which ratio, their order must show.
    let alike = |group: &Range<usize>| {
        let ratios = ratios.get(group.clone()).unwrap_or_default();
        ratios.iter().all(|ratio| *ratio == ratios[0])
    };
    if !ratios.is_empty()
        && (ratios.len() != squares.values.len() || !squares.groups().iter().all(alike))
    {
        return None;
    }
    let mut elastic = Vec::with_capacity(squares.values.len());
    for i in 0..squares.values.len() {
        let sigma = squares.around(&(i..i + 1));
        let mut gamma = alpha + beta * sigma;
        if let Some(ratio) = ratios.get(i) {
            gamma = gamma + real(2.0 * ratio) * root(sigma)?;
        }
        elastic.push(Modal {
            gamma,
            sigma: Some(sigma),
            shape: squares.shape(i),
            is_common: false,
        });
    }
    // σ = 0: what only dampers hold relaxes with −α.
    let null = squares.columns[squares.values.len()..]
        .iter()
        .take(squares.null);
    let whole = floating
        .iter()
        .map(|part| Shape::whole(system.len(), part, rigid == 1));
    let shapes = null.map(|column| Shape::plain(column)).chain(whole);
    let relaxing = shapes.filter(|_| !drifts).map(|shape| Modal {
        gamma: alpha,
        sigma: None,
        shape,
        is_common: false,
    });
    elastic.extend(relaxing);
    let massless = structure.damped_massless();
    if !massless.is_empty() {
        if massless.len() != structure.massless().len() {
            return None;
        }
        let gamma = Ball::ONE.checked_div(beta)?;
        elastic.extend(massless.iter().map(|i| Modal {
            gamma,
            sigma: None,
            shape: Shape::whole(system.len(), &[*i], massless.len() == 1),
            is_common: true,
        }));
    }
    roots(&elastic)
}

/// √σ of all σ > 0 in a ball; `None` where 0 may be one.
fn root(sigma: Ball<DoubleDouble>) -> Option<Ball<DoubleDouble>> {
    let (centre, reach) = (sigma.middle().re, sigma.radius().to_f64());
    if reach >= centre.to_f64() * (1.0 - 1e-9) {
        return None;
    }
    // √c − √(c − r) ≤ r/√c, and the square root rounds.
    let root = centre.sqrt();
    let size = root.to_f64();
    Some(around(
        root,
        (reach / size + size * 2f64.powi(-97)) * UPWARD,
    ))
}

/// α or β with its error.
fn known(value: DoubleDouble) -> Ball<DoubleDouble> {
    around(value, value.to_f64().abs() * 2f64.powi(-97))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::samples::network;
    use crate::{Bounds, MatrixKind, Modes};
    use faer::Mat;
    use num_complex::Complex;

    /// n masses of 2 kg, each joined to every other by a spring of ⅛ N/m and to the ground by one
    /// of `ground`: σ = ground/2 once, and (n/8 + ground)/2 for the rest. C = αM + βK.
    fn complete(n: usize, ground: f64, alpha: f64, beta: f64) -> System {
        let stiffness = Mat::from_fn(n, n, |i, j| {
            let own = if i == j {
                0.125 * n as f64 + ground
            } else {
                0.0
            };
            own - 0.125
        });
        let diagonal = |value: f64| Mat::from_fn(n, n, |i, j| if i == j { value } else { 0.0 });
        let damping = diagonal(2.0 * alpha) + &stiffness * faer::Scale(beta);
        let masses = (0..n).fold(System::builder(), |b, i| b.mass(format!("m{i}"), 2.0));
        let free = masses
            .matrix(MatrixKind::Stiffness, stiffness.as_ref())
            .matrix(MatrixKind::Damping, damping.as_ref());
        free.build().unwrap()
    }

    fn proven(system: &System) -> Option<Vec<Damped>> {
        let modes = crate::ClassicalModes::of(system).unwrap().unwrap();
        let elastic = (0..system.len()).filter(|j| modes.stiffness()[*j] != 0.0);
        let shape = |j: usize| modes.shapes().col(j).iter().copied().collect();
        let shapes = elastic.map(shape).collect();
        certify(system, system, shapes, 2.0 * f64::EPSILON)
    }

    /// λ = −γ/2 ± √(γ²/4 − σ) for exact γ and σ, the first with Im ≥ 0.
    fn truth(gamma: f64, sigma: f64) -> Vec<[DoubleDouble; 2]> {
        let zero = DoubleDouble::ZERO;
        let half = DoubleDouble::from(gamma / 2.0);
        let rest = half * half - DoubleDouble::from(sigma);
        if rest < zero {
            return vec![[-half, (-rest).sqrt()]];
        }
        let large = -half - rest.sqrt();
        vec![[large, zero], [DoubleDouble::from(sigma) / large, zero]]
    }

    #[test]
    fn roots_are_within_their_bounds() {
        let n = 70;
        for (ground, alpha, beta) in [
            (0.25, 0.03125, 0.0625),
            (0.25, 0.0, 2f64.powi(-30)),
            (0.25, 8.0, 0.5),
            (0.25, -0.5, 0.25),
            (0.5, 0.0, -0.125),
        ] {
            let system = complete(n, ground, alpha, beta);
            let found = proven(&system).unwrap();
            let mut expected = Vec::new();
            for (sigma, count) in [(ground / 2.0, 1), ((8.75 + ground) / 2.0, n - 1)] {
                for root in truth(alpha + beta * sigma, sigma) {
                    expected.push((root, count));
                }
            }
            assert_eq!(found.len(), expected.iter().map(|(_, count)| count).sum());
            for ([re, im], count) in expected {
                let off = |part: DoubleDouble, value: f64| {
                    (part - DoubleDouble::from(value)).to_f64().abs()
                };
                let size = re.to_f64().hypot(im.to_f64());
                let met = found.iter().filter(|root| {
                    let (a, b) = (off(re, root.value.re), off(im, root.value.im));
                    a <= root.real_bound && a.hypot(b) <= root.bound && root.multiplicity == count
                });
                assert_eq!(met.count(), count);
                let near = |root: &&Damped| (root.value.norm() - size).abs() < 1e-9 * size;
                for root in found.iter().filter(near) {
                    assert!(root.bound <= 1.01 * f64::EPSILON / 2.0 * 2f64.sqrt() * size);
                    let rounding = f64::EPSILON / 2.0 * re.to_f64().abs();
                    assert!(root.real_bound <= 1.01 * rounding + 1e-24 * size);
                }
            }
        }
    }

    #[test]
    fn what_only_dampers_hold_relaxes() {
        let n = 66;
        let system = complete(n, 0.0, 0.375, 0.125);
        let found = proven(&system).unwrap();
        let relaxing: Vec<&Damped> = found.iter().filter(|root| root.value.im == 0.0).collect();
        assert_eq!(relaxing.len(), 1);
        assert_eq!(relaxing[0].value, Complex::from(-0.375));
        assert!(relaxing[0].bound <= 1e-28);
        let modes: Modes = system.modes().unwrap();
        assert_eq!(modes.bounds(), Bounds::Proven);
        let zeros = modes
            .eigenvalues()
            .iter()
            .filter(|root| root.value.norm() == 0.0);
        assert_eq!((zeros.count(), modes.eigenvalues().len()), (1, 2 * n));
        // Drifting: two zeros, and no other real root.
        let system = complete(n, 0.0, 0.0, 0.125);
        assert!(
            proven(&system)
                .unwrap()
                .iter()
                .all(|root| root.value.im > 0.0)
        );
    }

    #[test]
    fn a_critically_damped_mode_is_one_entry() {
        // σ = 1 and γ = 2: −1 twice, beside 13 modes with σ = 15/8.
        let found = proven(&complete(14, 2.0, 2.0, 0.0)).unwrap();
        let double: Vec<&Damped> = found.iter().filter(|root| root.roots == 2).collect();
        assert_eq!((double.len(), found.len()), (1, 14));
        assert_eq!(
            (double[0].value, double[0].multiplicity),
            (Complex::from(-1.0), 2)
        );
        assert!(double[0].bound <= 1e-12);
        // An ulp beside it the roots differ by 2√(2u), which double-doubles show.
        for (alpha, real) in [(2f64.next_up(), 2), (2f64.next_down(), 0)] {
            let found = proven(&complete(14, 2.0, alpha, 0.0)).unwrap();
            assert!(found.iter().all(|root| root.roots == 1));
            let near = found.iter().filter(|root| root.value.im == 0.0);
            assert_eq!(near.count(), real);
            let expected = truth(alpha, 1.0);
            for [re, im] in expected {
                let off = |part: DoubleDouble, value: f64| {
                    (part - DoubleDouble::from(value)).to_f64().abs()
                };
                let met = found.iter().filter(|root| {
                    off(re, root.value.re).hypot(off(im, root.value.im)) <= root.bound
                        && off(re, root.value.re) <= root.real_bound
                });
                assert_eq!(met.count(), 1);
            }
        }
    }

    #[test]
    fn no_proof_without_proportion() {
        let system = network(&[1.0; 2], &[(0, 1, 1.0), (1, 2, 2.0)], &[(1, 2, 0.125)]);
        let shapes = vec![vec![1.0, 0.5], vec![0.5, -1.0]];
        assert!(certify(&system, &system, shapes, 1e-15).is_none());
    }
}
