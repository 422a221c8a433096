//! Coordinates without mass and without dampers, which follow the others at once.
//!
//! With U the columns that span them, UᵀMU = 0 and XᵀMU = 0; where UᵀKU is regular, [X U] takes (K, M) to
//!
//! [S R; Rᵀ UᵀKU] and [G 0; 0 0], R = XᵀKU,
//!
//! so that the finite eigenvalues are those of (S − R (UᵀKU)⁻¹ Rᵀ, G). Of shapes in equilibrium, R is what rounding leaves. U holds
//! unit vectors that the inverse of a Cholesky factor turns, so that UᵀKU is near to 1, and positive definite as that is.

use eigentone_digits::{Cholesky, DoubleDouble};
use faer::Mat;

use super::gram::{Form, UPWARD};
use crate::system::System;

/// Columns in double-double.
type Columns = Vec<Vec<DoubleDouble>>;

/// What spans the coordinates that follow at once.
pub(super) struct Inert {
    /// U.
    columns: Columns,
    /// A bound of ‖UᵀKU − 1‖, below ½.
    distance: f64,
}

impl Inert {
    /// No coordinates.
    pub(super) fn none() -> Inert {
        Inert {
            columns: Vec::new(),
            distance: 0.0,
        }
    }

    /// Of all coordinates that neither masses nor dampers move; `None` where the springs on them are not proved to be
    /// definite, or K is not symmetric.
    pub(super) fn of(system: &System) -> Option<Inert> {
        let structure = system.structure();
        let damped = structure.damped_massless();
        let massless = structure.massless().iter();
        let massless: Vec<usize> = massless.filter(|i| !damped.contains(i)).copied().collect();
        if massless.is_empty() {
            return Some(Inert::none());
        }
        if !structure.has_symmetric_stiffness() {
            return None;
        }
        let stiffness = system.stiffness_matrix();
        let count = massless.len();
        let own = Mat::from_fn(count, count, |i, j| stiffness[(massless[i], massless[j])]);
        // Scaled to a diagonal of 1.
        let scale: Vec<f64> = (0..count).map(|i| own[(i, i)].sqrt().recip()).collect();
        let scaled = Mat::from_fn(count, count, |i, j| own[(i, j)] * scale[i] * scale[j]);
        let mut inverse = Mat::<f64>::identity(count, count);
        Cholesky::of(scaled.as_ref())?.divide_by_upper(inverse.as_mut());
        let column = |j: usize| {
            let mut column = vec![DoubleDouble::ZERO; system.len()];
            for (i, at) in massless.iter().enumerate() {
                column[*at] = DoubleDouble::from(scale[i] * inverse[(i, j)]);
            }
            column
        };
        let columns: Columns = (0..count).map(column).collect();
        let gram = Form::stiffness(system).gram(&columns);
        let unit = vec![1.0; count];
        let off = gram.distance(&unit, count);
        let own = (0..count).map(|i| (gram.at(i, i) - DoubleDouble::from(1.0)).to_f64().abs());
        let distance = (off + own.fold(0.0, f64::max)) * UPWARD;
        (distance < 0.5).then_some(Inert { columns, distance })
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.columns.len()
    }

    /// Lets them follow in each of the shapes, as far as rounding goes.
    pub(super) fn follow(&self, stiffness: &Form<'_>, shapes: &mut [Vec<DoubleDouble>]) {
        if self.columns.is_empty() {
            return;
        }
        let forces = stiffness.between(&self.columns, shapes);
        for (j, shape) in shapes.iter_mut().enumerate() {
            for (i, column) in self.columns.iter().enumerate() {
                let share = forces.at(i, j);
                for (entry, x) in shape
                    .iter_mut()
                    .zip(column)
                    .filter(|(_, x)| **x != DoubleDouble::ZERO)
                {
                    *entry -= share * *x;
                }
            }
        }
    }

    /// Bounds of the diagonal of R (UᵀKU)⁻¹ Rᵀ, a positive semidefinite matrix: no other entry exceeds the geometric mean of
    /// its two, nor does one between two sets of shapes that of one of each set.
    pub(super) fn left(&self, stiffness: &Form<'_>, shapes: &[Vec<DoubleDouble>]) -> Vec<f64> {
        if self.columns.is_empty() {
            return vec![0.0; shapes.len()];
        }
        let forces = stiffness.between(&self.columns, shapes);
        let square = |j: usize| {
            let each = (0..self.columns.len()).map(|i| forces.upper(i, j));
            let sum: f64 = each
                .map(|force| force * force * UPWARD + f64::MIN_POSITIVE)
                .sum();
            sum / (1.0 - self.distance) * UPWARD
        };
        (0..shapes.len()).map(square).collect()
    }
}
