//! P(z) = z Eᵀ(K + z²M)⁻¹E of a few coordinates, enclosed.
//!
//! With S = K + |z|²M and the angle θ of z, the Hermitian part of (K + z²M)/z is cos θ S/|z|; so
//! |xᵀ(K + z²M)⁻¹y| ≤ ‖x‖‖y‖/|cos θ| in the norm of S⁻¹. Inertia proves S ⪰ μ diag(w), with which that norm is
//! had from the entries of a vector. With approximate solves x_j, whose residuals are ρ_j,
//! e_iᵀ(K + z²M)⁻¹e_j = e_iᵀx_j + x_iᵀρ_j + ρ_iᵀ(K + z²M)⁻¹ρ_j: what is not known is of the second order in residuals,
//! which are formed in double-double.

use eigentone_digits::{Ball, DoubleDouble, Magnitude, WideComplex};
use num_complex::Complex;

use super::factor::{Entry, Factor, Sum};
use super::inertia::Inertia;
use super::pencil::Pencil;

/// A square matrix by columns, each entry in a disc.
pub(crate) type Square = Vec<Vec<Ball<f64>>>;

/// P on a circle about 0.
pub(crate) struct Impedance<'a> {
    pencil: &'a Pencil,
    nodes: &'a [usize],
    radius: f64,
    /// μ w, by nodes.
    floor: Vec<f64>,
}

/// An approximate solve with its residual.
struct Solve {
    x: Vec<Complex<f64>>,
    rest: Vec<Complex<f64>>,
    /// How far each entry of the residual may be off.
    doubt: Vec<f64>,
    /// The residual in the norm of S⁻¹, at most.
    size: f64,
}

impl<'a> Impedance<'a> {
    /// `None` where K + r²M is not proved to be definite.
    pub(crate) fn on_circle(
        inertia: &Inertia<'a>,
        nodes: &'a [usize],
        radius: f64,
    ) -> Option<Impedance<'a>> {
        Some(Impedance {
            pencil: inertia.pencil,
            nodes,
            radius,
            floor: inertia.floor(-radius * radius)?,
        })
    }

    /// At r(−2t + i(1 − t²))/(1 + t²), for 0 < t ≤ 1: from near the imaginary axis to −r.
    pub(crate) fn at(&self, t: f64) -> Option<Square> {
        let part = self.radius / (1.0 + t * t);
        let z = Complex::new(-2.0 * t * part, (1.0 - t * t) * part);
        let cosine = 0.99 * z.re.abs() / self.radius;
        let factor = Factor::sum(
            self.pencil,
            Sum {
                damping: Complex::ZERO,
                mass: z * z,
            },
            &[],
        );
        if !factor.is_finite() || factor.zeros > 0 {
            return None;
        }
        let solves = self.nodes.iter().map(|&node| self.solve(&factor, z, node));
        let solves: Vec<Solve> = solves.collect();
        let rate = WideComplex::new(z.re, z.im);
        let entry = |i: usize, j: usize| {
            let (own, other) = (&solves[i], &solves[j]);
            let terms = own.x.iter().zip(&other.rest);
            let product: Complex<f64> = terms.clone().map(|(x, rest)| x * rest).sum();
            let rounded: f64 = terms.map(|(x, rest)| x.norm() * rest.norm()).sum();
            let doubt: f64 = own
                .x
                .iter()
                .zip(&other.doubt)
                .map(|(x, d)| x.norm() * d)
                .sum();
            let unit = 4.0 * (own.x.len() + 8) as f64 * f64::EPSILON;
            let value = other.x[self.nodes[i]] + product;
            let error = own.size * other.size / cosine
                + unit * rounded
                + 1.01 * doubt
                + f64::EPSILON * value.norm();
            let radius = Magnitude::from(1.01 * error);
            Ball::new(WideComplex::new(value.re, value.im), radius) * Ball::from(rate)
        };
        let all = 0..self.nodes.len();
        let columns = all
            .clone()
            .map(|j| all.clone().map(|i| entry(i, j)).collect());
        Some(columns.collect())
    }

    fn solve(&self, factor: &Factor<'_, Complex<f64>>, z: Complex<f64>, node: usize) -> Solve {
        /// What is not known of an entry on the diagonal, in proportion to it, is small enough then.
        const ENOUGH: f64 = 1e-18;
        const STEPS: usize = 4;
        let n = self.pencil.len();
        let mut work = vec![Complex::ZERO; n];
        let mut x = vec![Complex::ZERO; n];
        x[node] = Complex::ONE;
        factor.solve(&mut x, &mut work);
        let mut best = self.residual(z, node, x);
        for _ in 0..STEPS {
            if best.size * best.size * self.radius <= ENOUGH * z.re.abs() * best.x[node].norm() {
                break;
            }
            let mut x = best.rest.clone();
            factor.solve(&mut x, &mut work);
            x.iter_mut()
                .zip(&best.x)
                .for_each(|(x, before)| *x += before);
            let next = self.residual(z, node, x);
            let better = next.size < 0.5 * best.size;
            if next.size < best.size {
                best = next;
            }
            if !better {
                break;
            }
        }
        best
    }

    /// e − (K + z²M)x, formed in double-double.
    fn residual(&self, z: Complex<f64>, node: usize, x: Vec<Complex<f64>>) -> Solve {
        let Pencil {
            stiffness, mass, ..
        } = self.pencil;
        let n = x.len();
        let square = [
            DoubleDouble::product(z.re, z.re) - DoubleDouble::product(z.im, z.im),
            DoubleDouble::product(2.0 * z.re, z.im),
        ];
        let parts: [Vec<f64>; 2] = [
            x.iter().map(|x| x.re).collect(),
            x.iter().map(|x| x.im).collect(),
        ];
        let zeros = || vec![DoubleDouble::ZERO; n];
        let mut rests = [zeros(), zeros()];
        rests[0][node] = DoubleDouble::from(1.0);
        let mut moved = [zeros(), zeros()];
        for ((part, rest), moved) in parts.iter().zip(&mut rests).zip(&mut moved) {
            stiffness.accumulate(-1.0, part, rest);
            mass.accumulate(1.0, part, moved);
        }
        let [re, im] = &mut rests;
        for k in 0..n {
            let (a, b) = (moved[0][k], moved[1][k]);
            re[k] = re[k] - (square[0] * a - square[1] * b);
            im[k] = im[k] - (square[0] * b + square[1] * a);
        }
        let sizes: Vec<f64> = x.iter().map(|x| x.re.abs() + x.im.abs()).collect();
        let mut doubt = vec![0.0; n];
        stiffness.accumulate_sizes(1.0, &sizes, &mut doubt);
        mass.accumulate_sizes(2.0 * z.norm_sqr(), &sizes, &mut doubt);
        // An entry is a sum of at most so many terms.
        let terms = stiffness.joins().len() + mass.joins().len() + 32;
        let unit = 2.0 * terms as f64 * DoubleDouble::UNIT;
        doubt.iter_mut().for_each(|doubt| *doubt *= unit);
        let rest: Vec<Complex<f64>> = re
            .iter()
            .zip(&*im)
            .map(|(re, im)| Complex::new(re.high(), im.high()))
            .collect();
        // The low parts that are left out.
        for (doubt, rest) in doubt.iter_mut().zip(&rest) {
            *doubt += f64::EPSILON * rest.norm();
        }
        let squares = rest.iter().zip(&doubt).zip(&self.floor);
        let size = squares
            .map(|((rest, doubt), floor)| (rest.norm() + doubt).powi(2) / floor)
            .sum::<f64>()
            .sqrt();
        Solve {
            x,
            rest,
            doubt,
            size: if size.is_nan() {
                f64::INFINITY
            } else {
                1.001 * size
            },
        }
    }
}
