//! The generalized-α method (Chung & Hulbert 1993, *J. Appl. Mech.* 60).

use super::alpha_family::{AlphaMethod, Weights};
use super::equation::EquationOfMotion;
use super::fixed_step::{self, FixedStep, Scheme};
use super::integrator;

/// The method of order 2 that damps low frequencies least among those that damp the highest ones
/// by a given factor.
///
/// It is stable for any step. A motion of ω h → ∞ shrinks by the spectral radius ρ∞ in each step;
/// the error is in proportion to h². With s = (1 − ρ∞)/(1 + ρ∞), low frequencies get a damping ratio
/// of s³ (ω h)³/2, and periods come out long, by a relative (1/12 + 3s²/8) (ω h)².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeneralizedAlpha {
    /// Equal steps between two neighbouring instants of the grid; at least 1.
    pub substeps: u32,
    /// ρ∞, from 0, which extinguishes the highest frequencies in one step, to 1, which does not
    /// damp.
    pub spectral_radius: f64,
}

impl GeneralizedAlpha {
    /// The method with ρ∞ = 0.8.
    pub fn with_substeps(substeps: u32) -> GeneralizedAlpha {
        GeneralizedAlpha {
            substeps,
            spectral_radius: 0.8,
        }
    }
}

impl Scheme for GeneralizedAlpha {
    fn name(&self) -> &'static str {
        "generalized-α"
    }

    fn substeps(&self) -> u32 {
        self.substeps
    }

    fn misfit(&self) -> Option<String> {
        let radius = self.spectral_radius;
        (!(0.0..=1.0).contains(&radius))
            .then(|| format!("its spectral radius is {radius}: it must lie between 0 and 1"))
    }

    fn method<'e>(&self, equation: &'e EquationOfMotion) -> impl FixedStep + 'e {
        let radius = self.spectral_radius;
        let alpha_m = (2.0 * radius - 1.0) / (radius + 1.0);
        let alpha_f = radius / (radius + 1.0);
        AlphaMethod::of(equation, Weights::optimal(alpha_m, alpha_f))
    }
}

integrator!(GeneralizedAlpha, fixed_step);
