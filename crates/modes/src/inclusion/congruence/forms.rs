//! Bounds of all eigenvalues of (K, M) from S = XᵀKX and G = XᵀMX.
//!
//! For square X the pencils (K, M) and (S, G) = (XᵀKX, XᵀMX) have the same eigenvalues, and good
//! shapes make S and G nearly diagonal. With g = diag G, s = diag S and d_k = s_k/g_k write
//!
//! G = g^{1/2}(I + E_G)g^{1/2}, S = g^{1/2}(D + W^{1/2}E_S W^{1/2})g^{1/2}, D = diag d, w_k = max(|d_k|, w_0).
//!
//! If ‖E_G‖ < 1 and ‖E_S‖ < 1, the k-th eigenvalues σ_k of (K, M) and d_k of D, both in rising order, satisfy
//!
//! |σ_k − d_k| ≤ w_k (‖E_S‖ + ‖E_G‖)/(1 − ‖E_G‖).
//!
//! Proof. With η = ‖E_S‖, D + W^{1/2}E_S W^{1/2} lies between D − ηW and D + ηW, so that its k-th eigenvalue is within
//! ηw_k of d_k (Weyl's theorem; as η < 1 the diagonals of all three are in the same order; for w_0 = 0 this is theorem 2.1 of
//! Veselić & Slapničar 1993, *Lin. Alg. Appl.* 195). I + E_G is positive definite, so X and M are nonsingular and M is positive
//! definite, and taking the pencil with I + E_G is a congruence by (I + E_G)^{-1/2}, which multiplies each
//! eigenvalue by a number between 1/(1 + ‖E_G‖) and 1/(1 − ‖E_G‖) (Ostrowski's theorem; Horn & Johnson, *Matrix
//! Analysis*, theorem 4.5.9). ∎
//!
//! Scaled by W^{1/2}, the error is small against each frequency and not only the largest, K may be indefinite, and
//! roots that coincide cost nothing.
//!
//! Zeros are counted exactly. Shapes that a network of springs lets move as a whole are exact: their rows of S
//! vanish, and d = 0. Others are columns like all, with d = 0 in place of what rounding leaves and w_0 the least of the other |d|:
//! then the bounds above leave so many eigenvalues near 0 as there are zeros, and these are they.
//!
//! A frequency that rounding nearly hides beside the largest would make the bounds of all others as loose as its own: larger w_0
//! serve these, and of all bounds of a frequency the least counts.
//!
//! ‖E‖ is bounded by the largest sum of |E_ij| over a row. What coordinates without mass leave counts as a part of E_S
//! ([`inert`](crate::inclusion::inert)).

use eigentone_digits::{DoubleDouble, sort_by_number};

use crate::inclusion::gram::{Form, Gram, UPWARD};
use crate::inclusion::inert::Inert;

/// Approximate shapes, the elastic ones first, with the forms that they are to diagonalise.
pub(in crate::inclusion) struct Basis<'a> {
    pub(in crate::inclusion) stiffness: Form<'a>,
    pub(in crate::inclusion) mass: Form<'a>,
    pub(in crate::inclusion) columns: Vec<Vec<DoubleDouble>>,
    /// How many columns come before those that are exact; the last `null` of them have ω = 0 too.
    pub(in crate::inclusion) elastic: usize,
    pub(in crate::inclusion) null: usize,
    /// The coordinates that follow at once: the columns are as many as all others.
    pub(in crate::inclusion) inert: Inert,
    /// In how many slices forms are computed.
    pub(in crate::inclusion) slices: usize,
}

/// S, G and d in a basis.
pub(in crate::inclusion) struct Forms {
    pub(super) stiffness: Gram,
    pub(super) mass: Gram,
    /// d, 0 for the null columns, which come last.
    pub(super) squares: Vec<DoubleDouble>,
    /// Where the null columns begin.
    pub(super) nonzero: usize,
    /// Bounds of |σ_k − d_k| for all k before them.
    pub(super) reach: Vec<f64>,
    /// The largest of |σ_k − d_k|/|d_k|. Without the theorem's conditions this is ½ or more, and no proof.
    pub(super) spread: f64,
}

impl Basis<'_> {
    /// S, G and d; `None` where a shape has no frequency or a number leaves its range.
    pub(super) fn forms(&self) -> Option<Forms> {
        let elastic = &self.columns[..self.elastic];
        let stiffness = self.stiffness.gram_in(self.slices, elastic);
        let mass = self.mass.gram_in(self.slices, &self.columns);
        self.forms_of(stiffness, mass)
    }

    /// The same, given S and G.
    pub(super) fn forms_of(&self, stiffness: Gram, mass: Gram) -> Option<Forms> {
        let nonzero = self.elastic - self.null;
        let in_range = |value: DoubleDouble| {
            let size = value.to_f64().abs();
            size > 1e-280 && size < 1e280
        };
        let own = |i: usize| mass.at(i, i);
        let is_mass = |i: usize| own(i).to_f64() > 0.0 && in_range(own(i));
        let is_stiff = |i: usize| in_range(stiffness.at(i, i));
        if !(0..mass.size).all(is_mass) || !(0..nonzero).all(is_stiff) {
            return None;
        }
        let mut squares: Vec<DoubleDouble> =
            (0..nonzero).map(|i| stiffness.at(i, i) / own(i)).collect();
        if !squares.iter().copied().all(in_range) {
            return None;
        }
        let sizes: Vec<f64> = squares.iter().map(|square| square.to_f64().abs()).collect();
        squares.resize(self.elastic, DoubleDouble::ZERO);
        let e_g = mass.distance_from_diagonal();
        let left = self
            .inert
            .left(&self.stiffness, &self.columns[..self.elastic]);
        let mut reach = vec![f64::INFINITY; nonzero];
        for floor in floors(&sizes) {
            let size = |i: usize| {
                let weight = sizes.get(i).map_or(floor, |size| size.max(floor));
                (weight * own(i).to_f64()).sqrt()
            };
            let scales: Vec<f64> = (0..self.elastic).map(size).collect();
            // The norm of a semidefinite matrix is at most the sum of its diagonal.
            let follow = left
                .iter()
                .zip(&scales)
                .map(|(left, scale)| left / scale / scale);
            let e_s = stiffness.distance(&scales, nonzero) + follow.sum::<f64>() * UPWARD;
            let spread = (e_s + e_g) / (1.0 - e_g.min(0.5)) * UPWARD;
            if spread.is_nan() || spread >= 0.5 || e_g >= 0.5 {
                continue;
            }
            for (reach, size) in reach.iter_mut().zip(&sizes) {
                // With the rounding of the quotients s/g.
                let found = (spread * size.max(floor) + 2f64.powi(-100) * size) * UPWARD;
                *reach = reach.min(found);
            }
        }
        let relative = reach.iter().zip(&sizes).map(|(reach, size)| reach / size);
        let spread = relative.fold(0.0, f64::max);
        Some(Forms {
            stiffness,
            mass,
            squares,
            nonzero,
            reach,
            spread,
        })
    }
}

/// The least of the sizes, and larger ones that stand above gaps among the lowest.
fn floors(sizes: &[f64]) -> Vec<f64> {
    const GAP: f64 = 1e3;
    const MOST: usize = 4;
    let mut rising = sizes.to_vec();
    sort_by_number(&mut rising, |one| *one);
    let least = rising.first().copied().unwrap_or(1.0);
    let above = rising.windows(2).filter(|pair| pair[1] > GAP * pair[0]);
    std::iter::once(least)
        .chain(above.map(|pair| pair[1]))
        .take(MOST)
        .collect()
}
