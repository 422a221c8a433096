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
mod paths;
mod polynomial;
mod precise;
mod scales;
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
pub use expm::{BoundedExponential, ExpmError, expm, expm_bounded};
pub use pade::Pade13;
pub use second_order::SecondOrder;
pub(crate) use second_order::{by_taylor, second_order};
pub use taylor::Taylor;

/// A way to compute e^A in doubles, as a value, so that methods can be looped over.
///
/// Each errs by some units of 2^-53 times the condition of matrices that are not far from normal, relative to the norm of
/// e^A; none bounds that. [`expm`] is for those who need a certain answer.
pub trait Exponential: Sync {
    /// A short name for tables and plots.
    fn name(&self) -> &'static str;

    /// e^A, and how many products of matrices of the order of A that took, a solution with as many
    /// right-hand sides counting as one.
    ///
    /// # Errors
    /// [`ExpmError`] for a matrix that is not square or has an entry that is not finite, for one so large that its squarings
    /// leave no digit, and for an exponential with entries beyond the largest double.
    fn counted(&self, a: MatRef<'_, f64>) -> Result<(Mat<f64>, f64), ExpmError>;

    /// e^A.
    ///
    /// # Errors
    /// Those of [`counted`](Self::counted).
    fn exponential(&self, a: MatRef<'_, f64>) -> Result<Mat<f64>, ExpmError> {
        Ok(self.counted(a)?.0)
    }
}

/// What was found, if doubles hold it.
fn in_range(found: Option<(Mat<f64>, f64)>) -> Result<(Mat<f64>, f64), ExpmError> {
    found
        .filter(|(matrix, _)| matrix.as_ref().is_all_finite())
        .ok_or(ExpmError::BeyondDoubles)
}
