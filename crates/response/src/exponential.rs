//! The matrix exponential.

mod pade;

use faer::{Mat, MatRef};

pub use pade::Pade13;

/// A way to compute e^A, as a value, so that methods can be looped over.
pub trait Exponential: Sync {
    /// A short name for tables and plots.
    fn name(&self) -> &'static str;

    /// e^A for a square matrix of finite entries.
    fn exponential(&self, a: MatRef<'_, f64>) -> Mat<f64>;
}
