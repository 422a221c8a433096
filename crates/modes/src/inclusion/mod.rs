//! Proven discs for all roots of the quadratic eigenproblem.

mod ball;
mod pencil;
mod refine;
mod weierstrass;

use eigentone_digits::DoubleDouble;
use num_complex::Complex;

use crate::first_order::Massless;
use crate::structure::Structure;
use crate::system::System;

use ball::{Ball, Real};
use pencil::{Pencil, Scaled, determinant};
use refine::{Goal, Level, refine};
use weierstrass::{Inclusion, Points, Polynomial};

/// One root, or a cluster that the digits do not separate, with its proven disc.
#[derive(Clone, Debug)]
pub(crate) struct Certified {
    /// Indices of the approximations it came from.
    pub(crate) members: Vec<usize>,
    /// Im ≥ 0 unless its conjugate is listed as well.
    pub(crate) value: Complex<f64>,
    pub(crate) bound: f64,
    pub(crate) real_bound: f64,
}

/// Proves a disc for each of the nonzero finite roots, given approximations of all of them
/// (conjugates included); `None` where the count of roots is not known or no proof was reached.
pub(crate) fn certify(
    system: &System,
    structure: &Structure,
    approximations: &[Complex<f64>],
    tolerance: f64,
) -> Option<Vec<Certified>> {
    let degree = structure.finite_roots()?;
    let zeros = structure.zero_roots()?;
    if approximations.len() != degree - zeros {
        return None;
    }
    if approximations.is_empty() {
        return Some(Vec::new());
    }
    let in_square = structure.is_undamped() && structure.is_symmetric() && structure.is_passive();
    let job = Job {
        system,
        structure,
        in_square,
        degree,
        zeros,
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
    let points: Vec<[[f64; 2]; 2]> = start.iter().map(|z| [[z.re, 0.0], [z.im, 0.0]]).collect();
    let mut found = job.level::<DoubleDouble>(unit, &points)?;
    for disc in &mut found {
        for member in &mut disc.members {
            *member = chosen[*member];
        }
    }
    Some(found)
}

/// What stays the same at every level of precision.
struct Job<'a> {
    system: &'a System,
    structure: &'a Structure,
    in_square: bool,
    degree: usize,
    zeros: usize,
    tolerance: f64,
}

impl Job<'_> {
    /// One level: the polynomial in the precision of T, refined from the given points.
    fn level<T: Real>(&self, unit: i32, start: &[[[f64; 2]; 2]]) -> Option<Vec<Certified>> {
        let pencil = Pencil::of(self.system, self.in_square);
        let (precise, total) = pencil.precise::<T>(unit);
        let mut leading = leading::<T>(self.system, &pencil);
        leading.exponent += i64::from(unit) * self.degree as i64 - total;
        let halves = if self.in_square { 2 } else { 1 };
        let polynomial = Polynomial {
            pencil: precise,
            degree: (self.degree - self.zeros) / halves,
            zeros: self.zeros / halves,
            leading,
        };
        let sum = |terms: [f64; 2]| T::from_f64(terms[0]) + T::from_f64(terms[1]);
        let z = start
            .iter()
            .map(|[re, im]| Ball::exact(sum(*re), sum(*im)))
            .collect();
        let mut points = Points::new(z);
        let goal = Goal {
            tolerance: self.tolerance,
            limit: 1e-30,
            real_parts: !self.in_square,
        };
        let discs = match refine(&polynomial, &mut points, &goal) {
            Level::Done(discs) | Level::Proven(discs) => discs,
            Level::Failed => return None,
        };
        if self.in_square {
            discs.iter().map(|disc| square_root(disc, unit)).collect()
        } else {
            Some(self.in_plane(&discs, unit))
        }
    }

    /// Discs in λ as doubles with bounds; of conjugate discs the upper one.
    fn in_plane<T: Real>(&self, discs: &[Inclusion<T>], unit: i32) -> Vec<Certified> {
        let mut found = Vec::new();
        for (at, disc) in discs.iter().enumerate() {
            let ball = disc.centre;
            let height = ball.im.to_f64().abs();
            // A disc about the real axis that holds this one and meets no other holds the
            // conjugates of its own roots.
            let around = Ball {
                im: T::from_f64(0.0),
                radius: (ball.radius + height) * (1.0 + 1e-9),
                ..ball
            };
            let alone = discs
                .iter()
                .enumerate()
                .all(|(other, disc)| other == at || (disc.centre - around).lower() > 0.0);
            let odd = disc.members.len() % 2 == 1;
            let touches = height <= ball.radius;
            if touches && alone && (odd || disc.members.len() > 1 || height <= ball.radius) {
                found.push(self.rounded(&disc.members, around, unit, true));
            } else if ball.im.to_f64() > 0.0 {
                found.push(self.rounded(&disc.members, ball, unit, false));
            }
        }
        found
    }

    /// The double nearest to a disc's centre, and how far its roots may lie from that.
    fn rounded<T: Real>(
        &self,
        members: &[usize],
        ball: Ball<T>,
        unit: i32,
        real: bool,
    ) -> Certified {
        const UP: f64 = 1.0 + 1e-9;
        let scale = 2f64.powi(unit);
        let size = ball.re.to_f64().hypot(ball.im.to_f64());
        let mut re = ball.re.to_f64();
        let hidden = re.abs() <= ball.radius || re.abs() <= 1e-30 * size;
        if hidden && !real || (self.structure.is_passive() && re > 0.0) {
            re = 0.0;
        }
        let im = if real { 0.0 } else { ball.im.to_f64() };
        let re_error = (ball.re - T::from_f64(re)).to_f64().abs();
        let im_error = (ball.im - T::from_f64(im)).to_f64().abs();
        let bound = (ball.radius + re_error.hypot(im_error)) * UP * scale;
        let real_bound = (ball.radius + re_error) * UP * scale;
        Certified {
            members: members.to_vec(),
            value: Complex::new(re * scale, im * scale),
            bound,
            real_bound,
        }
    }
}

/// λ = iω from a disc about σ = −ω².
fn square_root<T: Real>(disc: &Inclusion<T>, unit: i32) -> Option<Certified> {
    const UP: f64 = 1.0 + 1e-9;
    // All σ are real, so the disc's section with the real axis holds them.
    let square = -disc.centre.re;
    let size = square.to_f64();
    if size <= 2.0 * disc.centre.radius {
        return None;
    }
    let root = square.square_root();
    let omega = root.to_f64();
    let rounding = (root - T::from_f64(omega)).to_f64().abs() + 8.0 * T::unit() * omega;
    let scale = 2f64.powi(unit);
    Some(Certified {
        members: disc.members.clone(),
        value: Complex::new(0.0, omega * scale),
        bound: (disc.centre.radius / omega + rounding) * UP * scale,
        real_bound: 0.0,
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
        let factor = determinant(block, parts.len());
        result = result.times(factor.ball);
        result.exponent += factor.exponent;
    }
    result
}
