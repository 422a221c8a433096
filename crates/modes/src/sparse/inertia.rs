//! How many eigenvalues of (K, M) lie below a number, proven.
//!
//! A factor L D Lᵀ that was computed is exact for a matrix that differs from K − τM by E with
//! |E| ≤ γ|L||D||Lᵀ| in every entry (Higham 2002, *Accuracy and Stability of Numerical Algorithms*, theorem
//! 10.3 and §11.1), so that ±E ≤ diag(w), w_i the sum of row i of that bound. Where K − τM − diag(p) with
//! p ≥ w is factorised, its negative pivots are therefore at least as many as the eigenvalues below τ, by
//! Sylvester's law of inertia; with +diag(p) at most as many. Both together prove the number itself (as
//! Rump 2006, *BIT* 46, proves definiteness).

use eigentone_digits::DoubleDouble;

use super::entry::Entry;
use super::factor::{Factor, Sum};
use super::pencil::Pencil;

/// From which side the number of eigenvalues is bounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// Not more than counted.
    AtMost,
    /// Not fewer than counted.
    AtLeast,
}

/// K − τM for many τ.
#[derive(Debug)]
pub(crate) struct Inertia<'a> {
    pub(crate) pencil: &'a Pencil,
    /// Nodes of parts that have neither mass nor a spring to others: their last pivot is 0 for every τ.
    idle: Vec<bool>,
    idle_parts: usize,
    sizes: [Vec<f64>; 2],
}

impl<'a> Inertia<'a> {
    pub(crate) fn new(pencil: &'a Pencil, idle: &[Vec<usize>]) -> Inertia<'a> {
        let mut nodes = vec![false; pencil.len()];
        idle.iter().flatten().for_each(|&node| nodes[node] = true);
        Inertia {
            pencil,
            idle: nodes,
            idle_parts: idle.len(),
            sizes: [pencil.stiffness.sizes(), pencil.mass.sizes()],
        }
    }

    /// A bound of the number of eigenvalues below τ, from one factor in numbers T, and `None` where that
    /// rounds too much.
    pub(crate) fn below<T: Entry>(&self, at: f64, side: Side) -> Option<usize> {
        self.moved::<T>(at, side, 0.0)
    }

    /// The same in doubles, or else in double-double.
    pub(crate) fn below_either(&self, at: f64, side: Side) -> Option<usize> {
        self.below::<f64>(at, side)
            .or_else(|| self.below::<DoubleDouble>(at, side))
    }

    /// A diagonal d > 0 with K − τM ⪰ diag(d), in proportion to what is added up in each row; `None` where none
    /// is found.
    pub(crate) fn floor(&self, at: f64) -> Option<Vec<f64>> {
        /// Doubles round more than that.
        const DOUBLES: f64 = 1e-11;
        let definite = |part: f64| {
            let count = match part > DOUBLES {
                true => self.moved::<f64>(at, Side::AtMost, part),
                false => self.moved::<DoubleDouble>(at, Side::AtMost, part),
            };
            count == Some(0)
        };
        let part = (1..9)
            .map(|power| 1e-3f64.powi(power))
            .find(|&part| definite(part))?;
        let [stiffness, mass] = &self.sizes;
        let rows = stiffness.iter().zip(mass);
        Some(
            rows.map(|(k, m)| 0.99 * part * (k + at.abs() * m))
                .collect(),
        )
    }

    /// A bound of the number of negative eigenvalues of K − τM with a part of each row's size added to the
    /// diagonal, towards that side.
    fn moved<T: Entry>(&self, at: f64, side: Side, part: f64) -> Option<usize> {
        let [stiffness, mass] = &self.sizes;
        // Terms of an entry, and those of its sum from ground and joins; a fourfold of it for the
        // star–mesh form, whose diagonals are sums over rows.
        let unit = 4.0 * (self.pencil.terms + 16) as f64 * T::UNIT;
        let own = |i: usize| stiffness[i] + at.abs() * mass[i];
        let sign = match side {
            Side::AtMost => -1.0,
            Side::AtLeast => 1.0,
        };
        let mut added: Vec<f64> = (0..self.idle.len())
            .map(|i| match self.idle[i] {
                true => 0.0,
                false => sign * (part + 4.0 * unit) * own(i),
            })
            .collect();
        for _ in 0..2 {
            let factor = Factor::<T>::sum(self.pencil, Sum::shifted(at), &added);
            if !factor.is_finite() || factor.zeros != self.idle_parts {
                return None;
            }
            let growth = factor.growth();
            let mut enough = true;
            for (i, added) in added.iter_mut().enumerate() {
                if self.idle[i] {
                    continue;
                }
                let least = unit * (growth[i] + own(i) + added.abs());
                let given = part * own(i);
                if added.abs() - given < least || least.is_nan() {
                    enough = false;
                    *added = sign * (given + 2.0 * least);
                }
            }
            if enough {
                return Some(factor.negative);
            }
        }
        None
    }

    /// Of what was added to the diagonal, the part that x feels in proportion to xᵀMx, in doubles.
    pub(crate) fn noise(&self, at: f64, shape: &[f64]) -> f64 {
        let unit = 16.0 * (self.pencil.terms + 16) as f64 * f64::UNIT;
        let [stiffness, mass] = &self.sizes;
        let terms = shape.iter().zip(stiffness).zip(mass);
        unit * terms
            .map(|((x, k), m)| (k + at.abs() * m) * x * x)
            .sum::<f64>()
    }
}
