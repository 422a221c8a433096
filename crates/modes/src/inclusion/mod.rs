//! Proven discs for all roots of the quadratic eigenproblem. It knows `first_order`, `model`, `modes`, `structure` and
//! `system`.

mod approximate_inverse;
pub(crate) mod bounded_shape;
pub(crate) mod classical;
pub(crate) mod congruence;
mod contraction;
mod exactly;
mod gram;
pub(crate) mod groups;
mod inert;
mod moved;
pub(crate) mod pairs;
mod pencil;
pub(crate) mod quadratic;
pub(crate) mod rayleigh;
mod refine;
pub(crate) mod shape;
mod sliced;
pub(crate) mod slow;
pub(crate) mod springless;
mod summed;
mod weierstrass;

use std::cell::OnceCell;

use eigentone_digits::{Ball, DoubleDouble, Magnitude, Real, Wide, WideComplex, decimal_digits};

use num_complex::Complex;

use crate::first_order::Massless;
use crate::structure::Structure;
use crate::system::System;

use contraction::{Approximate, Equations};
use exactly::{Terms, exact, lower, radius, size, terms, upper};
use pencil::{Eliminated, Pencil, Scaled, product};
use refine::{Goal, Level, refine};
use shape::{Disc, Kind, Shaper, Shapes};
use weierstrass::{Inclusion, Points, Polynomial};

/// Where digits end, relative to |λ|.
pub(crate) const LIMIT: f64 = 1e-30;

/// One root, or a cluster that the digits do not separate, with its proven disc.
#[derive(Clone, Debug)]
pub(crate) struct Certified {
    /// Indices of the approximations it came from.
    pub(crate) members: Vec<usize>,
    /// Im ≥ 0 unless its conjugate is listed as well.
    pub(crate) value: Complex<f64>,
    pub(crate) bound: f64,
    pub(crate) real_bound: f64,
    /// x and y with bounds, for each root of the disc; `None` where they are not proved to be one each.
    pub(crate) shapes: Option<Shapes>,
    /// Of μ, or of its square.
    disc: Disc,
}

/// What is known of a root beforehand.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Approximation<'a> {
    pub(crate) value: Complex<f64>,
    /// Whether its disc has to be small.
    pub(crate) is_wanted: bool,
    /// For Im λ ≥ 0; of no use where it is empty.
    pub(crate) shape: &'a [Complex<f64>],
}

#[cfg(test)]
impl Approximation<'_> {
    /// Of a root whose shape is not known.
    fn of(value: Complex<f64>) -> Self {
        Approximation {
            value,
            is_wanted: true,
            shape: &[],
        }
    }
}

/// Proves a disc for each of the nonzero finite roots, given approximations of all of them (conjugates included), and the decimal
/// digits that took: one by one, or by determinants with not many more than `most_work` operations; `None` where the count of roots
/// is not known or no proof was reached.
pub(crate) fn certify(
    system: &System,
    approximations: &[Approximation<'_>],
    tolerance: f64,
    most_work: f64,
) -> Option<(Vec<Certified>, usize)> {
    let structure = system.structure();
    let degree = structure.finite_roots()?;
    let zeros = structure.zero_roots()?;
    if approximations.len() != degree - zeros {
        return None;
    }
    if approximations.is_empty() {
        return Some((Vec::new(), 0));
    }
    let values = approximations.iter().map(|root| root.value.norm());
    let size = values.fold(0.0, f64::max);
    if !size.is_finite() || size == 0.0 {
        return None;
    }
    let unit = size.log2().round() as i32;
    let in_square = structure.is_undamped() && structure.is_symmetric() && structure.is_passive();
    // In σ = λ² one point stands for each conjugate pair, and every second one for real approximations, which are of pairs too.
    let mut reals = 0;
    let mut stands_for_pair = |z: Complex<f64>| {
        reals += usize::from(z.im == 0.0);
        z.im > 0.0 || z.im == 0.0 && reals % 2 == 1
    };
    let chosen: Vec<usize> = (0..approximations.len())
        .filter(|i| !in_square || stands_for_pair(approximations[*i].value))
        .collect();
    let job = Job {
        system,
        structure,
        pencil: Pencil::of(system, in_square),
        in_square,
        degree,
        zeros,
        tolerance,
        wanted: chosen
            .iter()
            .map(|i| approximations[*i].is_wanted)
            .collect(),
    };
    let start: Vec<Complex<f64>> = chosen
        .iter()
        .map(|i| {
            let z = approximations[*i].value * 2f64.powi(-unit);
            if in_square {
                let size = if z.im == 0.0 { z.re } else { z.im };
                Complex::from(-size * size)
            } else {
                z
            }
        })
        .collect();
    let shapes: Vec<&[Complex<f64>]> = chosen.iter().map(|i| approximations[*i].shape).collect();
    let contracted = job.contracted(unit, &start, &shapes);
    let (mut found, digits) = match contracted {
        Some(found) => (found, decimal_digits(2)),
        None if most_work > 0.0 => job.levels(unit, &start, most_work)?,
        None => return None,
    };
    for disc in &mut found {
        for member in &mut disc.members {
            *member = chosen[*member];
        }
    }
    Some((found, digits))
}

/// The shapes at simple roots, each given within a bound; `None` where they are not proved to be one each.
pub(crate) fn shapes_at(
    system: &System,
    discs: &[(Complex<f64>, f64)],
    tolerance: f64,
) -> Vec<Option<Shapes>> {
    let structure = system.structure();
    let sizes = discs.iter().map(|(value, _)| value.norm());
    let size = sizes.fold(0.0, f64::max);
    if !(size > 0.0 && size.is_finite()) {
        return vec![None; discs.len()];
    }
    let unit = size.log2().round() as i32;
    let pencil = Pencil::of(system, false);
    let goal = shape::Goal {
        tolerance,
        symmetric: structure.is_symmetric(),
        roots: 2 * discs.len(),
    };
    let shaper = Shaper::of(&pencil, unit, goal);
    let kind = Kind {
        is_simple: true,
        is_real: structure.is_classical(),
    };
    let shapes = |(value, bound): &(Complex<f64>, f64)| {
        let part = |part: f64| DoubleDouble::from(part).scale(-i64::from(unit));
        let centre = exact(part(value.re), part(value.im)).middle();
        let reach = Magnitude::from(*bound) * Magnitude::power_of_two(-i64::from(unit));
        let disc = Disc::of(Ball::new(centre, reach + DoubleDouble::floor()));
        shaper.shapes(disc, kind)
    };
    discs.iter().map(shapes).collect()
}

/// The shapes at λ = 0 of a system with det K = 0; `None` where K is not proved to annul one alone.
pub(crate) fn at_rest(system: &System, tolerance: f64) -> Option<Shapes> {
    let pencil = Pencil::of(system, false);
    let goal = shape::Goal {
        tolerance,
        symmetric: system.structure().is_symmetric(),
        roots: 1,
    };
    let kind = Kind {
        is_simple: true,
        is_real: true,
    };
    Shaper::of(&pencil, 0, goal).shapes(Disc::of(Ball::<DoubleDouble>::ZERO), kind)
}

/// The work of one level.
type Work = fn(&Job<'_>, i32, &[[Terms; 2]], u64) -> Outcome;

/// What a level leaves behind.
struct Outcome {
    points: Vec<[Terms; 2]>,
    proven: Option<Vec<Certified>>,
    done: bool,
    /// How many it took.
    products: u64,
}

/// Each precision, by its limbs, and the work in it.
const LEVELS: [(usize, Work); 6] = [
    (2, level::<DoubleDouble>),
    (4, level::<Wide<4>>),
    (8, level::<Wide<8>>),
    (16, level::<Wide<16>>),
    (32, level::<Wide<32>>),
    (64, level::<Wide<64>>),
];

fn level<T: Real>(job: &Job<'_>, unit: i32, start: &[[Terms; 2]], most: u64) -> Outcome {
    job.level::<T>(unit, start, most)
}

/// What stays the same at every level of precision.
struct Job<'a> {
    system: &'a System,
    structure: &'a Structure,
    pencil: Pencil,
    in_square: bool,
    degree: usize,
    zeros: usize,
    tolerance: f64,
    /// Which points have roots that are wanted.
    wanted: Vec<bool>,
}

impl Job<'_> {
    /// The limbs that the clusters so far ask for: where m roots lie within r of each other, the polynomial is below r^m, and a root of
    /// multiplicity m is known to `LIMIT` only with m times its digits.
    fn limbs(&self, best: &Option<Vec<Certified>>) -> usize {
        const MOST: f64 = 110.0;
        /// Beyond what distinguishes the disc of a cluster from a point, for each root.
        const MORE: f64 = 16.0;
        let bits = |disc: &Certified| {
            let each = (disc.value.norm() / disc.bound).log2() + MORE;
            disc.members.len() as f64 * each.min(MOST)
        };
        let is_wanted = |disc: &&Certified| disc.members.iter().any(|i| self.wanted[*i]);
        let discs = best.iter().flatten().filter(is_wanted);
        let clusters = discs.filter(|disc| disc.members.len() > 1);
        let most = clusters.map(bits).fold(0.0, f64::max);
        if most > 0.0 {
            ((most + 64.0) / 64.0).ceil().min(64.0) as usize
        } else {
            0
        }
    }

    /// Every root by itself with its shape; `None` where one is not proved, or not as closely as it has to be.
    fn contracted(
        &self,
        unit: i32,
        start: &[Complex<f64>],
        shapes: &[&[Complex<f64>]],
    ) -> Option<Vec<Certified>> {
        if shapes.iter().any(|shape| shape.is_empty()) {
            return None;
        }
        let (precise, _) = self.pencil.precise::<DoubleDouble>(unit);
        let equations = Equations::of(&precise)?;
        let goal = self.goal(0);
        let mut discs: Vec<Inclusion<DoubleDouble>> = Vec::with_capacity(start.len());
        let mut known = Vec::with_capacity(start.len());
        for (i, root) in start.iter().enumerate() {
            let disc = |centre| Inclusion {
                members: vec![i],
                centre,
            };
            match discs.last() {
                Some(before) if root.im < 0.0 && start[i - 1] == root.conj() => {
                    let ball = before.centre;
                    discs.push(disc(Ball::new(ball.middle().conj(), ball.radius())));
                    known.push(Vec::new());
                }
                _ => {
                    let shape = precise.in_units(shapes[i])?;
                    let is_close = |root| goal.meets(&[i], root);
                    let found = equations.solve(Approximate { root: *root, shape }, is_close)?;
                    discs.push(disc(found.root));
                    known.push(precise.in_coordinates(&found.shape));
                    if !is_close(found.root) {
                        return None;
                    }
                }
            }
        }
        if !are_apart(&discs) || !useful(&discs) {
            return None;
        }
        let mut found = self.proven(&discs, unit)?;
        self.shape(unit, &mut found, &known);
        Some(found)
    }

    /// Discs by determinants, level by level, and the decimal digits that they took.
    fn levels(
        &self,
        unit: i32,
        start: &[Complex<f64>],
        most_work: f64,
    ) -> Option<(Vec<Certified>, usize)> {
        let mut points: Vec<[Terms; 2]> = start
            .iter()
            .map(|z| [z.re, z.im].map(|part| [part, 0.0, 0.0, 0.0]))
            .collect();
        let mut best = None;
        let mut digits = 0;
        let mut left = most_work;
        for (limbs, level) in LEVELS {
            if limbs > 2 && (limbs < self.limbs(&best) || !self.pencil.affords(limbs, self.degree))
            {
                continue;
            }
            let product = product(limbs);
            let outcome = level(self, unit, &points, (left / product) as u64);
            left -= product * outcome.products as f64;
            points = outcome.points;
            let done = outcome.done;
            if outcome.proven.is_some() {
                best = outcome.proven;
                digits = decimal_digits(limbs);
            }
            if done {
                break;
            }
        }
        let mut found = best?;
        self.shape(unit, &mut found, &[]);
        Some((found, digits))
    }

    /// How small discs must become, by so many products.
    fn goal(&self, most: u64) -> Goal<'_> {
        Goal {
            tolerance: self.tolerance,
            limit: LIMIT,
            real_parts: !self.in_square,
            wanted: &self.wanted,
            most,
        }
    }

    /// One level: the polynomial in the precision of T, refined from the given points by about so many products at most.
    fn level<T: Real>(&self, unit: i32, start: &[[Terms; 2]], most: u64) -> Outcome {
        let (precise, total) = self.pencil.precise::<T>(unit);
        let is_determined = Massless::of_system(self.system).degree() == self.degree;
        let leading = is_determined.then(|| {
            let mut leading = leading::<T>(self.system, &self.pencil);
            leading.exponent += i64::from(unit) * self.degree as i64 - total;
            leading
        });
        let halves = if self.in_square { 2 } else { 1 };
        let polynomial = Polynomial {
            pencil: precise,
            zeros: self.zeros / halves,
            leading,
        };
        let sum = |terms: Terms| {
            terms[1..]
                .iter()
                .fold(T::from(terms[0]), |sum, term| sum + T::from(*term))
        };
        let z = start
            .iter()
            .map(|[re, im]| exact(sum(*re), sum(*im)))
            .collect();
        let mut points = Points::new(z);
        let (discs, done) = match refine(&polynomial, &mut points, &self.goal(most)) {
            Level::Done(discs) => (Some(discs), true),
            Level::Proven(discs) => (Some(discs), false),
            Level::Failed => (None, false),
        };
        let useful = discs.filter(|discs| useful(discs));
        let proven = useful.and_then(|discs| self.proven(&discs, unit));
        let products = points.products;
        let points = points
            .z
            .iter()
            .map(|z| [terms(z.middle().re), terms(z.middle().im)])
            .collect();
        Outcome {
            points,
            done: done && proven.is_some(),
            proven,
            products,
        }
    }

    /// Roots from discs that are apart from each other, each of which holds as many as it has members; `None` where they are not all.
    fn proven<T: Real>(&self, discs: &[Inclusion<T>], unit: i32) -> Option<Vec<Certified>> {
        if self.in_square {
            return discs.iter().map(|disc| square_root(disc, unit)).collect();
        }
        let found = self.in_plane(discs, unit);
        let pairs = |root: &Certified| if root.value.im == 0.0 { 1 } else { 2 };
        let count: usize = found
            .iter()
            .map(|root| pairs(root) * root.members.len())
            .sum();
        (count == self.degree - self.zeros).then_some(found)
    }

    /// Discs in λ as doubles with bounds; of conjugate discs the upper one.
    fn in_plane<T: Real>(&self, discs: &[Inclusion<T>], unit: i32) -> Vec<Certified> {
        let mut found = Vec::new();
        for (at, disc) in discs.iter().enumerate() {
            let ball = disc.centre;
            let height = ball.middle().im.to_f64().abs();
            // A disc about the real axis that holds this one and meets no other holds the
            // conjugates of its own roots.
            let reach = Magnitude::from((radius(ball) + height) * (1.0 + 1e-9));
            let around = Ball::new(
                WideComplex {
                    im: T::ZERO,
                    ..ball.middle()
                },
                reach,
            );
            let is_alone = |around: Ball<T>| {
                let mut discs = discs.iter().enumerate();
                discs.all(|(other, disc)| other == at || lower(disc.centre - around) > 0.0)
            };
            if height <= radius(ball) && is_alone(around) {
                found.push(self.rounded(&disc.members, around, unit, true));
            } else if ball.middle().im.to_f64() > 0.0 {
                // Without damping −λ̄ is a root with λ: a disc about the imaginary axis that holds one root has it there.
                let width = ball.middle().re.to_f64().abs();
                let reach = Magnitude::from((radius(ball) + width) * (1.0 + 1e-9));
                let upright = WideComplex {
                    re: T::ZERO,
                    ..ball.middle()
                };
                let is_imaginary = self.structure.is_undamped()
                    && disc.members.len() == 1
                    && width <= radius(ball)
                    && is_alone(Ball::new(upright, reach));
                let root = self.rounded(&disc.members, ball, unit, false);
                found.push(if is_imaginary {
                    Certified {
                        real_bound: 0.0,
                        ..root
                    }
                } else {
                    root
                });
            }
        }
        found
    }

    /// Gives each root its shapes, some of which may be known by its first member.
    fn shape(&self, unit: i32, found: &mut [Certified], known: &[Vec<Ball<DoubleDouble>>]) {
        let goal = shape::Goal {
            tolerance: self.tolerance,
            symmetric: self.structure.is_symmetric(),
            roots: self.degree,
        };
        let shaper = OnceCell::new();
        let still = self.undamped_ones_are_known(found);
        for root in found {
            let is_simple = root.members.len() == 1;
            // A simple real root of real matrices, or of what one set of real shapes diagonalises.
            let is_real = is_simple
                && (root.value.im == 0.0
                    || self.in_square
                    || self.structure.is_classical()
                    || (still && root.value.re == 0.0));
            let kind = Kind { is_simple, is_real };
            let known = known.get(root.members[0]);
            root.shapes = known.and_then(|known| goal.known(known, kind)).or_else(|| {
                let shaper = shaper.get_or_init(|| Shaper::of(&self.pencil, unit, goal));
                shaper.shapes(root.disc, kind)
            });
        }
    }

    /// Whether the roots given as imaginary are all undamped modes, K x = ω²M x with C x = 0: as many as there
    /// are.
    fn undamped_ones_are_known(&self, found: &[Certified]) -> bool {
        let still = |root: &&Certified| root.value.re == 0.0 && root.value.im != 0.0;
        let count = found.iter().filter(still).map(|root| root.members.len());
        let count: usize = count.sum();
        count > 0
            && !self.structure.is_gyroscopic()
            && self.structure.undamped_modes() == Some(count)
    }

    /// The double nearest to a disc's centre, and how far its roots may lie from that.
    fn rounded<T: Real>(
        &self,
        members: &[usize],
        ball: Ball<T>,
        unit: i32,
        real: bool,
    ) -> Certified {
        let middle = ball.middle();
        let hidden = middle.re.upper() <= ball.radius();
        let is_zero = hidden && !real || (self.structure.is_passive() && middle.re > T::ZERO);
        let power = i64::from(unit);
        // What is not 0 keeps its sign where it leaves the range of doubles.
        let part = |part: T| match part.scale(power).to_f64() {
            0.0 if part > T::ZERO => f64::from_bits(1),
            0.0 if part < T::ZERO => -f64::from_bits(1),
            value => value,
        };
        let re = if is_zero { 0.0 } else { part(middle.re) };
        let im = if real { 0.0 } else { part(middle.im) };
        let off = |part: T, double: f64| (part.scale(power) - T::from(double)).to_f64().abs();
        let (re_error, im_error) = (off(middle.re, re), off(middle.im, im));
        let reach = times_power(radius(ball), unit);
        let is_exact = re_error == 0.0 && im_error == 0.0 && ball.radius().is_zero();
        let is_imaginary = re == 0.0 && !real && self.structure.is_gyroscopic();
        let enlarged = |bound: f64| match is_exact {
            true => 0.0,
            false => bound * (1.0 + 1e-9) + f64::from_bits(1),
        };
        Certified {
            members: members.to_vec(),
            value: Complex::new(re, im),
            bound: enlarged(reach + re_error.hypot(im_error)),
            real_bound: if is_imaginary {
                0.0
            } else {
                enlarged(reach + re_error)
            },
            shapes: None,
            disc: Disc::of(ball),
        }
    }
}

/// Whether no two discs meet.
fn are_apart(discs: &[Inclusion<DoubleDouble>]) -> bool {
    let meets = |a: &Inclusion<_>, b: &Inclusion<_>| (a.centre - b.centre).contains_zero();
    let mut pairs = (1..discs.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    !pairs.any(|(i, j)| meets(&discs[i], &discs[j]))
}

/// Whether every disc gives at least the size of its roots to some digits, and so holds none at 0.
fn useful<T: Real>(discs: &[Inclusion<T>]) -> bool {
    discs
        .iter()
        .all(|disc| radius(disc.centre) <= 1e-6 * size(disc.centre))
}

/// 2^unit·value, for results within the range of doubles.
fn times_power(value: f64, unit: i32) -> f64 {
    value.scale(i64::from(unit))
}

/// 2^unit·bound and a little more, never 0 unless the bound is.
fn enlarged(bound: f64, unit: i32) -> f64 {
    let scaled = times_power(bound * (1.0 + 1e-9), unit);
    if bound > 0.0 {
        scaled.max(f64::from_bits(1))
    } else {
        0.0
    }
}

/// λ = iω from a disc about σ = −ω².
fn square_root<T: Real>(disc: &Inclusion<T>, unit: i32) -> Option<Certified> {
    // All σ are real, so the disc's section with the real axis holds them.
    let square = -disc.centre.middle().re;
    let spread = radius(disc.centre);
    if square.to_f64() <= 2.0 * spread {
        return None;
    }
    // |√σ − ω| = |σ − ω²| / (√σ + ω) for any ω > 0.
    let omega = square.to_f64().sqrt();
    let ball = exact(T::from(omega), T::ZERO);
    let defect = upper(ball * ball - exact(square, T::ZERO)) + spread;
    Some(Certified {
        members: disc.members.clone(),
        value: Complex::new(0.0, times_power(omega, unit)),
        bound: enlarged(defect / omega, unit),
        real_bound: 0.0,
        shapes: None,
        disc: Disc::of(disc.centre),
    })
}

/// The coefficient of the highest power in det(λ²M + λC + K): det M of the coordinates with mass,
/// times det C of the relaxing states, times det K of the parts that follow at once.
fn leading<T: Real>(system: &System, pencil: &Pencil) -> Scaled<T> {
    let massless = Massless::of_system(system);
    let mass_power = if pencil.in_square { 1 } else { 2 };
    let mut result = Scaled::one();
    for (power, parts) in [
        (
            mass_power,
            massless.massive().iter().map(|i| vec![*i]).collect(),
        ),
        (
            1,
            massless.relaxing_nodes().iter().map(|i| vec![*i]).collect(),
        ),
        (0, massless.following_groups()),
    ] as [(usize, Vec<Vec<usize>>); 3]
    {
        if parts.is_empty() {
            continue;
        }
        let block = pencil.block::<T>(power, &parts);
        let factor = Eliminated::of(block, parts.len()).determinant;
        result = result.times(factor.ball);
        result.exponent += factor.exponent;
    }
    result
}
