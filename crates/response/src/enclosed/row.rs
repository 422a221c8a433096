//! Rows of matrices known entry by entry.

use eigentone_digits::{BallMatrix, Magnitude, Real};

/// Adds a multiple of the only row of one matrix to a row of another.
pub(crate) fn add_multiple<T: Real>(
    to: &mut BallMatrix<T>,
    row: usize,
    factor: f64,
    course: &BallMatrix<T>,
) {
    for j in (0..course.columns()).filter(|j| !course.is_zero(0, *j)) {
        let product = course.middle(0, j) * T::from(factor);
        let rounding = match factor.abs() == 1.0 {
            true => Magnitude::ZERO,
            false => product.upper() * T::unit() + T::floor(),
        };
        let error = course.radius(0, j) * Magnitude::from(factor.abs()) + rounding;
        to.add(row, j, product, error);
    }
}
