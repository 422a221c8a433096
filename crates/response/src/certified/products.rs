//! Products of matrices with vectors: of doubles by rows, and with more digits by columns.

use std::ops::Range;

use eigentone_digits::Real;
use pulp::Arch;

/// A matrix by columns: all entries of a product with a vector are summed side by side.
pub(super) struct Columns<T> {
    pub(super) rows: usize,
    blocks: Vec<Block<T>>,
}

/// So many columns are multiplied at once.
const AT_ONCE: usize = 8;

/// Some columns, in all rows in which one of them is not 0.
struct Block<T> {
    rows: Range<usize>,
    columns: Vec<(usize, Vec<T>)>,
}

impl<T: Real> Columns<T> {
    pub(super) fn of(rows: usize, columns: usize, entry: impl Fn(usize, usize) -> T) -> Columns<T> {
        let is_filled = |i: usize, j: usize| !entry(i, j).is_zero();
        let filled: Vec<usize> = (0..columns)
            .filter(|&j| (0..rows).any(|i| is_filled(i, j)))
            .collect();
        let block = |columns: &[usize]| {
            let is_empty = |i: &usize| !columns.iter().any(|&j| is_filled(*i, j));
            let first = (0..rows).take_while(is_empty).count();
            let last = (0..rows).rev().take_while(is_empty).count();
            let rows = first..rows - last;
            let column = |j: usize| rows.clone().map(|i| entry(i, j)).collect();
            Block {
                columns: columns.iter().map(|&j| (j, column(j))).collect(),
                rows,
            }
        };
        Columns {
            rows,
            blocks: filled.chunks(AT_ONCE).map(block).collect(),
        }
    }

    /// The product with a vector.
    pub(super) fn apply(&self, vector: &[T], product: &mut [T]) {
        product.fill(T::ZERO);
        for block in &self.blocks {
            let mut terms = [(T::ZERO, &[][..]); AT_ONCE];
            let mut count = 0;
            for (j, entries) in &block.columns {
                if !vector[*j].is_zero() {
                    terms[count] = (vector[*j], entries);
                    count += 1;
                }
            }
            T::add_multiples(&mut product[block.rows.clone()], &terms[..count]);
        }
    }
}

/// The product of a matrix, by rows, and a vector.
pub(super) fn multiply(matrix: &[f64], vector: &[f64], product: &mut [f64]) {
    const LANES: usize = 8;
    let rows = matrix.chunks_exact(vector.len().max(1));
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for (entry, row) in product.iter_mut().zip(rows) {
                let (row, rest) = row.as_chunks::<LANES>();
                let (heads, tail) = vector.as_chunks::<LANES>();
                let mut sums = [0.0; LANES];
                for (row, head) in row.iter().zip(heads) {
                    for lane in 0..LANES {
                        sums[lane] += row[lane] * head[lane];
                    }
                }
                let rest = rest.iter().zip(tail).map(|(a, b)| a * b);
                *entry = sums.into_iter().chain(rest).sum();
            }
        },
    );
}
