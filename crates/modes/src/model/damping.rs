//! Damping beside that of the dampers given.

use std::sync::Arc;

use super::{Element, MatrixKind, Model, Square, Term, gathered};

/// Damping by ratios of the undamped modes.
#[derive(Clone, Debug)]
pub(crate) struct ByModes {
    /// Of the modes in their order, rigid motions included; of those beyond its length, the last.
    pub(crate) ratios: Vec<f64>,
    /// The model without it.
    pub(crate) beside: Model,
}

/// What is added to the damping of a model.
#[derive(Clone, Debug, Default)]
pub(crate) struct MoreDamping {
    /// What it is made of, where it is by modes: terms are that, rounded.
    pub(crate) ratios: Option<Vec<f64>>,
    pub(crate) dampers: Vec<Element>,
    /// What else is added to C.
    pub(crate) terms: Vec<Term>,
    /// The squares that these are the sum of, unless `is_given`.
    pub(crate) squares: Vec<Square>,
    /// Whether they come of a matrix that is not a sum of squares.
    pub(crate) is_given: bool,
    /// What unit velocities of supports, whose indices are the columns, add to C x′.
    pub(crate) coupling: Vec<Term>,
    /// The forces that they take at the supports themselves.
    pub(crate) between_supports: Vec<Term>,
}

impl Model {
    pub(crate) fn with_damping(mut self, more: MoreDamping) -> Model {
        let n = self.len();
        if let Some(ratios) = more.ratios {
            let beside = self.clone();
            self.by_modes = Some(Arc::new(ByModes { ratios, beside }));
        } else if let Some(by_modes) = &mut self.by_modes {
            let by_modes = Arc::make_mut(by_modes);
            by_modes.beside = by_modes.beside.clone().with_damping(more.clone());
        }
        self.dampers.extend(more.dampers);
        let added = &mut self.added[MatrixKind::Damping as usize];
        added.add(n, more.terms);
        added.squares.extend(more.squares);
        added.is_given |= more.is_given;
        if let Some(machine) = &mut self.machine {
            let machine = Arc::make_mut(machine);
            let kind = MatrixKind::Damping as usize;
            let coupling = &mut machine.couplings[kind];
            let between = &mut machine.between_supports[kind];
            for (terms, more) in [(coupling, more.coupling), (between, more.between_supports)] {
                let mut all = std::mem::take(terms);
                all.extend(more);
                *terms = gathered(all);
            }
        }
        self
    }
}
