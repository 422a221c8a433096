//! The matrix exponential.

mod algebra;
mod aligned;
mod condition;
mod contiguous;
mod dense;
mod dual;
mod energy_condition;
mod expm;
mod few_masses;
mod growth;
mod norm;
mod pade;
mod polynomial;
mod scaling;
mod second_order;
mod series;
mod sparse;
mod sparse_system;
mod squaring;
mod taylor;

use faer::{Mat, MatRef};

pub use condition::expm_condition;
pub use energy_condition::energy_condition;
pub use expm::{ExpmError, expm};
pub use pade::Pade13;
pub use second_order::SecondOrder;
pub use taylor::Taylor;

/// A way to compute e^A, as a value, so that methods can be looped over.
pub trait Exponential: Sync {
    /// A short name for tables and plots.
    fn name(&self) -> &'static str;

    /// e^A for a square matrix of finite entries, and how many products of matrices of the order of
    /// A that took, a solution with as many right-hand sides counting as one.
    fn counted(&self, a: MatRef<'_, f64>) -> (Mat<f64>, f64);

    /// e^A for a square matrix of finite entries.
    fn exponential(&self, a: MatRef<'_, f64>) -> Mat<f64> {
        self.counted(a).0
    }
}
