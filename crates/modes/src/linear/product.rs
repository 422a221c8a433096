//! Products of matrices by faer, and memory for its routines, without what makes them slow.

use std::mem::MaybeUninit;

use eigentone_digits::settle;
use faer::dyn_stack::{MemBuffer, StackReq};
use faer::{Mat, MatRef};

/// Doubles in the widest vector register.
const LANES: usize = 8;

/// A·B.
///
/// faer's kernels read columns of A to the end of a whole register. Where A's rows do not fill it, what follows them is whatever was
/// in memory before, and where that is below the normal doubles, as small integers are, a product takes up to nine times as long
/// (0.24.4). Such a matrix is copied to where zeros follow.
pub(crate) fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let rows = a.nrows();
    let product = if rows.is_multiple_of(LANES) || a.row_stride() != 1 {
        a * b
    } else {
        let mut even = Mat::<f64>::zeros(rows.next_multiple_of(LANES), a.ncols());
        even.subrows_mut(0, rows).copy_from(a);
        even.subrows(0, rows) * b
    };
    settle();
    product
}

/// Memory for a routine of faer, all 0: its own matrices do not always fill it either.
pub(crate) fn workspace(needed: StackReq) -> MemBuffer {
    let mut memory = MemBuffer::new(needed);
    memory.fill(MaybeUninit::new(0));
    memory
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whole numbers, whose sums do not round, on both sides of a register's length.
    #[test]
    fn products_are_those_of_the_entries() {
        for (rows, inner, columns) in [(1, 1, 1), (7, 30, 9), (8, 30, 9), (61, 61, 61), (100, 3, 5)]
        {
            let entry = |i: usize, j: usize| ((7 * i + 3 * j) % 11) as f64 - 5.0;
            let a = Mat::from_fn(rows, inner, entry);
            let b = Mat::from_fn(inner, columns, entry);
            let found = [
                product(a.as_ref(), b.as_ref()),
                product(a.transpose().to_owned().transpose(), b.as_ref()),
            ];
            for i in 0..rows {
                for j in 0..columns {
                    let sum: f64 = (0..inner).map(|k| a[(i, k)] * b[(k, j)]).sum();
                    assert!(found.iter().all(|found| found[(i, j)] == sum));
                }
            }
        }
    }
}
