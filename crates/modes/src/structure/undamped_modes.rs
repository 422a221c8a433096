//! Undamped modes of a damped system: K x = ω²M x with C x = 0, as where every damper sits at a
//! node. With M ≻ 0 and C, K ⪰ 0 these are all the motions that neither decay nor rest, for
//! Re λ = 0 ≠ λ asks for x*Cx = 0. They and the rigid motions that nothing damps, ker K ∩ ker C, span
//! the largest subspace of ker C that A = M⁻¹K keeps, which is what no row of C, CA, CA², … sees.
//! Massless coordinates p follow from the others, x_p = −K_pp⁻¹ K_pm x_m, and are eliminated.
//!
//! Modulo one prime, the rank of these rows leaves an upper bound on its dimension. Where it leaves none, that often shows
//! in one of the rows' combinations c, since the recurrence of cAᵏu is no longer than their rank. Else it is proved to
//! be reached by a mirror symmetry whose motions C does not touch, or modulo many primes.

use super::coefficients::Coefficients;
use crate::exact::elimination::solve;
use crate::exact::envelope::Envelope;
use crate::exact::matrix::{ExactMatrix, Image};
use crate::exact::prime_field::{MOST_WORK, PRIME_BITS, PrimeField, Residue};
use crate::exact::recurrence::order;
use crate::exact::sum::{Extent, ceil_log2};

/// How many there are with ω ≠ 0, given the massless coordinates, rising. `None` where it is not
/// proved.
pub(crate) fn undamped_modes(coefficients: &Coefficients, massless: &[usize]) -> Option<usize> {
    let [mass, damping, stiffness] = coefficients.parts();
    let n = mass.matrix.len();
    let moving = stiffness.semidefinite_rank()?;
    let damped = damping.semidefinite_rank()?;
    let massive = n - massless.len();
    if mass.semidefinite_rank()? < massive {
        return None;
    }
    if damped == n {
        return Some(0);
    }
    let rigid = n - damping.plus(stiffness).semidefinite_rank()?;
    if damped == n - rigid {
        return Some(0);
    }
    if damped == 0 && massless.is_empty() {
        return Some(moving);
    }
    let tied = Tied {
        parts: [&mass.matrix, &damping.matrix, &stiffness.matrix],
        massless,
    };
    if tied.least_seen(&PrimeField::first()) == Some(massive - rigid) {
        return Some(0);
    }
    let full = !mass.matrix.is_diagonal() || !massless.is_empty();
    if (if full { 3 } else { 1 }) * (n as u64).pow(3) > MOST_WORK {
        return None;
    }
    let seen = PrimeField::all()
        .take(2)
        .find_map(|field| tied.seen(&field))?;
    let unseen = massive - seen.rank;
    let is_massive = |i: usize| massless.binary_search(&i).is_err();
    let proved = unseen == rigid
        || seen.rank == 0
        || coefficients
            .mirror()
            .is_some_and(|mirror| mirror.untouched(&damping.matrix, is_massive) == unseen)
        || tied.sees_no_more(&seen);
    proved.then(|| unseen - rigid)
}

/// M, C and K, with the coordinates that follow from others.
struct Tied<'a> {
    parts: [&'a ExactMatrix; 3],
    massless: &'a [usize],
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

/// The rows of a matrix, each with its entries.
type Sparse = Vec<Vec<(usize, Residue)>>;

impl Tied<'_> {
    /// A number that the rank of the rows is not below, where all coordinates are massive and M and K have narrow bands, so
    /// that it costs little.
    fn least_seen(&self, field: &PrimeField) -> Option<usize> {
        let [m, c, k] = self.parts;
        let n = m.len();
        if !self.massless.is_empty() {
            return None;
        }
        let all: Vec<usize> = (0..n).collect();
        // A fraction of what all rows take.
        let most = MOST_WORK.min((n as u64).pow(3) / 2);
        let mass = Envelope::of(field, &m.image(field), &all, most)?;
        let stiffness = k.image(field);
        let entries: usize = (0..n).map(|i| k.row(i).count()).sum();
        let length = 2 * n as u64;
        if mass.work + length * (mass.step() + entries as u64 + length) > most {
            return None;
        }
        // Multiples of odd numbers without a pattern.
        let number = |i: u64, odd: u64| field.integer((i + 1).wrapping_mul(odd));
        let mut row = vec![Residue::ZERO; n];
        let damping = c.image(field);
        for i in 0..n {
            let share = number(i as u64, 0x9e37_79b9_7f4a_7c15);
            for (j, value) in damping.row(i) {
                row[j] = field.sum(row[j], field.product(share, value));
            }
        }
        let onto: Vec<Residue> = (0..n as u64)
            .map(|i| number(i, 0xd134_2543_de82_ef95))
            .collect();
        let mut sequence = Vec::with_capacity(2 * n);
        for _ in 0..2 * n {
            sequence.push(field.dot(&row, &onto));
            let solved = mass.solve(&row);
            for (i, entry) in row.iter_mut().enumerate() {
                let products = stiffness
                    .row(i)
                    .map(|(j, value)| field.product(value, solved[j]));
                *entry = products.fold(Residue::ZERO, |sum, product| field.sum(sum, product));
            }
        }
        Some(order(field, &sequence))
    }

    /// `None` if M_mm or K_pp is singular modulo the prime.
    fn seen(&self, field: &PrimeField) -> Option<Seen> {
        let [m, c, k] = self.parts;
        let (c, k, mut work) = self.eliminated([&c.image(field), &k.image(field)], field)?;
        let n = k.len();
        let (inverse, more) = self.inverse(m, field)?;
        work += more;
        let mut basis = Basis {
            field,
            rows: vec![None; n],
            work: 0,
        };
        let dense = |row: &Vec<(usize, Residue)>| {
            let mut values = vec![Residue::ZERO; n];
            row.iter().for_each(|&(j, value)| values[j] = value);
            values
        };
        let mut rows: Vec<Vec<Residue>> =
            c.iter().filter_map(|row| basis.add(dense(row))).collect();
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

    /// The numbers of the massive coordinates among themselves.
    fn places(&self) -> Vec<Option<usize>> {
        let mut places = vec![None; self.parts[0].len()];
        let massive = (0..places.len()).filter(|i| self.massless.binary_search(i).is_err());
        massive.enumerate().for_each(|(at, i)| places[i] = Some(at));
        places
    }

    /// C_·m − C_·p K_pp⁻¹ K_pm, K_mm − K_mp K_pp⁻¹ K_pm, and the multiplications they took.
    fn eliminated(&self, [c, k]: [&Image; 2], field: &PrimeField) -> Option<(Sparse, Sparse, u64)> {
        let places = self.places();
        let (n, p) = (places.len(), self.massless.len());
        let m = n - p;
        let at = |i: usize| self.massless.binary_search(&i);
        let rows = |massless: bool, width: usize| -> Vec<Vec<Residue>> {
            let row = |&i: &usize| {
                let mut row = vec![Residue::ZERO; width];
                for (j, value) in k.row(i) {
                    match (at(j), places[j]) {
                        (Ok(j), _) if massless => row[j] = value,
                        (_, Some(j)) if !massless => row[j] = value,
                        _ => {}
                    }
                }
                row
            };
            self.massless.iter().map(row).collect()
        };
        let follow = solve(field, rows(true, p), rows(false, m))?;
        let reduce = |image: &Image, i: usize| {
            let mut row = vec![Residue::ZERO; m];
            for (j, value) in image.row(i) {
                match (at(j), places[j]) {
                    (Ok(j), _) => {
                        for (entry, &other) in row.iter_mut().zip(&follow[j]) {
                            *entry = field.difference(*entry, field.product(value, other));
                        }
                    }
                    (_, Some(j)) => row[j] = field.sum(row[j], value),
                    _ => {}
                }
            }
            let entries = row.into_iter().enumerate();
            entries.filter(|(_, value)| !value.is_zero()).collect()
        };
        let damping = (0..n).map(|i| reduce(c, i)).collect();
        let massive = (0..n).filter(|&i| places[i].is_some());
        let stiffness = massive.map(|i| reduce(k, i)).collect();
        Some((damping, stiffness, ((p + 2) * n * n) as u64))
    }

    /// M_mm⁻¹, with the multiplications it took.
    fn inverse(&self, mass: &ExactMatrix, field: &PrimeField) -> Option<(Inverse, u64)> {
        let image = mass.image(field);
        let places = self.places();
        let massive: Vec<usize> = (0..places.len()).filter(|&i| places[i].is_some()).collect();
        if mass.is_diagonal() {
            let inverse = massive.iter().map(|&i| {
                let (_, mass) = image.row(i).next()?;
                (!mass.is_zero()).then(|| field.inverse(mass))
            });
            let inverse = inverse.collect::<Option<_>>()?;
            return Some((Inverse::Diagonal(inverse), 100 * massive.len() as u64));
        }
        let n = massive.len();
        let row = |&i: &usize| {
            let mut row = vec![Residue::ZERO; n];
            for (j, value) in image.row(i) {
                if let Some(j) = places[j] {
                    row[j] = value;
                }
            }
            row
        };
        let unit = |i| {
            let mut row = vec![Residue::ZERO; n];
            row[i] = field.integer(1);
            row
        };
        let inverse = solve(
            field,
            massive.iter().map(row).collect(),
            (0..n).map(unit).collect(),
        )?;
        Some((Inverse::Full(inverse), 2 * (n as u64).pow(3)))
    }

    /// Whether no more rows than these are proved independent, for rational numbers.
    ///
    /// A minor of rank + 1 rows of C, …, CA^p, times det(M_mm)^p det(K_pp)^(p+1), is a determinant
    /// of rows of C, p times over of those of (K, −M), and once more of those of massless
    /// coordinates: of the unknowns x, Ax, …, A^p x, tied by K A^j x = M A^(j+1) x.
    fn sees_no_more(&self, seen: &Seen) -> bool {
        let [m, c, k] = self.parts;
        let n = m.len();
        let shift = k.extent_of_all().high - m.extent_of_all().high;
        let bits = |extent: Extent, count: usize| extent.bits() + ceil_log2(count) as u64;
        let tie = |i: usize| {
            let extent = k.extent(i).join(m.extent(i).shifted(shift));
            bits(extent, k.row(i).count() + m.row(i).count())
        };
        let ties: u64 = (0..n).map(tie).sum();
        let last: u64 = self.massless.iter().map(|&i| tie(i)).sum();
        let rows = (0..n)
            .map(|i| bits(c.extent(i), c.row(i).count()))
            .max()
            .unwrap_or(0);
        let minor = seen.power * ties + last + (seen.rank as u64 + 1) * rows;
        let primes = minor / PRIME_BITS + 1;
        primes.saturating_mul(seen.work) <= MOST_WORK
            && PrimeField::all()
                .filter_map(|field| self.seen(&field))
                .take(primes as usize)
                .all(|other| other.rank <= seen.rank)
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

/// M_mm⁻¹ modulo a prime.
enum Inverse {
    Diagonal(Vec<Residue>),
    Full(Vec<Vec<Residue>>),
}

impl Inverse {
    fn times(&self, field: &PrimeField, vector: &[Residue]) -> Vec<Residue> {
        match self {
            Inverse::Diagonal(entries) => entries
                .iter()
                .zip(vector)
                .map(|(&a, &b)| field.product(a, b))
                .collect(),
            Inverse::Full(rows) => rows.iter().map(|row| field.dot(row, vector)).collect(),
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

fn multiply(field: &PrimeField, matrix: &Sparse, vector: &[Residue]) -> Vec<Residue> {
    let row = |row: &Vec<(usize, Residue)>| {
        row.iter().fold(Residue::ZERO, |sum, &(j, value)| {
            field.sum(sum, field.product(value, vector[j]))
        })
    };
    matrix.iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::super::massless::Massless;
    use super::super::samples::{
        Join, as_matrices, chain, matrices, network, triple_defect, uniform_beam,
    };
    use super::*;
    use crate::system::System;
    use faer::{Mat, mat};
    use proptest::prelude::*;

    fn count(system: &System) -> Option<usize> {
        let coefficients = Coefficients::of(system.model());
        undamped_modes(&coefficients, &Massless::of(&coefficients).nodes)
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

    #[test]
    fn massless_nodes_follow() {
        assert_eq!(count(&triple_defect()), Some(0));
        // A dashpot behind a spring, at the middle mass of three.
        let springs = [
            (0, 1, 1.0),
            (1, 2, 1.0),
            (2, 3, 1.0),
            (0, 3, 1.0),
            (2, 4, 9.0),
        ];
        let masses = [3.0, 3.0, 3.0, 0.0];
        assert_eq!(count(&network(&masses, &springs, &[(0, 4, 0.1)])), Some(1));
        assert_eq!(count(&network(&masses, &springs, &[])), Some(3));
        // Held by dampers alone: not answered.
        let loose = network(
            &[1.0, 1.0, 0.0],
            &[(0, 1, 1.0), (1, 2, 1.0)],
            &[(2, 3, 1.0), (0, 3, 1.0)],
        );
        assert_eq!(count(&loose), None);
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

        /// Mode r moves the middle of the spring before mass j by sin(πr(2j − 1)/(2n + 2)) times what
        /// is not 0: nothing for (gcd(2j − 1, n + 1) − 1)/2 of the r.
        #[test]
        fn uniform_chains_damped_between_masses(n in 1usize..10, at in 0usize..10, k in 1e-3..1e3) {
            let at = at % (n + 1) + 1;
            let node = |mass: usize| if mass == n + 1 { 0 } else { mass };
            let springs: Vec<Join> = (0..=n)
                .flat_map(|i| [(node(i), n + 1 + i, 2.0 * k), (n + 1 + i, node(i + 1), 2.0 * k)])
                .collect();
            let masses: Vec<f64> = (0..=2 * n).map(|i| if i < n { 0.1 } else { 0.0 }).collect();
            let expected = Some((common_divisor(2 * at - 1, n + 1) - 1) / 2);
            prop_assert_eq!(count(&network(&masses, &springs, &[(0, n + at, 0.3)])), expected);
            let at_mass = at.min(n);
            let expected = Some(common_divisor(at_mass, n + 1) - 1);
            prop_assert_eq!(count(&network(&masses, &springs, &[(0, at_mass, 0.3)])), expected);
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
