//! The classical Runge–Kutta method of order 4 (Kutta 1901, *Z. Math. Phys.* 46).

use super::Work;
use super::equation::{EquationOfMotion, Forces};
use super::fixed_step::{self, FixedStep, Scheme};
use super::integrator;

/// Four evaluations a step, error in proportion to h⁴.
///
/// It is stable for |λ|h up to 2.83 (imaginary λ) and 2.78 (real λ). Undamped motion gets a damping
/// ratio of (ω h)⁵/144, and its periods come out long, by a relative (ω h)⁴/120.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RungeKutta4 {
    /// Equal steps between two neighbouring instants of the grid; at least 1.
    pub substeps: u32,
}

impl RungeKutta4 {
    /// The method with at least 1 step between neighbouring instants.
    pub fn with_substeps(substeps: u32) -> RungeKutta4 {
        RungeKutta4 { substeps }
    }
}

impl Scheme for RungeKutta4 {
    fn name(&self) -> &'static str {
        "Runge–Kutta 4"
    }

    fn substeps(&self) -> u32 {
        self.substeps
    }

    fn method<'e>(&self, equation: &'e EquationOfMotion) -> impl FixedStep + 'e {
        Stages::of(equation)
    }
}

integrator!(RungeKutta4, fixed_step);

struct Stages<'a> {
    equation: &'a EquationOfMotion,
    /// The state that a stage looks at.
    stage: Vec<f64>,
    slope: Vec<f64>,
    sum: Vec<f64>,
    evaluations: u64,
}

impl Stages<'_> {
    fn of(equation: &EquationOfMotion) -> Stages<'_> {
        let zeros = vec![0.0; 2 * equation.len()];
        Stages {
            equation,
            stage: zeros.clone(),
            slope: zeros.clone(),
            sum: zeros,
            evaluations: 0,
        }
    }
}

impl FixedStep for Stages<'_> {
    fn step(
        &mut self,
        state: &mut [f64],
        forces: &Forces<'_>,
        elapsed: f64,
        h: f64,
    ) -> Result<(), String> {
        let n = self.equation.len();
        self.slope.fill(0.0);
        self.sum.fill(0.0);
        for (ahead, weight) in [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
            let at = state.iter().zip(&self.slope);
            for (stage, (value, slope)) in self.stage.iter_mut().zip(at) {
                *stage = value + ahead * h * slope;
            }
            let (velocity, acceleration) = self.slope.split_at_mut(n);
            velocity.copy_from_slice(&self.stage[n..]);
            let at = elapsed + ahead * h;
            self.equation
                .acceleration(&self.stage, forces, at, acceleration);
            for (sum, slope) in self.sum.iter_mut().zip(&self.slope) {
                *sum += weight * slope;
            }
        }
        for (value, sum) in state.iter_mut().zip(&self.sum) {
            *value += h / 6.0 * sum;
        }
        self.evaluations += 4;
        Ok(())
    }

    fn work(&self) -> Work {
        Work {
            evaluations: self.evaluations,
            ..Work::default()
        }
    }
}
