//! Backward differentiation formulas of order 1 to 5 with varying step (Shampine & Reichelt 1997,
//! *SIAM J. Sci. Comput.* 18), by the crate `diffsol`.

use super::super::adaptive::{self, Adaptive, Scheme};
use super::super::equation::EquationOfMotion;
use super::super::integrator;
use super::diffsol::{Diffsol, Formula};

/// Backward differences, with orders and steps chosen by a tolerance: what stiff solvers use most,
/// one system of equations a step.
///
/// It is stable for any step up to order 2. Beyond, a motion of little damping can grow (order 5:
/// where the angle of λ to the negative real axis exceeds 52°), and lightly damped systems keep
/// it at low orders and short steps. At every break it starts anew at order 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bdf {
    /// The error allowed in each step, relative to the largest displacement (or velocity) so far;
    /// 1e-15 to 1.
    pub tolerance: f64,
}

impl Bdf {
    /// The method with a relative tolerance from 1e-15 to 1.
    pub fn with_tolerance(tolerance: f64) -> Bdf {
        Bdf { tolerance }
    }
}

impl Scheme for Bdf {
    fn name(&self) -> &'static str {
        "BDF"
    }

    fn tolerance(&self) -> f64 {
        self.tolerance
    }

    fn method<'e>(&self, equation: &'e EquationOfMotion) -> impl Adaptive + 'e {
        Diffsol::of(Formula::Bdf, equation)
    }
}

integrator!(Bdf, adaptive);
