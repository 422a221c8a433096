//! The average-acceleration method of Newmark (1959, *J. Eng. Mech. Div. ASCE* 85), β = ¼, γ = ½.

use eigentone_response::{Problem, ResponseError, ResponseMethod, Trajectory};
use faer::Mat;

use super::equation::{EquationOfMotion, Forces};
use super::fixed_step::{self, FixedStep};
use super::{Integrator, Knob, Limit, Work};

const NAME: &str = "Newmark";

/// What structural engineers use: stable for any step, no numerical damping, error in proportion
/// to h². Each step solves a linear system, factorised once for each length of step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Newmark {
    /// Equal steps between two neighbouring instants of the grid; at least 1.
    pub substeps: u32,
}

impl Newmark {
    /// The method with at least 1 step between neighbouring instants.
    pub fn with_substeps(substeps: u32) -> Newmark {
        Newmark { substeps }
    }
}

impl ResponseMethod for Newmark {
    fn name(&self) -> &'static str {
        NAME
    }

    fn refuses(&self, problem: &Problem<'_>) -> Option<String> {
        fixed_step::refuses_substeps(self.substeps)
            .or_else(|| EquationOfMotion::of(problem.system()).err())
    }

    fn run(&self, problem: &Problem<'_>) -> Result<Trajectory, ResponseError> {
        Ok(self.integrate(problem, Limit::default())?.0)
    }
}

impl Integrator for Newmark {
    fn knob(&self) -> Knob {
        Knob::Substeps(self.substeps)
    }

    fn integrate(
        &self,
        problem: &Problem<'_>,
        limit: Limit,
    ) -> Result<(Trajectory, Work), ResponseError> {
        let equation = fixed_step::equation(NAME, problem, self.substeps)?;
        let method = AverageAcceleration::of;
        fixed_step::run(NAME, problem, &equation, method, self.substeps, limit)
    }
}

struct AverageAcceleration<'a> {
    equation: &'a EquationOfMotion,
    acceleration: Vec<f64>,
    /// What the equation of motion leaves over at the predicted state.
    rest: Vec<f64>,
    /// A length of step, and (I + h/2 M⁻¹C + h²/4 M⁻¹K)⁻¹ for it.
    solver: Option<(f64, Mat<f64>)>,
}

impl AverageAcceleration<'_> {
    fn of(equation: &EquationOfMotion) -> AverageAcceleration<'_> {
        let zeros = vec![0.0; equation.len()];
        AverageAcceleration {
            equation,
            acceleration: zeros.clone(),
            rest: zeros,
            solver: None,
        }
    }

    /// Moves [x; x′] by what the acceleration does over one half of a step's weight.
    fn advance(&self, state: &mut [f64], h: f64) {
        let n = self.equation.len();
        for (i, acceleration) in self.acceleration.iter().enumerate() {
            state[i] += 0.25 * h * h * acceleration;
            state[n + i] += 0.5 * h * acceleration;
        }
    }
}

impl FixedStep for AverageAcceleration<'_> {
    const EVALUATIONS: (u64, u64) = (1, 1);

    fn restart(&mut self, state: &[f64], forces: &Forces<'_>, elapsed: f64) {
        self.equation
            .acceleration(state, forces, elapsed, &mut self.acceleration);
    }

    fn step(
        &mut self,
        state: &mut [f64],
        forces: &Forces<'_>,
        elapsed: f64,
        h: f64,
    ) -> Result<(), String> {
        let n = self.equation.len();
        let solver = match self.solver.take().filter(|(length, _)| *length == h) {
            Some((_, solver)) => solver,
            None => {
                let solver = self.equation.implicit_inverse(0.5 * h, 0.25 * h * h);
                if !solver.is_all_finite() {
                    return Err(format!("its equations for a step of {h} s are singular"));
                }
                solver
            }
        };
        for i in 0..n {
            state[i] += h * state[n + i];
        }
        self.advance(state, h);
        self.equation
            .acceleration(state, forces, elapsed + h, &mut self.rest);
        self.acceleration.fill(0.0);
        for (j, rest) in self.rest.iter().enumerate() {
            for (i, acceleration) in self.acceleration.iter_mut().enumerate() {
                *acceleration += solver[(i, j)] * rest;
            }
        }
        self.advance(state, h);
        self.solver = Some((h, solver));
        Ok(())
    }
}
