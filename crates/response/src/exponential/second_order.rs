//! The exponential of second-order systems, by their displacements alone.

use faer::{Mat, MatRef};

use super::contiguous::with_columns;
use super::error::{ExpmError, check, in_range};
use super::few_masses::FewMasses;
use super::method::Exponential;
use super::sparse_system::SparseSystem;
use super::taylor::Taylor;
use super::taylor::{first_shift, taylor};

/// The exponential of A = [0 G; −K −C] with a positive diagonal matrix G, where K and C are sparse or
/// have at most eight rows; other matrices are left to [`Taylor`].
///
/// For G = I every polynomial p in A with p(0) = 1 is [I − RK, Q; −QK, I − RK − QC]: only R and Q are
/// kept, what a unit force does to displacements, R as a step and Q as an impulse. Multiplying them
/// by A costs little, so that the plain Taylor series is summed at ‖2^-s A‖ ≤ 2.43, with the unit of time
/// in which displacements and velocities are alike. Damping may decay motions by a factor of e
/// before a squaring at most, else I − RK would cancel.
///
/// Where K and C are symmetric and one or two squarings suffice, R and Q are squared: one product of
/// half the order and two halves of one instead of eight, as they are symmetric. Else rounding errors
/// that do not commute with A would grow, and those of RK grow as ‖A‖² where those of A grow as
/// ‖A‖: then the whole matrix is squared as [`Taylor`] does.
#[derive(Clone, Copy, Debug)]
pub struct SecondOrder;

impl Exponential for SecondOrder {
    fn name(&self) -> &'static str {
        "second order"
    }

    fn counted(&self, a: MatRef<'_, f64>) -> Result<(Mat<f64>, f64), ExpmError> {
        check(a)?;
        match structured(a) {
            Some(found) => in_range(Some(found)),
            None => Taylor.counted(a),
        }
    }
}

/// e^A for a square matrix, and the products it took; numbers without a digit where those of A are too large.
pub(crate) fn second_order(a: MatRef<'_, f64>) -> (Mat<f64>, f64) {
    structured(a).unwrap_or_else(|| by_taylor(a))
}

/// The same for matrices that are not of this form.
pub(crate) fn by_taylor(a: MatRef<'_, f64>) -> (Mat<f64>, f64) {
    let (result, products, _) = taylor(a);
    (result, f64::from(products))
}

fn structured(a: MatRef<'_, f64>) -> Option<(Mat<f64>, f64)> {
    let n = a.nrows();
    if n % 2 == 1 {
        return None;
    }
    match n / 2 {
        1 => FewMasses::<1, 4>::of(a)?.exponential(a),
        2 => FewMasses::<2, 4>::of(a)?.exponential(a),
        3 => FewMasses::<3, 4>::of(a)?.exponential(a),
        4 => FewMasses::<4, 4>::of(a)?.exponential(a),
        5 => FewMasses::<5, 8>::of(a)?.exponential(a),
        6 => FewMasses::<6, 8>::of(a)?.exponential(a),
        7 => FewMasses::<7, 8>::of(a)?.exponential(a),
        8 => FewMasses::<8, 8>::of(a)?.exponential(a),
        _ if first_shift(a) > 0 => return None,
        _ => with_columns(a, SparseSystem::of)?.exponential(a),
    }
    .into()
}
