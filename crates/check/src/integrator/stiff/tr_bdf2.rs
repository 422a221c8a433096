//! TR-BDF2: the trapezoidal rule followed by backward differences of order 2 (Bank et al. 1985,
//! *IEEE Trans. Electron Devices* 32; Hosea & Shampine 1996, *Appl. Numer. Math.* 20), by the crate
//! `diffsol`.

use super::super::adaptive::{self, Adaptive, Scheme};
use super::super::equation::EquationOfMotion;
use super::super::integrator;
use super::diffsol::{Diffsol, Formula};

/// Diagonally implicit Runge–Kutta of order 2 with steps sized by a tolerance: stable for any step,
/// and the fastest motions are extinguished (L-stable).
///
/// For low accuracy: a thousandth of the tolerance takes ten times the steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrBdf2 {
    /// The error allowed in each step, relative to the largest displacement (or velocity) so far;
    /// 1e-15 to 1.
    pub tolerance: f64,
}

impl TrBdf2 {
    /// The method with a relative tolerance from 1e-15 to 1.
    pub fn with_tolerance(tolerance: f64) -> TrBdf2 {
        TrBdf2 { tolerance }
    }
}

impl Scheme for TrBdf2 {
    fn name(&self) -> &'static str {
        "TR-BDF2"
    }

    fn tolerance(&self) -> f64 {
        self.tolerance
    }

    fn method<'e>(&self, equation: &'e EquationOfMotion) -> impl Adaptive + 'e {
        Diffsol::of(Formula::TrBdf2, equation)
    }
}

integrator!(TrBdf2, adaptive);
