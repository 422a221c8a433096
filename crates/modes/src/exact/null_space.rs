//! Vectors of doubles that a matrix maps to exactly 0: found modulo a prime, verified in exact sums.
//!
//! Rigid motions of finite elements are such vectors where rounding of the entries leaves them; they bound the rank from
//! above however large the minors are.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use super::elimination::{Row, eliminate};
use super::matrix::ExactMatrix;
use super::prime_field::{PrimeField, Residue};
use super::sum::{ExactSum, Parts};

/// A basis of all x with A x = 0, or `None` where it has vectors that are no short binary fractions. Each has an entry
/// 1 at its own place, where all others are 0.
pub(crate) fn null_space(matrix: &ExactMatrix) -> Option<Vec<NullVector>> {
    let field = PrimeField::first();
    let vector = |(place, found): (usize, Vec<Residue>)| {
        let entries = found.into_iter().enumerate();
        let entry = |(i, residue)| Some((i, short_fraction(&field, residue)?));
        let entries: Option<Vec<(usize, f64)>> = entries
            .filter(|(_, residue)| !residue.is_zero())
            .map(entry)
            .collect();
        entries.map(|entries| NullVector { place, entries })
    };
    let all = null_vectors_modulo(matrix, &field).into_iter();
    let found: Vec<NullVector> = all.map(vector).collect::<Option<_>>()?;
    let count = found.len();
    (annulled(matrix, &found).len() == count).then_some(found)
}

/// A basis of all x with A x = 0 modulo a prime. Each has an entry 1 at its own place, which comes first, where all
/// others are 0.
pub(crate) fn null_vectors_modulo(
    matrix: &ExactMatrix,
    field: &PrimeField,
) -> Vec<(usize, Vec<Residue>)> {
    let n = matrix.len();
    let image = matrix.image(field);
    let row = |i| Row::new(field, &image.row(i).collect::<Vec<_>>());
    let echelon = eliminate(field, (0..n).map(row).collect());
    let free = (0..n).filter(|column| echelon.pivots[*column].is_none());
    let vector = |place| (place, null_vector(field, &echelon.pivots, place));
    free.map(vector).collect()
}

/// Independent vectors that a square matrix of so many rows maps to exactly 0, whose entries are the sums without rounding of what is
/// given for them, as (row, column, value): each by the places and values of what is not 0, with 1 first at a place where all others
/// are 0. All there are, or none where they are no short binary fractions, a value is not finite, or one stands outside of the matrix.
///
/// ```
/// use eigentone_modes::null_vectors;
///
/// // A lever of 1 to 2 on a spring.
/// let square = [(0, 0, 4.0), (0, 1, -2.0), (1, 0, -2.0), (1, 1, 1.0)];
/// assert_eq!(null_vectors(2, square.to_vec()), [[(1, 1.0), (0, 0.5)]]);
/// ```
pub fn null_vectors(size: usize, parts: Vec<(usize, usize, f64)>) -> Vec<Vec<(usize, f64)>> {
    let is_part = |part: &(usize, usize, f64)| part.0 < size && part.1 < size && part.2.is_finite();
    if !parts.iter().all(is_part) {
        return Vec::new();
    }
    let found = null_space(&ExactMatrix::from_parts(size, parts)).unwrap_or_default();
    let first = |vector: NullVector| {
        let mut entries = vector.entries;
        entries.sort_by_key(|(i, _)| *i != vector.place);
        entries
    };
    found.into_iter().map(first).collect()
}

/// A vector that a matrix maps to 0.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NullVector {
    /// Where it has the entry 1, and the others of its basis 0.
    pub(crate) place: usize,
    /// Those that are not 0, and where.
    pub(crate) entries: Vec<(usize, f64)>,
}

impl NullVector {
    /// 1 on a set of coordinates, 0 elsewhere.
    pub(crate) fn whole(part: &[usize]) -> NullVector {
        NullVector {
            place: part[0],
            entries: part.iter().map(|&i| (i, 1.0)).collect(),
        }
    }

    /// Whether all entries but those that are 0 are 1.
    pub(crate) fn is_whole(&self) -> bool {
        self.entries.iter().all(|(_, entry)| *entry == 1.0)
    }

    /// All n entries.
    pub(crate) fn dense(&self, n: usize) -> Vec<f64> {
        let mut dense = vec![0.0; n];
        self.entries.iter().for_each(|&(i, entry)| dense[i] = entry);
        dense
    }
}

/// Those vectors that a matrix maps to exactly 0; without those for which products leave the range of doubles.
pub(crate) fn annulled(matrix: &ExactMatrix, vectors: &[NullVector]) -> Vec<NullVector> {
    /// Every double is a multiple of 2 to this power.
    const LOWEST: i32 = -1074;
    let mut met: Vec<Vec<(usize, f64)>> = vec![Vec::new(); matrix.len()];
    for (at, vector) in vectors.iter().enumerate() {
        for &(i, entry) in &vector.entries {
            met[i].push((at, entry));
        }
    }
    let mut zero = vec![true; vectors.len()];
    for i in 0..matrix.len() {
        let mut sums = BTreeMap::new();
        for (j, terms) in matrix.row(i) {
            for &(at, x) in &met[j] {
                let sum = sums.entry(at).or_insert_with(ExactSum::new);
                for &term in terms {
                    let product = term * x;
                    let low = Parts::of(term).exponent + Parts::of(x).exponent;
                    if x == 1.0 {
                        sum.add(term);
                    } else if product.is_finite() && low >= LOWEST {
                        sum.add(product);
                        sum.add(term.mul_add(x, -product));
                    } else {
                        zero[at] = false;
                    }
                }
            }
        }
        for (at, sum) in sums {
            zero[at] &= sum.sign() == Ordering::Equal;
        }
    }
    let chosen = vectors.iter().zip(zero).filter(|(_, zero)| *zero);
    chosen.map(|(vector, _)| vector.clone()).collect()
}

/// The null vector of an echelon form with the entry 1 in one column without pivot and 0 in the others.
fn null_vector(field: &PrimeField, pivots: &[Option<Row>], place: usize) -> Vec<Residue> {
    let mut vector = vec![Residue::ZERO; pivots.len()];
    vector[place] = field.integer(1);
    for column in (0..place).rev() {
        let Some(row) = &pivots[column] else {
            continue;
        };
        let (own, rest) = row.values().split_first().expect("a pivot is an entry");
        let terms = rest.iter().zip(&vector[column + 1..]);
        let sum = terms.fold(Residue::ZERO, |sum, (&a, &x)| {
            if x.is_zero() {
                sum
            } else {
                field.sum(sum, field.product(a, x))
            }
        });
        if !sum.is_zero() {
            vector[column] = field.negative(field.product(sum, field.inverse(*own)));
        }
    }
    vector
}

/// The number a/2^k with few bits in a and small k that has this image.
fn short_fraction(field: &PrimeField, residue: Residue) -> Option<f64> {
    const BITS: u32 = 28;
    const LARGEST_SHIFT: i32 = 28;
    let mut scaled = residue;
    for shift in 0..=LARGEST_SHIFT {
        let value = field.signed(scaled);
        if value.unsigned_abs() < 1 << BITS {
            return Some(value as f64 * 2f64.powi(-shift));
        }
        scaled = field.sum(scaled, scaled);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::MatrixKind;
    use crate::structure::samples::{free_beam, matrices};
    use faer::Mat;

    fn vectors_of(stiffness: Mat<f64>) -> Option<Vec<Vec<f64>>> {
        let n = stiffness.nrows();
        let system = matrices(Mat::identity(n, n), Mat::zeros(n, n), stiffness);
        let found = null_space(&ExactMatrix::of(system.model(), MatrixKind::Stiffness))?;
        Some(found.iter().map(|vector| vector.dense(n)).collect())
    }

    /// Deflection and slope of a beam whose elements are ½ long move it as a whole.
    #[test]
    fn rigid_motions_of_a_beam_are_found() {
        let elements = 50;
        let found = vectors_of(free_beam(elements)).expect("short fractions");
        assert_eq!(found.len(), 2);
        let slope = |vector: &[f64]| vector[1];
        for vector in &found {
            for node in 1..=elements {
                let rise = vector[2 * node] - vector[2 * node - 2];
                let length = vector[2] - vector[0];
                assert_eq!((rise, vector[2 * node + 1]), (length, slope(vector)));
            }
        }
    }

    /// A change in the last bit of one entry leaves fewer, or none.
    #[test]
    fn what_is_regular_has_none() {
        let mut beam = free_beam(20);
        beam[(4, 4)] = beam[(4, 4)].next_up();
        let found = vectors_of(beam).expect("short fractions");
        assert_eq!(found.len(), 1);
        assert_eq!(vectors_of(Mat::identity(5, 5)), Some(Vec::new()));
    }

    /// x = (1, −1/3) is no binary fraction.
    #[test]
    fn other_fractions_are_refused() {
        let matrix = faer::mat![[1.0, 3.0], [3.0, 9.0]];
        let found = vectors_of(matrix).expect("integers");
        assert_eq!(found, [[-3.0, 1.0]]);
        let matrix = faer::mat![[9.0, 3.0], [3.0, 1.0]];
        assert_eq!(vectors_of(matrix), None);
    }
}
