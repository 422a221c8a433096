//! How much of the other approximate shapes each true shape holds.
//!
//! With y_i = x_i/√g_i the shape of a simple eigenvalue σ near d_k is Σ c_i y_i with c_k = 1 and, for i ≠ k,
//!
//! (d_i − σ) c_i = Σ_j (σ E_G,ij − F_ij) c_j, F_ij = y_iᵀKy_j − d_i δ_ij.
//!
//! With a_ij ≥ |σ||E_G,ij| + |F_ij|, B_ij = a_ij/|d_i − σ| for j ≠ k and δ_i = a_ik/|d_i − σ| this is
//! c = Tc + t with |T| ≤ B and |t| ≤ δ. If δ + Bb < b for some b > 0, the spectral radius of B is below 1, so
//! that there is one solution, |c_i| ≤ b_i, and no shape has c_k = 0 (Collatz 1942, *Math. Z.* 48).

use eigentone_digits::{DoubleDouble, product};
use faer::Mat;

use super::forms::Forms;
use crate::inclusion::gram::{Gram, UPWARD};

/// More than products that underflow take from a sum, for squares within `RANGE`.
const TINY: f64 = 1e-120;

const RANGE: std::ops::Range<f64> = 1e-150..1e150;

/// For each elastic column, how far each of its entries may be from a multiple of the true shape; `None` where
/// that is not proved. Without meaning for values that their bounds do not separate.
pub(super) fn errors(forms: &Forms, columns: &[Vec<DoubleDouble>]) -> Vec<Option<Vec<f64>>> {
    let (all, elastic) = (columns.len(), forms.squares.len());
    let n = columns.first().map_or(0, Vec::len);
    let size = |square: &DoubleDouble| square.to_f64().abs();
    let squares: Vec<f64> = forms.squares.iter().map(size).collect();
    let in_range = |square: &f64| RANGE.contains(square);
    if !squares[..forms.nonzero].iter().all(in_range) {
        return vec![None; elastic];
    }
    let norms: Vec<f64> = (0..all)
        .map(|i| forms.mass.at(i, i).to_f64().sqrt())
        .collect();
    let couplings = |gram: &Gram, zeros: usize| {
        Mat::from_fn(all, all, |i, j| {
            // Springs do not feel rigid motions.
            if i.max(j) >= gram.size {
                return 0.0;
            }
            let off = if i == j && i < zeros {
                gram.error(i, j)
            } else {
                gram.upper(i, j)
            };
            off / (norms[i] * norms[j]) * UPWARD
        })
    };
    let (stiffness, mass) = (
        couplings(&forms.stiffness, forms.nonzero),
        couplings(&forms.mass, all),
    );
    let reach = |k: usize| forms.reach.get(k).copied().unwrap_or(0.0);
    // The least |d_i − σ|; NaN or not positive where there is none.
    let gap = |i: usize, k: usize| {
        let doubt = reach(k);
        let apart = match forms.squares.get(i) {
            None => squares[k],
            Some(square) => {
                let apart = (*square - forms.squares[k]).to_f64().abs();
                apart - 2f64.powi(-98) * squares[i]
            }
        };
        (apart - doubt * UPWARD) / UPWARD
    };
    let gaps = Mat::from_fn(all, elastic, gap);
    let largest = |k: usize| (squares[k] + reach(k)) * UPWARD;
    let coupled = |i: usize, k: usize, by_mass: f64, by_stiffness: f64| {
        (largest(k) * by_mass + by_stiffness) / gaps[(i, k)] * UPWARD + TINY
    };
    let first = Mat::from_fn(all, elastic, |i, k| {
        if i == k {
            0.0
        } else {
            coupled(i, k, mass[(i, k)], stiffness[(i, k)])
        }
    });
    let next = |shares: &Mat<f64>| {
        let coupled_by = |matrix: &Mat<f64>| product(matrix.as_ref(), shares.as_ref());
        let (by_mass, by_stiffness) = (coupled_by(&mass), coupled_by(&stiffness));
        Mat::from_fn(all, elastic, |i, k| {
            if i == k {
                0.0
            } else {
                (first[(i, k)] + coupled(i, k, by_mass[(i, k)], by_stiffness[(i, k)])) * UPWARD
            }
        })
    };
    let is_inside = |shares: &Mat<f64>, mapped: &Mat<f64>, k: usize| {
        (0..all).all(|i| i == k || (gaps[(i, k)] > 0.0 && mapped[(i, k)] < shares[(i, k)]))
    };
    let mut shares = &first * faer::Scale(2.0);
    let mut mapped = next(&shares);
    // What couples columns only by way of others shows in the next step.
    if !(0..elastic).all(|k| is_inside(&shares, &mapped, k)) {
        shares = mapped * faer::Scale(2.0);
        mapped = next(&shares);
    }
    let sizes = Mat::from_fn(n, all, |p, i| columns[i][p].to_f64().abs() / norms[i]);
    let errors = product(sizes.as_ref(), shares.as_ref());
    let of = |k: usize| {
        let each = errors.col(k).iter();
        let each: Vec<f64> = each.map(|e| (e * norms[k] + TINY) * UPWARD).collect();
        let finite = each.iter().all(|error| error.is_finite());
        (finite && is_inside(&shares, &mapped, k)).then_some(each)
    };
    (0..elastic).map(of).collect()
}
