//! The explicit Runge–Kutta pair of order 5(4) of Dormand & Prince (1980, *J. Comput. Appl. Math.*
//! 6), known as ode45 and DOPRI5, by the crate `differential-equations`.

use super::adaptive::{self, Adaptive, Scheme};
use super::embedded::{Embedded, Pair};
use super::equation::EquationOfMotion;
use super::integrator;

/// Runge–Kutta of order 5 with steps sized by a tolerance: what most simulation tools use by
/// default.
///
/// Its error is about the tolerance times the number of oscillations. Instants between its steps
/// are interpolated by the equation's own derivatives, to an error below that of the steps. Undamped
/// motion gets a damping ratio of (ω h)⁵/3600.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DormandPrince5 {
    /// The error allowed in each step, relative to the largest displacement (or velocity) so far;
    /// 1e-15 to 1.
    pub tolerance: f64,
}

impl DormandPrince5 {
    /// The method with a relative tolerance from 1e-15 to 1.
    pub fn with_tolerance(tolerance: f64) -> DormandPrince5 {
        DormandPrince5 { tolerance }
    }
}

impl Scheme for DormandPrince5 {
    fn name(&self) -> &'static str {
        "Dormand–Prince 5"
    }

    fn tolerance(&self) -> f64 {
        self.tolerance
    }

    fn method<'e>(&self, equation: &'e EquationOfMotion) -> impl Adaptive + 'e {
        /// It is stable for |λ|h up to 3.3 (real λ), a little less near the imaginary axis.
        const STABLE: f64 = 3.0;
        Embedded::of(Pair::dopri5, STABLE, equation)
    }
}

integrator!(DormandPrince5, adaptive);
