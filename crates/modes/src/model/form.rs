//! Linear forms in the displacements: what points and elements make of coordinates and supports.

use super::expansion::{product, sum};
use super::{Element, Node, Term};

/// Σ aᵢ xᵢ + Σ bₛ uₛ, a linear form in the displacements x of the coordinates and u of the supports. A point's
/// displacement is one, and so is the stretch of an element. Exact: an index may come more than once, its coefficient is
/// the sum of all of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Form {
    /// Index of a coordinate and its coefficient aᵢ.
    pub coordinates: Vec<(usize, f64)>,
    /// Index of a support and its coefficient bₛ.
    pub supports: Vec<(usize, f64)>,
}

impl Form {
    /// The displacement of one coordinate.
    pub(crate) fn coordinate(index: usize) -> Form {
        Form {
            coordinates: vec![(index, 1.0)],
            ..Form::default()
        }
    }

    /// The displacement of one support.
    pub(crate) fn support(index: usize) -> Form {
        Form {
            supports: vec![(index, 1.0)],
            ..Form::default()
        }
    }

    /// The displacement of an end of an element; that of the ground is 0.
    pub(crate) fn of_node(node: Node) -> Form {
        node.coordinate().map(Form::coordinate).unwrap_or_default()
    }

    /// self − other, each coefficient in as few doubles as hold it exactly.
    pub(crate) fn minus(&self, other: &Form) -> Form {
        let difference = |these: &[(usize, f64)], those: &[(usize, f64)]| {
            let mut all = these.to_vec();
            all.extend(those.iter().map(|&(i, value)| (i, -value)));
            all.sort_by_key(|&(i, _)| i);
            let parts = all.chunk_by(|a, b| a.0 == b.0).flat_map(|same| {
                let i = same[0].0;
                sum(same.iter().map(|&(_, value)| value))
                    .into_iter()
                    .map(move |part| (i, part))
            });
            parts.collect()
        };
        Form {
            coordinates: difference(&self.coordinates, &other.coordinates),
            supports: difference(&self.supports, &other.supports),
        }
    }

    /// The element of this stretch between two coordinates, or between one and what stands still, if it is one.
    pub(crate) fn element(&self, coefficient: f64) -> Option<Element> {
        let (first, second) = match *self.coordinates.as_slice() {
            [(i, 1.0 | -1.0)] => (Node::Ground, Node::Coordinate(i)),
            [(i, 1.0), (j, -1.0)] | [(j, -1.0), (i, 1.0)] if i != j => {
                (Node::Coordinate(j), Node::Coordinate(i))
            }
            _ => return None,
        };
        Some(Element {
            first,
            second,
            coefficient,
        })
    }

    /// The terms of coefficient·a aᵀ for the coefficients a of the coordinates, those of coefficient·a bᵀ for the
    /// coefficients b of the supports, whose columns are the supports, and those of coefficient·b bᵀ. `None` where a product
    /// leaves the range of doubles.
    pub(crate) fn terms(&self, coefficient: f64) -> Option<[Vec<Term>; 3]> {
        let mut weighted = Vec::with_capacity(2 * self.coordinates.len());
        for &(row, a) in &self.coordinates {
            weighted.extend(product(coefficient, a)?.map(|part| (row, part)));
        }
        let mut own = Vec::with_capacity(4 * self.coordinates.len().pow(2));
        let mut coupling = Vec::with_capacity(4 * self.coordinates.len() * self.supports.len());
        // Each product is taken once, for both of its places: the matrix is symmetric term by term.
        for (at, &(row, _)) in self.coordinates.iter().enumerate() {
            for &(_, part) in &weighted[2 * at..2 * at + 2] {
                for (beyond, &(column, b)) in self.coordinates[at..].iter().enumerate() {
                    for value in product(part, b)? {
                        own.push(Term { row, column, value });
                        if beyond > 0 {
                            let (row, column) = (column, row);
                            own.push(Term { row, column, value });
                        }
                    }
                }
                for &(column, b) in &self.supports {
                    let parts = product(part, b)?;
                    coupling.extend(parts.map(|value| Term { row, column, value }));
                }
            }
        }
        let mut still = Vec::with_capacity(4 * self.supports.len().pow(2));
        for &(row, a) in &self.supports {
            for part in product(coefficient, a)? {
                for &(column, b) in &self.supports {
                    let parts = product(part, b)?;
                    still.extend(parts.map(|value| Term { row, column, value }));
                }
            }
        }
        let mut all = [own, coupling, still];
        for terms in &mut all {
            terms.retain(|term| term.value != 0.0);
        }
        Some(all)
    }
}

/// Terms in the same place as few that do not overlap, in the order of rows and columns; of each place the largest
/// comes first. The same terms in another order give the same.
pub(crate) fn gathered(mut terms: Vec<Term>) -> Vec<Term> {
    let key = |term: &Term| (term.row, term.column);
    terms.sort_by(|a, b| key(a).cmp(&key(b)).then(a.value.total_cmp(&b.value)));
    let places = terms.chunk_by(|a, b| (a.row, a.column) == (b.row, b.column));
    let parts = places.flat_map(|place| {
        let Term { row, column, .. } = place[0];
        sum(place.iter().map(|term| term.value))
            .into_iter()
            .map(move |value| Term { row, column, value })
    });
    parts.collect()
}
