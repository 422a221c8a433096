//! Whole numbers from their remainders modulo primes (the Chinese remainder theorem, one prime at a
//! time: H. L. Garner, *The residue number system*, 1959).

use num_bigint::BigInt;
use num_traits::{One, Zero};

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
}
