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

use num_complex::Complex;

use super::entry::Entry;
use super::pencil::Pencil;

/// What of C and M is added to K before it is factorised: K + c·C + m·M.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sum<T> {
    pub(crate) damping: T,
    pub(crate) mass: T,
}

impl<T: Entry> Sum<T> {
    /// K − σM.
    pub(crate) fn shifted(shift: f64) -> Sum<T> {
        Sum {
            damping: T::from(0.0),
            mass: T::from(-shift),
        }
    }
}

impl Sum<Complex<f64>> {
    /// λ²M + λC + K.
    pub(crate) fn at(value: Complex<f64>) -> Sum<Complex<f64>> {
        Sum {
            damping: value,
            mass: value * value,
        }
    }
}

/// No column.
const NONE: u32 = u32::MAX;

/// L, D, and how they came about.
#[derive(Clone, Debug)]
pub(crate) struct Factor<'a, T = f64> {
    pub(crate) pencil: &'a Pencil,
    pub(crate) values: Vec<T>,
    /// 1/d_j, and 0 where d_j is exactly 0.
    pub(crate) inverses: Vec<T>,
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
        Factor::sum(pencil, Sum::shifted(shift), &[])
    }
}

impl<'a, T: Entry> Factor<'a, T> {
    /// Of K + c·C + m·M, with numbers added to the diagonal by nodes, if there are some.
    pub(crate) fn sum(pencil: &'a Pencil, sum: Sum<T>, added: &[f64]) -> Factor<'a, T> {
        let zero = T::from(0.0);
        let n = pencil.len();
        let ordering = &pencil.ordering;
        let [has_mass, has_damping] = [sum.mass, sum.damping].map(|part| part != zero);
        let weight = |at: usize| {
            let mut weight = T::rounded(pencil.stiffnesses[at]);
            if has_mass && let Some(mass) = pencil.masses.get(at) {
                weight += T::rounded(*mass) * sum.mass;
            }
            if has_damping && let Some(damping) = pencil.dampings.get(at) {
                weight += T::rounded(*damping) * sum.damping;
            }
            weight
        };
        let star_mesh = (0..pencil.rows.len()).all(|at| weight(at).is_non_negative());
        // Joins to the ground, or else the diagonal.
        let mut rest: Vec<T> = (0..n)
            .map(|j| {
                let node = ordering.nodes[j] as usize;
                let mut rest = T::rounded(pencil.stiffness.ground_long(node));
                if has_mass {
                    rest += T::rounded(pencil.mass.ground_long(node)) * sum.mass;
                }
                if has_damping {
                    rest += T::rounded(pencil.damping.ground_long(node)) * sum.damping;
                }
                match added.get(node) {
                    Some(added) => rest + T::from(*added),
                    None => rest,
                }
            })
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
            values: vec![zero; ordering.rows.len()],
            inverses: vec![zero; n],
            negative: 0,
            least: f64::INFINITY,
            zeros: 0,
        };
        let mut work = vec![zero; n];
        // The columns whose next row is j, as linked lists, and where in the column that row is.
        let (mut heads, mut links) = (vec![NONE; n], vec![NONE; n]);
        let mut next = vec![0usize; n];
        let mut pivots = vec![zero; n];
        for j in 0..n {
            for at in pencil.starts[j]..pencil.starts[j + 1] {
                work[pencil.rows[at] as usize] = zero - weight(at);
            }
            let mut terms = rest[j].size();
            let mut column = heads[j];
            while column != NONE {
                let k = column as usize;
                column = links[k];
                let (at, end) = (next[k], starts[k + 1]);
                let multiplier = factor.values[at];
                let scaled = multiplier * pivots[k];
                let rows = &ordering.rows[at + 1..end];
                for (&i, value) in rows.iter().zip(&factor.values[at + 1..end]) {
                    work[i as usize] -= scaled * *value;
                }
                let update = if star_mesh {
                    multiplier * rest[k]
                } else {
                    multiplier * scaled
                };
                rest[j] -= update;
                terms += update.size();
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
                    terms += work[i as usize].size();
                }
            }
            pivots[j] = pivot;
            let inverse = if pivot == zero {
                zero
            } else {
                T::from(1.0) / pivot
            };
            factor.inverses[j] = inverse;
            factor.negative += usize::from(pivot.is_negative());
            factor.zeros += usize::from(pivot == zero);
            if pivot != zero {
                factor.least = factor.least.min(pivot.size() / terms);
            }
            for at in range.clone() {
                let i = ordering.rows[at] as usize;
                factor.values[at] = work[i] * inverse;
                work[i] = zero;
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

    /// By nodes, the sums of the rows of |L||D||Lᵀ|, to which the factor's rounding errors are in
    /// proportion.
    pub(crate) fn growth(&self) -> Vec<f64> {
        let ordering = &self.pencil.ordering;
        let n = self.inverses.len();
        let mut sums = vec![0.0; n];
        for k in 0..n {
            let range = ordering.starts[k]..ordering.starts[k + 1];
            let entries = self.values[range.clone()].iter().map(|entry| entry.size());
            let pivot = match self.inverses[k].size() {
                0.0 => 0.0,
                inverse => 1.0 / inverse,
            };
            let whole = pivot * (1.0 + entries.clone().sum::<f64>());
            sums[k] += whole;
            for (&row, entry) in ordering.rows[range].iter().zip(entries) {
                sums[row as usize] += entry * whole;
            }
        }
        let mut by_node = vec![0.0; n];
        for (&node, sum) in ordering.nodes.iter().zip(sums) {
            by_node[node as usize] = sum;
        }
        by_node
    }

    /// Whether every entry of L and D is finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.inverses
            .iter()
            .all(|inverse| inverse.size().is_finite())
            && self.values.iter().all(|value| value.size().is_finite())
    }

    /// Solves (K − σM) x = b for x, which takes the place of b. `work` is of the same length. Where
    /// a pivot is 0 the last node of its part stays where it is.
    pub(crate) fn solve(&self, b: &mut [T], work: &mut [T]) {
        let ordering = &self.pencil.ordering;
        let (starts, rows) = (&ordering.starts, &ordering.rows);
        for (value, &node) in work.iter_mut().zip(&ordering.nodes) {
            *value = b[node as usize];
        }
        for j in 0..work.len() {
            let (range, value) = (starts[j]..starts[j + 1], work[j]);
            for (&i, entry) in rows[range.clone()].iter().zip(&self.values[range]) {
                work[i as usize] -= *entry * value;
            }
        }
        for j in (0..work.len()).rev() {
            let range = starts[j]..starts[j + 1];
            let mut value = work[j] * self.inverses[j];
            for (&i, entry) in rows[range.clone()].iter().zip(&self.values[range]) {
                value -= *entry * work[i as usize];
            }
            work[j] = value;
        }
        for (value, &node) in work.iter().zip(&ordering.nodes) {
            b[node as usize] = *value;
        }
    }
}
