//! Whole numbers modulo a prime below 2^31, and polynomials over them.

use num_bigint::BigInt;
use num_integer::Integer;
use num_traits::ToPrimitive;

/// The whole numbers modulo a prime.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PrimeField {
    prime: u64,
}

impl PrimeField {
    /// Fields with different primes, from the largest below 2^31 down.
    pub(super) fn all() -> impl Iterator<Item = PrimeField> {
        let odd = (3..1u64 << 31).rev().step_by(2);
        odd.filter(|number| is_prime(*number))
            .map(|prime| PrimeField { prime })
    }

    pub(super) fn prime(self) -> u64 {
        self.prime
    }

    pub(super) fn of(self, number: &BigInt) -> u64 {
        let rest = number.mod_floor(&BigInt::from(self.prime));
        rest.to_u64().expect("below the prime")
    }

    pub(super) fn plus(self, a: u64, b: u64) -> u64 {
        (a + b) % self.prime
    }

    pub(super) fn minus(self, a: u64, b: u64) -> u64 {
        (a + self.prime - b) % self.prime
    }

    pub(super) fn times(self, a: u64, b: u64) -> u64 {
        a * b % self.prime
    }

    /// 1/a for a ≠ 0, as a^(p−2).
    pub(super) fn inverse(self, a: u64) -> u64 {
        self.power(a, self.prime - 2)
    }

    fn power(self, a: u64, mut exponent: u64) -> u64 {
        let (mut power, mut square) = (1, a % self.prime);
        while exponent > 0 {
            if exponent % 2 == 1 {
                power = self.times(power, square);
            }
            square = self.times(square, square);
            exponent /= 2;
        }
        power
    }

    /// The determinant of a square matrix, by elimination.
    pub(super) fn determinant(self, mut matrix: Vec<Vec<u64>>) -> u64 {
        let n = matrix.len();
        let mut product = 1;
        for k in 0..n {
            let Some(pivot) = (k..n).find(|i| matrix[*i][k] != 0) else {
                return 0;
            };
            if pivot != k {
                matrix.swap(pivot, k);
                product = self.minus(0, product);
            }
            product = self.times(product, matrix[k][k]);
            let inverse = self.inverse(matrix[k][k]);
            let (above, below) = matrix.split_at_mut(k + 1);
            let leading = &above[k];
            for row in below.iter_mut().filter(|row| row[k] != 0) {
                let factor = self.minus(0, self.times(row[k], inverse));
                for (entry, above) in row[k..].iter_mut().zip(&leading[k..]) {
                    if *above != 0 {
                        *entry = (*entry + factor * above) % self.prime;
                    }
                }
            }
        }
        product
    }

    /// The coefficients, lowest first, of the polynomial that takes `values` at 0, 1, 2, …
    /// (Newton's divided differences).
    pub(super) fn interpolate(self, values: &[u64]) -> Vec<u64> {
        let n = values.len();
        let mut differences = values.to_vec();
        for order in 1..n {
            let inverse = self.inverse(order as u64);
            for i in (order..n).rev() {
                let difference = self.minus(differences[i], differences[i - 1]);
                differences[i] = self.times(difference, inverse);
            }
        }
        let mut polynomial = vec![0; n];
        for (i, difference) in differences.iter().enumerate().rev() {
            // p ← p·(x − i) + difference
            for k in (0..n).rev() {
                let shifted = if k > 0 {
                    polynomial[k - 1]
                } else {
                    *difference
                };
                let scaled = self.times(polynomial[k], i as u64);
                polynomial[k] = self.minus(shifted, scaled);
            }
        }
        polynomial
    }

    /// The greatest common divisor of two polynomials, lowest coefficients first, with leading
    /// coefficient 1; empty if both are 0.
    pub(super) fn common_divisor(self, mut a: Vec<u64>, mut b: Vec<u64>) -> Vec<u64> {
        trim(&mut a);
        trim(&mut b);
        while let Some(&leading) = b.last() {
            let inverse = self.inverse(leading);
            while a.len() >= b.len() {
                let factor = self.times(a[a.len() - 1], inverse);
                let shift = a.len() - b.len();
                for (entry, divisor) in a[shift..].iter_mut().zip(&b) {
                    *entry = self.minus(*entry, self.times(factor, *divisor));
                }
                trim(&mut a);
            }
            std::mem::swap(&mut a, &mut b);
        }
        let inverse = a.last().map_or(0, |leading| self.inverse(*leading));
        a.iter().map(|entry| self.times(*entry, inverse)).collect()
    }
}

fn trim(polynomial: &mut Vec<u64>) {
    while polynomial.last() == Some(&0) {
        polynomial.pop();
    }
}

/// Whether an odd number from 3 to 2^31 is prime: no composite one below 3.2e9 passes the test of Miller and Rabin to the bases 2, 3,
/// 5 and 7 (G. Jaeschke, *On strong pseudoprimes to several bases*, Math. Comp. 61, 1993).
fn is_prime(number: u64) -> bool {
    let twos = (number - 1).trailing_zeros();
    let field = PrimeField { prime: number };
    [2, 3, 5, 7].into_iter().all(|base| {
        let mut power = field.power(base, (number - 1) >> twos);
        let mut passes = power == 1 || base % number == 0;
        for _ in 0..twos {
            passes |= power == number - 1;
            power = field.times(power, power);
        }
        passes
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn primes_are_those_of_trial_division() {
        let by_division = |number: u64| {
            let mut divisors = (3..).step_by(2).take_while(|d| d * d <= number);
            divisors.all(|divisor| !number.is_multiple_of(divisor))
        };
        // 2047 and 1 373 653 are strong pseudoprimes to the base 2, the second to 3 too; 25 326 001 to 5 as well.
        let some = [2047, 1_373_653, 25_326_001, (1 << 31) - 1];
        let all = (3..5000).step_by(2).chain(some);
        for number in all.chain(((1u64 << 31) - 999..1 << 31).step_by(2)) {
            assert_eq!(is_prime(number), by_division(number), "{number}");
        }
    }
}
