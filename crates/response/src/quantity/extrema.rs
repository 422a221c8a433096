//! The extrema of a motion, its largest velocities, and when it settles, between the instants too.

use eigentone_modes::ElementKind;

use crate::answer::Trajectory;
use crate::certified::ByCertifiedExponential;
use crate::certified::follow::{Digits, Follower, INVISIBLE, PRODUCTS, ROUNDING, Stretch, Viewer};
use crate::problem::{Piece, Problem};

/// The highest and the lowest displacement of each coordinate, and its largest velocity, from 0 to the
/// end, at any time and not only at the instants of the grid; and the same of all that the problem asks for beside them:
/// accelerations, combinations, forces in springs and dampers.
///
/// Between the instants the exact solution is halved until it is, to nine digits of its range, a
/// polynomial of degree five through displacement, velocity and acceleration at both ends; so is what is asked for beside
/// it, with its own derivatives. Stretches on which nothing can go beyond what the instants show, by a bound of the sixth derivatives, are
/// left whole. An extremum is then where the velocity or acceleration changes sign, of polynomials through exact values on a
/// sixteenth of the stretch. All is done in doubles, from
/// steps that are right to their last digits: values are good to about 12 digits, and times to half of
/// them, for there a motion is flat. [`ByCertifiedExponential::at`](crate::ByCertifiedExponential::at)
/// gives the displacement at such a time with a proven bound.
///
/// ```
/// use eigentone_modes::{GROUND, System};
/// use eigentone_response::{Extrema, Response, State};
///
/// let system = System::builder().mass("m", 1.0).spring(GROUND, "m", 1.0).build()?;
/// let from = State::at_rest().push("m", 3.0);
/// let problem = Response::of(&system).from(from).every(1.0).until(6.0).problem()?;
/// let trajectory = eigentone_response::ResponsePlan::of(&problem)?.run(&problem)?;
/// let extrema = Extrema::of(&problem, &trajectory).expect("it is easily followed");
/// let highest = extrema.highest()[0];
/// assert!((highest.displacement - 3.0).abs() < 1e-12);
/// assert!((highest.time - std::f64::consts::FRAC_PI_2).abs() < 1e-6);
/// assert_eq!((extrema.fastest()[0].velocity, extrema.fastest()[0].time), (3.0, 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Extrema {
    highest: Vec<Extremum>,
    lowest: Vec<Extremum>,
    fastest: Vec<Fastest>,
    jumps: Vec<Vec<Jump>>,
    beside: Option<Beside>,
    digits: Digits,
    /// How far displacements may be off, about.
    roundings: Vec<f64>,
}

/// Of what is asked for beside displacements.
#[derive(Clone, Debug, PartialEq)]
struct Beside {
    accelerations: Vec<Peaks>,
    outputs: Vec<Peaks>,
    /// Of springs and of dampers.
    forces: [Vec<Peaks>; 2],
}

/// The highest and the lowest value of a quantity. At events both the value before and the one after count.
#[derive(Clone, Debug, PartialEq)]
pub struct Peaks {
    /// The highest.
    pub highest: Reached,
    /// The lowest.
    pub lowest: Reached,
    /// Where it changes at once after t = 0, in the order of time: the first thousand that show in nine digits.
    pub jumps: Vec<Discontinuity>,
}

/// A value that changes at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Discontinuity {
    /// When, in s.
    pub time: f64,
    /// Before and after it, in the unit of the quantity.
    pub values: [f64; 2],
}

/// So many jumps of one quantity are noted.
const MOST_JUMPS: usize = 1000;

/// A value and when it is reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reached {
    /// In the unit of the quantity.
    pub value: f64,
    /// In s; the first time, where it is reached more than once.
    pub time: f64,
    /// How far the value may be off: an estimate of what rounding makes of it, which is much where a stiff element or a sum
    /// cancels, of what polynomials miss at a turn, and of what may be hidden. Nothing is where the polynomials between the instants rise or fall all along, or
    /// turn once, for turns are found in the exact motion. Where one is as good as level, or turns several times, by no more than it is off, the
    /// motion may go further than the value by that: up to 1e-9 of the range, as where a quantity stays at 0 for some time.
    pub bound: f64,
}

impl Peaks {
    /// The one of larger size, the first one on ties.
    pub fn largest(&self) -> Reached {
        let (high, low) = (self.highest, self.lowest);
        match is_first([high.value, low.value], [high.time, low.time]) {
            true => high,
            false => low,
        }
    }

    /// Takes what a stretch has of a quantity, of which so much is known, and how far it may go beyond. Values that are equal but for rounding are not
    /// distinguished.
    fn widen(&mut self, stretch: &mut Stretch<'_>, i: usize, known: &Known, hidden: &mut [f64; 2]) {
        let both = [(1.0, &mut self.highest), (-1.0, &mut self.lowest)];
        let limits = stretch.limits(i);
        for (((sign, best), hidden), level) in both.into_iter().zip(hidden).zip(known.levels) {
            let mut climb = Climb {
                i,
                sign,
                range: known.range,
                level,
                best: Extremum {
                    displacement: best.value,
                    time: best.time,
                },
                beaten: None,
                hidden: *hidden,
            };
            climb.raise(stretch, limits, DEPTH);
            *hidden = climb.hidden;
            if let Some(off) = climb.beaten {
                let found = climb.best;
                *best = Reached {
                    value: found.displacement,
                    time: found.time,
                    bound: stretch.rounding(i) + EQUAL * found.displacement.abs() + off,
                };
            }
        }
    }

    /// Adds what may be hidden beyond the values to their bounds.
    fn leave(&mut self, hidden: [f64; 2]) {
        let both = [(1.0, &mut self.highest), (-1.0, &mut self.lowest)];
        for ((sign, best), hidden) in both.into_iter().zip(hidden) {
            best.bound += (hidden - sign * best.value).max(0.0);
        }
    }

    /// Compares the beginning of a stretch with the value at the end of the one before.
    fn note_jump(&mut self, before: f64, stretch: &Stretch<'_>, i: usize) {
        let after = stretch.left.x(i);
        let size = before.abs().max(after.abs());
        let size = size.max(self.highest.value).max(-self.lowest.value);
        if after != before
            && self.jumps.len() < MOST_JUMPS
            && (after - before).abs() > INVISIBLE * size + stretch.rounding(i)
        {
            self.jumps.push(Discontinuity {
                time: stretch.start,
                values: [before, after],
            });
        }
    }
}

/// A displacement and when it is reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremum {
    /// In m.
    pub displacement: f64,
    /// In s; the first time, where it is reached more than once.
    pub time: f64,
}

/// A velocity and when it is reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fastest {
    /// In m/s, with its sign.
    pub velocity: f64,
    /// In s; the first time, where it is reached more than once.
    pub time: f64,
}

/// An instant at which a coordinate's displacement, its velocity or both change at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// When, in s.
    pub time: f64,
    /// Before and after it, in m.
    pub displacement: [f64; 2],
    /// Before and after it, in m/s.
    pub velocity: [f64; 2],
}

impl Fastest {
    /// Takes another velocity where it is larger, by more than rounding.
    fn compare(&mut self, velocity: f64, time: f64) {
        if velocity.abs() > self.velocity.abs() * (1.0 + EQUAL) {
            *self = Fastest { velocity, time };
        }
    }
}

impl Extrema {
    /// The extrema of a motion, of which `trajectory` has the instants. `None` where it asks for
    /// too many points in between, such as a motion of very many oscillations from one instant to the
    /// next, or for more digits than 32 to set out, for a [large](eigentone_modes::System::is_large) system, and where the
    /// trajectory has another number of coordinates.
    pub fn of(problem: &Problem<'_>, trajectory: &Trajectory) -> Option<Extrema> {
        Extrema::with(&mut Follower::of(problem), Digits::Once, trajectory)
    }

    /// The same, followed with so many digits by a follower of the problem.
    pub(super) fn with(
        follower: &mut Follower<'_, '_>,
        digits: Digits,
        trajectory: &Trajectory,
    ) -> Option<Extrema> {
        let problem = follower.problem();
        let is_foreign = trajectory.displacement().nrows() != problem.system().len();
        if problem.system().is_large() || is_foreign {
            return None;
        }
        let (n, mut all) = (problem.system().len(), known(problem, trajectory));
        let v = trajectory.velocity();
        let speeds = (0..n).map(|i| largest(v.row(i).iter().skip(1)) * (1.0 - INVISIBLE));
        let speeds: Vec<f64> = speeds.collect();
        let found = Extrema::follow(follower, &all, &speeds, digits);
        // What is asked for beside the displacements may be harder to follow than they are.
        let more = all.len() > n;
        all.truncate(n);
        found.or_else(|| {
            more.then(|| Extrema::follow(follower, &all, &speeds, digits))
                .flatten()
        })
    }

    /// Of the displacements and, where something is known of it, of what is asked for beside them too.
    fn follow(
        follower: &mut Follower<'_, '_>,
        known: &[Known],
        speeds: &[f64],
        digits: Digits,
    ) -> Option<Extrema> {
        let mut search = Search::over(follower, known, speeds, digits)?;
        if !search.is_level() {
            // The instants given are of another motion, or of none, as at an instant at which it jumps.
            let known: Vec<Known> = known.iter().map(|known| known.alone()).collect();
            search = Search::over(follower, &known, &vec![0.0; speeds.len()], digits)?;
        }
        Some(search.extrema(follower.problem()))
    }

    /// With how many digits they were followed.
    pub(super) fn digits(&self) -> Digits {
        self.digits
    }

    /// How far a displacement may be off, about.
    pub(super) fn rounding(&self, coordinate: usize) -> f64 {
        self.roundings[coordinate]
    }

    /// Of the acceleration of a coordinate. `None` where accelerations were not asked for, or displacements alone can be
    /// followed.
    pub fn acceleration(&self, coordinate: usize) -> Option<&Peaks> {
        self.beside.as_ref()?.accelerations.get(coordinate)
    }

    /// Of a combination by its place. `None` where there is none, or displacements alone can be followed.
    pub fn output(&self, index: usize) -> Option<&Peaks> {
        self.beside.as_ref()?.outputs.get(index)
    }

    /// How fast the largest magnitude of a combination grows where the [`numbers`](Problem::numbers) of the problem change at these
    /// rates: as the motion does at its instant, where it is level. `None` at an event, where the values before and after it
    /// differ, and where the magnitude or its derivative is not known.
    ///
    /// # Panics
    /// If there are not as many rates as numbers.
    pub fn slope_of_largest(
        &self,
        problem: &Problem<'_>,
        index: usize,
        rates: &[f64],
    ) -> Option<f64> {
        let Reached { value, time, .. } = self.output(index)?.largest();
        let mut starts = problem.timeline().pieces().iter().skip(1).map(Piece::start);
        if starts.any(|start| (start - time).abs() <= 1e-9 * time) {
            return None;
        }
        let system = problem.tangent_system(rates).ok()?;
        let tangent = problem.tangent(&system, rates);
        let motion = ByCertifiedExponential.at(&tangent, &[time]).ok()?;
        Some(value.signum() * motion.output(index)[0])
    }

    /// Of the force in a spring or damper, by its place in [`System::elements`](eigentone_modes::System::elements), in N.
    /// `None` where forces were not asked for, or displacements alone can be followed.
    pub fn force(&self, kind: ElementKind, index: usize) -> Option<&Peaks> {
        let forces = &self.beside.as_ref()?.forces;
        forces[usize::from(kind == ElementKind::Damper)].get(index)
    }

    /// The highest displacement of each coordinate. Where a load makes it jump, both values count.
    pub fn highest(&self) -> &[Extremum] {
        &self.highest
    }

    /// The lowest displacement of each coordinate. Where a load makes it jump, both values count.
    pub fn lowest(&self) -> &[Extremum] {
        &self.lowest
    }

    /// The velocity of largest size of each coordinate, the first one on ties. Where an impulse makes it jump, both
    /// values count.
    pub fn fastest(&self) -> &[Fastest] {
        &self.fastest
    }

    /// Where displacement or velocity of a coordinate jump after t = 0, in the order of time, as impulses and loads on
    /// nodes without mass let them: the first thousand that show in nine digits.
    pub fn jumps(&self, coordinate: usize) -> &[Jump] {
        &self.jumps[coordinate]
    }

    /// Compares the beginning of a stretch with the end of the one before.
    fn note_jumps(&mut self, before: &[[f64; 2]], stretch: &Stretch<'_>) {
        let range = |i: usize| {
            let (high, low) = (self.highest[i].displacement, self.lowest[i].displacement);
            [high.abs().max(low.abs()), self.fastest[i].velocity.abs()]
        };
        let mut all: Option<[f64; 2]> = None;
        for (i, x_v) in before.iter().enumerate() {
            let after = [stretch.left.x(i), stretch.left.v(i)];
            if after == *x_v || self.jumps[i].len() == MOST_JUMPS {
                continue;
            }
            let own = range(i);
            let all = *all.get_or_insert_with(|| {
                let ranges = (0..before.len()).map(range);
                ranges.fold([0.0; 2], |[x, v]: [f64; 2], [a, b]| [x.max(a), v.max(b)])
            });
            let shows = |kind: usize| {
                let least = (INVISIBLE * own[kind]).max(ROUNDING * all[kind]);
                (after[kind] - x_v[kind]).abs() > least
            };
            if shows(0) || shows(1) {
                self.jumps[i].push(Jump {
                    time: stretch.start,
                    displacement: [x_v[0], after[0]],
                    velocity: [x_v[1], after[1]],
                });
            }
        }
    }

    /// The extremum of larger size, the first one on ties, of each coordinate.
    pub fn peak(&self, coordinate: usize) -> Extremum {
        let (high, low) = (self.highest[coordinate], self.lowest[coordinate]);
        let sizes = [high.displacement, low.displacement];
        match is_first(sizes, [high.time, low.time]) {
            true => high,
            false => low,
        }
    }
}

/// The extrema of the stretches seen so far.
struct Search {
    extrema: Extrema,
    /// Of what is followed beside the displacements.
    beside: Vec<Peaks>,
    /// How far each of them may go unseen, up and down.
    hidden: Vec<[f64; 2]>,
    /// What is known beforehand: of each quantity, and the size of a velocity of each coordinate.
    known: Vec<Known>,
    speeds: Vec<f64>,
    has_begun: bool,
    /// Displacement and velocity at the end of the stretch before, and what is followed beside them.
    before: Vec<[f64; 2]>,
    beside_before: Vec<f64>,
}

impl Search {
    /// Over all the motion.
    fn over(
        follower: &mut Follower<'_, '_>,
        known: &[Known],
        speeds: &[f64],
        digits: Digits,
    ) -> Option<Search> {
        let (n, problem) = (speeds.len(), follower.problem());
        let first = |i: usize| Extremum {
            displacement: problem.initial_displacement()[i],
            time: 0.0,
        };
        let start = |i: usize| Fastest {
            velocity: problem.initial_velocity()[i],
            time: 0.0,
        };
        let extrema = Extrema {
            highest: (0..n).map(first).collect(),
            lowest: (0..n).map(first).collect(),
            fastest: (0..n).map(start).collect(),
            jumps: vec![Vec::new(); n],
            beside: None,
            digits,
            roundings: vec![0.0; n],
        };
        let nothing = Reached {
            value: 0.0,
            time: 0.0,
            bound: 0.0,
        };
        let nothing = Peaks {
            highest: nothing,
            lowest: nothing,
            jumps: Vec::new(),
        };
        let mut search = Search {
            extrema,
            beside: vec![nothing; known.len() - n],
            hidden: vec![[f64::NEG_INFINITY; 2]; known.len() - n],
            known: known.to_vec(),
            speeds: speeds.to_vec(),
            has_begun: false,
            before: Vec::with_capacity(n),
            beside_before: Vec::new(),
        };
        let ranges = known.iter().map(|known| known.range).collect();
        follower.follow(0, ranges, (digits, PRODUCTS), &mut search)?;
        Some(search)
    }

    /// The lowest and the highest value found of a quantity.
    fn found(&self, i: usize) -> [f64; 2] {
        let extrema = &self.extrema;
        match i.checked_sub(extrema.highest.len()) {
            None => [&extrema.lowest, &extrema.highest].map(|all| all[i].displacement),
            Some(beside) => {
                let peaks = &self.beside[beside];
                [peaks.lowest.value, peaks.highest.value]
            }
        }
    }

    /// Whether all that was known beforehand has been found.
    fn is_level(&self) -> bool {
        let mut fastest = self.extrema.fastest.iter().zip(&self.speeds);
        let mut known = self.known.iter().enumerate();
        fastest.all(|(found, known)| found.velocity.abs() >= *known)
            && known.all(|(i, known)| {
                let [low, high] = self.found(i);
                high >= known.levels[0] && -low >= known.levels[1]
            })
    }

    /// What was found, once all has been seen.
    fn extrema(self, problem: &Problem<'_>) -> Extrema {
        let Search {
            mut extrema,
            mut beside,
            hidden,
            ..
        } = self;
        for (peaks, hidden) in beside.iter_mut().zip(hidden) {
            peaks.leave(hidden);
        }
        if extrema.digits == Digits::Once {
            let n = extrema.highest.len();
            let size = |i: usize| extrema.peak(i).displacement.abs();
            let all = (0..n).map(size).fold(0.0, f64::max);
            extrema.roundings.fill(10.0 * ROUNDING * all);
        }
        let mut accelerations = beside;
        let outputs = accelerations.len().checked_sub(problem.sources().len());
        if let Some(outputs) = outputs.filter(|_| !accelerations.is_empty()) {
            let mut outputs = accelerations.split_off(outputs);
            let mut springs = outputs.split_off(problem.combinations().len());
            let count = problem.system().elements(ElementKind::Spring).len();
            let dampers = springs.split_off(count.min(springs.len()));
            extrema.beside = Some(Beside {
                accelerations,
                outputs,
                forces: [springs, dampers],
            });
        }
        extrema
    }

    /// A node without mass does not begin at the initial values given.
    fn begin(&mut self, stretch: &Stretch<'_>) {
        self.has_begun = true;
        let extrema = &mut self.extrema;
        let n = extrema.highest.len();
        for i in 0..n {
            let displacement = stretch.left.x(i);
            let start = Extremum {
                displacement,
                time: 0.0,
            };
            (extrema.highest[i], extrema.lowest[i]) = (start, start);
            extrema.fastest[i] = Fastest {
                velocity: stretch.left.v(i),
                time: 0.0,
            };
        }
        for (i, peaks) in (n..).zip(&mut self.beside) {
            let start = Reached {
                value: stretch.left.x(i),
                time: 0.0,
                bound: stretch.rounding(i),
            };
            (peaks.highest, peaks.lowest) = (start, start);
        }
    }
}

impl Viewer for Search {
    fn asks(&self, stretch: &Stretch<'_>, i: usize, [off, speed_off]: [f64; 2]) -> bool {
        let n = self.extrema.highest.len();
        let ([low, high], known) = (self.found(i), &self.known[i]);
        let (low, high) = (low.min(-known.levels[1]), high.max(known.levels[0]));
        let [lowest, highest] = stretch.limits(i);
        let off = off + stretch.rounding(i) + INVISIBLE * known.range;
        let is_slow = || {
            let fastest = self.extrema.fastest[i].velocity.abs().max(self.speeds[i]);
            stretch.speed_limit(i) + speed_off < fastest
        };
        let is_within = highest + off < high && lowest - off > low;
        !(self.has_begun && is_within && (i >= n || is_slow()))
    }

    fn see(&mut self, stretch: &mut Stretch<'_>) {
        if !self.has_begun {
            self.begin(stretch);
        }
        let extrema = &mut self.extrema;
        let n = extrema.highest.len();
        if extrema.digits == Digits::Twice {
            for (i, rounding) in extrema.roundings.iter_mut().enumerate() {
                *rounding = rounding.max(stretch.rounding(i));
            }
        }
        for i in 0..n {
            if !stretch.is_asked(i) {
                continue;
            }
            let limits = stretch.limits(i);
            let known = &self.known[i];
            let both = [(1.0, &mut extrema.highest), (-1.0, &mut extrema.lowest)];
            for ((sign, all), level) in both.into_iter().zip(known.levels) {
                let mut climb = Climb {
                    i,
                    sign,
                    range: known.range,
                    level,
                    best: all[i],
                    beaten: None,
                    hidden: f64::NEG_INFINITY,
                };
                climb.raise(stretch, limits, DEPTH);
                all[i] = climb.best;
            }
            hasten(stretch, i, DEPTH, self.speeds[i], &mut extrema.fastest[i]);
        }
        let each = self.beside.iter_mut().zip(&mut self.hidden);
        for (i, (peaks, hidden)) in (n..).zip(each) {
            if let Some(value) = self.beside_before.get(i - n) {
                peaks.note_jump(*value, stretch, i);
            }
            if stretch.is_asked(i) {
                peaks.widen(stretch, i, &self.known[i], hidden);
            }
        }
        self.beside_before.clear();
        let beside = (n..self.known.len()).map(|i| stretch.right.x(i));
        self.beside_before.extend(beside);
        if !self.before.is_empty() {
            extrema.note_jumps(&self.before, stretch);
        }
        self.before.clear();
        let ends = (0..n).map(|i| [stretch.right.x(i), stretch.right.v(i)]);
        self.before.extend(ends);
    }
}

/// Values nearer to each other than this, in parts of them, are equal but for rounding.
const EQUAL: f64 = 1e-12;

/// Whether the first of two values has the larger size; of equal ones, whether it is reached first.
fn is_first(values: [f64; 2], times: [f64; 2]) -> bool {
    let [first, second] = values.map(f64::abs);
    if (first - second).abs() <= EQUAL * first.max(second) {
        times[0] <= times[1]
    } else {
        first > second
    }
}

/// What is known of a quantity from the instants.
#[derive(Clone, Copy, Debug)]
struct Known {
    /// Its largest size.
    range: f64,
    /// It is as high as this, and its negative too, but for what does not show: after the first instant, at which a node without
    /// mass may leave the place given.
    levels: [f64; 2],
}

impl Known {
    fn of<'a>(values: impl Iterator<Item = &'a f64>) -> Known {
        let (mut range, mut levels) = (0.0f64, [f64::NEG_INFINITY; 2]);
        for (instant, value) in values.enumerate() {
            range = range.max(value.abs());
            if instant > 0 {
                levels = [levels[0].max(*value), levels[1].max(-value)];
            }
        }
        let levels = levels.map(|level| level - INVISIBLE * range);
        Known { range, levels }
    }

    /// The range alone.
    fn alone(self) -> Known {
        let levels = [f64::NEG_INFINITY; 2];
        Known { levels, ..self }
    }
}

/// Of the displacement of each coordinate, and of what the problem asks for beside them, as far as the trajectory has it.
fn known(problem: &Problem<'_>, trajectory: &Trajectory) -> Vec<Known> {
    let x = trajectory.displacement();
    let mut all: Vec<Known> = (0..x.nrows()).map(|i| Known::of(x.row(i).iter())).collect();
    let nothing = || Known::of([].iter());
    let a = trajectory.acceleration();
    let accelerations = (0..problem.system().len()).filter(|_| problem.wants_acceleration());
    all.extend(accelerations.map(|i| a.map_or_else(nothing, |a| Known::of(a.row(i).iter()))));
    let combined = trajectory.combined().map(|values| Known::of(values.iter()));
    let combined = combined.chain(std::iter::repeat_with(nothing));
    all.extend(combined.take(problem.sources().len()));
    all
}

fn largest<'a>(values: impl Iterator<Item = &'a f64>) -> f64 {
    values.fold(0.0, |top, value| top.max(value.abs()))
}

/// A stretch whose polynomial may turn where the slopes at its ends do not show it is halved so often.
const DEPTH: usize = 8;

/// The search for the highest (`sign` 1) or lowest (−1) value of a quantity.
struct Climb {
    i: usize,
    sign: f64,
    /// The whole motion reaches it at least.
    range: f64,
    /// And this, times `sign`.
    level: f64,
    best: Extremum,
    /// How far the best may be from the exact motion that it is read off; `None` where it is the same as at first.
    beaten: Option<f64>,
    /// Times `sign`, the farthest that the motion may go unseen.
    hidden: f64,
}

impl Climb {
    /// Takes what a stretch has, which may be halved so often, given the limits of its polynomial.
    fn raise(&mut self, stretch: &mut Stretch<'_>, [low, high]: [f64; 2], depth: usize) {
        let (i, sign) = (self.i, self.sign);
        let (left, right) = (stretch.left, stretch.right);
        let range = self.range.max(left.x(i).abs()).max(right.x(i).abs());
        let limit = if sign > 0.0 { high } else { low };
        let level = self.level;
        let is_below =
            |value: f64, best: f64| sign * value < (sign * best).max(level) - INVISIBLE * range;
        if is_below(limit, self.best.displacement) {
            return;
        }
        // The left end may be beside a jump.
        self.compare(left.x(i), stretch.start, 0.0);
        self.compare(right.x(i), stretch.start + stretch.length, 0.0);
        let polynomial = stretch.polynomial(i);
        let off = stretch.off(i);
        let [before, after] = [left, right].map(|end| sign * end.v(i));
        let turns = usize::from(before > 0.0 && after < 0.0 || before < 0.0 && after > 0.0);
        let is_open = polynomial.turns() > turns;
        if is_open && depth > 0 && sign * (limit - self.best.displacement) > off {
            return stretch.halves(&mut |half| self.raise(half, half.limits(i), depth - 1));
        }
        /// What changes by no more than so many times its error may turn anywhere.
        const LEVEL: f64 = 8.0;
        if is_open || high - low <= LEVEL * off {
            self.hidden = self.hidden.max(sign * limit + off);
        }
        if before > 0.0 && after < 0.0 && !is_below(polynomial.turn().1, self.best.displacement) {
            let (time, displacement, off) = stretch.turn(i, 1);
            self.compare(displacement, time, off);
        }
    }

    /// Takes a value that beats the best. What is equal but for rounding is reached first where it is reached first.
    fn compare(&mut self, displacement: f64, time: f64, off: f64) {
        if self.sign * (displacement - self.best.displacement) > EQUAL * displacement.abs() {
            self.best = Extremum { displacement, time };
            self.beaten = Some(off);
        }
    }
}

/// Takes the largest velocity of a stretch, which may be halved so often, if it beats the best and what is known. Either end may be
/// beside a jump.
fn hasten(stretch: &mut Stretch<'_>, i: usize, depth: usize, known: f64, best: &mut Fastest) {
    let (left, right) = (stretch.left, stretch.right);
    best.compare(left.v(i), stretch.start);
    best.compare(right.v(i), stretch.start + stretch.length);
    if stretch.length == 0.0 {
        return;
    }
    let beyond = stretch.speed_limit(i) - best.velocity.abs().max(known);
    if beyond.is_nan() || beyond <= 0.0 {
        return;
    }
    let (before, after) = (left.a(i), right.a(i));
    let turns = before > 0.0 && after < 0.0 || before < 0.0 && after > 0.0;
    let is_open = stretch.polynomial(i).slope().turns() > usize::from(turns);
    // By a polynomial of degree five a slope is as near as eight times that over the length.
    if is_open && depth > 0 && beyond * stretch.length > 8.0 * stretch.off(i) {
        return stretch.halves(&mut |half| hasten(half, i, depth - 1, known, best));
    }
    if turns {
        let (time, velocity, _) = stretch.turn(i, 2);
        best.compare(velocity, time);
    }
}

/// A band about a displacement, in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Band {
    pub(crate) centre: f64,
    pub(crate) half_width: f64,
}

impl Band {
    pub(crate) fn excludes(&self, x: f64) -> bool {
        (x - self.centre).abs() > self.half_width
    }
}

/// A stretch is looked at in so many places.
const PLACES: u32 = 32;

/// Watches bands of what is followed.
pub(crate) struct Watch<'a, F> {
    pub(crate) bands: &'a [Option<Band>],
    pub(crate) see: F,
}

impl<F: FnMut(&Stretch<'_>)> Viewer for Watch<'_, F> {
    fn asks(&self, stretch: &Stretch<'_>, i: usize, [off, _]: [f64; 2]) -> bool {
        let Some(Band { centre, half_width }) = self.bands.get(i).copied().flatten() else {
            return false;
        };
        let [low, high] = stretch.limits(i);
        let off = off + stretch.rounding(i);
        let (low, high) = (low - off - centre, high + off - centre);
        let is_inside = low > -half_width && high < half_width;
        !(is_inside || low > half_width || high < -half_width)
    }

    fn see(&mut self, stretch: &mut Stretch<'_>) {
        (self.see)(stretch);
    }
}

/// The last part of a stretch that the band excludes.
pub(crate) fn last_place(stretch: &Stretch<'_>, i: usize, band: &Band) -> Option<f64> {
    if !stretch.is_asked(i) {
        // All of it, or nothing.
        return band.excludes(stretch.right.x(i)).then_some(1.0);
    }
    let polynomial = stretch.polynomial(i);
    let excludes = |s: f64| band.excludes(polynomial.at(s));
    let mut places = (0..=PLACES).rev().map(|k| f64::from(k) / f64::from(PLACES));
    let mut out = places.find(|s| excludes(*s))?;
    if out == 1.0 {
        return Some(out);
    }
    // It comes in between this place and the next.
    let mut inside = out + 1.0 / f64::from(PLACES);
    for _ in 0..50 {
        let middle = 0.5 * (out + inside);
        if excludes(middle) {
            out = middle;
        } else {
            inside = middle;
        }
    }
    Some(out)
}

/// The ranges of so many quantities that are followed: of displacements, or of what is asked for beside them too.
pub(crate) fn followed(problem: &Problem<'_>, trajectory: &Trajectory, count: usize) -> Vec<f64> {
    let known = known(problem, trajectory);
    known.iter().take(count).map(|known| known.range).collect()
}

/// When each coordinate that has a band was last outside it, in s, at any time from the instant
/// `from` of the grid on: 0 if it never was, `None` if it is at the very end; with more bands so of what the problem asks for
/// beside them, in the order of what is followed. `None` in place of all where the motion cannot be followed.
pub(crate) fn last_outside(
    follower: &mut Follower<'_, '_>,
    trajectory: &Trajectory,
    from: u64,
    digits: Digits,
    bands: &[Option<Band>],
) -> Option<Vec<Option<f64>>> {
    let mut last = vec![Some(0.0); bands.len()];
    let followed = followed(follower.problem(), trajectory, bands.len());
    let see = |stretch: &Stretch<'_>| {
        for (i, band) in bands.iter().enumerate() {
            let Some(out) = band.and_then(|band| last_place(stretch, i, &band)) else {
                continue;
            };
            // Outside at the end of a stretch; what follows decides, but for the last one.
            let is_last = out == 1.0 && stretch.length == 0.0;
            last[i] = (!is_last).then_some(stretch.start + out * stretch.length);
        }
    };
    let mut watch = Watch { bands, see };
    follower.follow(from, followed, (digits, PRODUCTS), &mut watch)?;
    Some(last)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Impulse, Polynomial, Quantity, Response, ResponsePlan, State, Step};
    use eigentone_modes::{GROUND, System};

    fn extrema(system: &System, ask: impl Fn(Response<'_>) -> Response<'_>) -> Extrema {
        let problem = ask(Response::of(system)).problem().expect("a problem");
        let trajectory = ResponsePlan::of(&problem).expect("a plan").run(&problem);
        Extrema::of(&problem, &trajectory.expect("a motion")).expect("it can be followed")
    }

    /// Of unit mass.
    fn oscillator(omega: f64, zeta: f64) -> System {
        let mass = System::builder().mass("m", 1.0);
        let held = mass.spring(GROUND, "m", omega * omega);
        let damped = held.damper(GROUND, "m", 2.0 * zeta * omega);
        damped.build().expect("a system")
    }

    #[test]
    fn the_overshoot_of_a_step_is_that_of_the_closed_form() {
        // x″ + 2ζωx′ + ω²x = ω² from rest peaks at π/ω_d with 1 + e^(−πζ/√(1−ζ²)); a grid of one
        // instant a period sees little of it.
        for zeta in [0.001f64, 0.1, 0.5, 0.9] {
            let omega = 7.0;
            let found = extrema(&oscillator(omega, zeta), |r| {
                r.load("m", Step::of(omega * omega)).every(0.9).until(18.0)
            });
            let root = (1.0 - zeta * zeta).sqrt();
            let peak = found.peak(0);
            let wanted = 1.0 + (-std::f64::consts::PI * zeta / root).exp();
            let off = (peak.displacement - wanted).abs();
            assert!(off < 1e-12, "{zeta}: {peak:?}");
            let time = std::f64::consts::PI / (omega * root);
            assert!((peak.time - time).abs() < 1e-6, "{zeta}: {peak:?} {time}");
            assert!(found.lowest()[0].displacement.abs() < 1e-12);
        }
    }

    /// An undamped mass that moves off upwards is as far down half a period after it is up.
    #[test]
    fn the_first_of_equal_peaks_is_named() {
        let omega = 4.123;
        for velocity in 1..20 {
            let velocity = f64::from(velocity);
            let from = State::at_rest().displace("m", 1.0).push("m", velocity);
            let found = extrema(&oscillator(omega, 0.0), |r| {
                r.from(from.clone()).every(0.1).until(20.0)
            });
            let wanted = (velocity / omega).atan() / omega;
            let peak = found.peak(0);
            assert!(peak.displacement > 0.0, "{velocity}: {peak:?}");
            assert!((peak.time - wanted).abs() < 1e-6, "{velocity}: {peak:?}");
        }
    }

    /// The instants of another motion lead to the same extrema.
    #[test]
    fn what_other_instants_show_is_not_believed() {
        let system = oscillator(2.0, 0.1);
        let pushed = |velocity: f64| {
            let from = State::at_rest().push("m", velocity);
            let problem = Response::of(&system).from(from).every(0.3).until(6.0);
            problem.with_acceleration().problem().expect("a problem")
        };
        let (weak, strong) = (pushed(1.0), pushed(1.5));
        let plan = ResponsePlan::of(&strong).expect("a plan");
        let other = plan.run(&strong).expect("a motion");
        let found = Extrema::of(&weak, &other).expect("it can be followed");
        let wanted = extrema(&system, |response| {
            let from = State::at_rest().push("m", 1.0);
            response
                .from(from)
                .with_acceleration()
                .every(0.3)
                .until(6.0)
        });
        let all = |found: &Extrema| {
            let acceleration = found.acceleration(0).expect("asked for");
            let ([high], [low], [fastest]) = (found.highest(), found.lowest(), found.fastest())
            else {
                panic!("there is one mass");
            };
            [
                high.displacement,
                low.displacement,
                fastest.velocity,
                acceleration.highest.value,
                acceleration.lowest.value,
            ]
        };
        for (found, wanted) in all(&found).into_iter().zip(all(&wanted)) {
            assert!((found - wanted).abs() < 1e-12, "{found} {wanted}");
        }
    }

    #[test]
    fn a_grid_of_whole_periods_hides_nothing() {
        let system = System::builder().mass("m", 1.0).spring(GROUND, "m", 1.0);
        let system = system.build().expect("a system");
        let step = 2.0 * std::f64::consts::TAU;
        let found = extrema(&system, |r| {
            r.from(State::at_rest().push("m", 1.0))
                .every(step)
                .until(2.0 * step)
        });
        assert!((found.highest()[0].displacement - 1.0).abs() < 1e-12);
        assert!((found.highest()[0].time - std::f64::consts::FRAC_PI_2).abs() < 1e-6);
        assert!((found.lowest()[0].displacement + 1.0).abs() < 1e-12);
    }

    /// A mass with the velocity (t − 0.2)(t − 1.9)(3 − t) is highest at 0.2 s, which no instant and no middle shows.
    #[test]
    fn turns_between_places_of_equal_slopes_are_seen() {
        let system = System::builder().mass("m", 1.0).build().expect("a system");
        let found = extrema(&system, |response| {
            response
                .from(State::at_rest().push("m", 1.14))
                .load("m", Polynomial::of([-6.68, 10.2, -3.0]))
                .sum("x", [(Quantity::Displacement, "m", 1.0)])
                .every(4.0)
                .until(4.0)
        });
        let place = |t: f64| t * (1.14 + t * (-3.34 + t * (1.7 - 0.25 * t)));
        let (top, same) = (
            found.highest()[0],
            found.output(0).expect("asked for").highest,
        );
        for (value, time) in [(top.displacement, top.time), (same.value, same.time)] {
            assert!((value - place(0.2)).abs() < 1e-12, "{value}");
            assert!((time - 0.2).abs() < 1e-6, "{time}");
        }
        assert!(same.bound < 1e-10, "{same:?}");
    }

    /// The same of a velocity, 2 m/s more than that way.
    #[test]
    fn velocities_that_turn_between_places_of_equal_slopes_are_seen() {
        let system = System::builder().mass("m", 1.0).build().expect("a system");
        let found = extrema(&system, |response| {
            response
                .from(State::at_rest().push("m", 2.0))
                .load("m", Polynomial::of([1.14, -6.68, 5.1, -1.0]))
                .every(4.0)
                .until(4.0)
        });
        let fastest = found.fastest()[0];
        let place = 0.2 * (1.14 + 0.2 * (-3.34 + 0.2 * (1.7 - 0.25 * 0.2)));
        let off = (fastest.velocity - 2.0 - place).abs();
        assert!(off < 1e-12, "{fastest:?}");
        assert!((fastest.time - 0.2).abs() < 1e-6, "{fastest:?}");
    }

    /// An acceleration t²(t − ε) goes down to −4ε³/27, and one that waits goes nowhere: bounds hold what is not seen, and
    /// no more.
    #[test]
    fn what_is_as_good_as_level_is_within_its_bound() {
        let system = System::builder().mass("m", 1.0).build().expect("a system");
        for dip in [1e-2, 1e-3, 1e-4] {
            let found = extrema(&system, |response| {
                response
                    .load("m", Polynomial::of([0.0, 0.0, -dip, 1.0]))
                    .with_acceleration()
                    .every(1.0)
                    .until(1.0)
            });
            let peaks = found.acceleration(0).expect("asked for");
            let truth = -4.0 * dip.powi(3) / 27.0;
            let Reached { value, bound, .. } = peaks.lowest;
            assert!((value - truth).abs() <= bound && bound < 1e-9, "{peaks:?}");
            assert!((peaks.highest.value - (1.0 - dip)).abs() <= peaks.highest.bound);
            assert!(peaks.highest.bound < 1e-11, "{peaks:?}");
        }
    }

    /// Of two nodes without mass, the last of which nothing else holds, the spring between them has no force.
    #[test]
    fn a_force_that_is_nothing_is_within_its_bound() {
        for stiffness in 1..20 {
            let stiffness = f64::from(stiffness) / 7.0;
            let builder = System::builder().mass("m", 1.3).mass("a", 0.0);
            let builder = builder.mass("b", 0.0).spring(GROUND, "m", 0.7);
            let builder = builder.spring("m", "a", 1.9).spring(GROUND, "a", 0.3);
            let builder = builder.spring("a", "b", stiffness);
            let found = extrema(&builder.build().expect("a system"), |response| {
                let from = State::at_rest().push("m", -1.6);
                response.from(from).with_forces().every(0.1).until(0.7)
            });
            let peaks = found.force(ElementKind::Spring, 3).expect("asked for");
            for Reached { value, bound, .. } in [peaks.highest, peaks.lowest] {
                assert!(
                    value.abs() <= bound && bound < 1e-25,
                    "{stiffness}: {peaks:?}"
                );
            }
        }
    }

    #[test]
    fn the_largest_velocity_is_that_of_the_closed_form() {
        // The impulse response e^(−ζωt)·sin(ω_d t) of a step's velocity is steepest at atan(ω_d/ζω)/ω_d.
        for zeta in [0.01f64, 0.3, 0.8] {
            let omega = 3.0;
            let found = extrema(&oscillator(omega, zeta), |r| {
                r.load("m", Step::of(omega * omega)).every(1.7).until(17.0)
            });
            let damped = omega * (1.0 - zeta * zeta).sqrt();
            let time = (damped / (zeta * omega)).atan() / damped;
            let wanted =
                omega * omega / damped * (-zeta * omega * time).exp() * (damped * time).sin();
            let fastest = found.fastest()[0];
            let off = (fastest.velocity - wanted).abs();
            assert!(off < 1e-12, "{zeta}: {fastest:?} {wanted}");
            let off = (fastest.time - time).abs();
            assert!(off < 1e-6, "{zeta}: {fastest:?} {time}");
        }
    }

    #[test]
    fn a_jump_of_the_velocity_is_seen_from_both_sides() {
        // From 3 m/s an impulse of −4 N·s leaves −1 m/s, one of −10 leaves −7.
        let system = System::builder().mass("m", 1.0).build().expect("a system");
        for (impulse, fastest) in [(-4.0, 3.0), (-10.0, -7.0)] {
            let found = extrema(&system, |r| {
                r.from(State::at_rest().push("m", 3.0))
                    .load("m", Impulse::of(impulse).at(1.25))
                    .every(1.0)
                    .until(4.0)
            });
            let found = found.fastest()[0];
            assert!((found.velocity - fastest).abs() < 1e-12, "{found:?}");
            assert_eq!(found.time, if fastest > 0.0 { 0.0 } else { 1.25 });
        }
    }

    /// Of two equal masses on like springs, joined by another, one swings as ½(cos at − cos bt) once the other is let go: of
    /// hundreds of peaks the largest is found, and of its acceleration.
    #[test]
    fn the_largest_of_many_peaks_is_found() {
        let system = System::builder().mass("p", 1.0).mass("q", 1.0);
        let system = system.spring(GROUND, "p", 1.0).spring(GROUND, "q", 1.0);
        let system = system.spring("p", "q", 2.9).build().expect("a system");
        let (b, end) = (6.8f64.sqrt(), 300.0);
        let found = extrema(&system, |response| {
            let response = response.from(State::at_rest().displace("p", 1.0));
            response.with_acceleration().every(7.0).until(end)
        });
        let acceleration = found.acceleration(1).expect("asked for");
        let place = |t: f64| 0.5 * (t.cos() - (b * t).cos());
        let pull = |t: f64| 0.5 * (b * b * (b * t).cos() - t.cos());
        // About the highest of many places a parabola.
        let highest = |of: &dyn Fn(f64) -> f64| {
            let step = 1e-3;
            let places = (1..300_000).map(|k| f64::from(k) * step);
            let best = places.max_by(|s, t| of(*s).total_cmp(&of(*t)));
            let best = best.expect("a place");
            let [before, here, after] = [-1.0, 0.0, 1.0].map(|k| of(best + k * step));
            let (slope, bend) = (after - before, before - 2.0 * here + after);
            here - slope * slope / (8.0 * bend)
        };
        let both = [
            (found.highest()[1].displacement, highest(&place)),
            (found.lowest()[1].displacement, -highest(&|t| -place(t))),
            (acceleration.highest.value, highest(&pull)),
            (acceleration.lowest.value, -highest(&|t| -pull(t))),
        ];
        for (found, wanted) in both {
            assert!((found - wanted).abs() < 1e-10, "{found} {wanted}");
        }
    }

    #[test]
    fn peaks_between_events_are_seen() {
        // Pulled by 1 for 2 s and then let go: afterwards it swings by 2·sin 1.
        let system = System::builder().mass("m", 1.0).spring(GROUND, "m", 1.0);
        let system = system.build().expect("a system");
        let off = Step::of(-1.0).starting_at(2.0);
        let found = extrema(&system, |r| {
            r.load("m", Step::of(1.0))
                .load("m", off)
                .every(3.0)
                .until(30.0)
        });
        let swing = 2.0 * 1f64.sin();
        assert!((found.highest()[0].displacement - swing).abs() < 1e-12);
        assert!((found.lowest()[0].displacement + swing).abs() < 1e-12);
    }

    /// An impulse of −4 N·s after a second and a force of 6 N after two, on 2 kg held by 8 N/m.
    #[test]
    fn jumps_of_accelerations_outputs_and_forces_are_noted() {
        let system = System::builder()
            .mass("m", 2.0)
            .spring(GROUND, "m", 8.0)
            .damper(GROUND, "m", 0.5);
        let found = extrema(&system.build().expect("a system"), |response| {
            response
                .load("m", Impulse::of(-4.0).at(1.0))
                .load("m", Step::of(6.0).starting_at(2.0))
                .sum("speed", [(Quantity::Velocity, "m", 1.0)])
                .with_acceleration()
                .with_forces()
                .every(0.75)
                .until(3.0)
        });
        let sizes = |peaks: Option<&Peaks>| -> Vec<(f64, f64)> {
            let jumps = &peaks.expect("it was asked for").jumps;
            let size = |jump: &Discontinuity| (jump.time, jump.values[1] - jump.values[0]);
            jumps.iter().map(size).collect()
        };
        for (peaks, wanted) in [
            (found.acceleration(0), &[(1.0, 0.5), (2.0, 3.0)][..]),
            (found.output(0), &[(1.0, -2.0)]),
            (found.force(ElementKind::Spring, 0), &[]),
            (found.force(ElementKind::Damper, 0), &[(1.0, -1.0)]),
        ] {
            let sizes = sizes(peaks);
            assert_eq!(sizes.len(), wanted.len(), "{sizes:?}");
            for ((time, size), (then, change)) in sizes.iter().zip(wanted) {
                assert_eq!(time, then);
                assert!((size - change).abs() < 1e-12, "{sizes:?}");
            }
        }
    }
}
