//! M = L D Lᵀ of a symmetric matrix modulo a prime, within the envelope of its rows: a diagonal or a band costs no more than
//! its width.

use super::matrix::Image;
use super::prime_field::{PrimeField, Residue};

/// L, with ones on its diagonal, and the inverse of D.
pub(crate) struct Envelope<'a> {
    field: &'a PrimeField,
    /// Where each row of L starts, and its entries before the diagonal.
    rows: Vec<(usize, Vec<Residue>)>,
    inverse: Vec<Residue>,
    /// How many entries there are.
    entries: u64,
    /// How many multiplications it took.
    pub(crate) work: u64,
}

impl<'a> Envelope<'a> {
    /// Of these rows and columns of a matrix, which rise, where they are so many multiplications at most; `None` beyond, and
    /// where a leading minor vanishes modulo the prime.
    pub(crate) fn of(
        field: &'a PrimeField,
        matrix: &Image<'_>,
        chosen: &[usize],
        most: u64,
    ) -> Option<Envelope<'a>> {
        let n = chosen.len();
        let mut factor = Envelope {
            field,
            rows: Vec::with_capacity(n),
            inverse: Vec::with_capacity(n),
            entries: n as u64,
            work: 100 * n as u64,
        };
        for (i, &at) in chosen.iter().enumerate() {
            let lower = matrix.row(at).filter_map(|(column, value)| {
                let j = chosen.binary_search(&column).ok()?;
                (j <= i).then_some((j, value))
            });
            let lower: Vec<(usize, Residue)> = lower.collect();
            let start = lower.first()?.0;
            let mut row = vec![Residue::ZERO; i + 1 - start];
            lower.iter().for_each(|&(j, value)| row[j - start] = value);
            let mut pivot = row.pop()?;
            // First L D: each entry less what those before it make of the row above.
            for j in start..i {
                let (first, above) = &factor.rows[j];
                let from = start.max(*first);
                let sum = field.dot(&row[from - start..j - start], &above[from - first..]);
                row[j - start] = field.difference(row[j - start], sum);
                factor.work += (j - from) as u64;
            }
            if factor.work > most {
                return None;
            }
            let scaled: Vec<Residue> = row
                .iter()
                .zip(&factor.inverse[start..])
                .map(|(&value, &inverse)| field.product(value, inverse))
                .collect();
            pivot = field.difference(pivot, field.dot(&row, &scaled));
            if pivot.is_zero() {
                return None;
            }
            factor.entries += scaled.len() as u64;
            factor.inverse.push(field.inverse(pivot));
            factor.rows.push((start, scaled));
        }
        Some(factor)
    }

    /// M⁻¹ times a vector.
    pub(crate) fn solve(&self, vector: &[Residue]) -> Vec<Residue> {
        let field = self.field;
        let mut x = vector.to_vec();
        for (i, (start, row)) in self.rows.iter().enumerate() {
            x[i] = field.difference(x[i], field.dot(row, &x[*start..i]));
        }
        for (x, &inverse) in x.iter_mut().zip(&self.inverse) {
            *x = field.product(*x, inverse);
        }
        for (i, (start, row)) in self.rows.iter().enumerate().rev() {
            let factor = field.negative(x[i]);
            for (x, &entry) in x[*start..i].iter_mut().zip(row) {
                *x = field.sum(*x, field.product(factor, entry));
            }
        }
        x
    }

    /// How many multiplications that takes.
    pub(crate) fn step(&self) -> u64 {
        2 * self.entries
    }
}

#[cfg(test)]
mod tests {
    use super::super::matrix::ExactMatrix;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Of bands and of full matrices, whole or without some rows and columns.
        #[test]
        fn a_solution_solves(numbers in prop::collection::vec(-9i32..10, 64), n in 1usize..8, width in 0usize..8, skip in 0usize..9) {
            let entry = |i: usize, j: usize| f64::from(numbers[8 * i.max(j) + i.min(j)]);
            let all = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
            let band = all.filter(|(i, j)| i.abs_diff(*j) <= width);
            let parts = band.map(|(i, j)| (i, j, entry(i, j) + if i == j { 1000.0 } else { 0.0 }));
            let matrix = ExactMatrix::from_parts(n, parts.collect());
            let chosen: Vec<usize> = (0..n).filter(|i| *i != skip).collect();
            let field = PrimeField::first();
            let image = matrix.image(&field);
            let factor = Envelope::of(&field, &image, &chosen, u64::MAX).unwrap();
            let right: Vec<Residue> = (0..chosen.len() as u64).map(|i| field.integer(7 * i + 3)).collect();
            let x = factor.solve(&right);
            for (i, right) in chosen.iter().zip(&right) {
                let terms = image.row(*i).filter_map(|(j, value)| {
                    let at = chosen.binary_search(&j).ok()?;
                    Some(field.product(value, x[at]))
                });
                prop_assert_eq!(terms.fold(Residue::ZERO, |sum, term| field.sum(sum, term)), *right);
            }
        }
    }
}
