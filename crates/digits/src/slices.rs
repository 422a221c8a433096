//! Products of matrices of many digits, as products of matrices of doubles.
//!
//! Rows of A and columns of B, over powers of 2 above their largest entries, are cut into s slices of β bits: Â = Σ 2^{-βp}A_p + …, with
//! whole numbers below 2^β in A_p. While k·s·2^{2β} ≤ 2^53 for k terms in each sum, nothing rounds in C_t = Σ_{p+q=t} A_pB_q, which is one
//! product of slices side by side and slices below each other (Ozaki, Ogita, Oishi & Rump 2012, *Numer. Algorithms* 59).
//! Σ 2^{-βt}C_t for t ≤ s + 1 leaves out at most 1.01·(s + 1)k·2^{-βs} of an entry of ÂB̂. In the 2-norm, with ‖r‖ ≤ ‖A‖_F ≤ √k·‖|A|‖ of the
//! largest entries r of rows, that is 4.04·(s + 1)k²·2^{-βs}·‖|A|‖‖|B|‖.

use faer::{Mat, MatRef};

use crate::wide::Wide;
use crate::{Real, product as of_doubles};

/// [`Real::matrix_product`]. s is such that half a unit for each term bounds what is left out.
pub(crate) fn product<const L: usize>(
    [m, k, n]: [usize; 3],
    a: &[Wide<L>],
    b: &[Wide<L>],
) -> Option<Vec<Wide<L>>> {
    /// Fewer rows or columns are multiplied as quickly term by term.
    const LEAST: usize = 12;
    if m.min(k).min(n) < LEAST {
        return None;
    }
    let (width, count) = slices(k, L)?;
    let mut rows = vec![i64::MIN; m];
    for (row, entries) in rows.iter_mut().zip(a.chunks_exact(k)) {
        for entry in entries {
            *row = (*row).max(entry.top()?);
        }
    }
    let mut columns = vec![i64::MIN; n];
    for entries in b.chunks_exact(n) {
        for (column, entry) in columns.iter_mut().zip(entries) {
            *column = (*column).max(entry.top()?);
        }
    }
    // Rows of zeros below: faer's kernels read whole registers.
    let mut left = Mat::<f64>::zeros(m.next_multiple_of(8), k * count);
    for (at, entry) in a.iter().enumerate() {
        let (i, l) = (at / k, at % k);
        entry.slices(rows[i], width, count, |p, value| {
            left[(i, p * k + l)] = value;
        });
    }
    // The last slice first.
    let mut right = Mat::<f64>::zeros(k * count, n);
    for (at, entry) in b.iter().enumerate() {
        let (l, j) = (at / n, at % n);
        entry.slices(columns[j], width, count, |q, value| {
            right[((count - 1 - q) * k + l, j)] = value;
        });
    }
    // C_t, the last first.
    let sums: Vec<Mat<f64>> = (1..=count)
        .rev()
        .map(|pairs| sum_of_pairs(left.as_ref(), right.as_ref(), pairs * k))
        .collect();
    let mut digits = vec![0i64; count];
    let entries = (0..m * n).map(|at| {
        let (i, j) = (at / n, at % n);
        for (digit, sum) in digits.iter_mut().zip(&sums) {
            *digit = sum[(i, j)] as i64;
        }
        Wide::from_slices(&mut digits, width).scale(rows[i].saturating_add(columns[j]))
    });
    Some(entries.collect())
}

/// β and s for k terms and L limbs: as many bits as doubles hold of such sums.
fn slices(k: usize, limbs: usize) -> Option<(u32, usize)> {
    let bits = 64 * limbs + 4 + (k * (4 * limbs + 2)).next_power_of_two().ilog2() as usize;
    let fits = |width: &u32| {
        (k * bits.div_ceil(*width as usize)) as f64 <= 2f64.powi(53 - 2 * *width as i32)
    };
    // From 17 bits on there are fewer than 4L + 2 slices.
    let width = (17..=24).rev().find(fits)?;
    Some((width, bits.div_ceil(width as usize)))
}

fn sum_of_pairs(left: MatRef<'_, f64>, right: MatRef<'_, f64>, terms: usize) -> Mat<f64> {
    let first = right.nrows() - terms;
    of_doubles(left.subcols(0, terms), right.subrows(first, terms))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DoubleDouble;
    use crate::Magnitude;

    /// Entries of any size and sign within some range of exponents, from a linear congruential generator.
    fn matrix<const L: usize>(
        rows: usize,
        columns: usize,
        reach: i64,
        mut seed: u64,
    ) -> Vec<Wide<L>> {
        let mut next = || {
            seed = seed
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            seed >> 11
        };
        let entry = |_| {
            let parts = (0..=L as i64).map(|part| Wide::from(next() as f64).scale(-53 - 60 * part));
            let size = parts.fold(Wide::ZERO, |sum, part| sum + part);
            let sign = if next() % 2 == 0 {
                Wide::ONE
            } else {
                -Wide::ONE
            };
            match next() % 9 {
                0 => Wide::ZERO,
                _ => (sign * size).scale(next() as i64 % (2 * reach + 1) - reach),
            }
        };
        (0..rows * columns).map(entry).collect()
    }

    fn holds<const L: usize, const M: usize>([m, k, n]: [usize; 3], reach: i64, power: i64) {
        let scaled =
            |all: Vec<Wide<L>>| all.into_iter().map(|x| x.scale(power)).collect::<Vec<_>>();
        let a = scaled(matrix::<L>(m, k, reach, 3));
        let b = scaled(matrix::<L>(k, n, reach, 5));
        let found = product([m, k, n], &a, &b).expect("as quick");
        let frobenius = |all: &[Wide<L>]| {
            let squares = all.iter().map(|x| x.upper() * x.upper());
            squares
                .fold(Magnitude::ZERO, |sum, square| sum + square)
                .sqrt()
        };
        // ‖|A|‖ is at least ‖A‖_F/√k.
        let unit =
            Wide::<L>::unit() * Magnitude::from(k as f64 + 2.0) * Magnitude::from(1.0 / k as f64);
        let allowed = unit * frobenius(&a) * frobenius(&b);
        let mut worst = Magnitude::ZERO;
        for i in 0..m {
            for j in 0..n {
                let terms = (0..k).map(|l| a[i * k + l].resize::<M>() * b[l * n + j].resize::<M>());
                let exact = terms.fold(Wide::ZERO, |sum, term| sum + term);
                let off = (exact - found[i * n + j].resize::<M>()).upper();
                worst = worst + off * off;
            }
        }
        assert!(
            worst.sqrt() <= allowed,
            "{L} limbs, {m} × {k} × {n}, 2^±{reach}"
        );
    }

    #[test]
    fn products_are_within_their_bounds() {
        for shape in [[12, 12, 12], [17, 30, 13], [40, 41, 42], [64, 64, 64]] {
            for (reach, power) in [(0, 0), (20, 3000), (900, -7)] {
                holds::<4, 12>(shape, reach, power);
                holds::<6, 16>(shape, reach, power);
            }
        }
        holds::<8, 20>([13, 70, 15], 3, 0);
        holds::<16, 40>([12, 14, 16], 30, 0);
        holds::<2, 8>([20, 20, 20], 1, 0);
    }

    /// Whole numbers come out as they are, zeros as zeros, and what is undefined is left to others.
    #[test]
    fn whole_numbers_are_exact() {
        let n = 20;
        let value = |i: usize, j: usize| ((i * 7 + j * 5) % 13) as f64 - 6.0;
        let entry = |at: usize| Wide::<4>::from(value(at / n, at % n));
        let mut a: Vec<Wide<4>> = (0..n * n).map(entry).collect();
        let found = product([n, n, n], &a, &a).expect("as quick");
        for (at, found) in found.iter().enumerate() {
            let terms = (0..n).map(|l| value(at / n, l) * value(l, at % n));
            assert_eq!(found.to_f64(), terms.sum::<f64>());
        }
        a[7] = Wide::from(f64::NAN);
        assert!(product([n, n, n], &a, &a).is_none());
        let none = vec![Wide::<4>::ZERO; n * n];
        let found = product([n, n, n], &none, &none).expect("as quick");
        assert!(found.iter().all(|x| x.is_zero()));
    }

    /// The entries of double-doubles have sums of products of their own.
    #[test]
    fn other_numbers_are_left_to_others() {
        let one = vec![DoubleDouble::ONE; 400];
        assert!(DoubleDouble::matrix_product([20, 20, 20], &one, &one).is_none());
    }
}
