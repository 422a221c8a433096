//! Scaling and squaring with the diagonal Padé approximant of degree 13.

use eigentone_digits::{Lu, product};
use faer::{Mat, MatRef};

use super::error::{ExpmError, check, in_range};
use super::method::Exponential;
use super::norm::norm;
use super::squaring::MEANINGFUL;

/// Al-Mohy & Higham 2009, *A new scaling and squaring algorithm for the matrix exponential*
/// (SIAM J. Matrix Anal. 31), with degree 13 throughout: the scaling is taken from ‖A⁴‖^{1/4} and
/// ‖A⁶‖^{1/6}, so that a large norm of a nearly nilpotent matrix costs no squarings. It does not
/// balance A: a caller does that where it helps.
#[derive(Clone, Copy, Debug)]
pub struct Pade13;

/// θ₁₃ of the paper's table 3.1.
const THETA: f64 = 4.25;

/// Of more halvings the powers that undo them leave the range of doubles.
const LARGEST: f64 = 150.0;

/// The numerator's coefficients, divided by the first: b_k / b_0.
const COEFFICIENTS: [f64; 14] = [
    64764752532480000.0,
    32382376266240000.0,
    7771770303897600.0,
    1187353796428800.0,
    129060195264000.0,
    10559470521600.0,
    670442572800.0,
    33522128640.0,
    1323241920.0,
    40840800.0,
    960960.0,
    16380.0,
    182.0,
    1.0,
];

impl Exponential for Pade13 {
    fn name(&self) -> &'static str {
        "Padé 13"
    }

    fn counted(&self, a: MatRef<'_, f64>) -> Result<(Mat<f64>, f64), ExpmError> {
        check(a)?;
        in_range(pade(a))
    }
}

/// e^A, and the products it took; `None` after so many squarings that no digit is left.
pub(super) fn pade(a: MatRef<'_, f64>) -> Option<(Mat<f64>, f64)> {
    /// Three powers, three products of the approximant, and its quotient.
    const APPROXIMANT: i32 = 7;
    let n = a.nrows();
    let size = norm(a);
    if size == 0.0 || n == 0 {
        return Some((Mat::identity(n, n), 0.0));
    }
    // A first scaling by the plain norm keeps the powers within range.
    let first = (size / THETA).log2().ceil().max(0.0);
    if first > LARGEST {
        return None;
    }
    let first = first as i32;
    let scaled = a * faer::Scale(2f64.powi(-first));
    let a2 = product(scaled.as_ref(), scaled.as_ref());
    let a4 = product(a2.as_ref(), a2.as_ref());
    let a6 = product(a4.as_ref(), a2.as_ref());
    let eta = norm(a4.as_ref())
        .powf(0.25)
        .max(norm(a6.as_ref()).powf(1.0 / 6.0));
    // The powers show how much of the first scaling was needless.
    let spare = if eta > 0.0 {
        (THETA / eta).log2().floor().clamp(0.0, f64::from(first))
    } else {
        f64::from(first)
    };
    let spare = (spare as i32 - extra(scaled.as_ref(), spare as i32)).max(0);
    let squarings = first - spare;
    if squarings > MEANINGFUL as i32 {
        return None;
    }
    let up = 2f64.powi(spare);
    let (a1, a2, a4, a6) = (
        scaled * faer::Scale(up),
        a2 * faer::Scale(up.powi(2)),
        a4 * faer::Scale(up.powi(4)),
        a6 * faer::Scale(up.powi(6)),
    );
    let mut result = approximant(a1.as_ref(), a2.as_ref(), a4.as_ref(), a6.as_ref());
    for _ in 0..squarings {
        result = product(result.as_ref(), result.as_ref());
    }
    Some((result, f64::from(APPROXIMANT + squarings)))
}

/// How many squarings the rounding errors of a nonnormal matrix want beyond those of η: ℓ₁₃ of the
/// paper, from ‖|2^up·A|^27‖.
fn extra(a: MatRef<'_, f64>, up: i32) -> i32 {
    // |c_27|, the first coefficient of the backward error of degree 13.
    const ERROR: f64 = 1.0 / 113250775606021113483283660800000000.0;
    let n = a.nrows();
    let factor = 2f64.powi(up);
    let mut power = vec![1.0; n];
    let mut exponent = 0.0;
    for _ in 0..27 {
        let mut next = vec![0.0; n];
        for (j, sum) in next.iter_mut().enumerate() {
            *sum = (0..n).map(|i| a[(i, j)].abs() * factor * power[i]).sum();
        }
        let size = next.iter().copied().fold(0.0, f64::max);
        if size == 0.0 {
            return 0;
        }
        exponent += size.log2();
        power = next.into_iter().map(|entry| entry / size).collect();
    }
    let alpha = ERROR.log2() + exponent - (norm(a) * factor).log2();
    let unit = (f64::EPSILON / 2.0).log2();
    ((alpha - unit) / 26.0).ceil().max(0.0) as i32
}

/// r₁₃(A) from the even powers of A.
fn approximant(
    a: MatRef<'_, f64>,
    a2: MatRef<'_, f64>,
    a4: MatRef<'_, f64>,
    a6: MatRef<'_, f64>,
) -> Mat<f64> {
    let n = a.nrows();
    let b = COEFFICIENTS.map(|coefficient| coefficient / COEFFICIENTS[0]);
    let combine = |six: f64, four: f64, two: f64, zero: f64| {
        Mat::from_fn(n, n, |i, j| {
            let identity = if i == j { zero } else { 0.0 };
            six * a6[(i, j)] + four * a4[(i, j)] + two * a2[(i, j)] + identity
        })
    };
    let above = |high: Mat<f64>, low: Mat<f64>| product(a6, high.as_ref()) + low;
    let odd = above(
        combine(b[13], b[11], b[9], 0.0),
        combine(b[7], b[5], b[3], b[1]),
    );
    let odd = product(a, odd.as_ref());
    let even = above(
        combine(b[12], b[10], b[8], 0.0),
        combine(b[6], b[4], b[2], b[0]),
    );
    // (even − odd) r = even + odd, as r = I + 2 (even − odd)⁻¹ odd to spare the identity's digits.
    let mut result = Lu::of((&even - &odd).as_ref()).solve(&odd * faer::Scale(2.0));
    for i in 0..n {
        result[(i, i)] += 1.0;
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(rows: [[f64; 2]; 2]) -> Mat<f64> {
        let a = Mat::from_fn(2, 2, |i, j| rows[i][j]);
        Pade13.exponential(a.as_ref()).expect("square and finite")
    }

    #[test]
    fn a_rotation_stays_one() {
        let result = of([[0.0, 100.0], [-100.0, 0.0]]);
        assert!((result[(0, 0)] - 100f64.cos()).abs() < 1e-13);
        assert!((result[(0, 1)] - 100f64.sin()).abs() < 1e-13);
    }

    #[test]
    fn a_large_nilpotent_part_is_not_overscaled() {
        // Higham & Al-Mohy's example: exp [1 b; 0 −1] has b·sinh 1 above the diagonal.
        let result = of([[1.0, 1e6], [0.0, -1.0]]);
        let exact = 1e6 * 1f64.sinh();
        assert!(
            (result[(0, 1)] - exact).abs() < 1e-14 * exact,
            "{}",
            result[(0, 1)]
        );
    }

    #[test]
    fn a_jordan_block_gives_its_polynomial() {
        let result = of([[-2.0, 1.0], [0.0, -2.0]]);
        assert!((result[(0, 1)] - (-2f64).exp()).abs() < 2.0 * f64::EPSILON);
        assert_eq!(result[(1, 0)], 0.0);
    }

    #[test]
    fn fast_decay_underflows_to_zero() {
        let result = of([[-1e12, 0.0], [0.0, -1.0]]);
        assert_eq!(result[(0, 0)], 0.0);
        assert!((result[(1, 1)] - (-1f64).exp()).abs() < 1e-4);
    }

    #[test]
    fn molers_stiff_test() {
        // Moler 2012; first row to 60 digits by series, here 12.
        let (a, b, c, d, e) = (2e10, 4e8 / 6.0, 200.0 / 3.0, 3.0, 1e-8);
        let rows = [[0.0, e, 0.0], [-(a + b), -d, a], [c, 0.0, -c]];
        let matrix = Mat::from_fn(3, 3, |i, j| rows[i][j]);
        let result = Pade13.exponential(matrix.as_ref()).expect("finite");
        assert!((result[(0, 0)] / 0.446849468283 - 1.0).abs() < 1e-9);
        assert!((result[(0, 1)] / 1.54044157384e-9 - 1.0).abs() < 1e-9);
        assert!((result[(0, 2)] / 0.462811453559 - 1.0).abs() < 1e-9);
    }
}
