//! How many different roots det(λ²M + λC + K) has, in exact arithmetic.
//!
//! A polynomial P of degree N has N − deg gcd(P, P′) different roots. With g the degree of the gcd, the principal
//! subresultant coefficient s_g of P and P′ is the first of s_0, s_1, … that is not 0 (Brown & Traub 1971,
//! *J. ACM* 18). Modulo a prime that keeps the degree, the gcd has the degree of the first s_j that the prime does not divide.
//! Where it has degree k or more modulo primes whose product exceeds s_0, …, s_{k−1}, all of these vanish.

use super::coefficients::Coefficients;
use super::determinant::{bounds, common_shift};
use super::polynomial::Reduced;
use crate::exact::prime_field::{PRIME_BITS, PrimeField, Residue};
use crate::exact::sum::ceil_log2;

/// One factor of the polynomial, with what is known of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Factor<'a> {
    pub(crate) coefficients: &'a Coefficients,
    /// The exact degree, and the exact order at λ = 0.
    pub(crate) degree: usize,
    pub(crate) zeros: usize,
    /// Whether it is taken as a polynomial in λ², which it is without damping.
    pub(crate) in_square: bool,
}

impl Factor<'_> {
    fn step(&self) -> usize {
        if self.in_square { 2 } else { 1 }
    }

    /// The degree once the roots 0 are divided out.
    fn degree(&self) -> usize {
        (self.degree - self.zeros) / self.step()
    }

    /// P/λ^zeros modulo a prime, given a bound on the degree.
    fn reduced(&self, field: &PrimeField, bound: usize) -> Vec<Residue> {
        let all = Reduced::new(self.coefficients, field).coefficients(bound);
        let kept = all.into_iter().take(self.degree + 1).skip(self.zeros);
        kept.step_by(self.step()).collect()
    }
}

/// Whether the product of the factors is proved to have no more than `count` different roots other than 0, with at
/// most so many multiplications.
pub(crate) fn are_at_most(factors: &[Factor<'_>], count: usize, most_work: u64) -> bool {
    let degree: usize = factors.iter().map(Factor::degree).sum();
    if degree <= count {
        return true;
    }
    let product = Product::of(factors);
    // ‖P‖ ≤ 2^size, so that Hadamard's inequality gives |s_j| ≤ ‖P‖^(N−1) (N‖P‖)^N.
    let size: u64 = product.bounds.iter().map(|(_, bits)| bits).sum();
    let n = degree as u64;
    let bits = (2 * n - 1) * size + n * ceil_log2(degree) as u64;
    let mut primes = bits / PRIME_BITS + 1;
    for (tried, field) in PrimeField::all().enumerate() {
        if tried == 0 && product.work(&field).saturating_mul(primes) > most_work {
            return false;
        }
        match product.different(&field) {
            None => continue,
            Some(different) if different > count => return false,
            Some(_) => primes -= 1,
        }
        if primes == 0 {
            break;
        }
    }
    true
}

/// Whether it is proved to have no fewer.
pub(crate) fn are_at_least(factors: &[Factor<'_>], count: usize) -> bool {
    let product = Product::of(factors);
    let mut fields = PrimeField::all().take(2);
    fields.any(|field| {
        product
            .different(&field)
            .is_some_and(|found| found >= count)
    })
}

struct Product<'a> {
    factors: &'a [Factor<'a>],
    /// Of each: a bound on the degree, and how many bits the sum of the coefficients' sizes has.
    bounds: Vec<(usize, u64)>,
}

impl<'a> Product<'a> {
    fn of(factors: &'a [Factor<'a>]) -> Product<'a> {
        let all: Vec<&Coefficients> = factors.iter().map(|factor| factor.coefficients).collect();
        let shift = common_shift(&all);
        Product {
            factors,
            bounds: all.into_iter().map(|one| bounds(one, shift)).collect(),
        }
    }

    /// Multiplications for one prime.
    fn work(&self, field: &PrimeField) -> u64 {
        let degree: usize = self.factors.iter().map(Factor::degree).sum();
        let each = self.factors.iter().zip(&self.bounds);
        let each = each.map(|(factor, (bound, _))| {
            let points = *bound as u64 + 1;
            points * (Reduced::new(factor.coefficients, field).at(2).work + 2 * points)
        });
        each.sum::<u64>() + (degree * degree) as u64
    }

    /// How many roots differ modulo a prime, which is no more than in truth; `None` where it does not keep the degree.
    fn different(&self, field: &PrimeField) -> Option<usize> {
        let mut product = vec![field.integer(1)];
        for (factor, (bound, _)) in self.factors.iter().zip(&self.bounds) {
            product = times(field, &product, &factor.reduced(field, *bound));
        }
        let degree = product.len() - 1;
        (!product[degree].is_zero()).then(|| degree - common_degree(field, product))
    }
}

fn times(f: &PrimeField, a: &[Residue], b: &[Residue]) -> Vec<Residue> {
    let mut product = vec![Residue::ZERO; a.len() + b.len() - 1];
    for (i, &x) in a.iter().enumerate() {
        for (j, &y) in b.iter().enumerate() {
            product[i + j] = f.sum(product[i + j], f.product(x, y));
        }
    }
    product
}

/// The degree of gcd(P, P′), by Euclid's algorithm, for P of its full degree by rising powers.
fn common_degree(f: &PrimeField, p: Vec<Residue>) -> usize {
    let slope = p.iter().enumerate().skip(1);
    let slope = slope.map(|(power, &value)| f.product(f.integer(power as u64), value));
    let (mut a, mut b) = (p.clone(), slope.collect::<Vec<_>>());
    loop {
        while b.last().is_some_and(|last| last.is_zero()) {
            b.pop();
        }
        let Some(&lead) = b.last() else {
            return a.len() - 1;
        };
        let inverse = f.negative(f.inverse(lead));
        while a.len() >= b.len() {
            let factor = f.product(a[a.len() - 1], inverse);
            let at = a.len() - b.len();
            for (value, &other) in a[at..].iter_mut().zip(&b) {
                *value = f.sum(*value, f.product(factor, other));
            }
            a.pop();
        }
        std::mem::swap(&mut a, &mut b);
    }
}

#[cfg(test)]
mod tests {
    use super::super::determinant::Roots;
    use super::super::samples::{matrices, network, triple_defect};
    use super::*;
    use crate::exact::prime_field::MOST_WORK;
    use crate::system::System;
    use faer::{Mat, mat};

    /// The least number for which it is proved.
    fn different(systems: &[&System]) -> usize {
        let all: Vec<Coefficients> = systems
            .iter()
            .map(|s| Coefficients::of(s.model()))
            .collect();
        let factor = |coefficients| {
            let Roots { zero, finite } = Roots::of(coefficients);
            Factor {
                coefficients,
                degree: finite.unwrap(),
                zeros: zero.unwrap(),
                in_square: false,
            }
        };
        let factors: Vec<Factor<'_>> = all.iter().map(factor).collect();
        let most = factors.iter().map(|f| f.degree - f.zeros).sum::<usize>();
        let proved = |count: &usize| are_at_most(&factors, *count, MOST_WORK);
        let count = (0..=most).find(proved).unwrap();
        assert!(are_at_least(&factors, count) && !are_at_least(&factors, count + 1));
        count
    }

    #[test]
    fn coinciding_roots_are_counted_once() {
        let oscillator = |m, c, k| network(&[m], &[(0, 1, k)], &[(0, 1, c)]);
        let critical = oscillator(1.0, 2.0, 1.0);
        let nearly = oscillator(1.0, 2.0 + 4.0 * f64::EPSILON, 1.0);
        assert_eq!(different(&[&critical]), 1);
        assert_eq!(different(&[&nearly]), 2);
        assert_eq!(different(&[&critical, &critical]), 1);
        assert_eq!(different(&[&critical, &nearly]), 3);
        assert_eq!(different(&[&critical, &oscillator(1.0, 3.0, 2.0)]), 2);
        assert_eq!(different(&[&triple_defect()]), 1);
        // Irrational ones, and far from 1.
        let far = oscillator(3e-40, 0.0, 1e7);
        assert_eq!(different(&[&far, &oscillator(6e-40, 0.0, 2e7)]), 2);
        assert_eq!(different(&[&far, &oscillator(3e-40, 0.0, 2e7)]), 4);
        assert_eq!(different(&[&network(&[2.0, 3.0], &[], &[(1, 2, 5.0)])]), 1);
    }

    #[test]
    fn an_ulp_separates_roots() {
        // −1 twice, −1 ± 4.2e-8, −0.9999999999999991 ± 4.2e-8i.
        let m = mat![[2.0, 0.0, -1.0], [0.0, 1.0, 2.0], [-1.0, 2.0, 5.0]];
        let mut c = &m * faer::Scale(2.0);
        c[(0, 2)] = -2.0000000000000018;
        c[(2, 0)] = c[(0, 2)];
        c[(2, 2)] = 10.000000000000002;
        assert_eq!(different(&[&matrices(m.clone(), c, m.clone())]), 5);
        assert_eq!(
            different(&[&matrices(m.clone(), &m * faer::Scale(2.0), m)]),
            1
        );
    }

    #[test]
    fn what_is_too_much_work_is_not_proved() {
        let critical = network(&[1.0], &[(0, 1, 1.0)], &[(0, 1, 2.0)]);
        let coefficients = Coefficients::of(critical.model());
        let factor = Factor {
            coefficients: &coefficients,
            degree: 2,
            zeros: 0,
            in_square: false,
        };
        assert!(are_at_most(&[factor], 1, MOST_WORK));
        assert!(!are_at_most(&[factor], 1, 10));
        assert!(are_at_most(&[factor], 2, 10));
    }

    #[test]
    fn squares_stand_for_pairs() {
        let identity = Mat::<f64>::identity(2, 2);
        let system = matrices(identity.clone(), Mat::zeros(2, 2), identity);
        let coefficients = Coefficients::of(system.model());
        let factor = |in_square| Factor {
            coefficients: &coefficients,
            degree: 4,
            zeros: 0,
            in_square,
        };
        assert!(are_at_most(&[factor(true)], 1, MOST_WORK));
        assert!(!are_at_most(&[factor(false)], 1, MOST_WORK));
    }
}
