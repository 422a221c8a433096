//! Scaling and squaring with Taylor polynomials: products only.

use eigentone_digits::{Real, product};
use faer::{Mat, MatRef};

use super::algebra::{Algebra, Explicit};
use super::aligned::Aligned;
use super::dense::Dense;
use super::error::{ExpmError, check, in_range};
use super::growth::Growth;
use super::method::Exponential;
use super::norm::{column_sums, largest};
use super::paths::Paths;
use super::polynomial::evaluate;
use super::scaling::scale;
use super::squaring::{Extended, LARGE, MEANINGFUL, square};

/// The exponential by the Taylor polynomials of Sastre, Ibáñez & Defez 2019 (*Boosting the
/// computation of the matrix exponential*, Appl. Math. Comput. 340): up to five products and a
/// squaring for each factor of two above ‖A‖ = 1.68, and no system of equations to solve, which is
/// expensive next to products.
///
/// The scaling follows Al-Mohy & Higham 2009 (SIAM J. Matrix Anal. 31): it is taken from the norms
/// of powers of A, so that a large norm of a nearly nilpotent matrix costs no squarings, and kept
/// where rounding errors of a nonnormal matrix want it. The squarings carry e^A − I, which keeps
/// the digits of motions that are slow beside the fastest.
///
/// It does not balance A: [`expm`](super::expm) does.
#[derive(Clone, Copy, Debug)]
pub struct Taylor;

impl Exponential for Taylor {
    fn name(&self) -> &'static str {
        "Taylor"
    }

    fn counted(&self, a: MatRef<'_, f64>) -> Result<(Mat<f64>, f64), ExpmError> {
        check(a)?;
        let (result, products, squarings) = taylor(a);
        in_range((squarings <= MEANINGFUL).then(|| (result, f64::from(products))))
    }
}

/// e^A, and the products and squarings it took, the squarings being products too.
///
/// Entries beyond the range of doubles come out as ∞ or 0, and NaN is what they lose beside others that grow; matrices of norm above 10^16, whose
/// exponential no digits are left of, at least do not grow beyond e^μ, μ the largest eigenvalue of (A + Aᵀ)/2.
pub(super) fn taylor(a: MatRef<'_, f64>) -> (Mat<f64>, u32, u32) {
    let n = a.nrows();
    let mut algebra = Dense::new(n);
    let shift = first_shift(a);
    let start = algebra.load(a, shift);
    let scaled = scale(&mut algebra, n, start);
    let squarings = scaled.squarings + shift.unsigned_abs();
    let less_one = evaluate(&mut algebra, scaled.degree, scaled.powers);
    let result = square(&mut algebra, less_one, squarings, || Growth::of(a));
    let matrix = store(a, &result, squarings);
    algebra.recycle(result.element);
    (matrix, algebra.products(), squarings)
}

/// e^A once more, as the square of e^{A/2 + δI}/e^δ, rows and columns in the opposite order: the roundings of
/// [`taylor`] do not come again, not even where sums have one term.
pub(super) fn otherwise(a: MatRef<'_, f64>) -> Mat<f64> {
    const DELTA: f64 = 0.137;
    let last = a.nrows().saturating_sub(1);
    let moved = Mat::from_fn(a.nrows(), a.ncols(), |i, j| {
        0.5 * a[(last - i, last - j)] + if i == j { DELTA } else { 0.0 }
    });
    let (root, _, _) = taylor(moved.as_ref());
    let square = product(root.as_ref(), root.as_ref()) * faer::Scale((-2.0 * DELTA).exp());
    square.as_ref().reverse_rows_and_cols().to_owned()
}

/// How often A is halved before its powers are formed: only so often that they do not overflow.
pub(super) fn first_shift(a: MatRef<'_, f64>) -> i32 {
    const ROOM: f64 = 150.0;
    let size = a.norm_max();
    let fits = size * (a.nrows() as f64) < 2f64.powi(ROOM as i32);
    if size.is_finite() && !fits {
        (size.log2() + (a.nrows() as f64).log2() - ROOM)
            .ceil()
            .max(0.0) as i32
    } else {
        0
    }
}

/// The exponential of A in the range of doubles, after so many squarings. Beside entries that grow, NaN is what may have
/// lost digits to the end of that range on the way.
pub(super) fn store(a: MatRef<'_, f64>, result: &Extended<Aligned>, squarings: u32) -> Mat<f64> {
    let n = a.nrows();
    let mut matrix = Mat::zeros(n, n);
    let columns = Dense::value(&result.element).chunks_exact(n.max(1));
    for (j, column) in columns.enumerate() {
        let target = matrix.col_as_slice_mut(j);
        target.copy_from_slice(column);
        if result.exponent != 0 {
            let scaled = target.iter_mut();
            scaled.for_each(|entry| *entry = entry.scale(result.exponent));
        }
    }
    let values = Dense::value(&result.element);
    let least = lost(n, values, result.exponent, squarings);
    if values.iter().any(|value| value.abs() < least) {
        let paths = Paths::of(a);
        for (at, value) in values.iter().enumerate() {
            let (i, j) = (at % n, at / n);
            if value.abs() < least && paths.lead(i, j) {
                matrix[(i, j)] = f64::NAN;
            }
        }
    }
    matrix
}

/// Entries below this may have lost a digit: before any squaring the smallest double was lost of each, which then grew as the
/// matrix did, n times and twice for each squaring. 0 where that is nothing, as nothing grows.
fn lost(n: usize, values: &[f64], exponent: i64, squarings: u32) -> f64 {
    const LEAST: i32 = -1074;
    const DIGITS: i32 = 53;
    let norm = largest(&column_sums(n, values));
    let grown = norm.log2() + exponent as f64;
    if norm.is_finite() && grown > LARGE.log2() {
        norm * n as f64 * 2f64.powi(LEAST + DIGITS + squarings as i32)
    } else {
        0.0
    }
}
