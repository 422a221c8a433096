//! Discs that hold all roots.

use eigentone_digits::ComplexDoubleDouble;

use super::pair::{Origin, Pairs};
use super::rows::Rows;
use crate::inclusion::gram::UPWARD;
use crate::inclusion::groups::join;
use crate::structure::Structure;

/// Some pairs whose discs touch each other, with the radius of each.
pub(super) struct Disc {
    pub(super) members: Vec<usize>,
    pub(super) centres: Vec<ComplexDoubleDouble>,
    pub(super) radii: Vec<f64>,
}

impl Disc {
    /// Whether the imaginary axis cannot be distinguished from it.
    pub(super) fn is_on_axis(&self) -> bool {
        let mut each = self.centres.iter().zip(&self.radii);
        each.any(|(centre, radius)| centre.re.to_f64().abs() <= *radius)
    }
}

impl Pairs<'_> {
    /// Whether the roots in all discs on the imaginary axis are those of modes that move no damper, which are
    /// counted exactly.
    pub(super) fn are_undamped<'a>(
        &self,
        structure: &Structure,
        discs: impl Iterator<Item = &'a Disc>,
    ) -> bool {
        let is_real = |disc: &Disc| self.pairs[disc.members[0]].is_real();
        let hidden = discs.filter(|disc| !is_real(disc) && disc.is_on_axis());
        let hidden: usize = hidden.map(|disc| disc.members.len()).sum();
        hidden > 0 && structure.undamped_modes() == Some(hidden)
    }
}

impl Rows {
    /// What the discs of counted roots hold beside those at 0; `None` where that is nothing.
    fn beside_zero(&self, sums: &[(f64, f64, f64)]) -> Option<Disc> {
        let beside = |i: usize| match self.origins[i] {
            Origin::Beside(_, value) => Some((i, value)),
            _ => None,
        };
        let (members, values): (Vec<_>, Vec<_>) = (0..sums.len()).filter_map(beside).unzip();
        let counted = (0..sums.len()).filter(|i| self.is_counted(*i));
        let reach = counted.map(|i| {
            let (own, others, mixed) = sums[i];
            self.rho[i].norm() + (own + others) / (1.0 - mixed)
        });
        let reach = reach.fold(0.0, f64::max);
        let centre = |value: &f64| ComplexDoubleDouble::new(*value, 0.0);
        let radius = |value: &f64| (reach + value.abs()) * UPWARD;
        let found = !members.is_empty();
        found.then(|| Disc {
            members,
            centres: values.iter().map(centre).collect(),
            radii: values.iter().map(radius).collect(),
        })
    }

    /// Discs that hold as many roots as they have members, none of which touches another or its
    /// conjugate; `None` where that is not so.
    pub(super) fn discs(&self) -> Option<Vec<Disc>> {
        let count = self.rows.len();
        let sums: Vec<(f64, f64, f64)> = (0..count).map(|i| self.sums(i)).collect();
        if !sums
            .iter()
            .all(|(own, others, mixed)| *mixed <= 0.25 && (own + others).is_finite())
        {
            return None;
        }
        let reach = |i: usize| sums[i].0 + sums[i].1;
        // As many roots at 0 as are counted are in discs together, and 0 in no other.
        let null = (0..count).find(|i| self.is_counted(*i));
        let apart_from_null =
            |i: usize| self.is_counted(i) || self.rho[i].norm() > 2.0 * reach(i) * UPWARD;
        if null.is_some() && !(0..count).all(apart_from_null) {
            return None;
        }
        let mut label: Vec<usize> = (0..count).collect();
        if let Some(null) = null {
            let counted = (0..count).filter(|i| self.is_counted(*i));
            counted.for_each(|i| label[i] = null);
        }
        // How many times larger each column can be made.
        let mut times = vec![1e15f64; count];
        for (i, row) in self.rows.iter().enumerate() {
            for (at, other) in self.columns.iter().enumerate() {
                let j = other.pair;
                if j == i && !other.conjugate {
                    continue;
                }
                let gap = (self.rho[i] - self.rho_of(*other)).norm() / UPWARD;
                // With E ≤ ½ each radius is at most twice its sum.
                let rest = gap - 2.0 * (reach(i) + reach(j)) * UPWARD;
                if rest.is_nan() || rest <= 0.0 {
                    if other.conjugate || self.is_counted(i) != self.is_counted(j) {
                        return None;
                    }
                    join(&mut label, i, j);
                    continue;
                }
                let ratio = self.tau[j] / self.tau[i] * UPWARD;
                let most =
                    (rest / (2.0 * row.reach[at] * ratio)).min(0.25 / (row.mixed[at] * ratio));
                if !most.is_nan() {
                    times[j] = times[j].min(most / UPWARD);
                }
            }
        }
        let mut discs = Vec::new();
        for first in 0..count {
            let members: Vec<usize> = (0..count).filter(|i| label[*i] == first).collect();
            if members.is_empty()
                || null == Some(first)
                || self.rho[first].norm() == 0.0 && members.len() == 1
            {
                continue;
            }
            let alone = members.len() == 1;
            let radius = |i: &usize| {
                let (own, others, mixed) = sums[*i];
                let times = if alone { times[*i].max(1.0) } else { 1.0 };
                (own + others / times) / (1.0 - mixed) * UPWARD
            };
            discs.push(Disc {
                centres: members.iter().map(|i| self.rho[*i]).collect(),
                radii: members.iter().map(radius).collect(),
                members,
            });
        }
        discs.extend(self.beside_zero(&sums));
        Some(discs)
    }
}
