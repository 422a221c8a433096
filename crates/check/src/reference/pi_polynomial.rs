//! Polynomials in π with rational coefficients, which are exact: π is a root of none but 0 (F. Lindemann, *Über die
//! Zahl π*, Math. Ann. 20, 1882), so that 0 is decided without digits, and any number of digits decides a sign.

use std::ops::{Add, AddAssign, Mul};

use num_rational::BigRational;
use num_traits::{One, Zero};

use super::ball::Ball;
use super::driven_form::shifted;
use super::elementary::pi;
use super::rational_matrix::Matrix;

/// Σ cᵢ πⁱ.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct PiPolynomial {
    /// From i = 0 on; the last one is not 0.
    coefficients: Vec<BigRational>,
}

/// A matrix of such numbers.
pub(super) type PiMatrix = Matrix<PiPolynomial>;

impl PiPolynomial {
    /// `value`·π.
    pub(super) fn times_pi(value: BigRational) -> PiPolynomial {
        let coefficients = vec![BigRational::zero(), value];
        PiPolynomial { coefficients }.trimmed()
    }

    fn trimmed(mut self) -> PiPolynomial {
        while self.coefficients.last().is_some_and(Zero::is_zero) {
            self.coefficients.pop();
        }
        self
    }

    /// The number, if it is rational.
    pub(super) fn rational(&self) -> Option<BigRational> {
        match self.coefficients.as_slice() {
            [] => Some(BigRational::zero()),
            [only] => Some(only.clone()),
            _ => None,
        }
    }

    fn each(&self, change: impl Fn(&BigRational) -> BigRational) -> PiPolynomial {
        PiPolynomial {
            coefficients: self.coefficients.iter().map(change).collect(),
        }
    }

    /// The number times 2^`power`.
    pub(super) fn shifted(&self, power: i64) -> PiPolynomial {
        self.each(|value| shifted(value, power))
    }

    /// The number to at least `bits` bits.
    pub(super) fn ball(&self, bits: u64) -> Ball {
        if let Some(value) = self.rational() {
            return Ball::rational(&value, bits);
        }
        let mut working = bits + 32;
        loop {
            let pi = pi(working);
            let highest = self.coefficients.iter().rev();
            let sum = highest.fold(Ball::zero(), |sum, value| {
                sum * &pi + Ball::rational(value, working)
            });
            // Not 0, so that the loop ends.
            if sum.radius_log2() <= sum.log2() - bits as f64 {
                return sum.rounded(bits);
            }
            working *= 2;
        }
    }

    pub(super) fn abs(&self) -> PiPolynomial {
        match self.ball(8).nearest() < 0.0 {
            true => self.each(|value| -value),
            false => self.clone(),
        }
    }

    /// log₂ of its size, roughly; −∞ for 0.
    pub(super) fn log2(&self) -> f64 {
        self.ball(8).log2()
    }
}

impl From<BigRational> for PiPolynomial {
    fn from(value: BigRational) -> PiPolynomial {
        let coefficients = vec![value];
        PiPolynomial { coefficients }.trimmed()
    }
}

impl AddAssign for PiPolynomial {
    fn add_assign(&mut self, other: PiPolynomial) {
        let count = self.coefficients.len().max(other.coefficients.len());
        self.coefficients.resize(count, BigRational::zero());
        for (sum, value) in self.coefficients.iter_mut().zip(other.coefficients) {
            *sum += value;
        }
        *self = std::mem::take(self).trimmed();
    }
}

impl Add for PiPolynomial {
    type Output = PiPolynomial;

    fn add(mut self, other: PiPolynomial) -> PiPolynomial {
        self += other;
        self
    }
}

impl Mul<&BigRational> for &PiPolynomial {
    type Output = PiPolynomial;

    fn mul(self, factor: &BigRational) -> PiPolynomial {
        self.each(|value| value * factor).trimmed()
    }
}

impl Mul for &PiPolynomial {
    type Output = PiPolynomial;

    fn mul(self, other: &PiPolynomial) -> PiPolynomial {
        let count = self.coefficients.len() + other.coefficients.len();
        let mut coefficients = vec![BigRational::zero(); count];
        for (i, a) in self.coefficients.iter().enumerate() {
            for (j, b) in other.coefficients.iter().enumerate() {
                coefficients[i + j] += a * b;
            }
        }
        PiPolynomial { coefficients }.trimmed()
    }
}

impl Mul for PiPolynomial {
    type Output = PiPolynomial;

    fn mul(self, other: PiPolynomial) -> PiPolynomial {
        &self * &other
    }
}

impl Zero for PiPolynomial {
    fn zero() -> PiPolynomial {
        PiPolynomial::default()
    }

    fn is_zero(&self) -> bool {
        self.coefficients.is_empty()
    }
}

impl One for PiPolynomial {
    fn one() -> PiPolynomial {
        BigRational::one().into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::equation::exactly;

    /// π³ − 31 = 0.00627…, from mpmath with 40 digits.
    #[test]
    fn what_nearly_cancels_keeps_its_digits() {
        let pi = PiPolynomial::times_pi(BigRational::one());
        let cube = &(&pi * &pi) * &pi;
        let rest = cube + exactly(-31.0).into();
        let ball = rest.ball(120);
        let wanted = "6.276680299820175476315067101395202e-3";
        assert_eq!(ball.to_decimal(34), wanted);
        assert!(ball.radius_log2() < ball.log2() - 100.0);
        assert_eq!(rest.abs(), rest);
        let negative = &rest * &exactly(-2.0);
        assert_eq!(negative.abs(), rest.shifted(1));
    }

    #[test]
    fn what_cancels_is_0() {
        let third = BigRational::new(1.into(), 3.into());
        let pi = PiPolynomial::times_pi(third);
        let mut sum = &pi * &exactly(3.0);
        sum += PiPolynomial::times_pi(exactly(-1.0));
        assert!(sum.is_zero() && sum.log2() == f64::NEG_INFINITY);
        assert_eq!(pi.rational(), None);
        assert_eq!(
            PiPolynomial::from(exactly(2.5)).rational(),
            Some(exactly(2.5))
        );
    }
}
