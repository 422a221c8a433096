//! The largest value over many intervals: halving first where it may be largest, until none may be larger.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use eigentone_digits::Real;

use super::maps::{Maps, Place};
use super::oscillator::Oscillator;
use super::peak::Form;

/// How often an interval is halved in all, at most; what is left then is bounded all the same.
const HALVINGS: usize = 200_000;

/// A part of an interval.
struct Part<T> {
    /// No value in it is larger.
    upper: T,
    /// When its interval begins, in s, and where in that it begins, in intervals.
    interval: f64,
    offset: f64,
    level: i64,
    from: Place<T>,
    to: Place<T>,
}

impl<T: Real> PartialEq for Part<T> {
    fn eq(&self, other: &Part<T>) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl<T: Real> Eq for Part<T> {}

impl<T: Real> PartialOrd for Part<T> {
    fn partial_cmp(&self, other: &Part<T>) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<T: Real> Ord for Part<T> {
    fn cmp(&self, other: &Part<T>) -> Ordering {
        let order = self.upper.partial_cmp(&other.upper);
        order.unwrap_or(Ordering::Equal)
    }
}

/// The largest size of a form, and when.
pub(super) struct Largest<T> {
    pub(super) lower: T,
    pub(super) upper: T,
    pub(super) time: f64,
    turn: Turn,
    /// An interval, in s.
    unit: f64,
}

/// What is known of the slope near the largest value: in intervals.
struct Turn {
    slope: f64,
    curvature: f64,
    third: f64,
    /// The norm of the generator.
    speed: f64,
    /// What roundings may leave of slope and curvature.
    rounding: f64,
    /// How far it is to the root of the slope, about, and how far the law of the motion holds on both sides.
    later: f64,
    room: f64,
}

impl<T> Largest<T> {
    /// How far from the time given the slope vanishes, for states of which the form may be off by `error`; `None` where that
    /// is not proved, as at a corner.
    pub(super) fn time_bound(&self, error: f64) -> Option<f64> {
        let Turn {
            slope,
            curvature,
            third,
            speed,
            rounding,
            later,
            room,
        } = self.turn;
        // A little before, free motions are larger: less than twice as large.
        let third = 2.0 * third;
        let off = (error * speed + rounding) * (1.0 + 1e-9);
        let bent = off * (speed + 1.0);
        let least = curvature.abs() - bent - third * later.abs();
        let missed = (slope + curvature * later).abs() + 4.0 * f64::EPSILON * slope.abs();
        let rest = missed + off + later.abs() * (bent + 0.5 * third * later.abs());
        // Within twice what a straight slope would need, it changes its sign if it bends no more than that.
        let bound = 2.0 * rest / least * (1.0 + 1e-9);
        let near = speed * (later.abs() + bound) < 0.5;
        let proved = near && least > 0.0 && third * bound < 0.5 * least && bound < room;
        let bound = bound * self.unit + 4.0 * f64::EPSILON * self.time.abs();
        (proved && bound.is_finite()).then_some(bound)
    }
}

pub(super) struct Search<'a, T> {
    oscillator: &'a Oscillator,
    driven: &'a mut Maps<T>,
    free: &'a mut Maps<T>,
    form: Form<T>,
    parts: BinaryHeap<Part<T>>,
    /// The largest value met, when, and where that is.
    best: T,
    interval: f64,
    offset: f64,
    place: Place<T>,
    /// An interval, in s.
    unit: f64,
}

impl<'a, T: Real> Search<'a, T> {
    pub(super) fn new(
        oscillator: &'a Oscillator,
        [driven, free]: [&'a mut Maps<T>; 2],
        form: Form<T>,
        start: f64,
        unit: f64,
    ) -> Search<'a, T> {
        Search {
            oscillator,
            driven,
            free,
            form,
            parts: BinaryHeap::new(),
            best: T::ZERO,
            interval: start,
            offset: 0.0,
            place: ([T::ZERO; 2], [T::ZERO; 3]),
            unit,
        }
    }

    pub(super) fn best(&self) -> T {
        self.best
    }

    /// Adds 2^−level intervals from a place on; where that leads.
    pub(super) fn add(
        &mut self,
        interval: f64,
        offset: f64,
        level: i64,
        from: Place<T>,
    ) -> Place<T> {
        let to = self.after(level, &from);
        self.put(interval, offset, level, from, to);
        to
    }

    /// Where 2^−level intervals lead.
    fn after(&mut self, level: i64, from: &Place<T>) -> Place<T> {
        let maps = match from.1.iter().all(|part| part.is_zero()) {
            true => &mut self.free,
            false => &mut self.driven,
        };
        maps.at(level).apply(from)
    }

    fn put(&mut self, interval: f64, offset: f64, level: i64, from: Place<T>, to: Place<T>) {
        let length = (-level as f64).exp2();
        for (at, place) in [(offset, &from), (offset + length, &to)] {
            let value = self.form.value(&place.0).abs();
            if self.best < value {
                self.best = value;
                (self.interval, self.offset, self.place) = (interval, at, *place);
            }
        }
        let upper = self.form.bound(self.oscillator, length, &from, &to);
        self.parts.push(Part {
            upper,
            interval,
            offset,
            level,
            from,
            to,
        });
    }

    /// The largest value, to a relative 2^`digits`.
    pub(super) fn run(mut self, digits: i32) -> Largest<T> {
        let mut halvings = 0;
        let upper = loop {
            let Some(part) = self.parts.pop() else {
                break self.best;
            };
            let near = self.best + self.best.scale(digits.into());
            if part.upper <= near || halvings >= HALVINGS {
                break if part.upper < self.best {
                    self.best
                } else {
                    part.upper
                };
            }
            halvings += 1;
            let level = part.level + 1;
            let half = (-level as f64).exp2();
            let middle = self.after(level, &part.from);
            self.put(part.interval, part.offset, level, part.from, middle);
            self.put(part.interval, part.offset + half, level, middle, part.to);
        };
        let slope = self.form.slope(self.oscillator, &self.place);
        let later = -slope / self.form.curvature(self.oscillator, &self.place);
        // A peak at the end of an interval, or of what is straight there, has no root beside it.
        let reach = ((0.5 * f64::from(digits)).exp2() * 64.0 / self.oscillator.norm).min(0.5);
        let later = if later.abs() <= reach { later } else { 0.0 };
        let place = &self.place;
        let ends = if place.1.iter().all(|part| part.is_zero()) {
            f64::INFINITY
        } else {
            1.0
        };
        let at = self.offset + later;
        let [third, _] = self.form.higher(self.oscillator, 1.0, place);
        let digits = T::unit().to_f64().max(f64::EPSILON);
        Largest {
            lower: self.best,
            upper,
            time: self.interval + at * self.unit,
            unit: self.unit,
            turn: Turn {
                slope,
                curvature: self.form.curvature(self.oscillator, place),
                third,
                speed: self.oscillator.norm,
                rounding: 64.0 * digits * self.form.grain(self.oscillator, place),
                later,
                room: at.min(ends - at),
            },
        }
    }
}
