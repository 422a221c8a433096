//! DOP853: an explicit Runge–Kutta pair of order 8(5,3) (Hairer, Nørsett & Wanner, *Solving
//! Ordinary Differential Equations I*, §II.5), by the crate `differential-equations`.

use eigentone_response::{Problem, ResponseError, ResponseMethod, Trajectory};

use super::embedded::{self, Integration, Pair};
use super::equation::EquationOfMotion;
use super::{Integrator, Knob, Limit, Work};

const NAME: &str = "DOP853";

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

impl ResponseMethod for Dop853 {
    fn name(&self) -> &'static str {
        NAME
    }

    fn refuses(&self, problem: &Problem<'_>) -> Option<String> {
        embedded::refuses_tolerance(self.tolerance)
            .or_else(|| EquationOfMotion::of(problem.system()).err())
    }

    fn run(&self, problem: &Problem<'_>) -> Result<Trajectory, ResponseError> {
        Ok(self.integrate(problem, Limit::default())?.0)
    }
}

impl Integrator for Dop853 {
    fn knob(&self) -> Knob {
        Knob::Tolerance(self.tolerance)
    }

    fn integrate(
        &self,
        problem: &Problem<'_>,
        limit: Limit,
    ) -> Result<(Trajectory, Work), ResponseError> {
        /// It is stable for |λ|h up to 5.9 (imaginary λ) and 6.4 (real λ).
        const STABLE: f64 = 6.0;
        Integration::run(NAME, Pair::dop853, STABLE, self.tolerance, problem, limit)
    }
}
