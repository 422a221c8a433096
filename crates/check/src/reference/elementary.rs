//! exp, sin and cos of balls by their Taylor series after reduction of the argument, with ln 2 and
//! π from Machin's formulas (J. Arndt, *Matters Computational*, §32).

use std::cmp::Ordering;

use num_bigint::{BigInt, BigUint};
use num_traits::{One, Zero};

use super::ball::Ball;

/// log₂ of the arguments from which on e^x is beyond every range.
const LARGEST: u32 = 20;

impl Ball {
    /// e^x; within 2^(−2^20) of 0 for x ≤ −2^20, and unknown from x = 2^20 on.
    pub(crate) fn exp(&self) -> Ball {
        let bits = self.bits();
        if self.is_unknown() || self.radius_log2() >= 0.0 {
            return Ball::unknown(bits);
        }
        if self.log2() >= f64::from(LARGEST) {
            let tiny = Ball::from(1).scaled(-(1 << LARGEST));
            return match self.sign() {
                Some(Ordering::Less) => Ball::zero().with_bits(bits).widened(&tiny),
                _ => Ball::unknown(bits),
            };
        }
        // The argument is halved until few terms are left; each squaring doubles the error.
        let halvings = 8 + bits.isqrt() as i64 / 2;
        let working = bits + halvings as u64 + 48;
        let ln2 = ln2(working + u64::from(LARGEST));
        let whole = (self.midpoint().with_bits(working) / &ln2).round();
        let rest = self.clone().with_bits(working) - ln2 * Ball::from(whole.clone());
        let mut power = taylor(&rest.scaled(-halvings), 1, |term, k| term / Ball::from(k));
        for _ in 0..halvings {
            power = &power * &power;
        }
        let whole = i64::try_from(whole).expect("below 2^21");
        power.scaled(whole).with_bits(bits)
    }

    /// (sin x, cos x); unknown from x = 2^(2·bits + 1100) on.
    pub(crate) fn sin_cos(&self) -> (Ball, Ball) {
        let bits = self.bits();
        let reduced = self.log2().max(0.0);
        if self.is_unknown() || self.radius_log2() > -2.0 || reduced > 2.0 * bits as f64 + 1100.0 {
            return (Ball::unknown(bits), Ball::unknown(bits));
        }
        let working = bits + reduced as u64 + 32;
        let quarter = pi(working).scaled(-1);
        let quarters = (self.midpoint().with_bits(working) / &quarter).round();
        let rest = self.clone().with_bits(working) - quarter * Ball::from(quarters.clone());
        let rest = rest.rounded(bits + 32);
        let square = -(&rest * &rest);
        let by = |term: Ball, a: i64| term / Ball::from(a);
        let cos = taylor(&square, 1, |term, k| by(term, 2 * k * (2 * k - 1)));
        let sin = rest * taylor(&square, 1, |term, k| by(term, 2 * k * (2 * k + 1)));
        let (sin, cos) = (sin.with_bits(bits), cos.with_bits(bits));
        let four = BigInt::from(4);
        let quadrant: BigInt = ((quarters % &four) + &four) % &four;
        match u8::try_from(quadrant).expect("0 … 3") {
            0 => (sin, cos),
            1 => (cos, -sin),
            2 => (-sin, -cos),
            _ => (-cos, sin),
        }
    }
}

/// The sum of the terms that start with `first` and follow from one another by a factor `x` and
/// `divide`, for |x| < 1.1 and growing divisors: where terms have become small, each is less than
/// half of the one before.
fn taylor(x: &Ball, first: i64, divide: impl Fn(Ball, i64) -> Ball) -> Ball {
    let floor = -(x.bits() as f64) - 8.0;
    let mut term = Ball::from(first).with_bits(x.bits());
    let mut sum = term.clone();
    for k in 1.. {
        term = divide(term * x, k);
        if term.is_zero() {
            return sum;
        }
        if term.log2().max(term.radius_log2()) < floor {
            return sum.widened(&term.scaled(1));
        }
        sum = sum + &term;
    }
    sum
}

/// π = 16 atan(1/5) − 4 atan(1/239).
pub(crate) fn pi(bits: u64) -> Ball {
    let atan = |n| inverse_series(n, bits, true);
    Ball::from(16) * atan(5) - Ball::from(4) * atan(239)
}

/// ln 2 = 18 artanh(1/26) − 2 artanh(1/4801) + 8 artanh(1/8749).
fn ln2(bits: u64) -> Ball {
    let artanh = |n| inverse_series(n, bits, false);
    Ball::from(18) * artanh(26) - Ball::from(2) * artanh(4801) + Ball::from(8) * artanh(8749)
}

/// Σ (±1)^k/((2k+1) n^(2k+1)): atan(1/n) or artanh(1/n). Each term is cut twice, and the terms left
/// out come to less than a last place.
fn inverse_series(n: u32, bits: u64, alternating: bool) -> Ball {
    let guarded = bits + 16;
    let mut power = (BigInt::one() << guarded) / n;
    let (mut sum, mut cuts) = (BigInt::zero(), BigUint::from(2u8));
    for k in 0u32.. {
        let term = &power / (2 * k + 1);
        if term.is_zero() {
            break;
        }
        match alternating && k % 2 == 1 {
            true => sum -= term,
            false => sum += term,
        }
        power /= n * n;
        cuts += 3u8;
    }
    Ball::new(sum, cuts, -(guarded as i64), bits)
}
