//! What is asked: a system, its state at t = 0, loads, instants, and the pieces of time between events. It knows no other room.

mod applied_load;
mod equilibrium;
mod error;
mod grid;
mod instant;
mod law;
mod load;
mod massless;
mod question;
mod state;
mod straight_load;
mod straight_loads;
mod timeline;
mod walk;

pub use applied_load::AppliedLoad;
pub(crate) use equilibrium::{Floating, equilibrium, rest};
pub use error::ResponseError;
pub use grid::{MAX_STEPS, TimeGrid};
pub use instant::Instant;
pub(crate) use instant::{Fraction, SampleGrid};
pub use load::{Harmonic, Hold, Impulse, Load, LoadError, Ramp, Samples, Step};
pub use question::Problem;
pub use state::State;
pub(crate) use straight_load::{Known, StraightLoad};
pub(crate) use straight_loads::StraightLoads;
pub use timeline::{Piece, Straight, Timeline};
pub(crate) use walk::{Leg, Walk};
