//! A simple root and its shapes with more digits: Newton's method on the bordered system.
//!
//! (λ, x) with x_p = 1 solves Q(λ)x = 0 and e_pᵀx = 1; the derivative of these equations is
//! B = [Q(λ) Q′(λ)x; e_pᵀ 0], which is regular if and only if λ is simple and x_p ≠ 0 (Nelson 1976,
//! *AIAA J.* 14; Andrew, Chu & Lancaster 1993, *SIAM J. Matrix Anal.* 14). The last column of B⁻*
//! is the left shape y with y*Q′(λ)x = 1.

use std::sync::Arc;

use eigentone_digits::ComplexDoubleDouble;
use num_complex::Complex;

use crate::model::{Element, MatrixKind, Square};
use crate::system::System;

type Number = ComplexDoubleDouble;

/// Steps of Newton's method that are allowed, from errors of 2^-4 or less.
const STEPS: usize = 8;

/// Errors below this are squared below 2^-104 by one more step, but for the system's condition.
const NEAR: f64 = 1e-12;

/// B is taken as singular where its reciprocal condition, after scaling, is below this.
const SINGULAR: f64 = 1e-27;

/// λ and x, each to about the 106 bits of a double-double less what the condition takes, with B
/// there factorised.
#[derive(Clone, Debug)]
pub(crate) struct Resolved {
    pub(crate) lambda: Number,
    pub(crate) x: Vec<Number>,
    /// Q′(λ)x.
    pub(crate) slope: Vec<Number>,
    /// How far off λ may be: what its last step and rounding leave.
    pub(crate) error: f64,
    terms: Vec<(f64, Place)>,
    factors: Factors,
}

impl Resolved {
    /// From an approximate root and its shape. `None` where Newton's method does not confirm them
    /// or B is singular to working precision: another root is too near.
    pub(crate) fn of(
        system: &System,
        lambda: Complex<f64>,
        shape: &[Complex<f64>],
    ) -> Option<Resolved> {
        let pivot = shape
            .iter()
            .position(|entry| *entry == Complex::ONE)
            .filter(|_| shape.len() == system.len())?;
        let mut terms = terms(system);
        let entry = |z: &Complex<f64>| Number::new(z.re, z.im);
        let mut root = entry(&lambda);
        let mut x: Vec<Number> = shape.iter().map(entry).collect();
        let (mut previous, mut root_before) = (0.125, f64::INFINITY);
        for _ in 0..STEPS {
            let resolved = Resolved::at(terms, root, x, pivot)?;
            let (change, root_change) = resolved.solve(&resolved.residual());
            let size = step_size(&change, root_change, root);
            if previous <= NEAR {
                // B is that of the last digits now: this step only tidies up.
                let is_near = size <= NEAR && resolved.factors.reciprocal_condition() >= SINGULAR;
                let resolved = is_near.then(|| resolved.moved(&change, root_change, pivot))?;
                return resolved.settled(root_before, root_change.norm());
            }
            if size > previous / 2.0 {
                return None;
            }
            (previous, root_before) = (size, root_change.norm());
            let moved = resolved.moved(&change, root_change, pivot);
            (root, x, terms) = (moved.lambda, moved.x, moved.terms);
        }
        None
    }

    fn at(
        terms: Vec<(f64, Place)>,
        lambda: Number,
        x: Vec<Number>,
        pivot: usize,
    ) -> Option<Resolved> {
        let n = x.len();
        let powers = powers(lambda);
        let slope = slope(&terms, lambda, &x);
        let derived = [0.0, 1.0, 2.0 * lambda.norm()];
        let mut bordered = vec![Number::ZERO; (n + 1) * (n + 1)];
        let mut sizes = vec![0.0; (n + 1) * (n + 1)];
        for (value, place) in &terms {
            for (row, left) in place.left.parts() {
                for (column, right) in place.right.parts() {
                    let entry = powers[place.power] * *value * *left * *right;
                    bordered[row * (n + 1) + column] += entry;
                    sizes[row * (n + 1) + column] += entry.norm();
                }
            }
            let force = value.abs() * derived[place.power] * place.right.of(&x).norm();
            for (row, _) in place.left.parts() {
                sizes[row * (n + 1) + n] += force;
            }
        }
        for (i, entry) in slope.iter().enumerate() {
            bordered[i * (n + 1) + n] = *entry;
        }
        bordered[n * (n + 1) + pivot] = one();
        sizes[n * (n + 1) + pivot] = 1.0;
        Some(Resolved {
            factors: Factors::of(bordered, &sizes, n + 1)?,
            lambda,
            x,
            slope,
            error: f64::INFINITY,
            terms,
        })
    }

    /// With its error, from the last two changes of λ. `None` where the steps neither shrink as those towards a simple root do
    /// nor are what rounding leaves: near a multiple root each is half as long as the one before, or longer.
    fn settled(mut self, before: f64, last: f64) -> Option<Resolved> {
        /// Of λ; beyond all that a double holds.
        const NEGLIGIBLE: f64 = 1e-22;
        if self.lambda == Number::ZERO {
            self.error = 0.0;
            return Some(self);
        }
        let rounding = self.rounding(&self.left());
        let least = NEGLIGIBLE * self.lambda.norm();
        self.error = rounding + least + 2.0 * last * (last / before).min(1.0);
        (last <= before / 4.0 || last <= least.max(4.0 * rounding)).then_some(self)
    }

    /// −Q(λ)x.
    fn residual(&self) -> Vec<Number> {
        let image = product(&self.terms, powers(self.lambda), &self.x, false);
        image.into_iter().map(|entry| -entry).collect()
    }

    fn moved(mut self, change: &[Number], root_change: Number, pivot: usize) -> Resolved {
        // 0 is only ever given exactly.
        if self.lambda != Number::ZERO {
            self.lambda += root_change;
        }
        for (i, (entry, change)) in self.x.iter_mut().zip(change).enumerate() {
            if i != pivot {
                *entry += *change;
            }
        }
        self.slope = slope(&self.terms, self.lambda, &self.x);
        self
    }

    /// x′ and λ′ with Q(λ)x′ + λ′Q′(λ)x = `right` and x′_p = 0, once refined.
    pub(crate) fn solve(&self, right: &[Number]) -> (Vec<Number>, Number) {
        let n = right.len();
        let mut bordered = right.to_vec();
        bordered.push(Number::ZERO);
        let mut solution = self.factors.solve(&bordered);
        let image = product(&self.terms, powers(self.lambda), &solution[..n], false);
        for i in 0..n {
            bordered[i] = right[i] - image[i] - self.slope[i] * solution[n];
        }
        for (entry, correction) in solution.iter_mut().zip(self.factors.solve(&bordered)) {
            *entry += correction;
        }
        let root_change = solution[n];
        solution.truncate(n);
        (solution, root_change)
    }

    /// How far rounding in the terms of Q(λ)x may move λ: what y*Q(λ)x errs by, where y*Q′(λ)x = 1.
    fn rounding(&self, y: &[Number]) -> f64 {
        /// Of each product and sum in a term, a few of 2^-104.
        const UNIT: f64 = 1e-30;
        let size = self.lambda.norm();
        let each = self.terms.iter().map(|(value, place)| {
            let parts = place.right.parts().iter();
            let moved: f64 = parts
                .map(|(i, times)| times.abs() * self.x[*i].norm())
                .sum();
            value.abs() * size.powi(place.power as i32) * place.left.of(y).norm() * moved
        });
        UNIT * each.sum::<f64>()
    }

    /// y with y*Q(λ) = 0 and y*Q′(λ)x = 1, once refined.
    pub(crate) fn left(&self) -> Vec<Number> {
        let n = self.x.len();
        let mut bordered = vec![Number::ZERO; n + 1];
        bordered[n] = one();
        let mut y = self.factors.solve_adjoint(&bordered);
        y.truncate(n);
        let image = product(&self.terms, powers(self.lambda).map(conjugate), &y, true);
        let at_slope = self
            .slope
            .iter()
            .zip(&y)
            .fold(one(), |rest, (slope, y)| rest - conjugate(*slope) * *y);
        let mut rest: Vec<Number> = image.into_iter().map(|entry| -entry).collect();
        rest.push(at_slope);
        for (entry, correction) in y.iter_mut().zip(self.factors.solve_adjoint(&rest)) {
            *entry += correction;
        }
        y
    }
}

/// Where a number p enters: Q(λ) holds p·λ^power·l rᵀ.
#[derive(Clone, Debug)]
struct Place {
    power: usize,
    left: Form,
    right: Form,
}

/// A linear form by index and coefficient; an index may come more than once.
#[derive(Clone, Debug)]
enum Form {
    /// So many of two.
    Short([(usize, f64); 2], usize),
    Long(Arc<[(usize, f64)]>),
}

impl Form {
    fn alone(i: usize) -> Form {
        Form::Short([(i, 1.0), (0, 0.0)], 1)
    }

    /// x_first − x_second, with 0 at the ground.
    fn of_element(element: &Element) -> Form {
        match (element.first.coordinate(), element.second.coordinate()) {
            (Some(i), Some(j)) => Form::Short([(i, 1.0), (j, -1.0)], 2),
            (Some(i), None) | (None, Some(i)) => Form::alone(i),
            (None, None) => Form::Short([(0, 0.0); 2], 0),
        }
    }

    fn parts(&self) -> &[(usize, f64)] {
        match self {
            Form::Short(parts, count) => &parts[..*count],
            Form::Long(parts) => parts,
        }
    }

    fn of(&self, x: &[Number]) -> Number {
        let parts = self.parts().iter();
        parts.fold(Number::ZERO, |sum, (i, times)| sum + x[*i] * *times)
    }
}

/// All that M, C and K are made of, elements as they are.
fn terms(system: &System) -> Vec<(f64, Place)> {
    let model = system.model();
    let kinds = [
        (2, MatrixKind::Mass, &[] as &[Element]),
        (1, MatrixKind::Damping, system.dampers()),
        (0, MatrixKind::Stiffness, system.springs()),
    ];
    let mut terms = Vec::new();
    for (power, kind, elements) in kinds {
        let symmetric = |value, left: Form| {
            let right = left.clone();
            (value, Place { power, left, right })
        };
        let elements = elements.iter();
        terms.extend(elements.map(|each| symmetric(each.coefficient, Form::of_element(each))));
        if let Some(squares) = model.added_whole(kind).squares() {
            let long = |square: &Square| Form::Long(square.form.as_slice().into());
            terms.extend(
                squares
                    .iter()
                    .map(|each| symmetric(each.coefficient, long(each))),
            );
            if kind == MatrixKind::Mass {
                let masses = system.masses().iter().enumerate();
                terms.extend(masses.map(|(i, mass)| symmetric(*mass, Form::alone(i))));
            }
        } else {
            terms.extend(model.single_terms(kind).map(|term| {
                let (left, right) = (Form::alone(term.row), Form::alone(term.column));
                (term.value, Place { power, left, right })
            }));
        }
    }
    terms.retain(|(value, _)| *value != 0.0);
    terms
}

fn one() -> Number {
    Number::new(1.0, 0.0)
}

/// 1, λ and λ².
fn powers(lambda: Number) -> [Number; 3] {
    [one(), lambda, lambda * lambda]
}

/// Q′(λ)x.
fn slope(terms: &[(f64, Place)], lambda: Number, x: &[Number]) -> Vec<Number> {
    product(terms, [Number::ZERO, one(), lambda * 2.0], x, false)
}

/// The larger of ‖δx‖∞, where ‖x‖∞ = 1, and |δλ|/|λ|, the latter not at 0; infinite if anything is
/// not finite.
fn step_size(change: &[Number], root_change: Number, root: Number) -> f64 {
    let relative = if root == Number::ZERO {
        0.0
    } else {
        root_change.norm() / root.norm()
    };
    let sizes = change.iter().map(|entry| entry.norm());
    sizes.fold(relative, |largest, size| {
        if size.is_finite() && largest.is_finite() {
            largest.max(size)
        } else {
            f64::INFINITY
        }
    })
}

/// Σ value·weight·l rᵀx, or with left and right exchanged.
fn product(
    terms: &[(f64, Place)],
    weights: [Number; 3],
    x: &[Number],
    transposed: bool,
) -> Vec<Number> {
    let mut image = vec![Number::ZERO; x.len()];
    for (value, place) in terms {
        let (from, to) = if transposed {
            (&place.left, &place.right)
        } else {
            (&place.right, &place.left)
        };
        let force = from.of(x) * *value * weights[place.power];
        for (i, times) in to.parts() {
            image[*i] += force * *times;
        }
    }
    image
}

pub(crate) fn conjugate(z: Number) -> Number {
    Number {
        re: z.re,
        im: -z.im,
    }
}

/// R·A·C = PᵀLU by Gaussian elimination with row interchanges, R and C powers of two that make the
/// largest terms of rows and columns about 1. Zeros are passed over, so that chains cost O(n²).
#[derive(Clone, Debug)]
struct Factors {
    n: usize,
    /// L below the diagonal, U on and above it, row by row.
    entries: Vec<Number>,
    /// Which row of A was used as each pivot.
    order: Vec<usize>,
    rows: Vec<f64>,
    columns: Vec<f64>,
}

impl Factors {
    /// From A and the sizes of its entries' terms, so that an entry or a row that cancels stays
    /// small. `None` if A is singular or not finite.
    fn of(mut entries: Vec<Number>, sizes: &[f64], n: usize) -> Option<Factors> {
        let rows: Vec<f64> = sizes
            .chunks_exact(n)
            .map(|row| power_below(row.iter().copied()))
            .collect();
        let columns: Vec<f64> = (0..n)
            .map(|j| power_below((0..n).map(|i| sizes[i * n + j] * rows[i])))
            .collect();
        for (row, r) in entries.chunks_exact_mut(n).zip(&rows) {
            for (entry, c) in row.iter_mut().zip(&columns) {
                *entry = *entry * *r * *c;
            }
        }
        let mut order: Vec<usize> = (0..n).collect();
        for step in 0..n {
            let size = |i: &usize| entries[i * n + step].norm();
            let pivot = (step..n).max_by(|i, j| size(i).total_cmp(&size(j)))?;
            if !(size(&pivot) > 0.0 && size(&pivot).is_finite()) {
                return None;
            }
            order.swap(step, pivot);
            for j in 0..n {
                entries.swap(step * n + j, pivot * n + j);
            }
            let (above, below) = entries.split_at_mut((step + 1) * n);
            let row = &above[step * n..];
            let filled: Vec<usize> = (step + 1..n).filter(|j| row[*j] != Number::ZERO).collect();
            for target in below.chunks_exact_mut(n) {
                if target[step] == Number::ZERO {
                    continue;
                }
                let factor = target[step] / row[step];
                target[step] = factor;
                for &j in &filled {
                    target[j] = target[j] - factor * row[j];
                }
            }
        }
        Some(Factors {
            n,
            entries,
            order,
            rows,
            columns,
        })
    }

    /// A⁻¹b.
    fn solve(&self, b: &[Number]) -> Vec<Number> {
        let scaled: Vec<Number> = b.iter().zip(&self.rows).map(|(b, r)| *b * *r).collect();
        let z = self.solve_scaled(&scaled);
        z.iter().zip(&self.columns).map(|(z, c)| *z * *c).collect()
    }

    /// A⁻*b.
    fn solve_adjoint(&self, b: &[Number]) -> Vec<Number> {
        let scaled: Vec<Number> = b.iter().zip(&self.columns).map(|(b, c)| *b * *c).collect();
        let z = self.solve_adjoint_scaled(&scaled);
        z.iter().zip(&self.rows).map(|(z, r)| *z * *r).collect()
    }

    fn solve_scaled(&self, b: &[Number]) -> Vec<Number> {
        let (n, lu) = (self.n, &self.entries);
        let mut z: Vec<Number> = self.order.iter().map(|i| b[*i]).collect();
        let subtract = |z: &mut [Number], i: usize, j: usize| {
            if lu[i * n + j] != Number::ZERO {
                z[i] = z[i] - lu[i * n + j] * z[j];
            }
        };
        for i in 0..n {
            for j in 0..i {
                subtract(&mut z, i, j);
            }
        }
        for i in (0..n).rev() {
            for j in i + 1..n {
                subtract(&mut z, i, j);
            }
            z[i] = z[i] / lu[i * n + i];
        }
        z
    }

    fn solve_adjoint_scaled(&self, b: &[Number]) -> Vec<Number> {
        let (n, lu) = (self.n, &self.entries);
        let mut z = b.to_vec();
        let subtract = |z: &mut [Number], i: usize, j: usize| {
            if lu[j * n + i] != Number::ZERO {
                z[i] = z[i] - conjugate(lu[j * n + i]) * z[j];
            }
        };
        for i in 0..n {
            for j in 0..i {
                subtract(&mut z, i, j);
            }
            z[i] = z[i] / conjugate(lu[i * n + i]);
        }
        for i in (0..n).rev() {
            for j in i + 1..n {
                subtract(&mut z, i, j);
            }
        }
        let mut result = vec![Number::ZERO; n];
        for (step, &i) in self.order.iter().enumerate() {
            result[i] = z[step];
        }
        result
    }

    /// About 1/‖(RAC)⁻¹‖₂, by two rounds of inverse iteration from a vector without pattern.
    fn reciprocal_condition(&self) -> f64 {
        const ROUNDS: usize = 2;
        const GOLDEN_ANGLE: f64 = 2.399963229728653;
        let mut z: Vec<Number> = (0..self.n)
            .map(|i| {
                let phase = Complex::cis(GOLDEN_ANGLE * i as f64);
                Number::new(phase.re, phase.im)
            })
            .collect();
        let mut growth = 0.0;
        for _ in 0..ROUNDS {
            for half in [Factors::solve_scaled, Factors::solve_adjoint_scaled] {
                let size = norm(&z);
                let unit: Vec<Number> = z.iter().map(|entry| *entry * (1.0 / size)).collect();
                z = half(self, &unit);
                growth = norm(&z);
            }
        }
        1.0 / growth
    }
}

fn norm(z: &[Number]) -> f64 {
    z.iter().map(|entry| entry.norm()).fold(0.0, f64::hypot)
}

/// The power of two that brings the largest size to [1, 2); 1 if all are 0 or one is not finite.
fn power_below(sizes: impl Iterator<Item = f64>) -> f64 {
    let largest = sizes.fold(0.0, f64::max);
    if largest > 0.0 && largest.is_finite() {
        (-largest.log2().floor()).clamp(-1000.0, 1000.0).exp2()
    } else {
        1.0
    }
}
