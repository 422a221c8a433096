//! Polynomials with whole coefficients.

use num_bigint::BigInt;
use num_integer::Integer;
use num_traits::{Signed, Zero};

use super::prime_field::PrimeField;
use super::remainders::Remainders;

/// A polynomial without a common factor of its coefficients, the leading one of which is positive.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct IntegerPolynomial {
    /// Lowest first; the last one is not 0.
    coefficients: Vec<BigInt>,
}

impl IntegerPolynomial {
    /// The polynomial with these coefficients, lowest first, but for a constant factor.
    pub(super) fn new(mut coefficients: Vec<BigInt>) -> IntegerPolynomial {
        while coefficients.last().is_some_and(BigInt::is_zero) {
            coefficients.pop();
        }
        let content = coefficients.iter().fold(BigInt::zero(), |content, c| {
            // Halving steps take long where one number is much longer.
            match content.is_zero() {
                true => c.abs(),
                false => content.gcd(&(c % &content)),
            }
        });
        let negative = coefficients.last().is_some_and(BigInt::is_negative);
        let content = if negative { -content } else { content };
        for coefficient in &mut coefficients {
            *coefficient /= &content;
        }
        IntegerPolynomial { coefficients }
    }

    pub(super) fn coefficients(&self) -> &[BigInt] {
        &self.coefficients
    }

    pub(super) fn degree(&self) -> usize {
        self.coefficients.len().saturating_sub(1)
    }

    pub(super) fn derivative(&self) -> IntegerPolynomial {
        let terms = self.coefficients.iter().enumerate().skip(1);
        IntegerPolynomial::new(terms.map(|(k, c)| c * k).collect())
    }

    /// p(−x).
    pub(super) fn mirrored(&self) -> IntegerPolynomial {
        let terms = self.coefficients.iter().enumerate();
        IntegerPolynomial::new(
            terms
                .map(|(k, c)| if k % 2 == 1 { -c } else { c.clone() })
                .collect(),
        )
    }

    /// The multiplicity of the root 0, and what is left when it is divided out.
    pub(super) fn without_zeros(&self) -> (usize, IntegerPolynomial) {
        let zeros = self.coefficients.iter().take_while(|c| c.is_zero()).count();
        let coefficients = self.coefficients[zeros..].to_vec();
        (zeros, IntegerPolynomial { coefficients })
    }

    /// q with p(x) = q(x²), where p has even powers only.
    pub(super) fn halved(&self) -> Option<IntegerPolynomial> {
        let even = self
            .coefficients
            .iter()
            .skip(1)
            .step_by(2)
            .all(BigInt::is_zero);
        even.then(|| IntegerPolynomial {
            coefficients: self.coefficients.iter().step_by(2).cloned().collect(),
        })
    }

    /// The quotient, where `divisor` divides it.
    pub(super) fn divided_by(&self, divisor: &IntegerPolynomial) -> Option<IntegerPolynomial> {
        let leading = divisor.coefficients.last()?;
        let mut rest = self.coefficients.clone();
        let count = (rest.len() + 1).checked_sub(divisor.coefficients.len())?;
        let mut quotient = vec![BigInt::zero(); count];
        for shift in (0..count).rev() {
            let (factor, left) = rest[shift + divisor.degree()].div_rem(leading);
            if !left.is_zero() {
                return None;
            }
            if !factor.is_zero() {
                for (entry, part) in rest[shift..].iter_mut().zip(&divisor.coefficients) {
                    *entry -= &factor * part;
                }
            }
            quotient[shift] = factor;
        }
        let exact = rest.iter().all(BigInt::is_zero);
        exact.then(|| IntegerPolynomial::new(quotient))
    }

    /// The greatest common divisor, from those modulo primes (W. S. Brown, *On Euclid's algorithm and
    /// the computation of polynomial greatest common divisors*, J. ACM 18, 1971). None modulo a prime
    /// has a lower degree, so that one that divides both is the greatest. Its coefficients beside the leading one
    /// are fractions, and are known as soon as there are twice as many digits as in these.
    pub(super) fn common_divisor(&self, other: &IntegerPolynomial) -> IntegerPolynomial {
        let mut found = Remainders::none(0);
        let mut degree = usize::MAX;
        let (mut count, mut enough) = (0usize, 1);
        for field in PrimeField::all() {
            if field.of(self.leading()) == 0 || field.of(other.leading()) == 0 {
                continue;
            }
            let reduced =
                |p: &IntegerPolynomial| p.coefficients.iter().map(|c| field.of(c)).collect();
            let divisor = field.common_divisor(reduced(self), reduced(other));
            if divisor.len() == 1 {
                return IntegerPolynomial::new(vec![BigInt::from(1)]);
            }
            if divisor.len() > degree {
                continue;
            }
            if divisor.len() < degree {
                degree = divisor.len();
                found = Remainders::none(degree);
                (count, enough) = (0, 1);
            }
            found.add(field, &divisor);
            count += 1;
            if count < enough {
                continue;
            }
            // A few more than half as many, so that trials take no more time than primes do.
            enough = count + count / 2 + 1;
            let candidate = found.fractions().map(over_one_denominator);
            let divides = |candidate: &IntegerPolynomial| {
                self.divided_by(candidate).is_some() && other.divided_by(candidate).is_some()
            };
            if let Some(candidate) = candidate.filter(divides) {
                return candidate;
            }
        }
        unreachable!("some prime does not divide what distinguishes the two")
    }

    fn leading(&self) -> &BigInt {
        self.coefficients.last().expect("no polynomial here is 0")
    }
}

/// The polynomial whose coefficients have these ratios.
fn over_one_denominator(fractions: Vec<(BigInt, BigInt)>) -> IntegerPolynomial {
    let denominators = fractions.iter().map(|(_, below)| below);
    let common = denominators.fold(BigInt::from(1), |common, below| common.lcm(below));
    let scaled = fractions
        .iter()
        .map(|(above, below)| above * (&common / below));
    IntegerPolynomial::new(scaled.collect())
}

/// Squarefree polynomials with the multiplicities of their roots (D. R. Musser, *Algorithms for
/// polynomial factorization*, 1971).
pub(super) fn squarefree(polynomial: &IntegerPolynomial) -> Vec<(IntegerPolynomial, usize)> {
    let mut factors = Vec::new();
    if polynomial.degree() == 0 {
        return factors;
    }
    let mut repeated = polynomial.common_divisor(&polynomial.derivative());
    let mut roots = polynomial.divided_by(&repeated).expect("it divides");
    for multiplicity in 1.. {
        if roots.degree() == 0 {
            break;
        }
        // Roots of higher multiplicity are those that the rest still has.
        let higher = match repeated.degree() {
            0 => repeated.clone(),
            _ => roots.common_divisor(&repeated),
        };
        let factor = roots.divided_by(&higher).expect("it divides");
        if factor.degree() > 0 {
            factors.push((factor, multiplicity));
        }
        repeated = repeated.divided_by(&higher).expect("it divides");
        roots = higher;
    }
    factors
}
