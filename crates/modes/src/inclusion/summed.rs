//! Sums of products in double-double, several side by side.

use eigentone_digits::{DoubleDouble, Lanes};
use pulp::{Arch, Simd, WithSimd};

/// So many sums at a time: one alone would wait for each of its own additions to end.
const LANES: usize = 8;

/// The rows of a matrix.
#[derive(Clone, Copy)]
pub(super) enum Rows<'a> {
    Full(&'a [Vec<DoubleDouble>]),
    /// By place and entry.
    Sparse(&'a [Vec<(usize, f64)>]),
}

/// All products of rows with columns, by rows, off by what [`Lanes::products`] and [`Lanes::sparse_products`] say; with
/// `is_symmetric` from what is on and above the diagonal.
pub(super) fn products(
    rows: Rows<'_>,
    columns: &[Vec<DoubleDouble>],
    is_symmetric: bool,
) -> Vec<DoubleDouble> {
    Arch::new().dispatch(Products {
        rows,
        columns,
        is_symmetric,
    })
}

struct Products<'a> {
    rows: Rows<'a>,
    columns: &'a [Vec<DoubleDouble>],
    is_symmetric: bool,
}

impl WithSimd for Products<'_> {
    type Output = Vec<DoubleDouble>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<DoubleDouble> {
        // Processors with vectors of doubles fuse multiplications and additions.
        if S::F64_LANES > 1 {
            self.sums::<true>()
        } else {
            self.sums::<false>()
        }
    }
}

impl Products<'_> {
    #[inline(always)]
    fn sums<const FUSED: bool>(self) -> Vec<DoubleDouble> {
        let size = self.columns.len();
        let length = self.columns.first().map_or(0, Vec::len);
        let count = match self.rows {
            Rows::Full(rows) => rows.len(),
            Rows::Sparse(rows) => rows.len(),
        };
        let mut sums = vec![DoubleDouble::ZERO; count * size];
        for (block, columns) in self.columns.chunks(LANES).enumerate() {
            let side_by_side = interleaved(columns, length);
            let j = block * LANES;
            let last = if self.is_symmetric {
                j + columns.len()
            } else {
                count
            };
            for i in 0..last {
                let found = match self.rows {
                    Rows::Full(rows) => Lanes::products::<FUSED>(&rows[i], &side_by_side),
                    Rows::Sparse(rows) => Lanes::sparse_products::<FUSED>(&rows[i], &side_by_side),
                };
                let found = (j..j + columns.len()).zip(found);
                for (j, sum) in found.filter(|(j, _)| i <= *j || !self.is_symmetric) {
                    sums[i * size + j] = sum;
                    if self.is_symmetric {
                        sums[j * size + i] = sum;
                    }
                }
            }
        }
        sums
    }
}

/// Columns side by side, entry by entry; those that are missing are 0.
fn interleaved(columns: &[Vec<DoubleDouble>], length: usize) -> Vec<Lanes<LANES>> {
    let mut rows = vec![Lanes::ZERO; length];
    for (lane, column) in columns.iter().enumerate() {
        for (row, entry) in rows.iter_mut().zip(column) {
            row.set(lane, *entry);
        }
    }
    rows
}
