//! Damping by ratios of the undamped modes, C = C₀ + MΦ diag(2ζω) ΦᵀM. Its last part is irrational. Its rounded matrix has other
//! structure: it damps rigid motions by 1e-50, or makes them grow.
//!
//! Facts that do not depend on sizes are proved of C₀ + K in place of C, where K ⪰ 0, C₀ ⪰ 0, and M ≻ 0 on the coordinates that have mass:
//!
//! - Roots at 0: both parts annul the motions N that need no force. In a basis of N and of what is M-orthogonal to it they act on
//!   the latter alone, where K has an inverse.
//! - Parts that nothing holds, and the rank of C where no ratio is 0: beside N neither part annuls anything.
//! - Classical damping: both parts have the shapes of (M, K), so that C₀ decides.

use super::coefficients::{Coefficient, Coefficients};
use crate::exact::matrix::ExactMatrix;
use crate::exact::null_space::annulled;
use crate::model::{MatrixKind, Model};

/// What is known of the ratios.
#[derive(Debug, PartialEq)]
pub(super) struct ByModes {
    /// ζ of each mode with ω ≠ 0, by rising ω.
    ratios: Vec<f64>,
    /// How many coordinates have no mass. What they follow is held by springs, as such damping asks for.
    massless: usize,
    /// C₀.
    rest: Coefficient,
}

/// Whether the rounded matrix may damp motions that need no force: they are not found exactly, or C does not annul all of them that C₀
/// annuls.
pub(super) fn damp_rigid_motions(model: &Model, whole: &Coefficients) -> bool {
    let Some(by_modes) = model.by_modes() else {
        return false;
    };
    if whole.stiffness.semidefinite_rank() == Some(model.len()) {
        return false;
    }
    let Some(motions) = whole.stiffness.null_space() else {
        return true;
    };
    let rest = ExactMatrix::of(&by_modes.beside, MatrixKind::Damping);
    annulled(&whole.damping.matrix, motions).len() < annulled(&rest, motions).len()
}

impl ByModes {
    /// Of a model with such damping, with what stands in for its matrices. `None` where K, C₀ or M is not
    /// proved to be as that takes.
    pub(super) fn of(model: &Model) -> Option<(ByModes, Coefficients)> {
        let by_modes = model.by_modes()?;
        let Coefficients {
            mass,
            damping,
            stiffness,
            ..
        } = Coefficients::of(&by_modes.beside);
        let n = model.len();
        let elastic = stiffness.semidefinite_rank()?;
        let massive = mass.semidefinite_rank()?;
        let is_massless = |i: &usize| mass.matrix.row(*i).next().is_none();
        let massless = (0..n).filter(is_massless).count();
        if massive + massless != n || damping.semidefinite_rank().is_none() {
            return None;
        }
        let ratio = |r: usize| by_modes.ratios.get(r).or(by_modes.ratios.last()).copied();
        let known = ByModes {
            ratios: (n - elastic..massive).map(ratio).collect::<Option<_>>()?,
            massless,
            rest: damping,
        };
        let stand_in = known.rest.plus(&stiffness);
        Some((known, Coefficients::from([mass, stand_in, stiffness])))
    }

    /// ζ of each mode with ω ≠ 0, by rising ω.
    pub(super) fn ratios(&self) -> &[f64] {
        &self.ratios
    }

    /// C₀.
    pub(super) fn rest(&self) -> &ExactMatrix {
        &self.rest.matrix
    }

    /// Whether C₀ = 0.
    fn is_alone(&self) -> bool {
        self.rest().is_zero()
    }

    /// Whether C is positive semidefinite for these ratios.
    pub(super) fn are_passive(&self) -> bool {
        self.ratios.iter().all(|ratio| *ratio >= 0.0)
    }

    /// Whether each root is real and no two of one mode are equal: all ratios are above 1.
    pub(super) fn are_overdamped(&self, n: usize) -> bool {
        self.is_alone() && self.ratios.len() == n && self.ratios.iter().all(|ratio| *ratio > 1.0)
    }

    /// Asked of what stands in for C, where no ratio is 0; else how many modes with ω ≠ 0 are of the kind, where there is no C₀.
    pub(super) fn counted(
        &self,
        stand_in: impl FnOnce() -> Option<usize>,
        is_counted: impl Fn(f64) -> bool,
    ) -> Option<usize> {
        if self.is_alone() {
            let ratios = self.ratios.iter().copied();
            return Some(ratios.filter(|ratio| is_counted(*ratio)).count());
        }
        // The stand-in damps what has no mass as well.
        let all = self.massless == 0 && self.ratios.iter().all(|ratio| *ratio > 0.0);
        all.then(stand_in)?
    }
}
