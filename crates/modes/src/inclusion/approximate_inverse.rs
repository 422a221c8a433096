//! About the inverse of a complex matrix, in doubles, and how far its product with the matrix is from the identity.
//!
//! A matrix is given by rows, each of which has all real parts before all imaginary parts.

use num_complex::Complex;
use pulp::{Arch, Simd, WithSimd};

/// |re| + |im|.
pub(super) fn size(z: Complex<f64>) -> f64 {
    z.re.abs() + z.im.abs()
}

/// R near the inverse of J.
pub(super) struct Inverse {
    n: usize,
    rows: Vec<f64>,
    /// The [sizes](size) of I − RJ as it is computed, by rows.
    rest: Vec<f64>,
}

impl Inverse {
    /// Of an n × n matrix, by Gauss–Jordan elimination with row pivoting; `None` for one that is about singular, or beyond what
    /// squares in doubles reach.
    pub(super) fn of(matrix: &[f64], n: usize) -> Option<Inverse> {
        Arch::new().dispatch(Inversion { matrix, n })
    }

    /// R times a vector.
    pub(super) fn times(&self, vector: &[Complex<f64>]) -> Vec<Complex<f64>> {
        let rows = self.rows.chunks_exact(2 * self.n);
        let entry = |row: &[f64]| {
            let parts = row[..self.n].iter().zip(&row[self.n..]);
            let each = parts
                .zip(vector)
                .map(|((re, im), x)| Complex::new(*re, *im) * x);
            each.sum()
        };
        rows.map(entry).collect()
    }

    /// Σ |R||x| + |I − RJ||y| by rows, with the [sizes](size) of both matrices.
    pub(super) fn sizes(&self, x: &[f64], y: &[f64]) -> Vec<f64> {
        let n = self.n;
        let rows = self.rows.chunks_exact(2 * n).zip(self.rest.chunks_exact(n));
        let sum = |(row, rest): (&[f64], &[f64])| -> f64 {
            let parts = row[..n].iter().zip(&row[n..]).zip(x);
            let parts: f64 = parts.map(|((re, im), x)| (re.abs() + im.abs()) * x).sum();
            let rest: f64 = rest.iter().zip(y).map(|(rest, y)| rest * y).sum();
            parts + rest
        };
        rows.map(sum).collect()
    }
}

struct Inversion<'a> {
    matrix: &'a [f64],
    n: usize,
}

impl WithSimd for Inversion<'_> {
    type Output = Option<Inverse>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Option<Inverse> {
        let n = self.n;
        let rows = self.eliminated()?;
        let mut rest = vec![0.0; n * n];
        let mut row = vec![0.0; 2 * n];
        for (i, (rest, factors)) in rest
            .chunks_exact_mut(n)
            .zip(rows.chunks_exact(2 * n))
            .enumerate()
        {
            row.fill(0.0);
            row[i] = 1.0;
            for (k, below) in self.matrix.chunks_exact(2 * n).enumerate() {
                subtract(&mut row, Complex::new(factors[k], factors[n + k]), below);
            }
            let (re, im) = row.split_at(n);
            for ((rest, re), im) in rest.iter_mut().zip(re).zip(im) {
                *rest = re.abs() + im.abs();
            }
        }
        Some(Inverse { n, rows, rest })
    }
}

impl Inversion<'_> {
    #[inline(always)]
    fn eliminated(&self) -> Option<Vec<f64>> {
        const REACH: std::ops::Range<f64> = 1e-100..1e100;
        let (n, mut a) = (self.n, self.matrix.to_vec());
        let width = 2 * n;
        let mut swaps = Vec::with_capacity(n);
        let mut above = vec![0.0; width];
        for k in 0..n {
            let entry = |i: usize| size(Complex::new(a[i * width + k], a[i * width + n + k]));
            let best = (k..n).max_by(|i, j| entry(*i).total_cmp(&entry(*j)))?;
            if !REACH.contains(&entry(best)) {
                return None;
            }
            swaps.push(best);
            if best != k {
                let (head, tail) = a.split_at_mut(best * width);
                head[k * width..][..width].swap_with_slice(&mut tail[..width]);
            }
            let pivot = &mut a[k * width..][..width];
            let share = Complex::new(pivot[k], pivot[n + k]).inv();
            (pivot[k], pivot[n + k]) = (1.0, 0.0);
            above.fill(0.0);
            subtract(&mut above, -share, pivot);
            pivot.copy_from_slice(&above);
            for (i, row) in a.chunks_exact_mut(width).enumerate() {
                let factor = Complex::new(row[k], row[n + k]);
                if i != k && factor != Complex::ZERO {
                    (row[k], row[n + k]) = (0.0, 0.0);
                    subtract(row, factor, &above);
                }
            }
        }
        for (k, best) in swaps
            .into_iter()
            .enumerate()
            .rev()
            .filter(|(k, best)| k != best)
        {
            for part in a.chunks_exact_mut(n) {
                part.swap(k, best);
            }
        }
        Some(a)
    }
}

/// row − factor·other.
#[inline(always)]
fn subtract(row: &mut [f64], factor: Complex<f64>, other: &[f64]) {
    let n = row.len() / 2;
    let (re, im) = row.split_at_mut(n);
    let (a, b) = other.split_at(n);
    for (((re, im), a), b) in re.iter_mut().zip(im).zip(a).zip(b) {
        *re -= factor.re * a - factor.im * b;
        *im -= factor.re * b + factor.im * a;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_change_places() {
        let re = [[0.0, 2.0, 0.0], [1.0, 4.0, 0.5], [8.0, 0.0, -1.0]];
        let im = [[0.0, 1.0, 3.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 2.0]];
        let rows = re.iter().zip(&im).flat_map(|(re, im)| [*re, *im]);
        let matrix: Vec<f64> = rows.flatten().collect();
        let found = Inverse::of(&matrix, 3).expect("it is regular");
        assert!(
            found.rest.iter().all(|rest| *rest < 1e-15),
            "{:?}",
            found.rest
        );
        for j in 0..3 {
            let column: Vec<_> = (0..3).map(|i| Complex::new(re[i][j], im[i][j])).collect();
            for (i, entry) in found.times(&column).into_iter().enumerate() {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((entry - expected).norm() < 1e-14, "{i} {j} {entry}");
            }
        }
        assert!(Inverse::of(&[1.0, 2.0, 1.0, 2.0, 2.0, 4.0, 2.0, 4.0], 2).is_none());
    }
}
