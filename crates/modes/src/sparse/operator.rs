//! A = (K − σM)⁻¹M, whose eigenvalues 1/(λ − σ) are largest for the λ nearest to σ (Ericsson & Ruhe
//! 1980, *Math. Comp.* 35, "The spectral transformation Lanczos method").

use eigentone_digits::DoubleDouble;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::factor::Factor;
use super::pencil::Pencil;

/// A with the motions at λ = 0 taken out that K lets go on without force.
#[derive(Debug)]
pub(crate) struct ShiftInvert<'a> {
    pub(crate) pencil: &'a Pencil,
    factor: Factor<'a>,
    pub(crate) shift: f64,
    rigid: Option<Rigid>,
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
        let unit = Mat::<f64>::identity(parts.len(), parts.len());
        let inverse = gram.llt(Side::Lower).ok()?.solve(&unit);
        let weights = Weights::Inverse(inverse);
        Some(Rigid { part, weights })
    }

    /// Makes x orthogonal to them, given M x.
    pub(crate) fn remove(&self, mass_times_x: &[f64], x: &mut [f64]) {
        let parts = match &self.weights {
            Weights::Diagonal(weights) => weights.len(),
            Weights::Inverse(inverse) => inverse.nrows(),
        };
        let mut sums = vec![0.0; parts];
        for (&part, value) in self.part.iter().zip(mass_times_x) {
            if part != HELD {
                sums[part as usize] += value;
            }
        }
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

impl<'a> ShiftInvert<'a> {
    pub(crate) fn new(factor: Factor<'a>, pencil: &'a Pencil, shift: f64) -> ShiftInvert<'a> {
        ShiftInvert {
            pencil,
            factor,
            shift,
            rigid: None,
        }
    }

    /// The same without these motions.
    pub(crate) fn without(self, rigid: Rigid) -> ShiftInvert<'a> {
        ShiftInvert {
            rigid: Some(rigid),
            ..self
        }
    }

    /// Makes x orthogonal to the motions that were taken out; `work` is of the same length.
    pub(crate) fn project(&self, x: &mut [f64], work: &mut [f64]) {
        if let Some(rigid) = &self.rigid {
            self.pencil.mass.apply(x, work);
            rigid.remove(work, x);
        }
    }

    /// (K − σM)⁻¹ b in place of b.
    pub(crate) fn solve(&self, b: &mut [f64], work: &mut [f64]) {
        self.factor.solve(b, work);
        self.project(b, work);
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
        let Pencil {
            stiffness, mass, ..
        } = self.pencil;
        let mut residual = vec![DoubleDouble::ZERO; y.len()];
        mass.accumulate(1.0, x, &mut residual);
        stiffness.accumulate(-1.0, y, &mut residual);
        if self.shift != 0.0 {
            mass.accumulate(self.shift, y, &mut residual);
        }
        let mut correction: Vec<f64> = residual.iter().map(|value| value.high()).collect();
        drop(residual);
        self.solve(&mut correction, work);
        correction
    }
}
