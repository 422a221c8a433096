//! M, C or K of a system, each entry an unevaluated sum of doubles.

use std::cmp::Ordering;

use super::prime_field::{PrimeField, Residue};
use super::sum::{ExactSum, Extent, Parts};
use crate::model::MatrixKind;
use crate::model::Model;

/// Every double is a multiple of 2 to this power.
const LOWEST: i32 = -1074;

/// A square sparse matrix by rows. Entries are exact sums of their terms; those that sum to 0 are
/// not there.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ExactMatrix {
    /// Where each row's entries start, and where the last one's end.
    rows: Vec<usize>,
    columns: Vec<usize>,
    /// Where each entry's terms start, and where the last one's end.
    starts: Vec<usize>,
    terms: Vec<f64>,
}

impl ExactMatrix {
    /// The matrix of this kind: elements and added matrix together.
    pub(crate) fn of(model: &Model, kind: MatrixKind) -> ExactMatrix {
        let mut parts = Vec::new();
        // `for_each` runs chained iterators several times as fast as `collect` does.
        model
            .terms(kind)
            .for_each(|term| parts.push((term.row, term.column, term.value)));
        ExactMatrix::from_parts(model.len(), parts)
    }

    /// From summands (row, column, value).
    pub(crate) fn from_parts(n: usize, mut parts: Vec<(usize, usize, f64)>) -> ExactMatrix {
        parts.retain(|part| part.2 != 0.0);
        let parts = by_rows(n, &parts);
        let mut matrix = ExactMatrix {
            rows: vec![0; n + 1],
            columns: Vec::with_capacity(parts.len()),
            starts: Vec::with_capacity(parts.len() + 1),
            terms: Vec::with_capacity(parts.len()),
        };
        matrix.starts.push(0);
        for entry in parts.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let start = matrix.terms.len();
            matrix.terms.extend(entry.iter().map(|part| part.2));
            if entry.len() > 1 && ExactSum::sign_of(&matrix.terms[start..]) == Ordering::Equal {
                matrix.terms.truncate(start);
                continue;
            }
            matrix.columns.push(entry[0].1);
            matrix.starts.push(matrix.terms.len());
            matrix.rows[entry[0].0 + 1] = matrix.columns.len();
        }
        for i in 0..n {
            matrix.rows[i + 1] = matrix.rows[i + 1].max(matrix.rows[i]);
        }
        matrix
    }

    pub(crate) fn transposed(&self) -> ExactMatrix {
        let row = |i| {
            let entries = self.row(i);
            entries.flat_map(move |(j, terms)| terms.iter().map(move |&term| (j, i, term)))
        };
        ExactMatrix::from_parts(self.len(), (0..self.len()).flat_map(row).collect())
    }

    /// The sum of two matrices.
    pub(crate) fn plus(&self, other: &ExactMatrix) -> ExactMatrix {
        let mut parts = Vec::new();
        for matrix in [self, other] {
            for i in 0..matrix.len() {
                for (j, terms) in matrix.row(i) {
                    parts.extend(terms.iter().map(|&term| (i, j, term)));
                }
            }
        }
        ExactMatrix::from_parts(self.len(), parts)
    }

    /// The matrix times a finite double; `None` where a product leaves the range of doubles.
    pub(crate) fn times(&self, factor: f64) -> Option<ExactMatrix> {
        let low = Parts::of(factor).exponent;
        let mut parts = Vec::with_capacity(2 * self.terms.len());
        for i in 0..self.len() {
            for (j, terms) in self.row(i) {
                for &term in terms {
                    let product = term * factor;
                    if !product.is_finite() || Parts::of(term).exponent + low < LOWEST {
                        return None;
                    }
                    parts.push((i, j, product));
                    parts.push((i, j, term.mul_add(factor, -product)));
                }
            }
        }
        Some(ExactMatrix::from_parts(self.len(), parts))
    }

    /// The order n of the matrix.
    pub(crate) fn len(&self) -> usize {
        self.rows.len() - 1
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.columns.is_empty()
    }

    pub(crate) fn is_diagonal(&self) -> bool {
        (0..self.len()).all(|i| {
            self.columns[self.rows[i]..self.rows[i + 1]]
                .iter()
                .all(|&j| j == i)
        })
    }

    /// The columns of row `i`, rising, each with the terms of its entry.
    pub(crate) fn row(&self, i: usize) -> impl Iterator<Item = (usize, &[f64])> {
        (self.rows[i]..self.rows[i + 1]).map(|at| (self.columns[at], self.terms_at(at)))
    }

    /// The terms of all entries of row `i`.
    pub(crate) fn row_terms(&self, i: usize) -> &[f64] {
        &self.terms[self.starts[self.rows[i]]..self.starts[self.rows[i + 1]]]
    }

    /// The terms of entry (i, j); none for one that is 0.
    pub(crate) fn entry(&self, i: usize, j: usize) -> &[f64] {
        let start = self.rows[i];
        match self.columns[start..self.rows[i + 1]].binary_search(&j) {
            Ok(at) => self.terms_at(start + at),
            Err(_) => &[],
        }
    }

    fn terms_at(&self, at: usize) -> &[f64] {
        &self.terms[self.starts[at]..self.starts[at + 1]]
    }

    /// Where the bits of the entries of row `i` lie.
    pub(crate) fn extent(&self, i: usize) -> Extent {
        self.row(i).fold(Extent::NOTHING, |extent, (_, terms)| {
            extent.join(Extent::of(terms))
        })
    }

    /// Where the bits of all entries lie.
    pub(crate) fn extent_of_all(&self) -> Extent {
        (0..self.len()).fold(Extent::NOTHING, |extent, i| extent.join(self.extent(i)))
    }

    /// The matrix modulo the field's prime.
    pub(crate) fn image<'a>(&'a self, field: &PrimeField) -> Image<'a> {
        let entries = 0..self.columns.len();
        Image {
            matrix: self,
            values: entries.map(|at| field.sum_of(self.terms_at(at))).collect(),
        }
    }
}

/// Summands in the order of their entries, those of one entry in the order in which they were given.
fn by_rows(n: usize, parts: &[(usize, usize, f64)]) -> Vec<(usize, usize, f64)> {
    let mut starts = vec![0; n + 1];
    parts.iter().for_each(|part| starts[part.0 + 1] += 1);
    for i in 0..n {
        starts[i + 1] += starts[i];
    }
    let mut next = starts.clone();
    let mut sorted = vec![(0, 0, 0.0); parts.len()];
    for part in parts {
        sorted[next[part.0]] = *part;
        next[part.0] += 1;
    }
    for row in starts.windows(2) {
        let row = &mut sorted[row[0]..row[1]];
        if !row.is_sorted_by_key(|part| part.1) {
            row.sort_by_key(|part| part.1);
        }
    }
    sorted
}

/// An [`ExactMatrix`] modulo a prime. Entries may be 0.
pub(crate) struct Image<'a> {
    matrix: &'a ExactMatrix,
    values: Vec<Residue>,
}

impl Image<'_> {
    /// The columns of row `i`, rising, each with its entry.
    pub(crate) fn row(&self, i: usize) -> impl Iterator<Item = (usize, Residue)> {
        let range = self.matrix.rows[i]..self.matrix.rows[i + 1];
        range.map(|at| (self.matrix.columns[at], self.values[at]))
    }

    /// All entries, zeros included.
    pub(crate) fn rows(&self) -> Vec<Vec<Residue>> {
        let n = self.matrix.len();
        let row = |i| {
            let mut row = vec![Residue::ZERO; n];
            self.row(i).for_each(|(j, value)| row[j] = value);
            row
        };
        (0..n).map(row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn products_are_exact(a in any::<f64>(), b in any::<f64>(), factor in any::<f64>()) {
            prop_assume!(a.is_finite() && b.is_finite() && factor.is_finite());
            let matrix = ExactMatrix::from_parts(2, vec![(0, 0, a), (0, 1, b), (0, 1, 1.0), (1, 0, -b)]);
            // A product that is not refused has the right image modulo two primes.
            for field in PrimeField::all().take(2) {
                let Some(product) = matrix.times(factor) else {
                    let finite = [a, b, 1.0].iter().all(|x| (x * factor).is_finite());
                    let far = [a, b, 1.0].iter().all(|x| (x * factor).abs() > 1e-250);
                    prop_assert!(!(finite && far));
                    continue;
                };
                for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    let expected = field.product(field.sum_of(matrix.entry(i, j)), field.double(factor));
                    prop_assert_eq!(field.sum_of(product.entry(i, j)), expected);
                }
            }
        }
    }
}
