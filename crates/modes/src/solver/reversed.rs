//! Singular mass matrices: the roots of the reversed problem, one over another.
//!
//! With μ = 1/λ, (λ²M + λC + K)x = 0 becomes (μ²K + μC + M)x = 0 (Tisseur & Meerbergen 2001, *SIAM
//! Review* 43, §3.1). Where K is nonsingular this is an ordinary problem, and the infinite roots λ
//! are its roots μ = 0, which are counted exactly and set aside.

use eigentone_digits::{ComplexDoubleDouble, DoubleDouble};
use num_complex::Complex;

use crate::element::MatrixKind;
use crate::first_order::{FirstOrder, FirstOrderError};
use crate::modes::{Eigenvalue, Mode, Modes, Precision, order};
use crate::system::System;

use super::ModesError;

/// Whether masses, or springs and dampers on massless nodes, do not determine all accelerations.
pub(crate) fn is_needed(system: &System) -> bool {
    let singular = system.masses().contains(&0.0) || system.added(MatrixKind::Mass).is_some();
    singular && FirstOrder::of(system).is_err()
}

/// The modes of the system, from those of the reversed one.
///
/// # Errors
/// [`ModesError`] where K is singular too, or an iteration fails.
pub(crate) fn solve(system: &System, precision: Precision) -> Result<Modes, ModesError> {
    let singular = || match FirstOrder::of(system) {
        Err(error) => ModesError::FirstOrder(error),
        Ok(_) => ModesError::FirstOrder(FirstOrderError::SingularMass),
    };
    let reversed = System::from_matrices(
        system.stiffness_matrix().as_ref(),
        system.damping_matrix().as_ref(),
        system.mass_matrix().as_ref(),
    )
    .map_err(|_| singular())?;
    if is_needed(&reversed) || reversed.structure().finite_roots() != Some(2 * system.len()) {
        return Err(singular());
    }
    let mut modes = reversed.modes_to(precision)?;
    modes
        .modes
        .retain(|mode| mode.eigenvalue.value.norm() != 0.0);
    for mode in &mut modes.modes {
        *mode = inverted(mode);
    }
    modes.eigenvalues.retain(|root| root.value.norm() != 0.0);
    for root in &mut modes.eigenvalues {
        *root = inverse(root);
    }
    modes
        .modes
        .sort_by(|a, b| order(&a.eigenvalue, &b.eigenvalue));
    modes.eigenvalues.sort_by(order);
    modes.infinite = 2 * system.len() - modes.eigenvalues.len();
    modes.plan.reason = format!(
        "the masses do not determine every acceleration, so one over each root is computed; there: {}",
        modes.plan.reason
    );
    Ok(modes)
}

/// The mode of λ = 1/μ, again with Im λ ≥ 0: its shape is that of the conjugate root.
fn inverted(mode: &Mode) -> Mode {
    let conjugate = |shape: &Vec<Complex<f64>>| shape.iter().map(|x| x.conj()).collect();
    let mut result = mode.clone();
    result.eigenvalue = inverse(&mode.eigenvalue);
    if result.eigenvalue.value.im < 0.0 {
        result.eigenvalue = result.eigenvalue.conjugate();
        result.shape = conjugate(&mode.shape);
        result.left_shape = mode.left_shape.as_ref().map(conjugate);
    }
    result
}

/// λ = 1/μ, rounded once, with what the bounds of μ and the rounding make of it.
fn inverse(root: &Eigenvalue) -> Eigenvalue {
    let one = ComplexDoubleDouble::new(1.0, 0.0);
    let quotient = one / ComplexDoubleDouble::new(root.value.re, root.value.im);
    let value = Complex::new(quotient.re.to_f64(), quotient.im.to_f64());
    let size = root.value.norm();
    // |1/μ − 1/μ̂| ≤ b / (|μ̂|(|μ̂| − b)), and a rounding of each part.
    let bound = root.bound.filter(|bound| *bound < 0.5 * size).map(|bound| {
        let moved = bound / (size * (size - bound));
        let rounded = |part: DoubleDouble| part.low().abs();
        let rounding = rounded(quotient.re).hypot(rounded(quotient.im));
        // The division itself is right to 2^-98.
        let division = 2f64.powi(-96) * value.norm();
        (moved + rounding + division) * (1.0 + 8.0 * f64::EPSILON)
    });
    Eigenvalue {
        value,
        bound,
        real_bound: bound,
    }
}

#[cfg(test)]
mod tests {
    use faer::mat;

    use super::*;
    use crate::modes::Bounds;

    #[test]
    fn a_mass_shared_by_two_coordinates_leaves_three_roots() {
        // (λ² + λ + 3)(λ² + 2λ + 2) − (λ² − 1)² = 3λ³ + 9λ² + 8λ + 5.
        let system = System::from_matrices(
            mat![[1.0, 1.0], [1.0, 1.0]].as_ref(),
            mat![[1.0, 0.0], [0.0, 2.0]].as_ref(),
            mat![[3.0, -1.0], [-1.0, 2.0]].as_ref(),
        )
        .unwrap();
        let modes = system.modes().unwrap();
        assert_eq!(modes.infinite(), 1);
        assert_eq!(modes.eigenvalues().len(), 3);
        assert_eq!(modes.bounds(), Bounds::Proven);
        for root in modes.eigenvalues() {
            let z = root.value;
            let value = ((z * 3.0 + 9.0) * z + 8.0) * z + 5.0;
            let slope = (z * 9.0 + 18.0) * z + 8.0;
            assert!((value / slope).norm() <= 8.0 * f64::EPSILON * z.norm());
            assert!(root.bound.unwrap() <= 4.0 * f64::EPSILON * z.norm());
        }
        for mode in &modes {
            assert!(mode.backward_error() <= 1e-15, "{}", mode.backward_error());
        }
    }
}
