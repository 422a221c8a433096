//! The motion between the instants, followed as closely as its shape asks for: in doubles, or with twice their digits.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;

use eigentone_digits::{DoubleDouble, Magnitude, Real, Wide};
use pulp::Arch;

use super::driven::Driven;
use super::generator::Generator;
use super::march::Walker;
use crate::enclosed::{Halves, Normed};
use crate::problem::{Instant, Leg, Problem, Walk};

/// With how many digits states and loads are taken from one place to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Digits {
    /// In doubles: what is small beside 1e-13 of the largest displacement is lost.
    Once,
    /// In double-double, each quantity rounded to a double by itself at last.
    Twice,
}

/// A moment of the motion, in doubles: what is followed with its first and second derivatives, then states and
/// loads. What is followed are the displacements of all coordinates and, where asked for, what the problem asks for beside
/// them: accelerations, combinations, forces.
#[derive(Clone, Debug)]
pub(crate) struct Point {
    count: usize,
    values: Vec<f64>,
    /// States and loads once more, where more digits are taken.
    more: Vec<DoubleDouble>,
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

    fn zeta(&self) -> &[f64] {
        &self.values[3 * self.count..]
    }
}

/// A short stretch of time in which each quantity is a polynomial of degree five
/// to about nine digits: that of its value and first two derivatives at both ends.
pub(crate) struct Stretch<'a> {
    /// When it begins, in s.
    pub(crate) start: f64,
    /// In s.
    pub(crate) length: f64,
    pub(crate) left: &'a Point,
    pub(crate) right: &'a Point,
    way: &'a mut Way,
    /// It is the way halved so many times.
    depth: usize,
}

impl Stretch<'_> {
    /// A quantity at the fraction `s` of the stretch, by the polynomial.
    pub(crate) fn polynomial(&self, i: usize, s: f64) -> f64 {
        let highest_first = self.coefficients(i).into_iter().rev();
        highest_first.fold(0.0, |sum, coefficient| sum * s + coefficient)
    }

    /// The polynomial's value where its slope changes sign, as it does between the ends.
    pub(crate) fn turning_value(&self, i: usize) -> f64 {
        let coefficients = self.coefficients(i);
        let slope = |s: f64| {
            let powers = (1..6).rev();
            powers.fold(0.0, |sum, k| sum * s + k as f64 * coefficients[k])
        };
        let (mut low, mut high) = (0.0, 1.0);
        let rises = slope(low) > 0.0;
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            if (slope(middle) > 0.0) == rises {
                low = middle;
            } else {
                high = middle;
            }
        }
        self.polynomial(i, low)
    }

    /// Those of 1, s, s², … s⁵.
    fn coefficients(&self, i: usize) -> [f64; 6] {
        let (p, q, h) = (self.left, self.right, self.length);
        let (v, a) = (h * p.v(i), h * h * p.a(i));
        let rise = q.x(i) - p.x(i) - v - a / 2.0;
        let slope = h * q.v(i) - v - a;
        let bend = h * h * q.a(i) - a;
        [
            p.x(i),
            v,
            a / 2.0,
            10.0 * rise - 4.0 * slope + bend / 2.0,
            -15.0 * rise + 7.0 * slope - bend,
            6.0 * rise - 3.0 * slope + bend / 2.0,
        ]
    }

    /// How far rounding may have moved a quantity, as steps in energy coordinates lengthen no error: an estimate.
    pub(crate) fn rounding(&self, i: usize) -> f64 {
        self.way.rounding(self.left, i)
    }

    /// Time and point where `crossed` turns from false to true, as it does between the ends: found by
    /// bisection, each point of which is exact.
    pub(crate) fn bisect(&mut self, mut crossed: impl FnMut(&Point) -> bool) -> (f64, Point) {
        /// A stretch is divided no further than doubles distinguish its times.
        const HALVINGS: usize = 48;
        self.way.halvings += HALVINGS as u64;
        let mut at = self.left.clone();
        let (mut time, mut length) = (self.start, self.length);
        for depth in self.depth + 1..=self.depth + HALVINGS {
            length /= 2.0;
            let next = self.way.advance(&at, depth);
            if !crossed(&next) {
                time += length;
                at = next;
            }
        }
        (time, at)
    }
}

/// From one stop of the march to the next, and its halves, quarters, ….
struct Way {
    outputs: Arc<Outputs>,
    /// The states and loads after each half of the way, as matrices by rows.
    halves: Vec<Vec<f64>>,
    /// The same, where more digits are taken.
    more: Vec<Vec<DoubleDouble>>,
    /// How often bisections have halved it.
    halvings: u64,
    /// Makes them; `None` for a way of no length.
    make: Option<Halves<DoubleDouble>>,
}

/// What is followed, from states and loads.
struct Outputs {
    count: usize,
    /// All quantities, then their first and their second derivatives, by rows.
    rows: Vec<f64>,
    /// The same, where more digits are taken.
    more: Vec<DoubleDouble>,
    /// How many entries of a row belong to states.
    states: usize,
    /// What a value loses along some fifty halvings, about, in parts of what it is made of.
    rounding: f64,
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
        if beside {
            let accelerations = a.rows.iter().filter(|_| problem.wants_acceleration());
            let combinations = generator.combinations.iter().flat_map(|one| &one.rows);
            for row in accelerations.chain(combinations) {
                let rate = derivative(row, &generator.w);
                orders[2].push(derivative(&rate, &generator.w));
                orders[1].push(rate);
                orders[0].push(row.clone());
            }
        }
        let rows = || orders.iter().flatten().flatten();
        let end = problem.grid().time(problem.grid().last());
        let error = (generator.w.error() * Magnitude::from(end)).to_f64();
        let (more, rounding) = match digits {
            Digits::Once => (Vec::new(), HALVINGS * f64::EPSILON),
            Digits::Twice => {
                let unit = DoubleDouble::unit().to_f64();
                (rows().copied().collect(), HALVINGS * unit + error)
            }
        };
        Outputs {
            count: orders[0].len(),
            rows: rows().map(|entry| entry.to_f64()).collect(),
            more,
            states: generator.states,
            rounding,
        }
    }
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
    fn point(&self, zeta: &[f64]) -> Point {
        let count = self.outputs.count;
        let mut values = vec![0.0; 3 * count + zeta.len()];
        let (outputs, states) = values.split_at_mut(3 * count);
        states.copy_from_slice(zeta);
        multiply(&self.outputs.rows, states, outputs);
        Point {
            count,
            values,
            more: Vec::new(),
        }
    }

    /// With more digits.
    fn point_of_more(&self, zeta: Vec<DoubleDouble>) -> Point {
        let values = multiply_more(&self.outputs.more, &zeta);
        let values = values.iter().chain(&zeta).map(|value| value.to_f64());
        Point {
            count: self.outputs.count,
            values: values.collect(),
            more: zeta,
        }
    }

    /// Where the march is.
    fn here(&self, walker: &Walker<'_, '_, DoubleDouble>) -> Point {
        match self.outputs.more.is_empty() {
            true => self.point(&walker.rounded()),
            false => self.point_of_more(walker.exact().to_vec()),
        }
    }

    /// What rounding makes of a quantity along some fifty halvings, about.
    fn rounding(&self, point: &Point, i: usize) -> f64 {
        let zeta = point.zeta();
        let row = &self.outputs.rows[i * zeta.len()..][..zeta.len()];
        let length = |part: &[f64]| part.iter().map(|x| x * x).sum::<f64>().sqrt();
        let (states, loads) = row.split_at(self.outputs.states);
        let (own, driven) = zeta.split_at(self.outputs.states);
        self.outputs.rounding * (length(states) * length(own) + length(loads) * length(driven))
    }

    /// The point 2^-depth of the way later.
    fn advance(&mut self, from: &Point, depth: usize) -> Point {
        let zeta = from.zeta();
        if self.halves.len() <= depth {
            self.halve(depth, zeta.len());
        }
        if let Some(half) = self.more.get(depth) {
            return self.point_of_more(multiply_more(half, &from.more));
        }
        let mut later = vec![0.0; zeta.len()];
        multiply(&self.halves[depth], zeta, &mut later);
        self.point(&later)
    }

    /// As far as the depth.
    fn halve(&mut self, depth: usize, size: usize) {
        let Some(make) = &self.make else {
            return self.halves.resize(depth + 1, vec![f64::NAN; size * size]);
        };
        let mut powers = Vec::new();
        if self.halves.is_empty() {
            let mut power = make.at(make.ground());
            for _ in 0..make.ground() {
                let next = power.times(&power);
                powers.push(std::mem::replace(&mut power, next));
            }
            powers.push(power);
            powers.reverse();
        }
        for depth in self.halves.len() + powers.len()..=depth {
            powers.push(make.at(depth));
        }
        for power in &powers {
            let entries = power.entries().iter();
            self.halves
                .push(entries.map(|entry| entry.to_f64()).collect());
            if !self.outputs.more.is_empty() {
                self.more.push(power.entries().to_vec());
            }
        }
    }
}

/// The product of a matrix, by rows, and a vector, with more digits.
fn multiply_more(matrix: &[DoubleDouble], vector: &[DoubleDouble]) -> Vec<DoubleDouble> {
    let rows = matrix.chunks_exact(vector.len().max(1));
    let product = |row: &[DoubleDouble]| {
        let terms = row.iter().zip(vector).map(|(a, b)| *a * *b);
        terms.fold(DoubleDouble::ZERO, |sum, term| sum + term)
    };
    rows.map(product).collect()
}

/// The product of a matrix, by rows, and a vector.
fn multiply(matrix: &[f64], vector: &[f64], product: &mut [f64]) {
    const LANES: usize = 8;
    let rows = matrix.chunks_exact(vector.len().max(1));
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for (entry, row) in product.iter_mut().zip(rows) {
                let (row, rest) = row.as_chunks::<LANES>();
                let (heads, tail) = vector.as_chunks::<LANES>();
                let mut sums = [0.0; LANES];
                for (row, head) in row.iter().zip(heads) {
                    for lane in 0..LANES {
                        sums[lane] += row[lane] * head[lane];
                    }
                }
                let rest = rest.iter().zip(tail).map(|(a, b)| a * b);
                *entry = sums.into_iter().chain(rest).sum();
            }
        },
    );
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
    /// How many halvings are left for bisections: at first twice as many as stretches.
    halvings: u64,
    /// The end of the motion, in s.
    end: f64,
}

impl Limits {
    /// Counts a stretch from `start` s on. `None` once there are too many, or it shows that there will be: after
    /// a good number of them, by how far they have led.
    fn count(&mut self, start: f64) -> Option<()> {
        const SAMPLE: u64 = 32;
        self.seen += 1;
        let expected = self.seen as f64 / (start / self.end);
        let hopeless = self.seen > self.most / SAMPLE && expected > 4.0 * self.most as f64;
        (self.seen <= self.most && !hopeless).then_some(())
    }

    /// Counts the halvings that bisections took. `None` once there are too many.
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
pub(crate) const PRODUCTS: f64 = 4e9;
/// Beside the range of a coordinate, a difference below this does not show.
pub(crate) const INVISIBLE: f64 = 1e-9;
/// Beside the range of all coordinates, a difference below this is rounding.
pub(crate) const ROUNDING: f64 = 1e-13;

/// Follows the motion from the instant `from` of the grid to its end, and shows every stretch in
/// turn; the last one is the end itself, of no length, as loads that jump then leave it. Where the motion
/// jumps, one stretch ends before the jump and the next begins after it. `range` is the largest displacement known of each
/// coordinate and, where they are to be followed too, the largest size of the accelerations and of what sources the problem
/// has, in this order. `None` where all stretches together would take more than so many `products`, where the motion is one of
/// too many states, or 32 digits do not suffice to set out.
pub(crate) fn follow(
    problem: &Problem<'_>,
    from: u64,
    range: Vec<f64>,
    (digits, products): (Digits, f64),
    visit: &mut dyn FnMut(&mut Stretch<'_>),
) -> Option<()> {
    /// The most products that may be taken at the start.
    const MOST_AT_ONCE: f64 = 2e9;
    /// What the generator may lose of more digits.
    const LEAST: f64 = 1e-26;
    let grid = problem.grid();
    let end = grid.time(grid.last());
    let states = 2.0 * problem.system().len() as f64;
    if 64.0 * states.powi(3) > MOST_AT_ONCE {
        return None;
    }
    let mut generator = Generator::<DoubleDouble>::of::<DoubleDouble>(problem, &[])?;
    let (lost, costs) = match digits {
        Digits::Once => (ROUNDING, 1.0),
        Digits::Twice => (LEAST, 32.0),
    };
    if (generator.w.error() * Magnitude::from(end)).to_f64() > lost {
        generator = Generator::<DoubleDouble>::of::<Wide<4>>(problem, &[])?;
    }
    let w = generator.w.clone();
    let displacements = problem.system().len();
    let outputs = Outputs::of(problem, &generator, range.len() > displacements, digits);
    let outputs = Arc::new(outputs);
    let most = (products / costs / (w.len() * (w.len() + 3 * outputs.count)) as f64) as u64;
    let mut limits = Limits {
        range,
        displacements,
        most,
        halvings: most.saturating_mul(2),
        seen: 0,
        end,
    };
    let mut walker = Walker::new(Driven::new(problem, generator, 0));
    let way = |make| Way {
        outputs: Arc::clone(&outputs),
        halves: Vec::new(),
        more: Vec::new(),
        halvings: 0,
        make,
    };
    let mut known: HashMap<u64, Way> = HashMap::new();
    let mut walk = Walk::of(problem);
    walker.begin(0);
    let mut index = from.min(grid.last());
    loop {
        let target = Instant::on_grid(grid, index);
        while let Some(leg) = walk.towards(&target) {
            let Leg::Pass { from: now, to } = leg else {
                walker.begin(walk.index());
                continue;
            };
            let (start, finish) = (walker.moment(&now), walker.moment(&to));
            if index > from {
                let (length, error) = walker.seconds(start, finish);
                let way = match known.entry(length.to_f64().to_bits()) {
                    Entry::Occupied(known) => known.into_mut(),
                    Entry::Vacant(free) => {
                        let halves = Halves::of(&w, length, error / length.magnitude())?;
                        free.insert(way(Some(halves)))
                    }
                };
                let left = way.here(&walker);
                let right = way.advance(&left, 0);
                let mut stretch = Stretch {
                    start: now.time().to_f64(),
                    length: length.to_f64(),
                    left: &left,
                    right: &right,
                    way,
                    depth: 0,
                };
                divide(&mut stretch, &mut limits, visit)?;
                if known.len() > 64 {
                    known.clear();
                }
            }
            walker.go(start, finish);
        }
        if index == grid.last() {
            // What the loads make of the end itself.
            let mut way = way(None);
            let here = way.here(&walker);
            visit(&mut Stretch {
                start: target.time().to_f64(),
                length: 0.0,
                left: &here,
                right: &here,
                way: &mut way,
                depth: 0,
            });
            return Some(());
        }
        index += 1;
    }
}

/// Shows the halves of a stretch, or divides them, until their polynomials meet the motion.
fn divide(
    stretch: &mut Stretch<'_>,
    limits: &mut Limits,
    visit: &mut dyn FnMut(&mut Stretch<'_>),
) -> Option<()> {
    const DEEPEST: usize = 40;
    limits.count(stretch.start)?;
    let depth = stretch.depth + 1;
    let middle = stretch.way.advance(stretch.left, depth);
    limits.see(&middle);
    let displacements = &limits.range[..limits.displacements];
    let all = displacements.iter().copied().fold(0.0, f64::max);
    let (p, q, h) = (stretch.left, stretch.right, stretch.length);
    let meets = (0..limits.range.len()).all(|i| {
        let speed = 1.875 * (q.x(i) - p.x(i)) - 0.4375 * h * (p.v(i) + q.v(i))
            + 0.03125 * h * h * (q.a(i) - p.a(i));
        let off = (middle.x(i) - stretch.polynomial(i, 0.5)).abs();
        let turn = (h * middle.v(i) - speed).abs();
        let off = off.max(turn / 8.0);
        let hidden = || match i < limits.displacements && p.more.is_empty() {
            true => ROUNDING * all,
            // Of whatever unit, or size beside the others.
            false => stretch.rounding(i),
        };
        off <= INVISIBLE * limits.range[i] || off <= hidden()
    });
    let half = h / 2.0;
    for (start, left, right) in [
        (stretch.start, p, &middle),
        (stretch.start + half, &middle, q),
    ] {
        let mut part = Stretch {
            start,
            length: half,
            left,
            right,
            way: &mut *stretch.way,
            depth,
        };
        if meets {
            visit(&mut part);
            limits.count_halvings(part.way)?;
        } else if depth < DEEPEST {
            divide(&mut part, limits, visit)?;
        } else {
            return None;
        }
    }
    Some(())
}
