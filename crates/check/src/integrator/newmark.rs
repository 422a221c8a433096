//! The methods of Newmark (1959, *J. Eng. Mech. Div. ASCE* 85), with any β and γ.

use super::alpha_family::{AlphaMethod, Weights};
use super::equation::EquationOfMotion;
use super::fixed_step::{self, FixedStep, Scheme};
use super::integrator;

/// Newmark's method: what structural engineers use.
///
/// The new acceleration takes part in the new displacement by β h² and in the new velocity by γ h.
/// Each step solves a linear system of n equations, factorised once for each length of step. With
/// γ = ½ the error is in proportion to h² and nothing is damped numerically; γ > ½ damps, at the
/// price of an error in proportion to h; γ < ½ makes every motion grow. It is stable for any step
/// where 2β ≥ γ ≥ ½, else for ω h up to 1/√(γ/2 − β) without damping (Hughes, *The Finite Element
/// Method*, §9.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Newmark {
    /// Equal steps between two neighbouring instants of the grid; at least 1.
    pub substeps: u32,
    /// The weight γ of the new acceleration in the new velocity; 0 to 1.
    pub gamma: f64,
    /// The weight β of the new acceleration in the new displacement; 0 to 1.
    pub beta: f64,
}

impl Newmark {
    /// The average-acceleration method, γ = ½ and β = ¼, also known as the trapezoidal rule: stable
    /// for any step, and the energy of undamped free motion is kept. Periods come out long, by a
    /// relative (ω h)²/12.
    pub fn with_substeps(substeps: u32) -> Newmark {
        Newmark {
            substeps,
            gamma: 0.5,
            beta: 0.25,
        }
    }

    /// The linear-acceleration method, γ = ½ and β = ⅙: stable for ω h up to 2√3. Periods come out
    /// long, by a relative (ω h)²/24.
    pub fn linear_acceleration(substeps: u32) -> Newmark {
        Newmark {
            beta: 1.0 / 6.0,
            ..Newmark::with_substeps(substeps)
        }
    }

    /// The central-difference method, γ = ½ and β = 0, also known as that of Störmer, Verlet and
    /// leapfrog: explicit but for the dampers, stable for ω h up to 2. Periods come out short, by
    /// a relative (ω h)²/24.
    pub fn central_difference(substeps: u32) -> Newmark {
        Newmark {
            beta: 0.0,
            ..Newmark::with_substeps(substeps)
        }
    }
}

impl Scheme for Newmark {
    fn name(&self) -> &'static str {
        match (self.gamma, self.beta) {
            (0.5, 0.0) => "central difference",
            _ => "Newmark",
        }
    }

    fn substeps(&self) -> u32 {
        self.substeps
    }

    fn misfit(&self) -> Option<String> {
        let weights = [("γ", self.gamma), ("β", self.beta)];
        let mut out_of_range = weights.iter().filter(|(_, x)| !(0.0..=1.0).contains(x));
        let (name, value) = out_of_range.next()?;
        Some(format!(
            "its {name} is {value}: it must lie between 0 and 1"
        ))
    }

    fn method<'e>(&self, equation: &'e EquationOfMotion) -> impl FixedStep + 'e {
        let weights = Weights {
            alpha_m: 0.0,
            alpha_f: 0.0,
            gamma: self.gamma,
            beta: self.beta,
        };
        AlphaMethod::of(equation, weights)
    }
}

integrator!(Newmark, fixed_step);
