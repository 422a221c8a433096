//! Matrices added to the elements: given whole, or made of elements at points.

use std::collections::HashMap;
use std::sync::Arc;

use faer::Mat;
use faer::sparse::{SparseColMat, Triplet};

use super::form::gathered;
use super::{MAX_DENSE_COORDINATES, Term};

/// What is added to the elements of one of the three matrices: dense where the system is small, sparse where it is
/// large.
#[derive(Clone, Debug, Default)]
pub(crate) struct Added {
    pub(crate) dense: Option<Mat<f64>>,
    pub(crate) sparse: Option<Arc<SparseColMat<usize, f64>>>,
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
            dense,
            ..Added::default()
        }
    }
}

impl Added {
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
            value: match (&self.dense, &self.sparse) {
                (Some(matrix), _) => matrix[(row, column)],
                (_, Some(matrix)) => matrix.get(row, column).copied().unwrap_or(0.0),
                _ => 0.0,
            },
        }));
        let gathered = gathered(terms);
        for place in gathered.chunk_by(|a, b| at(a) == at(b)) {
            places.insert(at(&place[0]), place[0].value);
            self.tails.extend(&place[1..]);
        }
        if n > MAX_DENSE_COORDINATES {
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
        } else {
            let matrix = self.dense.get_or_insert_with(|| Mat::zeros(n, n));
            for (&at, &value) in &places {
                matrix[at] = value;
            }
        }
    }

    /// The squares that it is the sum of, if nothing else is part of it.
    pub(crate) fn squares(&self) -> Option<&[Square]> {
        (!self.is_given).then_some(&self.squares)
    }

    /// The rows and columns of the chosen coordinates, which rise.
    pub(crate) fn block(&self, chosen: &[usize]) -> Added {
        let size = chosen.len();
        let dense =
            |matrix: &Mat<f64>| Mat::from_fn(size, size, |i, j| matrix[(chosen[i], chosen[j])]);
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
            dense: self.dense.as_ref().map(dense),
            sparse: None,
            tails: tails.collect(),
            is_given: self.is_given,
            squares: squares.collect(),
        }
    }
}
