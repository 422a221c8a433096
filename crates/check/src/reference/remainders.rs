//! Whole numbers from their remainders modulo primes (the Chinese remainder theorem, one prime at a
//! time: H. L. Garner, *The residue number system*, 1959).

use num_bigint::BigInt;
use num_traits::{One, Signed, Zero};

use super::prime_field::PrimeField;

/// A list of whole numbers known modulo a product of primes.
#[derive(Clone, Debug)]
pub(super) struct Remainders {
    values: Vec<BigInt>,
    modulus: BigInt,
}

impl Remainders {
    pub(super) fn none(count: usize) -> Remainders {
        Remainders {
            values: vec![BigInt::zero(); count],
            modulus: BigInt::one(),
        }
    }

    pub(super) fn modulus(&self) -> &BigInt {
        &self.modulus
    }

    /// Adds the remainders modulo a prime that was not used before.
    pub(super) fn add(&mut self, field: PrimeField, remainders: &[u64]) {
        let inverse = field.inverse(field.of(&self.modulus));
        for (value, remainder) in self.values.iter_mut().zip(remainders) {
            let missing = field.minus(*remainder, field.of(value));
            *value += &self.modulus * field.times(missing, inverse);
        }
        self.modulus *= field.prime();
    }

    /// The numbers of least size with these remainders.
    pub(super) fn least(&self) -> Vec<BigInt> {
        let half = &self.modulus >> 1;
        let least = |value: &BigInt| match *value > half {
            true => value - &self.modulus,
            false => value.clone(),
        };
        self.values.iter().map(least).collect()
    }

    /// The fractions with these remainders whose numerators and denominators are at most the root of half of the modulus: there is
    /// one at most for each (P. S. Wang, *A p-adic algorithm for univariate partial fractions*, SYMSAC 1981). `None` where one has none.
    pub(super) fn fractions(&self) -> Option<Vec<(BigInt, BigInt)>> {
        let half: BigInt = &self.modulus >> 1;
        let most = half.sqrt();
        let fraction = |value: &BigInt| {
            let (mut before, mut now) = (self.modulus.clone(), value.clone());
            let (mut below_before, mut below) = (BigInt::zero(), BigInt::one());
            while now > most {
                let quotient = &before / &now;
                let next = &before - &quotient * &now;
                (before, now) = (now, next);
                let next = &below_before - &quotient * &below;
                (below_before, below) = (below, next);
            }
            match below.is_negative() {
                _ if below.abs() > most => None,
                true => Some((-now, -below)),
                false => Some((now, below)),
            }
        };
        self.values.iter().map(fraction).collect()
    }
}
