//! Masses, springs and dampers to M, C, K, and the quadratic eigenproblem.

mod balance;
mod builder;
mod element;
mod exact;
mod first_order;
mod inclusion;
mod modes;
mod plan;
mod quality;
mod solver;
mod structure;
mod system;

pub use balance::{Balanced, balance};
pub use builder::{BuildError, MAX_COORDINATES, SystemBuilder};
pub use element::{Element, ElementKind, GROUND, MatrixKind, Node};
pub use first_order::{FirstOrder, FirstOrderError};
pub use modes::{Bounds, Eigenvalue, Frequency, Mode, Modes, Motion, Precision};
pub use plan::ModePlan;
pub use solver::{
    Classical, ClassicalModes, ModeSolver, ModesError, SpringFactor, StateMatrix, Symmetric,
    solvers,
};
pub use structure::Structure;
pub use system::System;
