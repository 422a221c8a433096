//! Balancing a small matrix in place (Parlett & Reinsch 1969, *Numer. Math.* 13).

/// Makes the norms of each row and column nearly equal, off the diagonal.
pub(crate) fn balance(a: &mut [f64], n: usize) {
    const ROUNDS: usize = 30;
    for _ in 0..ROUNDS {
        let mut settled = true;
        for i in 0..n {
            let (mut column, mut row) = (0.0, 0.0);
            for j in (0..n).filter(|j| *j != i) {
                column += a[j + n * i].abs();
                row += a[i + n * j].abs();
            }
            let ratio: f64 = row / column;
            if !(ratio > 0.0 && ratio.is_finite()) {
                continue;
            }
            // The nearest power of two to √ratio.
            let exponent = (0.5 * ratio.log2()).round();
            let factor = exponent.exp2();
            if exponent != 0.0 && column * factor + row / factor < 0.95 * (column + row) {
                settled = false;
                for j in 0..n {
                    a[j + n * i] *= factor;
                    a[i + n * j] /= factor;
                }
            }
        }
        if settled {
            return;
        }
    }
}
