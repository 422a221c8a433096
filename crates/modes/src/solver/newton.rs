//! Roots that doubles leave in doubt, by Newton's method in double-double.

use eigentone_digits::ComplexDoubleDouble;
use num_complex::Complex;

use crate::quality::bordered::Resolved;
use crate::system::System;

use super::roots::{Root, normalised};

/// Up to so many coordinates, Newton's method in double-double is quick beside the eigenproblem.
pub(crate) const FEW: usize = 16;

/// The simple root within `reach` that Newton's method leads to, with its shapes, from the elements;
/// `None` where it does not converge or B there is singular to 27 digits.
pub(crate) fn resolved(system: &System, root: &Root, reach: f64) -> Option<Root> {
    let shape = normalised(&root.shape);
    let resolved = Resolved::of(system, root.value, &shape)?;
    let plain = |z: &ComplexDoubleDouble| Complex::new(z.re.to_f64(), z.im.to_f64());
    let value = plain(&resolved.lambda);
    if (value - root.value).norm() > reach {
        return None;
    }
    let left = resolved.left();
    let part = |part: f64| f64::EPSILON * part.abs() + resolved.error;
    // On the real axis it is one of two, and no longer stands for a pair.
    if root.value.im != 0.0 && value.im <= part(value.re).hypot(part(value.im)) {
        return None;
    }
    Some(Root {
        value,
        left: root
            .left
            .is_some()
            .then(|| left.iter().map(plain).collect()),
        shape: resolved.x.iter().map(plain).collect(),
        error: Some((part(value.re).hypot(part(value.im)), part(value.re))),
        ..root.clone()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::MatrixKind;
    use crate::solver::ModeSolver;
    use crate::solver::state_matrix::StateMatrix;
    use faer::mat;

    /// Bᵀ [(λ + 1)² − δ², 0; λ, λ² + λ + 3] B with B = [1 0; 2 1], every entry a double: the roots −1 ± δ,
    /// and those of λ² + λ + 3.
    fn nearly_defective(near: f64) -> System {
        let k = 1.0 - near * near;
        let (mass, damping, stiffness) = (
            mat![[5.0, 2.0], [2.0, 1.0]],
            mat![[8.0, 2.0], [3.0, 1.0]],
            mat![[k + 12.0, 6.0], [6.0, 3.0]],
        );
        let names = System::builder().mass("a", 0.0).mass("b", 0.0);
        names
            .matrix(MatrixKind::Mass, mass.as_ref())
            .matrix(MatrixKind::Damping, damping.as_ref())
            .matrix(MatrixKind::Stiffness, stiffness.as_ref())
            .build()
            .unwrap()
    }

    #[test]
    fn a_root_beside_another_is_found_to_its_last_digit() {
        let near = 2f64.powi(-24);
        let (system, value) = (nearly_defective(near), near - 1.0);
        // B⁻¹(1, (1 − δ)/(3 − δ + δ²)) on the right, B⁻¹(1, 0) on the left.
        let right = 1.0 / ((1.0 - near) / (3.0 - near + near * near) - 2.0);
        let left = -0.5;
        // An eighth of the way to where the two would meet.
        let off = near / 8.0;
        let shape = |ratio: f64| [ratio, 1.0].map(Complex::from).to_vec();
        let start = Root {
            left: Some(shape(left + off)),
            ..Root::simple(Complex::from(value - off), shape(right + off))
        };
        for reach in [off, 2.0 * off, 1.0] {
            let found = resolved(&system, &start, reach).unwrap();
            assert_eq!(found.value, Complex::from(value));
            let (error, real_error) = found.error.unwrap();
            assert!(error <= 1e-15 && real_error <= 1e-15);
            for (shape, ratio) in [(found.shape, right), (found.left.unwrap(), left)] {
                assert!((shape[0] / shape[1] - ratio).norm() <= 1e-15);
            }
        }
        // Further away than it may be.
        assert!(resolved(&system, &start, 0.99 * off).is_none());
    }

    /// Where two roots meet, each step is half as long as the one before: what is left is as long as the last.
    #[test]
    fn a_double_root_is_within_its_estimate_or_not_confirmed() {
        let system = nearly_defective(0.0);
        for power in 10..52 {
            let off = 2f64.powi(-power);
            let shape = |ratio: f64| [ratio, 1.0].map(Complex::from).to_vec();
            let start = Root {
                left: Some(shape(-0.5 + off)),
                ..Root::simple(Complex::from(-1.0 - off), shape(-0.6 + off))
            };
            if let Some(found) = resolved(&system, &start, 1.0) {
                let (error, _) = found.error.unwrap();
                let off = (found.value + 1.0).norm();
                assert!(off <= error, "{power}: {off:e} {error:e}");
            }
        }
    }

    #[test]
    fn roots_beside_each_other_keep_their_digits() {
        for power in 16..=20 {
            let near = 2f64.powi(-power);
            let system = nearly_defective(near);
            let modes = StateMatrix.solve(&system).unwrap();
            let others = Complex::new(-0.5, 0.5 * 11f64.sqrt());
            for root in [
                Complex::from(-1.0 - near),
                Complex::from(near - 1.0),
                others,
            ] {
                let off = modes.eigenvalues().iter().map(|e| (e.value - root).norm());
                let off = off.fold(f64::INFINITY, f64::min);
                assert!(off <= 2.0 * f64::EPSILON * root.norm(), "{root}: {off:e}");
            }
        }
    }
}
