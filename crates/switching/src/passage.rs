//! What supports that jump pass on through dampers that switch and stops that damp.
//!
//! A jump is a passage of no duration. While the supports pass, displacements of masses stand still, the rates of stretches are
//! those of the supports alone, and velocities change evenly with the part σ of the passage, as long as the dampings stay: each
//! damper gives the impulse of its damping times the stretch that it takes. It is the limit of ever steeper ramps, in which all
//! other momenta at the same instant act evenly too.

use eigentone_digits::Real;

use crate::error::SwitchingError;
use crate::march::{Halt, March};
use crate::rows::{Row, SLACK, dot, length, unit};
use crate::switch::{DamperLaw, Switch};

/// What decides a damping during the passage.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Decided {
    /// Nothing changes it.
    Fixed,
    /// A stop damps beyond its gap.
    Gap,
    /// An on-off damper is high while v_b has the sign of its rate, else low.
    Body,
}

/// A switch whose stretch jumps.
struct Passing<T> {
    switch: usize,
    decided: Decided,
    /// By how much the stretch jumps, in m, and how well that is known.
    jump: T,
    off: f64,
    /// With which damping, of those below and above its limit, in N·s/m.
    dampings: [T; 2],
    above: bool,
    /// Whether v_b is 0, and stays so.
    still: bool,
    /// Whether it has damped.
    damped: bool,
}

impl<T: Real> March<'_, '_, T> {
    /// Changes ζ, which was `before` at the same instant, by what jumps of its supports pass on; its drives are known to
    /// `added`.
    pub(crate) fn pass_on(&mut self, before: &[T], added: f64) -> Result<(), Halt> {
        let states = self.driven.states();
        let n = self.zeta.len();
        let changed = |part: std::ops::Range<usize>| -> Vec<T> {
            let entry = |i: usize| match part.contains(&i) {
                true => self.zeta[i] - before[i],
                false => T::ZERO,
            };
            (0..n).map(entry).collect()
        };
        let (given, moved) = (changed(0..states), changed(states..n));
        let mut passing = Vec::new();
        let mut blurred = vec![0.0; n];
        self.note_losses(&moved, added);
        for switch in 0..self.places.len() {
            if let Some(one) = self.passing(switch, &moved, added) {
                passing.push(one);
            }
        }
        // What is no jump as far as digits show, and how well the others are known.
        passing.retain(|one| {
            let most = one.dampings[0].to_f64().max(one.dampings[1].to_f64());
            let push = self.places[one.switch].push.iter();
            let each = blurred.iter_mut().zip(push);
            each.for_each(|(sum, push)| *sum += push.to_f64().abs() * most * one.off);
            one.jump.to_f64().abs() > one.off
        });
        // Velocities before, under the drives after.
        let mut zeta: Vec<T> = self.zeta.iter().zip(&given).map(|(a, b)| *a - *b).collect();
        if !passing.is_empty() {
            self.pass(&mut passing, &mut zeta, &given, &mut blurred)?;
            self.zeta = zeta;
        }
        self.errors.add_each(&blurred);
        let damped = passing.iter().filter(|one| one.damped);
        if let Some(taken) = &mut self.taken {
            damped.for_each(|one| taken.without_limit(one.switch));
        }
        Ok(())
    }

    /// By how much a stretch jumps, and how well that is known.
    fn jump(&self, row: &Row<T>, moved: &[T], added: f64) -> (T, f64) {
        let mut along = row.rounded.clone();
        along[..self.driven.states()].fill(0.0);
        let drives = length(&moved.iter().map(|entry| entry.to_f64()).collect::<Vec<_>>());
        let off = self.errors.along(&along) + row.own_error(drives) + added * row.norm;
        (dot(&row.entries, moved), off * SLACK)
    }

    /// Dampers of the system take energy without limit from a jump.
    fn note_losses(&mut self, moved: &[T], added: f64) {
        if let Some(mut taken) = self.taken.take() {
            taken.jump(|row| {
                let (jump, off) = self.jump(row, moved, added);
                jump.to_f64().abs() > off
            });
            self.taken = Some(taken);
        }
    }

    /// How a switch takes part, where it damps; with what is taken of frictions and springs meanwhile.
    fn passing(&mut self, switch: usize, moved: &[T], added: f64) -> Option<Passing<T>> {
        let known = |march: &Self, row: &Row<T>| march.jump(row, moved, added);
        let place = &self.places[switch];
        let (jump, mut off) = known(self, &place.stretch);
        let is_jump = jump.to_f64().abs() > off;
        let beyond = |gap: f64, part: T| {
            let left = place.stretch.at(&self.zeta) - part - T::from(gap);
            if left > T::ZERO { left } else { T::ZERO }
        };
        let mut energy = T::ZERO;
        let (decided, dampings) = match &place.switch {
            Switch::Impact(_) => return None,
            Switch::Friction(friction) => {
                let size = if jump < T::ZERO { -jump } else { jump };
                energy = T::from(friction.force) * size;
                (Decided::Fixed, [T::ZERO; 2])
            }
            Switch::Stop(stop) => {
                let (from, to) = (beyond(stop.gap, jump), beyond(stop.gap, T::ZERO));
                energy = (T::from(stop.stiffness) * (to * to - from * from)).scale(-1);
                (Decided::Gap, [T::ZERO, T::from(stop.damping)])
            }
            Switch::ControlledDamper(damper) => {
                let (low, high) = (T::from(damper.low), T::from(damper.high));
                let [body, _] = self.driven.form(2 * switch + 1);
                let (body, body_off) = known(self, &Row::with_constant(body, T::ZERO));
                let body_jumps = body.to_f64().abs() > body_off;
                match damper.law {
                    // Beside the infinite rate no speed of the body counts.
                    DamperLaw::ClippedSkyhook { .. } if !body_jumps => (Decided::Fixed, [low; 2]),
                    DamperLaw::ClippedSkyhook { sky } => {
                        let wanted = T::from(sky) * body / jump;
                        // Of a damping times the jump.
                        off = 2.0 * off + (body_off * (jump / body).to_f64()).abs();
                        let least = if wanted < low { low } else { wanted };
                        (Decided::Fixed, [if least > high { high } else { least }; 2])
                    }
                    DamperLaw::OnOffSkyhook if !body_jumps => (Decided::Body, [low, high]),
                    DamperLaw::OnOffSkyhook => match (body > T::ZERO) == (jump > T::ZERO) {
                        true => (Decided::Fixed, [high; 2]),
                        false => (Decided::Fixed, [low; 2]),
                    },
                }
            }
        };
        if is_jump && let Some(taken) = &mut self.taken {
            taken.impact(switch, energy);
        }
        let decided = match dampings[0] == dampings[1] {
            true => Decided::Fixed,
            false => decided,
        };
        let damps = dampings.iter().any(|damping| !damping.is_zero());
        damps.then_some(Passing {
            switch,
            decided,
            jump,
            off,
            dampings,
            above: false,
            still: false,
            damped: false,
        })
    }

    /// Takes ζ through the passage, from event to event.
    fn pass(
        &mut self,
        passing: &mut [Passing<T>],
        zeta: &mut [T],
        given: &[T],
        blurred: &mut [f64],
    ) -> Result<(), Halt> {
        const MOST: usize = 1000;
        let n = zeta.len();
        let mut left = T::ONE;
        // How far each stop that damps is beyond its gap.
        let mut beyond: Vec<T> = Vec::with_capacity(passing.len());
        for one in passing.iter_mut() {
            let place = &self.places[one.switch];
            beyond.push(match &place.switch {
                Switch::Stop(stop) => place.stretch.at(&self.zeta) - one.jump - T::from(stop.gap),
                _ => T::ZERO,
            });
            let start = beyond[beyond.len() - 1];
            let vague = self.vague(&place.stretch) + place.stretch.own_error(self.size());
            let damping = one.dampings[1].to_f64();
            match one.decided {
                Decided::Fixed => {}
                Decided::Gap => {
                    one.above = start > T::ZERO || start.is_zero() && one.jump > T::ZERO;
                    // Where the gap lies is not known better; a damping times that is the whole error.
                    let push = place.push.iter();
                    let each = blurred.iter_mut().zip(push);
                    each.for_each(|(sum, push)| *sum += push.to_f64().abs() * damping * vague);
                }
                Decided::Body => {
                    let sign = self.body_sign(one, zeta)?;
                    one.still = sign == 0;
                    one.above = sign != 0 && (sign > 0) == (one.jump > T::ZERO);
                }
            }
        }
        let mut rate = self.settled_rate(passing, given)?;
        for _ in 0..MOST {
            // The first that comes to its limit.
            let mut next: Option<(usize, T, T)> = None;
            for (at, one) in passing.iter().enumerate() {
                let (value, slope, is_positive) = match one.decided {
                    Decided::Fixed => continue,
                    Decided::Gap => (beyond[at], one.jump, one.above),
                    Decided::Body if one.still => continue,
                    Decided::Body => {
                        let body = &self.places[one.switch].body;
                        let is_positive = one.above == (one.jump > T::ZERO);
                        (body.at(zeta), body.at(&rate), is_positive)
                    }
                };
                if slope.is_zero() || is_positive == (slope > T::ZERO) {
                    continue;
                }
                // What has just left its limit is beyond it but for rounding.
                let part = -(value / slope);
                let part = if part > T::ZERO { part } else { T::ZERO };
                if part < left && next.as_ref().is_none_or(|(_, first, _)| part < *first) {
                    next = Some((at, part, slope));
                }
            }
            let part = next.as_ref().map_or(left, |(_, part, _)| *part);
            T::add_multiple(zeta, part, &rate);
            let each = beyond.iter_mut().zip(passing.iter());
            each.for_each(|(beyond, one)| *beyond = *beyond + part * one.jump);
            left = left - part;
            let rounding = 16.0 * unit::<T>();
            let each = blurred.iter_mut().zip(rate.iter().zip(zeta.iter()));
            each.for_each(|(sum, (rate, zeta))| {
                *sum += rounding * (rate.to_f64().abs() + zeta.to_f64().abs());
            });
            let Some((at, _, slope)) = next else {
                return self.end_passage(passing, zeta);
            };
            let old = std::mem::take(&mut rate);
            let place = &self.places[passing[at].switch];
            let row = match passing[at].decided {
                Decided::Gap => place.stretch.rounded.clone(),
                _ => place.body.rounded.clone(),
            };
            match passing[at].decided {
                Decided::Gap => {
                    beyond[at] = T::ZERO;
                    passing[at].above = !passing[at].above;
                }
                _ => passing[at].still = true,
            }
            rate = self.settled_rate(passing, given)?;
            // When the limit is reached follows the state: a saltation.
            let mut map = vec![0.0; n * n];
            for i in 0..n {
                let change = (rate[i] - old[i]).to_f64() / slope.to_f64();
                for j in 0..n {
                    map[i * n + j] = f64::from(u8::from(i == j)) + change * row[j];
                }
            }
            self.errors.add_each(blurred);
            blurred.fill(0.0);
            self.errors.map(&map);
            self.turn(&map);
        }
        Err(self.undecided(passing[0].switch))
    }

    /// The sign of v_b of an on-off damper.
    fn body_sign(&self, one: &Passing<T>, zeta: &[T]) -> Result<i8, Halt> {
        let body = &self.places[one.switch].body;
        let size = self.size();
        let off = (self.vague(body) + body.own_error(size)) * SLACK;
        self.sign(one.switch, body.at(zeta), off, body.norm * size, false)
    }

    /// No body may be at its turn as the passage ends: what it does there would have decided.
    fn end_passage(&self, passing: &[Passing<T>], zeta: &[T]) -> Result<(), Halt> {
        let moving = passing
            .iter()
            .filter(|one| one.decided == Decided::Body && !one.still);
        for one in moving {
            self.body_sign(one, zeta)?;
        }
        Ok(())
    }

    /// What a passage adds to ζ, with the settings of those dampers whose bodies are still: low, unless the body then moves with
    /// the rate.
    fn settled_rate(&self, passing: &mut [Passing<T>], given: &[T]) -> Result<Vec<T>, Halt> {
        let rate = |passing: &[Passing<T>]| {
            let mut sum = given.to_vec();
            for one in passing {
                let impulse = -(one.dampings[usize::from(one.above)] * one.jump);
                T::add_multiple(&mut sum, impulse, &self.places[one.switch].push);
            }
            sum
        };
        let sign = |one: &Passing<T>, rate: &[T]| {
            let body = &self.places[one.switch].body;
            let size = length(&rate.iter().map(|entry| entry.to_f64()).collect::<Vec<_>>());
            let off = 16.0 * unit::<T>() * rate.len() as f64 * body.norm * size;
            self.sign(one.switch, body.at(rate), off, body.norm * size, true)
        };
        let along = |one: &Passing<T>, sign: i8| match one.jump > T::ZERO {
            true => sign,
            false => -sign,
        };
        let still: Vec<usize> = (0..passing.len()).filter(|at| passing[*at].still).collect();
        still.iter().for_each(|at| passing[*at].above = false);
        for _ in 0..=still.len() {
            let all = rate(passing);
            let mut changed = false;
            for at in &still {
                let one = &passing[*at];
                if !one.above && along(one, sign(one, &all)?) > 0 {
                    passing[*at].above = true;
                    changed = true;
                }
            }
            if changed {
                continue;
            }
            for at in &still {
                let one = &passing[*at];
                let moves = along(one, sign(one, &all)?);
                if one.above && moves <= 0 {
                    return Err(Halt::Failed(SwitchingError::Undecided {
                        time: self.now.to_f64(),
                        switch: one.switch,
                        reason: "as a support jumps, neither damping keeps the sign of v_b",
                    }));
                }
                passing[*at].still = moves == 0;
            }
            for one in passing.iter_mut() {
                one.damped |= !one.dampings[usize::from(one.above)].is_zero();
            }
            return Ok(all);
        }
        unreachable!("each becomes high once")
    }
}
