//! K − σM = L D Lᵀ by columns, left-looking, without pivoting.
//!
//! Where no join of K − σM is negative, elimination is a sequence of star–mesh steps: with the joins
//! w_ij of node j to later nodes and its join e_j to the ground,
//! d_j = e_j + Σ w_ij, w_ik ← w_ik + w_ij w_jk/d_j, e_i ← e_i + e_j w_ij/d_j. For σ ≤ 0 and a passive
//! network nothing is ever subtracted, so every entry of L and D is good to a small multiple of n
//! units of rounding, however far the springs lie apart (Alfa, Xue & Ye 2002, *Math. Comp.* 71,
//! "Accurate computation of the smallest eigenvalue of a diagonally dominant M-matrix"; Demmel &
//! Koev 2004, *Numer. Math.* 98). The last pivot of a part that nothing holds is then exactly 0.
//!
//! By Sylvester's law of inertia there are as many eigenvalues of (K, M) below σ as negative pivots
//! (Parlett 1998, *The Symmetric Eigenvalue Problem*, §3.3).

use super::pencil::Pencil;

/// No column.
const NONE: u32 = u32::MAX;

/// L, D, and how they came about.
#[derive(Clone, Debug)]
pub(crate) struct Factor<'a> {
    pub(crate) pencil: &'a Pencil,
    pub(crate) values: Vec<f64>,
    /// 1/d_j, and 0 where d_j is exactly 0.
    pub(crate) inverses: Vec<f64>,
    /// Negative pivots.
    pub(crate) negative: usize,
    /// The smallest |d_j| in proportion to the terms that it is the sum of.
    pub(crate) least: f64,
    /// Pivots that are exactly 0.
    pub(crate) zeros: usize,
}

impl<'a> Factor<'a> {
    /// Of K − σM.
    pub(crate) fn of(pencil: &'a Pencil, shift: f64) -> Factor<'a> {
        let n = pencil.len();
        let ordering = &pencil.ordering;
        let weight = |at: usize| match pencil.masses.get(at) {
            Some(mass) => pencil.stiffnesses[at] - shift * mass,
            None => pencil.stiffnesses[at],
        };
        let star_mesh = (0..pencil.rows.len()).all(|at| weight(at) >= 0.0);
        let node = |place: usize| ordering.nodes[place] as usize;
        // Joins to the ground, or else the diagonal.
        let mut rest: Vec<f64> = (0..n)
            .map(|j| pencil.stiffness.ground(node(j)) - shift * pencil.mass.ground(node(j)))
            .collect();
        if !star_mesh {
            for j in 0..n {
                for at in pencil.starts[j]..pencil.starts[j + 1] {
                    rest[j] += weight(at);
                    rest[pencil.rows[at] as usize] += weight(at);
                }
            }
        }
        let starts = &ordering.starts;
        let mut factor = Factor {
            pencil,
            values: vec![0.0; ordering.rows.len()],
            inverses: vec![0.0; n],
            negative: 0,
            least: f64::INFINITY,
            zeros: 0,
        };
        let mut work = vec![0.0; n];
        // The columns whose next row is j, as linked lists, and where in the column that row is.
        let (mut heads, mut links) = (vec![NONE; n], vec![NONE; n]);
        let mut next = vec![0usize; n];
        let mut pivots = vec![0.0; n];
        for j in 0..n {
            for at in pencil.starts[j]..pencil.starts[j + 1] {
                work[pencil.rows[at] as usize] = -weight(at);
            }
            let mut terms = rest[j].abs();
            let mut column = heads[j];
            while column != NONE {
                let k = column as usize;
                column = links[k];
                let (at, end) = (next[k], starts[k + 1]);
                let multiplier = factor.values[at];
                let scaled = multiplier * pivots[k];
                let rows = &ordering.rows[at + 1..end];
                for (&i, value) in rows.iter().zip(&factor.values[at + 1..end]) {
                    work[i as usize] -= scaled * value;
                }
                let update = if star_mesh {
                    multiplier * rest[k]
                } else {
                    multiplier * scaled
                };
                rest[j] -= update;
                terms += update.abs();
                next[k] = at + 1;
                if at + 1 < end {
                    let row = ordering.rows[at + 1] as usize;
                    links[k] = heads[row];
                    heads[row] = k as u32;
                }
            }
            let range = starts[j]..starts[j + 1];
            let mut pivot = rest[j];
            if star_mesh {
                for &i in &ordering.rows[range.clone()] {
                    pivot -= work[i as usize];
                    terms += work[i as usize].abs();
                }
            }
            pivots[j] = pivot;
            let inverse = if pivot == 0.0 { 0.0 } else { 1.0 / pivot };
            factor.inverses[j] = inverse;
            factor.negative += usize::from(pivot < 0.0);
            factor.zeros += usize::from(pivot == 0.0);
            if pivot != 0.0 {
                factor.least = factor.least.min(pivot.abs() / terms);
            }
            for at in range.clone() {
                let i = ordering.rows[at] as usize;
                factor.values[at] = work[i] * inverse;
                work[i] = 0.0;
            }
            next[j] = range.start;
            if range.start < range.end {
                let row = ordering.rows[range.start] as usize;
                links[j] = heads[row];
                heads[row] = j as u32;
            }
        }
        factor
    }

    /// Whether every entry of L and D is finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.inverses.iter().all(|inverse| inverse.is_finite())
            && self.values.iter().all(|value| value.is_finite())
    }

    /// Solves (K − σM) x = b for x, which takes the place of b. `work` is of the same length. Where
    /// a pivot is 0 the last node of its part stays where it is.
    pub(crate) fn solve(&self, b: &mut [f64], work: &mut [f64]) {
        let ordering = &self.pencil.ordering;
        let (starts, rows) = (&ordering.starts, &ordering.rows);
        for (value, &node) in work.iter_mut().zip(&ordering.nodes) {
            *value = b[node as usize];
        }
        for j in 0..work.len() {
            let (range, value) = (starts[j]..starts[j + 1], work[j]);
            for (&i, entry) in rows[range.clone()].iter().zip(&self.values[range]) {
                work[i as usize] -= entry * value;
            }
        }
        for j in (0..work.len()).rev() {
            let range = starts[j]..starts[j + 1];
            let mut value = work[j] * self.inverses[j];
            for (&i, entry) in rows[range.clone()].iter().zip(&self.values[range]) {
                value -= entry * work[i as usize];
            }
            work[j] = value;
        }
        for (value, &node) in work.iter().zip(&ordering.nodes) {
            b[node as usize] = *value;
        }
    }
}
