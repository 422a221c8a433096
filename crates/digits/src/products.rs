//! Products of matrices of doubles by faer, and what its kernels leave behind or stumble over.

use std::hint::black_box;
use std::mem::MaybeUninit;

use faer::dyn_stack::{MemBuffer, StackReq};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use pulp::Arch;

/// Doubles in the widest vector register.
const LANES: usize = 8;

/// A·B, m × n, of an m × k matrix and one of k × n, as faer rounds it.
///
/// The last rows of the left factor are [`even`] where that is needed, and the registers [settle].
pub fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let rows = a.nrows();
    let whole = match a.row_stride() {
        1 => rows - rows % LANES,
        _ => rows,
    };
    let product = if whole == rows {
        a * b
    } else {
        let mut product = Mat::zeros(rows, b.ncols());
        let (upper, lower) = product.as_mut().split_at_row_mut(whole);
        matmul(upper, Accum::Replace, a.subrows(0, whole), b, 1.0, Par::Seq);
        let rest = even(a.subrows(whole, rows - whole));
        let rest = rest.subrows(0, rows - whole);
        matmul(lower, Accum::Replace, rest, b, 1.0, Par::Seq);
        product
    };
    settle();
    product
}

/// The matrix with rows of zeros below it, up to a multiple of a register's length: as a left factor it is the submatrix of its
/// own rows.
///
/// faer's kernels read columns of a left factor to the end of a whole register. Where its rows do not fill it, what follows them is
/// whatever was in memory before, and where that is below the normal doubles, as small integers are, a product takes up to nine
/// times as long (0.24.4).
pub fn even(a: MatRef<'_, f64>) -> Mat<f64> {
    let rows = a.nrows();
    let mut even = Mat::zeros(rows.next_multiple_of(LANES), a.ncols());
    even.subrows_mut(0, rows).copy_from(a);
    even
}

/// Memory for a routine of faer, all 0: its own matrices are not [`even`] either.
pub fn workspace(needed: StackReq) -> MemBuffer {
    let mut memory = MemBuffer::new(needed);
    memory.fill(MaybeUninit::new(0));
    memory
}

/// Clears the upper halves of the vector registers. The kernels of faer's products leave something in
/// them, and x86 processors run code for the lower halves, which is what compilers make of ordinary
/// arithmetic, half as fast from then on. A function compiled for whole registers clears them as it returns.
pub fn settle() {
    let mut lanes = [1.0f64; 8];
    Arch::new().dispatch(|| {
        for lane in black_box(&mut lanes) {
            *lane += 1.0;
        }
    });
    black_box(lanes);
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
