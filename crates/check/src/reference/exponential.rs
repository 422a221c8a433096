//! The exponential of an exact matrix by scaling, the Taylor series and squaring (C. Moler and
//! C. Van Loan, *Nineteen dubious ways to compute the exponential of a matrix*, SIAM Review 45,
//! 2003, method 3), every step in balls.

use num_bigint::{BigInt, BigUint};
use num_rational::BigRational;
use num_traits::One;

use super::equation::log2;
use super::error::ReferenceError;
use super::fixed_matrix::FixedMatrix;
use super::pi_polynomial::PiMatrix;

/// The bits before the point of the largest exponential: doubles do not span as much.
const MOST_GROWTH: u64 = 2200;

/// e^(A t) to `bits` bits after the point, less what squaring loses; `None` where that is all.
///
/// # Errors
/// [`ReferenceError::TooFast`].
pub(super) fn exponential(
    matrix: &PiMatrix,
    time: &BigRational,
    bits: u64,
) -> Result<Option<FixedMatrix>, ReferenceError> {
    let (mut power, halvings) = scaled(matrix, time, bits);
    for _ in 0..halvings {
        match squared(&power)? {
            Some(square) => power = square,
            None => return Ok(None),
        }
    }
    Ok(Some(power))
}

/// The square, as long as it is known and not too long.
fn squared(power: &FixedMatrix) -> Result<Option<FixedMatrix>, ReferenceError> {
    let square = power.times(power);
    match square.row_norm().bits() > square.bits + MOST_GROWTH {
        true => Err(ReferenceError::TooFast),
        false => Ok(square.known()),
    }
}

/// For each component, a bound of γ_i = Σ_j |e^(A τ)|_ij over all τ from 0 to t, in units of
/// 2^−`bits`: what errors of 1 in all components may have become. `None` where `bits` do not suffice.
///
/// # Errors
/// [`ReferenceError::TooFast`].
///
/// For τ ≤ t 2^−s, |e^(A τ)| ≤ e^(|A| t 2^−s). Every τ ≤ t 2^(1−s) is τ′ or t 2^−s + τ′ with
/// τ′ ≤ t 2^−s, so that |e^(A t 2^−s)| γ is a bound for twice the range, if it is not less than γ.
pub(super) fn growth(
    matrix: &PiMatrix,
    time: &BigRational,
    bits: u64,
) -> Result<Option<Vec<BigUint>>, ReferenceError> {
    let (mut power, halvings) = scaled(matrix, time, bits);
    let order = power.order;
    let sizes = PiMatrix::from_fn(order, order, |i, j| matrix.at(i, j).abs());
    let shorter = time / BigRational::from(BigInt::one() << halvings);
    let short = scaled(&sizes, &shorter, bits).0.sizes();
    let mut most: Vec<BigUint> = (0..order).map(|i| short.row_sum(i)).collect();
    for _ in 0..halvings {
        let later = power.carry(&most);
        most = most.into_iter().zip(later).map(|(a, b)| a.max(b)).collect();
        match squared(&power)? {
            Some(square) => power = square,
            None => return Ok(None),
        }
    }
    Ok(Some(most))
}

/// How often A t is halved before its series is summed, so that ‖A t‖_∞ 2^−s is about ½.
pub(super) fn halvings(matrix: &PiMatrix, time: &BigRational) -> u64 {
    let mut rows = vec![Vec::new(); matrix.nrows()];
    for (i, _, entry) in matrix.nonzeros() {
        rows[i].push(entry.log2());
    }
    let norm = |row: &Vec<f64>| {
        let most = row.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        most + row
            .iter()
            .map(|log| (log - most).exp2())
            .sum::<f64>()
            .log2()
    };
    let norm = rows.iter().filter(|row| !row.is_empty()).map(norm);
    let norm = norm.fold(f64::NEG_INFINITY, f64::max) + log2(time);
    (norm + 1.0).ceil().max(0.0) as u64
}

/// e^(A t 2^−s), and s.
fn scaled(matrix: &PiMatrix, time: &BigRational, bits: u64) -> (FixedMatrix, u64) {
    let mut halvings = halvings(matrix, time);
    let one = BigUint::one() << bits;
    let small = loop {
        let shrink = time / BigRational::from(BigInt::one() << halvings);
        let small = FixedMatrix::cut(matrix, &shrink, bits);
        if small.row_norm() + &small.radius * matrix.nrows() <= one {
            break small;
        }
        halvings += 1;
    };
    let mut term = FixedMatrix::identity(matrix.nrows(), bits);
    let mut sum = term.clone();
    for k in 1.. {
        term = small.times(&term).divided(k);
        if term.vanishes() {
            // ‖A t 2^−s‖ ≤ 1: what is left out is less than twice this term.
            sum.radius += (term.row_norm() + &term.radius * matrix.nrows()) << 1u8;
            break;
        }
        sum = sum.plus(&term);
    }
    (sum, halvings)
}
