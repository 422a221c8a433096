//! What a system is made of: coordinates, elements, matrices, and the terms of M, C and K. It proves nothing
//! and solves nothing; of the rest of the crate it knows no file.

mod element;
mod terms;

use std::sync::{Arc, OnceLock};

use eigentone_digits::DoubleDouble;
use faer::sparse::{SparseColMat, SparseColMatRef};
use faer::{Mat, MatRef};

pub use element::{Element, ElementKind, GROUND, MatrixKind, Node};
pub use terms::Term;

/// The largest number of coordinates a system may have: a vector of this length takes 80 MB.
pub const MAX_COORDINATES: usize = 10_000_000;

/// The largest number of coordinates for which dense matrices are made; each takes 128 MB then, and the
/// dense solvers need several. Larger systems have [`SparseModes`](crate::SparseModes).
pub const MAX_DENSE_COORDINATES: usize = 4_000;

/// Named coordinates with masses, springs, dampers and added matrices.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    names: Arc<[String]>,
    masses: Vec<f64>,
    springs: Vec<Element>,
    dampers: Vec<Element>,
    added: Added,
    /// The coordinates by their names, sorted when first asked for.
    by_name: Arc<OnceLock<Vec<u32>>>,
}

/// Matrices added to the elements: dense where the system is small, sparse where it is large.
#[derive(Clone, Debug, Default)]
pub(crate) struct Added {
    pub(crate) dense: [Option<Mat<f64>>; 3],
    pub(crate) sparse: [Option<Arc<SparseColMat<usize, f64>>>; 3],
}

impl From<[Option<Mat<f64>>; 3]> for Added {
    fn from(dense: [Option<Mat<f64>>; 3]) -> Added {
        Added {
            dense,
            ..Added::default()
        }
    }
}

impl Model {
    pub(crate) fn new(
        names: Vec<String>,
        masses: Vec<f64>,
        springs: Vec<Element>,
        dampers: Vec<Element>,
        added: impl Into<Added>,
    ) -> Model {
        Model {
            names: names.into(),
            masses,
            springs,
            dampers,
            added: added.into(),
            by_name: Arc::default(),
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.names.len()
    }

    pub(crate) fn names(&self) -> &Arc<[String]> {
        &self.names
    }

    pub(crate) fn index_of(&self, name: &str) -> Option<usize> {
        let by_name = self.by_name.get_or_init(|| {
            let mut order: Vec<u32> = (0..self.names.len() as u32).collect();
            order.sort_unstable_by_key(|&i| self.names[i as usize].as_str());
            order
        });
        let at = |i: &u32| self.names[*i as usize].as_str();
        let place = by_name.binary_search_by(|i| at(i).cmp(name)).ok()?;
        Some(by_name[place] as usize)
    }

    pub(crate) fn masses(&self) -> &[f64] {
        &self.masses
    }

    pub(crate) fn springs(&self) -> &[Element] {
        &self.springs
    }

    pub(crate) fn dampers(&self) -> &[Element] {
        &self.dampers
    }

    pub(crate) fn is_large(&self) -> bool {
        self.len() > MAX_DENSE_COORDINATES
    }

    pub(crate) fn added(&self, kind: MatrixKind) -> Option<MatRef<'_, f64>> {
        self.added.dense[kind as usize].as_ref().map(Mat::as_ref)
    }

    pub(crate) fn added_sparse(&self, kind: MatrixKind) -> Option<SparseColMatRef<'_, usize, f64>> {
        let matrix = self.added.sparse[kind as usize].as_ref()?;
        Some(matrix.as_ref().as_ref())
    }

    /// Whether nothing but elements makes the matrix of this kind.
    pub(crate) fn is_of_elements(&self, kind: MatrixKind) -> bool {
        self.added(kind).is_none() && self.added_sparse(kind).is_none()
    }

    /// One of the matrices (n × n), each entry summed in double-double and rounded once.
    pub(crate) fn matrix(&self, kind: MatrixKind) -> Mat<f64> {
        let n = self.len();
        let mut total = Mat::<f64>::zeros(n, n);
        let mut low = Mat::<f64>::zeros(n, n);
        for term in self.terms(kind) {
            let at = (term.row, term.column);
            let sum = DoubleDouble::new(total[at], low[at]) + term.value;
            (total[at], low[at]) = (sum.high(), sum.low());
        }
        total
    }
}
