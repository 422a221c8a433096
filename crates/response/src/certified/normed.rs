//! Square matrices with a bound of their error in the 2-norm.

use eigentone_digits::{BallMatrix, Magnitude, Real};

/// A true matrix within `error` of the matrix kept, in the 2-norm, and of the same shape: block
/// upper triangular, with a first block of `lead` rows.
#[derive(Clone, Debug)]
pub(crate) struct Normed<T> {
    n: usize,
    lead: usize,
    /// Row by row.
    entries: Vec<T>,
    error: Magnitude,
    /// Upper bounds of the norms of what is kept.
    norm: Magnitude,
    frobenius: Magnitude,
}

impl<T: Real> Normed<T> {
    /// From entries row by row and the error they have already.
    pub(crate) fn new(n: usize, lead: usize, entries: Vec<T>, error: Magnitude) -> Normed<T> {
        let squares = entries.iter().map(|entry| {
            let size = entry.upper();
            size * size
        });
        let frobenius = squares
            .fold(Magnitude::ZERO, |sum, square| sum + square)
            .sqrt();
        let norm = two_norm(n, &entries, frobenius);
        // Entries that left the range of T say nothing, though their bounds may be finite.
        let error = if frobenius.is_finite() {
            error
        } else {
            Magnitude::INFINITY
        };
        Normed {
            n,
            lead,
            entries,
            error,
            norm,
            frobenius,
        }
    }

    /// From a matrix known entry by entry.
    pub(crate) fn of(matrix: &BallMatrix<T>, lead: usize) -> Normed<T> {
        let n = matrix.rows();
        let entries = (0..n * n).map(|at| matrix.middle(at / n, at % n));
        Normed::new(n, lead, entries.collect(), matrix.spread())
    }

    pub(crate) fn identity(n: usize, lead: usize) -> Normed<T> {
        let entry = |at: usize| if at / n == at % n { T::ONE } else { T::ZERO };
        let entries = (0..n * n).map(entry).collect();
        Normed::new(n, lead, entries, Magnitude::ZERO)
    }

    pub(crate) fn len(&self) -> usize {
        self.n
    }

    pub(crate) fn lead(&self) -> usize {
        self.lead
    }

    pub(crate) fn entries(&self) -> &[T] {
        &self.entries
    }

    pub(crate) fn row(&self, i: usize) -> &[T] {
        &self.entries[i * self.n..(i + 1) * self.n]
    }

    /// How far the true matrix may be, in the 2-norm.
    pub(crate) fn error(&self) -> Magnitude {
        self.error
    }

    /// An upper bound of the 2-norm of the true matrix.
    pub(crate) fn true_norm(&self) -> Magnitude {
        self.norm + self.error
    }

    /// An upper bound of the Frobenius norm of what is kept.
    pub(crate) fn frobenius(&self) -> Magnitude {
        self.frobenius
    }

    /// The same matrix, farther from the true one.
    pub(crate) fn with_more_error(mut self, more: Magnitude) -> Normed<T> {
        self.error = self.error + more;
        self
    }

    /// 2^power times the matrix.
    pub(crate) fn scaled(&self, power: i64) -> Normed<T> {
        let factor = Magnitude::power_of_two(power);
        let lost = T::floor() * Magnitude::from(self.n as f64);
        Normed {
            entries: self.entries.iter().map(|x| x.scale(power)).collect(),
            error: self.error * factor + lost,
            norm: self.norm * factor + lost,
            frobenius: self.frobenius * factor + lost,
            ..*self
        }
    }

    /// `factor` times the matrix, for a factor known to a relative `error`.
    pub(crate) fn times_scalar(&self, factor: T, error: Magnitude) -> Normed<T> {
        let size = factor.upper();
        let rounding = size * self.frobenius * (T::unit() + error)
            + T::floor() * Magnitude::from(self.n as f64);
        let error = size * self.error * (Magnitude::from(1.0) + error) + rounding;
        let entries = self.entries.iter().map(|x| *x * factor).collect();
        Normed::new(self.n, self.lead, entries, error)
    }

    /// The product. With k = n terms in each sum, its rounding is at most (k + 2)U in parts of the
    /// product of sizes (Higham 2002, §3.5), in the Frobenius norm.
    pub(crate) fn times(&self, other: &Normed<T>) -> Normed<T> {
        let (n, lead) = (self.n, self.lead);
        let mut entries = vec![T::ZERO; n * n];
        for i in 0..n {
            let (from, first) = if i < lead { (0, 0) } else { (lead, lead) };
            let row = &mut entries[i * n..(i + 1) * n];
            for k in from..n {
                let factor = self.entries[i * n + k];
                if factor.is_zero() {
                    continue;
                }
                let start = if k < lead { first } else { lead };
                let right = &other.entries[k * n + start..(k + 1) * n];
                for (sum, entry) in row[start..].iter_mut().zip(right) {
                    *sum = *sum + factor * *entry;
                }
            }
        }
        let rounding = self.frobenius * other.frobenius * growth::<T>(n)
            + T::floor() * Magnitude::from((n * n) as f64 * 2.0);
        let error = self.norm * other.error + self.error * other.true_norm() + rounding;
        Normed::new(n, lead, entries, error)
    }
}

/// (k + 2)U, above kU/(1 − kU).
pub(crate) fn growth<T: Real>(k: usize) -> Magnitude {
    T::unit() * Magnitude::from(k as f64 + 2.0)
}

/// An upper bound of the 2-norm: ‖A‖² = ‖G‖ for G = AᵀA, and ‖G‖⁴ = ‖G⁴‖ ≤ ‖G⁴‖_∞, computed in
/// doubles with their rounding added. It exceeds the norm by at most the eighth root of n.
fn two_norm<T: Real>(n: usize, entries: &[T], frobenius: Magnitude) -> Magnitude {
    const UNIT: f64 = f64::EPSILON / 2.0;
    if n == 0 || frobenius.is_zero() || !frobenius.is_finite() {
        return frobenius;
    }
    let shift = frobenius.exponent();
    // Entries of size at most 1, each within a unit of itself or 2^-1074.
    let a: Vec<f64> = entries.iter().map(|x| x.scale(-shift).to_f64()).collect();
    let mut gram = vec![0.0; n * n];
    for row in a.chunks_exact(n) {
        for (i, x) in row.iter().enumerate().filter(|(_, x)| **x != 0.0) {
            for (sum, y) in gram[i * n..(i + 1) * n].iter_mut().zip(row) {
                *sum += x * y;
            }
        }
    }
    let square = |matrix: &[f64]| {
        let mut square = vec![0.0; n * n];
        for i in 0..n {
            for k in 0..n {
                let factor = matrix[i * n + k];
                for j in 0..n {
                    square[i * n + j] += factor * matrix[k * n + j];
                }
            }
        }
        square
    };
    // The Frobenius norms of the rounding errors; squares of sizes up to 1 + n·units.
    let lost = |matrix: &[f64]| {
        let sum: f64 = matrix.iter().map(|x| x * x).sum();
        (n as f64 + 4.0) * 2.0 * UNIT * sum + f64::MIN_POSITIVE * (n * n) as f64
    };
    let second = square(&gram);
    let fourth = square(&second);
    let row_sum = |i: usize| {
        let row = fourth[i * n..(i + 1) * n].iter();
        row.map(|x| x.abs()).sum::<f64>()
    };
    let largest = (0..n).map(row_sum).fold(0.0, f64::max) * (1.0 + 2.0 * n as f64 * UNIT);
    let of_second = (largest + lost(&second)).sqrt();
    let of_gram = (of_second * (1.0 + 8.0 * UNIT) + lost(&gram)).sqrt();
    // ‖A‖_F ≤ 1 after the scaling; the conversions add 4 units to what the sums lose.
    let of_square = of_gram * (1.0 + 8.0 * UNIT) + (n as f64 + 8.0) * 2.0 * UNIT;
    let norm = Magnitude::from(of_square * (1.0 + 8.0 * UNIT)).sqrt();
    let bound = norm * Magnitude::power_of_two(shift);
    if bound < frobenius { bound } else { frobenius }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentone_digits::{DoubleDouble, Wide};

    fn normed<T: Real>(n: usize, entries: &[f64]) -> Normed<T> {
        let entries = entries.iter().map(|x| T::from(*x)).collect();
        Normed::new(n, n, entries, Magnitude::ZERO)
    }

    #[test]
    fn the_two_norm_is_bounded_closely() {
        // A rotation, a nilpotent matrix, and a singular one: norms 1, 1e9 and 2·√5.
        let (c, s) = (0.6, 0.8);
        for (entries, norm) in [
            ([c, s, -s, c], 1.0),
            ([0.0, 1e9, 0.0, 0.0], 1e9),
            ([2.0, 2.0, 4.0, 4.0], 40f64.sqrt()),
            ([1e-300, 0.0, 0.0, 1e-310], 1e-300),
        ] {
            let bound = normed::<DoubleDouble>(2, &entries).true_norm().to_f64();
            assert!(bound >= norm * (1.0 - 1e-15), "{bound} {norm}");
            assert!(bound <= norm * 1.1, "{bound} {norm}");
        }
    }

    #[test]
    fn products_respect_the_blocks() {
        let entries = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 0.0, 0.0, 7.0];
        let whole = normed::<Wide<4>>(3, &entries);
        let blocked = Normed::new(3, 2, whole.entries.clone(), Magnitude::ZERO);
        assert_eq!(whole.times(&whole).entries, blocked.times(&blocked).entries);
        assert_eq!(
            blocked.times(&blocked).row(0)[2].to_f64(),
            3.0 + 12.0 + 21.0
        );
    }
}
