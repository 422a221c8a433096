//! How often the determinants of a function vanish at 0 and at ∞, in exact arithmetic: with K + λC + λ²M bordered by input and
//! output, H is minus the ratio of the two determinants.

use std::cell::OnceCell;

use eigentone_modes::{MatrixKind, System};
use faer::Mat;

use super::dynamic_stiffness::exact_sum;

/// Row, column and, by powers of λ, the doubles whose sums stand there.
pub(super) type Terms = (usize, usize, [Vec<f64>; 3]);

/// The bordered equations as real matrices.
pub(super) struct Orders {
    /// The number of coordinates: one less than there are rows.
    n: usize,
    terms: Option<Vec<Terms>>,
    known: OnceCell<[Option<Order>; 2]>,
}

/// Of a determinant as a polynomial in λ.
#[derive(Clone, Copy)]
pub(super) struct Order {
    /// The least power.
    pub(super) least: usize,
    /// The largest.
    pub(super) most: usize,
}

impl Orders {
    /// `None` for what is not real.
    pub(super) fn of(n: usize, terms: Option<Vec<Terms>>) -> Orders {
        Orders {
            n,
            terms,
            known: OnceCell::new(),
        }
    }

    /// Those of the determinant of the system, and of the bordered one; `None` where they are not proved.
    pub(super) fn get(&self) -> [Option<Order>; 2] {
        /// More take too long.
        const MOST: usize = 64;
        let find = || match &self.terms {
            Some(terms) if self.n <= MOST => [self.n, self.n + 1].map(|size| order(size, terms)),
            _ => [None; 2],
        };
        *self.known.get_or_init(find)
    }
}

/// That of the first rows and columns.
fn order(size: usize, terms: &[Terms]) -> Option<Order> {
    let mut matrices = [(); 3].map(|()| Mat::<f64>::zeros(size, size));
    let own = terms.iter();
    for (row, column, powers) in own.filter(|(row, column, _)| *row < size && *column < size) {
        for (matrix, terms) in matrices.iter_mut().zip(powers) {
            matrix[(*row, *column)] = exact_sum(terms)?;
        }
    }
    let kinds = [MatrixKind::Stiffness, MatrixKind::Damping, MatrixKind::Mass];
    let all = kinds.into_iter().zip(&matrices);
    let builder = all.fold(System::builder(), |builder, (kind, matrix)| {
        builder.matrix(kind, matrix.as_ref())
    });
    let system = builder.build().ok()?;
    let structure = system.structure();
    Some(Order {
        least: structure.zero_roots()?,
        most: structure.finite_roots()?,
    })
}
