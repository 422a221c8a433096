//! The motion between the instants, followed as closely as its shape asks for: in doubles, or with twice their digits.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use eigentone_digits::{DoubleDouble, Magnitude, Real};

use super::driven::Driven;
use super::generator::Generator;
use super::march::{Step, Walker};
use super::products::{Columns, multiply};
use super::quintic::{Quintic, turn_of};
use super::remainder::Remainder;
use super::stepper::{Stepper, is_quick};
use crate::enclosed::{Halves, Normed};
use crate::exponential::by_taylor;
use crate::problem::{Instant, Leg, Problem, Walk};

/// With how many digits states and loads are taken from one place to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Digits {
    /// In doubles: what is small beside 1e-13 of the largest displacement is lost.
    Once,
    /// In double-double, each quantity rounded to a double by itself at last.
    Twice,
}

/// A moment of the motion, in doubles: what is followed, with its first and second derivatives. What is followed are the
/// displacements of all coordinates and, where asked for, what the problem asks for beside them: accelerations,
/// combinations, forces.
#[derive(Clone, Debug)]
pub(crate) struct Point {
    count: usize,
    /// All quantities, then their first and their second derivatives, then states and loads.
    values: Vec<f64>,
    /// States and loads once more, where more digits are taken.
    more: Vec<DoubleDouble>,
    /// The 2-norms of states and of loads.
    sizes: [f64; 2],
}

impl Point {
    /// The displacement of a coordinate, or another quantity.
    pub(crate) fn x(&self, i: usize) -> f64 {
        self.values[i]
    }

    /// Its velocity.
    pub(crate) fn v(&self, i: usize) -> f64 {
        self.values[self.count + i]
    }

    /// Its acceleration.
    pub(crate) fn a(&self, i: usize) -> f64 {
        self.values[2 * self.count + i]
    }

    /// A quantity and its derivatives.
    fn knot(&self, i: usize) -> [f64; 3] {
        [self.x(i), self.v(i), self.a(i)]
    }

    fn states(&self) -> States<'_> {
        (&self.values[3 * self.count..], &self.more)
    }
}

/// States and loads, and the same where more digits are taken.
type States<'a> = (&'a [f64], &'a [DoubleDouble]);

/// A short stretch of time in which each quantity is a polynomial of degree five
/// to about nine digits: that of its value and first two derivatives at both ends.
pub(crate) struct Stretch<'a> {
    /// When it begins, in s.
    pub(crate) start: f64,
    /// In s.
    pub(crate) length: f64,
    pub(crate) left: &'a Point,
    pub(crate) right: &'a Point,
    /// By how much the polynomials missed what they were tried at.
    missed: &'a [f64],
    /// Whether each quantity may show something new; all may where there is nothing. What may not, and so is not where the
    /// extrema or the edges of bands are, may be at the ends as it was some time before.
    asked: &'a [bool],
    /// [`Remainder::sizes`] of a stretch that it is part of.
    sizes: [f64; 2],
    way: &'a mut Way,
    /// It is the way halved so many times.
    depth: usize,
}

/// What a motion is shown to, stretch by stretch.
pub(crate) trait Viewer {
    /// Whether a quantity may show something new on a stretch, where it and its derivative are no farther than so much from its
    /// polynomial and the derivative of that.
    fn asks(&self, stretch: &Stretch<'_>, i: usize, off: [f64; 2]) -> bool;

    /// Looks at a stretch on which all that may show something new is as good as its polynomials.
    fn see(&mut self, stretch: &mut Stretch<'_>);
}

/// Looks at everything.
impl<F: FnMut(&mut Stretch<'_>)> Viewer for F {
    fn asks(&self, _: &Stretch<'_>, _: usize, _: [f64; 2]) -> bool {
        true
    }

    fn see(&mut self, stretch: &mut Stretch<'_>) {
        self(stretch);
    }
}

impl Stretch<'_> {
    /// Whether a quantity may show something new; else its polynomial is known to be near enough to show that it does not.
    pub(crate) fn is_asked(&self, i: usize) -> bool {
        self.asked.get(i).is_none_or(|asked| *asked)
    }

    /// Which of so many quantities may show something new.
    fn asked_by(&self, viewer: &dyn Viewer, count: usize) -> Vec<bool> {
        let remainder = self.way.outputs.remainder();
        let off = remainder.along(self.length, self.sizes);
        let asks = |i| self.is_asked(i) && viewer.asks(self, i, off(i));
        (0..count).map(asks).collect()
    }

    /// A quantity by the fraction of the stretch.
    pub(crate) fn polynomial(&self, i: usize) -> Quintic {
        Quintic::between(self.left.knot(i), self.right.knot(i), self.length)
    }

    /// What this polynomial does not fall below, and what it does not exceed.
    pub(crate) fn limits(&self, i: usize) -> [f64; 2] {
        Quintic::limits(self.left.knot(i), self.right.knot(i), self.length)
    }

    /// What the velocity by this polynomial does not exceed in size.
    pub(crate) fn speed_limit(&self, i: usize) -> f64 {
        Quintic::speed_limit(self.left.knot(i), self.right.knot(i), self.length)
    }

    /// How far a quantity may be from its polynomial, as far as a place between the ends has shown: an estimate.
    pub(crate) fn off(&self, i: usize) -> f64 {
        self.missed.get(i).copied().unwrap_or(0.0) + self.rounding(i)
    }

    /// Shows both halves, one after the other.
    pub(crate) fn halves(&mut self, visit: &mut dyn FnMut(&mut Stretch<'_>)) {
        self.way.halvings += 1;
        let middle = self.way.point(self.left, self.depth + 1, self.asked);
        self.split(&middle, self.missed, &mut |half| {
            visit(half);
            Some(())
        });
    }

    /// The same, given what lies between them and by how much polynomials missed it, until one leads to `None`.
    fn split(
        &mut self,
        middle: &Point,
        missed: &[f64],
        visit: &mut dyn FnMut(&mut Stretch<'_>) -> Option<()>,
    ) -> Option<()> {
        let length = self.length / 2.0;
        for (start, left, right) in [
            (self.start, self.left, middle),
            (self.start + length, middle, self.right),
        ] {
            visit(&mut Stretch {
                start,
                length,
                left,
                right,
                missed,
                asked: self.asked,
                sizes: self.sizes,
                way: &mut *self.way,
                depth: self.depth + 1,
            })?;
        }
        Some(())
    }

    /// How far rounding may have moved a quantity, as steps in energy coordinates lengthen no error: an estimate.
    pub(crate) fn rounding(&self, i: usize) -> f64 {
        let outputs = &self.way.outputs;
        let made = outputs.rounding + outputs.rate * (self.start + self.length);
        let parts = outputs.norms[i]
            .iter()
            .zip(&outputs.off[i])
            .zip(&self.left.sizes);
        parts
            .map(|((norm, off), size)| (made * norm + off) * size)
            .sum()
    }

    /// Where a quantity's first or second derivative changes sign, as it does between the ends: the time, and the quantity or
    /// its first derivative there, which is largest or smallest; and how far the quantity may be off.
    pub(crate) fn turn(&mut self, i: usize, derivative: usize) -> (f64, f64, f64) {
        // Nearly always it is where the polynomial has it, which leaves half of the products.
        let slope = self.polynomial(i).slope();
        let guess = match derivative {
            1 => slope.zero(),
            _ => slope.turn().0,
        };
        let (mut start, mut length, mut knots) = self.part(i, derivative, Some(guess));
        let is_up = |knot: &[f64; 3]| knot[derivative] > 0.0;
        let is_high = is_up(&self.left.knot(i));
        if [&knots[0], &knots[2]].map(is_up) != [is_high, !is_high] {
            (start, length, knots) = self.part(i, derivative, None);
        }
        let (s, value, off) = turn_of(&knots, derivative, length);
        (start + s * length, value, off)
    }

    /// The small part of the stretch in which there is a guess, or a derivative changes sign as it does between the ends: when it
    /// begins, its length in s, and the quantity at its beginning, middle and end.
    fn part(
        &mut self,
        i: usize,
        derivative: usize,
        guess: Option<f64>,
    ) -> (f64, f64, [[f64; 3]; 3]) {
        /// After so many halvings, each of which is exact, velocities are of degree five but for less than rounding.
        const HALVINGS: usize = 4;
        let is_up = self.left.knot(i)[derivative] > 0.0;
        let (states, more) = self.left.states();
        let (mut states, mut more) = (states.to_vec(), more.to_vec());
        let mut later = states.clone();
        let (mut start, mut part) = (0.0, 1.0);
        for depth in self.depth + 1..=self.depth + HALVINGS {
            part /= 2.0;
            if guess.is_some_and(|guess| guess < start + part) {
                continue;
            }
            self.way.halvings += 1;
            let later_more = self.way.advance((&states, &more), depth, &mut later);
            if guess.is_none() {
                let middle = self.way.outputs.knot((&later, &later_more), i);
                if (middle[derivative] > 0.0) != is_up {
                    continue;
                }
            }
            std::mem::swap(&mut states, &mut later);
            more = later_more;
            start += part;
        }
        let mut knots = [self.way.outputs.knot((&states, &more), i); 3];
        for knot in &mut knots[1..] {
            self.way.halvings += 1;
            let depth = self.depth + HALVINGS + 1;
            more = self.way.advance((&states, &more), depth, &mut later);
            std::mem::swap(&mut states, &mut later);
            *knot = self.way.outputs.knot((&states, &more), i);
        }
        (self.start + start * self.length, part * self.length, knots)
    }
}

/// From one stop of the march to the next, and its halves, quarters, ….
struct Way {
    outputs: Arc<Outputs>,
    /// The states and loads after each half of the way, as matrices by rows.
    halves: Vec<Vec<f64>>,
    /// The same, where more digits are taken.
    more: Vec<Columns<DoubleDouble>>,
    /// How often searches for turns have halved it.
    halvings: u64,
    /// Makes them; `None` for a way of no length.
    make: Option<Arc<Halves<DoubleDouble>>>,
    /// The whole way, for the march; `None` until it is made.
    whole: Option<Step<DoubleDouble>>,
}

/// What is followed, from states and loads.
struct Outputs {
    count: usize,
    /// All quantities, then their first and their second derivatives, by rows.
    rows: Vec<f64>,
    /// The same, where more digits are taken, and once more by columns, order by order.
    more: Vec<DoubleDouble>,
    columns: Vec<Columns<DoubleDouble>>,
    /// How many entries of a row belong to states.
    states: usize,
    /// Those of [`Generator::levels`].
    levels: Vec<Range<usize>>,
    /// How far each quantity may be off beside the 2-norms of states and of loads: by the error of its row, which is all there
    /// is where the exact entries cancel.
    off: Vec<[f64; 2]>,
    /// The 2-norms of the parts of its row, and how far states and loads may be off, about, beside their own: by what
    /// some fifty halvings round, and with more digits by what is not known of the generator, for each second.
    norms: Vec<[f64; 2]>,
    rounding: f64,
    rate: f64,
    /// W by rows, and what bounds remainders once it is asked for.
    w: Vec<f64>,
    remainder: OnceLock<Remainder>,
}

impl Outputs {
    /// The displacements of the coordinates and, if `beside`, what the problem asks for beside them.
    fn of(
        problem: &Problem<'_>,
        generator: &Generator<DoubleDouble>,
        beside: bool,
        digits: Digits,
    ) -> Outputs {
        const HALVINGS: f64 = 64.0;
        let [x, v, a] = &generator.outputs;
        let mut orders = [&x.rows, &v.rows, &a.rows].map(|rows| rows.clone());
        let mut off = x.off.clone();
        if beside {
            let accelerations = a.rows.iter().filter(|_| problem.wants_acceleration());
            let combinations = generator.combinations.iter().flat_map(|one| &one.rows);
            let wanted = a.off.iter().filter(|_| problem.wants_acceleration());
            off.extend(wanted.chain(generator.combinations.iter().flat_map(|one| &one.off)));
            for row in accelerations.chain(combinations) {
                let rate = derivative(row, &generator.w);
                orders[2].push(derivative(&rate, &generator.w));
                orders[1].push(rate);
                orders[0].push(row.clone());
            }
        }
        let rows = || orders.iter().flatten().flatten();
        let size = generator.w.len();
        let (mut more, mut columns) = (Vec::new(), Vec::new());
        let (unit, rate) = match digits {
            Digits::Once => (f64::EPSILON, 0.0),
            Digits::Twice => {
                let by_columns = |rows: &Vec<Vec<DoubleDouble>>| {
                    Columns::of(rows.len(), size, |i, j| rows[i][j])
                };
                columns.extend(orders.iter().map(by_columns));
                more.extend(rows().copied());
                let rate = generator.w.error().to_f64();
                (DoubleDouble::unit().to_f64(), rate)
            }
        };
        let rows: Vec<f64> = rows().map(|entry| entry.to_f64()).collect();
        let states = generator.states;
        let count = orders[0].len();
        let norms = (0..count).map(|i| sizes(&rows[i * size..][..size], states));
        let w = generator.w.entries().iter().map(|entry| entry.to_f64());
        Outputs {
            count,
            off: off.iter().map(|off| off.map(Magnitude::to_f64)).collect(),
            norms: norms.collect(),
            rounding: HALVINGS * unit,
            rate,
            w: w.collect(),
            remainder: OnceLock::new(),
            rows,
            more,
            columns,
            states,
            levels: generator.levels.clone(),
        }
    }

    fn remainder(&self) -> &Remainder {
        self.remainder.get_or_init(|| {
            let second = &self.rows[self.rows.len() / 3 * 2..];
            Remainder::of(self.count, second, &self.w, self.states)
        })
    }

    /// So many quantities, from room for them and their derivatives, then states and loads, and those with more digits
    /// where they are taken. Those that are not `asked` for may be left as they are.
    fn read(
        &self,
        count: usize,
        asked: &[bool],
        mut values: Vec<f64>,
        more: Vec<DoubleDouble>,
    ) -> Point {
        let (quantities, states) = values.split_at_mut(3 * count);
        let size = states.len();
        let mut exact = vec![DoubleDouble::ZERO; if more.is_empty() { 0 } else { self.count }];
        for derivative in 0..3 {
            let mut quantities = &mut quantities[derivative * count..][..count];
            if more.is_empty() {
                let mut rows = &self.rows[derivative * self.count * size..];
                for run in asked.chunk_by(|one, next| one == next) {
                    let (now, later) = quantities.split_at_mut(run.len());
                    if run[0] {
                        multiply(rows, states, now);
                    }
                    (quantities, rows) = (later, &rows[run.len() * size..]);
                }
                multiply(rows, states, quantities);
            } else {
                self.columns[derivative].apply(&more, &mut exact);
                let exact = quantities.iter_mut().zip(&exact);
                exact.for_each(|(value, exact)| *value = exact.to_f64());
            }
        }
        Point {
            count,
            sizes: sizes(states, self.states),
            values,
            more,
        }
    }

    /// One quantity alone, with its derivatives.
    fn knot(&self, (states, more): States<'_>, i: usize) -> [f64; 3] {
        let size = states.len();
        [0, 1, 2].map(|derivative| {
            let row = (derivative * self.count + i) * size..;
            if more.is_empty() {
                let mut value = [0.0];
                multiply(&self.rows[row][..size], states, &mut value);
                value[0]
            } else {
                let terms = self.more[row].iter().zip(more).map(|(a, b)| *a * *b);
                terms
                    .fold(DoubleDouble::ZERO, |sum, term| sum + term)
                    .to_f64()
            }
        })
    }
}

/// The 2-norms of the states and of the loads in a row, or of themselves.
fn sizes(row: &[f64], states: usize) -> [f64; 2] {
    let (states, loads) = row.split_at(states);
    [states, loads].map(|part| part.iter().map(|x| x * x).sum::<f64>().sqrt())
}

/// The rate of a row: (cᵀζ)′ = cᵀWζ.
fn derivative(row: &[DoubleDouble], w: &Normed<DoubleDouble>) -> Vec<DoubleDouble> {
    let mut rate = vec![DoubleDouble::ZERO; row.len()];
    for (i, factor) in row
        .iter()
        .enumerate()
        .filter(|(_, factor)| !factor.is_zero())
    {
        for (sum, entry) in rate.iter_mut().zip(w.row(i)) {
            *sum += *factor * *entry;
        }
    }
    rate
}

impl Way {
    fn of(outputs: &Arc<Outputs>, make: Option<Arc<Halves<DoubleDouble>>>) -> Way {
        Way {
            outputs: Arc::clone(outputs),
            halves: Vec::new(),
            more: Vec::new(),
            halvings: 0,
            make,
            whole: None,
        }
    }

    /// The states 2^-depth of the way later, and those with more digits.
    fn advance(
        &mut self,
        (states, more): States<'_>,
        depth: usize,
        later: &mut [f64],
    ) -> Vec<DoubleDouble> {
        if self.halves.len() <= depth {
            self.halve(depth, states.len());
        }
        let mut later_more = vec![DoubleDouble::ZERO; more.len()];
        if let Some(half) = self.more.get(depth) {
            half.apply(more, &mut later_more);
            let rounded = later.iter_mut().zip(&later_more);
            rounded.for_each(|(later, exact)| *later = exact.to_f64());
        } else {
            multiply(&self.halves[depth], states, later);
        }
        later_more
    }

    /// What is followed, so much later; what is not `asked` for may be as it was.
    fn point(&mut self, from: &Point, depth: usize, asked: &[bool]) -> Point {
        let mut values = from.values.clone();
        let more = self.advance(from.states(), depth, &mut values[3 * from.count..]);
        self.outputs.read(from.count, asked, values, more)
    }

    /// As far as the depth.
    fn halve(&mut self, depth: usize, size: usize) {
        let Some(make) = self.make.clone() else {
            return self.halves.resize(depth + 1, vec![f64::NAN; size * size]);
        };
        if self.halves.is_empty() {
            self.begin(&make.squares());
        }
        for depth in self.halves.len()..=depth {
            if self.outputs.more.is_empty() {
                let (half, _) = by_taylor(make.exponent(depth).as_ref());
                let entries = (0..size * size).map(|entry| half[(entry / size, entry % size)]);
                self.halves.push(entries.collect());
            } else {
                self.know(&make.at(depth));
            }
        }
    }

    /// The whole way, its half, ….
    fn begin(&mut self, squares: &[Normed<DoubleDouble>]) {
        let whole = squares.first().cloned();
        self.whole = whole.map(|power| Step::of(power, &self.outputs.levels));
        squares.iter().for_each(|power| self.know(power));
    }

    /// Adds the next half.
    fn know(&mut self, power: &Normed<DoubleDouble>) {
        let entries = power.entries();
        self.halves
            .push(entries.iter().map(|entry| entry.to_f64()).collect());
        if !self.outputs.more.is_empty() {
            let size = power.len();
            let entry = |i, j| entries[i * size + j];
            self.more.push(Columns::of(size, size, entry));
        }
    }
}

/// How finely the motion is divided.
struct Limits {
    /// The largest size of each quantity so far.
    range: Vec<f64>,
    /// How many of them are displacements.
    displacements: usize,
    /// How many stretches may be looked at.
    most: u64,
    /// How many have been.
    seen: u64,
    /// How many there were when it was last asked how many there will be, and where that was, in s.
    sampled: (u64, f64),
    /// How many halvings are left for searches for turns: at first twice as many as stretches.
    halvings: u64,
    /// The end of the motion, in s.
    end: f64,
}

impl Limits {
    /// Counts a stretch from `start` s on. `None` once there are too many, or the last ones show that there will be.
    fn count(&mut self, start: f64) -> Option<()> {
        const SAMPLE: u64 = 32;
        self.seen += 1;
        let (seen, last) = self.sampled;
        if self.seen - seen > self.most / SAMPLE {
            let left = (self.seen - seen) as f64 * ((self.end - start) / (start - last));
            if self.seen as f64 + left > self.most as f64 {
                return None;
            }
            self.sampled = (self.seen, start);
        }
        (self.seen <= self.most).then_some(())
    }

    /// Counts the halvings that searches for turns took. `None` once there are too many.
    fn count_halvings(&mut self, way: &mut Way) -> Option<()> {
        self.halvings = self
            .halvings
            .checked_sub(std::mem::take(&mut way.halvings))?;
        Some(())
    }

    /// Widens the ranges by a point.
    fn see(&mut self, point: &Point) {
        for (i, range) in self.range.iter_mut().enumerate() {
            *range = range.max(point.x(i).abs());
        }
    }
}

/// The most products that following a motion may take: seconds.
pub(crate) const PRODUCTS: f64 = 6e9;
/// Beside the range of a coordinate, a difference below this does not show.
pub(crate) const INVISIBLE: f64 = 1e-9;
/// Beside the range of all coordinates, a difference below this is rounding.
pub(crate) const ROUNDING: f64 = 1e-13;

/// Follows the motion of a problem, as often as it is asked for.
pub(crate) struct Follower<'a, 'b> {
    problem: &'a Problem<'b>,
    prepared: Vec<Prepared>,
}

/// What it takes to follow a motion with so many digits, and what is known of it so far.
struct Prepared {
    digits: Digits,
    /// Whether the quantities beside displacements are among the outputs.
    beside: bool,
    ways: Ways,
    /// States and loads at every so many instants.
    marks: Vec<Vec<DoubleDouble>>,
    apart: u64,
}

impl<'a, 'b> Follower<'a, 'b> {
    pub(crate) fn of(problem: &'a Problem<'b>) -> Follower<'a, 'b> {
        Follower {
            problem,
            prepared: Vec::new(),
        }
    }

    pub(crate) fn problem(&self) -> &'a Problem<'b> {
        self.problem
    }

    /// The same motion until another instant, with all that is known of it.
    pub(crate) fn until<'c>(self, problem: &'c Problem<'b>) -> Follower<'c, 'b> {
        let mut prepared = self.prepared;
        prepared.retain(|one| one.is_of(problem));
        Follower { problem, prepared }
    }

    /// Follows the motion from the instant `from` of the grid to its end, and shows every stretch in
    /// turn; the last one is the end itself, of no length, as loads that jump then leave it. Where the motion
    /// jumps, one stretch ends before the jump and the next begins after it. `range` is the largest displacement known of each
    /// coordinate and, where they are to be followed too, the largest size of the accelerations and of what sources the problem
    /// has, in this order. `None` where all stretches together would take more than so many `products`, where the motion is one
    /// of too many states, or 32 digits do not suffice to set out.
    pub(crate) fn follow(
        &mut self,
        from: u64,
        range: Vec<f64>,
        (digits, products): (Digits, f64),
        viewer: &mut dyn Viewer,
    ) -> Option<()> {
        let beside = range.len() > self.problem.system().len();
        let serves = |one: &Prepared| one.digits == digits && one.beside >= beside;
        let at = match self.prepared.iter().position(serves) {
            Some(at) => at,
            None => {
                self.prepared
                    .push(Prepared::of(self.problem, beside, digits)?);
                self.prepared.len() - 1
            }
        };
        self.prepared[at].follow(self.problem, from, range, products, viewer)
    }
}

impl Prepared {
    fn of(problem: &Problem<'_>, beside: bool, digits: Digits) -> Option<Prepared> {
        /// So many marks at most, and one.
        const MARKS: u64 = 256;
        let stepper = stepper(problem, digits)?;
        Some(Prepared {
            digits,
            beside,
            apart: problem.grid().last().div_ceil(MARKS).max(1),
            ways: Ways {
                outputs: Arc::new(Outputs::of(problem, &stepper.generator, beside, digits)),
                stepper: stepper.clone(),
                known: HashMap::new(),
            },
            marks: Vec::new(),
        })
    }

    /// Whether it serves another problem too.
    fn is_of(&self, problem: &Problem<'_>) -> bool {
        let generator = &self.ways.stepper.generator;
        stepper(problem, self.digits).is_some_and(|one| Arc::ptr_eq(&one.generator, generator))
    }

    fn follow(
        &mut self,
        problem: &Problem<'_>,
        from: u64,
        range: Vec<f64>,
        products: f64,
        viewer: &mut dyn Viewer,
    ) -> Option<()> {
        /// What a stretch takes beside its products, in products.
        const STRETCH: f64 = 100.0;
        let grid = problem.grid();
        let (last, count, size) = (
            grid.last(),
            range.len(),
            self.ways.stepper.generator.w.len(),
        );
        let costs = match self.digits {
            Digits::Once => 1.0,
            Digits::Twice => 32.0,
        };
        let each = costs * (size * (size + 3 * count)) as f64;
        let most = (products / (each + STRETCH)) as u64;
        let mut limits = Limits {
            range,
            displacements: problem.system().len(),
            most,
            halvings: most.saturating_mul(2),
            seen: 0,
            sampled: (0, grid.time(from.min(last))),
            end: grid.time(last),
        };
        let from = from.min(last);
        // From the last mark on; without marks at once to where something is to be seen.
        let apart = self.apart;
        let marks = self.marks.len() as u64;
        let mark = marks.checked_sub(1).map(|top| top.min(from / apart));
        let mut index = mark.map_or(from, |mark| mark * apart);
        let mut walk = Walk::of(problem);
        let mut walker = Walker::new(Driven::new(problem, self.ways.stepper.clone(), 0));
        walker.begin(0);
        if let Some(mark) = mark {
            let target = Instant::on_grid(grid, index);
            while let Some(leg) = walk.towards(&target) {
                if let Leg::Begin = leg {
                    walker.begin(walk.index());
                }
            }
            walker.put(&self.marks[mark as usize]);
        }
        loop {
            let target = Instant::on_grid(grid, index);
            while let Some(leg) = walk.towards(&target) {
                let Leg::Pass { from: now, to } = leg else {
                    walker.begin(walk.index());
                    continue;
                };
                let (start, finish) = (walker.moment(&now), walker.moment(&to));
                if mark.is_none() && index <= from {
                    walker.go(start, finish);
                    continue;
                }
                let (length, error) = walker.seconds(start, finish);
                let left = self.here(walker.exact(), count);
                let way = self.ways.of(length, error)?;
                let right = way.point(&left, 0, &[]);
                if index > from {
                    let mut stretch = Stretch {
                        start: now.time().to_f64(),
                        length: length.to_f64(),
                        left: &left,
                        right: &right,
                        missed: &[],
                        asked: &[],
                        sizes: [0.0; 2],
                        way,
                        depth: 0,
                    };
                    divide(&mut stretch, &mut limits, viewer)?;
                }
                if let Some(whole) = &way.whole {
                    walker.hop(whole, finish);
                }
            }
            if index == self.marks.len() as u64 * apart {
                self.marks.push(walker.exact().to_vec());
            }
            if index == last {
                // What the loads make of the end itself.
                let here = self.here(walker.exact(), count);
                viewer.see(&mut Stretch {
                    start: target.time().to_f64(),
                    length: 0.0,
                    left: &here,
                    right: &here,
                    missed: &[],
                    asked: &[],
                    sizes: [0.0; 2],
                    way: &mut Way::of(&self.ways.outputs, None),
                    depth: 0,
                });
                return Some(());
            }
            index += 1;
        }
    }

    /// Where the march is.
    fn here(&self, exact: &[DoubleDouble], count: usize) -> Point {
        let mut values = vec![0.0; 3 * count];
        values.extend(exact.iter().map(|entry| entry.to_f64()));
        let more = match self.digits {
            Digits::Once => Vec::new(),
            Digits::Twice => exact.to_vec(),
        };
        self.ways.outputs.read(count, &[], values, more)
    }
}

/// That of a problem, for so many digits; `None` where it takes long, or 32 digits do not suffice to set out.
fn stepper(problem: &Problem<'_>, digits: Digits) -> Option<Stepper<DoubleDouble>> {
    /// What the generator may lose of more digits.
    const LEAST: f64 = 1e-26;
    let lost = match digits {
        Digits::Once => ROUNDING,
        Digits::Twice => LEAST,
    };
    is_quick(problem).then(|| Stepper::precise(problem, lost))?
}

/// The ways that are known.
struct Ways {
    stepper: Stepper<DoubleDouble>,
    outputs: Arc<Outputs>,
    /// By their lengths in s.
    known: HashMap<[u64; 2], Way>,
}

impl Ways {
    /// One so many seconds long, which are known to an error. `None` beyond the range of doubles.
    fn of(&mut self, length: DoubleDouble, error: Magnitude) -> Option<&mut Way> {
        /// So many of unlike lengths are kept.
        const MOST: usize = 64;
        if self.known.len() > MOST {
            self.known.clear();
        }
        let rounded = length.to_f64();
        let rest = (length - DoubleDouble::from(rounded)).to_f64();
        Some(match self.known.entry([rounded, rest].map(f64::to_bits)) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(free) => {
                let unit = self.stepper.unit.as_ref();
                free.insert(match unit.and_then(|unit| unit.known(length)) {
                    Some(chain) => {
                        let halves = Arc::clone(&chain.halves);
                        let mut way = Way::of(&self.outputs, Some(halves));
                        way.begin(&chain.squares);
                        way
                    }
                    None => {
                        let w = &self.stepper.generator.w;
                        let halves = Halves::of(w, length, error / length.magnitude())?;
                        Way::of(&self.outputs, Some(Arc::new(halves)))
                    }
                })
            }
        })
    }
}

/// Shows the halves of a stretch, or divides them, until the polynomials of all that may show something new meet the motion.
fn divide(stretch: &mut Stretch<'_>, limits: &mut Limits, viewer: &mut dyn Viewer) -> Option<()> {
    const DEEPEST: usize = 40;
    /// After so many halvings what moves may have decayed.
    const ANEW: usize = 4;
    limits.count(stretch.start)?;
    if stretch.depth.is_multiple_of(ANEW) {
        let remainder = stretch.way.outputs.remainder();
        stretch.sizes = remainder.sizes(stretch.length, stretch.left.states().0);
    }
    let asked = stretch.asked_by(viewer, limits.range.len());
    let stretch = &mut Stretch {
        asked: &asked,
        way: &mut *stretch.way,
        ..*stretch
    };
    if !asked.contains(&true) {
        viewer.see(stretch);
        return Some(());
    }
    let depth = stretch.depth + 1;
    let middle = stretch.way.point(stretch.left, depth, &asked);
    limits.see(&middle);
    let displacements = &limits.range[..limits.displacements];
    let all = displacements.iter().copied().fold(0.0, f64::max);
    let (p, q, h) = (stretch.left, stretch.right, stretch.length);
    let mut missed = vec![0.0; asked.len()];
    let mut open = (0..asked.len()).filter(|i| asked[*i]);
    let meets = open.all(|i| {
        let speed = 1.875 * (q.x(i) - p.x(i)) - 0.4375 * h * (p.v(i) + q.v(i))
            + 0.03125 * h * h * (q.a(i) - p.a(i));
        let off = (middle.x(i) - stretch.polynomial(i).at(0.5)).abs();
        let turn = (h * middle.v(i) - speed).abs();
        let off = off.max(turn / 8.0);
        missed[i] = off;
        let hidden = || match i < limits.displacements && p.more.is_empty() {
            true => ROUNDING * all,
            // Of whatever unit, or size beside the others.
            false => stretch.rounding(i),
        };
        off <= INVISIBLE * limits.range[i] || off <= hidden()
    });
    stretch.split(&middle, &missed, &mut |part| {
        if meets {
            viewer.see(part);
            limits.count_halvings(part.way)
        } else if depth < DEEPEST {
            divide(part, limits, viewer)
        } else {
            None
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Harmonic, Hold, Impulse, Ramp, Response, Samples};
    use eigentone_modes::{GROUND, System};

    /// From where marks lead as from the start, under loads that are in the midst of their laws there.
    #[test]
    fn what_is_followed_again_is_the_same() {
        let system = System::builder().mass("a", 1.0).mass("b", 2.0);
        let system = system.spring(GROUND, "a", 30.0).spring("a", "b", 20.0);
        let system = system.damper("a", "b", 0.3).build().expect("a system");
        let samples = Samples {
            step: 0.07,
            values: (0..40).map(|k| f64::from(k % 7) - 2.5).collect(),
            hold: Hold::First,
        };
        let ask = Response::of(&system).load("a", samples);
        let ask = ask.load("b", Ramp::of(0.7).starting_at(0.33));
        let ask = ask.load("a", Harmonic::of(2.0, 5.0));
        let ask = ask.load("b", Impulse::of(1.5).at(1.25));
        let problem = ask.every(0.01).until(4.0).problem().expect("a problem");
        for digits in [Digits::Once, Digits::Twice] {
            let ends = |follower: &mut Follower<'_, '_>, from: u64| {
                let mut ends = Vec::new();
                let found = follower.follow(
                    from,
                    vec![1.0; 2],
                    (digits, 1e9),
                    &mut |stretch: &mut Stretch<'_>| {
                        ends.push([stretch.start, stretch.right.x(0), stretch.right.v(1)]);
                    },
                );
                found.expect("it can be followed");
                ends
            };
            let mut again = Follower::of(&problem);
            let all = ends(&mut again, 0);
            for from in [1, 57, 126, 333, 400] {
                let (marked, anew) = (
                    ends(&mut again, from),
                    ends(&mut Follower::of(&problem), from),
                );
                assert_eq!(marked.len(), anew.len());
                let end = &all[all.len() - anew.len()..];
                for ((marked, anew), all) in marked.iter().zip(&anew).zip(end) {
                    for ((marked, anew), all) in marked.iter().zip(anew).zip(all) {
                        assert!((marked - anew).abs() < 1e-13, "{from}: {marked} {anew}");
                        assert!((marked - all).abs() < 1e-13, "{from}: {marked} {all}");
                    }
                }
            }
        }
    }
}
