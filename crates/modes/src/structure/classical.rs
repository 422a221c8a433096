//! Classical damping: C M⁻¹ K = K M⁻¹ C with M ≻ 0 and all three symmetric. Then, and only then,
//! one set of real shapes diagonalises M, C and K at once (Caughey & O'Kelly 1965, *J. Appl.
//! Mech.* 32, theorem 2). It holds exactly or not at all: where two
//! frequencies are close, a commutator that almost vanishes still lets damping mix their shapes.
//!
//! First Rayleigh's kind: M, C and K span no more than a plane. If not, the commutator itself is
//! computed modulo primes; one that is not 0 disproves it.

use super::coefficients::Coefficients;
use super::commutator::differs_visibly;
use crate::exact::elimination::solve;
use crate::exact::matrix::{ExactMatrix, Image};
use crate::exact::prime_field::{MOST_WORK, PRIME_BITS, PrimeField, Residue};
use crate::exact::sum::{Extent, Parts, ceil_log2};

/// The answer to a question that exact arithmetic can settle, if not always at a bearable cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Verdict {
    Proved,
    Disproved,
    NotProved,
}

/// Whether a system is classically damped. Not proved without a mass on each coordinate, or where
/// it would take too many primes.
pub(crate) fn classical(coefficients: &Coefficients) -> Verdict {
    let [mass, damping, stiffness] = coefficients.parts();
    if damping.network.is_none()
        || stiffness.network.is_none()
        || mass.semidefinite_rank() != Some(mass.matrix.len())
    {
        return Verdict::NotProved;
    }
    let (m, c, k) = (&mass.matrix, &damping.matrix, &stiffness.matrix);
    if c.is_zero() || k.is_zero() {
        Verdict::Proved
    } else if differ_visibly(m, c, k) {
        Verdict::Disproved
    } else if is_rayleigh([m, c, k]) {
        Verdict::Proved
    } else if m.is_diagonal() {
        commute_over_diagonal(m, c, k)
    } else {
        commute(m, c, k)
    }
}

/// Whether C M⁻¹ K − K M⁻¹ C has an entry that doubles distinguish from 0 beyond their rounding, for a diagonal M of one
/// double each. Most systems show it at their first joint.
fn differ_visibly(m: &ExactMatrix, c: &ExactMatrix, k: &ExactMatrix) -> bool {
    /// Smaller numbers may have lost digits.
    const LEAST: f64 = 1e-280;
    let masses = || (0..m.len()).map(|i| m.entry(i, i));
    if !m.is_diagonal() || masses().any(|terms| terms.len() != 1) {
        return false;
    }
    // Sum and sum of sizes of an entry.
    let value = |terms: &[f64]| {
        let add = |(sum, size): (f64, f64), term: &f64| (sum + term, size + term.abs());
        terms.iter().fold((0.0, 0.0), add)
    };
    let differs = |i: usize, j: usize| {
        let (mut sum, mut size, mut terms) = (0.0, 0.0, 0);
        for (left, right, sign) in [(c, k, 1.0), (k, c, -1.0)] {
            for (l, first) in left.row(i) {
                let second = right.entry(l, j);
                if second.is_empty() {
                    continue;
                }
                terms += first.len() + second.len();
                let (first, second, mass) = (value(first), value(second), m.entry(l, l)[0]);
                let product = first.1 * second.1;
                if product < LEAST || product / mass < LEAST {
                    return false;
                }
                sum += sign * (first.0 * second.0 / mass);
                size += product / mass;
            }
        }
        let rounding = 4.0 * (terms + 8) as f64 * f64::EPSILON;
        size.is_finite() && sum.abs() > rounding * size
    };
    // Of each pair that has a node in common, once.
    let mut met = vec![usize::MAX; m.len()];
    (0..m.len()).any(|i| {
        let joined = |i: usize| c.row(i).chain(k.row(i)).map(|entry| entry.0);
        joined(i).any(|l| {
            joined(l).any(|j| j < i && std::mem::replace(&mut met[j], i) != i && differs(i, j))
        })
    })
}

/// Whether one of three symmetric matrices is a combination of the others: their entries, taken as
/// vectors of three, have rank 2 at most.
pub(crate) fn is_rayleigh(matrices: [&ExactMatrix; 3]) -> bool {
    // A 3 × 3 minor is a sum of six products.
    let bits: u64 = matrices
        .iter()
        .map(|matrix| matrix.extent_of_all().bits())
        .sum::<u64>()
        + 3;
    let primes = bits / PRIME_BITS + 1;
    PrimeField::all().take(primes as usize).all(|field| {
        let mut plane = Plane::default();
        let mut parts = Vec::new();
        (0..matrices[0].len()).all(|i| {
            parts.clear();
            for (which, matrix) in matrices.iter().enumerate() {
                let upper = matrix.row(i).filter(|entry| entry.0 >= i);
                parts.extend(upper.map(|(j, terms)| (j, which, field.sum_of(terms))));
            }
            parts.sort_by_key(|part| part.0);
            parts.chunk_by(|a, b| a.0 == b.0).all(|entry| {
                let mut vector = [Residue::ZERO; 3];
                entry
                    .iter()
                    .for_each(|&(_, which, value)| vector[which] = value);
                plane.holds(&field, vector)
            })
        })
    })
}

/// The span of vectors of three seen so far.
#[derive(Default)]
struct Plane {
    first: Option<[Residue; 3]>,
    normal: Option<[Residue; 3]>,
}

impl Plane {
    /// Adds a vector; whether all still lie in one plane.
    fn holds(&mut self, f: &PrimeField, vector: [Residue; 3]) -> bool {
        if let Some(normal) = self.normal {
            let products = (0..3).map(|i| f.product(normal[i], vector[i]));
            return products
                .fold(Residue::ZERO, |sum, product| f.sum(sum, product))
                .is_zero();
        }
        let Some(first) = self.first else {
            self.first = vector.iter().any(|x| !x.is_zero()).then_some(vector);
            return true;
        };
        let cross = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| {
            f.difference(
                f.product(first[i], vector[j]),
                f.product(first[j], vector[i]),
            )
        });
        self.normal = cross.iter().any(|x| !x.is_zero()).then_some(cross);
        true
    }
}

/// Whether C M⁻¹ K − K M⁻¹ C vanishes modulo one prime after another: at the first one, then at as
/// many as its entries' size asks for. `vanishes` is `None` at a prime where M is singular.
fn decide(cost: impl FnOnce() -> Cost, vanishes: impl Fn(&PrimeField) -> Option<bool>) -> Verdict {
    let mut answers = PrimeField::all().filter_map(|field| vanishes(&field));
    if answers.next() == Some(false) {
        return Verdict::Disproved;
    }
    let cost = cost();
    let primes = cost.bits / PRIME_BITS + 1;
    if primes.saturating_mul(cost.work) > MOST_WORK {
        Verdict::NotProved
    } else if answers.take(primes as usize - 1).all(|vanishes| vanishes) {
        Verdict::Proved
    } else {
        Verdict::Disproved
    }
}

/// What it takes to prove that a matrix vanishes.
#[derive(Default)]
struct Cost {
    /// The bits of its entries as integers.
    bits: u64,
    /// The multiplications for each prime.
    work: u64,
}

/// For a diagonal M each entry is an integer once multiplied by the masses that occur in it, which
/// are few in a chain.
fn commute_over_diagonal(m: &ExactMatrix, c: &ExactMatrix, k: &ExactMatrix) -> Verdict {
    let cost = || {
        let around: Vec<Surroundings> =
            (0..m.len()).map(|i| Surroundings::of(i, m, c, k)).collect();
        let mut cost = Cost::default();
        let mut met = vec![usize::MAX; m.len()];
        for i in 0..m.len() {
            for &l in &around[i].nodes {
                cost.work += around[l].nodes.len() as u64;
                for &j in around[l].nodes.iter().filter(|&&j| j > i) {
                    if std::mem::replace(&mut met[j], i) != i {
                        cost.bits = cost.bits.max(around[i].bits_with(&around[j]));
                    }
                }
            }
        }
        cost
    };
    decide(cost, |field| {
        let mass = m.image(field);
        let inverse = (0..m.len()).map(|i| {
            let (_, mass) = mass.row(i).next()?;
            (!mass.is_zero()).then(|| field.inverse(mass))
        });
        let inverse: Vec<Residue> = inverse.collect::<Option<_>>()?;
        let (c, k) = (c.image(field), k.image(field));
        let mut sums = vec![Residue::ZERO; m.len()];
        let mut met = Vec::new();
        let vanishes = (0..m.len()).all(|i| {
            let mut add = |left: &Image, right: &Image, inverse: &dyn Fn(usize) -> Residue| {
                for (l, value) in left.row(i) {
                    let value = field.product(value, inverse(l));
                    for (j, other) in right.row(l).filter(|entry| entry.0 > i) {
                        sums[j] = field.sum(sums[j], field.product(value, other));
                        met.push(j);
                    }
                }
            };
            add(&c, &k, &|l| inverse[l]);
            add(&k, &c, &|l| field.negative(inverse[l]));
            met.drain(..)
                .all(|j| std::mem::replace(&mut sums[j], Residue::ZERO).is_zero())
        });
        Some(vanishes)
    })
}

/// The nodes that C and K join to one node, itself included, and where the bits of its entries and
/// their masses lie.
struct Surroundings {
    nodes: Vec<usize>,
    damping: Extent,
    stiffness: Extent,
    /// A common multiple of the masses, each divided by a power of two, has so many bits.
    mass_bits: u64,
    /// Those powers of two: from the lowest to the highest.
    mass_powers: Extent,
}

impl Surroundings {
    fn of(i: usize, m: &ExactMatrix, c: &ExactMatrix, k: &ExactMatrix) -> Surroundings {
        let mut nodes: Vec<usize> = c.row(i).chain(k.row(i)).map(|entry| entry.0).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let mut mass_powers = Extent::NOTHING;
        // Masses that are one double and differ by a power of two are counted once.
        let mut odd_parts = Vec::with_capacity(nodes.len());
        for &l in &nodes {
            for (_, terms) in m.row(l) {
                let extent = Extent::of(terms);
                mass_powers = mass_powers.join(Extent {
                    low: extent.low,
                    high: extent.low,
                });
                let key = match terms {
                    [mass] => {
                        let mantissa = Parts::of(*mass).mantissa;
                        (mantissa >> mantissa.trailing_zeros(), usize::MAX)
                    }
                    _ => (0, l),
                };
                odd_parts.push((key, extent.bits()));
            }
        }
        odd_parts.sort_unstable();
        odd_parts.dedup();
        Surroundings {
            nodes,
            damping: c.extent(i),
            stiffness: k.extent(i),
            mass_bits: odd_parts.iter().map(|part| part.1).sum(),
            mass_powers,
        }
    }

    /// The bits of entry (i, j) of C M⁻¹ K − K M⁻¹ C as an integer, given what surrounds i and j.
    /// Only masses that surround both occur in it.
    fn bits_with(&self, other: &Surroundings) -> u64 {
        let fewer = if self.mass_bits < other.mass_bits {
            self
        } else {
            other
        };
        let products = self
            .damping
            .times(other.stiffness)
            .join(self.stiffness.times(other.damping));
        let quotients = Extent {
            low: products.low - fewer.mass_powers.high,
            high: products.high - fewer.mass_powers.low,
        };
        quotients.of_sum(2 * fewer.nodes.len()).bits() + fewer.mass_bits
    }
}

/// For a full M, whose inverse is an integer matrix over det M.
fn commute(m: &ExactMatrix, c: &ExactMatrix, k: &ExactMatrix) -> Verdict {
    let n = m.len();
    if (n as u64).pow(3) > MOST_WORK {
        return Verdict::NotProved;
    }
    if differs_visibly(m, c, k) || differ_somewhere(m, c, k, &PrimeField::first()) {
        return Verdict::Disproved;
    }
    let cost = || {
        // Row i of M divided by 2^low, so that M⁻¹K is that of integers and of K's rows divided too.
        let mut determinant = 0;
        let mut right = Extent::NOTHING;
        for i in 0..n {
            let row = m.extent(i);
            determinant += row.bits() + ceil_log2(m.row(i).count()) as u64;
            right = right.join(k.extent(i).shifted(-row.low));
        }
        let products = c.extent_of_all().times(right).of_sum(n).of_sum(n).of_sum(2);
        Cost {
            bits: products.bits() + determinant,
            work: (3 * n * n * n) as u64,
        }
    };
    decide(cost, |field| {
        let solution = solve(field, m.image(field).rows(), k.image(field).rows())?;
        let product = multiply(field, &c.image(field), &solution);
        Some((0..n).all(|i| (0..i).all(|j| product[i][j] == product[j][i])))
    })
}

/// Whether C M⁻¹ K and K M⁻¹ C take some one vector to different ones, modulo a prime.
fn differ_somewhere(m: &ExactMatrix, c: &ExactMatrix, k: &ExactMatrix, field: &PrimeField) -> bool {
    let (c, k) = (c.image(field), k.image(field));
    let vector: Vec<Vec<Residue>> = (0..m.len() as u64)
        .map(|i| vec![field.integer((i + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15))])
        .collect();
    let pairs = multiply(field, &k, &vector)
        .into_iter()
        .zip(multiply(field, &c, &vector));
    let right = pairs.map(|(k, c)| [k, c].concat()).collect();
    let Some(solved) = solve(field, m.image(field).rows(), right) else {
        return false;
    };
    let column =
        |at: usize| -> Vec<Vec<Residue>> { solved.iter().map(|row| vec![row[at]]).collect() };
    multiply(field, &c, &column(0)) != multiply(field, &k, &column(1))
}

/// A sparse matrix times one of full rows.
fn multiply(field: &PrimeField, left: &Image, right: &[Vec<Residue>]) -> Vec<Vec<Residue>> {
    let columns = right.first().map_or(0, Vec::len);
    let row = |i| {
        let mut row = vec![Residue::ZERO; columns];
        for (l, value) in left.row(i) {
            for (sum, &other) in row.iter_mut().zip(&right[l]) {
                *sum = field.sum(*sum, field.product(value, other));
            }
        }
        row
    };
    (0..right.len()).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::super::samples::{
        almost_classical, as_matrices, chain, matrices, network, with_matrices,
    };
    use super::*;
    use crate::system::System;
    use Verdict::{Disproved, NotProved, Proved};
    use faer::{Mat, mat};
    use proptest::prelude::*;

    fn verdict(system: &System) -> Verdict {
        classical(&Coefficients::of(system.model()))
    }

    #[test]
    fn almost_is_not() {
        assert_eq!(verdict(&almost_classical()), Disproved);
        assert_eq!(verdict(&as_matrices(&almost_classical())), Disproved);
    }

    #[test]
    fn dampers_in_proportion_to_springs() {
        // SDLD02/89 of the French society of mechanical engineers: 8 equal masses, 9 equal joints.
        assert_eq!(verdict(&chain(&[10.0; 8], &[1e5; 9], &[50.0; 9])), Proved);
        let springs = [0.1, 1e12, 1.0 / 3.0, 7e-200];
        let dampers = springs.map(|k| k / 1024.0);
        let masses = [1e-9, 0.3, 1e20];
        assert_eq!(verdict(&chain(&masses, &springs, &dampers)), Proved);
        let mut off = dampers;
        off[2] = off[2].next_up();
        assert_eq!(verdict(&chain(&masses, &springs, &off)), Disproved);
    }

    #[test]
    fn dampers_in_proportion_to_masses() {
        let masses = [0.1, 0.7, 1e10];
        let to_ground: Vec<_> = (0..3).map(|i| (0, i + 1, masses[i] / 4.0)).collect();
        let springs = [(1, 2, 0.3), (2, 3, 1e-7), (0, 3, 5.0)];
        assert_eq!(verdict(&network(&masses, &springs, &to_ground)), Proved);
        let both: Vec<_> = to_ground
            .iter()
            .copied()
            .chain(springs.map(|(a, b, k)| (a, b, k * 8.0)))
            .collect();
        assert_eq!(verdict(&network(&masses, &springs, &both)), Proved);
    }

    #[test]
    fn beyond_rayleigh() {
        // C = K M⁻¹ K, which is no combination of M and K (Caughey 1960).
        let stiffness = mat![[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]];
        let mass = Mat::from_fn(3, 3, |i, j| if i == j { [0.5, 1.0, 0.25][i] } else { 0.0 });
        let weights = mat![[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 4.0]];
        let mut damping = &stiffness * &weights * &stiffness;
        assert_eq!(
            verdict(&matrices(mass.clone(), damping.clone(), stiffness.clone())),
            Proved
        );
        damping[(0, 0)] = damping[(0, 0)].next_up();
        assert_eq!(verdict(&matrices(mass, damping, stiffness)), Disproved);
    }

    #[test]
    fn beyond_rayleigh_with_a_full_mass_matrix() {
        // M = BᵀB, K = BᵀDB, C = BᵀEB for diagonal D and E of four different pairs.
        let b = mat![
            [1.0, 2.0, 0.0, 1.0],
            [0.0, 1.0, 3.0, 0.0],
            [1.0, 0.0, 1.0, 5.0],
            [2.0, 1.0, 0.0, 1.0]
        ];
        let diagonal = |d: [f64; 4]| Mat::from_fn(4, 4, |i, j| if i == j { d[i] } else { 0.0 });
        let of = |d| b.transpose() * diagonal(d) * &b;
        let (m, k) = (of([1.0; 4]), of([1.0, 5.0, 7.0, 8.0]));
        let mut c = of([3.0, 1.0, 0.0, 2.0]);
        assert_eq!(verdict(&matrices(m.clone(), c.clone(), k.clone())), Proved);
        c[(3, 3)] += 1.0;
        assert_eq!(verdict(&matrices(m.clone(), c, k.clone())), Disproved);
        assert_eq!(verdict(&matrices(m.clone(), &m + 0.5 * &k, k)), Proved);
    }

    #[test]
    fn two_machines_each_with_its_own_proportion() {
        let springs = [(0, 1, 3.0), (1, 2, 5.0), (0, 3, 7.0), (3, 4, 11.0)];
        let dampers = [(0, 1, 0.75), (1, 2, 1.25), (0, 3, 14.0), (3, 4, 22.0)];
        assert_eq!(
            verdict(&network(&[1.0, 3.0, 5.0, 7.0], &springs, &dampers)),
            Proved
        );
    }

    #[test]
    fn what_is_not_answered() {
        assert_eq!(
            verdict(&network(
                &[1.0, 0.0],
                &[(0, 1, 1.0), (1, 2, 1.0)],
                &[(0, 2, 1.0)]
            )),
            NotProved
        );
        let follower = with_matrices(
            &[1.0, 1.0],
            &[],
            &[(0, 1, 1.0)],
            [None, None, Some(mat![[1.0, 1.0], [0.0, 2.0]])],
        );
        assert_eq!(verdict(&follower), NotProved);
        let indefinite = matrices(
            mat![[1.0, 2.0], [2.0, 1.0]],
            Mat::zeros(2, 2),
            Mat::identity(2, 2),
        );
        assert_eq!(verdict(&indefinite), NotProved);
    }

    #[test]
    fn a_large_system_of_many_masses_is_not_answered() {
        // Two full networks of 150 different masses, each with a proportion of its own.
        let n = 150;
        let masses: Vec<f64> = (0..2 * n)
            .map(|i| 1.0 + i as f64 / 1024.0 / 1024.0 / 3.0)
            .collect();
        let pairs =
            |from: usize| (1..=n).flat_map(move |i| (i + 1..=n).map(move |j| (from + i, from + j)));
        let springs: Vec<_> = [0, n]
            .into_iter()
            .flat_map(pairs)
            .map(|(i, j)| (i, j, 1.0))
            .collect();
        let dampers: Vec<_> = springs
            .iter()
            .map(|&(i, j, k)| (i, j, if i > n { k } else { 2.0 * k }))
            .collect();
        assert_eq!(verdict(&network(&masses, &springs, &dampers)), NotProved);
    }

    /// C M⁻¹ K in integers, for masses 1, 2 and 4.
    fn commutes(masses: &[u8], damping: &Mat<f64>, stiffness: &Mat<f64>) -> bool {
        let n = masses.len();
        let entry = |i: usize, j: usize| -> f64 {
            (0..n)
                .map(|l| damping[(i, l)] * stiffness[(l, j)] * f64::from(4 / masses[l]))
                .sum()
        };
        (0..n).all(|i| (0..i).all(|j| entry(i, j) == entry(j, i)))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1000))]

        #[test]
        fn small_integers_agree(
            masses in prop::collection::vec(prop::sample::select(vec![1u8, 2, 4]), 3),
            springs in prop::collection::vec(0i8..3, 4),
            dampers in prop::collection::vec(0i8..3, 4),
        ) {
            let values = |list: &[i8]| -> Vec<f64> { list.iter().map(|&x| x.into()).collect() };
            let lumped: Vec<f64> = masses.iter().map(|&m| m.into()).collect();
            let system = chain(&lumped, &values(&springs), &values(&dampers));
            let expected = commutes(&masses, &system.damping_matrix(), &system.stiffness_matrix());
            prop_assert_eq!(verdict(&system), if expected { Proved } else { Disproved });
        }
    }
}
