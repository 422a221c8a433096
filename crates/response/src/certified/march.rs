//! From instant to instant with more digits, every error counted.

use std::ops::Range;

use eigentone_digits::{BallMatrix, Magnitude, Real};

use super::attempt::Attempt;
use super::clock::Moment;
use super::drift::{Carried, Drift, Errors, LEVELS};
use super::driven::Driven;
use super::generator::{Generator, Output};
use super::judge::Judge;
use super::products::Columns;
use super::stepper::Stepper;
use crate::answer::{Collector, Operations, Wanted};
use crate::enclosed::{Normed, counted, growth, squarings};
use crate::problem::{Instant, Leg, Problem, ResponseError, Walk};

/// What a march is to answer.
#[derive(Clone, Copy)]
pub(super) struct March<'a, 'b> {
    pub(super) problem: &'a Problem<'b>,
    pub(super) wanted: Wanted<'a>,
    /// The name of the method, for messages.
    pub(super) method: &'static str,
    /// Relative, of each instant.
    pub(super) tolerance: f64,
    /// Whether no attempt follows that takes more digits.
    pub(super) last: bool,
}

impl March<'_, '_> {
    /// The answer in the arithmetic of T, by a stepper of the problem: [`Attempt::Stuck`] where there is none. Unless this is the
    /// last attempt, it ends at the first instant that misses the tolerance, or at once where what is not known of the generator
    /// will come to more in all the time.
    ///
    /// # Errors
    /// [`ResponseError::TooLarge`], [`ResponseError::ImpulseOnMassless`] for one that displaces without limit,
    /// [`ResponseError::Overflow`] where the motion leaves the range of doubles, and
    /// [`ResponseError::Lost`] where nothing is left to be known of it.
    pub(super) fn by<T: Real>(self, stepper: Option<Stepper<T>>) -> Result<Attempt, ResponseError> {
        let grid = self.problem.grid();
        let end = Magnitude::from(grid.time(grid.last()));
        match stepper {
            None => Ok(Attempt::Stuck),
            Some(Stepper { generator, .. })
                if !self.last && generator.w.error() * end > Magnitude::from(self.tolerance) =>
            {
                Ok(Attempt::Missed {
                    halvings: squarings(&generator.w, grid.step()),
                })
            }
            Some(stepper) => {
                let driven = Driven::new(self.problem, stepper, 0);
                driven.check_momenta()?;
                Walker::new(driven).walk(&self)
            }
        }
    }
}

/// A state on its way.
pub(super) struct Walker<'a, 'b, T> {
    driven: Driven<'a, 'b, T>,
    /// Φ^{2^j} of the unit step, as far as needed.
    powers: Vec<Step<T>>,
    /// The maps to displacements, velocities and accelerations.
    outputs: [Columns<T>; 3],
    zeta: Vec<T>,
    next: Vec<T>,
    /// The errors of the states and of sines and cosines.
    drift: Drift,
    /// The error of the straight loads in ζ.
    straight_error: Magnitude,
    /// The state in its own coordinates where it is known without any motion: at the start, and at
    /// impulses on what was at rest.
    fresh: Option<BallMatrix<T>>,
    operations: Operations,
}

impl<'a, 'b, T: Real> Walker<'a, 'b, T> {
    pub(super) fn new(driven: Driven<'a, 'b, T>) -> Walker<'a, 'b, T> {
        let (zeta, error) = driven.start();
        let mut base = [Magnitude::ZERO; LEVELS];
        base[0] = error;
        Walker {
            powers: Vec::new(),
            outputs: driven.generator.outputs.each_ref().map(|output| {
                let size = zeta.len();
                Columns::of(output.rows.len(), size, |i, j| output.rows[i][j])
            }),
            next: zeta.clone(),
            zeta,
            drift: Drift::new(driven.generator.levels.len(), base),
            straight_error: Magnitude::ZERO,
            fresh: Some(driven.generator.given(driven.problem)),
            operations: Operations::default(),
            driven,
        }
    }

    fn walk(mut self, march: &March<'_, '_>) -> Result<Attempt, ResponseError> {
        /// Where errors come to 2 to this power of the states, it is to be known how they fade.
        const SEEN: i64 = -72;
        let March { wanted, last, .. } = *march;
        let mut collector = Collector::new(self.driven.problem, wanted)?;
        let problem = self.driven.problem;
        let end = problem.grid().time(problem.grid().last());
        let mut judge = Judge::new(march.tolerance, end, self.driven.generator.fastest());
        let mut walk = Walk::of(problem);
        self.begin(0);
        let doublings = self.doublings(wanted.count(problem.grid()));
        if let Some(doublings) = doublings {
            // Errors that no step lengthens do not need the norms of many steps.
            self.prepare(0);
            let growth = self.powers[0].carried.growth().log2() * (doublings as f64).exp2();
            self.prepare(if growth < 1.0 { 0 } else { doublings });
        }
        while let Some(target) = collector.next() {
            while let Some(leg) = walk.towards(&target) {
                match leg {
                    Leg::Pass { from, to } => {
                        self.go(
                            self.driven.clock.moment(&from),
                            self.driven.clock.moment(&to),
                        );
                    }
                    Leg::Begin => self.begin(walk.index()),
                }
            }
            let (sizes, mut drift) = (self.sizes(), self.parts());
            if let Some(doublings) = doublings
                && sizes[0] * Magnitude::power_of_two(SEEN) < drift[0]
                && self.powers.len() <= doublings
            {
                self.prepare(doublings);
                drift = self.parts();
            }
            let good = self.record(&mut collector, &mut judge, &target, (sizes, drift), last)?;
            if !good && !last {
                let halvings = squarings(&self.driven.generator.w, problem.grid().step());
                return Ok(Attempt::Missed { halvings });
            }
        }
        let trajectory = collector.finish(march.method).after(self.operations);
        Ok(Attempt::Found(Box::new(trajectory)))
    }

    /// To states and loads that it had at the same instant.
    pub(super) fn put(&mut self, zeta: &[T]) {
        self.fresh = None;
        self.zeta.copy_from_slice(zeta);
    }

    /// The state and the loads.
    pub(super) fn exact(&self) -> &[T] {
        &self.zeta
    }

    /// A bound of its error in the 2-norm.
    pub(super) fn error(&mut self) -> Magnitude {
        let [states, turning] = self.parts();
        states + turning + self.straight_error
    }

    /// Bounds of the errors of the states, and of sines and cosines.
    fn parts(&mut self) -> [Magnitude; 2] {
        let (total, generator) = (self.drift.total(), &self.driven.generator);
        let mut parts = [Magnitude::ZERO; 2];
        for (level, error) in generator.levels.iter().zip(total) {
            let part = &mut parts[usize::from(level.start >= generator.states)];
            *part = *part + error;
        }
        parts
    }

    /// Where an instant is.
    pub(super) fn moment(&self, instant: &Instant) -> Moment {
        self.driven.clock.moment(instant)
    }

    /// From one moment to another, and a bound of the error.
    pub(super) fn seconds(&self, from: Moment, to: Moment) -> (T, Magnitude) {
        self.driven.clock.seconds(from, to)
    }

    /// The impulses and new laws at the start of a piece.
    pub(super) fn begin(&mut self, index: usize) {
        if self.fresh.is_none() && self.is_at_rest() {
            self.fresh = Some(self.driven.generator.rest());
        }
        let begun = self.driven.set(index, &mut self.zeta);
        let generator = &self.driven.generator;
        self.fresh = self
            .fresh
            .take()
            .map(|state| generator.after_momenta(&state, &begun.momenta));
        if !begun.momenta.is_empty() {
            let mut total = self.drift.total();
            total[0] = total[0] + begun.error;
            self.drift.restart(total);
        }
        if let Some(error) = begun.straight {
            self.straight_error = error;
        }
    }

    fn is_at_rest(&mut self) -> bool {
        let states = &self.zeta[..self.driven.generator.states];
        states.iter().all(|entry| entry.is_zero()) && self.parts()[0].is_zero()
    }

    /// From one moment to a later one.
    pub(super) fn go(&mut self, now: Moment, end: Moment) {
        if now == end {
            return;
        }
        if let (Moment::Units(from), Moment::Units(to)) = (now, end) {
            self.fresh = None;
            let mut at = from;
            while at < to {
                let j = (to - at).ilog2() as usize;
                self.prepare(j);
                let error = apply(
                    &self.powers[j],
                    &self.driven.generator,
                    &mut self.zeta,
                    &mut self.next,
                    self.straight_error,
                );
                self.operations.steps += 1;
                self.drift.step(1 << j, error);
                at += 1 << j;
                self.follow_slopes(Moment::Units(at));
            }
        } else {
            let (time, error) = self.driven.clock.seconds::<T>(now, end);
            let relative = (error + error) / time.magnitude();
            let power = self.exponential(time, relative);
            let hop = Step::of(power, &self.driven.generator.levels);
            self.hop(&hop, end);
        }
    }

    /// By a step to the moment to which it leads.
    pub(super) fn hop(&mut self, step: &Step<T>, end: Moment) {
        self.fresh = None;
        self.operations.steps += 1;
        let error = apply(
            step,
            &self.driven.generator,
            &mut self.zeta,
            &mut self.next,
            self.straight_error,
        );
        let mut total = self.drift.total();
        step.carried.carry(&mut total);
        let pairs = total.iter_mut().zip(error);
        pairs.for_each(|(total, error)| *total = *total + error);
        self.drift.restart(total);
        self.follow_slopes(end);
    }

    fn follow_slopes(&mut self, now: Moment) {
        if self.driven.straight.are_sloped() {
            self.straight_error = self.driven.set_straight_at(now, &mut self.zeta);
        }
    }

    fn exponential(&mut self, time: T, relative: Magnitude) -> Normed<T> {
        let (power, products) = counted(&self.driven.generator.w, time, relative);
        self.operations.exponentials += 1;
        self.operations.products += products as f64;
        power
    }

    /// Φ, made with all its halves where these are shared.
    fn unit(&mut self, time: T, relative: Magnitude) -> Normed<T> {
        let w = &self.driven.generator.w;
        let unit = self.driven.unit.as_ref();
        let Some(chain) = unit.and_then(|unit| unit.chain(w, time, relative)) else {
            return self.exponential(time, relative);
        };
        self.operations.exponentials += 1;
        self.operations.products += chain.halves.products() as f64;
        chain.squares[0].clone()
    }

    /// Φ^{2^j} and all before it.
    fn prepare(&mut self, j: usize) {
        while self.powers.len() <= j {
            let power = match self.powers.last() {
                Some(last) => {
                    self.operations.products += 1.0;
                    last.power.times(&last.power)
                }
                None => {
                    let (time, error) = self
                        .driven
                        .clock
                        .seconds(Moment::Units(0), Moment::Units(1));
                    self.unit(time, (error + error) / time.magnitude())
                }
            };
            let step = Step::of(power, &self.driven.generator.levels);
            self.drift.know(self.powers.len(), step.carried);
            self.powers.push(step);
        }
    }

    /// All powers up to the end, whose norms show how errors fade, where they cost little beside the march.
    pub(super) fn prepare_all(&mut self, instants: u64) {
        if let Some(doublings) = self.doublings(instants) {
            self.prepare(doublings);
        }
    }

    /// How many times the unit step is doubled until the end, where so many products cost little beside the march.
    fn doublings(&self, instants: u64) -> Option<usize> {
        let steps = self.driven.problem.grid().last() * self.driven.clock.division;
        let doublings = steps.checked_ilog2()? as usize;
        (doublings * self.zeta.len() <= 16 * instants as usize).then_some(doublings)
    }

    /// Fills the column of the instant reached, where states and loads have these 2-norms and errors; whether it is good enough.
    fn record(
        &mut self,
        collector: &mut Collector<'_, '_>,
        judge: &mut Judge,
        now: &Instant,
        (sizes, drift): ([Magnitude; 2], [Magnitude; 2]),
        last: bool,
    ) -> Result<bool, ResponseError> {
        let column = collector.column();
        let step = self.driven.problem.grid().step();
        let index = now.index().unwrap_or((now.time().to_f64() / step) as u64);
        let outset = self.fresh.as_ref().map(|state| {
            self.driven
                .generator
                .outset(state, &self.zeta, self.straight_error)
        });
        let mut good = true;
        let size = (sizes[0] * sizes[0] + sizes[1] * sizes[1]).sqrt();
        for row in 0..self.driven.generator.combinations.len() {
            let (exact, error) = match &outset {
                Some(outset) => (outset[3].middle(row, 0), outset[3].radius(row, 0)),
                None => self.combination(&self.driven.generator.combinations[row], drift, sizes),
            };
            let (value, bound) = rounded(exact, error);
            if !value.is_finite() && error.is_finite() {
                return Err(ResponseError::Overflow { index });
            }
            // Loads are in units of what they do in a step.
            let parts = self.driven.generator.combinations[row].parts.iter();
            let norm = parts.fold(Magnitude::ZERO, |sum, part| sum + part.norm);
            let made_of = norm * size;
            good &= judge.judge_combination(row, value.abs(), made_of, error);
            collector.combine(row, value, bound.to_f64());
        }
        let mut bounds = [Some(0.0); 3];
        let mut motion = [(0.0, Magnitude::ZERO); 2];
        for kind in 0..3 {
            if collector.values[kind].ncols() == 0 {
                continue;
            }
            let values = match &outset {
                Some(outset) => column_of(&outset[kind]),
                None => self.values(kind, drift, sizes),
            };
            let (mut top, mut worst, mut bound) = (0.0f64, Magnitude::ZERO, Magnitude::ZERO);
            for (i, (exact, error)) in values.into_iter().enumerate() {
                let (value, off) = rounded(exact, error);
                if !value.is_finite() && error.is_finite() {
                    return Err(ResponseError::Overflow { index });
                }
                bound = larger(bound, off);
                worst = larger(worst, error);
                collector.values[kind][(i, column)] = value;
                top = top.max(value.abs());
            }
            bounds[kind] = Some(bound.to_f64());
            if kind < 2 {
                motion[kind] = (top, worst);
            }
            if last && !bound.to_f64().is_finite() {
                let digits = (f64::from(-T::UNIT_LOG2) * std::f64::consts::LOG10_2) as usize;
                return Err(ResponseError::Lost { index, digits });
            }
        }
        collector.advance(bounds);
        let accelerates = || {
            self.values(2, drift, sizes)
                .iter()
                .any(|(value, error)| value.upper() > *error)
        };
        Ok(judge.judge(motion, accelerates) && good)
    }

    /// Each coordinate's displacement, velocity or acceleration, and a bound of its error.
    fn values(
        &self,
        kind: usize,
        drift: [Magnitude; 2],
        sizes: [Magnitude; 2],
    ) -> Vec<(T, Magnitude)> {
        let error = self.output_error(&self.driven.generator.outputs[kind], drift, sizes);
        let rows = self.outputs[kind].rows;
        let mut values = vec![T::ZERO; rows];
        self.outputs[kind].apply(&self.zeta, &mut values);
        values.into_iter().map(|value| (value, error)).collect()
    }

    /// The value of an output of one row, and a bound of its error.
    fn combination(
        &self,
        output: &Output<T>,
        drift: [Magnitude; 2],
        sizes: [Magnitude; 2],
    ) -> (T, Magnitude) {
        let products = output.rows[0].iter().zip(&self.zeta).map(|(a, b)| *a * *b);
        let sum = products.fold(T::ZERO, |sum, product| sum + product);
        (sum, self.output_error(output, drift, sizes))
    }

    /// The 2-norms of states and of loads.
    fn sizes(&self) -> [Magnitude; 2] {
        let (states, loads) = self.zeta.split_at(self.driven.generator.states);
        [states, loads].map(length)
    }

    /// A bound of the error of any value of an output.
    fn output_error(
        &self,
        output: &Output<T>,
        drift: [Magnitude; 2],
        sizes: [Magnitude; 2],
    ) -> Magnitude {
        let states = self.driven.generator.states;
        let counts = [states, self.zeta.len() - states];
        let errors = [drift[0], drift[1] + self.straight_error];
        let rounding = growth::<T>(self.zeta.len());
        let mut error = Magnitude::ZERO;
        let vectors = sizes.into_iter().zip(counts);
        for ((part, (size, count)), own) in output.parts.iter().zip(vectors).zip(errors) {
            if part.norm.is_zero() || size.is_zero() && own.is_zero() {
                continue;
            }
            let floor = T::floor() * Magnitude::from(count as f64);
            error = error + part.norm * own + (part.error + rounding * part.norm) * size + floor;
        }
        error
    }
}

/// Φ^{2^j}, or that of any other time.
pub(super) struct Step<T> {
    power: Normed<T>,
    columns: Columns<T>,
    /// How it carries errors on: straight loads, which are set anew, have none that it would.
    carried: Carried,
}

impl<T: Real> Step<T> {
    /// With the [levels](Generator::levels) of ζ.
    pub(super) fn of(power: Normed<T>, levels: &[Range<usize>]) -> Step<T> {
        let n = power.len();
        Step {
            columns: Columns::of(n, n, |i, j| power.row(i)[j]),
            carried: Carried::of(&power, levels),
            power,
        }
    }
}

/// The nearest double, or 0 where the error hides it, and how far it may be off.
fn rounded<T: Real>(exact: T, error: Magnitude) -> (f64, Magnitude) {
    let size = exact.upper();
    if size <= error {
        return (0.0, error + size);
    }
    let value = exact.to_f64();
    (value, error + (exact - T::from(value)).upper())
}

/// The only column, with its errors.
fn column_of<T: Real>(matrix: &BallMatrix<T>) -> Vec<(T, Magnitude)> {
    let entry = |i| (matrix.middle(i, 0), matrix.radius(i, 0));
    (0..matrix.rows()).map(entry).collect()
}

fn larger(a: Magnitude, b: Magnitude) -> Magnitude {
    if a < b { b } else { a }
}

/// ζ ← Ψ ζ but for the straight loads; the errors this makes by itself, those of the straight loads
/// included.
fn apply<T: Real>(
    step: &Step<T>,
    generator: &Generator<T>,
    zeta: &mut [T],
    next: &mut [T],
    straight_error: Magnitude,
) -> Errors {
    let n = zeta.len();
    let floor = T::floor() * Magnitude::from((n * n) as f64);
    let psi = &step.power;
    let relative = psi.error() + growth::<T>(n) * psi.sizes();
    let mut errors = [Magnitude::ZERO; LEVELS];
    // Nothing before a level moves it, so that its error is one of what stands from there on.
    let mut squares = Magnitude::ZERO;
    for (error, level) in errors.iter_mut().zip(&generator.levels).rev() {
        squares = squares + sum_of_squares(&zeta[level.clone()]);
        if level.end == generator.states {
            squares = squares + sum_of_squares(&zeta[generator.straight..]);
        }
        if !squares.is_zero() {
            *error = relative * squares.sqrt() + floor;
        }
        if level.start < generator.states {
            *error = *error + psi.true_norm() * straight_error;
        }
    }
    step.columns.apply(zeta, next);
    zeta[..generator.straight].copy_from_slice(&next[..generator.straight]);
    errors
}

/// An upper bound of the 2-norm.
pub(super) fn length<T: Real>(vector: &[T]) -> Magnitude {
    sum_of_squares(vector).sqrt()
}

fn sum_of_squares<T: Real>(vector: &[T]) -> Magnitude {
    let squares = vector.iter().map(|entry| {
        let size = entry.upper();
        size * size
    });
    squares.fold(Magnitude::ZERO, |sum, square| sum + square)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ByCertifiedExponential, Response, ResponseMethod, State};
    use eigentone_digits::{DoubleDouble, Wide};
    use eigentone_modes::{GROUND, System};

    /// A damper holds q on p, but nothing holds p at once: an impulse on q would displace both without limit.
    #[test]
    fn an_impulse_that_only_springs_resist_is_refused() {
        let system = System::builder().mass("p", 0.0).mass("q", 0.0);
        let system = system.spring(GROUND, "p", 1.0).damper("p", "q", 3.0);
        let system = system.build().expect("a system");
        let impulse = |size: f64| {
            let ask = Response::of(&system).load("q", crate::Impulse::of(size).at(0.7));
            let problem = ask.every(0.5).until(2.0).problem().expect("a problem");
            ByCertifiedExponential
                .run(&problem)
                .map(|motion| motion.displacement().norm_max())
        };
        let (index, name) = (0, "q".to_owned());
        assert_eq!(
            impulse(1.0),
            Err(ResponseError::ImpulseOnMassless { index, name })
        );
        assert_eq!(impulse(0.0), Ok(0.0));
    }

    /// A sine on a mass, on a road that is shaken by another: what loads add to an error grows in proportion to a power of time, where
    /// powers of one norm would come to 1e-15 after a thousand steps; and it is no less than what 32 digits are off.
    #[test]
    fn errors_under_sines_grow_slowly() {
        const STEPS: u64 = 1000;
        let system = System::builder().mass("m", 1.0).support("road");
        let system = system.spring("road", "m", 4.0).build().expect("a system");
        let ask = Response::of(&system).load("m", crate::Harmonic::of(1.0, 3.0));
        let shaken = crate::Harmonic::of(2.0, 5.0);
        let ask = ask.motion("road", crate::Quantity::Acceleration, shaken);
        let problem = ask.every(0.005).until(5.0).problem().expect("a problem");
        fn marched<T: Real>(problem: &Problem<'_>) -> (T, f64) {
            let stepper = Stepper::<T>::of::<T>(problem).expect("regular");
            let mut walker = Walker::new(Driven::new(problem, stepper, 0));
            walker.begin(0);
            let step = |k| walker.go(Moment::Units(k), Moment::Units(k + 1));
            (0..STEPS).for_each(step);
            let (drift, sizes) = (walker.parts(), walker.sizes());
            let (value, error) = walker.values(0, drift, sizes)[0];
            (value, error.to_f64())
        }
        let (found, error) = marched::<DoubleDouble>(&problem);
        let (exact, _) = marched::<Wide<4>>(&problem);
        let off = exact - Wide::from(found.high()) - Wide::from(found.low());
        let off = off.to_f64().abs();
        assert!(off <= error && error < 1e-21, "{off:e} {error:e}");
    }

    /// A sample between two instants of the grid, and an event and a time asked for that are the same.
    #[test]
    fn a_time_may_be_that_of_a_sample() {
        let system = System::builder().mass("m", 1.0).spring(GROUND, "m", 1.0);
        let system = system.build().expect("a system");
        let (values, hold) = (vec![0.0, 1.0], crate::Hold::Zero);
        let samples = crate::Samples {
            step: 0.25,
            values,
            hold,
        };
        let ask = Response::of(&system).load("m", samples);
        let ask = ask.load("m", crate::Impulse::of(2.0).at(0.25));
        let problem = ask.every(1.0).until(4.0).problem().expect("a problem");
        let motion = ByCertifiedExponential.at(&problem, &[0.25, 0.75]);
        let motion = motion.expect("a motion");
        assert_eq!(
            (motion.displacement()[(0, 0)], motion.velocity()[(0, 0)]),
            (0.0, 2.0)
        );
        let wanted = 2.0 * 0.5f64.sin() + 1.0 - 0.5f64.cos();
        assert!((motion.displacement()[(0, 1)] - wanted).abs() < 1e-15);
    }

    /// A bound beyond the doubles says nothing, even where the one in more digits is finite: the two swing against each other,
    /// and are lost in what could have become of them together.
    #[test]
    fn a_bound_beyond_the_doubles_is_no_bound() {
        let system = System::builder()
            .mass("a", 1.0)
            .mass("b", 1.0)
            .spring(GROUND, "a", -1e8)
            .spring(GROUND, "b", -1e8)
            .spring("a", "b", 1e8);
        let system = system.build().expect("a system");
        let apart = State::at_rest().displace("a", 1.0).displace("b", -1.0);
        let ask = Response::of(&system).from(apart);
        let problem = ask.every(1.0).until(1.0).problem().expect("a problem");
        match ByCertifiedExponential.run(&problem) {
            Err(ResponseError::Lost { index: 1, .. }) => {}
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn rounding_to_a_double_is_counted() {
        let third = DoubleDouble::from(1.0) / DoubleDouble::from(3.0);
        let known = Magnitude::from(1e-20);
        let (value, bound) = rounded(third, known);
        let off = (third - DoubleDouble::from(value)).to_f64().abs();
        assert!(off > 0.0, "nothing was rounded");
        let worst = off + known.to_f64();
        assert!(
            bound.to_f64() >= worst * (1.0 - 1e-15),
            "{bound:?} {worst:e}"
        );
    }
}
