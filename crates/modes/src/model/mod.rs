//! What a system is made of: coordinates, elements, matrices, and the terms of M, C and K. It proves nothing
//! and solves nothing; of the rest of the crate it knows no file.

mod added;
mod damping;
mod element;
mod expansion;
mod form;
mod machine;
mod names;
mod terms;

use std::sync::Arc;

use eigentone_digits::DoubleDouble;
use faer::sparse::SparseColMatRef;
use faer::{Mat, MatRef};

pub(crate) use added::{Added, Square};
pub(crate) use damping::{ByModes, MoreDamping};
pub use element::{CoordinateKind, Element, ElementKind, GROUND, MatrixKind, Node};
pub(crate) use expansion::product;
pub use form::Form;
pub(crate) use form::gathered;
pub use machine::{GivenElement, Point};
pub(crate) use machine::{Held, Machine};
pub use names::{Names, NoCoordinate};
pub use terms::Term;

/// The largest number of coordinates a system may have: a vector of this length takes 80 MB.
pub const MAX_COORDINATES: usize = 10_000_000;

/// The largest number of coordinates for which dense matrices are made; each takes 128 MB then, and the
/// dense solvers need several. Larger systems have [`SparseModes`](crate::SparseModes).
pub const MAX_DENSE_COORDINATES: usize = 4_000;

/// Named coordinates with masses, springs, dampers and added matrices.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    names: Names,
    masses: Vec<f64>,
    springs: Vec<Element>,
    dampers: Vec<Element>,
    /// By matrix.
    added: [Added; 3],
    /// What a part of the damping was before it was rounded.
    by_modes: Option<Arc<ByModes>>,
    /// Absent where there are neither points nor supports nor names of elements.
    machine: Option<Arc<Machine>>,
}

impl Model {
    pub(crate) fn new(
        names: Vec<String>,
        masses: Vec<f64>,
        springs: Vec<Element>,
        dampers: Vec<Element>,
        added: [impl Into<Added>; 3],
    ) -> Model {
        Model {
            names: names.into(),
            masses,
            springs,
            dampers,
            added: added.map(Into::into),
            by_modes: None,
            machine: None,
        }
    }

    pub(crate) fn with_machine(self, machine: Machine) -> Model {
        Model {
            machine: Some(Arc::new(machine)),
            ..self
        }
    }

    /// The same but for its dampers.
    pub(crate) fn without_dampers(&self) -> Model {
        let mut model = self.clone();
        model.dampers.clear();
        model.added[MatrixKind::Damping as usize] = Added::default();
        model.by_modes = None;
        model
    }

    pub(crate) fn by_modes(&self) -> Option<&ByModes> {
        self.by_modes.as_deref()
    }

    pub(crate) fn machine(&self) -> Option<&Machine> {
        self.machine.as_deref()
    }

    /// What a coordinate measures.
    pub(crate) fn kind_of(&self, i: usize) -> CoordinateKind {
        let is_rotation = self
            .machine()
            .and_then(|machine| machine.is_rotation.get(i));
        match is_rotation {
            Some(true) => CoordinateKind::Rotation,
            _ => CoordinateKind::Displacement,
        }
    }

    /// The names of the supports.
    pub(crate) fn supports(&self) -> &[String] {
        self.machine().map_or(&[], |machine| &machine.supports)
    }

    /// What unit motions of the supports, whose indices are the columns, add.
    pub(crate) fn coupling(&self, kind: MatrixKind) -> &[Term] {
        self.machine()
            .map_or(&[], |machine| &machine.couplings[kind as usize])
    }

    /// The forces that unit motions of the supports take at the supports.
    pub(crate) fn between_supports(&self, kind: MatrixKind) -> &[Term] {
        self.machine()
            .map_or(&[], |machine| &machine.between_supports[kind as usize])
    }

    pub(crate) fn len(&self) -> usize {
        self.names.len()
    }

    pub(crate) fn names(&self) -> &Names {
        &self.names
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

    fn between(&self, kind: ElementKind) -> &[Element] {
        match kind {
            ElementKind::Spring => &self.springs,
            ElementKind::Damper => &self.dampers,
        }
    }

    /// How many springs or dampers were given.
    pub(crate) fn element_count(&self, kind: ElementKind) -> usize {
        let between = self.between(kind).len();
        self.machine()
            .map_or(between, |machine| machine.elements(kind).len())
    }

    /// A spring or damper as it was given.
    pub(crate) fn element(&self, kind: ElementKind, index: usize) -> Option<GivenElement> {
        if let Some(machine) = self.machine() {
            return machine.elements(kind).get(index).cloned();
        }
        let element = self.between(kind).get(index)?;
        let name = |node: Node| {
            node.coordinate()
                .map_or(GROUND, |i| &self.names[i])
                .to_owned()
        };
        Some(GivenElement {
            name: None,
            ends: [name(element.first), name(element.second)],
            stretch: Form::of_node(element.second).minus(&Form::of_node(element.first)),
            coefficient: element.coefficient,
            kind: Some(CoordinateKind::Displacement),
        })
    }

    pub(crate) fn is_large(&self) -> bool {
        self.len() > MAX_DENSE_COORDINATES
    }

    pub(crate) fn added(&self, kind: MatrixKind) -> Option<MatRef<'_, f64>> {
        self.added[kind as usize].dense()
    }

    /// The added matrix, unless it is kept as a sparse one.
    fn kept_dense(&self, kind: MatrixKind) -> Option<MatRef<'_, f64>> {
        match self.added_sparse(kind) {
            None => self.added(kind),
            Some(_) => None,
        }
    }

    /// The added matrix, if it is kept as a sparse one.
    pub(crate) fn added_sparse(&self, kind: MatrixKind) -> Option<SparseColMatRef<'_, usize, f64>> {
        self.added[kind as usize].sparse()
    }

    /// What the added matrix, rounded to doubles, leaves of its entries.
    pub(crate) fn tails(&self, kind: MatrixKind) -> &[Term] {
        &self.added[kind as usize].tails
    }

    /// All that was added to the elements of a matrix.
    pub(crate) fn added_whole(&self, kind: MatrixKind) -> &Added {
        &self.added[kind as usize]
    }

    /// Whether the matrix of this kind is a sum of c a aᵀ with c ≥ 0, element by element.
    pub(crate) fn is_sum_of_squares(&self, kind: MatrixKind) -> bool {
        let elements: &[Element] = match kind {
            MatrixKind::Mass => &[],
            MatrixKind::Damping => &self.dampers,
            MatrixKind::Stiffness => &self.springs,
        };
        let squares = self.added_whole(kind).squares();
        let elements = elements.iter().map(|element| element.coefficient);
        squares.is_some_and(|squares| {
            let squares = squares.iter().map(|square| square.coefficient);
            elements
                .chain(squares)
                .all(|coefficient| coefficient >= 0.0)
        })
    }

    /// Whether nothing but elements makes the matrix of this kind.
    pub(crate) fn is_of_elements(&self, kind: MatrixKind) -> bool {
        !self.added[kind as usize].is_some()
    }

    /// Whether nothing but an added matrix of doubles makes the matrix of this kind.
    pub(crate) fn is_added_alone(&self, kind: MatrixKind) -> bool {
        let elements = self.terms_beside(kind).next().is_some();
        self.kept_dense(kind).is_some() && !elements
    }

    /// One of the matrices (n × n), each entry summed in double-double and rounded once.
    pub(crate) fn matrix(&self, kind: MatrixKind) -> Mat<f64> {
        let n = self.len();
        let mut total = match self.kept_dense(kind) {
            // Without zeros that are negative.
            Some(matrix) => Mat::from_fn(n, n, |i, j| matrix[(i, j)] + 0.0),
            None => Mat::zeros(n, n),
        };
        let mut terms = self.terms_beside(kind).peekable();
        if terms.peek().is_none() {
            return total;
        }
        let mut low = Mat::<f64>::zeros(n, n);
        for term in terms {
            let at = (term.row, term.column);
            let sum = DoubleDouble::new(total[at], low[at]) + term.value;
            (total[at], low[at]) = (sum.high(), sum.low());
        }
        total
    }
}
