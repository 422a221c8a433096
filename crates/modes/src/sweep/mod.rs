//! The modes of many small systems that differ in their parameters alone, without allocating. It knows `linear`,
//! `model` and `system`.

mod design;
mod shape;
mod workspace;

pub use design::{Design, DesignError};
pub use workspace::ModesWorkspace;
