//! What a system is made of: coordinates, elements, matrices, and the terms of M, C and K. It proves nothing
//! and solves nothing; of the rest of the crate it knows no file.

mod element;
mod expansion;
mod form;
mod machine;
mod terms;

use std::collections::{HashMap, HashSet};
use std::sync::{Arc, OnceLock};

use eigentone_digits::DoubleDouble;
use faer::sparse::{SparseColMat, SparseColMatRef, Triplet};
use faer::{Mat, MatRef};

pub use element::{Element, ElementKind, GROUND, MatrixKind, Node};
pub use form::Form;
pub(crate) use machine::Machine;
pub use machine::{GivenElement, Point};
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
    /// Absent where there are neither points nor supports nor names of elements.
    machine: Option<Arc<Machine>>,
    /// The coordinates by their names, sorted when first asked for.
    by_name: Arc<OnceLock<Vec<u32>>>,
}

/// Matrices added to the elements: dense where the system is small, sparse where it is large.
#[derive(Clone, Debug, Default)]
pub(crate) struct Added {
    pub(crate) dense: [Option<Mat<f64>>; 3],
    pub(crate) sparse: [Option<Arc<SparseColMat<usize, f64>>>; 3],
    /// What the doubles of either leave of entries that are sums of products: each is smaller than a unit of the last
    /// place of the entry.
    pub(crate) tails: [Vec<Term>; 3],
}

impl From<[Option<Mat<f64>>; 3]> for Added {
    fn from(dense: [Option<Mat<f64>>; 3]) -> Added {
        Added {
            dense,
            ..Added::default()
        }
    }
}

impl Added {
    /// Adds terms to a matrix of order n: in each place, the double next to what it then is and, as tails, the rest.
    pub(crate) fn add(&mut self, kind: MatrixKind, n: usize, mut terms: Vec<Term>) {
        if terms.is_empty() {
            return;
        }
        let places: HashSet<(usize, usize)> =
            terms.iter().map(|term| (term.row, term.column)).collect();
        let kind = kind as usize;
        let (dense, sparse) = (&mut self.dense[kind], &mut self.sparse[kind]);
        let entry = |at: (usize, usize)| match (&*dense, &*sparse) {
            (Some(matrix), _) => matrix[at],
            (_, Some(matrix)) => matrix.get(at.0, at.1).copied().unwrap_or(0.0),
            _ => 0.0,
        };
        terms.extend(places.iter().map(|&(row, column)| Term {
            row,
            column,
            value: entry((row, column)),
        }));
        let gathered = form::gathered(terms);
        let of_place = gathered.chunk_by(|a, b| (a.row, a.column) == (b.row, b.column));
        let mut heads = HashMap::new();
        for place in of_place {
            heads.insert((place[0].row, place[0].column), place[0].value);
            self.tails[kind].extend(&place[1..]);
        }
        let head = |at: &(usize, usize)| heads.get(at).copied().unwrap_or(0.0);
        if n > MAX_DENSE_COORDINATES {
            let kept = sparse.iter().flat_map(|matrix| matrix.triplet_iter());
            let kept = kept
                .map(|entry| ((entry.row, entry.col), *entry.val))
                .filter(|(at, _)| !places.contains(at));
            let all = kept.chain(heads.iter().map(|(at, value)| (*at, *value)));
            let all: Vec<_> = all
                .map(|((row, column), value)| Triplet::new(row, column, value))
                .collect();
            let matrix = SparseColMat::try_new_from_triplets(n, n, &all);
            *sparse = Some(Arc::new(matrix.expect("indices are those of coordinates")));
        } else {
            let matrix = dense.get_or_insert_with(|| Mat::zeros(n, n));
            for at in &places {
                matrix[*at] = head(at);
            }
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
            machine: None,
            by_name: Arc::default(),
        }
    }

    pub(crate) fn with_machine(self, machine: Machine) -> Model {
        Model {
            machine: Some(Arc::new(machine)),
            ..self
        }
    }

    pub(crate) fn machine(&self) -> Option<&Machine> {
        self.machine.as_deref()
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

    /// What the added matrix, rounded to doubles, leaves of its entries.
    pub(crate) fn tails(&self, kind: MatrixKind) -> &[Term] {
        &self.added.tails[kind as usize]
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
