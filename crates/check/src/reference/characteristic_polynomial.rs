//! det(λ²M + λC + K), exactly: evaluated at whole numbers modulo many primes, interpolated, and put
//! together (J. von zur Gathen and J. Gerhard, *Modern Computer Algebra*, §5.5).

use eigentone_modes::System;
use num_bigint::BigInt;
use num_integer::Integer;
use num_traits::{One, Signed, Zero};

use super::equation::Equation;
use super::integer_polynomial::IntegerPolynomial;
use super::prime_field::PrimeField;
use super::rational_matrix::RationalMatrix;
use super::remainders::Remainders;

/// λ²M + λC + K with each row multiplied so that its entries are whole numbers.
pub(super) struct WholePencil {
    /// For each entry of the pencil, by rows, the coefficients of 1, λ and λ².
    entries: Vec<Vec<[BigInt; 3]>>,
}

impl WholePencil {
    pub(super) fn of(system: &System) -> WholePencil {
        let Equation {
            mass,
            damping,
            stiffness,
        } = Equation::of(system);
        let parts = [&stiffness, &damping, &mass];
        let n = system.len();
        let rows = (0..n).map(|i| {
            // In lowest terms: the least common denominator, then no common factor.
            let all = || {
                parts
                    .iter()
                    .flat_map(|part| (0..n).map(move |j| part.at(i, j)))
            };
            let denominator = all().fold(BigInt::one(), |lcm, entry| lcm.lcm(entry.denom()));
            let whole = |part: &RationalMatrix, j: usize| {
                let entry = part.at(i, j);
                entry.numer() * (&denominator / entry.denom())
            };
            let row: Vec<[BigInt; 3]> = (0..n).map(|j| parts.map(|part| whole(part, j))).collect();
            let common = row
                .iter()
                .flatten()
                .fold(BigInt::default(), |gcd, entry| gcd.gcd(entry));
            let divided = |entry: [BigInt; 3]| entry.map(|part| part / &common);
            row.into_iter().map(divided).collect()
        });
        WholePencil {
            entries: rows.collect(),
        }
    }

    /// Its value at a whole number, by rows.
    pub(super) fn at(&self, point: &BigInt) -> Vec<Vec<BigInt>> {
        let value = |[k, c, m]: &[BigInt; 3]| k + point * (c + point * m);
        let rows = self.entries.iter();
        rows.map(|row| row.iter().map(value).collect()).collect()
    }

    fn nonzeros(&self) -> impl Iterator<Item = (usize, usize, &[BigInt; 3])> {
        let rows = self.entries.iter().enumerate();
        let entries = rows.flat_map(|(i, row)| row.iter().enumerate().map(move |(j, e)| (i, j, e)));
        entries.filter(|(_, _, entry)| entry.iter().any(|part| !part.is_zero()))
    }

    /// A bound of the sum of all coefficients' sizes: the product of the sums of sizes along rows.
    fn bound(&self) -> BigInt {
        let row = |row: &Vec<[BigInt; 3]>| row.iter().flatten().map(BigInt::abs).sum::<BigInt>();
        self.entries.iter().map(row).product()
    }

    /// About how many multiplications modulo primes [`polynomial`](Self::polynomial) takes.
    pub(super) fn work(&self) -> f64 {
        let n = self.entries.len() as f64;
        let density = self.nonzeros().count() as f64 / (n * n);
        let determinant = n.powi(3) / 3.0 * density + 3.0 * n * n;
        (2.0 * n + 1.0) * determinant * self.bound().bits() as f64 / 31.0
    }

    /// The characteristic polynomial, but for a constant factor.
    pub(super) fn polynomial(&self) -> IntegerPolynomial {
        let n = self.entries.len();
        let points = 2 * n + 1;
        let enough = self.bound() * 2 + 1;
        let mut coefficients = Remainders::none(points);
        for field in PrimeField::all() {
            if *coefficients.modulus() >= enough {
                break;
            }
            let reduced: Vec<(usize, usize, [u64; 3])> = self
                .nonzeros()
                .map(|(i, j, entry)| (i, j, entry.each_ref().map(|part| field.of(part))))
                .collect();
            let value = |point: u64| {
                let mut matrix = vec![vec![0; n]; n];
                for (i, j, [k, c, m]) in &reduced {
                    let inner = field.plus(*c, field.times(*m, point));
                    matrix[*i][*j] = field.plus(*k, field.times(inner, point));
                }
                field.determinant(matrix)
            };
            let values: Vec<u64> = (0..points as u64).map(value).collect();
            coefficients.add(field, &field.interpolate(&values));
        }
        IntegerPolynomial::new(coefficients.least())
    }
}
