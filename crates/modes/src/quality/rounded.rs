//! Roots near 0 that rounding of the entries of K may have moved there from 0.

use eigentone_digits::ComplexDoubleDouble;
use num_complex::Complex;

use crate::model::MatrixKind;
use crate::modes::{Mode, Modes};
use crate::system::System;

use super::rayleigh::Forms;

impl System {
    /// The places of modes whose roots may be 0 but for the rounding of the entries of a given K to doubles, as of a free
    /// structure from finite elements: rigid motions that come as slow oscillations, or as pairs of which one root decays and the
    /// other grows. None where K comes from springs, beams and rods, which are exact, or for more coordinates than full
    /// matrices are made of.
    ///
    /// To first order K + ΔK has a root at 0 where y*(K + ΔK)x = 0 for the shapes x and y of a root near 0 (Stewart and Sun 1990,
    /// *Matrix Perturbation Theory*, chapter VI). Entries off by two units in their last place each, as sums of some terms are, make
    /// that possible where |y*Kx| ≤ 4u·|y|ᵀ|K||x|. Of the two roots of μλ² + γλ + κ, with these forms, κ → 0 takes the smaller one to 0
    /// and leaves the other, −γ/μ, as of a free body that dampers hold. None of modes with another number of coordinates.
    ///
    /// ```
    /// use eigentone_modes::System;
    /// use faer::mat;
    ///
    /// // Of a free body, but for the last digit of an entry.
    /// let m = mat![[1.0, 0.0], [0.0, 1.0]];
    /// let k = mat![[3.0, -3.0], [-3.0, 3.0 + 4e-16]];
    /// let none = faer::Mat::zeros(2, 2);
    /// let system = System::from_matrices(m.as_ref(), none.as_ref(), k.as_ref())?;
    /// let modes = system.modes()?;
    /// assert!(modes.as_slice()[0].eigenvalue().value.norm() > 1e-9);
    /// assert_eq!(system.rigid_but_for_rounding(&modes), [0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn rigid_but_for_rounding(&self, modes: &Modes) -> Vec<usize> {
        /// Beside the largest root.
        const SLOW: f64 = 1e-4;
        const UNITS: f64 = 2.0 * f64::EPSILON;
        let model = self.model();
        let whole = model.added_whole(MatrixKind::Stiffness);
        let is_foreign = modes.iter().any(|mode| mode.shape().len() != self.len());
        if is_foreign || model.is_large() || whole.squares().is_some() {
            return Vec::new();
        }
        let Some(stiffness) = self.added(MatrixKind::Stiffness) else {
            return Vec::new();
        };
        let size = |mode: &Mode| mode.eigenvalue().value.norm();
        let largest = modes.iter().map(size).fold(0.0, f64::max);
        let is_moved = |mode: &Mode| {
            let x = mode.shape();
            let own: Vec<Complex<f64>> = x.iter().map(|x| x.conj()).collect();
            let y = mode.left_shape().unwrap_or(&own);
            let form: Forms = Forms::of(self, y, x);
            let columns = stiffness.col_iter().zip(x);
            let sum = |(column, x): (faer::ColRef<'_, f64>, &Complex<f64>)| {
                let each = column.iter().zip(y).map(|(k, y)| k.abs() * y.norm());
                each.sum::<f64>() * x.norm()
            };
            let near =
                |form: &ComplexDoubleDouble| Complex::new(form.re.to_f64(), form.im.to_f64());
            let [m, c, k] = [&form.m, &form.c, &form.k].map(near);
            let inertia = mode.eigenvalue().value * m;
            // Of a pair that oscillates both are as large.
            let is_smaller = inertia.norm() <= 2.0 * (inertia + c).norm();
            is_smaller && k.norm() <= UNITS * columns.map(sum).sum::<f64>()
        };
        let slow = |mode: &Mode| size(mode) > 0.0 && size(mode) <= SLOW * largest;
        let places = modes.iter().enumerate();
        let moved = places.filter(|(_, mode)| slow(mode) && is_moved(mode));
        moved.map(|(place, _)| place).collect()
    }
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::*;
    use crate::structure::samples::uniform_beam;

    /// A beam of 20 elements, each so long, without the first coordinates.
    fn beam(length: f64, without: usize) -> System {
        let n = 42 - without;
        let unit = |i: usize| if (i + without) % 2 == 1 { length } else { 1.0 };
        let scaled = uniform_beam(20).map(|a| {
            Mat::from_fn(n, n, |i, j| {
                unit(i) * a[(i + without, j + without)] * unit(j)
            })
        });
        let [m, k] = scaled.each_ref().map(Mat::as_ref);
        System::from_matrices(m, Mat::zeros(n, n).as_ref(), k).expect("a system")
    }

    /// Two masses on a spring, one of which a damper holds: the root at −c/(m₁ + m₂) owes nothing to the spring.
    #[test]
    fn what_dampers_slow_is_not_taken_for_rounding() {
        let of = |entries: [[f64; 2]; 2]| Mat::from_fn(2, 2, |i, j| entries[i][j]);
        let (m, c) = (of([[1.0, 0.0], [0.0, 1.0]]), of([[3.0, 0.0], [0.0, 0.0]]));
        let k = 1e10 * of([[1.0, -1.0], [-1.0, 1.0]]);
        let system = System::from_matrices(m.as_ref(), c.as_ref(), k.as_ref()).expect("a system");
        let modes = system.modes().expect("modes");
        assert!((modes.as_slice()[1].eigenvalue().value.re + 1.5).abs() < 1e-6);
        assert!(system.rigid_but_for_rounding(&modes).is_empty());
    }

    /// In units of which a third has no double the two rigid motions of a free beam are not at 0; bending, and a beam that is clamped,
    /// are not taken for them.
    #[test]
    fn rigid_motions_that_rounding_moved_are_named() {
        let rigid = |system: &System| {
            let modes = system.modes().expect("modes");
            let still = modes
                .iter()
                .filter(|mode| mode.eigenvalue().value.norm() == 0.0);
            (still.count(), system.rigid_but_for_rounding(&modes))
        };
        assert_eq!(rigid(&beam(1.0, 0)), (1, Vec::new()));
        let (still, moved) = rigid(&beam(1.0 / 3.0, 0));
        assert!(
            !moved.is_empty() && still + moved.len() <= 3,
            "{still}, {moved:?}"
        );
        assert_eq!(moved[0], still);
        assert_eq!(rigid(&beam(1.0 / 3.0, 2)), (0, Vec::new()));
        let others = beam(1.0 / 3.0, 2).modes().expect("modes");
        assert!(
            beam(1.0 / 3.0, 0)
                .rigid_but_for_rounding(&others)
                .is_empty()
        );
    }
}
