//! ESDIRK34: a diagonally implicit Runge–Kutta method of order 3 with an explicit first stage
//! (Jørgensen, Kristensen & Thomsen 2018, *A Family of ESDIRK Integration Methods*), by the crate
//! `diffsol`.

use super::super::adaptive::{self, Adaptive, Scheme};
use super::super::equation::EquationOfMotion;
use super::super::integrator;
use super::diffsol::{Diffsol, Formula};

/// Diagonally implicit Runge–Kutta of order 3 with steps sized by a tolerance: stable for any step,
/// and the fastest motions are extinguished (L-stable).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Esdirk34 {
    /// The error allowed in each step, relative to the largest displacement (or velocity) so far;
    /// 1e-15 to 1.
    pub tolerance: f64,
}

impl Esdirk34 {
    /// The method with a relative tolerance from 1e-15 to 1.
    pub fn with_tolerance(tolerance: f64) -> Esdirk34 {
        Esdirk34 { tolerance }
    }
}

impl Scheme for Esdirk34 {
    fn name(&self) -> &'static str {
        "ESDIRK34"
    }

    fn tolerance(&self) -> f64 {
        self.tolerance
    }

    fn method<'e>(&self, equation: &'e EquationOfMotion) -> impl Adaptive + 'e {
        Diffsol::of(Formula::Esdirk34, equation)
    }
}

integrator!(Esdirk34, adaptive);
