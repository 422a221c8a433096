//! One-sided Jacobi: singular values by rotating columns until they are orthogonal (Hestenes 1958,
//! *J. SIAM* 6). Each is right to a few units times the condition of the matrix with columns of
//! norm 1 (Demmel & Veselić 1992, *SIAM J. Matrix Anal.* 13, §4).

use faer::Mat;

/// Norms and directions of the rotated columns; `None` where they do not become orthogonal.
pub(crate) fn jacobi(mut columns: Mat<f64>) -> Option<(Vec<f64>, Mat<f64>)> {
    const SWEEPS: usize = 60;
    let (rows, count) = (columns.nrows(), columns.ncols());
    // A power of two keeps squares within range.
    let scale = columns.norm_max().log2().floor();
    let scale = if scale.is_finite() {
        (-scale).clamp(-1000.0, 1000.0).exp2()
    } else {
        1.0
    };
    columns *= faer::Scale(scale);
    let tolerance = f64::EPSILON * (rows as f64).sqrt();
    let mut converged = count < 2;
    for _ in 0..SWEEPS {
        let mut rotated = false;
        for p in 0..count {
            for q in p + 1..count {
                let (a, b) = (columns.col(p), columns.col(q));
                let (alpha, beta, gamma) =
                    (a.squared_norm_l2(), b.squared_norm_l2(), a.transpose() * b);
                let limit = tolerance * alpha.sqrt() * beta.sqrt();
                if gamma == 0.0 || gamma.abs() <= limit {
                    continue;
                }
                rotated = true;
                let zeta = (beta - alpha) / (2.0 * gamma);
                let t = zeta.signum() / (zeta.abs() + 1f64.hypot(zeta));
                let cosine = 1.0 / 1f64.hypot(t);
                rotate(&mut columns, p, q, cosine, cosine * t);
            }
        }
        if !rotated {
            converged = true;
            break;
        }
    }
    if !converged {
        return None;
    }
    let norms: Vec<f64> = (0..count).map(|j| columns.col(j).norm_l2()).collect();
    let directions = Mat::from_fn(rows, count, |i, j| columns[(i, j)] / norms[j]);
    Some((norms.iter().map(|norm| norm / scale).collect(), directions))
}

/// (a_p, a_q) ← (c·a_p − s·a_q, s·a_p + c·a_q).
fn rotate(matrix: &mut Mat<f64>, p: usize, q: usize, cosine: f64, sine: f64) {
    for i in 0..matrix.nrows() {
        let (a, b) = (matrix[(i, p)], matrix[(i, q)]);
        matrix[(i, p)] = cosine * a - sine * b;
        matrix[(i, q)] = sine * a + cosine * b;
    }
}
