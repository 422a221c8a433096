//! Proven discs for all roots of the quadratic eigenproblem.

pub(crate) mod classical;
pub(crate) mod congruence;
mod exactly;
mod gram;
pub(crate) mod pairs;
mod pencil;
pub(crate) mod quadratic;
pub(crate) mod rayleigh;
mod refine;
pub(crate) mod springless;
mod weierstrass;

use eigentone_digits::{Ball, DoubleDouble, Magnitude, Real, Wide, WideComplex};

use num_complex::Complex;

use crate::first_order::Massless;
use crate::structure::Structure;
use crate::system::System;

use exactly::{exact, lower, radius, size, upper};
use pencil::{Eliminated, Pencil, PencilIn, Scaled};
use refine::{Goal, Level, refine};
use weierstrass::{Inclusion, Points, Polynomial};

/// Where digits end, relative to |λ|.
const LIMIT: f64 = 1e-30;

/// One root, or a cluster that the digits do not separate, with its proven disc.
#[derive(Clone, Debug)]
pub(crate) struct Certified {
    /// Indices of the approximations it came from.
    pub(crate) members: Vec<usize>,
    /// Im ≥ 0 unless its conjugate is listed as well.
    pub(crate) value: Complex<f64>,
    pub(crate) bound: f64,
    pub(crate) real_bound: f64,
    /// x and y at a simple root; `None` where it is not simple or the digits do not tell, and y
    /// where it follows from x by symmetry.
    pub(crate) shape: Option<Vec<Complex<f64>>>,
    pub(crate) left: Option<Vec<Complex<f64>>>,
}

/// Proves a disc for each of the nonzero finite roots, given approximations of all of them
/// (conjugates included), and the decimal digits that took; `None` where the count of roots is not known or no proof was reached.
pub(crate) fn certify(
    system: &System,
    structure: &Structure,
    approximations: &[Complex<f64>],
    tolerance: f64,
) -> Option<(Vec<Certified>, usize)> {
    let degree = structure.finite_roots()?;
    let zeros = structure.zero_roots()?;
    if approximations.len() != degree - zeros {
        return None;
    }
    if approximations.is_empty() {
        return Some((Vec::new(), 0));
    }
    let in_square = structure.is_undamped() && structure.is_symmetric() && structure.is_passive();
    let pencil = Pencil::of(system, in_square);
    let job = Job {
        system,
        structure,
        pencil,
        in_square,
        degree,
        zeros,
        determined: Massless::of_system(system).degree() == degree,
        tolerance,
    };
    let size = approximations.iter().map(|z| z.norm()).fold(0.0, f64::max);
    if !size.is_finite() || size == 0.0 {
        return None;
    }
    let unit = size.log2().round() as i32;
    // In σ = λ² one point stands for each conjugate pair.
    let chosen: Vec<usize> = (0..approximations.len())
        .filter(|i| !in_square || approximations[*i].im > 0.0)
        .collect();
    let start: Vec<Complex<f64>> = chosen
        .iter()
        .map(|i| {
            let z = approximations[*i] * 2f64.powi(-unit);
            if in_square {
                Complex::from(-z.im * z.im)
            } else {
                z
            }
        })
        .collect();
    let mut points: Vec<[Terms; 2]> = start
        .iter()
        .map(|z| [z.re, z.im].map(|part| [part, 0.0, 0.0, 0.0]))
        .collect();
    let mut best = None;
    let mut digits = 0;
    for level in LEVELS {
        if level.limbs > 2 && (level.limbs < job.wanted(&best) || !job.affords(level.limbs)) {
            continue;
        }
        let outcome = (level.run)(&job, unit, &points);
        points = outcome.points;
        let done = outcome.done;
        if outcome.proven.is_some() {
            best = outcome.proven;
            digits = level.digits;
        }
        if done {
            break;
        }
    }
    let mut found = best?;
    for disc in &mut found {
        for member in &mut disc.members {
            *member = chosen[*member];
        }
    }
    Some((found, digits))
}

/// A number as a sum of doubles, to be carried from one precision to the next.
type Terms = [f64; 4];

/// A precision, and the work of one level in it.
struct Rung {
    limbs: usize,
    /// Decimal digits.
    digits: usize,
    run: fn(&Job<'_>, i32, &[[Terms; 2]]) -> Outcome,
}

/// What a level leaves behind.
struct Outcome {
    points: Vec<[Terms; 2]>,
    proven: Option<Vec<Certified>>,
    done: bool,
}

/// From 32 digits to 1200.
const LEVELS: [Rung; 6] = [
    Rung {
        limbs: 2,
        digits: 32,
        run: level::<DoubleDouble>,
    },
    Rung {
        limbs: 4,
        digits: 77,
        run: level::<Wide<4>>,
    },
    Rung {
        limbs: 8,
        digits: 154,
        run: level::<Wide<8>>,
    },
    Rung {
        limbs: 16,
        digits: 308,
        run: level::<Wide<16>>,
    },
    Rung {
        limbs: 32,
        digits: 616,
        run: level::<Wide<32>>,
    },
    Rung {
        limbs: 64,
        digits: 1233,
        run: level::<Wide<64>>,
    },
];

fn level<T: Real>(job: &Job<'_>, unit: i32, start: &[[Terms; 2]]) -> Outcome {
    job.level::<T>(unit, start)
}

/// What stays the same at every level of precision.
struct Job<'a> {
    system: &'a System,
    structure: &'a Structure,
    pencil: Pencil,
    in_square: bool,
    degree: usize,
    zeros: usize,
    /// Whether the leading coefficient is that of [`leading`].
    determined: bool,
    tolerance: f64,
}

impl Job<'_> {
    /// The limbs that the largest cluster so far asks for: a root of multiplicity m is known to
    /// `LIMIT` only with m times its digits.
    fn wanted(&self, best: &Option<Vec<Certified>>) -> usize {
        const DIGITS: usize = 110;
        let largest = |found: &Vec<Certified>| {
            found
                .iter()
                .map(|disc| disc.members.len())
                .max()
                .unwrap_or(1)
        };
        let m = best.as_ref().map_or(1, largest);
        if m > 1 {
            (DIGITS * m + 30).div_ceil(64).min(64)
        } else {
            0
        }
    }

    /// Whether a sweep with so many limbs stays within a stated count of operations.
    fn affords(&self, limbs: usize) -> bool {
        const LARGEST: f64 = 1e9;
        let n = self.system.len() as f64;
        let filled = self.pencil.entry_count() as f64 / n;
        let elimination = (n * n * n / 3.0).min(4.0 * n * filled * filled);
        let product = (limbs * limbs + 20) as f64;
        elimination * self.degree as f64 * product <= LARGEST
    }

    /// One level: the polynomial in the precision of T, refined from the given points.
    fn level<T: Real>(&self, unit: i32, start: &[[Terms; 2]]) -> Outcome {
        let (precise, total) = self.pencil.precise::<T>(unit);
        let leading = self.determined.then(|| {
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
        let goal = Goal {
            tolerance: self.tolerance,
            limit: LIMIT,
            real_parts: !self.in_square,
        };
        let (discs, done) = match refine(&polynomial, &mut points, &goal) {
            Level::Done(discs) => (Some(discs), true),
            Level::Proven(discs) => (Some(discs), false),
            Level::Failed => (None, false),
        };
        let proven = discs.filter(|discs| useful(discs)).and_then(|discs| {
            if self.in_square {
                let root =
                    |disc| Some(self.shaped(&polynomial.pencil, disc, square_root(disc, unit)?));
                discs.iter().map(root).collect()
            } else {
                let found = self.in_plane(&polynomial.pencil, &discs, unit);
                let pairs = |root: &Certified| if root.value.im == 0.0 { 1 } else { 2 };
                let count: usize = found
                    .iter()
                    .map(|root| pairs(root) * root.members.len())
                    .sum();
                (count == self.degree - self.zeros).then_some(found)
            }
        });
        let terms = |mut value: T| {
            [(); 4].map(|()| {
                let term = value.to_f64();
                value = value - T::from(term);
                term
            })
        };
        let points = points
            .z
            .iter()
            .map(|z| [terms(z.middle().re), terms(z.middle().im)])
            .collect();
        Outcome {
            points,
            done: done && proven.is_some(),
            proven,
        }
    }

    /// Discs in λ as doubles with bounds; of conjugate discs the upper one.
    fn in_plane<T: Real>(
        &self,
        pencil: &PencilIn<T>,
        discs: &[Inclusion<T>],
        unit: i32,
    ) -> Vec<Certified> {
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
            let alone = discs
                .iter()
                .enumerate()
                .all(|(other, disc)| other == at || lower(disc.centre - around) > 0.0);
            if height <= radius(ball) && alone {
                let root = self.rounded(&disc.members, around, unit, true);
                found.push(self.shaped(pencil, disc, root));
            } else if ball.middle().im.to_f64() > 0.0 {
                let root = self.rounded(&disc.members, ball, unit, false);
                found.push(self.shaped(pencil, disc, root));
            }
        }
        found
    }

    /// The root with its shapes, where it is simple.
    fn shaped<T: Real>(
        &self,
        pencil: &PencilIn<T>,
        disc: &Inclusion<T>,
        mut root: Certified,
    ) -> Certified {
        if disc.members.len() == 1 {
            let mut centre = disc.centre.middle();
            if root.value.im == 0.0 {
                centre.im = T::ZERO;
            }
            root.shape = pencil.null_vector(centre, false);
            if !self.structure.is_symmetric() {
                // y*Q = 0 is Qᵀ ȳ = 0.
                let conjugate = |v: Vec<Complex<f64>>| v.iter().map(|z| z.conj()).collect();
                root.left = pencil.null_vector(centre, true).map(conjugate);
            }
        }
        root
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
        let mut re = middle.re.to_f64();
        let hidden = re.abs() <= radius(ball) || re.abs() <= LIMIT * size(ball);
        if hidden && !real || (self.structure.is_passive() && re > 0.0) {
            re = 0.0;
        }
        let im = if real { 0.0 } else { middle.im.to_f64() };
        let re_error = (middle.re - T::from(re)).to_f64().abs();
        let im_error = (middle.im - T::from(im)).to_f64().abs();
        Certified {
            members: members.to_vec(),
            value: Complex::new(times_power(re, unit), times_power(im, unit)),
            bound: enlarged(radius(ball) + re_error.hypot(im_error), unit),
            real_bound: enlarged(radius(ball) + re_error, unit),
            shape: None,
            left: None,
        }
    }
}

/// Whether every disc tells at least the size of its roots to some digits.
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
        shape: None,
        left: None,
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
