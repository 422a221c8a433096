//! Balancing a square matrix by a diagonal similarity of powers of two.

use faer::{Mat, MatRef};

/// D and D⁻¹AD, where D = diag(d) makes row and column norms alike.
#[derive(Clone, Debug)]
pub struct Balanced {
    /// D⁻¹AD; powers of two make it free of rounding.
    pub matrix: Mat<f64>,
    /// The diagonal of D.
    pub scale: Vec<f64>,
}

/// Balances A (N × N) with the 2-norm criterion of James, Langou & Lowery 2014 (*On matrix
/// balancing and eigenvector computation*, algorithm 3), which does not spoil matrices that are
/// nearly triangular. Rows or columns that are zero off the diagonal are left as they are.
///
/// # Panics
/// If A is not square.
pub fn balance(a: MatRef<'_, f64>) -> Balanced {
    let n = a.nrows();
    assert_eq!(n, a.ncols(), "as many columns as rows");
    let mut matrix = a.to_owned();
    let mut exponents = vec![0i32; n];
    // Each pass at least quarters some row–column pair, so this ends; the cap is a safeguard.
    for _ in 0..100 {
        let mut converged = true;
        for i in 0..n {
            let others = || (0..n).filter(|j| *j != i);
            let column = norm(others().map(|j| matrix[(j, i)]));
            let row = norm(others().map(|j| matrix[(i, j)]));
            if column == 0.0 || row == 0.0 || !column.is_finite() || !row.is_finite() {
                continue;
            }
            // The power of two nearest to sqrt(row/column).
            let exponent = (0.5 * (row.log2() - column.log2())).round() as i32;
            let factor = exp2(exponent);
            let new = (column * factor).hypot(row / factor);
            let within = (exponents[i] + exponent).abs() <= 900;
            if exponent != 0 && within && new < 0.95 * column.hypot(row) {
                converged = false;
                exponents[i] += exponent;
                for j in 0..n {
                    matrix[(j, i)] *= factor;
                    matrix[(i, j)] /= factor;
                }
            }
        }
        if converged {
            break;
        }
    }
    Balanced {
        matrix,
        scale: exponents.into_iter().map(exp2).collect(),
    }
}

/// The 2-norm; where squares would leave the doubles, the slow way.
fn norm(entries: impl Iterator<Item = f64> + Clone) -> f64 {
    let square: f64 = entries.clone().map(|x| x * x).sum();
    if (1e-200..1e200).contains(&square) {
        square.sqrt()
    } else {
        entries.fold(0.0, f64::hypot)
    }
}

/// 2^exponent, exactly.
fn exp2(exponent: i32) -> f64 {
    2f64.powi(exponent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_similarity_is_exact_and_evens_the_norms() {
        let a = Mat::from_fn(3, 3, |i, j| {
            (1.0 + i as f64 + 2.0 * j as f64) * 1e8f64.powi(i as i32 - j as i32)
        });
        let balanced = balance(a.as_ref());
        for i in 0..3 {
            for j in 0..3 {
                let back = balanced.scale[i] * balanced.matrix[(i, j)] / balanced.scale[j];
                assert_eq!(back, a[(i, j)]);
            }
        }
        let largest = balanced.matrix.norm_max();
        assert!(largest < 20.0, "the norm is {largest}");
    }
}
