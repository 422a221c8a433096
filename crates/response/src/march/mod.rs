//! From instant to instant in doubles: by the exponential or by modes, whole motions or chosen outputs. It knows
//! `problem`, `answer`, `enclosed`, `exponential` and `hold`.

mod batch;
mod blocks;
mod by_exponential;
mod by_superposition;
mod course;
mod deviation;
mod estimate;
mod flow;
mod grid_loads;
mod modal_basis;
mod modal_march;
mod queue;
mod strides;

pub use by_exponential::ByExponential;
pub(crate) use by_exponential::Exponential;
pub use by_superposition::BySuperposition;
pub(crate) use by_superposition::Superposition;
pub(crate) use course::Course;
pub(crate) use modal_basis::Basis;
