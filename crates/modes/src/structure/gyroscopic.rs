//! Gyroscopic systems: C = −Cᵀ does no work. For a shape x of a root λ, with real numbers
//! m = x*Mx > 0, k = x*Kx ≥ 0 and g = x*Cx/i, λ²m + iλg + k = 0 has the roots
//! λ = i(−g ± √(g² + 4mk))/2m: every motion oscillates for ever (Tisseur & Meerbergen 2001,
//! *SIAM Review* 43, on gyroscopic systems). With a stiffness that is not semidefinite it may not.

use std::cmp::Ordering;

use super::coefficients::Coefficients;
use crate::exact::matrix::ExactMatrix;
use crate::exact::sum::ExactSum;

/// Whether C = −Cᵀ ≠ 0, and M ≻ 0 and K ⪰ 0 are proved.
pub(crate) fn is_gyroscopic(coefficients: &Coefficients) -> bool {
    let [mass, damping, stiffness] = coefficients.parts();
    !damping.matrix.is_zero()
        && is_skew(&damping.matrix)
        && mass.semidefinite_rank() == Some(mass.matrix.len())
        && stiffness.semidefinite_rank().is_some()
}

/// Whether each entry and the one across the diagonal add up to 0.
pub(super) fn is_skew(matrix: &ExactMatrix) -> bool {
    (0..matrix.len()).all(|i| {
        matrix.row(i).all(|(j, terms)| {
            let mut sum = ExactSum::of(terms);
            matrix.entry(j, i).iter().for_each(|&term| sum.add(term));
            sum.sign() == Ordering::Equal
        })
    })
}

#[cfg(test)]
mod tests {
    use super::super::samples::{chain, matrices, network, with_matrices};
    use super::*;
    use crate::system::System;
    use faer::{Mat, mat};
    use proptest::prelude::*;

    fn gyroscopic(system: &System) -> bool {
        is_gyroscopic(&Coefficients::of(system.model()))
    }

    fn rotor(g: f64, stiffness: Mat<f64>) -> System {
        matrices(Mat::identity(2, 2), mat![[0.0, -g], [g, 0.0]], stiffness)
    }

    #[test]
    fn a_rotor_on_springs_or_on_none() {
        assert!(gyroscopic(&rotor(0.3, Mat::identity(2, 2))));
        assert!(gyroscopic(&rotor(1e-300, mat![[1.0, 1.0], [1.0, 1.0]])));
        assert!(gyroscopic(&rotor(2.0, Mat::zeros(2, 2))));
    }

    #[test]
    fn a_hilltop_is_not_answered() {
        // Stabilised by g > 2, unstable below; only K ⪰ 0 is a proof.
        assert!(!gyroscopic(&rotor(3.0, mat![[-1.0, 0.0], [0.0, -1.0]])));
        assert!(!gyroscopic(&rotor(3.0, mat![[1.0, 0.5], [-0.5, 1.0]])));
    }

    #[test]
    fn no_damping_and_true_damping_are_not_gyroscopic() {
        assert!(!gyroscopic(&rotor(0.0, Mat::identity(2, 2))));
        assert!(!gyroscopic(&chain(&[1.0; 2], &[1.0; 3], &[0.1; 3])));
        let almost = mat![[0.0, -1.0], [1.0_f64.next_up(), 0.0]];
        assert!(!gyroscopic(&matrices(
            Mat::identity(2, 2),
            almost,
            Mat::identity(2, 2)
        )));
        let massless = mat![[1.0, 0.0], [0.0, 0.0]];
        let skew = mat![[0.0, 1.0], [-1.0, 0.0]];
        assert!(!gyroscopic(&matrices(massless, skew, Mat::identity(2, 2))));
    }

    #[test]
    fn dampers_that_cancel_leave_a_rotor() {
        let skew = || Some(mat![[0.0, 1.0], [-1.0, 0.0]]);
        let springs = [(0, 1, 1.0), (0, 2, 1.0)];
        let with = |dampers: &[_]| {
            gyroscopic(&with_matrices(
                &[1.0, 1.0],
                &springs,
                dampers,
                [None, skew(), None],
            ))
        };
        assert!(with(&[(1, 2, 0.5), (1, 2, 0.25), (1, 2, -0.75)]));
        assert!(!with(&[(1, 2, 0.1), (1, 2, 0.2), (1, 2, -0.3)]));
        assert!(!gyroscopic(&network(&[1.0, 1.0], &springs, &[])));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(50))]

        /// What is proved: no root decays or grows.
        #[test]
        fn every_root_lies_on_the_imaginary_axis(numbers in prop::collection::vec(-4i8..5, 15)) {
            let number = |at: usize| f64::from(numbers[at]);
            let skew = Mat::from_fn(3, 3, |i, j| match i.cmp(&j) {
                Ordering::Less => number(i + j - 1),
                Ordering::Equal => 0.0,
                Ordering::Greater => -number(i + j - 1),
            });
            let factor = Mat::from_fn(3, 3, |i, j| number(3 + 3 * i + j));
            let stiffness = factor.transpose() * &factor + Mat::<f64>::identity(3, 3);
            let system = matrices(Mat::identity(3, 3), skew.clone(), stiffness);
            prop_assert_eq!(gyroscopic(&system), skew != Mat::<f64>::zeros(3, 3));
            let modes = system.modes().unwrap();
            for mode in modes.iter() {
                let size = mode.natural_frequency().radians_per_second();
                prop_assert!(mode.decay_rate().abs() <= 1e-6 * size, "{mode:?}");
            }
        }
    }
}
