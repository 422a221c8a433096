//! Refinement of approximate shapes to double-double.
//!
//! The bounds of [`forms`](super::forms) are of the first order in the errors of X. The iteration of Ogita & Aishima 2018,
//! *Jpn. J. Ind. Appl. Math.* 35, for a pencil squares them: X ← X(I + Ẽ) with
//! ẽ_ij = (s_ij − d_j g_ij)/((d_j − d_i) g_i). Shapes too close for that are first replaced by the Ritz vectors of their
//! span; so are those whose frequencies lie below what doubles resolve beside the largest one.

use std::cmp::Ordering;

use eigentone_digits::{DoubleDouble, sort_by_number, symmetric_eigen};
use faer::Mat;

use super::forms::{Basis, Forms};
use crate::inclusion::gram::SLICES;

/// How small the bound of relative errors is to become.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// In any case, if double-double reaches it.
    pub(crate) spread: f64,
    /// Where all values and shapes are distinguished by it.
    pub(crate) where_apart: f64,
}

impl Goal {
    /// The same whether values are apart or not.
    pub(crate) fn always(spread: f64) -> Goal {
        Goal {
            spread,
            where_apart: spread,
        }
    }
}

impl Forms {
    fn meet(&self, goal: Goal) -> bool {
        self.spread <= goal.spread || (self.spread <= goal.where_apart && self.are_apart())
    }

    /// Whether errors are larger than of forms that are found anew.
    fn have_grown(&self) -> bool {
        self.stiffness.growth.max(self.mass.growth) > 1.0
    }

    /// Whether all squares are known to some digits, but for some that are distinguished from all others by being so small.
    fn are_distinguished(&self) -> bool {
        const LARGEST: f64 = 1e-3;
        let each = self.reach.iter().zip(&self.squares);
        let each = each.map(|(reach, square)| (*reach, square.to_f64().abs()));
        let is_known = |(reach, size): &(f64, f64)| *reach <= LARGEST * size;
        let known = each.clone().filter(is_known);
        let least = known.map(|(_, size)| size).fold(f64::INFINITY, f64::min);
        let mut hidden = each.filter(|square| !is_known(square));
        least.is_finite() && hidden.all(|(reach, size)| size + reach <= LARGEST * least)
            || self.spread <= LARGEST
    }

    /// Whether squares are so far apart that neither their bounds nor the mixing of shapes, which is about
    /// the bound divided by the gap, shows in doubles.
    fn are_apart(&self) -> bool {
        const HIDDEN: f64 = 1e-17;
        let mut rising: Vec<DoubleDouble> = self.squares[..self.nonzero].to_vec();
        rising.sort_by(|a, b| a.partial_cmp(b).unwrap_or(Ordering::Equal));
        rising.windows(2).all(|pair| {
            let gap = (pair[1] - pair[0]).to_f64();
            let size = pair[0].to_f64().abs().max(pair[1].to_f64().abs());
            HIDDEN * gap > self.spread * size
        })
    }

    /// How much of shape i is in shape j, or more than that of any where both are equal; `None` where any mixture will do.
    fn share(&self, i: usize, j: usize) -> Option<f64> {
        /// Coupling and gap of shapes of which any mixture will do: it only has to be orthogonal. So it is where
        /// rounding hides both.
        const NOTHING: f64 = 1e-27;
        const EQUAL: f64 = 1e-14;
        const HIDDEN: f64 = 1e2;
        if i.min(j) >= self.nonzero {
            return None;
        }
        let (a, b) = (self.squares[i], self.squares[j]);
        let gap = (b - a).to_f64().abs();
        let size = a.to_f64().abs().max(b.to_f64().abs());
        let own = self.mass.at(i, i).to_f64() * self.mass.at(j, j).to_f64();
        let mean = (a + b) * 0.5;
        let coupling = (self.stiffness.at(i, j) - mean * self.mass.at(i, j)).to_f64();
        let coupling = coupling.abs() / own.sqrt();
        let noise = self.stiffness.error(i, j) + mean.to_f64().abs() * self.mass.error(i, j);
        let noise = noise / own.sqrt();
        let alike = coupling <= NOTHING * size && gap <= EQUAL * size
            || coupling <= noise && gap <= HIDDEN * noise;
        (!alike).then_some(coupling / gap)
    }

    /// Whether this is nearer to the true squares and shapes than what it comes from, by half or more in some respect.
    fn is_closer(&self, before: &Forms) -> bool {
        const ENOUGH: f64 = 1e-24;
        let halved = |(i, (next, last)): (usize, (&f64, &f64))| {
            *last > ENOUGH * before.squares[i].to_f64().abs() && *next < 0.5 * *last
        };
        let mut reach = self.reach.iter().zip(&before.reach).enumerate();
        reach.any(halved) || self.mixed() < 0.5 * before.mixed()
    }

    /// The largest share of one shape in another.
    fn mixed(&self) -> f64 {
        let pairs = (0..self.squares.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
        pairs
            .filter_map(|(i, j)| self.share(i, j))
            .fold(0.0, f64::max)
    }
}

/// What is to be done to a basis.
enum Step {
    /// X ← X(I + Ẽ).
    Correct(Mat<f64>),
    /// Ritz vectors in place of each of these sets of columns.
    Rotate(Vec<Vec<usize>>),
}

impl Basis<'_> {
    /// Refines the basis to the goal, or as far as double-double reaches, and returns its forms.
    pub(in crate::inclusion) fn refine(&mut self, goal: Goal) -> Option<Forms> {
        const STEPS: usize = 16;
        /// One correction makes this less than what one slice shows.
        const SMALL: f64 = 1e-10;
        /// Where two slices do. So little is asked of shapes that have lost many digits.
        const ROUGH: f64 = 1e-16;
        let is_sliced = [&self.stiffness, &self.mass].map(|form| form.is_sliced(self.elastic));
        let is_rough = goal.spread > ROUGH;
        let most = if is_rough { 2 } else { SLICES };
        self.slices = if is_rough && is_sliced.contains(&true) {
            1
        } else {
            most
        };
        let mut forms = self.forms();
        for _ in 0..STEPS {
            let Some(known) = forms.as_ref().filter(|known| !known.meet(goal)) else {
                break;
            };
            let before = self.slices;
            if known.spread <= SMALL {
                self.slices = most;
            }
            let next = self.advanced(known);
            let is_slow = next.as_ref().is_none_or(|(_, slow)| *slow);
            forms = next.map(|(next, _)| next).or(forms);
            if is_slow {
                // What is left is what errors of the forms amount to.
                self.slices = most;
                if before < most || forms.as_ref().is_some_and(Forms::have_grown) {
                    forms = self.forms();
                }
                if before == most {
                    break;
                }
            }
        }
        forms.filter(Forms::are_distinguished)
    }

    /// The forms after a step, and whether another would gain little; `None`, with the basis as before, where the
    /// step gained nothing. As squares near 0 come nearer to it, their relative errors may grow on the way.
    pub(super) fn advanced(&mut self, forms: &Forms) -> Option<(Forms, bool)> {
        let before = self.columns.clone();
        let step = self.step(forms);
        let corrected = matches!(step, Step::Correct(_));
        let next = match step {
            Step::Correct(change) => self.corrected(forms, &change),
            Step::Rotate(groups) => self.rotated(forms, &groups),
        };
        let better = next.and_then(|next| {
            let closer = next.is_closer(forms);
            let gains = !corrected || next.spread < forms.spread || closer;
            gains.then_some((next, !closer))
        });
        if better.is_none() {
            self.columns = before;
        }
        better
    }

    fn step(&self, forms: &Forms) -> Step {
        /// Beyond this share of another shape one correction does not do.
        const SMALL: f64 = 1e-2;
        let Forms {
            stiffness,
            mass,
            squares,
            ..
        } = forms;
        let (all, elastic) = (self.columns.len(), self.elastic);
        let mut change = Mat::<f64>::zeros(all, all);
        let mut group: Vec<usize> = (0..elastic).collect();
        let own = |i: usize| mass.at(i, i).to_f64();
        for j in 0..elastic {
            for i in elastic..all {
                change[(i, j)] = -mass.at(i, j).to_f64() / own(i);
            }
            for i in 0..j {
                let (s, g) = (stiffness.at(i, j), mass.at(i, j));
                match forms.share(i, j) {
                    None => {
                        change[(i, j)] = -0.5 * g.to_f64() / own(i);
                        change[(j, i)] = -0.5 * g.to_f64() / own(j);
                    }
                    Some(share) if share <= SMALL => {
                        let gap = (squares[j] - squares[i]).to_f64();
                        change[(i, j)] = (s - squares[j] * g).to_f64() / (gap * own(i));
                        change[(j, i)] = -(s - squares[i] * g).to_f64() / (gap * own(j));
                    }
                    Some(_) => {
                        let (from, to) = (group[i].max(group[j]), group[i].min(group[j]));
                        group
                            .iter_mut()
                            .filter(|label| **label == from)
                            .for_each(|label| *label = to);
                    }
                }
            }
        }
        let mut groups = vec![Vec::new(); elastic];
        for (i, label) in group.into_iter().enumerate() {
            groups[label].push(i);
        }
        groups.retain(|group| group.len() > 1);
        if groups.is_empty() {
            Step::Correct(change)
        } else {
            Step::Rotate(groups)
        }
    }

    /// The forms of Ritz vectors in place of these sets of columns.
    fn rotated(&mut self, forms: &Forms, groups: &[Vec<usize>]) -> Option<Forms> {
        for group in groups {
            self.rotate(forms, group)?;
        }
        self.inert
            .follow(&self.stiffness, &mut self.columns[..self.elastic]);
        self.forms()
    }

    /// The Ritz vectors of a set of columns, by the part of S that differs from a multiple of G.
    fn rotate(&mut self, forms: &Forms, group: &[usize]) -> Option<()> {
        let Forms {
            stiffness,
            mass,
            squares,
            ..
        } = forms;
        let centre = squares[group[group.len() / 2]];
        let norms: Vec<f64> = group
            .iter()
            .map(|i| mass.at(*i, *i).to_f64().sqrt())
            .collect();
        let rest = Mat::from_fn(group.len(), group.len(), |a, b| {
            let (i, j) = (group[a], group[b]);
            (stiffness.at(i, j) - centre * mass.at(i, j)).to_f64() / norms[a] / norms[b]
        });
        let (values, vectors) = symmetric_eigen(&rest)?;
        // Those nearest to 0 take the places of the null columns, which come last.
        let size = |b: &usize| (DoubleDouble::from(values[*b]) + centre).to_f64().abs();
        let nulls = group.iter().filter(|i| **i >= forms.nonzero).count();
        let mut order: Vec<usize> = (0..group.len()).collect();
        if nulls > 0 {
            sort_by_number(&mut order, |b| -size(b));
        }
        let rotated = order.into_iter().map(|b| {
            let mut column = vec![DoubleDouble::ZERO; self.columns[0].len()];
            for (a, i) in group.iter().enumerate() {
                let share = vectors[(a, b)] / norms[a];
                for (entry, x) in column.iter_mut().zip(&self.columns[*i]) {
                    *entry += *x * share;
                }
            }
            column
        });
        let rotated: Vec<Vec<DoubleDouble>> = rotated.collect();
        for (i, column) in group.iter().zip(rotated) {
            self.columns[*i] = column;
        }
        Some(())
    }
}
