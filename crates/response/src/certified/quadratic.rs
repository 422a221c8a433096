//! Sums of squares along a motion, at its instants and over time, with proven bounds.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use eigentone_digits::{DoubleDouble, Magnitude, Real, Wide};
use eigentone_modes::Form;

use super::driven::{Driven, KnownVector};
use super::march::{Walker, length};
use super::stepper::Stepper;
use crate::enclosed::{Normed, gramian, growth};
use crate::problem::{Instant, Known, Leg, Problem, Walk, sum};

/// Σ c·(r₁ − r₂)², or c·r₁²: of the displacements of coordinates and, beyond them, of supports, or of their velocities.
pub(crate) struct Squares<T> {
    /// Which derivative.
    pub(crate) order: usize,
    /// Each c and what it belongs to.
    pub(crate) terms: Vec<(Known<T>, usize, Option<usize>)>,
}

/// What is known of three sums: of two at an instant, and of the integral of the third from 0 on.
pub(crate) type Sums<T> = [Known<T>; 3];

/// A problem in an arithmetic, to be followed once.
pub(crate) struct Course<'a, 'b, T>(Driven<'a, 'b, T>);

/// Why nothing is known.
const EXPENSIVE: &str = "it would take too long: there are too many states, or instants";
const LOST: &str = "the digits do not suffice to follow it";

impl<'a, 'b> Course<'a, 'b, DoubleDouble> {
    /// With 32 digits.
    ///
    /// # Errors
    /// The reason why there is none.
    pub(crate) fn of(
        problem: &'a Problem<'b>,
    ) -> Result<Course<'a, 'b, DoubleDouble>, &'static str> {
        /// What may be lost of 32 digits.
        const LEAST: f64 = 1e-26;
        Course::by(problem, || Stepper::precise(problem, LEAST))
    }
}

impl<'a, 'b> Course<'a, 'b, Wide<4>> {
    /// With 77 digits.
    ///
    /// # Errors
    /// The reason why there is none.
    pub(crate) fn with_more(
        problem: &'a Problem<'b>,
    ) -> Result<Course<'a, 'b, Wide<4>>, &'static str> {
        Course::by(problem, || Stepper::of::<Wide<4>>(problem))
    }
}

impl<'a, 'b, T: Real> Course<'a, 'b, T> {
    fn by(
        problem: &'a Problem<'b>,
        stepper: impl FnOnce() -> Option<Stepper<T>>,
    ) -> Result<Course<'a, 'b, T>, &'static str> {
        if cost::<T>() * 100.0 * (2.0 * problem.system().len() as f64).powi(3) > MOST {
            return Err(EXPENSIVE);
        }
        let supports = 0..problem.system().supports().len();
        let forms: Vec<Form> = supports
            .map(|support| Form {
                supports: vec![(support, 1.0)],
                ..Form::default()
            })
            .collect();
        let driven = match forms.is_empty() {
            true => stepper().map(|stepper| Driven::new(problem, stepper, 0)),
            false => Driven::of::<Wide<4>>(problem, &forms).ok().flatten(),
        };
        driven.map(Course).ok_or(LOST)
    }

    /// Before loads, impulses and motions of supports set in, and at these instants of the grid, which rise.
    ///
    /// # Errors
    /// The reason why nothing is known.
    pub(crate) fn sums(
        self,
        instants: &[u64],
        held: [&Squares<T>; 2],
        taken: &Squares<T>,
    ) -> Result<(Sums<T>, Vec<Sums<T>>), &'static str> {
        let Course(driven) = self;
        let problem = driven.problem;
        let rows = |squares: &Squares<T>| Rows::of(&driven, problem, squares);
        let (held, taken) = (held.map(rows), rows(taken));
        let (w, rate) = (driven.generator.w.transposed(), taken.form(driven.len()));
        let size = driven.len() as f64;
        let mut spent = 2.0 * cost::<T>() * size.powi(2) * instants.len() as f64;
        // Sines run from the start, so that what they would do at once is taken off.
        let (mut before, off) = driven.start();
        before[driven.generator.states..].fill(T::ZERO);
        let initially = held.each_ref().map(|rows| rows.value(&before, off));
        let mut walker = Walker::new(driven);
        let mut walk = Walk::of(problem);
        let nothing = (T::ZERO, Magnitude::ZERO);
        let mut passed = nothing;
        let mut integrals: HashMap<[u64; 2], Normed<T>> = HashMap::new();
        walker.begin(0);
        walker.prepare_all(instants.len() as u64);
        let mut found = Vec::with_capacity(instants.len());
        for index in instants {
            let target = Instant::on_grid(problem.grid(), *index);
            while let Some(leg) = walk.towards(&target) {
                let Leg::Pass { from, to } = leg else {
                    walker.begin(walk.index());
                    continue;
                };
                let (from, to) = (walker.moment(&from), walker.moment(&to));
                let (step, off) = walker.seconds(from, to);
                if !taken.0.is_empty() && !step.is_zero() {
                    let high = step.to_f64();
                    let low = (step - T::from(high)).to_f64();
                    let integral = match integrals.entry([high, low].map(f64::to_bits)) {
                        Entry::Occupied(known) => known.into_mut(),
                        Entry::Vacant(free) => {
                            let turns = (w.true_norm() * step.upper()).log2().max(0.0);
                            spent += cost::<T>() * (50.0 + 3.0 * turns) * size.powi(3);
                            let known = (step, off / step.magnitude());
                            match spent > MOST {
                                true => return Err(EXPENSIVE),
                                false => free.insert(gramian(&w, &rate, known, false).ok_or(LOST)?),
                            }
                        }
                    };
                    passed = sum(passed, form(integral, &mut walker));
                }
                walker.go(from, to);
            }
            let off = walker.error();
            let [first, second] = held.each_ref().map(|rows| rows.value(walker.exact(), off));
            found.push([first, second, passed]);
        }
        let [first, second] = initially;
        Ok(([first, second, nothing], found))
    }
}

/// The most products of two numbers in double-double: some ten seconds.
const MOST: f64 = 4e9;

/// What a product takes beside one in double-double.
fn cost<T: Real>() -> f64 {
    (f64::from(T::UNIT_LOG2) / f64::from(DoubleDouble::UNIT_LOG2)).powi(2)
}

/// ζᵀPζ.
fn form<T: Real>(p: &Normed<T>, walker: &mut Walker<'_, '_, T>) -> Known<T> {
    let off = walker.error();
    let zeta = walker.exact();
    let n = zeta.len();
    let rows = (0..n).map(|i| zeta[i] * dot(p.row(i), zeta));
    let value = rows.fold(T::ZERO, |sum, row| sum + row);
    let size = length(zeta);
    let moved = p.true_norm() * off * (size + size + off);
    let rounding = growth::<T>(2 * n) * p.sizes() * size * size;
    (
        value,
        p.error() * size * size + moved + rounding + lost::<T>(n),
    )
}

/// Rows whose squares, each with a factor, are added up.
struct Rows<T>(Vec<Row<T>>);

struct Row<T> {
    factor: Known<T>,
    entries: Vec<T>,
    /// In the 2-norm.
    norm: Magnitude,
    error: Magnitude,
}

impl<T: Real> Rows<T> {
    fn of(driven: &Driven<'_, '_, T>, problem: &Problem<'_>, squares: &Squares<T>) -> Rows<T> {
        let n = problem.system().len();
        let place = |at: usize| -> KnownVector<T> {
            let [x, v] = match at.checked_sub(n) {
                None => driven.coordinate(at),
                Some(support) => driven.form(support),
            };
            if squares.order == 0 { x } else { v }
        };
        let row = |&(factor, at, other): &(Known<T>, usize, Option<usize>)| {
            let (mut entries, mut error) = place(at);
            if let Some(other) = other {
                let (less, off) = place(other);
                let pairs = entries.iter_mut().zip(less);
                pairs.for_each(|(entry, less)| *entry = *entry - less);
                error = error + off + length(&entries) * T::unit();
            }
            Row {
                factor,
                norm: length(&entries),
                entries,
                error,
            }
        };
        Rows(squares.terms.iter().map(row).collect())
    }

    /// The sum for states and loads that are known to so much.
    fn value(&self, zeta: &[T], off: Magnitude) -> Known<T> {
        let (n, size) = (zeta.len(), length(zeta));
        let (mut total, mut sizes) = (T::ZERO, Magnitude::ZERO);
        let mut error = Magnitude::ZERO;
        for row in &self.0 {
            let (factor, factor_off) = row.factor;
            let value = dot(&row.entries, zeta);
            let rounding = growth::<T>(n) * row.norm * size + lost::<T>(n);
            let own = row.norm * off + row.error * (size + off) + rounding;
            let square = factor * value * value;
            total = total + square;
            sizes = sizes + square.upper();
            let far = value.upper() + own;
            error = error + factor.upper() * own * (far + far) + factor_off * far * far;
        }
        let rounding = growth::<T>(self.0.len() + 2) * sizes;
        (total, error + rounding + lost::<T>(self.0.len()))
    }

    /// The sum as a form of states and loads.
    fn form(&self, n: usize) -> Normed<T> {
        let mut entries = vec![T::ZERO; n * n];
        let (mut sizes, mut error) = (Magnitude::ZERO, Magnitude::ZERO);
        for row in &self.0 {
            let (factor, factor_off) = row.factor;
            for (i, one) in row.entries.iter().enumerate() {
                let terms = [(factor * *one, &row.entries[..])];
                if !one.is_zero() {
                    T::add_multiples(&mut entries[i * n..][..n], &terms);
                }
            }
            let far = row.norm + row.error;
            sizes = sizes + factor.upper() * row.norm * row.norm;
            error = error + factor.upper() * row.error * (far + far) + factor_off * far * far;
        }
        let rounding = growth::<T>(self.0.len() + 2) * sizes;
        let error = error + rounding + lost::<T>(n * n * self.0.len());
        Normed::new(n, n, entries, error)
    }
}

fn dot<T: Real>(a: &[T], b: &[T]) -> T {
    let products = a.iter().zip(b).map(|(a, b)| *a * *b);
    products.fold(T::ZERO, |sum, product| sum + product)
}

/// What so many products may lose below the smallest numbers.
fn lost<T: Real>(count: usize) -> Magnitude {
    T::floor() * Magnitude::from(4.0 * (count + 1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Response, State};
    use eigentone_modes::{GROUND, System};

    /// What 32 digits say of a stiff motion is within its bounds of what 77 say: the errors of the steps, which squares of the
    /// exponential enlarge, are most of it.
    #[test]
    fn errors_of_the_state_are_counted() {
        let system = System::builder().mass("a", 1.0).mass("b", 3.0);
        let system = system.spring(GROUND, "a", 1e12).spring("a", "b", 2.0);
        let system = system.damper("a", "b", 1e-3).build().expect("a system");
        let ask = Response::of(&system).from(State::at_rest().push("a", 1.0).push("b", 0.3));
        let problem = ask.every(0.7).until(70.0).problem().expect("a problem");
        fn energies<T: Real>(course: Course<'_, '_, T>) -> Vec<Sums<T>> {
            let factor = |value: f64| (T::from(value), Magnitude::ZERO);
            let squares = |order, terms| Squares { order, terms };
            let mass = squares(1, vec![(factor(1.0), 0, None), (factor(3.0), 1, None)]);
            let spring = squares(0, vec![(factor(1e12), 0, None), (factor(2.0), 0, Some(1))]);
            let damper = squares(1, vec![(factor(1e-3), 0, Some(1))]);
            let instants: Vec<u64> = (0..=100).collect();
            let found = course.sums(&instants, [&mass, &spring], &damper);
            found.expect("few states").1
        }
        let few = energies(Course::of(&problem).expect("digits"));
        let many = energies(Course::with_more(&problem).expect("digits"));
        let mut worst = [0.0f64; 3];
        for (few, many) in few.iter().zip(&many) {
            for (worst, (few, many)) in worst.iter_mut().zip(few.iter().zip(many)) {
                let wide = Wide::<4>::from(few.0.high()) + Wide::from(few.0.low());
                let off = (wide - many.0).upper();
                let bound = few.1 + many.1;
                assert!(off <= bound, "{:e} {:e}", off.to_f64(), bound.to_f64());
                assert!(many.1.to_f64() < 1e-60);
                *worst = worst.max((off / bound).to_f64());
            }
        }
        assert!(
            worst.iter().all(|ratio| *ratio > 1e-6),
            "idle bounds: {worst:?}"
        );
    }
}
