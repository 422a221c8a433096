//! Gaussian elimination modulo a prime, on rows stored from their first to their last entry, so
//! that chains and bands cost no more than their width.

use super::prime_field::{PrimeField, Residue};

/// A row of a matrix: entries before `start` and after `values` are 0.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    start: usize,
    values: Vec<Residue>,
}

impl Row {
    /// From (column, value) in any order; values of one column add up.
    pub(crate) fn new(field: &PrimeField, parts: &[(usize, Residue)]) -> Row {
        let start = parts.iter().map(|part| part.0).min().unwrap_or(0);
        let end = parts.iter().map(|part| part.0 + 1).max().unwrap_or(0);
        let mut values = vec![Residue::ZERO; end - start];
        for &(column, value) in parts {
            values[column - start] = field.sum(values[column - start], value);
        }
        let mut row = Row { start, values };
        row.trim();
        row
    }

    /// From the first entry that is not 0.
    pub(crate) fn values(&self) -> &[Residue] {
        &self.values
    }

    /// Drops zeros in front.
    fn trim(&mut self) {
        let zeros = self
            .values
            .iter()
            .take_while(|value| value.is_zero())
            .count();
        self.values.drain(..zeros);
        self.start += zeros;
    }
}

/// What elimination shows of a square matrix modulo a prime.
#[derive(Debug)]
pub(crate) struct Echelon {
    /// The determinant.
    pub(crate) determinant: Residue,
    /// A largest set of independent rows, by index.
    pub(crate) independent: Vec<usize>,
    /// The row that begins in each column, once those above are taken out of it.
    pub(crate) pivots: Vec<Option<Row>>,
    /// How many multiplications it took.
    pub(crate) work: u64,
}

/// So many multiplications an inverse takes, about.
const INVERSE: usize = 120;

/// Eliminates the n rows of an n × n matrix.
pub(crate) fn eliminate(field: &PrimeField, rows: Vec<Row>) -> Echelon {
    let n = rows.len();
    let mut determinant = field.integer(1);
    // What rows were multiplied by.
    let mut scales = field.integer(1);
    let mut independent = Vec::with_capacity(n);
    let mut work = n as u64;
    let mut waiting: Vec<Vec<(usize, Row)>> = vec![Vec::new(); n];
    let mut pivots = vec![None; n];
    for (index, row) in rows.into_iter().enumerate() {
        if !row.values.is_empty() {
            waiting[row.start].push((index, row));
        }
    }
    for column in 0..n {
        let mut bucket = std::mem::take(&mut waiting[column]);
        let shortest = (0..bucket.len()).min_by_key(|&at| bucket[at].1.values.len());
        let Some(shortest) = shortest else { continue };
        let (index, pivot) = bucket.swap_remove(shortest);
        independent.push(index);
        determinant = field.product(determinant, pivot.values[0]);
        if bucket.is_empty() {
            pivots[column] = Some(pivot);
            continue;
        }
        let lead = pivot.values[0];
        let entries: usize = bucket.iter().map(|(_, row)| row.values.len()).sum();
        let inverse = (entries > INVERSE).then(|| field.inverse(lead));
        for (index, mut row) in bucket {
            let factor = match inverse {
                Some(inverse) => field.product(row.values[0], inverse),
                None => {
                    let factor = row.values[0];
                    scales = field.product(scales, lead);
                    let each = row.values.iter_mut();
                    each.for_each(|value| *value = field.product(*value, lead));
                    factor
                }
            };
            if row.values.len() < pivot.values.len() {
                row.values.resize(pivot.values.len(), Residue::ZERO);
            }
            for (value, &above) in row.values.iter_mut().zip(&pivot.values) {
                *value = field.difference(*value, field.product(factor, above));
            }
            work += pivot.values.len() as u64;
            row.trim();
            if !row.values.is_empty() {
                waiting[row.start].push((index, row));
            }
        }
        pivots[column] = Some(pivot);
    }
    if independent.len() < n {
        determinant = Residue::ZERO;
    } else {
        determinant = field.product(determinant, field.inverse(scales));
        if is_odd(&independent) {
            determinant = field.negative(determinant);
        }
    }
    Echelon {
        determinant,
        independent,
        pivots,
        work,
    }
}

/// A⁻¹B for an n × n matrix and n rows of any length; `None` if A is singular. A = LU with ones on the diagonal of U,
/// entry by entry (Crout), so that most of it are long sums of products, and substitution backwards.
pub(crate) fn solve(
    field: &PrimeField,
    mut a: Vec<Vec<Residue>>,
    mut b: Vec<Vec<Residue>>,
) -> Option<Vec<Vec<Residue>>> {
    let n = a.len();
    let width = b.first().map_or(0, Vec::len);
    // Rows of L, in place of those of A, and columns of U and of L⁻¹B.
    let mut upper: Vec<Vec<Residue>> = vec![Vec::with_capacity(n); n + width];
    for column in 0..n {
        for row in &mut a[column..] {
            let sum = field.dot(&row[..column], &upper[column]);
            row[column] = field.difference(row[column], sum);
        }
        let pivot = (column..n).find(|&i| !a[i][column].is_zero())?;
        a.swap(column, pivot);
        b.swap(column, pivot);
        let lower = &a[column];
        let scale = field.inverse(lower[column]);
        let entries = lower[column + 1..].iter().chain(&b[column]);
        let later = upper[column + 1..n + width].iter_mut();
        for (above, &entry) in later.zip(entries) {
            let left = field.difference(entry, field.dot(&lower[..column], above));
            above.push(field.product(left, scale));
        }
    }
    let (upper, found) = upper.split_at_mut(n);
    let row = |i: usize| -> Vec<Residue> { upper[i + 1..].iter().map(|above| above[i]).collect() };
    for i in (0..n).rev() {
        let row = row(i);
        for x in found.iter_mut() {
            x[i] = field.difference(x[i], field.dot(&row, &x[i + 1..]));
        }
    }
    Some(
        (0..n)
            .map(|i| found.iter().map(|x| x[i]).collect())
            .collect(),
    )
}

/// Whether a permutation of 0 … n − 1 is odd.
fn is_odd(permutation: &[usize]) -> bool {
    let mut seen = vec![false; permutation.len()];
    let mut cycles = 0;
    for start in 0..permutation.len() {
        cycles += usize::from(!seen[start]);
        let mut at = start;
        while !seen[at] {
            seen[at] = true;
            at = permutation[at];
        }
    }
    (permutation.len() - cycles) % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn rows(field: &PrimeField, entries: &[Vec<i64>]) -> Vec<Row> {
        let image = |value: i64| field.double(value as f64);
        let row = |row: &Vec<i64>| {
            Row::new(
                field,
                &row.iter()
                    .map(|&x| image(x))
                    .enumerate()
                    .collect::<Vec<_>>(),
            )
        };
        entries.iter().map(row).collect()
    }

    /// By expansion along the first row.
    fn expand(entries: &[Vec<i64>]) -> i64 {
        let Some(first) = entries.first() else {
            return 1;
        };
        let minor = |j: usize| -> Vec<Vec<i64>> {
            let without = |row: &Vec<i64>| [&row[..j], &row[j + 1..]].concat();
            entries[1..].iter().map(without).collect()
        };
        (0..first.len())
            .map(|j| if j % 2 == 0 { 1 } else { -1 } * first[j] * expand(&minor(j)))
            .sum()
    }

    #[test]
    fn rank_and_independent_rows() {
        let field = PrimeField::first();
        let matrix = [
            vec![0, 0, 0, 0],
            vec![1, 2, 0, 4],
            vec![2, 4, 0, 8],
            vec![0, 0, 0, 5],
        ];
        let echelon = eliminate(&field, rows(&field, &matrix));
        assert!(echelon.determinant.is_zero());
        assert_eq!(echelon.independent.len(), 2);
        assert!(echelon.independent.contains(&3));
    }

    /// The first pivots are worth an inverse, the last are not.
    #[test]
    fn determinants_of_long_rows_multiply() {
        const N: usize = 24;
        let f = PrimeField::first();
        let matrix = |seed: usize| -> Vec<Vec<Residue>> {
            let entry = |i: usize, j: usize| ((7 * i + 3 * j + seed).pow(3) + i * j) % 1009;
            let row = |i: usize| (0..N).map(|j| f.integer(entry(i, j) as u64)).collect();
            (0..N).map(row).collect()
        };
        let determinant = |matrix: &[Vec<Residue>]| {
            let parts = |row: &Vec<Residue>| row.iter().copied().enumerate().collect::<Vec<_>>();
            let rows = matrix.iter().map(|row| Row::new(&f, &parts(row)));
            eliminate(&f, rows.collect()).determinant
        };
        let (a, b) = (matrix(1), matrix(500));
        let entry = |i: usize, j: usize| {
            let products = (0..N).map(|l| f.product(a[i][l], b[l][j]));
            products.fold(Residue::ZERO, |sum, product| f.sum(sum, product))
        };
        let row = |i: usize| -> Vec<Residue> { (0..N).map(|j| entry(i, j)).collect() };
        let product: Vec<Vec<Residue>> = (0..N).map(row).collect();
        let [a, b, product] = [&a, &b, &product].map(|matrix| determinant(matrix));
        assert!(!a.is_zero() && !b.is_zero());
        assert_eq!(product, f.product(a, b));
    }

    proptest! {
        #[test]
        fn a_solution_solves(numbers in prop::collection::vec(-3i32..4, 32), n in 1usize..5) {
            let f = PrimeField::first();
            let part = |from: usize| -> Vec<Vec<Residue>> {
                let row = |i: usize| numbers[from + 4 * i..][..n].iter().map(|&x| f.double(x.into())).collect();
                (0..n).map(row).collect()
            };
            let (a, b) = (part(0), part(16));
            let rows = a.iter().map(|row| Row::new(&f, &row.iter().copied().enumerate().collect::<Vec<_>>()));
            let singular = eliminate(&f, rows.collect()).determinant.is_zero();
            let x = solve(&f, a.clone(), b.clone());
            prop_assert_eq!(x.is_none(), singular);
            for (i, j) in x.iter().flat_map(|_| (0..n * n).map(|at| (at / n, at % n))) {
                let x = x.as_ref().expect("it is iterated over");
                let sum = (0..n).fold(Residue::ZERO, |sum, l| f.sum(sum, f.product(a[i][l], x[l][j])));
                prop_assert_eq!(sum, b[i][j]);
            }
        }

        #[test]
        fn the_determinant_is_that_of_expansion(
            matrix in (1usize..6).prop_flat_map(|n| prop::collection::vec(prop::collection::vec(-3i64..4, n), n))
        ) {
            let field = PrimeField::first();
            let echelon = eliminate(&field, rows(&field, &matrix));
            let expected = expand(&matrix);
            prop_assert_eq!(echelon.determinant, field.double(expected as f64));
            prop_assert_eq!(echelon.independent.len() == matrix.len(), expected != 0);
        }
    }
}
