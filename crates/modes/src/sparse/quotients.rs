//! Shapes that are given as undamped modes: their Rayleigh quotients in double-double, with errors from residuals.
//!
//! Of K x = θM x a residual ρ = ‖Kx − θMx‖ in the norm of M⁻¹, with ‖x‖_M = 1, has an eigenvalue within ρ of θ, and within
//! ρ²/γ where no other lies within γ (Parlett 1998, *The Symmetric Eigenvalue Problem*, theorem 11.7.1).

use eigentone_digits::{DoubleDouble, Real, sort_by_number};
use num_complex::Complex;

use super::basis::dot;
use super::eigenpair::Eigenpair;
use super::form::Form;
use super::operator::Rigid;
use super::refine::{self, Pair};

/// K and M.
#[derive(Clone, Copy)]
pub(crate) struct Shapes<'a> {
    pub(crate) mass: &'a Form,
    pub(crate) stiffness: &'a Form,
}

/// A shape of M-norm 1 on its way.
struct Rough {
    square: f64,
    /// ρ, infinite where M says nothing of it.
    rest: f64,
    shape: Vec<f64>,
}

impl Shapes<'_> {
    /// Real shapes of M-norm 1 that span what is given, without rigid motions; and how many pairs have no mass.
    pub(crate) fn real(
        self,
        pairs: Vec<Eigenpair>,
        rigid: Option<&Rigid>,
    ) -> (Vec<Vec<f64>>, usize) {
        /// Less than that of a shape is what rounding has left.
        const REST: f64 = 1e-6;
        /// Parts of a shape that belong to two modes are not as unlike as that.
        const PART: f64 = 1e-3;
        let mass = self.mass;
        let mut product = vec![0.0; mass.len()];
        let mut all = Vec::new();
        let mut unfit = 0;
        for pair in pairs {
            let by_size = |a: &&Complex<f64>, b: &&Complex<f64>| a.norm().total_cmp(&b.norm());
            let largest = pair.shape.iter().max_by(by_size).copied();
            let turn = largest.map_or(Complex::ONE, |x| x.conj() / x.norm() / x.norm());
            let part = |of: fn(Complex<f64>) -> f64| -> Vec<f64> {
                pair.shape.iter().map(|x| of(x * turn)).collect()
            };
            let parts = [part(|x| x.re), part(|x| x.im)];
            let norms = parts.each_ref().map(|part| mass.quadratic(part));
            let whole = norms[0] + norms[1];
            if !(whole > 0.0 && whole.is_finite()) {
                unfit += 1;
                continue;
            }
            for (mut shape, norm) in parts.into_iter().zip(norms) {
                if norm <= PART * PART * whole {
                    continue;
                }
                if let Some(rigid) = rigid {
                    mass.apply(&shape, &mut product);
                    rigid.remove(&product, &mut shape);
                }
                let left = mass.quadratic(&shape);
                if left > REST * REST * norm {
                    let length = left.sqrt();
                    shape.iter_mut().for_each(|x| *x /= length);
                    all.push(shape);
                }
            }
        }
        (all, unfit)
    }

    /// Their pairs with errors, and how many shapes are of no mode: those whose residual is neither small beside ω² nor,
    /// by the part `small`, beside the terms of Kx and ω²Mx. The lowest has nothing below it where `held`.
    pub(crate) fn pairs(self, shapes: Vec<Vec<f64>>, held: bool, small: f64) -> (Vec<Pair>, usize) {
        /// Values that near are taken together.
        const NEAR: f64 = 1e-6;
        let all = shapes.len();
        let rough = shapes
            .into_iter()
            .filter_map(|shape| self.rough(shape, small));
        let mut rough: Vec<Rough> = rough.collect();
        let unfit = all - rough.len();
        sort_by_number(&mut rough, |a| a.square.abs());
        let mut groups: Vec<Vec<Rough>> = Vec::new();
        for next in rough {
            let near = |other: &Rough| {
                let reach = NEAR * other.square.abs().max(next.square.abs());
                (other.square - next.square).abs() <= reach.max(2.0 * (other.rest + next.rest))
            };
            match groups.last_mut().filter(|group| group.iter().any(near)) {
                Some(group) => group.push(next),
                None => groups.push(vec![next]),
            }
        }
        let separated = groups.into_iter().map(|group| self.separated(group));
        let mut pairs = bounded(separated.collect(), held, unfit == 0);
        self.keep_apart(&mut pairs);
        (pairs, unfit)
    }

    /// A shape of a mode, or none.
    fn rough(self, shape: Vec<f64>, small: f64) -> Option<Rough> {
        const PART: f64 = 0.1;
        let square = self.stiffness.quadratic(&shape);
        let residual = self.residual(&long(&shape), square.into());
        let rest = inverse_mass_norm(self.mass, &residual).unwrap_or(f64::INFINITY);
        let sizes = self.stiffness.sizes().into_iter().zip(self.mass.sizes());
        let sizes: Vec<f64> = sizes.map(|(k, m)| k + square.abs() * m).collect();
        let terms = |x: &[f64], of: fn(f64, f64) -> f64| -> f64 {
            let terms = x.iter().zip(&sizes).filter(|(x, _)| **x != 0.0);
            terms.map(|(x, size)| of(*size, x * x)).sum::<f64>().sqrt()
        };
        let whole = terms(&shape, |size, square| size * square);
        let left = terms(&residual, |size, square| square / size);
        let is_resolved = rest <= PART * square.abs() || left <= small * whole;
        is_resolved.then_some(Rough {
            square,
            rest,
            shape,
        })
    }

    /// The eigenvectors of K and M in the span of shapes whose values are nearly one, with ρ and what rounding adds.
    fn separated(self, group: Vec<Rough>) -> Vec<(Pair, f64, f64)> {
        /// Shapes with less beside the others are one of them.
        const APART: f64 = 1e-3;
        let Shapes { mass, stiffness } = self;
        let mut product = vec![0.0; mass.len()];
        let mut kept: Vec<Vec<f64>> = Vec::new();
        for Rough { mut shape, .. } in group {
            mass.apply(&shape, &mut product);
            let along = |other: &Vec<f64>| dot(other, &product);
            let alongs: Vec<f64> = kept.iter().map(along).collect();
            for (other, along) in kept.iter().zip(alongs) {
                let entries = shape.iter_mut().zip(other);
                entries.for_each(|(x, y)| *x -= along * y);
            }
            let length = mass.quadratic(&shape).max(0.0).sqrt();
            if length > APART {
                shape.iter_mut().for_each(|x| *x /= length);
                kept.push(shape);
            }
        }
        let mut vectors: Vec<[Vec<DoubleDouble>; 2]> =
            kept.iter().map(|x| [long(x), Vec::new()]).collect();
        match refine::ritz(stiffness, mass, &mut vectors) {
            true => vectors.iter().map(|[x, _]| self.quotient(x)).collect(),
            false => Vec::new(),
        }
    }

    /// Of shapes that are not orthogonal, as those of modes are, keeps that with the least error.
    pub(crate) fn keep_apart(self, pairs: &mut Vec<Pair>) {
        const ALIKE: f64 = 0.05;
        let mass = self.mass;
        let error = |pair: &Pair| pair.error.unwrap_or(f64::INFINITY) / pair.square.abs();
        sort_by_number(pairs, error);
        let mut resisted: Vec<Vec<f64>> = Vec::new();
        pairs.retain(|pair| {
            let alike = |other: &Vec<f64>| dot(other, &pair.shape).abs() > ALIKE;
            let apart = !resisted.iter().any(alike);
            if apart {
                let mut product = vec![0.0; mass.len()];
                mass.apply(&pair.shape, &mut product);
                resisted.push(product);
            }
            apart
        });
    }

    /// θ = xᵀKx of a shape of M-norm 1, with ρ and what rounding adds.
    fn quotient(self, x: &[DoubleDouble]) -> (Pair, f64, f64) {
        let (energy, of_energy) = self.stiffness.quadratic_long(x);
        let (norm, of_norm) = self.mass.quadratic_long(x);
        let square = (energy / norm).to_f64();
        let rounding = of_energy + of_norm * square.abs() + f64::EPSILON * square.abs();
        let rest = self.residual(x, square.into());
        let rest = inverse_mass_norm(self.mass, &rest).unwrap_or(f64::INFINITY);
        let pair = Pair {
            square,
            shape: x.iter().map(|x| x.to_f64()).collect(),
            error: None,
        };
        (pair, rest, rounding)
    }

    /// Kx − θMx.
    fn residual(self, x: &[DoubleDouble], square: DoubleDouble) -> Vec<f64> {
        let mut product = vec![DoubleDouble::ZERO; x.len()];
        self.mass.accumulate_long(1.0, x, &mut product);
        product.iter_mut().for_each(|p| *p = -(*p * square));
        self.stiffness.accumulate_long(1.0, x, &mut product);
        product.into_iter().map(DoubleDouble::to_f64).collect()
    }
}

/// Errors from residuals and the distances between groups: the first has none below it where `held`, the last an
/// unknown one above. Where one is missing, as not all are `whole`, nothing is known of distances.
fn bounded(found: Vec<Vec<(Pair, f64, f64)>>, held: bool, whole: bool) -> Vec<Pair> {
    let values: Vec<Vec<f64>> = found
        .iter()
        .map(|group| group.iter().map(|(pair, ..)| pair.square).collect())
        .collect();
    let mut all = Vec::new();
    let last = found.len().saturating_sub(1);
    for (k, group) in found.into_iter().enumerate() {
        let joint = group.iter().map(|(_, rest, _)| rest * rest).sum::<f64>();
        for (mut pair, _, rounding) in group {
            let others = values.iter().enumerate().filter(|(j, _)| *j != k);
            let apart = others.flat_map(|(_, squares)| squares);
            let apart = apart.map(|square| (square - pair.square).abs());
            // Rigid motions lie at 0.
            let zero = (!held).then_some(pair.square.abs());
            let gap = apart.chain(zero).fold(f64::INFINITY, f64::min) - joint.sqrt();
            let second = match whole && k < last && gap > 0.0 {
                true => joint / gap,
                false => f64::INFINITY,
            };
            let error = joint.sqrt().min(second) + rounding;
            pair.error = error.is_finite().then_some(error);
            all.push(pair);
        }
    }
    all
}

fn long(x: &[f64]) -> Vec<DoubleDouble> {
    x.iter().map(|&x| x.into()).collect()
}

/// √(rᵀM⁻¹r): by conjugate gradients on M scaled to a unit diagonal (Golub & Van Loan 2013, *Matrix Computations*,
/// §11.3), which sum it up from below, with what a few more digits would add. `None` where M is 0 in a row in which r
/// is not, or that does not converge.
fn inverse_mass_norm(mass: &Form, r: &[f64]) -> Option<f64> {
    const STEPS: usize = 500;
    const DIGITS: f64 = 1e-3;
    let diagonal = mass.diagonal();
    let bare = |(m, r): (&f64, &f64)| *m <= 0.0 && *r != 0.0;
    if diagonal.iter().zip(r).any(bare) {
        return None;
    }
    if mass.is_diagonal() {
        let terms = diagonal.iter().zip(r).filter(|(m, _)| **m > 0.0);
        return Some(terms.map(|(m, r)| r * r / m).sum::<f64>().sqrt());
    }
    let scale: Vec<f64> = diagonal
        .iter()
        .map(|m| if *m > 0.0 { m.sqrt().recip() } else { 0.0 })
        .collect();
    let mut rest: Vec<f64> = r.iter().zip(&scale).map(|(r, s)| r * s).collect();
    let mut direction = rest.clone();
    let (mut along, mut product) = (vec![0.0; r.len()], vec![0.0; r.len()]);
    let mut size = dot(&rest, &rest);
    let first = size;
    let mut sum = 0.0;
    for _ in 0..STEPS {
        if size <= DIGITS * DIGITS * first {
            return Some((sum * (1.0 + 4.0 * DIGITS)).sqrt());
        }
        let scaled = direction.iter().zip(&scale).map(|(d, s)| d * s);
        along.iter_mut().zip(scaled).for_each(|(a, d)| *a = d);
        mass.apply(&along, &mut product);
        let energy = dot(&along, &product);
        if energy <= 0.0 || energy.is_nan() {
            return None;
        }
        let step = size / energy;
        sum += step * size;
        for ((rest, product), s) in rest.iter_mut().zip(&product).zip(&scale) {
            *rest -= step * product * s;
        }
        let before = std::mem::replace(&mut size, dot(&rest, &rest));
        let turn = size / before;
        let entries = direction.iter_mut().zip(&rest);
        entries.for_each(|(d, rest)| *d = *rest + turn * *d);
    }
    None
}
