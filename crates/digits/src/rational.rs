//! Exact witnesses for the tests.

use num_bigint::{BigInt, Sign};
use num_rational::BigRational;

use crate::{DoubleDouble, Magnitude, Wide};

/// integer·2^power.
pub(crate) fn integer(integer: BigInt, power: i64) -> BigRational {
    let factor = BigInt::from(1) << power.unsigned_abs();
    if power < 0 {
        BigRational::new(integer, factor)
    } else {
        BigRational::from(integer * factor)
    }
}

/// x·2^power.
pub(crate) fn dyadic(x: f64, power: i64) -> BigRational {
    BigRational::from_float(x).expect("finite") * integer(BigInt::from(1), power)
}

/// A number whose exact value is known.
pub(crate) trait Exact {
    fn exact(self) -> BigRational;
}

impl Exact for f64 {
    fn exact(self) -> BigRational {
        dyadic(self, 0)
    }
}

impl Exact for DoubleDouble {
    fn exact(self) -> BigRational {
        dyadic(self.high(), 0) + dyadic(self.low(), 0)
    }
}

impl Exact for Magnitude {
    fn exact(self) -> BigRational {
        let (mantissa, exponent) = self.parts();
        dyadic(mantissa, 512 * exponent)
    }
}

impl<const L: usize> Exact for Wide<L> {
    fn exact(self) -> BigRational {
        let (negative, exponent, limbs) = self.parts();
        let words: Vec<u32> = limbs
            .iter()
            .flat_map(|limb| [*limb as u32, (*limb >> 32) as u32])
            .collect();
        if words.iter().all(|word| *word == 0) {
            return BigRational::default();
        }
        let sign = if negative { Sign::Minus } else { Sign::Plus };
        integer(BigInt::from_slice(sign, &words), exponent - 64 * L as i64)
    }
}
