//! How many directions are damped: the rank of C. A few dampers on a large structure leave all but
//! so many combinations of its undamped modes as they are.

use super::coefficients::Coefficients;
use crate::exact::rank::rank;

/// The rank of C: for dampers ≥ 0 the joins of a spanning forest, otherwise by exact elimination.
/// `None` where it is not proved.
pub(crate) fn damping_rank(coefficients: &Coefficients) -> Option<usize> {
    let damping = &coefficients.damping;
    damping
        .semidefinite_rank()
        .or_else(|| rank(&damping.matrix))
}

#[cfg(test)]
mod tests {
    use super::super::samples::{matrices, network};
    use super::*;
    use crate::system::System;
    use faer::{Mat, mat};
    use proptest::prelude::*;

    fn rank_of(system: &System) -> Option<usize> {
        damping_rank(&Coefficients::of(system.model()))
    }

    fn damping(matrix: Mat<f64>) -> System {
        let n = matrix.nrows();
        matrices(Mat::identity(n, n), matrix, Mat::identity(n, n))
    }

    #[test]
    fn dampers_are_counted_but_not_those_that_close_a_loop() {
        let rank = |dampers: &[_]| rank_of(&network(&[1.0; 6], &[(0, 1, 1.0)], dampers));
        assert_eq!(rank(&[]), Some(0));
        assert_eq!(rank(&[(0, 3, 0.1)]), Some(1));
        assert_eq!(rank(&[(1, 2, 0.1), (1, 2, 7.0), (4, 5, 1e-300)]), Some(2));
        let ring = [(1, 2, 0.1), (2, 3, 1e20), (3, 1, 0.3)];
        assert_eq!(rank(&ring), Some(2));
        assert_eq!(rank(&[ring.to_vec(), vec![(0, 1, 1.0)]].concat()), Some(3));
    }

    #[test]
    fn negative_dampers_can_lower_the_rank() {
        // 1 and −2 in series act as 2, which −2 takes away.
        let dampers = |last| [(0, 1, 1.0), (1, 2, -2.0), (0, 2, last)];
        let rank = |last| rank_of(&network(&[1.0; 2], &[(0, 1, 1.0)], &dampers(last)));
        assert_eq!(rank(-2.0), Some(1));
        assert_eq!(rank((-2.0_f64).next_up()), Some(2));
    }

    #[test]
    fn gyroscopic_matrices_have_even_rank() {
        assert_eq!(rank_of(&damping(mat![[0.0, 0.1], [-0.1, 0.0]])), Some(2));
        let skew = mat![[0.0, 0.1, 7.0], [-0.1, 0.0, 1e-9], [-7.0, -1e-9, 0.0]];
        assert_eq!(rank_of(&damping(skew)), Some(2));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        /// U Vᵀ of r columns that start with the unit matrix has rank r, whatever its signs.
        #[test]
        fn planted_ranks_are_found(
            n in 2usize..9,
            r in 0usize..4,
            numbers in prop::collection::vec(-99i32..100, 64),
        ) {
            let r = r.min(n);
            let factor = |from: usize| Mat::from_fn(n, r, |i, j| match i.checked_sub(r) {
                Some(_) => f64::from(numbers[(from + 3 * i + j) % 64]),
                None => f64::from(u8::from(i == j)),
            });
            let (u, v) = (factor(0), factor(32));
            prop_assert_eq!(rank_of(&damping(&u * v.transpose())), Some(r));
            prop_assert_eq!(rank_of(&damping(&u * u.transpose())), Some(r));
        }
    }
}
