//! How many roots of λ²M + λC + K lie in a disc about 0, proven for a passive system with few dampers.
//!
//! With C = E S² Eᵀ on the few coordinates that dampers move, det Q(z) = det(z²M + K)·det G(z),
//! G = 1 + F, F(z) = z S Eᵀ(z²M + K)⁻¹E S. Zeros of det Q are those of det(z²M + K), which Sylvester's law of
//! inertia counts, and the turns of det G along the circle (argument principle; Güttel & Tisseur 2017, *Acta
//! Numerica* 26, §5).
//!
//! F is a driving-point impedance: positive real, with all poles on the imaginary axis (Brune 1931, *J. Math.
//! Phys.* 10). To the right of the axis the real part of G is therefore definite and its argument is that of its
//! eigenvalues; so it is a little to the left, as far as −Re F < 1. Elsewhere the lemma of Schwarz and Pick bounds
//! how far F can move between two points, with ρ = |z₁ − z₀|/|z₁ + z̄₀| and H = −Re F(z₀):
//! ‖H^(−1/2)(F(z₁) − F(z₀))H^(−1/2)‖ ≤ 2ρ/(1 − ρ). Steps are so short that by it det G cannot turn by half of a
//! half turn between two points; nothing rests on a grid being fine enough.

use std::f64::consts::PI;

use eigentone_digits::DoubleDouble;
use faer::linalg::solvers::{DenseSolveCore, Solve};
use faer::{Mat, Side as Triangle};
use num_complex::Complex;

use super::factor::{Factor, Sum};
use super::form::Form;
use super::inertia::{Inertia, Side};
use super::pencil::Pencil;

type Square = Mat<Complex<f64>>;

/// More coordinates with dampers are not few.
const FEW: usize = 48;

/// Points beyond which a circle is given up.
const POINTS: usize = 3000;

/// Roots in discs about 0.
pub(crate) struct Winding<'a> {
    pencil: &'a Pencil,
    inertia: Inertia<'a>,
    /// The coordinates that dampers move.
    nodes: Vec<usize>,
    /// S.
    root: Mat<f64>,
}

impl<'a> Winding<'a> {
    /// Of a system that is proved to be passive; `None` where its dampers are many.
    pub(crate) fn of(
        pencil: &'a Pencil,
        damping: &Form,
        idle: &[Vec<usize>],
    ) -> Option<Winding<'a>> {
        let sizes = damping.sizes();
        let nodes: Vec<usize> = (0..sizes.len()).filter(|&i| sizes[i] > 0.0).collect();
        if nodes.len() > FEW || !idle.is_empty() {
            return None;
        }
        let unit = |at: usize| {
            let mut unit = vec![0.0; sizes.len()];
            unit[at] = 1.0;
            unit
        };
        let mut block = Mat::zeros(nodes.len(), nodes.len());
        let mut product = vec![0.0; sizes.len()];
        for (j, &node) in nodes.iter().enumerate() {
            damping.apply(&unit(node), &mut product);
            for (i, &other) in nodes.iter().enumerate() {
                block[(i, j)] = product[other];
            }
        }
        let eigen = block.self_adjoint_eigen(Triangle::Lower).ok()?;
        let scaled = Mat::from_fn(nodes.len(), nodes.len(), |i, j| {
            eigen.U()[(i, j)] * eigen.S()[j].max(0.0).sqrt()
        });
        Some(Winding {
            pencil,
            inertia: Inertia::new(pencil, idle),
            root: &scaled * eigen.U().transpose(),
            nodes,
        })
    }

    /// How many roots have |λ| < radius; `None` where that is not proved.
    pub(crate) fn inside(&self, radius: f64) -> Option<usize> {
        let square = radius * radius;
        let poles = 2 * self.undamped_below(square)?;
        // To the left of the axis as far as Re G stays definite: there −Re F ≤ −Re z·F′ of the axis.
        let (_, slope) = self.at(Complex::new(0.0, radius))?;
        let steepest = slope.self_adjoint_eigen(Triangle::Lower).ok()?;
        let steepest = steepest
            .S()
            .column_vector()
            .iter()
            .fold(0.0, |top: f64, s| top.max(s.re));
        let first = (0.5 / (radius * steepest)).min(0.2).asin();
        let mut angle = PI / 2.0 + first;
        let at = |angle: f64| Complex::from_polar(radius, angle);
        let (mut here, _) = self.at(at(angle))?;
        let mut turned: f64 = here
            .eigen()
            .ok()?
            .S()
            .column_vector()
            .iter()
            .map(|s| s.arg())
            .sum();
        for _ in 0..POINTS {
            if angle >= PI {
                let turns = turned / PI;
                let whole = turns.round();
                let total = poles as f64 + whole;
                return ((turns - whole).abs() < 0.02 && total >= 0.0).then_some(total as usize);
            }
            let reach = reach(&here)?;
            let next = step(angle, reach).min(PI);
            if next <= angle || next.is_nan() {
                return None;
            }
            let (there, _) = self.at(at(next))?;
            let ratio: Square = here.partial_piv_lu().solve(&there);
            turned += ratio.determinant().arg();
            (angle, here) = (next, there);
        }
        None
    }

    fn undamped_below(&self, square: f64) -> Option<usize> {
        let counts = |side| self.inertia.below::<f64>(square, side);
        let [least, most] = [Side::AtLeast, Side::AtMost].map(counts);
        if least.is_some() && least == most {
            return least;
        }
        let counts = |side| self.inertia.below::<DoubleDouble>(square, side);
        let [least, most] = [Side::AtLeast, Side::AtMost].map(counts);
        least.filter(|_| least == most)
    }

    /// G(z), and F′(z) where z is on the imaginary axis.
    fn at(&self, z: Complex<f64>) -> Option<(Square, Square)> {
        /// What solves may err by; the steps leave room for more.
        const SOLVED: f64 = 1e-5;
        let n = self.pencil.len();
        let sum = Sum {
            damping: Complex::ZERO,
            mass: z * z,
        };
        let factor = Factor::sum(self.pencil, sum, &[]);
        if !factor.is_finite() || factor.zeros > 0 {
            return None;
        }
        let count = self.nodes.len();
        let mut work = vec![Complex::ZERO; n];
        let size = |x: &[Complex<f64>]| x.iter().map(|x| x.norm_sqr()).sum::<f64>().sqrt();
        let mut columns = Vec::with_capacity(count);
        for &node in &self.nodes {
            let mut x = vec![Complex::ZERO; n];
            x[node] = Complex::ONE;
            factor.solve(&mut x, &mut work);
            let mut rest = vec![Complex::ZERO; n];
            rest[node] = Complex::ONE;
            self.pencil
                .stiffness
                .accumulate_complex(-Complex::ONE, &x, &mut rest);
            self.pencil.mass.accumulate_complex(-(z * z), &x, &mut rest);
            factor.solve(&mut rest, &mut work);
            let missing = size(&rest) / size(&x);
            if missing > SOLVED || missing.is_nan() {
                return None;
            }
            x.iter_mut().zip(&rest).for_each(|(x, rest)| *x += rest);
            columns.push(x);
        }
        let root = Mat::from_fn(count, count, |i, j| Complex::from(self.root[(i, j)]));
        let moved = Mat::from_fn(count, count, |i, j| columns[j][self.nodes[i]]);
        let weighted: Vec<Vec<Complex<f64>>> = columns
            .iter()
            .map(|x| {
                let mut product = vec![Complex::ZERO; n];
                self.pencil
                    .mass
                    .accumulate_complex(Complex::ONE, x, &mut product);
                product
            })
            .collect();
        let inertia = Mat::from_fn(count, count, |i, j| {
            columns[i]
                .iter()
                .zip(&weighted[j])
                .map(|(x, y)| x * y)
                .sum::<Complex<f64>>()
        });
        let whole = &root * &moved * &root;
        let value = Mat::from_fn(count, count, |i, j| {
            let unit = Complex::from(if i == j { 1.0 } else { 0.0 });
            unit + z * whole[(i, j)]
        });
        let slope = Mat::from_fn(count, count, |i, j| {
            moved[(i, j)] - 2.0 * z * z * inertia[(i, j)]
        });
        Some((value, &root * &slope * &root))
    }
}

/// The largest 2ρ/(1 − ρ) for which det G(z₁)/det G(z₀) stays within an argument of 1.2.
fn reach(here: &Square) -> Option<f64> {
    let count = here.nrows();
    let real = Mat::from_fn(count, count, |i, j| {
        let unit = if i == j { 1.0 } else { 0.0 };
        Complex::from(unit) - (here[(i, j)] + here[(j, i)].conj()) / 2.0
    });
    let eigen = real.self_adjoint_eigen(Triangle::Lower).ok()?;
    let half = Mat::from_fn(count, count, |i, j| {
        eigen.U()[(i, j)] * eigen.S()[j].re.max(0.0).sqrt()
    });
    let inverse = here.partial_piv_lu().inverse();
    let product = half.adjoint() * &inverse * &half;
    let sizes = product.singular_values().ok()?;
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    let sum: f64 = sizes.iter().sum();
    sum.is_finite()
        .then(|| (0.8 / largest).min(0.75 / sum).min(8.0))
}

/// The angle that is so far from another one on a circle about 0, to the left of the imaginary axis.
fn step(angle: f64, reach: f64) -> f64 {
    let rho = reach / (2.0 + reach);
    // sin(Δ/2) = ρ |cos(angle + Δ/2)|, which is |cos a| cos(Δ/2) + … with a beyond a right angle.
    let (sine, cosine) = angle.sin_cos();
    let half = (rho * cosine.abs()).atan2(1.0 - rho * sine.abs().min(1.0));
    angle + 2.0 * half.min(0.5)
}
