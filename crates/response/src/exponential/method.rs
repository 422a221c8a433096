//! What all ways to compute an exponential have in common.

use faer::{Mat, MatRef};

use super::error::ExpmError;

/// A way to compute e^A in doubles, as a value, so that methods can be looped over.
///
/// Each errs by some units of 2^-53 times the condition of matrices that are not far from normal, relative to the norm of
/// e^A; none bounds that. [`expm`](super::expm) is for those who need a certain answer.
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
