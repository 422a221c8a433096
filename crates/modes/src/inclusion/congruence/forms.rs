//! Bounds of all eigenvalues of (K, M) from S = XᵀKX and G = XᵀMX.
//!
//! For square X the pencils (K, M) and (S, G) = (XᵀKX, XᵀMX) have the same eigenvalues, and good
//! shapes make S and G nearly diagonal. With g = diag G, s = diag S and d_k = s_k/g_k write
//!
//! G = g^{1/2}(I + E_G)g^{1/2}, S = g^{1/2}D^{1/2}(I + E_S)D^{1/2}g^{1/2}, D = diag d ≥ 0.
//!
//! If ‖E_G‖ < 1 and ‖E_S‖ < 1, the k-th eigenvalues σ_k of (K, M) and d_k of D, both in rising
//! order, satisfy
//!
//! d_k (1 − ‖E_S‖)/(1 + ‖E_G‖) ≤ σ_k ≤ d_k (1 + ‖E_S‖)/(1 − ‖E_G‖).
//!
//! Proof. I + E_G is positive definite, so X and M are nonsingular and M is positive definite. By
//! Ostrowski's theorem (Horn & Johnson, *Matrix Analysis*, theorem 4.5.9) λ_k(TATᵀ) = θ_k λ_k(A)
//! with λ_min(TTᵀ) ≤ θ_k ≤ λ_max(TTᵀ) for symmetric A and nonsingular T. D^{1/2}(I + E_S)D^{1/2}
//! has the eigenvalues of TDTᵀ with T = (I + E_S)^{1/2}, which are θ_k d_k with
//! |θ_k − 1| ≤ ‖E_S‖; taking the pencil with I + E_G is one more congruence, by (I + E_G)^{-1/2}. ∎
//!
//! (This is theorem 2.3 of Demmel & Veselić 1992, *SIAM J. Matrix Anal.* 13, for both matrices.)
//! Scaled by D^{1/2}, the error is small against each frequency and not only the largest, and
//! roots that coincide cost nothing. The shapes of rigid-body motions are exact: their rows of S
//! vanish, and d = 0.
//!
//! ‖E‖ is bounded by the largest sum of |E_ij| over a row.

use eigentone_digits::DoubleDouble;

use crate::inclusion::gram::{Form, Gram, UPWARD};

/// Approximate shapes, the elastic ones first, with the forms that they are to diagonalise.
pub(in crate::inclusion) struct Basis<'a> {
    pub(in crate::inclusion) stiffness: Form<'a>,
    pub(in crate::inclusion) mass: Form<'a>,
    pub(in crate::inclusion) columns: Vec<Vec<DoubleDouble>>,
    pub(in crate::inclusion) elastic: usize,
}

/// S, G and d in a basis.
pub(in crate::inclusion) struct Forms {
    pub(super) stiffness: Gram,
    pub(super) mass: Gram,
    pub(super) squares: Vec<DoubleDouble>,
    /// A bound of |σ_k/d_k − 1| for all k, where it is below ½.
    pub(super) spread: f64,
}

impl Forms {
    /// With the rounding of the quotients s/g.
    pub(super) fn full_spread(&self) -> f64 {
        self.spread + 2f64.powi(-100)
    }
}

impl Basis<'_> {
    /// `None` where a shape has no frequency or a number leaves its range.
    pub(super) fn forms(&self) -> Option<Forms> {
        let stiffness = self.stiffness.gram(&self.columns[..self.elastic]);
        let mass = self.mass.gram(&self.columns);
        let in_range = |value: DoubleDouble| value.to_f64() > 1e-280 && value.to_f64() < 1e280;
        let diagonals = |gram: &Gram| (0..gram.size).all(|i| in_range(gram.at(i, i)));
        if !diagonals(&stiffness) || !diagonals(&mass) {
            return None;
        }
        let squares: Vec<DoubleDouble> = (0..self.elastic)
            .map(|i| stiffness.at(i, i) / mass.at(i, i))
            .collect();
        if !squares.iter().copied().all(in_range) {
            return None;
        }
        let (e_s, e_g) = (stiffness.distance(), mass.distance());
        // From both sides |σ/d − 1| ≤ (e_S + e_G)/(1 − e_G). Without the theorem's conditions this
        // is ½ or more, and no proof.
        let spread = (e_s + e_g) / (1.0 - e_g.min(0.5)) * UPWARD;
        Some(Forms {
            stiffness,
            mass,
            squares,
            spread,
        })
    }
}
