//! Arithmetic modulo a prime p below 2^62, by Montgomery's products (1985, *Math. Comp.* 44).
//!
//! A sum of products of doubles has an exact image modulo p, for 2 has an inverse there. An image
//! other than 0 proves that the number is not 0. Images of 0 modulo primes whose product exceeds
//! the number's size as an integer prove that it is.

use super::sum::Parts;

/// Every prime used lies above 2^PRIME_BITS: so many bits of a number are settled by one of them.
pub(crate) const PRIME_BITS: u64 = 60;

/// The most multiplications spent on one proof: below a second.
pub(crate) const MOST_WORK: u64 = 200_000_000;

/// How far below 2^61 the first primes lie: those that small systems need, without a search.
const BELOW: [u64; 16] = [
    1, 31, 45, 229, 259, 283, 339, 391, 403, 465, 531, 579, 675, 759, 799, 819,
];

/// An element of a [`PrimeField`], held as its product with 2^64.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Residue(u64);

impl Residue {
    pub(crate) const ZERO: Residue = Residue(0);

    pub(crate) fn is_zero(self) -> bool {
        self.0 == 0
    }
}

/// The integers modulo a prime.
#[derive(Clone, Debug)]
pub(crate) struct PrimeField {
    prime: u64,
    /// −1/prime modulo 2^64.
    negative_inverse: u64,
    /// 2^128 modulo prime.
    square: u64,
    /// 2^(64 i − 1088) for i = 0, 1, ….
    powers: [Residue; 33],
}

impl PrimeField {
    /// The fields of the largest primes below 2^61, downwards, from the Mersenne prime 2^61 − 1.
    pub(crate) fn all() -> impl Iterator<Item = PrimeField> {
        let known = BELOW
            .iter()
            .map(|&below| PrimeField::modulo((1 << 61) - below));
        let beyond = PrimeField::search(BELOW[BELOW.len() - 1] + 2);
        known.chain(beyond).map(PrimeField::with_powers)
    }

    /// The field of 2^61 − 1.
    pub(crate) fn first() -> PrimeField {
        PrimeField::modulo((1 << 61) - 1).with_powers()
    }

    /// The primes from 2^61 − below downwards, for an odd number.
    fn search(below: u64) -> impl Iterator<Item = PrimeField> {
        (below..)
            .step_by(2)
            .map(|below| PrimeField::modulo((1 << 61) - below))
            .filter(PrimeField::is_prime)
    }

    /// The ring modulo an odd number, without its powers of two.
    fn modulo(modulus: u64) -> PrimeField {
        // Newton's iteration doubles the number of right bits, from 3.
        let inverse = (0..5).fold(modulus, |x, _| {
            x.wrapping_mul(2u64.wrapping_sub(modulus.wrapping_mul(x)))
        });
        let wide = u128::from(modulus);
        let once = (1 << 64) % wide;
        PrimeField {
            prime: modulus,
            negative_inverse: inverse.wrapping_neg(),
            square: (once * once % wide) as u64,
            powers: [Residue::ZERO; 33],
        }
    }

    fn with_powers(self) -> PrimeField {
        let step = Residue(self.square);
        let mut power = self.inverse(self.power(self.integer(2), 1088));
        let powers = self.powers.map(|_| {
            let place = power;
            power = self.product(power, step);
            place
        });
        PrimeField { powers, ..self }
    }

    /// Miller and Rabin's test; these bases decide every number below 3·10^24 (Sorenson & Webster
    /// 2017, *Math. Comp.* 86).
    fn is_prime(&self) -> bool {
        let one = self.integer(1);
        let minus_one = self.negative(one);
        let twos = (self.prime - 1).trailing_zeros();
        [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37]
            .iter()
            .all(|&base| {
                let mut power = self.power(self.integer(base), (self.prime - 1) >> twos);
                let mut passes = power == one || power == minus_one;
                for _ in 1..twos {
                    power = self.product(power, power);
                    passes |= power == minus_one;
                }
                passes
            })
    }

    fn reduce(&self, value: u128) -> Residue {
        let factor = (value as u64).wrapping_mul(self.negative_inverse);
        let reduced = ((value + u128::from(factor) * u128::from(self.prime)) >> 64) as u64;
        Residue(if reduced >= self.prime {
            reduced - self.prime
        } else {
            reduced
        })
    }

    /// The image of an integer.
    pub(crate) fn integer(&self, value: u64) -> Residue {
        self.reduce(u128::from(value) * u128::from(self.square))
    }

    /// The integer nearest to 0 with this image.
    pub(crate) fn signed(&self, a: Residue) -> i64 {
        let value = self.reduce(u128::from(a.0)).0;
        if value > self.prime / 2 {
            -((self.prime - value) as i64)
        } else {
            value as i64
        }
    }

    /// The image of a finite double, exactly.
    pub(crate) fn double(&self, value: f64) -> Residue {
        let parts = Parts::of(value);
        if parts.mantissa == 0 {
            return Residue::ZERO;
        }
        let shift = (parts.exponent + 1088) as usize;
        let scale = self.product(self.powers[shift / 64], self.integer(1 << (shift % 64)));
        let size = self.product(self.integer(parts.mantissa), scale);
        if parts.negative {
            self.negative(size)
        } else {
            size
        }
    }

    /// The image of a sum of finite doubles, exactly.
    pub(crate) fn sum_of(&self, terms: &[f64]) -> Residue {
        terms
            .iter()
            .fold(Residue::ZERO, |sum, &term| self.sum(sum, self.double(term)))
    }

    pub(crate) fn sum(&self, a: Residue, b: Residue) -> Residue {
        let sum = a.0 + b.0;
        Residue(if sum >= self.prime {
            sum - self.prime
        } else {
            sum
        })
    }

    pub(crate) fn negative(&self, a: Residue) -> Residue {
        Residue(if a.0 == 0 { 0 } else { self.prime - a.0 })
    }

    pub(crate) fn difference(&self, a: Residue, b: Residue) -> Residue {
        self.sum(a, self.negative(b))
    }

    pub(crate) fn product(&self, a: Residue, b: Residue) -> Residue {
        self.reduce(u128::from(a.0) * u128::from(b.0))
    }

    /// Σ a_i b_i, over the shorter of the two.
    pub(crate) fn dot(&self, a: &[Residue], b: &[Residue]) -> Residue {
        /// Products of numbers below 2^61 that are summed before they are reduced: less than 2^125.
        const AT_ONCE: usize = 7;
        let chunks = a.chunks(AT_ONCE).zip(b.chunks(AT_ONCE));
        chunks.fold(Residue::ZERO, |sum, (a, b)| {
            let pairs = a.iter().zip(b);
            let part = pairs.map(|(a, b)| u128::from(a.0) * u128::from(b.0)).sum();
            self.sum(sum, self.reduce(part))
        })
    }

    fn power(&self, base: Residue, exponent: u64) -> Residue {
        let bits = u64::BITS - exponent.leading_zeros();
        (0..bits).rev().fold(self.integer(1), |power, bit| {
            let square = self.product(power, power);
            if exponent >> bit & 1 == 1 {
                self.product(square, base)
            } else {
                square
            }
        })
    }

    /// 1/a, for a other than 0 (Fermat).
    pub(crate) fn inverse(&self, a: Residue) -> Residue {
        self.power(a, self.prime - 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn by_trial(number: u64) -> bool {
        number >= 2
            && (2..)
                .take_while(|d| d * d <= number)
                .all(|d| !number.is_multiple_of(d))
    }

    #[test]
    fn primes_are_distinguished_from_composites() {
        for odd in (41..20_001).step_by(2) {
            assert_eq!(PrimeField::modulo(odd).is_prime(), by_trial(odd), "{odd}");
        }
        // Strong pseudoprimes to the bases 2, 3, 5 and 7, and to all below 31 (Jaeschke 1993).
        for composite in [
            3_215_031_751,
            341_550_071_728_321,
            3_825_123_056_546_413_051,
        ] {
            assert!(!PrimeField::modulo(composite).is_prime());
        }
    }

    #[test]
    fn the_primes_descend_from_the_mersenne_one() {
        let below = |field: PrimeField| (1 << 61) - field.prime;
        let searched: Vec<u64> = PrimeField::search(1).take(40).map(below).collect();
        assert_eq!(
            PrimeField::all().take(40).map(below).collect::<Vec<_>>(),
            searched
        );
        assert!(
            PrimeField::all()
                .take(300)
                .all(|field| field.prime >> PRIME_BITS > 0)
        );
    }

    proptest! {
        #[test]
        fn the_field_laws_hold(a in any::<u64>(), b in any::<u64>(), c in any::<u64>(), skip in 0usize..5) {
            let f = PrimeField::all().nth(skip).unwrap();
            let wide = |x: u128| f.integer((x % u128::from(f.prime)) as u64);
            let (x, y, z) = (f.integer(a), f.integer(b), f.integer(c));
            prop_assert_eq!(f.product(x, y), wide(u128::from(a) * u128::from(b)));
            prop_assert_eq!(f.sum(x, y), wide(u128::from(a) + u128::from(b)));
            prop_assert_eq!(f.product(x, f.sum(y, z)), f.sum(f.product(x, y), f.product(x, z)));
            prop_assert_eq!(f.sum(f.difference(x, y), y), x);
            let largest = f.negative(f.integer(1));
            for (a, b) in [(vec![x; 23], vec![y; 23]), (vec![largest; 23], vec![largest; 23]), (vec![y], vec![z, x])] {
                let each = a.iter().zip(&b);
                let sum = each.fold(Residue::ZERO, |sum, (&a, &b)| f.sum(sum, f.product(a, b)));
                prop_assert_eq!(f.dot(&a, &b), sum);
            }
            if !x.is_zero() {
                prop_assert_eq!(f.product(x, f.inverse(x)), f.integer(1));
            }
        }

        #[test]
        fn images_of_doubles_respect_scaling(bits in any::<u64>()) {
            let x = f64::from_bits(bits);
            prop_assume!(x.is_finite());
            let f = PrimeField::first();
            prop_assert_eq!(f.double(-x), f.negative(f.double(x)));
            let doubled = x * 2.0;
            if doubled.is_finite() {
                prop_assert_eq!(f.double(doubled), f.sum(f.double(x), f.double(x)));
            }
        }
    }

    #[test]
    fn images_of_doubles_are_those_of_their_integers() {
        let f = PrimeField::first();
        assert_eq!(f.double(12345.0), f.integer(12345));
        assert_eq!(f.sum(f.double(0.75), f.double(0.25)), f.integer(1));
        assert_eq!(
            f.product(f.double(2f64.powi(-537)), f.double(2f64.powi(-537))),
            f.double(f64::from_bits(1))
        );
        assert_eq!(
            f.product(f.double(2f64.powi(1000)), f.double(2f64.powi(-1000))),
            f.integer(1)
        );
        assert!(f.sum_of(&[0.1, 0.2, -0.3, -(2f64.powi(-55))]).is_zero());
    }
}
