//! A symmetric matrix as a network: joins between nodes, and from each node to the ground.
//!
//! xᵀAy = Σ w (x_i − x_j)(y_i − y_j) + Σ g_i x_i y_i, with w = −A_ij and g_i the sum of row i. Springs
//! are joins as they stand. Where no join is negative, no sum over them cancels: soft springs
//! beside stiff ones keep their digits, as they do not in the assembled matrix.

use std::ops::Mul;

use eigentone_digits::{DoubleDouble, Real, Wide};

use num_complex::Complex;

use crate::model::{Element, ElementKind, MatrixKind, Node};
use crate::structure::symmetric::is_symmetric;
use crate::system::System;

use super::entry::Entry;

/// A join between two nodes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Join {
    pub(crate) ends: [u32; 2],
    pub(crate) weight: f64,
}

impl Join {
    pub(crate) fn ends(self) -> (usize, usize) {
        (self.ends[0] as usize, self.ends[1] as usize)
    }
}

/// A symmetric matrix of order n.
#[derive(Clone, Debug)]
pub(crate) struct Form {
    /// From each node to the ground.
    ground: Vec<DoubleDouble>,
    /// Parallel ones are kept apart.
    joins: Vec<Join>,
    non_negative: bool,
    /// Whether the sums to the ground are exact.
    exact: bool,
}

impl Form {
    /// M, C or K of a system, without entries that are 0; `None` unless it is symmetric.
    pub(crate) fn of(system: &System, kind: MatrixKind) -> Option<Form> {
        let mut form = Form {
            ground: vec![DoubleDouble::ZERO; system.len()],
            joins: Vec::new(),
            non_negative: false,
            exact: true,
        };
        let elements: &[Element] = match kind {
            MatrixKind::Mass => &[],
            MatrixKind::Damping => system.dampers(),
            MatrixKind::Stiffness => system.springs(),
        };
        if kind == MatrixKind::Mass {
            for (i, &mass) in system.masses().iter().enumerate() {
                form.hold(i, mass);
            }
        }
        form.joins.reserve_exact(elements.len());
        for element in elements.iter().filter(|element| element.coefficient != 0.0) {
            form.element(element);
        }
        if !is_symmetric(system.model(), kind) {
            return None;
        }
        for term in system.model().added_terms(kind) {
            form.entry(term.row, term.column, term.value);
        }
        let of_one_sign = |ground: &DoubleDouble| ground.high() >= 0.0;
        form.non_negative =
            form.joins.iter().all(|join| join.weight > 0.0) && form.ground.iter().all(of_one_sign);
        Some(form)
    }

    /// 0, of order n.
    pub(crate) fn zero(n: usize) -> Form {
        Form {
            ground: vec![DoubleDouble::ZERO; n],
            joins: Vec::new(),
            non_negative: true,
            exact: true,
        }
    }

    /// The sum of the stiffnesses of the springs as they were given, those at points and supports too, each times a factor
    /// of its own.
    pub(crate) fn of_springs(system: &System, factors: &[f64]) -> Form {
        let mut form = Form::zero(system.len());
        let springs = system.elements(ElementKind::Spring).into_iter();
        for (spring, factor) in springs.zip(factors).filter(|(_, factor)| **factor != 0.0) {
            let product = DoubleDouble::product(spring.coefficient, *factor);
            form.square(product, &spring.stretch.coordinates);
        }
        form.non_negative = form.joins.iter().all(|join| join.weight > 0.0)
            && form.ground.iter().all(|ground| ground.high() >= 0.0);
        form
    }

    /// Adds c·a aᵀ, given the entries of a by their nodes.
    fn square(&mut self, c: DoubleDouble, entries: &[(usize, f64)]) {
        let parts = |value: DoubleDouble| {
            let parts = [value.high(), value.low()].into_iter();
            parts.filter(|part| *part != 0.0)
        };
        let zero = DoubleDouble::ZERO;
        let total = entries.iter().fold(zero, |sum, &(_, a)| sum + a);
        for (at, &(i, a)) in entries.iter().enumerate() {
            parts(c * a * total).for_each(|part| self.hold(i, part));
            for &(j, b) in entries[at + 1..].iter().filter(|(j, _)| *j != i) {
                let ends = [i.min(j) as u32, i.max(j) as u32];
                let weights = parts(c * a * -b);
                self.joins
                    .extend(weights.map(|weight| Join { ends, weight }));
            }
        }
        self.exact = false;
    }

    /// Adds a multiple of another matrix of the same order.
    pub(crate) fn add(&mut self, factor: f64, other: &Form) {
        for (sum, ground) in self.ground.iter_mut().zip(&other.ground) {
            *sum += *ground * factor;
        }
        for join in &other.joins {
            let product = DoubleDouble::product(join.weight, factor);
            let parts = [product.high(), product.low()].into_iter();
            let parts = parts.filter(|weight| *weight != 0.0);
            self.joins
                .extend(parts.map(|weight| Join { weight, ..*join }));
        }
        self.exact = false;
        self.non_negative &= other.non_negative && factor >= 0.0;
    }

    fn element(&mut self, element: &Element) {
        match (element.first, element.second) {
            (Node::Coordinate(i), Node::Coordinate(j)) => self.joins.push(Join {
                ends: [i as u32, j as u32],
                weight: element.coefficient,
            }),
            (Node::Coordinate(i), Node::Ground) | (Node::Ground, Node::Coordinate(i)) => {
                self.hold(i, element.coefficient);
            }
            (Node::Ground, Node::Ground) => {}
        }
    }

    /// Joins a node to the ground.
    fn hold(&mut self, i: usize, value: f64) {
        let before = self.ground[i];
        self.ground[i] += DoubleDouble::from(value);
        if before.high() != 0.0 && self.exact {
            let sum = Wide::<4>::from(before) + Wide::from(value);
            self.exact = sum == Wide::from(self.ground[i]);
        }
    }

    /// One of all entries of a symmetric matrix.
    fn entry(&mut self, i: usize, j: usize, value: f64) {
        if value == 0.0 {
            return;
        }
        self.hold(i, value);
        if i < j {
            self.joins.push(Join {
                ends: [i as u32, j as u32],
                weight: -value,
            });
        }
    }

    /// The order n.
    pub(crate) fn len(&self) -> usize {
        self.ground.len()
    }

    /// The joins between nodes.
    pub(crate) fn joins(&self) -> &[Join] {
        &self.joins
    }

    /// The sum of row i.
    pub(crate) fn ground(&self, i: usize) -> f64 {
        self.ground[i].high()
    }

    /// The sum of row i, to the digits of a double-double.
    pub(crate) fn ground_long(&self, i: usize) -> DoubleDouble {
        self.ground[i]
    }

    /// By nodes, the sums of the absolute values of all that is added up in a row.
    pub(crate) fn sizes(&self) -> Vec<f64> {
        let mut sizes: Vec<f64> = self.ground.iter().map(|sum| sum.high().abs()).collect();
        for join in &self.joins {
            let (i, j) = join.ends();
            sizes[i] += 2.0 * join.weight.abs();
            sizes[j] += 2.0 * join.weight.abs();
        }
        sizes
    }

    /// Whether no join is negative, so that the matrix is positive semidefinite and no sum cancels.
    pub(crate) fn is_non_negative(&self) -> bool {
        self.non_negative
    }

    /// Whether there are no joins between nodes.
    pub(crate) fn is_diagonal(&self) -> bool {
        self.joins.is_empty()
    }

    /// Whether every entry is 0.
    pub(crate) fn is_zero(&self) -> bool {
        self.joins.is_empty() && self.ground.iter().all(|ground| ground.high() == 0.0)
    }

    /// A_ii of every node, in doubles.
    pub(crate) fn diagonal(&self) -> Vec<f64> {
        let mut diagonal: Vec<f64> = self.ground.iter().map(|ground| ground.high()).collect();
        for join in &self.joins {
            let (i, j) = join.ends();
            diagonal[i] += join.weight;
            diagonal[j] += join.weight;
        }
        diagonal
    }

    /// The Frobenius norm, parallel joins taken apart.
    pub(crate) fn norm(&self) -> f64 {
        let diagonal = self.diagonal();
        let beside = self
            .joins
            .iter()
            .map(|join| 2.0 * join.weight * join.weight);
        let squares = diagonal.iter().map(|entry| entry * entry);
        (squares.sum::<f64>() + beside.sum::<f64>()).sqrt()
    }

    /// y = A x in doubles.
    pub(crate) fn apply(&self, x: &[f64], y: &mut [f64]) {
        for ((y, ground), x) in y.iter_mut().zip(&self.ground).zip(x) {
            *y = ground.high() * x;
        }
        for join in &self.joins {
            let (i, j) = join.ends();
            let force = join.weight * (x[i] - x[j]);
            y[i] += force;
            y[j] -= force;
        }
    }

    /// y += factor·A x, every term and sum in double-double.
    pub(crate) fn accumulate(&self, factor: f64, x: &[f64], y: &mut [DoubleDouble]) {
        let stretch = |i: usize, j: usize| DoubleDouble::new(x[i], -x[j]);
        self.add_forces(factor, |i| x[i], stretch, y);
    }

    /// The same for a vector of double-doubles.
    pub(crate) fn accumulate_long(&self, factor: f64, x: &[DoubleDouble], y: &mut [DoubleDouble]) {
        self.add_forces(factor, |i| x[i], |i, j| x[i] - x[j], y);
    }

    /// Adds a multiple of the forces in all joins, by what nodes and joins are stretched.
    #[inline(always)]
    fn add_forces<T>(
        &self,
        factor: f64,
        moved: impl Fn(usize) -> T,
        stretch: impl Fn(usize, usize) -> DoubleDouble,
        y: &mut [DoubleDouble],
    ) where
        DoubleDouble: Mul<T, Output = DoubleDouble> + Mul<f64, Output = DoubleDouble>,
    {
        let multiple = |force: DoubleDouble| match factor {
            1.0 => force,
            -1.0 => -force,
            _ => force * factor,
        };
        for (i, (y, ground)) in y.iter_mut().zip(&self.ground).enumerate() {
            *y += multiple(*ground * moved(i));
        }
        for join in &self.joins {
            let (i, j) = join.ends();
            let force = multiple(stretch(i, j) * join.weight);
            y[i] += force;
            y[j] -= force;
        }
    }

    /// xᵀAx. Where no term is negative they are taken in doubles and their sum compensated, which
    /// errs by 4 units of rounding; else all is in double-double.
    pub(crate) fn quadratic(&self, x: &[f64]) -> f64 {
        if self.non_negative {
            let mut sum = Compensated::default();
            for (ground, x) in self.ground.iter().zip(x) {
                sum.add(ground.high() * x * x);
            }
            for join in &self.joins {
                let (i, j) = join.ends();
                let stretch = x[i] - x[j];
                sum.add(join.weight * stretch * stretch);
            }
            return sum.total();
        }
        let mut sum = DoubleDouble::ZERO;
        for (ground, &x) in self.ground.iter().zip(x) {
            sum += *ground * DoubleDouble::product(x, x);
        }
        for join in &self.joins {
            let (i, j) = join.ends();
            let stretch = DoubleDouble::new(x[i], -x[j]);
            sum += stretch * stretch * join.weight;
        }
        sum.to_f64()
    }

    /// y += factor·A x in complex doubles.
    pub(crate) fn accumulate_complex(
        &self,
        factor: Complex<f64>,
        x: &[Complex<f64>],
        y: &mut [Complex<f64>],
    ) {
        for ((y, ground), x) in y.iter_mut().zip(&self.ground).zip(x) {
            *y += factor * x * ground.high();
        }
        for join in &self.joins {
            let (i, j) = join.ends();
            let force = factor * (x[i] - x[j]) * join.weight;
            y[i] += force;
            y[j] -= force;
        }
    }

    /// y += factor·|A|x for x ≥ 0, or more: the sums of the sizes of all terms of A x.
    pub(crate) fn accumulate_sizes(&self, factor: f64, x: &[f64], y: &mut [f64]) {
        for ((y, ground), x) in y.iter_mut().zip(&self.ground).zip(x) {
            *y += ground.high().abs() * x * factor;
        }
        for join in &self.joins {
            let (i, j) = join.ends();
            let force = (x[i] + x[j]) * join.weight.abs() * factor;
            y[i] += force;
            y[j] += force;
        }
    }

    /// xᵀAy, and the sum of the sizes of its terms, all in double-double.
    pub(crate) fn bilinear_long(
        &self,
        x: &[DoubleDouble],
        y: &[DoubleDouble],
    ) -> (DoubleDouble, f64) {
        let mut sum = DoubleDouble::ZERO;
        let mut sizes = 0.0;
        let mut add = |term: DoubleDouble| {
            sum += term;
            sizes += term.high().abs();
        };
        for ((ground, &x), &y) in self.ground.iter().zip(x).zip(y) {
            add(*ground * x * y);
        }
        for join in &self.joins {
            let (i, j) = join.ends();
            add((x[i] - x[j]) * (y[i] - y[j]) * join.weight);
        }
        (sum, sizes)
    }

    /// xᵀAx without rounding that matters, but for that of the sums of rows, and a bound of that.
    pub(crate) fn quadratic_long(&self, x: &[DoubleDouble]) -> (Wide<4>, f64) {
        let wide: Vec<Wide<4>> = x.iter().map(|&x| x.into()).collect();
        let mut sum = Wide::ZERO;
        for (ground, &x) in self.ground.iter().zip(&wide) {
            sum = sum + Wide::from(*ground) * x * x;
        }
        for join in &self.joins {
            let (i, j) = join.ends();
            let stretch = wide[i] - wide[j];
            sum = sum + stretch * stretch * Wide::from(join.weight);
        }
        let rounded = match self.exact {
            true => 0.0,
            false => {
                let terms = self.sizes().into_iter().zip(x);
                let terms = terms.map(|(size, x)| size * x.high() * x.high());
                DoubleDouble::UNIT * terms.sum::<f64>()
            }
        };
        (sum, rounded)
    }

    /// xᵀAy in doubles, to a small multiple of √(xᵀAx · yᵀAy) where no join is negative.
    pub(crate) fn bilinear(&self, x: &[f64], y: &[f64]) -> f64 {
        let mut sum = Compensated::default();
        for ((ground, x), y) in self.ground.iter().zip(x).zip(y) {
            sum.add(ground.high() * x * y);
        }
        for join in &self.joins {
            let (i, j) = join.ends();
            sum.add(join.weight * (x[i] - x[j]) * (y[i] - y[j]));
        }
        sum.total()
    }
}

/// A running sum with the rounding errors of its additions (Neumaier 1974, *Z. Angew. Math. Mech.*
/// 54), in the branch-free form of Knuth's two-sum.
#[derive(Clone, Copy, Debug, Default)]
struct Compensated {
    sum: f64,
    error: f64,
}

impl Compensated {
    #[inline]
    fn add(&mut self, term: f64) {
        let sum = self.sum + term;
        let part = sum - self.sum;
        self.error += (self.sum - (sum - part)) + (term - part);
        self.sum = sum;
    }

    fn total(self) -> f64 {
        self.sum + self.error
    }
}
