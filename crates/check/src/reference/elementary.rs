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

#[cfg(test)]
mod tests {
    use std::f64::consts::{self, FRAC_PI_2};

    use super::*;

    fn decimal(ball: &Ball, digits: usize) -> String {
        let known = (ball.log2() - ball.radius_log2()) * std::f64::consts::LOG10_2;
        assert!(known > digits as f64 + 2.0);
        ball.to_decimal(digits)
    }

    fn exactly(value: f64) -> Ball {
        Ball::exactly(value).expect("finite").with_bits(192)
    }

    /// From mpmath with 100 digits.
    #[test]
    fn digits_are_those_of_mpmath() {
        assert_eq!(decimal(&pi(192), 40), PI);
        for (x, exp, sin, cos) in VALUES {
            let x = exactly(*x);
            assert_eq!(decimal(&x.exp(), 40), *exp);
            let (found_sin, found_cos) = x.sin_cos();
            assert_eq!(decimal(&found_sin, 40), *sin);
            assert_eq!(decimal(&found_cos, 40), *cos);
        }
    }

    #[test]
    fn what_is_out_of_reach_is_unknown() {
        assert!(exactly(2e6).exp().is_unknown());
        let nothing = exactly(-2e6).exp();
        assert!(nothing.contains_zero() && nothing.radius_log2() <= -1_000_000.0);
        let wide = Ball::zero().widened(&Ball::from(1));
        assert!(wide.sin_cos().0.is_unknown() && wide.exp().is_unknown());
    }

    #[test]
    fn wide_arguments_give_wide_values() {
        // e^x for x within 2^-20 of 1 is within e·2^-20·1.01 of e, and no less.
        let near = exactly(1.0).widened(&Ball::from(1).scaled(-20));
        let spread = near.exp().radius() / 2f64.powi(-20);
        assert!((consts::E..2.9).contains(&spread), "{spread}");
        let spread = near.sin_cos().0.radius() / 2f64.powi(-20);
        assert!((0.54..1.7).contains(&spread), "{spread}");
    }

    const PI: &str = "3.141592653589793238462643383279502884197e0";
    #[rustfmt::skip]
    const VALUES: &[(f64, &str, &str, &str)] = &[
        (1.0, "2.718281828459045235360287471352662497757e0", "8.414709848078965066525023216302989996226e-1", "5.403023058681397174009366074429766037323e-1"),
        (-0.3, "7.408182206817178742916082359446519848763e-1", "-2.955202066613395644989550807669445010439e-1", "9.553364891256060229232436043420874092269e-1"),
        (1e-10, "1.000000000100000000005000003643386398581e0", "1.000000000000000036430530648831074912317e-10", "9.999999999999999999949999999999999996357e-1"),
        (0.79, "2.203396426255936737500012823780044741291e0", "7.103532724176078348196376817427499224618e-1", "7.038453156522360716759629840976125179017e-1"),
        (-FRAC_PI_2, "2.078795763507619212759085091383985881883e-1", "-9.999999999999999999999999999999981253003e-1", "6.123233995736765886130329661375001464640e-17"),
        (consts::PI, "2.314069263277926617181157008936183649988e1", "1.224646799147353177226065932274997997083e-16", "-9.999999999999999999999999999999925012011e-1"),
        (100.25, "3.451610733125923987136198599526574675092e43", "-2.772828564548513033536720570194358868443e-1", "9.607883312760612034423445613620499861238e-1"),
        (-1e5, "3.562949565309373121071174418748652368609e-43430", "-3.574879797201650931647050069580882900905e-2", "-9.993608074382124518911354141448022032354e-1"),
        (1e6, "3.033215396802087545086402141418114327084e434294", "-3.499935021712929521176524867807714690614e-1", "9.367521275331447869385325350749187757081e-1"),
        (123456.789, "4.001438939280317422768034483229449563401e53616", "-9.986640823432245253101441505994574890905e-1", "5.167253271870138266287687326741910977895e-2"),
    ];
}
