//! Undamped modes of a damped system: K x = ω²M x with C x = 0, as where every damper sits at a
//! node. With M ≻ 0 and C, K ⪰ 0 these are all the motions that neither decay nor rest, for
//! Re λ = 0 ≠ λ asks for x*Cx = 0. They and the rigid motions that nothing damps, ker K ∩ ker C, span
//! the largest subspace of ker C that A = M⁻¹K keeps, which is what no row of C, CA, CA², … sees.
//!
//! Modulo one prime, the rank of these rows leaves an upper bound on its dimension. It is proved to
//! be reached by a mirror symmetry whose motions C does not touch, or modulo many primes.

use super::coefficients::Coefficients;
use crate::exact::elimination::solve;
use crate::exact::matrix::{ExactMatrix, Image};
use crate::exact::prime_field::{MOST_WORK, PRIME_BITS, PrimeField, Residue};
use crate::exact::sum::ceil_log2;

/// How many there are with ω ≠ 0. `None` where it is not proved.
pub(crate) fn undamped_modes(coefficients: &Coefficients) -> Option<usize> {
    let Coefficients {
        mass,
        damping,
        stiffness,
        ..
    } = coefficients;
    let n = mass.matrix.len();
    let moving = stiffness.semidefinite_rank()?;
    let damped = damping.semidefinite_rank()?;
    if mass.semidefinite_rank()? < n {
        return None;
    }
    let rigid = n - damping.plus(stiffness).semidefinite_rank()?;
    if damped == 0 {
        return Some(moving);
    }
    if damped == n - rigid {
        return Some(0);
    }
    let parts = [&mass.matrix, &damping.matrix, &stiffness.matrix];
    let factor = if mass.matrix.is_diagonal() { 1 } else { 3 };
    if factor * (n as u64).pow(3) > MOST_WORK {
        return None;
    }
    let seen = PrimeField::all()
        .take(2)
        .find_map(|field| Seen::of(parts, &field))?;
    let unseen = n - seen.rank;
    let proved = unseen == rigid
        || coefficients
            .mirror()
            .is_some_and(|mirror| mirror.untouched(&damping.matrix) == unseen)
        || seen.is_all(parts);
    proved.then(|| unseen - rigid)
}

/// The rows of C, CA, CA², … modulo a prime.
struct Seen {
    /// How many of them are independent.
    rank: usize,
    /// The least power whose rows depend on those of lower ones.
    power: u64,
    /// The multiplications it took.
    work: u64,
}

impl Seen {
    /// `None` if M is singular modulo the prime.
    fn of(parts: [&ExactMatrix; 3], field: &PrimeField) -> Option<Seen> {
        let [m, c, k] = parts.map(|part| part.image(field));
        let n = parts[0].len();
        let mut basis = Basis {
            field,
            rows: vec![None; n],
            work: 0,
        };
        let (inverse, mut work) = Inverse::of(parts[0], &m, field)?;
        let mut rows: Vec<Vec<Residue>> = c
            .rows()
            .into_iter()
            .filter_map(|row| basis.add(row))
            .collect();
        let (mut rank, mut power) = (0, 0);
        while !rows.is_empty() {
            rank += rows.len();
            power += 1;
            let next = rows.iter().filter_map(|row| {
                work += inverse.work(n);
                basis.add(multiply(field, &k, &inverse.times(field, row)))
            });
            rows = next.collect();
        }
        Some(Seen {
            rank,
            power,
            work: work + basis.work,
        })
    }

    /// Whether no more rows than these are proved independent, for rational numbers.
    ///
    /// A minor of rank + 1 rows of C, …, CA^p, times det(M)^p, is a determinant of rows of C, and p
    /// times over of (K, −M): of the unknowns x, Ax, …, A^p x, tied by K A^j x = M A^(j+1) x.
    fn is_all(&self, parts: [&ExactMatrix; 3]) -> bool {
        let [m, c, k] = parts;
        let n = m.len();
        let shift = k.extent_of_all().high - m.extent_of_all().high;
        let tie = |i: usize| {
            let extent = k.extent(i).join(m.extent(i).shifted(shift));
            extent.bits() + ceil_log2(k.row(i).count() + m.row(i).count()) as u64
        };
        let row = |i: usize| c.extent(i).bits() + ceil_log2(c.row(i).count()) as u64;
        let ties: u64 = (0..n).map(tie).sum();
        let rows = (0..n).map(row).max().unwrap_or(0);
        let primes = (self.power * ties + (self.rank as u64 + 1) * rows) / PRIME_BITS + 1;
        primes.saturating_mul(self.work) <= MOST_WORK
            && PrimeField::all()
                .filter_map(|field| Seen::of(parts, &field))
                .take(primes as usize)
                .all(|seen| seen.rank <= self.rank)
    }
}

/// Independent rows, each with a 1 in front where no later one has an entry.
struct Basis<'a> {
    field: &'a PrimeField,
    /// By the column of their first entry.
    rows: Vec<Option<Vec<Residue>>>,
    work: u64,
}

impl Basis<'_> {
    /// What is left of a row, if it is independent of those before it.
    fn add(&mut self, mut row: Vec<Residue>) -> Option<Vec<Residue>> {
        let f = self.field;
        for column in 0..row.len() {
            if row[column].is_zero() {
                continue;
            }
            self.work += (row.len() - column) as u64;
            let Some(above) = &self.rows[column] else {
                let scale = f.inverse(row[column]);
                row[column..]
                    .iter_mut()
                    .for_each(|value| *value = f.product(*value, scale));
                self.rows[column] = Some(row.clone());
                return Some(row);
            };
            let factor = f.negative(row[column]);
            for (value, &other) in row[column..].iter_mut().zip(&above[column..]) {
                *value = f.sum(*value, f.product(factor, other));
            }
        }
        None
    }
}

/// M⁻¹ modulo a prime.
enum Inverse {
    Diagonal(Vec<Residue>),
    Full(Vec<Vec<Residue>>),
}

impl Inverse {
    /// With the multiplications it took; `None` if there is none.
    fn of(matrix: &ExactMatrix, image: &Image, field: &PrimeField) -> Option<(Inverse, u64)> {
        let n = matrix.len();
        if matrix.is_diagonal() {
            let inverse = (0..n).map(|i| {
                let (_, mass) = image.row(i).next()?;
                (!mass.is_zero()).then(|| field.inverse(mass))
            });
            let inverse = inverse.collect::<Option<_>>()?;
            return Some((Inverse::Diagonal(inverse), 100 * n as u64));
        }
        let unit = |i| {
            let mut row = vec![Residue::ZERO; n];
            row[i] = field.integer(1);
            row
        };
        let inverse = solve(field, image.rows(), (0..n).map(unit).collect())?;
        Some((Inverse::Full(inverse), 2 * (n as u64).pow(3)))
    }

    fn times(&self, field: &PrimeField, vector: &[Residue]) -> Vec<Residue> {
        let pairs = |row: &[Residue]| {
            row.iter().zip(vector).fold(Residue::ZERO, |sum, (&a, &b)| {
                field.sum(sum, field.product(a, b))
            })
        };
        match self {
            Inverse::Diagonal(entries) => entries
                .iter()
                .zip(vector)
                .map(|(&a, &b)| field.product(a, b))
                .collect(),
            Inverse::Full(rows) => rows.iter().map(|row| pairs(row)).collect(),
        }
    }

    /// The multiplications for one product.
    fn work(&self, n: usize) -> u64 {
        match self {
            Inverse::Diagonal(_) => n as u64,
            Inverse::Full(_) => (n * n) as u64,
        }
    }
}

fn multiply(field: &PrimeField, matrix: &Image, vector: &[Residue]) -> Vec<Residue> {
    let row = |i| {
        matrix.row(i).fold(Residue::ZERO, |sum, (j, value)| {
            field.sum(sum, field.product(value, vector[j]))
        })
    };
    (0..vector.len()).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::super::samples::{
        Join, as_matrices, chain, matrices, network, triple_defect, uniform_beam,
    };
    use super::*;
    use crate::system::System;
    use faer::{Mat, mat};
    use proptest::prelude::*;

    fn count(system: &System) -> Option<usize> {
        undamped_modes(&Coefficients::of(system))
    }

    /// A hub, 1, held by a spring, and arms of (mass, spring).
    fn star(arms: &[(f64, f64)], dampers: &[Join]) -> System {
        let masses: Vec<f64> = [1.0]
            .into_iter()
            .chain(arms.iter().map(|arm| arm.0))
            .collect();
        let mut springs = vec![(0, 1, 0.7)];
        springs.extend(arms.iter().enumerate().map(|(i, arm)| (1, i + 2, arm.1)));
        network(&masses, &springs, dampers)
    }

    #[test]
    fn a_damper_at_the_middle_of_three() {
        let grounded = |at| {
            network(
                &[0.1; 3],
                &[(0, 1, 0.3), (1, 2, 0.3), (2, 3, 0.3), (0, 3, 0.3)],
                &[(0, at, 0.7)],
            )
        };
        assert_eq!(count(&grounded(2)), Some(1));
        assert_eq!(count(&grounded(1)), Some(0));
        assert_eq!(count(&as_matrices(&grounded(2))), Some(1));
        let mut masses = [0.1_f64; 3];
        masses[2] = masses[2].next_up();
        let off = network(
            &masses,
            &[(0, 1, 0.3), (1, 2, 0.3), (2, 3, 0.3), (0, 3, 0.3)],
            &[(0, 2, 0.7)],
        );
        assert_eq!(count(&off), Some(0));
    }

    #[test]
    fn stars_with_equal_arms() {
        let arms = [(0.1, 0.3); 4];
        assert_eq!(count(&star(&arms, &[(0, 1, 0.2)])), Some(3));
        let along: Vec<Join> = (2..6).map(|i| (1, i, 0.2)).collect();
        assert_eq!(count(&star(&arms, &along)), Some(0));
        assert_eq!(count(&star(&arms, &along[..2])), Some(1));
        assert_eq!(count(&star(&[(0.1, 0.3); 60], &[(0, 1, 0.2)])), Some(59));
    }

    #[test]
    fn unequal_masses_that_happen_to_balance() {
        // Held at the middle, either side is at ω = 1: 2 · 0.15 / 0.3 = 2 · 0.05 / 0.1 in doubles.
        let springs = [
            (0, 1, 0.15),
            (1, 2, 0.15),
            (2, 3, 0.05),
            (0, 3, 0.05),
            (0, 2, 7.0),
        ];
        assert_eq!(
            count(&network(&[0.3, 5.0, 0.1], &springs, &[(0, 2, 1.0)])),
            Some(1)
        );
        let mut off = springs;
        off[0].2 = off[0].2.next_up();
        assert_eq!(
            count(&network(&[0.3, 5.0, 0.1], &off, &[(0, 2, 1.0)])),
            Some(0)
        );
    }

    #[test]
    fn rigid_motions_are_not_counted() {
        let springs = [(1, 2, 3.0), (2, 3, 3.0)];
        let free = |dampers: &[Join]| count(&network(&[2.0; 3], &springs, dampers));
        assert_eq!(free(&[]), Some(2));
        assert_eq!(free(&[(1, 3, 1.0)]), Some(1));
        assert_eq!(free(&[(1, 2, 1.0)]), Some(0));
        assert_eq!(free(&[(0, 2, 1.0)]), Some(1));
        let masses = [1.0, 4.0];
        assert_eq!(
            count(&network(&masses, &[(1, 2, 1.0)], &[(1, 2, 1.0)])),
            Some(0)
        );
    }

    #[test]
    fn what_is_not_answered() {
        assert_eq!(count(&triple_defect()), None);
        let negative = network(&[1.0], &[(0, 1, 1.0)], &[(0, 1, -1.0)]);
        assert_eq!(count(&negative), None);
        let skew = mat![[0.0, 1.0], [-1.0, 0.0]];
        assert_eq!(
            count(&matrices(Mat::identity(2, 2), skew, Mat::identity(2, 2))),
            None
        );
    }

    #[test]
    fn the_antisymmetric_modes_of_a_clamped_beam_with_a_dashpot_at_its_middle() {
        for elements in [2, 4, 30, 100] {
            let n = 2 * (elements - 1);
            let [mass, stiffness] =
                uniform_beam(elements).map(|part| part.submatrix(2, 2, n, n).to_owned());
            let mut damping = Mat::<f64>::zeros(n, n);
            damping[(elements - 2, elements - 2)] = 0.1;
            let beam = matrices(mass, damping, stiffness);
            assert_eq!(count(&beam), Some(elements - 1), "{elements}");
        }
    }

    fn common_divisor(a: usize, b: usize) -> usize {
        if b == 0 { a } else { common_divisor(b, a % b) }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]

        /// Mode r of a uniform chain, sin(πrj/(n + 1)), rests at mass j for gcd(j, n + 1) − 1 of the
        /// r, with lumped masses and with the consistent ones of rods.
        #[test]
        fn uniform_chains(n in 1usize..14, at in 0usize..13, c in 1e-3..1e3, k in 1e-3..1e3) {
            let at = at % n + 1;
            let expected = Some(common_divisor(at, n + 1) - 1);
            let lumped = chain(&vec![0.1; n], &vec![k; n + 1], &vec![0.0; n + 1]);
            let springs: Vec<Join> = (0..=n).map(|i| (i, (i + 1) % (n + 1), k)).collect();
            let damped = network(&vec![0.1; n], &springs, &[(0, at, c)]);
            prop_assert_eq!(count(&damped), expected);
            prop_assert_eq!(count(&lumped), Some(n));
            let mass = Mat::from_fn(n, n, |i, j| match i.abs_diff(j) {
                0 => 4.0,
                1 => 1.0,
                _ => 0.0,
            });
            let rod = matrices(mass, damped.damping_matrix(), damped.stiffness_matrix());
            prop_assert_eq!(count(&rod), expected);
        }

        /// Arms of one frequency balance each other: all but one of them.
        #[test]
        fn stars(arms in prop::collection::vec((1u8..3, 1u8..5), 1..8)) {
            let ratios: Vec<u8> = arms.iter().map(|&(m, k)| 2 / m * k).collect();
            let mut distinct = ratios.clone();
            distinct.sort_unstable();
            distinct.dedup();
            let arms: Vec<(f64, f64)> = arms.iter().map(|&(m, k)| (f64::from(m) * 0.1, f64::from(k))).collect();
            let system = star(&arms, &[(0, 1, 0.3)]);
            prop_assert_eq!(count(&system), Some(ratios.len() - distinct.len()));
        }
    }
}
