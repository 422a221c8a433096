//! exp, sin and cos of balls by their Taylor series after reduction of the argument, with ln 2 and
//! π from Machin's formulas (J. Arndt, *Matters Computational*, §32).

use num_bigint::{BigInt, BigUint};
use num_traits::{One, Zero};

use super::ball::Ball;

impl Ball {
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
