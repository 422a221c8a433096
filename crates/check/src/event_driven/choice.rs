//! Which phases follow: those that agree with the laws of all switches, found by trying all.

use eigentone_digits::sort_by_number;
use eigentone_switching::Switch;

use super::law::{Law, Moment, NOTHING, Phase, Place};

impl Law<'_> {
    /// The phases that follow these phases and forces.
    ///
    /// Of all combinations whose laws agree a moment later, one in which no friction slides that could hold beside the others that
    /// do. Where several such move otherwise, the friction that is first at its limit, as forces run on towards those by which all of
    /// them hold, gives way; where such forces are not unique, one that has not held does.
    pub(super) fn phases(
        &self,
        place: Place<'_>,
        (old, before): (&[Phase], &[f64]),
    ) -> Result<(Vec<Phase>, Moment), String> {
        const MOST: usize = 20_000;
        let each = (0..self.len()).map(|k| self.candidates(k, place));
        let mut all: Vec<Vec<Phase>> = each.collect();
        let held: Vec<Phase> = all.iter().map(|own| own[0]).collect();
        if self.moment(&held, place).is_none() {
            let holding = all.iter_mut().filter(|own| own[0] == Phase::Stick);
            holding.for_each(|own| own.extend([Phase::Full(1), Phase::Full(-1)]));
        }
        let count = all
            .iter()
            .fold(1usize, |count, own| count.saturating_mul(own.len()));
        if count > MOST {
            return Err(format!(
                "too many switches are at their limits at once: {count} combinations"
            ));
        }
        let combination = |number: usize| {
            let mut rest = number;
            let pick = |own: &Vec<Phase>| {
                let phase = own[rest % own.len()];
                rest /= own.len();
                phase
            };
            all.iter().map(pick).collect::<Vec<Phase>>()
        };
        let slides = |phases: &Vec<Phase>| phases.iter().filter(|phase| is_slip(**phase)).count();
        let mut each: Vec<Vec<Phase>> = (0..count).map(combination).collect();
        each.sort_by_key(slides);
        let mut found: Vec<(Vec<Phase>, Moment)> = Vec::new();
        for own in each {
            let has_more = |(other, _): &(Vec<Phase>, Moment)| {
                let mut pairs = own.iter().zip(other);
                slides(other) < slides(&own)
                    && pairs.all(|(own, other)| is_slip(*own) || !is_slip(*other))
            };
            if !found.iter().any(has_more)
                && self.agree(&own, place)
                && let Some(moment) = self.moment(&own, place)
            {
                found.push((own, moment));
            }
        }
        while let Some((phases, moment)) = found.first() {
            let moves_alike = |(_, other): &(_, Moment)| moment.is_like(other);
            if found.iter().all(moves_alike) {
                // How they share what they hold is free: the farther below their limits the better.
                let strain = |(phases, moment): &(Vec<Phase>, Moment)| self.strain(phases, moment);
                sort_by_number(&mut found, strain);
                return Ok(found.swap_remove(0));
            }
            let differs = |k: &usize| {
                let differs =
                    |(other, _): &(Vec<Phase>, _)| is_slip(other[*k]) != is_slip(phases[*k]);
                found.iter().any(differs)
            };
            let open: Vec<usize> = (0..self.len()).filter(differs).collect();
            let mut first = found
                .iter()
                .map(|(own, _)| self.first(own, &open, (old, before), place));
            let gives = first.next().flatten();
            let gives = gives.filter(|gives| first.all(|other| other == Some(*gives)));
            let count = found.len();
            match gives {
                Some(gives) => found.retain(|(phases, _)| is_slip(phases[gives])),
                None => {
                    // What has held goes on, where forces do not show it.
                    let held = |(phases, _): &(Vec<Phase>, _)| {
                        let pairs = phases.iter().zip(old);
                        pairs
                            .filter(|(now, old)| !is_slip(**now) && !is_slip(**old))
                            .count()
                    };
                    let most = found.iter().map(held).max();
                    found.retain(|one| Some(held(one)) == most);
                }
            }
            if found.len() == count {
                return Err("which of several frictions gives way is not determined".to_owned());
            }
        }
        Err("no combination of states agrees with the laws of all switches".to_owned())
    }

    /// How near to their limits frictions are that hold.
    fn strain(&self, phases: &[Phase], moment: &Moment) -> f64 {
        let each = self.placed.iter().zip(phases).zip(&moment.forces);
        let shares = each.map(|((placed, phase), force)| match (placed.switch, phase) {
            (Switch::Friction(friction), Phase::Stick | Phase::Full(_)) => {
                force / friction.static_force.max(f64::MIN_POSITIVE)
            }
            _ => 0.0,
        });
        shares.map(|share| share * share).sum()
    }

    /// Which of some frictions is first at its limit, as forces run on from what they were to what holds all of them; `None` of
    /// several. Those that share what they hold do so as they did before.
    fn first(
        &self,
        phases: &[Phase],
        open: &[usize],
        (old, before): (&[Phase], &[f64]),
        place: Place<'_>,
    ) -> Option<usize> {
        /// What is nearer to each other is equal.
        const TOGETHER: f64 = 1e-6;
        let full = |k: usize| matches!(old.get(k), Some(Phase::Full(_)));
        let held = phases.iter().enumerate().map(|(k, phase)| {
            let before = old
                .get(k)
                .filter(|old| matches!(old, Phase::Stick | Phase::Full(_)));
            match before {
                Some(old) if open.contains(&k) || !is_slip(*phase) => *old,
                _ if open.contains(&k) => Phase::Stick,
                _ => *phase,
            }
        });
        let held: Vec<Phase> = held.collect();
        let state = self.later(&held, place)?;
        let after = self.moment(&held, self.soon_after(place, &state))?.forces;
        let share = |k: &usize| {
            let Switch::Friction(friction) = self.placed[*k].switch else {
                return None;
            };
            let way = after[*k] - before[*k];
            let left = friction.static_force - way.signum() * before[*k];
            Some((left.max(0.0) / way.abs().max(f64::MIN_POSITIVE), *k))
        };
        let open = open.iter().filter(|k| !full(**k));
        let mut shares = open.map(share).collect::<Option<Vec<_>>>()?;
        sort_by_number(&mut shares, |share| share.0);
        match shares[..] {
            [(share, _), (next, _), ..] if next - share <= TOGETHER => None,
            [(share, k), ..] if share <= 1.0 => Some(k),
            _ => None,
        }
    }

    /// The state of a moment later, by Heun's method: what sets out from rest may do so with the jerk alone.
    fn later(&self, phases: &[Phase], place: Place<'_>) -> Option<Vec<f64>> {
        let n = self.equation.len();
        let soon = self.soon();
        let moved = |accelerations: &[f64]| {
            let mut state = place.state.to_vec();
            for i in 0..n {
                state[i] += soon * (state[n + i] + 0.5 * soon * accelerations[i]);
                state[n + i] += soon * accelerations[i];
            }
            state
        };
        let mut accelerations = self.moment(phases, place)?.accelerations;
        let first = moved(&accelerations);
        let then = self.moment(phases, self.soon_after(place, &first))?;
        let pairs = accelerations.iter_mut().zip(&then.accelerations);
        pairs.for_each(|(now, then)| *now = f64::midpoint(*now, *then));
        let mut state = moved(&accelerations);
        self.project(phases, place.piece, place.elapsed + soon, &mut state);
        Some(state)
    }

    fn soon_after<'b>(&self, place: Place<'_>, state: &'b [f64]) -> Place<'b> {
        Place {
            piece: place.piece,
            elapsed: place.elapsed + self.soon(),
            state,
        }
    }

    fn agree(&self, phases: &[Phase], place: Place<'_>) -> bool {
        let Some(state) = self.later(phases, place) else {
            return false;
        };
        let later = self.soon_after(place, &state);
        let Some(moment) = self.moment(phases, later) else {
            return false;
        };
        let mut each = phases.iter().enumerate();
        each.all(|(k, phase)| {
            // A body that stays still has the low damping.
            let least = match phase {
                Phase::High => 2.0 * NOTHING * NOTHING,
                _ => 0.0,
            };
            self.guard(k, *phase, later, &moment) >= least && self.stays_open(k, *phase, later)
        })
    }
}

fn is_slip(phase: Phase) -> bool {
    matches!(phase, Phase::Slip(_))
}
