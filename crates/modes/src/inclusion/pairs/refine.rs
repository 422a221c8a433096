//! Refinement of roots and shapes to double-double.
//!
//! As for undamped shapes ([`congruence`](crate::inclusion::congruence)), x_i ← x_i + Σ_j x_j (a_ji − ρ_i b_ji)/(b_jj(ρ_i − ρ_j)),
//! y_i ← y_i + Σ_j y_j (a_ij − ρ_i b_ij)/(b_jj(ρ_i − ρ_j)) and λ_i ← ρ_i (Ogita & Aishima 2018, *Jpn. J. Ind. Appl. Math.* 35).
//! Columns too close for that are first separated, those of a [cluster](super::span) given anew if need be, and those that
//! are mixed however far apart resolved by a [Rayleigh–Ritz step](super::ritz).

use eigentone_digits::{ComplexDoubleDouble, DoubleDouble};
use faer::prelude::Reborrow;
use faer::{ColMut, Mat, c64};

use super::pair::{Column, Origin, Pair, Pairs, Parts, norm, plain};
use super::ritz::End;
use super::rows::Rows;
use crate::inclusion::groups::join;

/// Discs that are no larger, relative to their roots, are good enough.
const GOOD: f64 = 1e-10;

impl Pairs<'_> {
    /// Refines roots and shapes until their discs are small, or as far as double-double reaches.
    pub(super) fn refine(&mut self) -> Option<Rows> {
        const STEPS: usize = 12;
        const GOAL: f64 = 1e-20;
        /// The largest discs, relative to their roots, that are of use.
        const LARGEST: f64 = 1e-3;
        self.project()?;
        let mut rows = self.rows(None)?;
        for _ in 0..STEPS {
            if rows.spread() <= GOAL {
                break;
            }
            let Some((next, slow)) = self.advanced(&rows) else {
                break;
            };
            rows = next;
            if slow {
                break;
            }
        }
        (rows.spread_of_distinguished() <= LARGEST).then_some(rows)
    }

    /// The rows after a step, and whether another would gain little; `None`, with all as before, where no step
    /// gains anything.
    pub(super) fn advanced(&mut self, rows: &Rows) -> Option<(Rows, bool)> {
        let before = self.pairs.clone();
        let mut separated = vec![false; before.len()];
        for group in &rows.mixed(true) {
            let done = self.separate(rows, group).is_some() || self.separate_anew(rows, group);
            group.iter().for_each(|i| separated[*i] = done);
        }
        let spread = rows.spread();
        if rows.mixing() > 0 {
            let mut next = self.resolved(rows, &separated);
            // Clusters may be mixed with others.
            if next.is_none() && spread > GOOD && separated.contains(&true) {
                let apart = std::mem::replace(&mut self.pairs, before.clone());
                next = self.resolved(rows, &vec![false; before.len()]);
                if next.is_none() {
                    self.pairs = apart;
                }
            }
            if let Some(next) = next {
                return Some((next, false));
            }
        }
        let mut separated = separated.contains(&true);
        if !separated {
            self.correct(rows);
        }
        let mut next = self.project().and_then(|()| self.rows(Some(rows)));
        // What is separated may still hold shares of all others.
        let gains_little = |next: &mut Rows| separated && next.spread() > 0.5 * spread;
        if let Some(rows) = next.take_if(gains_little) {
            separated = false;
            self.correct(&rows);
            next = self.project().and_then(|()| self.rows(None));
        }
        let measures: [fn(&Rows) -> f64; 2] = [Rows::spread, Rows::spread_of_distinguished];
        let last = measures.map(|measure| measure(rows));
        let gains = |next: &Rows, part: f64| {
            let mut each = measures.iter().zip(last);
            each.any(|(measure, last)| measure(next) < part * last)
        };
        // Shapes that are right but for shares of each other may first gain larger ones.
        let is_worse = |next: &mut Rows| !separated && !gains(next, 1.0) && next.mixing() == 0;
        if last[1] > GOOD
            && let Some(rows) = next.take_if(is_worse)
        {
            self.correct(&rows);
            next = self.project().and_then(|()| self.rows(None));
        }
        let better = next.filter(|next| separated || gains(next, 1.0));
        if better.is_none() {
            self.pairs = before;
        }
        better.map(|next| {
            let slow = !separated && !gains(&next, 0.5);
            (next, slow)
        })
    }

    /// The rows once mixed columns are resolved from the end that gains most; `None`, with all as before, where none does.
    fn resolved(&mut self, rows: &Rows, separated: &[bool]) -> Option<Rows> {
        let before = self.pairs.clone();
        let mut best: Option<Rows> = None;
        let mut pairs = before.clone();
        for end in [End::Large, End::Small] {
            self.pairs.clone_from(&before);
            let Some(next) = self.resolved_from(end, rows, separated) else {
                continue;
            };
            if best
                .as_ref()
                .is_none_or(|best| next.spread() < best.spread())
            {
                best = Some(next);
                std::mem::swap(&mut pairs, &mut self.pairs);
            }
        }
        self.pairs = pairs;
        best
    }

    fn resolved_from(&mut self, end: End, rows: &Rows, separated: &[bool]) -> Option<Rows> {
        /// What is resolved may first be seen to be mixed with more.
        const TIMES: usize = 3;
        let (spread, mixing) = (rows.spread(), rows.mixing());
        let mut separated = separated.to_vec();
        let mut last: Option<Rows> = None;
        for _ in 0..TIMES {
            if !self.resolve(last.as_ref().unwrap_or(rows), &separated, end) {
                return None;
            }
            let next = self.project().and_then(|()| self.rows(None))?;
            if next.mixing() < mixing || next.spread() < 0.5 * spread {
                return Some(next);
            }
            if spread <= GOOD || separated.contains(&true) {
                break;
            }
            separated = vec![false; self.pairs.len()];
            last = Some(next);
        }
        None
    }

    /// Separates the columns of a cluster after giving it others; whether it did.
    fn separate_anew(&mut self, rows: &Rows, group: &[usize]) -> bool {
        let before = self.pairs.clone();
        let rows = self.span(rows, group).and_then(|()| {
            self.project()?;
            self.rows(None)
        });
        let done = rows.is_some_and(|rows| self.separate(&rows, group).is_some());
        if !done {
            self.pairs = before;
        }
        done
    }

    /// A step towards the roots and shapes, of the first order in what is off the diagonal; columns
    /// too close for that keep what mixes them.
    fn correct(&mut self, rows: &Rows) {
        let along = |i: usize, at: usize| rows.rows[i].h[at];
        let left = self
            .has_left()
            .then(|| self.change(rows, Pair::left, true, along));
        let right = if left.is_some() {
            self.change(rows, Pair::right, false, |i, at| rows.across(i, at))
        } else {
            self.change(rows, Pair::right, false, along)
        };
        for (i, pair) in self.pairs.iter_mut().enumerate() {
            if pair.is_given() {
                continue;
            }
            if !matches!(pair.origin, Origin::Hidden(_)) {
                pair.value = rows.rho[i];
            }
            if pair.is_real() {
                pair.value.im = DoubleDouble::ZERO;
            }
            let left = pair.left.as_mut().zip(left.as_ref());
            for (parts, change) in [(&mut pair.right, &right)].into_iter().chain(left) {
                for (row, entry) in parts.re.iter_mut().enumerate() {
                    *entry = *entry + change[(row, i)].re;
                }
                for (row, entry) in parts.im.iter_mut().enumerate() {
                    *entry = *entry + change[(row, i)].im;
                }
            }
        }
    }

    /// What is to be added to the shapes on one side, given the entries that couple pair i to each column.
    fn change(
        &self,
        rows: &Rows,
        side: fn(&Pair) -> &Parts,
        on_left: bool,
        coupling: impl Fn(usize, usize) -> c64,
    ) -> Mat<c64> {
        let n = self.system.len();
        let (all, count) = (rows.columns.len(), self.pairs.len());
        let mut change = Mat::<c64>::zeros(all, count);
        let weights = rows.weights();
        for i in (0..count).filter(|i| !self.pairs[*i].is_given()) {
            let own = rows.place(i, false);
            for (at, other) in rows.columns.iter().enumerate() {
                if at == own || rows.is_counted(other.pair) && !self.has_left() {
                    continue;
                }
                let share = match rows.twin(at).filter(|twin| *twin != own) {
                    None => {
                        let gap = plain(rows.rho[i] - rows.rho_of(*other));
                        coupling(i, at) / (rows.own_of(*other) * gap)
                    }
                    // The shares of nearly the same shape may cancel but for little.
                    Some(twin) => {
                        let entry = |j: usize, l: usize| rows.shifted(j, l, rows.rho[i]);
                        let (first, second) = (coupling(i, at), coupling(i, twin));
                        let [across, back] = if on_left {
                            [entry(twin, at), entry(at, twin)]
                        } else {
                            [entry(at, twin), entry(twin, at)]
                        };
                        let (a, b) = (entry(at, at), entry(twin, twin));
                        (second * across - first * b) / (a * b - across * back)
                    }
                };
                if !rows.mixes(i, *other, share, 1.0) {
                    change[(at, i)] = share;
                }
            }
            self.take_smaller_half(rows, i, &weights, change.col_mut(i));
        }
        let shapes = Mat::<c64>::from_fn(n, all, |row, at| {
            let Column { pair, conjugate } = rows.columns[at];
            let entry = side(&self.pairs[pair]).at(row);
            if conjugate { entry.conj() } else { entry }
        });
        shapes * change
    }

    /// The shares c_j of columns (x_j, λ_jx_j) that correct (x_i, λ_ix_i), for x_i alone: the upper half says c_j, the lower
    /// c_jλ_j/ρ_i and λ_i/ρ_i − 1 of x_i itself. The smaller one counts: what cancels of columns with nearly the same
    /// shape leaves the errors of these shapes.
    fn take_smaller_half(
        &self,
        rows: &Rows,
        i: usize,
        weights: &[[f64; 2]],
        mut shares: ColMut<'_, c64>,
    ) {
        /// By so much the lower half is to be smaller: shares of faster columns are larger there.
        const CANCELS: f64 = 1e-3;
        let rho = plain(rows.rho[i]);
        let ratio = |at: usize| {
            let Column { pair, conjugate } = rows.columns[at];
            let value = plain(rows.values[pair]);
            (if conjugate { value.conj() } else { value }) / rho
        };
        let (mut upper, mut lower) = (0.0, 0.0);
        for (share, [weight, value]) in shares.rb().iter().zip(weights) {
            let size = norm(*share) * weight;
            upper += size;
            lower += size * value;
        }
        if lower < CANCELS * upper * norm(rho) {
            (0..shares.nrows()).for_each(|at| shares[at] *= ratio(at));
            let own = rows.place(i, false);
            shares[own] = ratio(own) - 1.0;
        }
    }
}

impl Rows {
    /// By how much a share of each column counts, and |λ| of it.
    fn weights(&self) -> Vec<[f64; 2]> {
        let of = |column: &Column| {
            let value = self.values[column.pair].norm();
            [norm(self.own_of(*column)).sqrt().recip(), value]
        };
        self.columns.iter().map(of).collect()
    }

    /// a_ji − ρ_i b_ji for the column j.
    fn across(&self, i: usize, at: usize) -> c64 {
        self.shifted(at, self.place(i, false), self.rho[i])
    }

    /// Whether so large a share of another column, `coupling` over `whole`, is more than a correction.
    fn mixes(&self, i: usize, other: Column, coupling: c64, whole: f64) -> bool {
        const SMALL: f64 = 1e-2;
        let ratio = self.tau[i] / self.tau[other.pair];
        let is_small = whole > 0.0 && norm(coupling) * ratio <= SMALL * whole;
        !is_small
    }

    /// How many columns are mixed with others, conjugates counted.
    fn mixing(&self) -> usize {
        let columns = |i: &usize| 1 + self.place(*i, true) - self.place(*i, false);
        self.mixed(false).iter().flatten().map(columns).sum()
    }

    /// Whether the gap between two roots may hide that they are mixed.
    pub(super) fn are_near(&self, i: usize, j: usize) -> bool {
        const NEAR: f64 = 0.1;
        // A mixed column may have the quotient of what it is mixed with.
        let near =
            |roots: &[ComplexDoubleDouble]| (roots[i] - roots[j]).norm() <= NEAR * roots[i].norm();
        near(&self.rho) && near(&self.values)
    }

    /// Whether columns are mixed with conjugates of each other.
    pub(super) fn meet_conjugates(&self, group: &[usize]) -> bool {
        group.iter().any(|i| {
            let mut others = self.columns.iter().enumerate();
            others.any(|(at, other)| {
                other.conjugate && group.contains(&other.pair) && self.is_mixed(*i, at)
            })
        })
    }

    /// Whether the pair i is mixed with a column.
    fn is_mixed(&self, i: usize, at: usize) -> bool {
        let other = self.columns[at];
        let whole = norm(self.own_of(other) * plain(self.rho[i] - self.rho_of(other)));
        // Of its shapes on the left and on the right.
        self.mixes(i, other, self.rows[i].h[at], whole)
            || !self.is_symmetric && self.mixes(i, other, self.across(i, at), whole)
    }

    /// Groups of pairs with columns so far from what they should be that corrections do not separate them: those of roots near
    /// each other, or all, conjugates included.
    pub(super) fn mixed(&self, near: bool) -> Vec<Vec<usize>> {
        let count = self.rows.len();
        let mut label: Vec<usize> = (0..count).collect();
        let mut is_clear = vec![true; count];
        for (i, is_clear) in is_clear.iter_mut().enumerate() {
            for (at, other) in self.columns.iter().enumerate() {
                let j = other.pair;
                let own = j == i && !other.conjugate;
                let counted = self.is_counted(i) || self.is_counted(j);
                let far = near && (other.conjugate || !self.are_near(i, j));
                if own || counted || far || !self.is_mixed(i, at) {
                    continue;
                }
                *is_clear = false;
                join(&mut label, i, j);
            }
        }
        let members = |first: usize| (0..count).filter(|i| label[*i] == first).collect();
        let groups = (0..count).map(members);
        groups
            .filter(|group: &Vec<usize>| group.iter().any(|i| !is_clear[*i]))
            .collect()
    }
}
