//! Which polynomial, and after how many halvings.

use super::algebra::Algebra;
use super::aligned::Aligned;
use super::dense::Dense;
use super::norm::{column_sums, largest, weighted_sums};
use super::polynomial::{Degree, Powers};

/// A scaled matrix, the powers of it that are known, and how often the result is to be squared.
pub(super) struct Scaled {
    pub(super) degree: Degree,
    pub(super) powers: Powers<Aligned>,
    pub(super) squarings: u32,
}

/// Chooses degree and scaling so that the polynomial is the exponential of a matrix that differs by
/// at most the rounding unit.
///
/// Following Al-Mohy & Higham 2009 (*A new scaling and squaring algorithm for the matrix
/// exponential*, SIAM J. Matrix Anal. 31), not ‖A‖ decides but ‖A^k‖^{1/k} for k = 2 … 6, so that a
/// large norm of a matrix whose powers are small costs no squarings. Here these are proven bounds,
/// from the column sums of products of |A|, |A²| and |A³|, rather than estimates. Where they save
/// squarings, |A|^{m+1} must agree that the rounding errors permit it.
pub(super) fn scale(algebra: &mut Dense, n: usize, a: Aligned) -> Scaled {
    let sums = column_sums(n, &a);
    let norm = largest(&sums);
    let done = |degree, powers| Scaled {
        degree,
        powers,
        squarings: 0,
    };
    for degree in [Degree::One, Degree::Two] {
        if norm <= degree.theta() {
            let (a2, a3) = (None, None);
            return done(degree, unscaled(a, a2, a3));
        }
    }

    let a2 = algebra.multiply(&a, &a);
    let [second, third] = weighted_sums(n, &a2, [None, Some(&sums)]);
    let d2 = largest(&second).sqrt();
    let third = largest(&third);
    let alpha = norm.min(d2.max(third.cbrt()));
    for degree in [Degree::Four, Degree::Eight, Degree::Fifteen] {
        if alpha <= degree.theta() && guard(n, &a, norm, degree, 0) == 0 {
            let (a2, a3) = (Some(a2), None);
            return done(degree, unscaled(a, a2, a3));
        }
    }

    let degree = Degree::TwentyOne;
    let a3 = algebra.multiply(&a2, &a);
    let [cubed, fourth, fifth] = weighted_sums(n, &a3, [None, Some(&sums), Some(&second)]);
    let d3 = largest(&cubed).min(third).cbrt();
    let mut alpha = norm.min(d2.max(d3));
    if needed(alpha) > 0 {
        let [by_squares, by_cubes] = weighted_sums(n, &a2, [Some(&second), Some(&cubed)]);
        let fourth = largest(&by_squares).min(largest(&fourth));
        let fifth = largest(&by_cubes).min(largest(&fifth));
        let [sixth] = weighted_sums(n, &a3, [Some(&cubed)]);
        let sixth = largest(&sixth);
        let (d4, d5, d6) = (fourth.sqrt().sqrt(), fifth.powf(0.2), sixth.powf(1.0 / 6.0));
        // p(p − 1) ≤ m + 1 = 22 for p ≤ 5: max(d_p, d_{p+1}) bounds ‖A^k‖^{1/k} for all k ≥ 22.
        alpha = alpha.min(d3.max(d4)).min(d4.max(d5)).min(d5.max(d6));
    }
    let mut squarings = needed(alpha);
    squarings = (squarings + guard(n, &a, norm, degree, squarings)).min(needed(norm));
    Scaled {
        degree,
        powers: Powers {
            factor: 2f64.powi(-squarings),
            ..unscaled(a, Some(a2), Some(a3))
        },
        squarings: squarings as u32,
    }
}

fn unscaled<E>(a: E, a2: Option<E>, a3: Option<E>) -> Powers<E> {
    Powers {
        a,
        a2,
        a3,
        factor: 1.0,
    }
}

/// How many halvings bring `alpha` to where the polynomial of degree 21 holds. Matrices are scaled to
/// less than 2^151 before.
pub(super) fn needed(alpha: f64) -> i32 {
    (alpha / Degree::TwentyOne.theta())
        .log2()
        .ceil()
        .clamp(0.0, 200.0) as i32
}

/// How many squarings beyond `squarings` the rounding errors of a nonnormal matrix want: ℓ_m of the
/// paper, from the 1-norm of |2^-squarings A|^{m+1}.
fn guard(n: usize, a: &[f64], norm: f64, degree: Degree, squarings: i32) -> i32 {
    let factor = 2f64.powi(-squarings);
    if norm * factor <= degree.theta() {
        return 0;
    }
    let (coefficient, order) = degree.first_error();
    let unit = (f64::EPSILON / 2.0).log2();
    let wanted = |exponent: f64| {
        let error = coefficient.log2() + exponent - (norm * factor).log2();
        ((error - unit) / f64::from(order - 1)).ceil().max(0.0) as i32
    };
    // The binary logarithms of the norms of powers so far; they bound those of higher ones.
    let mut exponents = vec![0.0];
    let mut power = vec![1.0; n];
    for k in 1..=order as usize {
        [power] = weighted_sums(n, a, [Some(&power)]);
        let size = largest(&power) * factor;
        if size == 0.0 {
            return 0;
        }
        exponents.push(exponents[k - 1] + size.log2());
        let (times, rest) = (order as usize / k, order as usize % k);
        if wanted(times as f64 * exponents[k] + exponents[rest]) == 0 {
            return 0;
        }
        let inverse = factor / size;
        power.iter_mut().for_each(|entry| *entry *= inverse);
    }
    wanted(exponents[order as usize])
}
