//! The exponential of a matrix, in doubles and with a bound. It knows `enclosed` alone, and nothing of motions.

mod algebra;
mod aligned;
mod choice;
mod condition;
mod contiguous;
mod dense;
mod dual;
mod energy_condition;
mod error;
mod expm;
mod few_masses;
mod growth;
mod method;
mod norm;
mod pade;
mod paths;
mod polynomial;
mod precise;
mod scales;
mod scaling;
mod second_order;
mod series;
mod sparse;
mod sparse_system;
mod squaring;
mod taylor;
pub(crate) mod vector;

pub use condition::expm_condition;
pub use energy_condition::energy_condition;
pub use error::ExpmError;
pub use expm::{BoundedExponential, expm, expm_bounded};
pub use method::Exponential;
pub use pade::Pade13;
pub use second_order::SecondOrder;
pub(crate) use second_order::{by_taylor, second_order};
pub use taylor::Taylor;
