//! Gyroscopic parts of C, which grow with the speed of rotors.

use super::{BuildError, System};
use crate::model::{MatrixKind, MoreDamping, Term, gathered, product};

impl System {
    /// The same system with `factor` times the gyroscopic part (C − Cᵀ)/2 in place of that part of C. Exact: products are
    /// kept in two doubles, and what is left symmetric stays as it was.
    ///
    /// ```
    /// use eigentone_modes::System;
    /// use faer::{Mat, mat};
    ///
    /// // A unit disc on springs of 4: σ² − gσ − 4 = 0 for frequencies σ of either sense.
    /// let gyroscopic = mat![[0.0, 1.0], [-1.0, 0.0]];
    /// let stiffness = mat![[4.0, 0.0], [0.0, 4.0]];
    /// let system = System::from_matrices(
    ///     Mat::identity(2, 2).as_ref(),
    ///     gyroscopic.as_ref(),
    ///     stiffness.as_ref(),
    /// )?;
    /// let modes = system.with_gyroscopic_part(3.0)?.modes()?;
    /// assert_eq!(modes.as_slice()[0].eigenvalue().value.im, 1.0);
    /// assert_eq!(modes.as_slice()[1].eigenvalue().value.im, 4.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`BuildError::DampingNotFinite`], [`BuildError::DampingRange`], [`BuildError::Singular`].
    pub fn with_gyroscopic_part(&self, factor: f64) -> Result<System, BuildError> {
        if !factor.is_finite() {
            return Err(BuildError::DampingNotFinite { value: factor });
        }
        let mut terms = Vec::new();
        for part in self.model().skew_terms() {
            for times in [0.5 * factor, -0.5] {
                let products = product(times, part.value).ok_or(BuildError::DampingRange)?;
                terms.extend(products.map(|value| Term { value, ..part }));
            }
        }
        terms.retain(|term| term.value != 0.0);
        if terms.is_empty() {
            return Ok(self.clone());
        }
        let model = self.model().clone().with_damping(MoreDamping {
            terms,
            is_given: true,
            ..MoreDamping::default()
        });
        let system = System::from(model);
        match system.is_singular() {
            true => Err(BuildError::Singular),
            false => Ok(system),
        }
    }

    /// The terms of C − Cᵀ, each entry being the exact sum of those in its place; none where C is symmetric.
    pub fn gyroscopic_terms(&self) -> Vec<Term> {
        self.model().skew_terms()
    }
}

impl crate::model::Model {
    fn skew_terms(&self) -> Vec<Term> {
        let all = self.terms(MatrixKind::Damping).flat_map(|term| {
            let across = Term {
                row: term.column,
                column: term.row,
                value: -term.value,
            };
            [term, across]
        });
        gathered(all.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::sum::ExactSum;
    use crate::model::GROUND;
    use faer::mat;

    /// C = S + G with entries whose products are no doubles, and a damper beside: the entries of S + fG are exact sums.
    #[test]
    fn nothing_is_rounded() {
        let damping = mat![[0.3, 0.1], [-0.7, 0.9]];
        let stiffness = mat![[2.0, 0.0], [0.0, 3.0]];
        let system = System::builder()
            .mass("a", 1.0)
            .mass("b", 1.0)
            .damper("a", "b", 0.2)
            .damper(GROUND, "a", 0.6)
            .matrix(MatrixKind::Damping, damping.as_ref())
            .matrix(MatrixKind::Stiffness, stiffness.as_ref())
            .build()
            .expect("a system");
        let factor = 0.1;
        let spun = system.with_gyroscopic_part(factor).expect("a system");
        for (i, j) in [(0, 1), (1, 0), (0, 0), (1, 1)] {
            // 2(S + fG) = C + Cᵀ + f(C − Cᵀ), and what is found is taken off.
            let mut left = ExactSum::of(&[]);
            let entry = |system: &System, row: usize, column: usize| -> Vec<f64> {
                let terms = system.terms(MatrixKind::Damping);
                let here = terms.filter(|term| (term.row, term.column) == (row, column));
                here.map(|term| term.value).collect()
            };
            for (row, column, sign) in [(i, j, 1.0), (j, i, -1.0)] {
                for value in entry(&system, row, column) {
                    left.add(value);
                    let parts = product(sign * factor, value).expect("within the range");
                    parts.into_iter().for_each(|part| left.add(part));
                }
            }
            for value in entry(&spun, i, j) {
                left.add(-2.0 * value);
            }
            assert_eq!(left.sign(), std::cmp::Ordering::Equal, "{i} {j}");
        }
        // At rest nothing but the symmetric part is left; without one nothing changes.
        let at_rest = system.with_gyroscopic_part(0.0).expect("a system");
        assert!(at_rest.gyroscopic_terms().is_empty() && at_rest.structure().is_symmetric());
        let again = at_rest.with_gyroscopic_part(7.0).expect("a system");
        assert_eq!(again.damping_matrix(), at_rest.damping_matrix());
    }

    #[test]
    fn factors_out_of_range_are_errors() {
        let gyroscopic = mat![[0.0, 1e200], [-1e200, 0.0]];
        let unit = mat![[1.0, 0.0], [0.0, 1.0]];
        let system = System::from_matrices(unit.as_ref(), gyroscopic.as_ref(), unit.as_ref());
        let system = system.expect("a system");
        let error = |factor: f64| system.with_gyroscopic_part(factor).err();
        assert_eq!(error(1e200), Some(BuildError::DampingRange));
        assert!(matches!(
            error(f64::NAN),
            Some(BuildError::DampingNotFinite { .. })
        ));
    }
}
