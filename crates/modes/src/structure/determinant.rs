//! The polynomial det(λ²M + λC + K): whether it vanishes, its degree, and its order at λ = 0, all
//! in exact arithmetic. The degree is the number of finite roots, the order that of zero roots.
//!
//! Both come from one argument, read forwards and backwards. In det(A₀ + λA₁ + λ²A₂) with
//! symmetric A, a floating part S of the network A₀ has A₀ e_S = 0, so the sum of its columns
//! holds a factor λ; one that floats on A₀ and A₁ together holds λ². So λ = 0 is a root at least
//! that often; it is no more than that if the determinant of what is left does not vanish at
//! λ = 0. That is certain where the three networks have no negative join, and otherwise shown by
//! one determinant modulo a prime. Other null vectors of A₀, found as such ([`null_space`](crate::exact::null_space)), serve
//! like floating parts. Where this proves nothing, all coefficients are computed modulo
//! primes: other than 0 once is a proof, and 0 is proved by primes whose product exceeds every
//! possible coefficient.

use super::coefficients::{Coefficient, Coefficients};
use super::polynomial::Reduced;
use super::support::floating;
use crate::exact::elimination::{Row, eliminate};
use crate::exact::null_space::{NullVector, annulled, null_vectors_modulo};
use crate::exact::prime_field::{MOST_WORK, PRIME_BITS, PrimeField, Residue};
use crate::exact::rank::rank;
use crate::exact::sum::{Extent, ceil_log2};
use crate::model::MAX_DENSE_COORDINATES;
use crate::model::MatrixKind;
use crate::model::Model;

/// The most coordinates for which coefficients are computed.
const MOST_COORDINATES: usize = 100;

/// Where a determinant that is 0 cannot be proved to vanish within [`MOST_WORK`], it is 0 at so
/// many points, modulo as many primes.
const ZERO_TESTS: usize = 3;

/// Whether the polynomial vanishes for every λ. `false` is always proved. `true` is proved for
/// floating parts without mass, and for systems small enough for [`MOST_WORK`]; beyond, it rests
/// on 0 at [`ZERO_TESTS`] points, each modulo another prime above 2^60. Of large systems only floating parts
/// without mass are looked for.
pub(crate) fn vanishes<'a>(model: &Model, coefficients: impl FnOnce() -> &'a Coefficients) -> bool {
    let lumped = model.is_of_elements(MatrixKind::Mass);
    if lumped && model.masses().iter().all(|&mass| mass > 0.0) {
        return false;
    }
    let coefficients = coefficients();
    if model.is_large() {
        return Order::at_zero(coefficients) == Order::Infinite;
    }
    match Order::at_zero(coefficients) {
        Order::Infinite => return true,
        Order::Exactly(_) => return false,
        Order::NotProved => {}
    }
    Order::at_infinity(coefficients) == Order::NotProved
        && PrimeField::all()
            .take(ZERO_TESTS)
            .enumerate()
            .all(|(point, field)| {
                Reduced::new(coefficients, &field)
                    .at(point as u64 + 2)
                    .determinant
                    .is_zero()
            })
        && Terms::of(coefficients).is_none_or(|terms| terms.range.is_none())
}

/// How many roots are finite and how many are 0, where that is proved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Roots {
    pub(crate) zero: Option<usize>,
    pub(crate) finite: Option<usize>,
}

impl Roots {
    /// Of a system whose determinant does not vanish.
    pub(crate) fn of(coefficients: &Coefficients) -> Roots {
        let n = coefficients.mass.matrix.len();
        let zero = Order::at_zero(coefficients).exactly();
        let finite = Order::at_infinity(coefficients)
            .exactly()
            .map(|infinite| 2 * n - infinite);
        if zero.is_some() && finite.is_some() {
            return Roots { zero, finite };
        }
        let Some(terms) = Terms::of(coefficients) else {
            return Roots { zero, finite };
        };
        let lowest = terms.range.map(|range| range.0);
        let highest = terms.range.map(|range| range.1);
        Roots {
            zero: zero.or(lowest.filter(|&lowest| terms.all || lowest == 0)),
            finite: finite.or(highest.filter(|&highest| terms.all || highest == terms.bound)),
        }
    }
}

/// Which powers of λ occur in the determinant.
struct Terms {
    /// The lowest and the highest whose coefficient was seen not to be 0.
    range: Option<(usize, usize)>,
    /// No higher one can occur.
    bound: usize,
    /// Whether all others are proved not to occur.
    all: bool,
}

impl Terms {
    /// From the coefficients modulo as many primes as prove those that are 0, or modulo one where so
    /// many are too much work; `None` where one is.
    fn of(coefficients: &Coefficients) -> Option<Terms> {
        if coefficients.mass.matrix.len() > MOST_COORDINATES {
            return None;
        }
        let (bound, bits) = bounds(coefficients, common_shift(&[coefficients]));
        let mut primes = bits / PRIME_BITS + 1;
        let mut all = true;
        let mut range = None;
        for (tried, field) in PrimeField::all().enumerate() {
            if tried as u64 == primes || range == Some((0, bound)) {
                break;
            }
            let reduced = Reduced::new(coefficients, &field);
            if tried == 0 {
                let points = bound as u64 + 1;
                all = primes * points * (reduced.at(2).work + points) <= MOST_WORK;
                primes = if all { primes } else { 1 };
            }
            let terms = reduced.coefficients(bound);
            for power in (0..terms.len()).filter(|&power| !terms[power].is_zero()) {
                let (lowest, highest) = range.unwrap_or((power, power));
                range = Some((lowest.min(power), highest.max(power)));
            }
        }
        Some(Terms { range, bound, all })
    }
}

/// K, C and M.
fn by_power(coefficients: &Coefficients) -> [&Coefficient; 3] {
    [
        &coefficients.stiffness,
        &coefficients.damping,
        &coefficients.mass,
    ]
}

/// The power of two by which λ is scaled to bring the coefficients of several systems closer together.
pub(super) fn common_shift(systems: &[&Coefficients]) -> i64 {
    let extent = |power: usize| {
        let each = systems
            .iter()
            .map(|one| by_power(one)[power].matrix.extent_of_all());
        each.fold(Extent::NOTHING, Extent::join)
    };
    let (first, last) = (extent(0), extent(2));
    if first.bits() > 0 && last.bits() > 0 {
        (first.high - last.high).div_euclid(2)
    } else {
        0
    }
}

/// A bound on the degree, and how many bits the sum of the coefficients' sizes has at most, as integers, once λ is scaled
/// by 2^shift and the rows by powers of two.
pub(super) fn bounds(coefficients: &Coefficients, shift: i64) -> (usize, u64) {
    let by_power = by_power(coefficients);
    let n = coefficients.mass.matrix.len();
    let (mut degree, mut bits) = (0, 0);
    for i in 0..n {
        let (mut row, mut count) = (Extent::NOTHING, 0);
        for (power, coefficient) in by_power.iter().enumerate() {
            let entries = coefficient.matrix.row(i).count();
            if entries > 0 {
                row = row.join(coefficient.matrix.extent(i).shifted(shift * power as i64));
                count += entries;
            }
        }
        degree += (0..3)
            .rev()
            .find(|&power| by_power[power].matrix.row(i).next().is_some())
            .unwrap_or(0);
        bits += row.bits() + ceil_log2(count) as u64;
    }
    (degree, bits)
}

/// How often λ = 0 is a root of det(A₀ + λA₁ + λ²A₂).
#[derive(Clone, Copy, Debug, PartialEq)]
enum Order {
    Exactly(usize),
    /// The determinant vanishes.
    Infinite,
    NotProved,
}

impl Order {
    fn at_zero(coefficients: &Coefficients) -> Order {
        Order::of([
            &coefficients.stiffness,
            &coefficients.damping,
            &coefficients.mass,
        ])
    }

    /// Of λ = ∞ as a root.
    fn at_infinity(coefficients: &Coefficients) -> Order {
        Order::of([
            &coefficients.mass,
            &coefficients.damping,
            &coefficients.stiffness,
        ])
    }

    fn exactly(self) -> Option<usize> {
        match self {
            Order::Exactly(order) => Some(order),
            Order::Infinite | Order::NotProved => None,
        }
    }

    fn of(parts: [&Coefficient; 3]) -> Order {
        let n = parts[0].matrix.len();
        let networks = parts.map(|part| part.network.as_ref());
        let [first, second, third] = networks;
        let whole = |sets: Vec<Vec<usize>>| -> Vec<NullVector> {
            sets.iter().map(|set| NullVector::whole(set)).collect()
        };
        let single = whole(first.map_or(Vec::new(), |first| floating(&[first])));
        let double = match (first, second) {
            (Some(first), Some(second)) => whole(floating(&[first, second])),
            _ => annulled(&parts[1].matrix, &single),
        };
        let order = Order::Exactly(single.len() + double.len());
        if let (Some(first), Some(second), Some(third)) = (first, second, third) {
            let all = [first, second, third];
            if !floating(&all).is_empty() {
                return Order::Infinite;
            }
            if all.iter().all(|network| network.is_non_negative()) {
                return order;
            }
        }
        if n > MAX_DENSE_COORDINATES {
            return Order::NotProved;
        }
        if single.is_empty() && parts[0].semidefinite_rank() == Some(n) {
            return order;
        }
        let proved = |single: &[NullVector], double: &[NullVector]| {
            PrimeField::all().take(2).any(|field| {
                // A part that floats on A₀ and A₁ together is several that float on A₀: it takes the place of one of these.
                let known =
                    |x: &NullVector| match double.iter().find(|other| other.place == x.place) {
                        Some(twice) => Known::of(twice, 2, &field),
                        None => Known::of(x, 1, &field),
                    };
                let known: Vec<Known> = single.iter().map(known).collect();
                leaves_something(parts, &known, &field)
            })
        };
        if proved(&single, &double) {
            return order;
        }
        if let Some(order) = Order::by_rank(parts) {
            return order;
        }
        // Motions of a body that is no network, such as those of finite elements.
        let all = parts[0].null_space().unwrap_or_default();
        let double = annulled(&parts[1].matrix, all);
        if all.len() > single.len() && proved(all, &double) {
            return Order::Exactly(all.len() + double.len());
        }
        Order::by_null_vectors_modulo(parts).unwrap_or(Order::NotProved)
    }

    /// Where null vectors of A₀ are no short fractions: λ = 0 is a root dim N(A₀) + dim(N(A₀) ∩ N(A₁)) times at least, of which
    /// the rank of A₀ gives the first and vectors that are short fractions the second. That it is no more often is shown with
    /// null vectors modulo a prime.
    fn by_null_vectors_modulo(parts: [&Coefficient; 3]) -> Option<Order> {
        let field = PrimeField::first();
        let known_rank = parts[0].semidefinite_rank();
        let rank = known_rank.or_else(|| rank(&parts[0].matrix))?;
        let nullity = parts[0].matrix.len() - rank;
        let single = null_vectors_modulo(&parts[0].matrix, &field);
        if nullity == 0 || single.len() != nullity {
            return None;
        }
        let pair = parts[0].plus(parts[1]);
        let double = annulled(&parts[0].matrix, pair.null_space().unwrap_or_default());
        let double = annulled(&parts[1].matrix, &double);
        // Each of the double ones takes the place of a single one that it has a share of, earlier ones taken out.
        let mut shares: Vec<(usize, Vec<Residue>)> = Vec::new();
        for vector in &double {
            let share = |(place, _): &(usize, Vec<Residue>)| {
                let mut entries = vector.entries.iter();
                let own = entries.find(|(i, _)| i == place);
                own.map_or(Residue::ZERO, |(_, entry)| field.double(*entry))
            };
            let mut row: Vec<Residue> = single.iter().map(share).collect();
            for (pivot, other) in &shares {
                let factor = field.product(row[*pivot], field.inverse(other[*pivot]));
                for (entry, other) in row.iter_mut().zip(other) {
                    *entry = field.difference(*entry, field.product(factor, *other));
                }
            }
            let pivot = row.iter().position(|entry| !entry.is_zero())?;
            shares.push((pivot, row));
        }
        let mut known: Vec<Known> = single
            .into_iter()
            .map(|(place, vector)| Known {
                place,
                power: 1,
                entries: vector.into_iter().enumerate().collect(),
            })
            .collect();
        for (vector, (pivot, _)) in double.iter().zip(&shares) {
            let place = known[*pivot].place;
            known[*pivot] = Known {
                place,
                ..Known::of(vector, 2, &field)
            };
        }
        let order = Order::Exactly(nullity + double.len());
        leaves_something(parts, &known, &field).then_some(order)
    }

    /// dim N(A₀) + dim(N(A₀) ∩ N(A₁)) for positive semidefinite matrices; the determinant
    /// vanishes where the three share a null vector.
    fn by_rank(parts: [&Coefficient; 3]) -> Option<Order> {
        let n = parts[0].matrix.len();
        let first = parts[0].semidefinite_rank()?;
        let pair = parts[0].plus(parts[1]);
        let second = parts[1].semidefinite_rank().and(pair.semidefinite_rank())?;
        let all = pair.plus(parts[2]);
        let all = parts[2].semidefinite_rank().and(all.semidefinite_rank())?;
        Some(if all == n {
            Order::Exactly(2 * n - first - second)
        } else {
            Order::Infinite
        })
    }
}

/// A null vector x of A₀, modulo a prime, and the column that it replaces.
struct Known {
    place: usize,
    entries: Vec<(usize, Residue)>,
    /// The power of λ that (A₀ + λA₁ + λ²A₂)x has as a factor.
    power: usize,
}

impl Known {
    fn of(vector: &NullVector, power: usize, field: &PrimeField) -> Known {
        let entries = vector.entries.iter();
        Known {
            place: vector.place,
            entries: entries.map(|&(j, x)| (j, field.double(x))).collect(),
            power,
        }
    }
}

/// Whether, at λ = 0, a determinant other than 0 is left of A₀ + λA₁ + λ²A₂ once the columns at the places of null
/// vectors are replaced by its products with these and divided by their powers of λ.
fn leaves_something(parts: [&Coefficient; 3], known: &[Known], field: &PrimeField) -> bool {
    let n = parts[0].matrix.len();
    // What a node's column adds to the columns at the places of vectors.
    let shares = |power: usize| {
        let mut shares = vec![Vec::new(); n];
        for vector in known.iter().filter(|vector| vector.power == power) {
            for &(j, entry) in &vector.entries {
                shares[j].push((vector.place, entry));
            }
        }
        shares
    };
    let (once_shares, twice_shares) = (shares(1), shares(2));
    let mut replaced = vec![false; n];
    known.iter().for_each(|x| replaced[x.place] = true);
    let images = parts.map(|part| part.matrix.image(field));
    let rows = (0..n).map(|i| {
        let mut entries: Vec<(usize, Residue)> =
            images[0].row(i).filter(|&(j, _)| !replaced[j]).collect();
        for (image, shares) in [(&images[1], &once_shares), (&images[2], &twice_shares)] {
            for (j, value) in image.row(i) {
                let added = shares[j].iter();
                entries.extend(added.map(|&(place, share)| (place, field.product(share, value))));
            }
        }
        Row::new(field, &entries)
    });
    !eliminate(field, rows.collect()).determinant.is_zero()
}

#[cfg(test)]
mod tests {
    use super::super::samples::{
        as_matrices, chain, matrices, network, triple_defect, with_matrices,
    };
    use super::*;
    use crate::system::System;
    use faer::{Mat, mat};
    use proptest::prelude::*;
    use std::ops::Range;

    /// (finite, zero), `None` where the determinant vanishes.
    fn roots(system: &System) -> Option<(usize, usize)> {
        if system.is_singular() {
            return None;
        }
        let roots = Roots::of(&Coefficients::of(system.model()));
        Some((
            roots.finite.expect("finite roots proved"),
            roots.zero.expect("zero roots proved"),
        ))
    }

    /// By coefficients modulo primes alone.
    fn computed(system: &System) -> Option<(usize, usize)> {
        let terms = Terms::of(&Coefficients::of(system.model())).expect("small enough");
        assert!(terms.all);
        terms.range.map(|(lowest, highest)| (highest, lowest))
    }

    #[track_caller]
    fn are_counted(system: &System, finite_and_zero: (usize, usize)) {
        assert_eq!(roots(system), Some(finite_and_zero));
    }

    #[test]
    fn masses_held_by_springs_have_no_zero_root() {
        are_counted(&chain(&[1.0; 3], &[1.0; 4], &[0.1; 4]), (6, 0));
        are_counted(&chain(&[1.0], &[1.0], &[]), (2, 0));
    }

    #[test]
    fn free_motions_are_counted() {
        let free = [(1, 2, 100.0), (2, 3, 200.0)];
        are_counted(
            &network(&[1.0, 2.0, 3.0], &free, &[(1, 2, 0.1), (2, 3, 0.1)]),
            (6, 2),
        );
        are_counted(&network(&[1.0, 2.0, 3.0], &free, &[(0, 3, 0.1)]), (6, 1));
        are_counted(&network(&[2.0], &[], &[(0, 1, 5.0)]), (2, 1));
        are_counted(&network(&[2.0, 3.0], &[], &[(1, 2, 5.0)]), (4, 3));
        are_counted(&network(&[2.0, 3.0], &[], &[]), (4, 4));
    }

    #[test]
    fn springs_that_cancel_join_nothing() {
        let springs = [(0, 1, 0.5), (0, 1, 0.25), (1, 2, 1.0), (0, 1, -0.75)];
        are_counted(&network(&[1.0, 1.0], &springs, &[]), (4, 2));
        // 0.1 + 0.2 − 0.3 is not 0 as doubles go.
        let springs = [(0, 1, 0.1), (0, 1, 0.2), (1, 2, 1.0), (0, 1, -0.3)];
        are_counted(&network(&[1.0, 1.0], &springs, &[]), (4, 0));
    }

    #[test]
    fn massless_nodes_lower_the_degree() {
        are_counted(&triple_defect(), (3, 0));
        let springs = [(0, 1, 3.0), (1, 2, 24.0)];
        are_counted(&network(&[9.0, 0.0], &springs, &[(0, 2, 8.0)]), (3, 0));
        are_counted(&network(&[9.0, 0.0], &springs, &[]), (2, 0));
        // A damper between massless nodes: one relaxation root, for only their distance relaxes.
        let springs = [(0, 1, 1.0), (1, 2, 2.0), (3, 4, 2.0)];
        are_counted(
            &network(&[1.0, 0.0, 0.0, 1.0], &springs, &[(2, 3, 1.0)]),
            (5, 1),
        );
        // A massless node held by nothing but a damper.
        are_counted(
            &network(&[1.0, 0.0], &[(0, 1, 1.0)], &[(1, 2, 1.0)]),
            (3, 1),
        );
    }

    #[test]
    fn a_massless_node_that_meets_nothing_is_singular() {
        assert_eq!(roots(&network(&[1.0, 0.0], &[(0, 1, 1.0)], &[])), None);
        assert_eq!(
            roots(&network(&[1.0, 0.0, 0.0], &[(0, 1, 1.0), (2, 3, 1.0)], &[])),
            None
        );
        assert_eq!(
            roots(&network(&[0.0], &[(0, 1, 1.0), (0, 1, -1.0)], &[])),
            None
        );
        let zero = || Mat::zeros(2, 2);
        assert_eq!(
            roots(&matrices(zero(), zero(), mat![[1.0, 2.0], [0.5, 1.0]])),
            None
        );
        are_counted(
            &matrices(zero(), zero(), mat![[1.0, 2.0], [0.5, 1.0 + 1e-15]]),
            (0, 0),
        );
        // Singular at every λ without a common null vector.
        let nilpotent = [
            mat![[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]],
            mat![[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]],
        ];
        let [c, k] = nilpotent;
        assert_eq!(
            roots(&matrices(
                Mat::zeros(3, 3),
                &c + c.transpose(),
                &k + k.transpose()
            )),
            None
        );
    }

    #[test]
    fn opposite_springs_on_a_massless_node_lower_the_degree_further() {
        // K_pp = 0, K_pm = (−k, k): det = −k²(λ²(m₁ + m₂) + …).
        let springs = [(1, 3, 2.0), (2, 3, -2.0), (0, 1, 1.0), (0, 2, 1.0)];
        are_counted(&network(&[1.0, 4.0, 0.0], &springs, &[]), (2, 0));
    }

    #[test]
    fn mass_matrices_of_every_kind() {
        let identity = || Mat::<f64>::identity(2, 2);
        let zero = || Mat::<f64>::zeros(2, 2);
        are_counted(
            &matrices(mat![[2.0, 1.0], [1.0, 2.0]], zero(), identity()),
            (4, 0),
        );
        // One mass on the sum of two coordinates.
        are_counted(
            &matrices(mat![[1.0, 1.0], [1.0, 1.0]], zero(), identity()),
            (2, 0),
        );
        // Follower force: K singular and not symmetric.
        are_counted(
            &matrices(identity(), zero(), mat![[1.0, -1.0], [2.0, -2.0]]),
            (4, 2),
        );
        are_counted(
            &matrices(identity(), mat![[0.0, 1.0], [-1.0, 0.0]], zero()),
            (4, 2),
        );
    }

    #[test]
    fn a_stiffness_indefinite_along_a_floating_part_is_counted() {
        // On the floating pair, C and the join to it cancel at λ = 0: det = λ³(…) by hand.
        let system = network(&[1.0, 1.0], &[(1, 2, 1.0)], &[(0, 1, 1.0), (0, 2, -1.0)]);
        // Q = [λ²+λ+1, −1; −1, λ²−λ+1], det = λ⁴ + λ².
        are_counted(&system, (4, 2));
    }

    #[test]
    fn massless_nodes_that_a_damper_joins_are_counted_with_springs_of_either_sign() {
        // det = λ²((λ + 1)(λ − 1) − λ²) + 1 − 1 = −λ².
        let springs = [(1, 2, 1.0), (3, 1, -1.0)];
        let system = network(&[1.0, 0.0, 0.0], &springs, &[(2, 3, 1.0)]);
        are_counted(&system, (2, 2));
    }

    #[test]
    fn every_magnitude_counts() {
        let tiny = f64::from_bits(1);
        let springs = [(0, 1, 1e300), (1, 2, tiny), (2, 3, 1e-300)];
        are_counted(&network(&[1e300, tiny, 1e-300], &springs, &[]), (6, 0));
        are_counted(
            &network(&[1e300, 0.0, tiny], &springs, &[(0, 2, -tiny)]),
            (5, 0),
        );
        let k = mat![[1e300, 1e-300], [1e300, 2e-300]];
        are_counted(&matrices(Mat::identity(2, 2), Mat::zeros(2, 2), k), (4, 0));
        let k = mat![[1e300, 1e-300], [2e300, 2e-300]];
        are_counted(&matrices(Mat::identity(2, 2), Mat::zeros(2, 2), k), (4, 2));
    }

    #[test]
    fn forces_that_are_not_symmetric() {
        // A follower force on the first two of many masses, a massless node between others.
        let n = 150;
        let force = Mat::from_fn(n, n, |i, j| if (i, j) == (0, 1) { 0.5 } else { 0.0 });
        let mut masses = vec![1.0; n];
        masses[70] = 0.0;
        let springs: Vec<_> = (0..n).map(|i| (i, i + 1, 1.0)).collect();
        for (damping, stiffness) in [(Some(force.clone()), None), (None, Some(force))] {
            let system = with_matrices(&masses, &springs, &[], [None, damping, stiffness]);
            are_counted(&system, (2 * n - 2, 0));
        }
        // Gyroscopic coupling to a massless node: det [λ² λ; −λ 1] = 2λ².
        let gyroscopic = mat![[0.0, 1.0], [-1.0, 0.0]];
        let system = with_matrices(
            &[1.0, 0.0],
            &[(0, 2, 1.0)],
            &[],
            [None, Some(gyroscopic), None],
        );
        are_counted(&system, (2, 2));
    }

    #[test]
    fn long_chains_of_either_sign_are_counted() {
        let n = 2000;
        let mut springs = vec![1.0; n];
        springs[n / 2] = -3.0;
        springs[0] = 0.0;
        let mut masses = vec![1.0; n];
        masses[7] = 0.0;
        are_counted(&chain(&masses, &springs, &[]), (2 * n - 2, 2));
    }

    /// Systems with massless nodes, missing and cancelling elements, of small integers.
    fn systems(range: Range<i32>) -> impl Strategy<Value = System> {
        (1usize..5).prop_flat_map(move |n| {
            let join = (0..=n, 0..=n, range.clone()).prop_filter("two ends", |j| j.0 != j.1);
            let joins =
                prop::collection::vec(join.prop_map(|(a, b, k)| (a, b, f64::from(k))), 0..7);
            (prop::collection::vec(0u8..3, n), joins.clone(), joins).prop_map(
                |(masses, springs, dampers)| {
                    let masses: Vec<f64> = masses.into_iter().map(f64::from).collect();
                    network(&masses, &springs, &dampers)
                },
            )
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1000))]

        #[test]
        fn the_graph_counts_as_the_coefficients_do(system in systems(0..4)) {
            prop_assert_eq!(roots(&system), computed(&system));
            prop_assert_eq!(roots(&as_matrices(&system)), computed(&system));
        }

        #[test]
        fn so_it_does_for_either_sign(
            system in prop_oneof![systems(-3..4), systems(-1..2)],
        ) {
            prop_assert_eq!(roots(&system), computed(&system));
        }
    }
}
