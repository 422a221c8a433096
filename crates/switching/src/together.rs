//! Where bounces of several rigid stops die out together.
//!
//! What one of them does to the speeds of the others follows no law of its own, so that there is no series to sum. But each
//! impact takes of the relative speeds, and contacts that all press bring them back: once every speed is next to nothing, so is the
//! time that is left.

use eigentone_digits::{Cholesky, Real};
use faer::Mat;

use crate::march::{Doubt, Halt, March};
use crate::phase::Phase;
use crate::rows::{Row, dot};
use crate::switch::Switch;

/// The last bounces of some rigid stops.
pub(crate) struct Last {
    /// Of each, its index and the largest speed left.
    speeds: Vec<(usize, f64)>,
    /// How long they take at most, in s.
    pub(crate) longest: f64,
    /// The largest of those speeds beside the largest at any impact of its stop.
    pub(crate) share: f64,
    /// The least acceleration that presses.
    pub(crate) presses: f64,
}

impl<T: Real> March<'_, '_, T> {
    /// The other rigid stops that bounce where bounces of one die out: in `delay` s, or if that is not known, those that
    /// took part in its last ones.
    pub(crate) fn beside(&self, switch: usize, delay: Option<f64>) -> Vec<usize> {
        /// Beside what is left the bounces before it were long.
        const BEFORE: f64 = 1e3;
        let first = self.turns[switch].first();
        let recent = first.map_or(0.0, |first| (self.now - *first).to_f64());
        let long = delay.map_or(recent, |delay| BEFORE * delay);
        let is_near = |other: &usize| {
            let last = self.turns[*other].last();
            *other != switch && last.is_some_and(|last| (self.now - *last).to_f64() <= long)
        };
        (0..self.places.len()).filter(is_near).collect()
    }

    /// What is left of the bounces of one rigid stop and those beside it; `None` where they do not all press, or where something
    /// changes meanwhile.
    pub(crate) fn last_bounces(&mut self, switch: usize, beside: &[usize]) -> Option<Last> {
        /// Bounces excite each other: how much longer than each by itself they may take.
        const LONGER: f64 = 100.0;
        let mut phases = self.phases.clone();
        let group = || [&[switch], beside].concat().into_iter();
        group().for_each(|k| phases[k] = Phase::Contact);
        let configuration = self.configuration(&phases).ok()?;
        let moved = configuration.apply(&self.zeta);
        let mut last = Last {
            speeds: Vec::new(),
            longest: 0.0,
            share: 0.0,
            presses: f64::INFINITY,
        };
        // How fast forces change beside themselves.
        let mut fastest = configuration.reach / configuration.step;
        for k in group() {
            let place = &self.places[k];
            let Switch::Impact(impact) = &place.switch else {
                return None;
            };
            let force = configuration.forces[k].as_ref()?;
            let against = -force.at(&self.zeta).to_f64();
            if against <= 2.0 * self.unknown(force) {
                return None;
            }
            let slope = force.at(&moved).to_f64().abs() / configuration.step;
            fastest = fastest.max(slope / against);
            let presses = against * self.reply(k);
            let rate = place.rate.at(&self.zeta).to_f64();
            let open = -self.beyond(k, impact.gap).at(&self.zeta).to_f64();
            let next = (rate * rate + 2.0 * presses * open.max(0.0)).sqrt();
            // What is about to hit comes back more slowly.
            let left = if rate > 0.0 {
                impact.restitution * next
            } else {
                next
            };
            last.longest += LONGER * left / presses / (1.0 - impact.restitution);
            last.share = last.share.max(left / self.largest[k]);
            last.presses = last.presses.min(presses);
            last.speeds.push((k, left));
        }
        (last.longest * fastest < 1e-3).then_some(last)
    }

    /// Brings all of them to rest where they touch; gives their indices, or `None` where they hold the same.
    pub(crate) fn rest_together(&mut self, last: &Last) -> Option<Vec<usize>> {
        /// A solution in doubles gives as many digits.
        const ROUNDS: usize = 6;
        let group: Vec<usize> = last.speeds.iter().map(|(switch, _)| *switch).collect();
        let n = self.zeta.len();
        let moves: Vec<Vec<T>> = group.iter().map(|k| self.moves(*k)).collect();
        // What a unit impulse along each stretch does to the rates of all.
        let answers = Mat::from_fn(group.len(), group.len(), |i, j| {
            dot(
                &self.places[group[i]].rate.entries,
                &self.places[group[j]].push,
            )
            .to_f64()
        });
        let factor = Cholesky::of(answers.as_ref())?;
        for _ in 0..ROUNDS {
            for is_rate in [false, true] {
                let mut found = Mat::from_fn(group.len(), 1, |i, _| {
                    let place = &self.places[group[i]];
                    let value = match (&place.switch, is_rate) {
                        (Switch::Impact(impact), false) => {
                            self.beyond(group[i], impact.gap).at(&self.zeta)
                        }
                        _ => place.rate.at(&self.zeta),
                    };
                    value.to_f64()
                });
                factor.divide_by_lower(found.as_mut());
                factor.divide_by_upper(found.as_mut());
                for (at, k) in group.iter().enumerate() {
                    let along = if is_rate {
                        &self.places[*k].push
                    } else {
                        &moves[at]
                    };
                    T::add_multiple(&mut self.zeta, T::from(-found[(at, 0)]), along);
                }
            }
        }
        let mut blurred = vec![0.0; n];
        for ((k, left), moves) in last.speeds.iter().zip(&moves) {
            let impulse = 4.0 * left / self.reply(*k);
            for ((blurred, push), moves) in blurred.iter_mut().zip(&self.places[*k].push).zip(moves)
            {
                *blurred += impulse * (push.to_f64().abs() + last.longest * moves.to_f64().abs());
            }
        }
        self.blur(&blurred);
        Some(group)
    }

    /// Lets what is nearer to its stop than digits tell, and comes nearer, touch it at once: what goes to and fro between others that
    /// close up does so ever more often, until in no time all are at rest to each other.
    pub(crate) fn close_gaps(&mut self) -> Result<(), Halt> {
        /// Beside what is not known of a distance.
        const HIDDEN: f64 = 1e6;
        const ROUNDS: usize = 3;
        for switch in 0..self.places.len() {
            let place = &self.places[switch];
            let Switch::Impact(impact) = &place.switch else {
                continue;
            };
            let beyond = self.beyond(switch, impact.gap);
            let open = -beyond.at(&self.zeta).to_f64();
            let rate = place.rate.at(&self.zeta).to_f64();
            let comes = rate > self.unknown(&place.rate) && self.phases[switch] == Phase::Free;
            if !comes || open <= 0.0 || open > HIDDEN * self.unknown(&beyond) {
                continue;
            }
            if self.doubt == Doubt::Refused {
                return Err(self.undecided(switch));
            }
            let (moves, reply) = (self.moves(switch), self.reply(switch));
            for _ in 0..ROUNDS {
                let far = beyond.at(&self.zeta) / T::from(-reply);
                T::add_multiple(&mut self.zeta, far, &moves);
            }
            let share = 2.0 * open / reply;
            let blurred: Vec<f64> = moves
                .iter()
                .map(|entry| entry.to_f64().abs() * share)
                .collect();
            self.blur(&blurred);
        }
        Ok(())
    }

    /// What a unit impulse along a stretch does to the rate of ζ.
    fn moves(&self, switch: usize) -> Vec<T> {
        let push = &self.places[switch].push;
        let rows = self.w.chunks(push.len());
        rows.map(|row| dot(row, push)).collect()
    }

    /// What is not known of a function of the state.
    fn unknown(&self, row: &Row<T>) -> f64 {
        let own = row.own_error(self.size());
        match self.doubt {
            Doubt::Ignored => own,
            _ => self.vague(row) + own,
        }
    }

    /// The rate that a unit impulse makes.
    fn reply(&self, switch: usize) -> f64 {
        let place = &self.places[switch];
        dot(&place.rate.entries, &place.push).to_f64()
    }
}
