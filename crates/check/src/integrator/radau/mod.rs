//! Radau IIA of order 5 (Hairer & Wanner, *Solving Ordinary Differential Equations II*, §IV.5 and
//! §IV.8, whose symbols are kept): implicit, three stages, for stiff systems.

mod collocation;
mod passage;
mod resolvent;
mod tableau;

use super::adaptive::{self, Adaptive, Allowed, Passage, Scheme, Steps};
use super::course::Stretch;
use super::equation::EquationOfMotion;
use super::{Work, integrator};
use passage::Marching;
use resolvent::Resolvent;

/// Implicit Runge–Kutta of order 5 with steps sized by a tolerance: the one to take where some
/// motions die down much faster than those of interest.
///
/// It is stable for any step and extinguishes the fastest motions at once (L-stable), so that the
/// length of a step follows from the accuracy alone. A step factorises one real and one complex
/// matrix of n × n where its length changes, and solves with both. The estimate of the error is of
/// order 3, for which steps are shorter than order 5 would need and their ends more accurate than
/// the tolerance; instants between them are interpolated by the polynomial of collocation, to
/// about the tolerance. Undamped motion gets a damping ratio of (ω h)⁵/7200.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Radau5 {
    /// The error allowed in each step, relative to the largest displacement (or velocity) so far;
    /// 1e-15 to 1.
    pub tolerance: f64,
}

impl Radau5 {
    /// The method with a relative tolerance from 1e-15 to 1.
    pub fn with_tolerance(tolerance: f64) -> Radau5 {
        Radau5 { tolerance }
    }
}

impl Scheme for Radau5 {
    fn name(&self) -> &'static str {
        "Radau IIA 5"
    }

    fn tolerance(&self) -> f64 {
        self.tolerance
    }

    fn method<'e>(&self, equation: &'e EquationOfMotion) -> impl Adaptive + 'e {
        Radau {
            equation,
            real: Resolvent::of(equation),
            complex: Resolvent::of(equation),
            evaluations: 0,
        }
    }
}

integrator!(Radau5, adaptive);

/// The method for one equation.
struct Radau<'e> {
    equation: &'e EquationOfMotion,
    real: Resolvent<'e, f64>,
    complex: Resolvent<'e, faer::c64>,
    evaluations: u64,
}

impl Adaptive for Radau<'_> {
    fn order(&self) -> f64 {
        4.0
    }

    fn longest_stable_step(&self, _fastest: f64) -> f64 {
        f64::INFINITY
    }

    fn enter<R>(
        &mut self,
        stretch: &Stretch<'_>,
        state: &[f64],
        steps: Steps,
        _allowed: Allowed,
        march: impl FnOnce(&mut dyn Passage) -> R,
    ) -> Result<R, String> {
        Ok(march(&mut Marching::begin(self, stretch, state, steps)))
    }

    fn work(&self) -> Work {
        let (real, complex) = (self.real.work(), self.complex.work());
        Work {
            evaluations: self.evaluations,
            factorisations: real.factorisations + complex.factorisations,
            solves: real.solves + complex.solves,
            ..Work::default()
        }
    }
}
