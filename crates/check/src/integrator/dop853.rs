//! DOP853: an explicit Runge–Kutta pair of order 8(5,3) (Hairer, Nørsett & Wanner, *Solving
//! Ordinary Differential Equations I*, §II.5), by the crate `differential-equations`.

use super::adaptive::{self, Adaptive, Scheme};
use super::embedded::{Embedded, Pair};
use super::equation::EquationOfMotion;
use super::integrator;

/// Runge–Kutta of order 8 with steps sized by a tolerance: the one to take among explicit methods
/// where many digits are wanted.
///
/// Its error is about the tolerance times the number of oscillations. Instants between its steps
/// are interpolated by the equation's own derivatives, to an error below that of the steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dop853 {
    /// The error allowed in each step, relative to the largest displacement (or velocity) so far;
    /// 1e-15 to 1.
    pub tolerance: f64,
}

impl Dop853 {
    /// The method with a relative tolerance from 1e-15 to 1.
    pub fn with_tolerance(tolerance: f64) -> Dop853 {
        Dop853 { tolerance }
    }
}

impl Scheme for Dop853 {
    fn name(&self) -> &'static str {
        "DOP853"
    }

    fn tolerance(&self) -> f64 {
        self.tolerance
    }

    fn method<'e>(&self, equation: &'e EquationOfMotion) -> impl Adaptive + 'e {
        /// It is stable for |λ|h up to 5.9 (imaginary λ) and 6.4 (real λ).
        const STABLE: f64 = 6.0;
        Embedded::of(Pair::dop853, STABLE, equation)
    }
}

integrator!(Dop853, adaptive);
