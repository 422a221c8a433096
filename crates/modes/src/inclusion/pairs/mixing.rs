//! How much of the other columns each true shape holds.
//!
//! A root λ that is alone in the disc about ρ_k belongs to z = Σ c_j z_j with WᵀAZ c = λ WᵀBZ c. Row j of that, divided by
//! (ρ_j − λ) b_jj, is
//!
//! c_j = −Σ_l (h_jl/(ρ_j − λ) + e_jl) c_l,
//!
//! and |ρ_j − λ| is no less than the gap |ρ_j − ρ_k| less the radius of the disc. So |c| ≤ T|c| + t for the rows
//! j ≠ k, with c_k = 1, T_jl = |h_jl|/gap_j + |e_jl| for l ≠ k and t_j the same for l = k. If t + Ts < s for some s > 0, the
//! spectral radius of T is below 1, so that there is one solution, |c| ≤ s, and no shape has c_k = 0 (Collatz 1942, *Math.
//! Z.* 48). The upper halves of the columns are the shapes: x = x_k + Σ c_j x_j. Left shapes are those of the
//! transposed pencil.

use std::ops::Range;

use eigentone_digits::product;
use faer::Mat;

use super::discs::Disc;
use super::pair::{Pair, norm};
use super::rows::Rows;
use crate::inclusion::gram::UPWARD;

/// More than products that underflow take from a sum, for roots and scales within `RANGE` and gaps above `LEAST_GAP`.
const TINY: f64 = 1e-120;

const RANGE: Range<f64> = 1e-75..1e75;

const LEAST_GAP: f64 = 1e-150;

/// Whether bounds of x or of y are sought.
#[derive(Clone, Copy)]
pub(super) enum Side {
    Right,
    Left,
}

impl Rows {
    /// For each disc of one root, how far each component of its pair may be from a multiple of the true shape; `None`
    /// where that is not proved.
    pub(super) fn shape_errors(
        &self,
        pairs: &[Pair],
        discs: &[Disc],
        side: Side,
    ) -> Vec<Option<Vec<f64>>> {
        let sizes = self.rho.iter().map(|rho| rho.norm());
        let mut sizes = sizes.filter(|size| *size > 0.0).chain(self.tau.clone());
        if !sizes.all(|size| RANGE.contains(&size)) {
            return vec![None; discs.len()];
        }
        let all = self.columns.len();
        let alone: Vec<&Disc> = discs
            .iter()
            .filter(|disc| disc.members.len() == 1)
            .collect();
        if alone.is_empty() {
            return vec![None; discs.len()];
        }
        let owners: Vec<usize> = alone
            .iter()
            .map(|disc| self.place(disc.members[0], false))
            .collect();
        let [reach, mixed] = self.couplings(side);
        let gaps = Mat::from_fn(all, alone.len(), |j, at| {
            let disc = alone[at];
            let apart = self.rho_of(self.columns[j]) - self.rho[disc.members[0]];
            (apart.norm() / UPWARD - disc.radii[0] * UPWARD) / UPWARD
        });
        let row = |j: usize, at: usize, by_reach: f64, by_mixed: f64| {
            (by_reach / gaps[(j, at)] + by_mixed) * UPWARD + TINY
        };
        let over_rows = |entry: &dyn Fn(usize, usize) -> f64| {
            Mat::from_fn(all, alone.len(), |j, at| {
                if j == owners[at] { 0.0 } else { entry(j, at) }
            })
        };
        let first = over_rows(&|j, at| row(j, at, reach[(j, owners[at])], mixed[(j, owners[at])]));
        let next = |shares: &Mat<f64>| {
            let coupled_by = |matrix: &Mat<f64>| product(matrix.as_ref(), shares.as_ref());
            let (by_reach, by_mixed) = (coupled_by(&reach), coupled_by(&mixed));
            over_rows(&|j, at| {
                (first[(j, at)] + row(j, at, by_reach[(j, at)], by_mixed[(j, at)])) * UPWARD
            })
        };
        let is_inside = |shares: &Mat<f64>, mapped: &Mat<f64>, at: usize| {
            (0..all).all(|j| {
                j == owners[at] || (gaps[(j, at)] > LEAST_GAP && mapped[(j, at)] < shares[(j, at)])
            })
        };
        let mut shares = &first * faer::Scale(2.0);
        let mut mapped = next(&shares);
        // What couples columns only by way of others shows in the next step.
        if !(0..alone.len()).all(|at| is_inside(&shares, &mapped, at)) {
            shares = mapped * faer::Scale(2.0);
            mapped = next(&shares);
        }
        let parts = match side {
            Side::Right => Pair::right,
            Side::Left => Pair::left,
        };
        let components = Mat::from_fn(pairs[0].right.re.len(), all, |row, j| {
            let column = self.columns[j].pair;
            norm(parts(&pairs[column]).at(row)) * self.tau[column] * UPWARD
        });
        let errors = product(components.as_ref(), shares.as_ref());
        let error = |at: usize| {
            if !is_inside(&shares, &mapped, at) {
                return None;
            }
            // In proportion to the pair's own column.
            let own = alone[at].members[0];
            let share = |j: usize| {
                self.drift[self.columns[j].pair] * self.tau[self.columns[j].pair] * shares[(j, at)]
            };
            let drift = self.drift[own] + (0..all).map(share).sum::<f64>() / self.tau[own] * UPWARD;
            let each = errors.col(at).iter();
            let each: Vec<f64> = each
                .map(|error| ((error + TINY) / self.tau[own] + drift) * UPWARD)
                .collect();
            each.iter().all(|error| error.is_finite()).then_some(each)
        };
        let mut proven = (0..alone.len()).map(error);
        let each = discs.iter().map(|disc| match disc.members.len() {
            1 => proven.next().flatten(),
            _ => None,
        });
        each.collect()
    }

    /// Bounds of |h_jl| and |e_jl| for all columns, each scaled by its τ.
    fn couplings(&self, side: Side) -> [Mat<f64>; 2] {
        let all = self.columns.len();
        // The rows of conjugates are conjugate.
        let entry = |j: usize, l: usize| {
            let (row, other) = (self.columns[j], self.columns[l]);
            let at = self.place(other.pair, row.conjugate != other.conjugate);
            let row = &self.rows[row.pair];
            (row.reach[at], row.mixed[at])
        };
        // Of ZᵀAZ transposed: a_lj − ρ_jb_lj is a_lj − ρ_lb_lj and (ρ_l − ρ_j)b_lj.
        let turned = |j: usize, l: usize| {
            let (reach, mixed) = entry(l, j);
            let own = |at: usize| self.own_of(self.columns[at]).norm();
            let apart = self.rho_of(self.columns[l]) - self.rho_of(self.columns[j]);
            let ratio = own(l) / own(j) * UPWARD;
            ((reach + apart.norm() * mixed) * ratio, mixed * ratio)
        };
        let scaled = |of: &dyn Fn(usize, usize) -> f64| {
            Mat::from_fn(all, all, |j, l| {
                let (row, other) = (self.columns[j].pair, self.columns[l].pair);
                of(j, l) * (self.tau[other] / self.tau[row]) * UPWARD
            })
        };
        match side {
            Side::Right => [scaled(&|j, l| entry(j, l).0), scaled(&|j, l| entry(j, l).1)],
            Side::Left => [
                scaled(&|j, l| turned(j, l).0),
                scaled(&|j, l| turned(j, l).1),
            ],
        }
    }
}
