//! Masses, springs and dampers to M, C, K, and the quadratic eigenproblem.

mod assurance;
mod balance;
mod builder;
mod element;
mod enclosed_form;
mod exact;
mod first_order;
mod inclusion;
mod modes;
mod parameter;
mod participation;
mod plan;
mod quality;
mod sensitivity;
mod solver;
mod sparse;
mod structure;
mod system;

pub use assurance::{AssuranceError, modal_assurance, phase_collinearity};
pub use balance::{Balanced, balance};
pub use builder::{BuildError, MAX_COORDINATES, MAX_DENSE_COORDINATES, SystemBuilder};
pub use element::{Element, ElementKind, GROUND, MatrixKind, Node};
pub use enclosed_form::EnclosedFirstOrder;
pub use first_order::{FirstOrder, FirstOrderError};
pub use modes::{Bounds, Eigenvalue, Frequency, Mode, Modes, Motion, Precision};
pub use parameter::Parameter;
pub use participation::{Participation, ParticipationError};
pub use plan::ModePlan;
pub use sensitivity::{Derivative, Sensitivity, SensitivityError};
pub use solver::{
    Classical, ClassicalModes, DamperFactor, LowRank, ModalMatrix, ModeSolver, ModesError,
    SpringFactor, StateMatrix, Symmetric, solvers,
};
pub use sparse::{SparseError, SparseModes, SparseWork};
pub use structure::Structure;
pub use system::System;
