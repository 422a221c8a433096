//! Balancing a small matrix in place (Parlett & Reinsch 1969, *Numer. Math.* 13).

/// Makes the norms of each row and column nearly equal, off the diagonal.
pub(crate) fn balance(a: &mut [f64], n: usize) {
    const ROUNDS: usize = 30;
    /// Exact, and sums of so many of the largest doubles are finite.
    const PART: f64 = 1.0 / 65536.0;
    /// Powers of two up to this one are doubles, and so are their inverses.
    const MOST: f64 = 1000.0;
    for _ in 0..ROUNDS {
        let mut settled = true;
        for i in 0..n {
            let (mut column, mut row) = (0.0, 0.0);
            for j in (0..n).filter(|j| *j != i) {
                column += PART * a[j + n * i].abs();
                row += PART * a[i + n * j].abs();
            }
            let ratio: f64 = row / column;
            // The nearest power of two to √ratio, which may itself be beyond doubles.
            let size = match (ratio > 0.0 && ratio.is_finite(), row > 0.0 && column > 0.0) {
                (true, _) => ratio.log2(),
                (false, true) => row.log2() - column.log2(),
                (false, false) => continue,
            };
            let exponent = (0.5 * size).round().clamp(-MOST, MOST);
            if !exponent.is_finite() {
                continue;
            }
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
