//! What is answered: motions at instants, what they took, and the trait of all methods. It knows `problem`.

mod collector;
mod combined;
mod history;
mod method;
mod operations;
mod output;
#[cfg(feature = "serde")]
mod serial;
mod trajectory;

pub(crate) use collector::{BUDGET, Collector, Wanted, check_size};
pub use history::History;
pub use method::ResponseMethod;
pub use operations::Operations;
pub use output::Output;
pub use trajectory::Trajectory;
