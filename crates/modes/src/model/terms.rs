//! The terms of M, C and K: the one place where elements become entries of matrices.

use super::{Element, MatrixKind, Model, Node};

/// A part of one entry of a matrix. The entry is the exact sum of its terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// The entry's row, from 0.
    pub row: usize,
    /// The entry's column, from 0.
    pub column: usize,
    /// What is added there.
    pub value: f64,
}

impl Model {
    /// All terms of a matrix but those that are 0: first those of the added matrix, then those of the elements
    /// in their order.
    pub(crate) fn terms(&self, kind: MatrixKind) -> impl Iterator<Item = Term> + '_ {
        let all = self.dense_terms(kind).chain(self.terms_beside(kind));
        all.filter(|term| term.value != 0.0)
    }

    /// Those that come after the entries of an added matrix that is kept as a dense one.
    pub(crate) fn terms_beside(&self, kind: MatrixKind) -> impl Iterator<Item = Term> + '_ {
        let elements: &[Element] = match kind {
            MatrixKind::Mass => &[],
            MatrixKind::Damping => self.dampers(),
            MatrixKind::Stiffness => self.springs(),
        };
        let elements = elements.iter().flat_map(of_element);
        let all = self.sparse_terms(kind).chain(self.mass_terms(kind));
        all.chain(elements).filter(|term| term.value != 0.0)
    }

    /// All without those of springs and dampers.
    pub(crate) fn single_terms(&self, kind: MatrixKind) -> impl Iterator<Item = Term> + '_ {
        self.added_terms(kind).chain(self.mass_terms(kind))
    }

    fn mass_terms(&self, kind: MatrixKind) -> impl Iterator<Item = Term> + '_ {
        let masses = match kind {
            MatrixKind::Mass => self.masses(),
            _ => &[],
        };
        masses.iter().enumerate().map(|(i, &value)| Term {
            row: i,
            column: i,
            value,
        })
    }

    /// Those of the added matrix alone.
    pub(crate) fn added_terms(&self, kind: MatrixKind) -> impl Iterator<Item = Term> + '_ {
        self.dense_terms(kind).chain(self.sparse_terms(kind))
    }

    fn dense_terms(&self, kind: MatrixKind) -> impl Iterator<Item = Term> + '_ {
        self.kept_dense(kind).into_iter().flat_map(|matrix| {
            let entries =
                (0..matrix.ncols()).flat_map(move |j| (0..matrix.nrows()).map(move |i| (i, j)));
            entries.map(move |(row, column)| Term {
                row,
                column,
                value: matrix[(row, column)],
            })
        })
    }

    /// Those of an added matrix that is kept as a sparse one, and what either leaves of its entries.
    fn sparse_terms(&self, kind: MatrixKind) -> impl Iterator<Item = Term> + '_ {
        let sparse = self.added_sparse(kind).into_iter().flat_map(|matrix| {
            matrix.triplet_iter().map(|entry| Term {
                row: entry.row,
                column: entry.col,
                value: *entry.val,
            })
        });
        sparse.chain(self.tails(kind).iter().copied())
    }
}

/// A spring or damper c between i and j: c on the diagonal in both rows, −c in both places that join them.
fn of_element(element: &Element) -> impl Iterator<Item = Term> {
    let Element {
        first,
        second,
        coefficient,
    } = *element;
    [(first, second), (second, first)]
        .into_iter()
        .flat_map(move |(end, other)| {
            let diagonal = end.coordinate().map(|i| Term {
                row: i,
                column: i,
                value: coefficient,
            });
            let joint = match (end, other) {
                (Node::Coordinate(row), Node::Coordinate(column)) => Some(Term {
                    row,
                    column,
                    value: -coefficient,
                }),
                _ => None,
            };
            diagonal.into_iter().chain(joint)
        })
}
