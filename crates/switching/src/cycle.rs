//! Periodic motions: fixed points of the map of the state over a period, by Newton's method with the exact derivative of that
//! map (Parker and Chua, Practical Numerical Algorithms for Chaotic Systems, 1989, sections 3.4 and 5.2).

use eigentone_digits::{Lu, Real, Wide, eigenvalues, sort_by_number};
use eigentone_modes::System;
use eigentone_response::State;
use faer::{Mat, c64};

use crate::change::product;
use crate::cycle_error::CycleError;
use crate::error::SwitchingError;
use crate::event::Event;
use crate::march::{Doubt, March, Question};
use crate::rows::{Row, dot, length};
use crate::switching::Switching;

/// How long a period is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Period {
    /// As long as the motion makes it, as that of a mass on a belt: loads are constant, and supports move steadily or not at
    /// all.
    Free,
    /// So many seconds.
    Seconds(f64),
    /// So many cycles of the slowest harmonic load, exactly.
    Cycles(u32),
}

/// A motion that repeats itself.
#[derive(Clone, Debug, PartialEq)]
pub struct LimitCycle {
    /// In s.
    pub period: f64,
    /// How far that may be off, in s; estimated.
    pub period_bound: f64,
    /// At its start, by coordinate: in m or rad.
    pub displacement: Vec<f64>,
    /// At its start, by coordinate: in m/s or rad/s.
    pub velocity: Vec<f64>,
    /// How far displacements and velocities may be off, by coordinate; estimated.
    pub bound: [Vec<f64>; 2],
    /// What happens in one period, by time from its start.
    pub events: Vec<Event>,
    /// What becomes of small disturbances in one period, each by a factor: the eigenvalues of the derivative of the map over a
    /// period, the largest first. Where the period is free, the one of a shift in time, which is 1, is left out.
    pub multipliers: Vec<c64>,
    /// Whether disturbances die out; `None` where doubles do not decide.
    pub stable: Option<bool>,
    /// Whether the problem's own motion is near it where the search starts, within a hundredth of how far it moves in a period. If not,
    /// that motion may need more time to come there, or tend to another one, such as one of twice the period.
    pub is_reached: bool,
}

impl LimitCycle {
    /// The state that starts the motion at t = 0, when loads and supports start theirs.
    pub fn state(&self, system: &System) -> State {
        let each = system
            .names()
            .iter()
            .zip(self.displacement.iter().zip(&self.velocity));
        each.fold(State::at_rest(), |state, (name, (x, v))| {
            state.displace(name, *x).push(name, *v)
        })
    }
}

impl Switching<'_, '_> {
    /// A periodic motion near where the motion ends: where the problem's time ends, Newton's method takes over. So it need not be
    /// stable, nor the one that the motion tends to: [`LimitCycle::is_reached`].
    ///
    /// # Errors
    /// [`CycleError`].
    pub fn limit_cycle(&self, period: Period) -> Result<LimitCycle, CycleError> {
        let search = Search {
            question: self.question(),
        };
        search.run(period)
    }
}

/// With so many that a period is known to all digits of doubles.
type Digits = Wide<4>;

struct Search<'s, 'a, 'b> {
    question: &'s Question<'a, 'b>,
}

/// What a motion comes to.
struct Pass {
    /// Displacements, then velocities.
    motion: Vec<Digits>,
    /// How they follow those at the start, by rows.
    tangent: Vec<f64>,
    /// How they change, in 1/s.
    rate: Vec<f64>,
    /// How far each may be off.
    errors: Vec<f64>,
    /// Of the controlled dampers between what may move.
    speeds: Vec<f64>,
    events: Vec<Event>,
}

/// A periodic motion as Newton's method leaves it.
struct Fixed {
    motion: Vec<Digits>,
    period: Digits,
    pass: Pass,
    /// How far it is from repeating itself, beside its size.
    residual: f64,
    /// Make lengths of displacements and velocities.
    scales: Vec<f64>,
}

impl Search<'_, '_, '_> {
    fn run(&self, period: Period) -> Result<LimitCycle, CycleError> {
        let (start, period, free) = self.guess(period)?;
        let mut fixed = self.newton(start.clone(), period, free)?;
        if free {
            fixed = self.shortest(fixed)?;
        }
        let [off_state, off_period] = fixed.off(free)?;
        if (free || self.is_steady()) && fixed.rests(off_state) {
            return Err(CycleError::Lost);
        }
        let n = fixed.scales.len();
        let twice = fixed.period * Digits::from(2.0);
        let again = self.pass(&fixed.motion, twice, &vec![0.0; n])?;
        let off = scaled(&again.motion, &fixed.motion, &fixed.scales);
        let size = scaled(&fixed.motion, &[], &fixed.scales);
        if length(&off) > 1e-9 * length(&size) {
            return Err(CycleError::NotRepeating {
                period: fixed.period.to_f64(),
            });
        }
        let samples = self.samples(&fixed)?;
        let is_reached = fixed.is_near(&start, &samples);
        let ball: Vec<f64> = fixed.scales.iter().map(|scale| off_state / scale).collect();
        let known = self.pass(&fixed.motion, fixed.period, &ball)?;
        let mut monodromy = fixed.pass.tangent.clone();
        for (at, entry) in monodromy.iter_mut().enumerate() {
            *entry *= fixed.scales[at / n] / fixed.scales[at % n];
        }
        if free {
            leave_out(&mut monodromy, &fixed.rate());
        }
        let matrix = Mat::from_fn(n, n, |i, j| monodromy[i * n + j]);
        let seconds = fixed.period.to_f64();
        let found =
            eigenvalues(matrix.as_ref()).filter(|_| !fixed.leaves_dampers_at_rest(&samples));
        let unknown = CycleError::NoMultipliers { period: seconds };
        let mut multipliers = found.ok_or(unknown)?;
        sort_by_number(&mut multipliers, |a| -a.norm());
        multipliers.truncate(n - usize::from(free));
        let (displacement, velocity): (Vec<f64>, Vec<f64>) = {
            let rounded: Vec<f64> = fixed.motion.iter().map(|entry| entry.to_f64()).collect();
            (rounded[..n / 2].to_vec(), rounded[n / 2..].to_vec())
        };
        let bounds: Vec<f64> = ball
            .iter()
            .zip(displacement.iter().chain(&velocity))
            .map(|(off, value)| off + value.abs() * f64::EPSILON / 2.0)
            .collect();
        Ok(LimitCycle {
            period: seconds,
            period_bound: off_period + seconds * f64::EPSILON / 2.0,
            displacement,
            velocity,
            bound: [bounds[..n / 2].to_vec(), bounds[n / 2..].to_vec()],
            events: known.events,
            stable: dies_out(n, monodromy),
            is_reached,
            multipliers,
        })
    }

    /// Whether loads keep their laws and nothing oscillates but supports that touch nothing, so that what is at rest stays there.
    fn is_steady(&self) -> bool {
        let problem = self.question.problem;
        let timeline = problem.timeline();
        let acts = |signal: usize| {
            let channel = signal.checked_sub(problem.system().len());
            channel.is_none_or(|at| !problem.channels()[at].directions.concat().is_empty())
        };
        let mut harmonics = timeline.harmonics().iter();
        let still = harmonics.all(|(signal, load)| load.frequency == 0.0 || !acts(*signal));
        timeline.pieces().len() == 1 && still
    }

    /// What the motion comes to within its period, where it can be followed.
    fn samples(&self, fixed: &Fixed) -> Result<Vec<Pass>, CycleError> {
        let known = vec![0.0; fixed.scales.len()];
        // √2 − 1, √3 − 1 and √5 − 2 of a period: a motion that repeats within it is not back at its start at all three.
        let parts = [0.414_213_562, 0.732_050_808, 0.236_067_977];
        let passes = parts.map(|part| {
            let until = fixed.period.mul_f64(part);
            Ok(tried(self.pass(&fixed.motion, until, &known))?.ok())
        });
        passes.into_iter().filter_map(Result::transpose).collect()
    }

    /// The same with its least period: a part of the one that was found, with as large a part of its events.
    fn shortest(&self, fixed: Fixed) -> Result<Fixed, CycleError> {
        const ALIKE: f64 = 1e-9;
        let count = fixed.pass.events.len();
        for parts in (2..=count)
            .rev()
            .filter(|parts| count.is_multiple_of(*parts))
        {
            let period = fixed.period / Digits::from(parts as f64);
            let known = vec![0.0; fixed.scales.len()];
            let Some(pass) = tried(self.pass(&fixed.motion, period, &known))?.ok() else {
                continue;
            };
            let off = length(&scaled(&pass.motion, &fixed.motion, &fixed.scales));
            if off <= ALIKE * length(&scaled(&fixed.motion, &[], &fixed.scales)) {
                return self.newton(fixed.motion, period, true);
            }
        }
        Ok(fixed)
    }

    /// A state near the periodic motion, and about its period, by the motion itself.
    fn guess(&self, period: Period) -> Result<(Vec<Digits>, Digits, bool), CycleError> {
        let problem = self.question.problem;
        let end = problem.grid().time(problem.grid().last());
        let seconds = match period {
            Period::Free if self.question.switches.is_empty() => {
                return Err(CycleError::NothingSwitches);
            }
            Period::Free => {
                let pass = self.transient(Digits::from(end))?;
                let (start, period) =
                    repetition(&pass.events, end).ok_or(CycleError::NoRepetition { end })?;
                let pass = self.transient(Digits::from(start))?;
                return Ok((pass.motion, Digits::from(period), true));
            }
            Period::Seconds(seconds) if seconds.is_finite() && seconds > 0.0 => {
                Digits::from(seconds)
            }
            Period::Seconds(seconds) => return Err(CycleError::Period { seconds }),
            Period::Cycles(0) => return Err(CycleError::Period { seconds: 0.0 }),
            Period::Cycles(count) => {
                let harmonics = problem.timeline().harmonics().iter();
                let slowest = harmonics
                    .map(|(_, harmonic)| harmonic.frequency.abs())
                    .filter(|frequency| *frequency > 0.0)
                    .reduce(f64::min)
                    .ok_or(CycleError::NoHarmonic)?;
                eigentone_response::turns(count, slowest)
            }
        };
        // The last start of a period within the time asked for.
        let passed = (end / seconds.to_f64()).floor();
        let pass = self.transient(seconds * Digits::from(passed))?;
        Ok((pass.motion, seconds, false))
    }

    /// From the problem's own start; where digits do not decide what happens, as rounding has it.
    fn transient(&self, until: Digits) -> Result<Pass, CycleError> {
        let mut march =
            March::<Digits>::of::<Digits>(self.question, Doubt::Ignored, f64::INFINITY)?;
        march.go((until, 0.0), false, &mut |_, _, _, _| {})?;
        Ok(Pass::of(march, &[]))
    }

    /// From displacements and velocities, which are known to these bounds: a motion that is tried, not that of the problem.
    fn pass(&self, from: &[Digits], until: Digits, off: &[f64]) -> Result<Pass, CycleError> {
        let mut march =
            March::<Digits>::of::<Digits>(self.question, Doubt::Coincidence, f64::INFINITY)?;
        march.spare(1.0 / 32.0);
        let enter = march.place(from, off);
        let gone = march.go((until, 0.0), false, &mut |_, _, _, _| {});
        gone.map_err(|halt| match halt.into() {
            error @ SwitchingError::Response(_) => CycleError::Switching(error),
            error => CycleError::Halted(error),
        })?;
        Ok(Pass::of(march, &enter))
    }

    /// Newton's method, with shorter steps where whole ones do not come closer.
    fn newton(
        &self,
        mut motion: Vec<Digits>,
        mut period: Digits,
        free: bool,
    ) -> Result<Fixed, CycleError> {
        const MOST: usize = 40;
        /// Relative residuals that cannot be improved, and that suffice.
        const BEST: f64 = 1e-40;
        const GOOD: f64 = 1e-20;
        let n = motion.len();
        let known = vec![0.0; n];
        let mut best: Option<Fixed> = None;
        let mut part = 1.0;
        // Why the last steps were too long, where the motion after one could not be followed.
        let mut halted = None;
        for _ in 0..MOST {
            let turn = period.to_f64() / std::f64::consts::TAU;
            let scale = |i: usize| if i < n / 2 { 1.0 } else { turn };
            let scales: Vec<f64> = (0..n).map(scale).collect();
            let before = best.as_ref().map_or(f64::INFINITY, |best| best.residual);
            let closer = match tried(self.pass(&motion, period, &known))? {
                Ok(pass) => {
                    let size = length(&scaled(&pass.motion, &[], &scales));
                    let residual = length(&scaled(&pass.motion, &motion, &scales));
                    let relative = residual / size.max(f64::MIN_POSITIVE);
                    (relative < before).then_some((pass, relative))
                }
                Err(error) => {
                    halted = Some(error);
                    None
                }
            };
            match closer {
                Some((pass, residual)) => {
                    part = if part < 1.0 { 2.0 * part } else { 1.0 };
                    halted = None;
                    best = Some(Fixed {
                        motion,
                        period,
                        pass,
                        residual,
                        scales,
                    });
                }
                None if before <= GOOD => break,
                None => part /= 2.0,
            }
            let Some(best) = &best else { break };
            if best.residual <= BEST {
                break;
            }
            let Some((step, delay)) = best.step(free) else {
                break;
            };
            let each = best.pass.motion.iter().zip(&best.motion);
            // The map's own image keeps what holds, which rounded steps would let go.
            let carried = best.carried(&step);
            motion = each
                .zip(carried.iter().zip(&best.pass.rate))
                .map(|((after, before), (carried, rate))| {
                    let whole =
                        *after - *before + Digits::from(*carried) + Digits::from(rate * delay);
                    *before + whole.mul_f64(part)
                })
                .collect();
            period = best.period + Digits::from(delay * part);
            if period <= Digits::ZERO {
                return Err(CycleError::Lost);
            }
        }
        best.filter(|best| best.residual <= GOOD)
            .ok_or(halted.unwrap_or(CycleError::Lost))
    }
}

impl Pass {
    /// Where it ends, and how that follows the start by the columns of ζ that each entry of the motion there enters by.
    fn of(march: March<'_, '_, Digits>, enter: &[Vec<f64>]) -> Pass {
        let rows = march.motion();
        let n = march.zeta.len();
        let tangent = march.tangent.as_ref();
        let carried = tangent.map(|tangent| {
            let columns = enter.iter().map(|column| {
                let entry = |row: &[f64]| row.iter().zip(column).map(|(a, b)| a * b).sum();
                tangent.chunks(n).map(entry).collect::<Vec<f64>>()
            });
            columns.collect::<Vec<_>>()
        });
        let carried = carried.unwrap_or_default();
        let along = |row: &Row<Digits>, column: &Vec<f64>| -> f64 {
            row.rounded.iter().zip(column).map(|(a, b)| a * b).sum()
        };
        let each = rows
            .iter()
            .flat_map(|row| carried.iter().map(move |column| along(row, column)));
        let rates = march.current.apply(&march.zeta);
        let seconds = march.current.step;
        Pass {
            tangent: each.collect(),
            motion: rows.iter().map(|row| row.at(&march.zeta)).collect(),
            rate: rows
                .iter()
                .map(|row| dot(&row.entries, &rates).to_f64() / seconds)
                .collect(),
            errors: rows
                .iter()
                .map(|row| march.vague(row) + row.own_error(march.size()))
                .collect(),
            speeds: march
                .places
                .iter()
                .filter_map(|place| place.speed(&march.zeta))
                .collect(),
            events: march.events,
        }
    }
}

impl Fixed {
    /// Whether a state is near, beside how far the motion goes in a period.
    fn is_near(&self, state: &[Digits], samples: &[Pass]) -> bool {
        const NEAR: f64 = 0.01;
        let apart = samples.iter().map(|pass| {
            let off = scaled(&pass.motion, &self.motion, &self.scales);
            length(&off)
        });
        let extent = apart.fold(0.0, f64::max);
        length(&scaled(state, &self.motion, &self.scales)) <= NEAR * extent
    }

    /// Whether a controlled damper is at rest all the time between what may move: it answers disturbances by no linear law.
    fn leaves_dampers_at_rest(&self, samples: &[Pass]) -> bool {
        /// Slower ones, beside the fastest of the motion, are the digits that are left.
        const REST: f64 = 1e-20;
        let passes = || samples.iter().chain([&self.pass]);
        let velocities = passes().flat_map(|pass| &pass.motion[pass.motion.len() / 2..]);
        let fastest = velocities.fold(0.0, |most, v| v.to_f64().abs().max(most));
        (0..self.pass.speeds.len())
            .any(|damper| passes().all(|pass| pass.speeds[damper] <= REST * fastest))
    }

    /// Whether it moves no farther than what is not known of it lets it: then it is a place of rest, which any period fits.
    fn rests(&self, off: f64) -> bool {
        /// How many times as fast as once a period it may oscillate.
        const FASTEST: f64 = 1e4;
        length(&self.rate()) <= FASTEST * off
    }

    /// Derivative of the map in the scales, less the identity, with a row and a column for the period where that is free.
    fn jacobian(&self, free: bool) -> Mat<f64> {
        let n = self.scales.len();
        let rate = self.rate();
        let speed = length(&rate).max(f64::MIN_POSITIVE);
        Mat::from_fn(
            n + usize::from(free),
            n + usize::from(free),
            |i, j| match (i < n, j < n) {
                (true, true) => {
                    self.pass.tangent[i * n + j] * self.scales[i] / self.scales[j]
                        - f64::from(u8::from(i == j))
                }
                (true, false) => rate[i] / speed,
                (false, true) => rate[j] / speed,
                (false, false) => 0.0,
            },
        )
    }

    /// How the motion changes at the end, in the scales.
    fn rate(&self) -> Vec<f64> {
        let each = self.pass.rate.iter().zip(&self.scales);
        each.map(|(rate, scale)| rate * scale).collect()
    }

    /// The step of Newton's method: of the motion, in the scales, and of the period; `None` where doubles give none.
    fn step(&self, free: bool) -> Option<(Vec<f64>, f64)> {
        let n = self.scales.len();
        let residual = scaled(&self.pass.motion, &self.motion, &self.scales);
        let right = Mat::from_fn(n + usize::from(free), 1, |i, _| match i < n {
            true => -residual[i],
            false => 0.0,
        });
        let answer = Lu::of(self.jacobian(free).as_ref()).solve(right);
        let step: Vec<f64> = (0..n).map(|i| answer[(i, 0)]).collect();
        let speed = length(&self.rate()).max(f64::MIN_POSITIVE);
        let delay = if free { answer[(n, 0)] / speed } else { 0.0 };
        let is_known = step.iter().chain([&delay]).all(|entry| entry.is_finite());
        is_known.then_some((step, delay))
    }

    /// What a step, in the scales, has become at the end.
    fn carried(&self, step: &[f64]) -> Vec<f64> {
        let n = self.scales.len();
        let row = |i: usize| {
            let entries = self.pass.tangent[i * n..(i + 1) * n].iter();
            let each = entries.zip(step.iter().zip(&self.scales));
            each.map(|(entry, (step, scale))| entry * step / scale)
                .sum()
        };
        (0..n).map(row).collect()
    }

    /// How far the motion, in the scales, and the period may be off: what is left of the equations through the inverse of
    /// their derivative, and twice as much for what is not of first order.
    fn off(&self, free: bool) -> Result<[f64; 2], CycleError> {
        /// Beyond this, a neighbour repeats itself as far as doubles show.
        const MOST: f64 = 1e10;
        let jacobian = self.jacobian(free);
        let n = jacobian.nrows();
        let inverse = Lu::of(jacobian.as_ref()).solve(Mat::identity(n, n));
        let growth = inverse.norm_l2();
        if !growth.is_finite() || growth > MOST {
            return Err(CycleError::NotIsolated);
        }
        let errors = self.pass.errors.iter().zip(&self.scales);
        let errors: Vec<f64> = errors.map(|(error, scale)| error * scale).collect();
        let residual = scaled(&self.pass.motion, &self.motion, &self.scales);
        let off = 2.0 * growth * (length(&residual) + length(&errors));
        let speed = length(&self.rate()).max(f64::MIN_POSITIVE);
        Ok([off, if free { off / speed } else { 0.0 }])
    }
}

/// What a motion that is tried comes to, or why it cannot be followed; limits of the search itself end it.
fn tried(pass: Result<Pass, CycleError>) -> Result<Result<Pass, CycleError>, CycleError> {
    match pass {
        Err(error) if !matches!(error, CycleError::Halted(_)) => Err(error),
        pass => Ok(pass),
    }
}

/// The difference of two motions, or the first alone, in scales.
fn scaled(motion: &[Digits], less: &[Digits], scales: &[f64]) -> Vec<f64> {
    let each = motion
        .iter()
        .zip(scales)
        .enumerate()
        .map(|(i, (entry, scale))| {
            let less = less.get(i).copied().unwrap_or(Digits::ZERO);
            (*entry - less).to_f64() * scale
        });
    each.collect()
}

/// Takes the shift in time, along a rate, out of the derivative of a map: what is left is that of the section across it.
fn leave_out(map: &mut [f64], rate: &[f64]) {
    let n = rate.len();
    let square: f64 = rate.iter().map(|entry| entry * entry).sum();
    if square == 0.0 {
        return;
    }
    for j in 0..n {
        let share: f64 = (0..n).map(|i| rate[i] * map[i * n + j]).sum::<f64>() / square;
        (0..n).for_each(|i| map[i * n + j] -= share * rate[i]);
    }
}

/// Whether the powers of a map tend to 0, by squaring: a norm below 1 shows it, a trace above the order that they do not
/// (both bound the largest eigenvalue).
fn dies_out(n: usize, mut map: Vec<f64>) -> Option<bool> {
    /// What the map may be off, beside its size.
    const OFF: f64 = 1e-12;
    let mut off = OFF * length(&map);
    for _ in 0..64 {
        let size = length(&map);
        let trace: f64 = (0..n).map(|i| map[i * n + i]).sum();
        if !size.is_finite() || !off.is_finite() {
            return None;
        } else if size + off < 1.0 {
            return Some(true);
        } else if trace.abs() - off * n as f64 > n as f64 {
            return Some(false);
        }
        map = product(n, &map, &map);
        off = off * (2.0 * size + off) + f64::EPSILON * n as f64 * size * size;
    }
    None
}

/// The middle of the longest time without events in the last of the periods that events come in, and that period.
fn repetition(events: &[Event], end: f64) -> Option<(f64, f64)> {
    /// The relative change of a period that still is one.
    const ALIKE: f64 = 0.2;
    let count = events.len();
    let alike = |a: &Event, b: &Event| a.switch == b.switch && a.kind == b.kind;
    let span = |length: usize, back: usize| {
        let last = count - 1 - back * length;
        events[last].time - events[last - length].time
    };
    let repeats = |length: &usize| {
        let recent = &events[count - 2 * length..];
        let same = (0..*length).all(|i| alike(&recent[i], &recent[i + length]));
        let [now, before] = [span(*length, 0), span(*length, 1)];
        same && now > 0.0 && (now - before).abs() <= ALIKE * now
    };
    // The last event of three spans is needed.
    let longest = count.saturating_sub(1) / 2;
    let length = (1..=longest).find(repeats)?;
    let period = span(length, 0);
    // Events that ended long ago are no cycle.
    if end - events[count - 1].time > 2.0 * period {
        return None;
    }
    let last = &events[count - 1 - length..];
    let gap = last
        .windows(2)
        .max_by(|a, b| (a[1].time - a[0].time).total_cmp(&(b[1].time - b[0].time)))?;
    Some((0.5 * (gap[0].time + gap[1].time), period))
}
