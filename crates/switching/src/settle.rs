//! Which phases follow an event: those that all laws agree with.
//!
//! Where several contacts are at their limits the phases depend on each other: a linear complementarity problem, whose matrix
//! is that of the masses as the contacts feel them. It is solved by principal pivots at the least index (Murty, Opsearch 11,
//! 1974); signs are those of the first derivative that is not 0, so that what is at its limit is decided by where it goes.

use std::cmp::Ordering;
use std::collections::HashSet;
use std::rc::Rc;

use eigentone_digits::Real;

use crate::change::Change;
use crate::collapse::{Grips, Turned};
use crate::configuration::{Configuration, Guard, Place, clipped};
use crate::error::SwitchingError;
use crate::event::EventKind;
use crate::march::{Doubt, Halt, March};
use crate::phase::Phase;
use crate::rows::{Row, SLACK, dot, length, unit};
use crate::switch::Switch;
use crate::together::Last;

/// Why bounces that affect each other have no end that is known.
const TOGETHER: &str = "bounces of several rigid stops die out together";

/// Why what follows bounces that something interrupts is not known.
const INTERRUPTED: &str = "bounces die out just as a load or another switch changes";

/// Why it is not known which friction slides.
const AT_ONCE: &str =
    "several frictions are at their limits at once, and which of them gives way is not determined";

/// The end of bounces that are too small to be seen.
struct Closing {
    /// After how long they have died out, in s, and how well that is known.
    delay: f64,
    bound: f64,
    /// The largest speed left out.
    left: f64,
    /// With those of other rigid stops.
    together: Option<Last>,
}

/// How many derivatives decide a sign.
const ORDERS: usize = 7;

impl<T: Real> March<'_, '_, T> {
    /// The sign of a value known to `error`, beside numbers of a size; 0 where it is taken to be 0, as what `is_due` may.
    pub(crate) fn sign(
        &self,
        switch: usize,
        value: T,
        error: f64,
        size: f64,
        is_due: bool,
    ) -> Result<i8, Halt> {
        // What is due is 0 but for rounding that bounds need not know.
        const ROUNDING: f64 = 16.0;
        let rounded = value.to_f64();
        if self.doubt == Doubt::Ignored {
            let tiny = self.is_tiny(rounded, size);
            return Ok(if tiny { 0 } else { rounded.signum() as i8 });
        }
        if rounded.abs() > if is_due { ROUNDING * error } else { error } {
            return Ok(if rounded > 0.0 { 1 } else { -1 });
        }
        match value.is_zero()
            || (is_due || self.doubt == Doubt::Coincidence) && self.is_tiny(rounded, size)
        {
            true => Ok(0),
            false => Err(self.undecided(switch)),
        }
    }

    /// A function of the state, and its error.
    fn value(&self, row: &Row<T>) -> (T, f64) {
        let error = self.vague(row) + row.own_error(self.size());
        (row.at(&self.zeta), error * SLACK)
    }

    fn sign_of(&self, switch: usize, row: &Row<T>, is_due: bool) -> Result<i8, Halt> {
        let (value, error) = self.value(row);
        self.sign(switch, value, error, row.norm * self.size(), is_due)
    }

    /// Lets impulses act and finds the phases that follow, where these switches are at their limits; `earlier` is ζ before
    /// anything jumped at this instant.
    pub(crate) fn settle(&mut self, due: &[usize], earlier: Vec<T>) -> Result<Change, Halt> {
        let before = self.phases.clone();
        self.earlier = earlier;
        self.added.fill(0.0);
        self.bounced.iter_mut().for_each(|bounced| *bounced = false);
        let mut change = Change {
            map: None,
            happened: Vec::new(),
        };
        // What has stayed at its limit.
        let guards = self.current.guards.iter().zip(&self.orders);
        let stays = guards.filter(|(_, order)| **order == usize::MAX);
        let stays: Vec<usize> = stays.map(|(guard, _)| guard.switch).collect();
        let mut rests = self.apply_impacts(due, &stays, &mut change)?;
        rests.extend((0..before.len()).filter(|k| before[*k].holds()));
        // Due is also that, and what has the ends of what rests.
        let mut due = [due, &stays].concat();
        let others = 0..self.places.len();
        due.extend(others.filter(|other| {
            let shares = |rest: &usize| {
                let mut forms = 0..2;
                rest != other && forms.any(|form| self.along(*rest, *other, form).is_some())
            };
            rests.iter().any(shares)
        }));
        let mut phases = self.candidates(&due)?;
        // And what was at its limit before, and what has just been hit.
        due.extend(change.happened.iter().map(|one| one.0));
        due.extend((0..phases.len()).filter(|k| before[*k].holds()));
        self.pivot(&mut phases, &due)?;
        for (switch, (old, new)) in before.iter().zip(&phases).enumerate() {
            if self.started
                && let Some(kind) = kind(&self.places[switch], *old, *new)
            {
                let known = change
                    .happened
                    .iter()
                    .any(|one| one.0 == switch && one.1 == kind);
                if !known {
                    let delay = self.delays[switch].take().unwrap_or((0.0, 0.0));
                    change.happened.push((switch, kind, delay.0, delay.1));
                }
            }
        }
        self.delays.iter_mut().for_each(|delay| *delay = None);
        self.phases = phases;
        self.current = self.configuration(&self.phases.clone())?;
        self.project(&mut change);
        Ok(change)
    }

    /// Adds an error of the settling itself.
    pub(crate) fn blur(&mut self, errors: &[f64]) {
        self.errors.add_each(errors);
        for (added, error) in self.added.iter_mut().zip(errors) {
            *added += error;
        }
    }

    /// Reverses what hits a rigid stop, one after the other; gives those that stop moving.
    fn apply_impacts(
        &mut self,
        due: &[usize],
        stays: &[usize],
        change: &mut Change,
    ) -> Result<Vec<usize>, Halt> {
        const MOST: usize = 10_000;
        let mut rests = Vec::new();
        for round in 0.. {
            let mut hit = None;
            for switch in 0..self.places.len() {
                let Switch::Impact(impact) = &self.places[switch].switch else {
                    continue;
                };
                let held = self.phases[switch] == Phase::Contact;
                let is_due = due.contains(&switch) || stays.contains(&switch) || held;
                let beyond = self.beyond(switch, impact.gap);
                let place = match held {
                    true => 0,
                    false => self.sign_of(switch, &beyond, is_due)?,
                };
                if place > 0 {
                    // At the start, or where a support jumps.
                    return Err(match due.is_empty() {
                        true => self.beyond_gap(switch),
                        false => self.undecided(switch),
                    });
                }
                // Of what is held, only a jump of the rate counts.
                let settled = held && !self.jumped;
                let rate = self.places[switch].rate.clone();
                let approaches = match due.contains(&switch) && !held && round == 0 {
                    true => rate.at(&self.zeta) > T::ZERO,
                    false => {
                        place == 0
                            && !settled
                            && self.sign_of(switch, &rate, is_due || self.bounced[switch])? > 0
                    }
                };
                if approaches {
                    hit = Some((switch, impact.restitution, rate));
                    break;
                }
            }
            let Some((switch, restitution, rate)) = hit else {
                break;
            };
            if round == MOST {
                let time = self.now.to_f64();
                return Err(Halt::Failed(match self.is_jammed(switch) {
                    true => SwitchingError::Jammed { time, switch },
                    false => SwitchingError::Endless {
                        events: MOST,
                        time,
                        switch,
                    },
                }));
            }
            self.jumped = true;
            let speed = rate.at(&self.zeta);
            let closing = self.closing(switch, &rate, speed, restitution)?;
            let factor = match &closing {
                Some(_) => T::ONE,
                None => T::ONE + T::from(restitution),
            };
            rests.retain(|rest| *rest != switch);
            if closing.is_some() || restitution == 0.0 {
                rests.push(switch);
            }
            let push = self.places[switch].push.clone();
            let response = dot(&rate.entries, &push);
            let impulse = -(factor * speed / response);
            if let Some(taken) = &mut self.taken {
                // The impulse times the mean of the speeds before and after.
                taken.impact(
                    switch,
                    -impulse * speed * (T::ONE + T::ONE - factor).scale(-1),
                );
            }
            for (entry, push) in self.zeta.iter_mut().zip(&push) {
                *entry = *entry + impulse * *push;
            }
            let reply = response.to_f64();
            let strength =
                length(&push.iter().map(|entry| entry.to_f64()).collect::<Vec<_>>()) / reply;
            let unit = unit::<T>();
            let own = rate.own_error(self.size()) * 2.0 / reply;
            let vague = impulse.to_f64().abs()
                * (self.places[switch].push_error + 16.0 * unit + rate.error / rate.norm);
            let blurred = self.zeta.iter().zip(&push).map(|(entry, push)| {
                let sizes = [entry, push].map(|value| value.to_f64().abs());
                own * sizes[1] + vague * sizes[1] + 2.0 * unit * sizes[0]
            });
            let blurred: Vec<f64> = blurred.collect();
            self.blur(&blurred);
            let n = push.len();
            let mut map = vec![0.0; n * n];
            for i in 0..n {
                for j in 0..n {
                    let own = if i == j { 1.0 } else { 0.0 };
                    map[i * n + j] =
                        own - factor.to_f64() * push[i].to_f64() * rate.rounded[j] / reply;
                }
            }
            self.errors.map(&map);
            change.compose(&map, n);
            match closing {
                Some(Closing {
                    delay,
                    bound,
                    left,
                    together,
                }) => {
                    let until = self.now + T::from(2.0 * delay);
                    let until = match until > self.hidden.0 {
                        true => until,
                        false => self.hidden.0,
                    };
                    self.hidden = (until, 2.0 * strength * left, switch);
                    let share = 4.0 * left * bound / delay / reply;
                    let blurred: Vec<f64> = push
                        .iter()
                        .map(|push| push.to_f64().abs() * share)
                        .collect();
                    self.blur(&blurred);
                    let group = match together {
                        None => vec![switch],
                        Some(last) => self
                            .rest_together(&last)
                            .ok_or_else(|| self.undecided(switch))?,
                    };
                    for switch in group {
                        self.bounced[switch] = false;
                        self.delays[switch] = Some((delay, bound));
                        rests.retain(|rest| *rest != switch);
                        rests.push(switch);
                    }
                }
                None => {
                    self.bounced[switch] = restitution > 0.0;
                    let turns = &mut self.turns[switch];
                    if turns.len() == 3 {
                        turns.remove(0);
                    }
                    turns.push(self.now);
                    change.happened.push((switch, EventKind::Impact, 0.0, 0.0));
                    self.close_gaps()?;
                }
            }
        }
        Ok(rests)
    }

    /// Whether another rigid stop at its limit presses against this one, whatever impulses there are between them: these act the opposite
    /// way on all masses, and the two gaps close together, as supports move.
    fn is_jammed(&self, switch: usize) -> bool {
        /// Of rounding in directions.
        const ALIKE: f64 = 1e-12;
        let rounded = |push: &[T]| push.iter().map(|part| part.to_f64()).collect::<Vec<f64>>();
        let own = rounded(&self.places[switch].push);
        (0..self.places.len()).any(|other| {
            let place = &self.places[other];
            let Switch::Impact(impact) = &place.switch else {
                return false;
            };
            let push = rounded(&place.push);
            let share = length(&own) / length(&push);
            let sum = own.iter().zip(&push).map(|(a, b)| a + share * b);
            let are_opposite = length(&sum.collect::<Vec<f64>>()) <= ALIKE * length(&own);
            let gap = self.beyond(other, impact.gap).at(&self.zeta).to_f64();
            let rate = |of: usize| self.places[of].rate.at(&self.zeta).to_f64();
            are_opposite
                && self.is_tiny(gap, place.stretch.norm * self.size())
                && rate(switch) + share * rate(other) > 0.0
        })
    }

    /// Where the bounces that follow are too small to be seen: after how long they have died out, how well that is known, and
    /// the largest speed left out. A bounce that starts with v, is slowed by a and brought back by b takes v/a + v/√(ab), and
    /// the next starts with r√(b/a) v; a and b differ by the frictions of the same ends.
    ///
    /// Which digits suffice depends on where the motion is asked for. So how many bounces are followed depends on their speeds,
    /// and on digits only where no more are at hand. A speed that a change of the loads leaves free lasts: bounces that go on
    /// until then are followed farther, and have died out where they end at that instant as far as half of the digits show.
    fn closing(
        &mut self,
        switch: usize,
        rate: &Row<T>,
        speed: T,
        restitution: f64,
    ) -> Result<Option<Closing>, Halt> {
        /// Beside the largest speed: what digits need not hide, what an instant among bounces need not know, what may last.
        const SMALL: f64 = 1e-6;
        const UNSEEN: f64 = 1e-19;
        const LASTING: f64 = 1e-25;
        /// Bounces no higher than this are hidden by the error of the state.
        const HIDDEN: f64 = 1e6;
        let speed = speed.to_f64();
        let largest = self.largest[switch].max(speed);
        self.largest[switch] = largest;
        let left = restitution * speed;
        // Other loads act at once.
        let ends = self.change.is_some_and(|change| self.now >= change);
        if restitution == 0.0 || restitution >= 1.0 || left > SMALL * largest || ends {
            return Ok(None);
        }
        let alone = self.dying(switch, rate, speed, restitution);
        let beside = self.beside(switch, alone.map(|(delay, ..)| delay));
        let together = match beside.is_empty() {
            true => None,
            false => match self.last_bounces(switch, &beside) {
                None => return Ok(None),
                last => last,
            },
        };
        let ((delay, off, away), share) = match (&together, alone) {
            (Some(last), _) => {
                let half = 0.5 * last.longest;
                ((half, half, last.presses), last.share)
            }
            (None, Some(alone)) => (alone, left / largest),
            (None, None) => return Ok(None),
        };
        let rest = self
            .change
            .map(|change| (change - self.now).to_f64() - delay);
        let (least, ends_there) = match rest {
            Some(rest) if rest <= delay => (LASTING, rest.abs() <= off),
            _ => (UNSEEN, true),
        };
        let is_over = share <= least && ends_there;
        let stretch = &self.places[switch].stretch;
        let hidden = match self.doubt {
            Doubt::Ignored => stretch.own_error(self.size()),
            _ => self.vague(stretch),
        };
        let is_hidden = left * left <= 2.0 * away * HIDDEN * hidden;
        match self.doubt {
            _ if !is_over && !is_hidden => return Ok(None),
            Doubt::Refused => return Err(self.undecided(switch)),
            // What they do to each other is followed as far as digits show it, and is not known beyond.
            _ if !is_over && together.is_some() => {
                return Err(Halt::Undecided(SwitchingError::Undecided {
                    time: self.now.to_f64(),
                    switch,
                    reason: TOGETHER,
                }));
            }
            Doubt::Ignored => {}
            Doubt::Coincidence if !ends_there => return Err(self.interrupted(switch)),
            Doubt::Coincidence => self.is_cut |= !is_over,
        }
        Ok(Some(Closing {
            delay,
            bound: off,
            left,
            together,
        }))
    }

    /// After how long bounces have died out if nothing interrupts them, how well that is known, and what slows the next.
    fn dying(
        &mut self,
        switch: usize,
        rate: &Row<T>,
        speed: f64,
        restitution: f64,
    ) -> Option<(f64, f64, f64)> {
        let mut phases = self.phases.clone();
        phases[switch] = Phase::Free;
        // Where it goes towards the stop with this sign.
        let mut moves = |sign: i8| {
            for (other, phase) in phases.iter_mut().enumerate() {
                let [stretch, body] = [0, 1].map(|form| self.along(switch, other, form));
                *phase = match (*phase, stretch, body) {
                    (Phase::Stick | Phase::Slip(_) | Phase::Idle(_), Some(side), _) => match sign {
                        // At the turn it may hold.
                        0 => Phase::Idle(side),
                        sign => Phase::Slip(sign * side),
                    },
                    (Phase::OnOff { rate, .. }, _, Some(side)) if sign != 0 => Phase::OnOff {
                        body: sign * side,
                        rate,
                    },
                    (phase, ..) => phase,
                };
            }
            let configuration = self.configuration(&phases).ok()?;
            let step = configuration.step;
            let moved = configuration.apply(&self.zeta);
            let again = configuration.apply(&moved);
            let acceleration = rate.at(&moved).to_f64() / step;
            let jerk = rate.at(&again).to_f64() / (step * step);
            // How fast it changes beside itself, and twice what comes beyond the first order.
            let fastest = configuration.reach / step;
            let sizes = self.zeta.iter().zip(&configuration.scales);
            let sizes: Vec<f64> = sizes.map(|(z, scale)| z.to_f64() * scale).collect();
            let beyond = configuration.norm_of(rate) * length(&sizes) * fastest.powi(3);
            let curved = [jerk.abs() / acceleration + fastest, beyond / acceleration];
            (acceleration > 0.0).then_some((acceleration, curved))
        };
        moves(0)?;
        let (back, first) = moves(1)?;
        let (away, second) = moves(-1)?;
        let (delay, off) = match self.is_joined(switch) {
            true => self.by_ratio(switch)?,
            false => {
                let once = 1.0 / away + 1.0 / (away * back).sqrt();
                let shrinks = restitution * (back / away).sqrt();
                let delay = restitution * speed * once / (1.0 - shrinks);
                (delay, 1e-12 * delay)
            }
        };
        // Beyond the parabola, and of the speed.
        let curved = [first, second].map(|[slope, curve]| delay * (slope + delay * curve));
        let vague = match self.doubt {
            Doubt::Ignored => 0.0,
            _ => self.vague(rate) / speed,
        };
        let curved = curved[0].max(curved[1]) + vague;
        (delay > 0.0 && curved < 1e-3).then_some((delay, off + delay * curved, away))
    }

    /// What digits may still tell apart.
    pub(crate) fn interrupted(&self, switch: usize) -> Halt {
        Halt::Undecided(SwitchingError::Undecided {
            time: self.now.to_f64(),
            switch,
            reason: INTERRUPTED,
        })
    }

    /// The other switches that took part in the last bounces.
    fn partners(&self, switch: usize) -> impl Iterator<Item = usize> + '_ {
        let since = self.turns[switch].first().map(|since| since.to_f64());
        let events = self.events.iter().rev();
        let recent = events.take_while(move |event| since.is_some_and(|since| event.time >= since));
        recent
            .map(|event| event.switch)
            .filter(move |other| *other != switch)
    }

    /// Whether another switch has an end that moves as the stretch of this one.
    fn is_alike(&self, switch: usize, other: usize) -> bool {
        let mut forms = 0..2;
        forms.any(|form| self.along(switch, other, form).is_some())
    }

    /// Whether other switches take part in the last bounces, so that none is like a free one: but for those of the same ends.
    fn is_joined(&self, switch: usize) -> bool {
        let mut partners = self.partners(switch);
        partners.any(|other| !self.is_alike(switch, other))
    }

    /// Whether one of these switches interrupts bounces that are left out: none that took part in them does.
    pub(crate) fn interrupts(&self, due: &[usize]) -> bool {
        let (until, _, switch) = self.hidden;
        let takes_part = |other: usize| {
            self.is_alike(switch, other) || self.partners(switch).any(|partner| partner == other)
        };
        self.doubt != Doubt::Ignored
            && self.now < until
            && !due.iter().all(|other| takes_part(*other))
    }

    /// How long it takes until bounces have died out that shrink by one ratio, as speeds and times do where accelerations
    /// follow from signs of speeds alone; and how well that is known, as ratios draw nearer to each other.
    fn by_ratio(&self, switch: usize) -> Option<(f64, f64)> {
        /// How far two ratios in a row may differ, beside themselves.
        const ALIKE: f64 = 1e-3;
        let [first, second, third] = self.turns[switch][..] else {
            return None;
        };
        let spans = [second - first, third - second, self.now - third].map(|span| span.to_f64());
        let [before, ratio] = [spans[1] / spans[0], spans[2] / spans[1]];
        let change = (ratio - before).abs();
        let delay = spans[2] * ratio / (1.0 - ratio);
        let off = 4.0 * spans[2] * change / ((1.0 - ratio) * (1.0 - ratio)) + 1e-12 * delay;
        (ratio < 1.0 && change <= ALIKE * ratio).then_some((delay, off))
    }

    /// Whether a form of another switch (0: its stretch, 1: b) is the stretch of this one: 1, or −1 the other way round.
    fn along(&self, switch: usize, other: usize, form: usize) -> Option<i8> {
        let (a, b) = (
            &self.question.forms[switch][0],
            &self.question.forms[other][form],
        );
        let is_times = |sign: f64| {
            let pairs = |mine: &[(usize, f64)], theirs: &[(usize, f64)]| {
                let mut pairs = mine.iter().zip(theirs);
                mine.len() == theirs.len() && pairs.all(|(m, t)| *m == (t.0, sign * t.1))
            };
            pairs(&a.coordinates, &b.coordinates) && pairs(&a.supports, &b.supports)
        };
        match is_times(1.0) {
            true => Some(1),
            false => is_times(-1.0).then_some(-1),
        }
    }

    pub(crate) fn beyond(&self, switch: usize, gap: f64) -> Row<T> {
        let own = T::from(gap) / self.constant;
        self.places[switch].stretch.plus_constant(-own)
    }

    /// The phases to begin with: what lies on its limit holds.
    fn candidates(&self, due: &[usize]) -> Result<Vec<Phase>, Halt> {
        let each = (0..self.places.len()).map(|switch| {
            let place = &self.places[switch];
            let old = self.phases[switch];
            let is_due = due.contains(&switch);
            Ok(match &place.switch {
                Switch::Friction(_) => {
                    let held = matches!(old, Phase::Stick | Phase::Idle(_)) && !self.jumped;
                    let by_damper = || self.phases.iter().any(is_hold);
                    match held {
                        true if old != Phase::Stick && by_damper() => old,
                        true => Phase::Stick,
                        false => {
                            let is_due = is_due || old == Phase::Stick;
                            match self.sign_of(switch, &place.rate, is_due)? {
                                0 => Phase::Stick,
                                sign => Phase::Slip(sign),
                            }
                        }
                    }
                }
                Switch::Stop(stop) => {
                    match self.sign_of(switch, &self.beyond(switch, stop.gap), is_due)? {
                        0 => old,
                        1 => Phase::Closed,
                        _ => Phase::Open,
                    }
                }
                Switch::Impact(_) if self.bounced[switch] => Phase::Free,
                Switch::Impact(impact) => {
                    let held = old == Phase::Contact;
                    let beyond = self.beyond(switch, impact.gap);
                    let away = !held && self.sign_of(switch, &beyond, is_due || self.jumped)? < 0;
                    let is_due = is_due || held || self.delays[switch].is_some();
                    let leaves = || {
                        Ok::<_, Halt>(self.jumped && self.sign_of(switch, &place.rate, is_due)? < 0)
                    };
                    match away || leaves()? {
                        true => Phase::Free,
                        false => match self.started
                            || self.sign_of(switch, &place.rate, false)? == 0
                        {
                            true if self.sign_of(switch, &place.rate, true)? == 0 => Phase::Contact,
                            _ => Phase::Free,
                        },
                    }
                }
                Switch::ControlledDamper(damper) => match old {
                    Phase::OnOff { body, rate } => {
                        let keep = |sign: i8, old: i8| match (sign, old) {
                            (0, 0) => 1,
                            (0, old) => old,
                            (sign, _) => sign,
                        };
                        Phase::OnOff {
                            body: keep(self.sign_of(switch, &place.body, is_due)?, body),
                            rate: keep(self.sign_of(switch, &place.rate, is_due)?, rate),
                        }
                    }
                    Phase::Hold { rate } if self.jumped => Phase::OnOff {
                        body: self.sign_of(switch, &place.body, is_due)?.max(0) * 2 - 1,
                        rate,
                    },
                    Phase::Clipped { low, high, rate } => {
                        let keep = |sign: i8, old: i8| if sign == 0 { old } else { sign };
                        let [to_low, to_high] = clipped(place, damper);
                        Phase::Clipped {
                            low: keep(self.sign_of(switch, &to_low, is_due)?, low),
                            high: keep(self.sign_of(switch, &to_high, is_due)?, high),
                            rate: keep(self.sign_of(switch, &place.rate, is_due)?, rate),
                        }
                    }
                    old => old,
                },
            })
        });
        each.collect()
    }

    /// The phases that all laws agree with: where more frictions are at rest than the motion has freedoms, by limit analysis.
    ///
    /// Where static limits are above the forces of sliding there may be several: of those that two precedences lead to, the one in
    /// which more holds, as where friction is taken for a steep function of the speed that falls beyond its top, and of as many the
    /// one in which more has held before. Where neither ends, by the least index.
    fn pivot(&mut self, phases: &mut [Phase], due: &[usize]) -> Result<(), Halt> {
        let mut best: Option<Agreed> = None;
        let holding_in = |phases: &[Phase]| phases.iter().filter(|phase| is_stick(phase)).count();
        let before = self.phases.clone();
        let kept_in = |phases: &[Phase]| {
            let both = before.iter().zip(phases);
            both.filter(|(old, new)| is_stick(old) && is_stick(new))
                .count()
        };
        // Of one friction there is no order.
        let frictions = self.places.iter();
        let frictions = frictions.filter(|place| matches!(place.switch, Switch::Friction(_)));
        let is_alone = frictions.count() <= 1;
        if let Some(shared) = self.by_limit_load(phases, due)? {
            phases.copy_from_slice(&shared);
            return Ok(());
        }
        let ways = [
            (Precedence::Path, 100),
            (Precedence::Held, 100),
            (Precedence::Index, 500),
        ];
        for (precedence, most) in ways {
            if precedence == Precedence::Index && best.is_some() {
                break;
            }
            let mut found = phases.to_vec();
            if !self.pivots(&mut found, due, (precedence, false), most)? {
                continue;
            }
            let holding = holding_in(&found);
            let rank = [holding, kept_in(&found)];
            if best.as_ref().is_none_or(|best| rank > best.rank) {
                best = Some(Agreed {
                    rank,
                    phases: found,
                    orders: self.orders.clone(),
                    precedence,
                });
            }
            if is_alone || holding == holding_in(phases) {
                break;
            }
        }
        let time = self.now.to_f64();
        let refuse = |switch: Option<usize>, reason| {
            let switch = switch.or(due.first().copied()).unwrap_or(0);
            Err(Halt::Failed(SwitchingError::Undecided {
                time,
                switch,
                reason,
            }))
        };
        let Some(best) = best else {
            return refuse(
                None,
                "no combination of states agrees with the laws of all switches",
            );
        };
        let [holding, _] = best.rank;
        if !is_alone && holding != holding_in(phases) && best.precedence != Precedence::Index {
            let mut other = phases.to_vec();
            let ended = self.pivots(&mut other, due, (best.precedence, true), 100);
            let differs = |at: &usize| best.phases[*at] != other[*at];
            let first = (0..best.phases.len()).find(differs);
            if matches!(ended, Ok(true))
                && first.is_some()
                && holding_in(&other) == holding
                && !self.moves_alike(&best.phases, &other)?
            {
                return refuse(first, AT_ONCE);
            }
        }
        phases.copy_from_slice(&best.phases);
        self.orders = best.orders;
        Ok(())
    }

    /// The phases where more frictions are at rest than the motion has freedoms, and some of them give way: those that slide by
    /// limit analysis, and what follows once these have the force of sliding. `None` otherwise.
    fn by_limit_load(
        &mut self,
        phases: &[Phase],
        due: &[usize],
    ) -> Result<Option<Vec<Phase>>, Halt> {
        const MOST: usize = 100;
        let way = (Precedence::Path, false);
        let is_shared = phases.iter().filter(|phase| is_stick(phase)).count() > 1
            && !phases.iter().any(is_hold)
            && self.configuration(phases).is_err();
        if !is_shared {
            return Ok(None);
        }
        let mut held = self.shared(phases, false)?.unwrap_or(phases.to_vec());
        if self.pivots(&mut held, due, way, MOST)? && sliding_in(&held) == sliding_in(phases) {
            return Ok(Some(held));
        }
        let Some(mut shared) = self.shared(phases, true)? else {
            return Ok(None);
        };
        match self.pivots(&mut shared, due, way, MOST) {
            Ok(agrees) => Ok(agrees.then_some(shared)),
            Err(halt) if halt.is_undecided() => Err(halt),
            Err(_) => Ok(None),
        }
    }

    /// What limit analysis lets slide of the frictions at rest, where some give way, and how the others share what they hold.
    fn shared(&mut self, phases: &[Phase], gives: bool) -> Result<Option<Vec<Phase>>, Halt> {
        let grips: Vec<usize> = (0..phases.len())
            .filter(|k| is_stick(&phases[*k]))
            .collect();
        let count = grips.len();
        let free: Vec<Phase> = phases
            .iter()
            .map(|phase| {
                if is_stick(phase) {
                    Phase::Idle(0)
                } else {
                    *phase
                }
            })
            .collect();
        let free = self.configuration(&free)?;
        let limits = grips.iter().map(|k| match &self.places[*k].switch {
            Switch::Friction(friction) => [friction.force, friction.static_force],
            _ => [0.0; 2],
        });
        let limits = limits.collect();
        let mut answers = vec![0.0; count * count];
        for (j, grip) in grips.iter().enumerate() {
            let mut push = self.places[*grip].push.clone();
            for (_, gain, other) in &free.held {
                let force = dot(gain, &push);
                T::add_multiple(&mut push, T::ZERO - force, other);
            }
            for (i, other) in grips.iter().enumerate() {
                answers[i * count + j] = dot(&self.places[*other].rate.entries, &push).to_f64();
            }
        }
        let now = self.rates_of(&grips, &free, &self.zeta);
        let Some(grip) = Grips::of(answers.clone(), limits) else {
            return Ok(None);
        };
        let slides = match gives {
            true => self.giving_way(phases, &grips, (&grip, &answers), &free)?,
            false => Some(vec![0; count]),
        };
        let Some(slides) = slides else {
            return Ok(None);
        };
        let Some(shares) = grip.shares(&now, &slides) else {
            return Ok(None);
        };
        let mut shared = phases.to_vec();
        for ((switch, slides), share) in grips.into_iter().zip(slides).zip(shares) {
            shared[switch] = match (slides, share) {
                (0, None) => Phase::Stick,
                (0, Some(sign)) => Phase::Idle(-sign),
                (slides, _) => Phase::Slip(slides),
            };
        }
        Ok(Some(shared))
    }

    /// The accelerations of what frictions hold, in these units of time, as the state goes on.
    fn rates_of(&self, grips: &[usize], of: &Configuration<T>, zeta: &[T]) -> Vec<f64> {
        let change = of.apply(zeta);
        let rate = |k: &usize| self.places[*k].rate.at(&change).to_f64() / of.step;
        grips.iter().map(rate).collect()
    }

    /// Which frictions at rest give way, by the sign with which they slide, or 0: `None` where that depends on how a turn is read.
    fn giving_way(
        &mut self,
        phases: &[Phase],
        grips: &[usize],
        (grip, answers): (&Grips, &[f64]),
        free: &Configuration<T>,
    ) -> Result<Option<Vec<i8>>, Halt> {
        /// The powers of two, of one step, after which forces have grown so that it shows what gives way.
        const SOON: [i64; 6] = [-24, -20, -16, -12, -8, -4];
        let count = grips.len();
        let now = self.rates_of(grips, free, &self.zeta);
        let mut held = phases.to_vec();
        let held = self.independent(&mut held, false)?;
        // What was at rest until now is so under any reading; what slid may hold at once, or no more than while sliding, until it
        // has come to rest. What gives way is known where both let the same slide.
        let slid: Vec<bool> = grips
            .iter()
            .map(|k| self.started && !self.firmness(*k).0)
            .collect();
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|a, b| {
            let firmness = |at: &usize| self.firmness(grips[*at]);
            firmness(b)
                .partial_cmp(&firmness(a))
                .unwrap_or(Ordering::Equal)
        });
        let pushed = self.accelerations_before(grips, answers);
        let mut readings = Vec::new();
        for turned in [Turned::Rest, Turned::Sliding(&slid)] {
            // What forces were against; nothing acted before the start.
            let mut before = match turned {
                Turned::Sliding(_) if self.started => {
                    self.rates_of(grips, &self.current, &self.earlier)
                }
                _ => vec![0.0; count],
            };
            for (before, own) in before.iter_mut().zip(&pushed) {
                *before -= own;
            }
            let Some(mut slides) = grip.giving(&before, &now, turned) else {
                return Ok(None);
            };
            let mut last = now.clone();
            for power in SOON {
                if slides.iter().any(|sign| *sign != 0) {
                    break;
                }
                let soon = self.soon(&held, power);
                let soon = self.rates_of(grips, free, &soon);
                let Some(giving) = grip.giving(&now, &soon, turned) else {
                    return Ok(None);
                };
                (slides, last) = (giving, soon);
            }
            let Some(slides) = grip.returned(&last, &slides, &order) else {
                return Ok(None);
            };
            readings.push(slides);
        }
        if readings[0] != readings[1] {
            return Ok(None);
        }
        Ok(Some(readings.swap_remove(0)))
    }

    /// What frictions did until now to the accelerations of their ends, by what unit forces do; nothing acted before the start.
    fn accelerations_before(&self, grips: &[usize], answers: &[f64]) -> Vec<f64> {
        let count = grips.len();
        let mut pushed = vec![0.0; count];
        for (j, grip) in grips.iter().enumerate().filter(|_| self.started) {
            let force = self.current.forces[*grip].as_ref();
            let force = force.map_or(0.0, |force| force.at(&self.earlier).to_f64());
            for (i, pushed) in pushed.iter_mut().enumerate() {
                *pushed += answers[i * count + j] * force;
            }
        }
        pushed
    }

    /// ζ after this power of two of a step.
    fn soon(&self, configuration: &Configuration<T>, power: i64) -> Vec<T> {
        let mut soon = self.zeta.clone();
        let mut term = self.zeta.clone();
        for k in 1..ORDERS {
            term = configuration.apply(&term);
            for (soon, term) in soon.iter_mut().zip(&mut term) {
                *term = term.scale(power) / T::from(k as f64);
                *soon = *soon + *term;
            }
        }
        soon
    }

    /// Whether the state goes on in the same way, but for rounding.
    fn moves_alike(&mut self, phases: &[Phase], others: &[Phase]) -> Result<bool, Halt> {
        const ROUNDING: f64 = 1e-12;
        const ALIKE: f64 = 1e-9;
        let mut rates = Vec::new();
        for phases in [phases, others] {
            let rate = self.configuration(phases)?.apply(&self.zeta);
            rates.push(
                rate.into_iter()
                    .map(|entry| entry.to_f64())
                    .collect::<Vec<_>>(),
            );
        }
        let size = length(&rates[0]).max(length(&rates[1]));
        let mut pairs = rates[0].iter().zip(&rates[1]);
        Ok(pairs.all(|(a, b)| {
            let least = (ALIKE * a.abs().max(b.abs())).max(ROUNDING * size);
            (a - b).abs() <= least
        }))
    }

    /// Changes the first phase that disagrees with its own law, until none does; of all, frictions come last, and of those that
    /// give way together the last listed one first where that is asked for. `false` where so many changes are not enough.
    fn pivots(
        &mut self,
        phases: &mut [Phase],
        due: &[usize],
        (precedence, last_first): (Precedence, bool),
        most: usize,
    ) -> Result<bool, Halt> {
        let mut turns = vec![0; phases.len()];
        let mut seen = HashSet::new();
        // What stood aside and slides, as what held its ends moves them.
        let mut parted = Vec::new();
        // What slid against its own sign.
        let mut returned = HashSet::new();
        for _ in 0..most {
            self.exhaust_beside_dampers(phases);
            let configuration = self.independent(phases, last_first)?;
            let mut derivatives = vec![self.zeta.clone()];
            for k in 1..ORDERS {
                let mut next = configuration.apply(&derivatives[k - 1]);
                for entry in &mut next {
                    *entry = *entry / T::from(k as f64);
                }
                derivatives.push(next);
            }
            let mut factor = [1.0; ORDERS];
            for k in 1..ORDERS {
                factor[k] = factor[k - 1] * configuration.reach / k as f64;
            }
            let off = self.vague_in(&configuration);
            let size = self.size();
            self.orders = vec![usize::MAX; configuration.guards.len()];
            let mut wrong = None;
            let mut order: Vec<usize> = (0..configuration.guards.len()).collect();
            let key = |at: &usize| self.precedence(precedence, phases, &configuration.guards, *at);
            order.sort_by(|a, b| {
                let (first, second) = (key(a), key(b));
                let order = first.0.cmp(&second.0).then(first.1.total_cmp(&second.1));
                match last_first && first.0 >= 2 {
                    true => order.then(b.cmp(a)),
                    false => order,
                }
            });
            for at in order {
                let guard = &configuration.guards[at];
                let before = configuration.guards[..at].iter().rev();
                let number = before
                    .take_while(|other| other.switch == guard.switch)
                    .count();
                let is_due = due.contains(&guard.switch);
                let row = &guard.row;
                let mut sign = 0;
                if self.bounced[guard.switch] && phases[guard.switch] == Phase::Free {
                    self.orders[at] = 1;
                    continue;
                }
                for (k, derivative) in derivatives.iter().enumerate() {
                    let own =
                        row.own_error(size) + row.norm * configuration.error * size * k as f64;
                    let error = match k {
                        0 => self.vague(row) + own,
                        _ => (configuration.norm_of(row) * off + own) * factor[k].max(1e-3),
                    };
                    let beside = row.norm * size * factor[k].max(1e-3);
                    let value = row.at(derivative);
                    sign = self.sign(guard.switch, value, error * SLACK, beside, is_due)?;
                    if sign != 0 {
                        self.orders[at] = k;
                        break;
                    }
                }
                let slides = matches!(phases[guard.switch], Phase::Slip(_));
                let still = match (phases[guard.switch], number) {
                    (Phase::OnOff { body, .. }, 0) => body != 0,
                    (Phase::OnOff { rate, .. }, _) => rate != 0,
                    _ => false,
                };
                if sign < 0 || sign == 0 && (slides || still) {
                    wrong = Some((guard.switch, number, sign));
                    break;
                }
            }
            let Some((switch, number, sign)) = wrong else {
                return Ok(true);
            };
            // How often the sign of v_b was turned round, or lost.
            turns[switch] += usize::from(number == 0);
            let stands_aside = match phases[switch] {
                Phase::Slip(side) if sign == 0 => {
                    !seen.insert((switch, side)) || self.is_held_by_damper(phases, switch)
                }
                _ => false,
            };
            let old = phases[switch];
            phases[switch] = match (phases[switch], number) {
                (Phase::Stick, 0) => Phase::Slip(-1),
                (Phase::Stick, _) => Phase::Slip(1),
                // What others hold cannot slide: it carries what it can.
                (Phase::Slip(side), _) if stands_aside => Phase::Idle(side),
                (Phase::Slip(_), _) => Phase::Stick,
                (Phase::Open, _) => Phase::Closed,
                (Phase::Closed, _) => Phase::Open,
                (Phase::Free, _) => Phase::Contact,
                (Phase::Contact, _) => Phase::Free,
                (Phase::OnOff { rate, .. }, 0) if turns[switch] > 6 => Phase::Hold { rate },
                (Phase::OnOff { rate, .. }, 0) if sign == 0 => Phase::OnOff { body: 0, rate },
                (Phase::OnOff { body, .. }, _) if sign == 0 => Phase::OnOff { body, rate: 0 },
                (Phase::OnOff { body, rate }, 0) => Phase::OnOff { body: -body, rate },
                (Phase::OnOff { body, rate }, _) => Phase::OnOff { body, rate: -rate },
                (Phase::Hold { rate }, 2) => Phase::Hold { rate: -rate },
                (Phase::Hold { rate }, number) => Phase::OnOff {
                    body: if number == 0 { -rate } else { rate },
                    rate,
                },
                (Phase::Clipped { low, high, rate }, 0) => Phase::Clipped {
                    low: -low,
                    high,
                    rate,
                },
                (Phase::Clipped { low, high, rate }, 1) => Phase::Clipped {
                    low,
                    high: -high,
                    rate,
                },
                (Phase::Clipped { low, high, rate }, _) => Phase::Clipped {
                    low,
                    high,
                    rate: -rate,
                },
                (Phase::Idle(_), 0) => Phase::Slip(-1),
                (Phase::Idle(_), _) => Phase::Slip(1),
            };
            if let (Phase::Slip(side), true) = (old, sign < 0) {
                returned.insert((switch, side));
            }
            // With the low damping frictions hold its body alone, beyond the high one it slides.
            if is_hold(&old) && !is_hold(&phases[switch]) {
                turns[switch] = 0;
                for (other, phase) in phases.iter_mut().enumerate() {
                    *phase = match *phase {
                        Phase::Idle(_) if self.along(other, switch, 1).is_none() => *phase,
                        Phase::Idle(side) if number != 0 && side != 0 => Phase::Slip(side),
                        Phase::Idle(_) => Phase::Stick,
                        phase => phase,
                    };
                }
                if number == 0
                    && let Some(shared) = self.shared(phases, false)?
                {
                    phases.copy_from_slice(&shared);
                }
            }
            // What would only slide back carries what it can, in place of what stood aside with that.
            if let (Phase::Stick, Phase::Slip(side)) = (old, phases[switch])
                && returned.contains(&(switch, side))
                && let Some(aside) = phases.iter().position(carries_all)
            {
                phases[switch] = Phase::Idle(side);
                phases[aside] = Phase::Stick;
                continue;
            }
            // A damper that only loses a sign does what it did.
            let setting = |phase: Phase| self.places[switch].setting(phase);
            let is_alike = setting(old).is_some() && setting(old) == setting(phases[switch]);
            // Where one gives way, what stood aside may be needed, what was held may slide, and what was still may move.
            let slides = matches!(phases[switch], Phase::Slip(_) | Phase::Free);
            let gives = slides || matches!(phases[switch], Phase::Idle(_));
            match old {
                Phase::Idle(0) => parted.push(switch),
                Phase::Stick => {
                    let others = parted.drain(..).filter(|other| *other != switch);
                    others.for_each(|other| phases[other] = Phase::Stick);
                }
                _ => {}
            }
            for (other, phase) in phases.iter_mut().enumerate() {
                *phase = match *phase {
                    Phase::Idle(0) if other != switch && gives => Phase::Stick,
                    Phase::OnOff { body, rate }
                        if other != switch
                            && body * rate == 0
                            && !is_alike
                            && !self.places[other].body.is_nothing() =>
                    {
                        let moves = |sign: i8| if sign == 0 { 1 } else { sign };
                        let (body, rate) = (moves(body), moves(rate));
                        Phase::OnOff { body, rate }
                    }
                    Phase::Idle(side) if other != switch && slides && side != 0 => {
                        Phase::Slip(side)
                    }
                    phase => phase,
                };
            }
        }
        Ok(false)
    }

    /// Which laws are asked first, by rising numbers.
    ///
    /// Frictions come last: what holds by its static limit is asked beside laws that all others agree with, those of frictions
    /// that stand aside among them. Of those that cannot hold the one gives way first that is first at its limit as forces
    /// run on from what they were, or else, of those that have not held before, the one farthest beyond its limit.
    fn precedence(
        &self,
        precedence: Precedence,
        phases: &[Phase],
        guards: &[Guard<T>],
        at: usize,
    ) -> (u8, f64) {
        let switch = guards[at].switch;
        let (Phase::Stick, Switch::Friction(friction)) =
            (phases[switch], &self.places[switch].switch)
        else {
            return (u8::from(matches!(phases[switch], Phase::Slip(_))), 0.0);
        };
        // Nearer to each other they are equal.
        const TOGETHER: f64 = 1e10;
        let together = |share: f64| (TOGETHER * share).round();
        let most = friction.static_force;
        let after = guards[at].row.at(&self.zeta).to_f64();
        match precedence {
            Precedence::Index => (1, 0.0),
            Precedence::Held => {
                let has_held = matches!(self.phases[switch], Phase::Stick | Phase::Idle(_));
                (2 + u8::from(has_held), together(after / most))
            }
            Precedence::Path => {
                let number = guards[..at].iter().rev();
                let number = number.take_while(|other| other.switch == switch).count();
                let before = match self.phases[switch] {
                    // Nothing acted before the start.
                    _ if !self.started => most,
                    Phase::Slip(sign) => {
                        let pulls = f64::from(sign) * if number == 0 { 1.0 } else { -1.0 };
                        most + pulls * friction.force
                    }
                    Phase::Stick => {
                        let own = self.current.guards.iter();
                        let mut own = own.filter(|guard| guard.switch == switch);
                        let before = own.nth(number);
                        before.map_or(most, |guard| guard.row.at(&self.earlier).to_f64())
                    }
                    _ => most,
                };
                let share = match before > 0.0 {
                    true => before / (before - after),
                    false => after / most,
                };
                let share = together(share);
                (2, if after < 0.0 { share } else { f64::INFINITY })
            }
        }
    }

    /// Frictions on a body that an on-off damper holds carry all that they have against the side to which it would move, which
    /// is that on which the damping is high: the damper takes what they cannot.
    fn exhaust_beside_dampers(&self, phases: &mut [Phase]) {
        for damper in 0..phases.len() {
            let Phase::Hold { rate } = phases[damper] else {
                continue;
            };
            for (switch, phase) in phases.iter_mut().enumerate() {
                if matches!(self.places[switch].switch, Switch::Friction(_))
                    && let Some(sign) = self.along(switch, damper, 1)
                {
                    *phase = Phase::Idle(sign * rate);
                }
            }
        }
    }

    /// Whether a friction would hold what an on-off damper holds already, which takes what the friction cannot.
    fn is_held_by_damper(&mut self, phases: &[Phase], switch: usize) -> bool {
        let mut held = phases.to_vec();
        held[switch] = Phase::Stick;
        phases.iter().any(is_hold) && self.configuration(&held).is_err()
    }

    /// The system of some phases, where frictions that hold what others hold already stand aside: those that did not hold before
    /// do so first, and then the weaker ones; of equals the last listed one, or the first where that is asked for.
    fn independent(
        &mut self,
        phases: &mut [Phase],
        last_first: bool,
    ) -> Result<Rc<Configuration<T>>, Halt> {
        loop {
            if let Ok(configuration) = self.configuration(phases) {
                return Ok(configuration);
            }
            // What a rigid stop holds still a damper need not hold.
            let rests = |damper: usize| {
                (0..phases.len()).any(|stop| {
                    phases[stop] == Phase::Contact && self.along(stop, damper, 1).is_some()
                })
            };
            let twice = (0..phases.len()).find_map(|damper| match phases[damper] {
                Phase::Hold { rate } if rests(damper) => Some((damper, rate)),
                _ => None,
            });
            if let Some((damper, rate)) = twice {
                phases[damper] = Phase::OnOff { body: 0, rate };
                continue;
            }
            // What a friction carries beside a damper that holds the same is not unique, and decides what follows.
            if phases.iter().any(is_hold) {
                self.configuration(phases)?;
            }
            let mut order: Vec<usize> = (0..phases.len()).collect();
            if last_first {
                order.reverse();
            }
            order.sort_by(|a, b| {
                self.firmness(*b)
                    .partial_cmp(&self.firmness(*a))
                    .unwrap_or(Ordering::Equal)
            });
            let mut partial: Vec<Phase> = phases
                .iter()
                .map(|phase| {
                    if *phase == Phase::Stick {
                        Phase::Idle(0)
                    } else {
                        *phase
                    }
                })
                .collect();
            self.configuration(&partial)?;
            for switch in order {
                if phases[switch] == Phase::Stick {
                    partial[switch] = Phase::Stick;
                    if self.configuration(&partial).is_err() {
                        partial[switch] = Phase::Idle(0);
                    }
                }
            }
            phases.copy_from_slice(&partial);
        }
    }

    /// Which of frictions that hold the same goes on: the larger.
    fn firmness(&self, switch: usize) -> (bool, f64) {
        let has_held = self.started && matches!(self.phases[switch], Phase::Stick | Phase::Idle(_));
        match &self.places[switch].switch {
            Switch::Friction(friction) => (has_held, friction.static_force),
            _ => (has_held, 0.0),
        }
    }

    /// Takes away what rounding left of the rates that are held.
    fn project(&mut self, change: &mut Change) {
        let configuration = self.current.clone();
        if configuration.held.is_empty() {
            return;
        }
        let n = self.zeta.len();
        let mut map = vec![0.0; n * n];
        (0..n).for_each(|i| map[i * n + i] = 1.0);
        let forces: Vec<T> = configuration
            .held
            .iter()
            .map(|(_, gain, _)| dot(gain, &self.zeta))
            .collect();
        let mut sizes = vec![0.0; n];
        for ((_, gain, push), force) in configuration.held.iter().zip(&forces) {
            for i in 0..n {
                self.zeta[i] = self.zeta[i] - *force * push[i];
                for j in 0..n {
                    map[i * n + j] -= push[i].to_f64() * gain[j].to_f64();
                }
            }
            let norm = length(&gain.iter().map(|entry| entry.to_f64()).collect::<Vec<_>>());
            for (size, push) in sizes.iter_mut().zip(push) {
                *size += norm * push.to_f64().abs();
            }
        }
        let rounding = unit::<T>() * (n + 4) as f64 * 4.0 + configuration.error;
        let size = self.size();
        let blurred: Vec<f64> = sizes.iter().map(|own| own * rounding * size).collect();
        self.blur(&blurred);
        self.errors.map(&map);
        change.compose(&map, n);
    }
}

/// Which of several frictions that cannot hold gives way first.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Precedence {
    /// The first at its limit, as forces run on.
    Path,
    /// One that has not held before, and the farthest beyond its limit.
    Held,
    /// The one that is listed first: with it pivots end.
    Index,
}

fn is_stick(phase: &Phase) -> bool {
    *phase == Phase::Stick
}

/// How many frictions slide.
fn sliding_in(phases: &[Phase]) -> usize {
    let slip = |phase: &&Phase| matches!(phase, Phase::Slip(_));
    phases.iter().filter(slip).count()
}

/// Phases that all laws agree with.
struct Agreed {
    /// How many frictions hold, and how many of them have held before.
    rank: [usize; 2],
    phases: Vec<Phase>,
    orders: Vec<usize>,
    precedence: Precedence,
}

/// Whether a friction stands aside with all that it has.
fn carries_all(phase: &Phase) -> bool {
    matches!(phase, Phase::Idle(side) if *side != 0)
}

/// Whether a damper holds its body.
fn is_hold(phase: &Phase) -> bool {
    matches!(phase, Phase::Hold { .. })
}

/// What a change of phase is called.
fn kind<T: Real>(place: &Place<T>, old: Phase, new: Phase) -> Option<EventKind> {
    let sticks = |phase| matches!(phase, Phase::Stick | Phase::Idle(_));
    match (old, new) {
        _ if old == new || sticks(old) && sticks(new) => None,
        (_, Phase::Slip(_)) => Some(EventKind::Slip),
        (Phase::Slip(_), _) => Some(EventKind::Stick),
        (_, Phase::Closed | Phase::Contact) => Some(EventKind::Contact),
        (Phase::Closed | Phase::Contact, _) => Some(EventKind::Release),
        _ if place.setting(old) != place.setting(new) => Some(EventKind::Switch),
        _ => None,
    }
}
