//! The HHT-α method (Hilber, Hughes & Taylor 1977, *Earthq. Eng. Struct. Dyn.* 5).

use super::alpha_family::{AlphaMethod, Weights};
use super::equation::EquationOfMotion;
use super::fixed_step::{self, FixedStep, Scheme};
use super::integrator;

/// Newmark's method with springs, dampers and loads taken at t + (1 + α) h, so that high
/// frequencies are damped and the error remains in proportion to h².
///
/// It is stable for any step. A motion of ω h → ∞ shrinks by the spectral radius
/// ρ∞ = (1 + α)/(1 − α) in each step; α = 0 is the average-acceleration method. Low frequencies get
/// a damping ratio of |α| (1 − |α|)² (ω h)³/8, and periods come out long, by a relative
/// (1/12 + |α| (2 − 3|α|)/8) (ω h)².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HhtAlpha {
    /// Equal steps between two neighbouring instants of the grid; at least 1.
    pub substeps: u32,
    /// Its parameter α, from −⅓, which damps most, to 0, which does not damp.
    pub alpha: f64,
}

impl HhtAlpha {
    /// The method with ρ∞ = 0.8, which is α = −1/9.
    pub fn with_substeps(substeps: u32) -> HhtAlpha {
        HhtAlpha::with_spectral_radius(substeps, 0.8)
    }

    /// The method that makes the highest frequencies shrink by ρ∞, from ½ to 1, in each step.
    pub fn with_spectral_radius(substeps: u32, radius: f64) -> HhtAlpha {
        HhtAlpha {
            substeps,
            alpha: (radius - 1.0) / (radius + 1.0),
        }
    }

    /// ρ∞ = (1 + α)/(1 − α).
    pub fn spectral_radius(&self) -> f64 {
        (1.0 + self.alpha) / (1.0 - self.alpha)
    }
}

impl Scheme for HhtAlpha {
    fn name(&self) -> &'static str {
        "HHT-α"
    }

    fn substeps(&self) -> u32 {
        self.substeps
    }

    fn misfit(&self) -> Option<String> {
        let alpha = self.alpha;
        (!(-1.0 / 3.0..=0.0).contains(&alpha))
            .then(|| format!("its α is {alpha}: it must lie between -1/3 and 0"))
    }

    fn method<'e>(&self, equation: &'e EquationOfMotion) -> impl FixedStep + 'e {
        AlphaMethod::of(equation, Weights::optimal(0.0, -self.alpha))
    }
}

integrator!(HhtAlpha, fixed_step);
