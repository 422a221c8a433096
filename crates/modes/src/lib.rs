//! Masses, springs and dampers to M, C, K, and the quadratic eigenproblem.

mod builder;
mod element;
mod exact;
mod modes;
mod plan;
mod solver;
mod structure;
mod system;

pub use builder::{BuildError, MAX_COORDINATES, SystemBuilder};
pub use element::{Element, ElementKind, GROUND, MatrixKind, Node};
pub use modes::{Eigenvalue, Frequency, Mode, Modes, Motion};
pub use plan::ModePlan;
pub use solver::{ModeSolver, ModesError, solvers};
pub use structure::Structure;
pub use system::System;
