//! P(z) = z Eᵀ(K + z²M)⁻¹E of a few coordinates, enclosed.
//!
//! With S = K + |z|²M and the angle θ of z, the Hermitian part of (K + z²M)/z is cos θ S/|z|; so
//! |xᵀ(K + z²M)⁻¹y| ≤ ‖x‖‖y‖/|cos θ| in the norm of S⁻¹. Inertia proves S ⪰ μ diag(w), with which that norm is
//! had from the entries of a vector. With approximate solves x_j, whose residuals are ρ_j,
//! e_iᵀ(K + z²M)⁻¹e_j = e_iᵀx_j + x_iᵀρ_j + ρ_iᵀ(K + z²M)⁻¹ρ_j: what is not known is of the second order in residuals,
//! which are formed in double-double, as the solves are kept.

use eigentone_digits::{Ball, ComplexDoubleDouble, DoubleDouble, Magnitude, WideComplex};
use num_complex::Complex;

use super::entry::Entry;
use super::factor::{Factor, Sum};
use super::inertia::Inertia;
use super::pencil::Pencil;

/// A number in a disc.
pub(crate) type Disc = Ball<DoubleDouble>;

/// A square matrix by columns.
pub(crate) type Square = Vec<Vec<Disc>>;

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
    x: Vec<ComplexDoubleDouble>,
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
        let rounded: Vec<Vec<Complex<f64>>> = solves
            .iter()
            .map(|solve| solve.x.iter().map(|x| high(*x)).collect())
            .collect();
        let entry = |i: usize, j: usize| {
            let (own, other) = (&rounded[i], &solves[j]);
            let terms = own.iter().zip(&other.rest);
            let product: Complex<f64> = terms.clone().map(|(x, rest)| x * rest).sum();
            let sizes: f64 = terms.map(|(x, rest)| x.norm() * rest.norm()).sum();
            let doubts = own.iter().zip(&other.doubt);
            let doubt: f64 = doubts.map(|(x, doubt)| x.norm() * doubt).sum();
            let unit = 4.0 * (own.len() + 8) as f64 * f64::EPSILON;
            let value = other.x[self.nodes[i]] + WideComplex::new(product.re, product.im);
            let error = solves[i].size * other.size / cosine
                + unit * sizes
                + 1.01 * doubt
                + 4.0 * DoubleDouble::UNIT * value.norm();
            Ball::new(value, Magnitude::from(1.01 * error)) * Ball::from(rate)
        };
        let all = 0..self.nodes.len();
        let columns = all
            .clone()
            .map(|j| all.clone().map(|i| entry(i, j)).collect());
        Some(columns.collect())
    }

    fn solve(&self, factor: &Factor<'_, Complex<f64>>, z: Complex<f64>, node: usize) -> Solve {
        /// What is not known of an entry on the diagonal, in proportion to it, is small enough then.
        const ENOUGH: f64 = 1e-26;
        const STEPS: usize = 4;
        let n = self.pencil.len();
        let mut work = vec![Complex::ZERO; n];
        let mut unit = vec![Complex::ZERO; n];
        unit[node] = Complex::ONE;
        factor.solve(&mut unit, &mut work);
        let x = unit.iter().map(|x| WideComplex::new(x.re, x.im)).collect();
        let mut best = self.residual(z, node, x);
        for _ in 0..STEPS {
            let own = high(best.x[node]).norm();
            if best.size * best.size * self.radius <= ENOUGH * z.re.abs() * own {
                break;
            }
            let mut missing = best.rest.clone();
            factor.solve(&mut missing, &mut work);
            let pairs = best.x.iter().zip(&missing);
            let x = pairs.map(|(x, missing)| *x + WideComplex::new(missing.re, missing.im));
            let next = self.residual(z, node, x.collect());
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
    fn residual(&self, z: Complex<f64>, node: usize, x: Vec<ComplexDoubleDouble>) -> Solve {
        let Pencil {
            stiffness, mass, ..
        } = self.pencil;
        let n = x.len();
        let square = [
            DoubleDouble::product(z.re, z.re) - DoubleDouble::product(z.im, z.im),
            DoubleDouble::product(2.0 * z.re, z.im),
        ];
        let parts: [Vec<DoubleDouble>; 2] = [
            x.iter().map(|x| x.re).collect(),
            x.iter().map(|x| x.im).collect(),
        ];
        let zeros = || vec![DoubleDouble::ZERO; n];
        let mut rests = [zeros(), zeros()];
        rests[0][node] = DoubleDouble::from(1.0);
        let mut moved = [zeros(), zeros()];
        for ((part, rest), moved) in parts.iter().zip(&mut rests).zip(&mut moved) {
            stiffness.accumulate_long(-1.0, part, rest);
            mass.accumulate_long(1.0, part, moved);
        }
        let [re, im] = &mut rests;
        for k in 0..n {
            let (a, b) = (moved[0][k], moved[1][k]);
            re[k] -= square[0] * a - square[1] * b;
            im[k] -= square[0] * b + square[1] * a;
        }
        let largest: Vec<f64> = x
            .iter()
            .map(|x| 1.01 * (x.re.high().abs() + x.im.high().abs()))
            .collect();
        let mut doubt = vec![0.0; n];
        stiffness.accumulate_sizes(1.0, &largest, &mut doubt);
        mass.accumulate_sizes(2.0 * z.norm_sqr(), &largest, &mut doubt);
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

fn high(value: ComplexDoubleDouble) -> Complex<f64> {
    Complex::new(value.re.high(), value.im.high())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::MatrixKind;
    use crate::sparse::form::Form;
    use crate::structure::samples::chain;

    /// z/(z² + ω²).
    fn pole(z: ComplexDoubleDouble, square: f64) -> ComplexDoubleDouble {
        z / (z * z + WideComplex::new(square, 0.0))
    }

    fn impedance(t: f64, radius: f64, fault: f64) -> (Disc, ComplexDoubleDouble) {
        // Masses of 1 between springs of 1: squares 1 and 3, each with half of the motion of the first.
        let system = chain(&[1.0; 2], &[1.0; 3], &[]);
        let form = |kind| Form::of(&system, kind).unwrap();
        let [mass, stiffness] = [MatrixKind::Mass, MatrixKind::Stiffness].map(form);
        let pencil = Pencil::of(stiffness, Form::zero(2), mass).unwrap();
        let inertia = Inertia::new(&pencil, &[]);
        let nodes = [0];
        let mut circle = Impedance::on_circle(&inertia, &nodes, radius).unwrap();
        circle.floor.iter_mut().for_each(|floor| *floor *= fault);
        let part = radius / (1.0 + t * t);
        let z = WideComplex::new(-2.0 * t * part, (1.0 - t * t) * part);
        let value = (pole(z, 1.0) + pole(z, 3.0)) * 0.5;
        (circle.at(t).unwrap()[0][0], value)
    }

    #[test]
    fn the_impedance_lies_in_its_disc() {
        for radius in [0.3, 1.2, 1.7, 40.0] {
            for t in [1e-9, 1e-4, 0.03, 0.5, 1.0] {
                let (ball, value) = impedance(t, radius, 1.0);
                let error = (ball.middle() - value).norm();
                let bound = ball.radius().to_f64();
                assert!(
                    error <= bound + 1e-28 * value.norm(),
                    "{radius} {t}: {error:e}"
                );
                assert!(bound <= 1e-10 * value.norm(), "{radius} {t}: {bound:e}");
            }
        }
    }

    #[test]
    fn a_floor_that_is_too_low_makes_discs_wide() {
        let (ball, value) = impedance(1e-4, 1.2, 1e-60);
        assert!(ball.radius().to_f64() > 1e-3 * value.norm());
    }
}
