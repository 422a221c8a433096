//! How many roots of λ²M + λC + K lie in a disc about 0, proven for M, C ⪰ 0 and K that is not negative but for what
//! lies far inside, with few dampers.
//!
//! With C = E Ĉ Eᵀ on the few coordinates that dampers move, det Q(z) = det(z²M + K)·det G(z), G = 1 + Ĉ P(z),
//! P(z) = z Eᵀ(z²M + K)⁻¹E. Zeros of det Q are those of det(z²M + K), which Sylvester's law of inertia counts, and the
//! turns of det G along the circle (argument principle; Güttel & Tisseur 2017, *Acta Numerica* 26, §5).
//!
//! P is a driving-point impedance: positive real, with all poles on the imaginary axis (Brune 1931, *J. Math.
//! Phys.* 10). With F = Ĉ^(1/2)P Ĉ^(1/2), det(1 + τF) for 0 ≤ τ ≤ 1 is therefore not 0 to the right of the axis; nor is
//! it a little to the left, as far as −Re F < 1, where −Re F grows with the distance from the axis as long as that is
//! small beside the distance to the next pole. So there the argument of det G is the sum of those of its eigenvalues.
//!
//! From there to the negative axis the lemma of Schwarz and Pick bounds how far P can move between two points. The arc
//! is a geodesic of the half-plane; with L its hyperbolic length and H = −Re P(z₀),
//! ‖H^(−1/2)(P(z₁) − P(z₀))H^(−1/2)‖ ≤ 2ρ/(1 − ρ) = e^L − 1, ρ = tanh(L/2). Steps are so short that by it no eigenvalue
//! of G(z₀)⁻¹G(z) − 1 gets as large as 1 on the way from z₀ to z₁. The argument of det G then turns by the sum of those of
//! the eigenvalues of G(z₀)⁻¹G(z₁), which is enclosed; nothing rests on a grid being fine enough.
//!
//! Where K has eigenvalues as low as −ε, P is positive real outside of the disc |z| ≤ √ε alone. w = z − ε/z maps what
//! is left of the half-plane onto a half-plane, in which an arc is longer by at most (r² + ε)/(r² − ε).

use std::f64::consts::PI;

use eigentone_digits::{Ball, DoubleDouble, Magnitude, WideComplex, eigen};
use faer::Mat;
use num_complex::Complex;

use super::entry::Entry;
use super::form::Form;
use super::impedance::{Disc, Impedance, Square};
use super::inertia::{Inertia, Side};
use super::pencil::Pencil;

/// More coordinates with dampers are not few.
const FEW: usize = 48;

/// Says so.
pub(crate) const MANY: &str = "dampers move more than 48 coordinates";

/// Points beyond which a circle is given up.
const POINTS: usize = 1000;

/// Roots in discs about 0.
pub(crate) struct Winding<'a> {
    inertia: Inertia<'a>,
    /// The coordinates that dampers move.
    nodes: Vec<usize>,
    /// Ĉ.
    damping: Square,
    semidefinite: bool,
}

impl<'a> Winding<'a> {
    /// For M, C ⪰ 0, where no part has neither mass nor a spring to others; `None` where dampers move too many
    /// coordinates.
    pub(crate) fn of(pencil: &'a Pencil, damping: &Form) -> Option<Winding<'a>> {
        let sizes = damping.sizes();
        let nodes: Vec<usize> = (0..sizes.len()).filter(|&i| sizes[i] > 0.0).collect();
        if nodes.len() > FEW {
            return None;
        }
        let column = |&node: &usize| {
            let mut unit = vec![0.0; sizes.len()];
            unit[node] = 1.0;
            let mut product = vec![DoubleDouble::ZERO; sizes.len()];
            damping.accumulate(1.0, &unit, &mut product);
            let entry = |&other: &usize| {
                let radius = 1e-25 * sizes[other];
                Ball::new(
                    WideComplex::new(product[other], 0.0),
                    Magnitude::from(radius),
                )
            };
            nodes.iter().map(entry).collect()
        };
        Some(Winding {
            inertia: Inertia::new(pencil, &[]),
            damping: nodes.iter().map(column).collect(),
            semidefinite: pencil.stiffness.is_non_negative(),
            nodes,
        })
    }

    /// How many roots have |λ| < radius; `None` where that is not proved.
    pub(crate) fn inside(&self, radius: f64) -> Option<usize> {
        /// √ε in proportion to the radius.
        const INNER: f64 = 0.03;
        let longer = if self.semidefinite {
            1.0
        } else {
            let at = -(INNER * radius).powi(2);
            (self.inertia.below_either(at, Side::AtMost)? == 0).then_some(())?;
            (1.0 + INNER * INNER) / (1.0 - INNER * INNER)
        };
        let (poles, gap) = self.undamped_below(radius * radius)?;
        let impedance = Impedance::on_circle(&self.inertia, &self.nodes, radius)?;
        let at = |t: f64| Point::of(&self.damping, impedance.at(t)?);
        // As far as −Re F grows for all poles beyond the gap.
        let mut t = (0.1 * gap).min(0.05);
        let mut here = loop {
            let here = at(t)?;
            if here.resistance < 0.9 {
                break here;
            }
            t *= 0.5 / here.resistance;
            (t > 1e-12).then_some(())?;
        };
        let mut turned = Turn::of(&here.product)?;
        for _ in 0..POINTS {
            if t >= 1.0 {
                let turns = turned.angle / PI;
                let whole = turns.round();
                let total = 2.0 * poles as f64 + whole;
                let is_sure = turned.doubt < 0.5 && (turns - whole).abs() < 0.2 && total >= 0.0;
                return is_sure.then_some(total as usize);
            }
            // tan of half the angle from the axis grows by e^L.
            let length = (1.0 + here.reach).ln() / longer;
            let next = (t * (length * (1.0 - 1e-9)).exp()).min(1.0);
            (next > t * (1.0 + 1e-9)).then_some(())?;
            let there = at(next)?;
            turned = turned + Turn::of(&here.ratio(&there))?;
            (t, here) = (next, there);
        }
        None
    }

    /// How many eigenvalues of (K, M) lie below a number, and a part of it within which it has none beside it.
    fn undamped_below(&self, square: f64) -> Option<(usize, f64)> {
        (1..9).find_map(|power| {
            let gap = 0.1f64.powi(power);
            let least = square * (1.0 - gap);
            let least = self.inertia.below_either(least, Side::AtLeast)?;
            let most = square * (1.0 + gap);
            let most = self.inertia.below_either(most, Side::AtMost)?;
            (least == most).then_some((least, gap))
        })
    }
}

/// What is known of G at a point to the left of the imaginary axis.
struct Point {
    impedance: Square,
    /// The powers of 2 by which coordinates are scaled, so that −Re P has a diagonal near 1.
    powers: Vec<i64>,
    /// Ĉ P, scaled.
    product: Square,
    /// G⁻¹Ĉ, scaled.
    response: Square,
    /// At most −Re F.
    resistance: f64,
    /// By how much P can move, in proportion to H, while the eigenvalues of G⁻¹ times what G becomes stay near 1.
    reach: f64,
}

impl Point {
    fn of(damping: &Square, impedance: Square) -> Option<Point> {
        /// How far from 1 these eigenvalues may get.
        const NEAR: f64 = 0.9;
        let count = damping.len();
        let power = |i: usize| -> Option<i64> {
            let own = -impedance[i][i].middle().re.to_f64();
            (own > 0.0 && own.is_finite()).then(|| (-0.5 * own.log2()).round() as i64)
        };
        let powers: Vec<i64> = (0..count).map(power).collect::<Option<_>>()?;
        let inverse: Vec<i64> = powers.iter().map(|power| -power).collect();
        let own = scaled(&impedance, &powers);
        let damping = scaled(damping, &inverse);
        let product = times(&damping, &own);
        let one = Ball::from(WideComplex::new(1.0, 0.0));
        let whole = square(count, |i, j| match i == j {
            true => one + product[j][i],
            false => product[j][i],
        });
        let lower = cholesky(&own)?;
        let resistance = largest(&congruent(&damping, &lower));
        let response = solve(whole, damping)?;
        let reach = NEAR / largest(&congruent(&response, &lower));
        Some(Point {
            impedance,
            powers,
            product,
            response,
            resistance,
            reach: if reach.is_nan() { 0.0 } else { reach },
        })
    }

    /// G⁻¹ times that of another point, without 1.
    fn ratio(&self, other: &Point) -> Square {
        let moved = square(self.powers.len(), |i, j| {
            other.impedance[j][i] - self.impedance[j][i]
        });
        times(&self.response, &scaled(&moved, &self.powers))
    }
}

/// By how much the argument of a determinant turns.
#[derive(Clone, Copy, Debug)]
struct Turn {
    angle: f64,
    doubt: f64,
}

impl Turn {
    /// That of det(1 + τA) from τ = 0 to τ = 1, where it is not 0.
    ///
    /// In a basis of approximate eigenvectors A is Λ + R with a small R, and
    /// det(1 + τΛ + τR) = det(1 + τΛ) det(1 + τ(1 + τΛ)⁻¹R), |1/τ + Λ_k| ≥ max(1 + Re Λ_k, |Im Λ_k|). With a sum s < 1
    /// of the sizes of all entries of (1/τ + Λ)⁻¹R the last one turns by arcsin s at most.
    fn of(matrix: &Square) -> Option<Turn> {
        const SMALL: f64 = 0.1;
        let count = matrix.len();
        let middles = Mat::from_fn(count, count, |i, j| {
            let middle = matrix[j][i].middle();
            Complex::new(middle.re.to_f64(), middle.im.to_f64())
        });
        let (_, right) = eigen(middles.as_ref())?;
        let vectors = square(count, |i, j| {
            let entry: Complex<f64> = right[(i, j)];
            Ball::from(WideComplex::new(entry.re, entry.im))
        });
        let right = times(matrix, &vectors);
        let solved = solve(vectors, right)?;
        let mut rest = 0.0;
        let mut angle = 0.0;
        for k in 0..count {
            let value = solved[k][k].middle();
            let value = Complex::new(value.re.to_f64(), value.im.to_f64());
            let least = (1.0 + value.re).max(value.im.abs());
            (1.0 + value.re > 0.0).then_some(())?;
            angle += value.im.atan2(1.0 + value.re);
            let size = |(j, column): (usize, &Vec<Disc>)| match j == k {
                true => column[k].radius().to_f64(),
                false => column[k].upper().to_f64(),
            };
            let row: f64 = solved.iter().enumerate().map(size).sum();
            rest += row / least;
        }
        (rest < SMALL).then_some(Turn {
            angle,
            doubt: 1.01 * rest + 1e-14 * count as f64,
        })
    }
}

impl std::ops::Add for Turn {
    type Output = Turn;

    fn add(self, other: Turn) -> Turn {
        Turn {
            angle: self.angle + other.angle,
            doubt: self.doubt + other.doubt,
        }
    }
}

/// S A S with a diagonal S of powers of 2.
fn scaled(matrix: &Square, powers: &[i64]) -> Square {
    square(matrix.len(), |i, j| {
        matrix[j][i] * 2f64.powi((powers[i] + powers[j]) as i32)
    })
}

fn square(count: usize, entry: impl Fn(usize, usize) -> Disc) -> Square {
    let column = |j: usize| (0..count).map(|i| entry(i, j)).collect();
    (0..count).map(column).collect()
}

fn times(left: &Square, right: &Square) -> Square {
    let count = left.len();
    square(count, |i, j| {
        let terms = left.iter().zip(&right[j]);
        terms.fold(Ball::ZERO, |sum, (column, entry)| sum + column[i] * *entry)
    })
}

/// A lower triangle T, by columns, with T Tᵀ ⪰ −Re P.
fn cholesky(impedance: &Square) -> Option<Vec<Vec<DoubleDouble>>> {
    let count = impedance.len();
    let entry = |i: usize, j: usize| {
        let [a, b] = [impedance[j][i], impedance[i][j]].map(|entry| entry.middle().re);
        (a + b) * -0.5
    };
    let trace: f64 = (0..count).map(|i| entry(i, i).to_f64()).sum();
    // Not less than the Frobenius norm of what is not known, and what rounding adds.
    let all = impedance.iter().flatten();
    let unknown: f64 = all.map(|entry| entry.radius().to_f64()).sum();
    let mut raised = 2.0 * unknown + 16.0 * (count + 4) as f64 * DoubleDouble::UNIT * trace;
    for _ in 0..12 {
        if let Some(lower) = factored(count, |i, j| match i == j {
            true => entry(i, i) + DoubleDouble::from(raised),
            false => entry(i, j),
        }) {
            return Some(lower);
        }
        raised *= 16.0;
    }
    None
}

fn factored(
    count: usize,
    entry: impl Fn(usize, usize) -> DoubleDouble,
) -> Option<Vec<Vec<DoubleDouble>>> {
    let mut lower = vec![vec![DoubleDouble::ZERO; count]; count];
    for j in 0..count {
        let (before, rest) = lower.split_at_mut(j);
        let column = &mut rest[0];
        for i in j..count {
            let known = before.iter().map(|column| column[i] * column[j]);
            column[i] = known.fold(entry(i, j), |rest, known| rest - known);
        }
        let pivot = column[j];
        if !(pivot.to_f64() > 0.0 && pivot.to_f64().is_finite()) {
            return None;
        }
        let root = pivot.sqrt();
        column[j..]
            .iter_mut()
            .for_each(|entry| *entry = *entry / root);
    }
    Some(lower)
}

/// TᵀA T.
fn congruent(matrix: &Square, lower: &[Vec<DoubleDouble>]) -> Square {
    let count = lower.len();
    let combined = |entry: &dyn Fn(usize) -> Disc, column: usize| {
        let factor = |k: usize| Ball::from(WideComplex::new(lower[column][k], 0.0));
        let terms = (column..count).map(|k| entry(k) * factor(k));
        terms.fold(Ball::ZERO, |sum, term| sum + term)
    };
    let half = square(count, |i, j| combined(&|k| matrix[k][i], j));
    square(count, |i, j| combined(&|k| half[j][k], i))
}

/// At most the largest singular value: ‖B⁴‖^(1/8) in the norm of Frobenius for B = AᴴA.
fn largest(matrix: &Square) -> f64 {
    let count = matrix.len();
    let frobenius = |matrix: &Square| {
        let sizes = matrix.iter().flatten().map(|entry| entry.upper());
        sizes
            .fold(Magnitude::ZERO, |sum, size| sum + size * size)
            .sqrt()
    };
    let plain = frobenius(matrix);
    if count == 1 {
        return plain.to_f64();
    }
    // Scaled to be of size 1, with radii taken along.
    let size = plain.to_f64();
    if !(size > 1e-300 && size < 1e300) {
        return size;
    }
    let conjugate = |entry: Disc| Ball::new(entry.middle().conj(), entry.radius());
    let power = 2f64.powi(-(size.log2().round() as i32));
    let one = square(count, |i, j| matrix[j][i] * power);
    let adjoint = square(count, |i, j| conjugate(one[i][j]));
    let mut product = times(&adjoint, &one);
    for _ in 0..2 {
        product = times(&product, &product);
    }
    let root = frobenius(&product).sqrt().sqrt().sqrt();
    size.min(1.0001 * root.to_f64() / power)
}

/// A⁻¹B, by elimination with partial pivoting; `None` where A may be singular.
fn solve(mut left: Square, mut right: Square) -> Option<Square> {
    let count = left.len();
    for k in 0..count {
        let size = |i: usize| left[k][i].lower();
        let larger = |a: usize, b: usize| if size(b) > size(a) { b } else { a };
        let best = (k..count).reduce(larger)?;
        left.iter_mut()
            .chain(&mut right)
            .for_each(|column| column.swap(k, best));
        let one = Ball::from(WideComplex::new(1.0, 0.0));
        let inverse = one.checked_div(left[k][k])?;
        for i in k + 1..count {
            let multiplier = left[k][i] * inverse;
            for column in left[k + 1..].iter_mut().chain(&mut right) {
                column[i] = column[i] - multiplier * column[k];
            }
        }
    }
    for column in &mut right {
        for k in (0..count).rev() {
            column[k] = column[k].checked_div(left[k][k])?;
            for i in 0..k {
                column[i] = column[i] - left[k][i] * column[k];
            }
        }
    }
    Some(right)
}
