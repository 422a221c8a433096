//! A = (K − σM)⁻¹M, whose eigenvalues 1/(λ − σ) are largest for the λ nearest to σ (Ericsson & Ruhe
//! 1980, *Math. Comp.* 35, "The spectral transformation Lanczos method").

use eigentone_digits::{Cholesky, DoubleDouble};
use faer::Mat;

use super::basis::dot;
use super::factor::{Factor, Sum};
use super::pencil::Pencil;

/// A with the motions at λ = 0 taken out that K lets go on without force.
#[derive(Debug)]
pub(crate) struct ShiftInvert<'a> {
    pub(crate) pencil: &'a Pencil,
    factor: Digits<'a>,
    pub(crate) shift: f64,
    rigid: Option<Rigid>,
    /// How often a solve is corrected by its residual.
    refinements: usize,
}

/// A factor with as many digits as it takes.
#[derive(Debug)]
enum Digits<'a> {
    Doubles(Factor<'a>),
    DoubleDoubles(Factor<'a, DoubleDouble>),
}

/// Parts that nothing holds, and how M weighs them.
#[derive(Clone, Debug)]
pub(crate) struct Rigid {
    /// The part of each node.
    part: Vec<u32>,
    weights: Weights,
}

/// The matrix of the forms of M between parts.
#[derive(Clone, Debug)]
enum Weights {
    Diagonal(Vec<f64>),
    Inverse(Mat<f64>),
}

/// In no such part.
const HELD: u32 = u32::MAX;

impl Rigid {
    /// So many parts may have masses in common.
    const MOST: usize = 500;

    /// Of these parts, all of which have mass; `None` where there are too many for a mass matrix that is
    /// not diagonal.
    pub(crate) fn of(parts: &[Vec<usize>], mass: &super::form::Form) -> Option<Rigid> {
        let mut part = vec![HELD; mass.len()];
        for (at, nodes) in parts.iter().enumerate() {
            nodes.iter().for_each(|&node| part[node] = at as u32);
        }
        if mass.is_diagonal() {
            let sum = |nodes: &Vec<usize>| nodes.iter().map(|&i| mass.ground(i)).sum();
            let weights = Weights::Diagonal(parts.iter().map(sum).collect());
            return Some(Rigid { part, weights });
        }
        if parts.len() > Rigid::MOST {
            return None;
        }
        let mut gram = Mat::<f64>::zeros(parts.len(), parts.len());
        let mut product = vec![0.0; mass.len()];
        for (at, nodes) in parts.iter().enumerate() {
            let mut shape = vec![0.0; mass.len()];
            nodes.iter().for_each(|&node| shape[node] = 1.0);
            mass.apply(&shape, &mut product);
            for (other, nodes) in parts.iter().enumerate() {
                gram[(other, at)] = nodes.iter().map(|&node| product[node]).sum();
            }
        }
        let inverse = Cholesky::of(gram.as_ref())?.inverse();
        let weights = Weights::Inverse(inverse);
        Some(Rigid { part, weights })
    }

    fn parts(&self) -> usize {
        match &self.weights {
            Weights::Diagonal(weights) => weights.len(),
            Weights::Inverse(inverse) => inverse.nrows(),
        }
    }

    /// Makes x orthogonal to them, given M x.
    pub(crate) fn remove(&self, mass_times_x: &[f64], x: &mut [f64]) {
        let mut sums = vec![0.0; self.parts()];
        for (&part, value) in self.part.iter().zip(mass_times_x) {
            if part != HELD {
                sums[part as usize] += value;
            }
        }
        self.subtract(sums, x);
    }

    /// The same from sums in double-double.
    fn remove_long(&self, mass_times_x: &[DoubleDouble], x: &mut [f64]) {
        let mut sums = vec![DoubleDouble::ZERO; self.parts()];
        for (&part, value) in self.part.iter().zip(mass_times_x) {
            if part != HELD {
                sums[part as usize] += *value;
            }
        }
        self.subtract(sums.into_iter().map(DoubleDouble::to_f64).collect(), x);
    }

    fn subtract(&self, mut sums: Vec<f64>, x: &mut [f64]) {
        let parts = sums.len();
        match &self.weights {
            Weights::Diagonal(weights) => {
                let pairs = sums.iter_mut().zip(weights);
                pairs.for_each(|(sum, weight)| *sum /= weight);
            }
            Weights::Inverse(inverse) => {
                sums = (0..parts)
                    .map(|i| (0..parts).map(|j| inverse[(i, j)] * sums[j]).sum())
                    .collect();
            }
        }
        for (&part, value) in self.part.iter().zip(x) {
            if part != HELD {
                *value -= sums[part as usize];
            }
        }
    }
}

/// Solves that err by more are corrected, relative to their result.
const ROUGH: f64 = 1e-9;

/// A factor whose solves err by more does not serve to correct them.
const LOST: f64 = 1e-2;

impl<'a> ShiftInvert<'a> {
    pub(crate) fn new(factor: Factor<'a>, pencil: &'a Pencil, shift: f64) -> ShiftInvert<'a> {
        ShiftInvert {
            pencil,
            factor: Digits::Doubles(factor),
            shift,
            rigid: None,
            refinements: 0,
        }
    }

    /// The same without these motions.
    pub(crate) fn without(self, rigid: Rigid) -> ShiftInvert<'a> {
        ShiftInvert {
            rigid: Some(rigid),
            ..self
        }
    }

    /// The same with solves that are good to about 9 digits: corrected by their residuals, from a factor with
    /// more digits where doubles lose too many, or where that takes less work. `None` where those do not suffice either.
    pub(crate) fn accurate(mut self) -> Option<ShiftInvert<'a>> {
        if self.never_cancels() {
            return Some(self);
        }
        let refinements = |error: f64| {
            // What a correction leaves is the square of the error, a second one the cube.
            let digits = ROUGH.ln() / error.ln();
            (error <= LOST).then(|| (digits.ceil() as usize).saturating_sub(1))
        };
        // A residual takes as many products of double-doubles as there are joins, a solve in these twice
        // as many as the factor has entries.
        let forms = [&self.pencil.stiffness, &self.pencil.mass];
        let joins: usize = forms.iter().map(|form| form.joins().len()).sum();
        let entries = self.pencil.ordering.rows.len();
        let found = refinements(self.probe());
        self.refinements = match found {
            Some(count) if count * joins <= 2 * entries => count,
            _ => {
                let factor = Factor::sum(self.pencil, Sum::shifted(self.shift), &[]);
                if !factor.is_finite() {
                    return None;
                }
                self.factor = Digits::DoubleDoubles(factor);
                refinements(self.probe())?
            }
        };
        Some(self)
    }

    /// How much a solve for a random vector lacks, relative to its result.
    fn probe(&self) -> f64 {
        let n = self.pencil.len();
        let mut state = 0x2545_f491_4f6c_dd1d_u64;
        let x: Vec<f64> = (0..n).map(|_| super::random::uniform(&mut state)).collect();
        let (mut y, mut work) = (vec![0.0; n], vec![0.0; n]);
        self.pencil.mass.apply(&x, &mut y);
        self.solve_once(&mut y, &mut work);
        let missing = self.correction(&x, &y, &mut work);
        let mut norm = |x: &[f64]| {
            self.pencil.mass.apply(x, &mut work);
            dot(x, &work).max(0.0).sqrt()
        };
        let (missing, whole) = (norm(&missing), norm(&y));
        match missing / whole {
            error if error.is_finite() => error.max(f64::EPSILON),
            _ => f64::INFINITY,
        }
    }

    /// Makes x orthogonal to the motions that were taken out; `work` is of the same length.
    pub(crate) fn project(&self, x: &mut [f64], work: &mut [f64]) {
        if let Some(rigid) = &self.rigid {
            self.pencil.mass.apply(x, work);
            rigid.remove(work, x);
        }
    }

    /// (K − σM)⁻¹ b in place of b, without corrections.
    fn solve_once(&self, b: &mut [f64], work: &mut [f64]) {
        match &self.factor {
            Digits::Doubles(factor) => factor.solve(b, work),
            Digits::DoubleDoubles(factor) => {
                let mut long: Vec<DoubleDouble> = b.iter().map(|&b| b.into()).collect();
                factor.solve(&mut long, &mut vec![DoubleDouble::ZERO; b.len()]);
                b.iter_mut().zip(&long).for_each(|(b, x)| *b = x.to_f64());
            }
        }
        self.project(b, work);
    }

    /// (K − σM)⁻¹ b in place of b.
    pub(crate) fn solve(&self, b: &mut [f64], work: &mut [f64]) {
        let given = (self.refinements > 0).then(|| b.to_vec());
        self.solve_once(b, work);
        let Some(given) = given else { return };
        for _ in 0..self.refinements {
            let mut residual: Vec<DoubleDouble> = given.iter().map(|&b| b.into()).collect();
            self.subtract(b, &mut residual);
            let mut correction: Vec<f64> = residual.iter().map(|value| value.high()).collect();
            self.solve_once(&mut correction, work);
            let pairs = b.iter_mut().zip(&correction);
            pairs.for_each(|(x, missing)| *x += missing);
        }
    }

    /// y − (K − σM)x in place of y.
    fn subtract(&self, x: &[f64], y: &mut [DoubleDouble]) {
        self.pencil.stiffness.accumulate(-1.0, x, y);
        if self.shift != 0.0 {
            self.pencil.mass.accumulate(self.shift, x, y);
        }
    }

    /// Whether no solve subtracts: then it is good to about √n units of rounding in every entry.
    pub(crate) fn never_cancels(&self) -> bool {
        let Pencil {
            stiffness, mass, ..
        } = self.pencil;
        let plain_mass = self.shift == 0.0 || mass.is_non_negative();
        self.shift <= 0.0 && stiffness.is_non_negative() && plain_mass
    }

    /// y = A x; `work` is of the same length.
    pub(crate) fn apply(&self, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        self.pencil.mass.apply(x, y);
        self.solve(y, work);
    }

    /// What y = A x lacks: (K − σM)⁻¹ of the residual Mx − (K − σM)y, formed from the elements in
    /// double-double. Iterative refinement adds it to y.
    pub(crate) fn correction(&self, x: &[f64], y: &[f64], work: &mut [f64]) -> Vec<f64> {
        let mut residual = vec![DoubleDouble::ZERO; y.len()];
        self.pencil.mass.accumulate(1.0, x, &mut residual);
        self.subtract(y, &mut residual);
        let mut correction: Vec<f64> = residual.iter().map(|value| value.high()).collect();
        drop(residual);
        self.solve_once(&mut correction, work);
        correction
    }

    /// Makes x orthogonal to the motions that were taken out, to the digits of a double-double.
    pub(crate) fn project_long(&self, x: &mut [DoubleDouble]) {
        let Some(rigid) = &self.rigid else { return };
        for _ in 0..3 {
            let mut product = vec![DoubleDouble::ZERO; x.len()];
            self.pencil.mass.accumulate_long(1.0, x, &mut product);
            let mut along = vec![0.0; x.len()];
            rigid.remove_long(&product, &mut along);
            x.iter_mut()
                .zip(&along)
                .for_each(|(x, along)| *x += DoubleDouble::from(*along));
        }
    }

    /// A x to the digits of a double-double as far as corrections go, and the size of the last one in the
    /// norm of M.
    pub(crate) fn apply_long(&self, x: &[DoubleDouble]) -> (Vec<DoubleDouble>, f64) {
        const MOST: usize = 12;
        let n = x.len();
        let mut work = vec![0.0; n];
        let mut product = vec![DoubleDouble::ZERO; n];
        let mut last = f64::INFINITY;
        for _ in 0..MOST {
            let mut residual = vec![DoubleDouble::ZERO; n];
            self.pencil.mass.accumulate_long(1.0, x, &mut residual);
            self.pencil
                .stiffness
                .accumulate_long(-1.0, &product, &mut residual);
            if self.shift != 0.0 {
                self.pencil
                    .mass
                    .accumulate_long(self.shift, &product, &mut residual);
            }
            let mut correction: Vec<f64> = residual.iter().map(|value| value.high()).collect();
            self.solve_once(&mut correction, &mut work);
            self.pencil.mass.apply(&correction, &mut work);
            let size = dot(&correction, &work).max(0.0).sqrt();
            if size >= 0.5 * last || size.is_nan() {
                break;
            }
            last = size;
            for (y, missing) in product.iter_mut().zip(&correction) {
                *y += DoubleDouble::from(*missing);
            }
        }
        (product, last)
    }
}
