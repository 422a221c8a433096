//! K − σM = L D Lᵀ without pivoting, by fronts (`front.rs`).
//!
//! Where no join of K − σM is negative, or far from being positive if complex, elimination is a sequence of star–mesh steps: with the joins
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

use super::basis::short_dot;
use super::entry::Entry;
use super::front::Fronts;
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
        let star_mesh = (0..pencil.rows.len()).all(|at| weight(at).adds_up());
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
        let mut factor = Factor {
            pencil,
            values: vec![zero; ordering.rows.len()],
            inverses: vec![zero; n],
            negative: 0,
            least: f64::INFINITY,
            zeros: 0,
        };
        let mut fronts = Fronts::new(ordering, rest, star_mesh);
        for supernode in ordering.supernodes() {
            fronts.open(supernode.clone());
            for j in supernode.clone() {
                for at in pencil.starts[j]..pencil.starts[j + 1] {
                    fronts.enter(j, pencil.rows[at], zero - weight(at));
                }
            }
            fronts.eliminate(|j, pivot, column| {
                factor.inverses[j] = pivot.inverse;
                factor.negative += usize::from(pivot.value.is_negative());
                factor.zeros += usize::from(pivot.value == zero);
                if pivot.value != zero {
                    factor.least = factor.least.min(pivot.value.size() / pivot.terms);
                }
                factor.values[ordering.starts[j]..ordering.starts[j + 1]].copy_from_slice(column);
            });
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
        let zero = T::from(0.0);
        for (value, &node) in work.iter_mut().zip(&ordering.nodes) {
            *value = b[node as usize];
        }
        let mut front: Vec<T> = Vec::new();
        for columns in ordering.supernodes() {
            let rows = ordering.below(&columns);
            front.clear();
            front.extend_from_slice(&work[columns.clone()]);
            front.resize(columns.len() + rows.len(), zero);
            for (k, j) in columns.clone().enumerate() {
                let value = front[k];
                let entries = &self.values[ordering.starts[j]..ordering.starts[j + 1]];
                let later = front[k + 1..].iter_mut().zip(entries);
                later.for_each(|(x, entry)| *x -= *entry * value);
            }
            let (own, later) = front.split_at(columns.len());
            work[columns].copy_from_slice(own);
            let pairs = rows.iter().zip(later);
            pairs.for_each(|(&row, x)| work[row as usize] += *x);
        }
        for columns in ordering.supernodes().rev() {
            let rows = ordering.below(&columns);
            front.clear();
            front.extend_from_slice(&work[columns.clone()]);
            front.extend(rows.iter().map(|&row| work[row as usize]));
            for (k, j) in columns.clone().enumerate().rev() {
                let entries = &self.values[ordering.starts[j]..ordering.starts[j + 1]];
                front[k] = front[k] * self.inverses[j] - short_dot(entries, &front[k + 1..]);
            }
            work[columns.clone()].copy_from_slice(&front[..columns.len()]);
        }
        for (value, &node) in work.iter().zip(&ordering.nodes) {
            b[node as usize] = *value;
        }
    }
}
