//! No damping at all.

use super::coefficients::Coefficients;

/// Whether C = 0, entries that sum exactly to 0 included.
pub(crate) fn is_undamped(coefficients: &Coefficients) -> bool {
    coefficients.damping.matrix.is_zero()
}
