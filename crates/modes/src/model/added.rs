//! Matrices added to the elements: given whole, or made of elements at points.

use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use faer::sparse::{SparseColMat, SparseColMatRef, Triplet};
use faer::{Mat, MatRef};

use super::form::gathered;
use super::{MAX_DENSE_COORDINATES, Term};

/// What is added to the elements of one of the three matrices: sparse where the system is large, or where it was given
/// so with few entries, else dense.
#[derive(Clone, Debug, Default)]
pub(crate) struct Added {
    sparse: Option<Arc<SparseColMat<usize, f64>>>,
    /// Of a sparse one, what it is as a dense one, as soon as that is asked for.
    dense: OnceLock<Mat<f64>>,
    /// What the doubles of either leave of entries that are sums of products: each is smaller than a unit of the last
    /// place of the entry, which is not 0. Empty where there is no matrix.
    pub(crate) tails: Vec<Term>,
    /// Whether a matrix that was given is part of it.
    pub(crate) is_given: bool,
    /// What makes the rest of it.
    pub(crate) squares: Vec<Square>,
}

/// A part c a aᵀ of a matrix.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Square {
    pub(crate) coefficient: f64,
    /// Index and coefficient; an index may come more than once.
    pub(crate) form: Vec<(usize, f64)>,
}

impl From<Option<Mat<f64>>> for Added {
    fn from(dense: Option<Mat<f64>>) -> Added {
        Added {
            is_given: dense.is_some(),
            dense: dense.map(OnceLock::from).unwrap_or_default(),
            ..Added::default()
        }
    }
}

impl From<Vec<Square>> for Added {
    fn from(squares: Vec<Square>) -> Added {
        Added {
            squares,
            ..Added::default()
        }
    }
}

impl Added {
    /// Takes a sparse matrix that was given.
    pub(crate) fn give_sparse(&mut self, matrix: SparseColMat<usize, f64>) {
        self.is_given = true;
        self.sparse = Some(Arc::new(matrix));
    }

    /// Takes a dense matrix that was given.
    pub(crate) fn give_dense(&mut self, matrix: Mat<f64>) {
        self.is_given = true;
        self.dense = OnceLock::from(matrix);
    }

    /// Whether there is a matrix.
    pub(crate) fn is_some(&self) -> bool {
        self.sparse.is_some() || self.dense.get().is_some()
    }

    /// The matrix as a sparse one, if it is kept so.
    pub(crate) fn sparse(&self) -> Option<SparseColMatRef<'_, usize, f64>> {
        Some(self.sparse.as_ref()?.as_ref().as_ref())
    }

    /// The matrix as a dense one, unless it is too large for that.
    pub(crate) fn dense(&self) -> Option<MatRef<'_, f64>> {
        match &self.sparse {
            None => self.dense.get().map(Mat::as_ref),
            Some(sparse) if sparse.nrows() > MAX_DENSE_COORDINATES => None,
            Some(sparse) => Some(self.dense.get_or_init(|| sparse.to_dense()).as_ref()),
        }
    }

    /// Adds terms to a matrix of order n: in each place, the double next to what it then is and, as tails, the rest.
    pub(crate) fn add(&mut self, n: usize, mut terms: Vec<Term>) {
        if terms.is_empty() {
            return;
        }
        let at = |term: &Term| (term.row, term.column);
        let mut places: HashMap<(usize, usize), f64> =
            terms.iter().map(|term| (at(term), 0.0)).collect();
        self.tails.retain(|tail| {
            let stays = !places.contains_key(&at(tail));
            if !stays {
                terms.push(*tail);
            }
            stays
        });
        terms.extend(places.keys().map(|&(row, column)| Term {
            row,
            column,
            value: match (&self.sparse, self.dense.get()) {
                (Some(matrix), _) => matrix.get(row, column).copied().unwrap_or(0.0),
                (_, Some(matrix)) => matrix[(row, column)],
                _ => 0.0,
            },
        }));
        let gathered = gathered(terms);
        for place in gathered.chunk_by(|a, b| at(a) == at(b)) {
            places.insert(at(&place[0]), place[0].value);
            self.tails.extend(&place[1..]);
        }
        if n > MAX_DENSE_COORDINATES || self.sparse.is_some() {
            let kept = self.sparse.iter().flat_map(|matrix| matrix.triplet_iter());
            let kept = kept
                .filter(|entry| !places.contains_key(&(entry.row, entry.col)))
                .map(|entry| Triplet::new(entry.row, entry.col, *entry.val));
            let heads = places
                .iter()
                .map(|(&(row, column), &value)| Triplet::new(row, column, value));
            let all: Vec<_> = kept.chain(heads).collect();
            let matrix = SparseColMat::try_new_from_triplets(n, n, &all);
            self.sparse = Some(Arc::new(matrix.expect("indices are those of coordinates")));
            self.dense = OnceLock::new();
        } else {
            let mut matrix = self.dense.take().unwrap_or_else(|| Mat::zeros(n, n));
            for (&at, &value) in &places {
                matrix[at] = value;
            }
            self.dense = OnceLock::from(matrix);
        }
    }

    /// The squares that it is the sum of, if nothing else is part of it.
    pub(crate) fn squares(&self) -> Option<&[Square]> {
        (!self.is_given).then_some(&self.squares)
    }

    /// The rows and columns of the chosen coordinates, which rise.
    pub(crate) fn block(&self, chosen: &[usize]) -> Added {
        let size = chosen.len();
        let dense = |matrix: MatRef<'_, f64>| {
            Mat::from_fn(size, size, |i, j| matrix[(chosen[i], chosen[j])])
        };
        let place = |i: usize| chosen.binary_search(&i).ok();
        let tails = self.tails.iter().filter_map(|tail| {
            Some(Term {
                row: place(tail.row)?,
                column: place(tail.column)?,
                value: tail.value,
            })
        });
        let squares = self.squares.iter().map(|square| Square {
            coefficient: square.coefficient,
            form: square
                .form
                .iter()
                .filter_map(|&(i, times)| Some((place(i)?, times)))
                .collect(),
        });
        Added {
            tails: tails.collect(),
            is_given: self.is_given,
            squares: squares.collect(),
            ..Added::from(self.dense().map(dense))
        }
    }
}
