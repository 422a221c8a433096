//! What is asked: a system, its state at t = 0, loads, instants, and the pieces of time between events. It knows no other room.

mod angle;
mod applied_load;
mod channel;
mod combination;
mod course;
mod equilibrium;
mod error;
mod grid;
mod instant;
mod kept;
mod law;
mod load;
mod massless;
mod momenta;
mod moving;
mod plant;
mod question;
mod rate;
mod state;
mod straight_load;
mod straight_loads;
mod tangent;
mod timeline;
mod walk;

pub(crate) use angle::reduced_angle;
pub use applied_load::AppliedLoad;
pub use channel::{Channel, Quantity};
pub(crate) use combination::Source;
pub use combination::{Combination, Sum};
pub(crate) use course::MOST_INTEGRALS;
pub(crate) use equilibrium::{Floating, equilibrium, equilibrium_rounding, rest};
pub use error::ResponseError;
pub use grid::{MAX_STEPS, TimeGrid};
pub use instant::Instant;
pub(crate) use instant::{Base, Fraction, SampleGrid};
pub use load::{
    HalfSine, Harmonic, Hold, Impulse, Load, LoadError, Polynomial, Ramp, Samples, Step, Versine,
};
pub(crate) use moving::moving;
pub(crate) use plant::Plant;
pub use question::{Drive, Problem};
pub(crate) use rate::Rate;
pub use rate::turns;
pub use state::State;
pub(crate) use straight_load::{Known, StraightLoad, sum};
pub(crate) use straight_loads::StraightLoads;
pub(crate) use timeline::Pulse;
pub use timeline::{Piece, Straight, Timeline};
pub(crate) use walk::{Leg, Walk};
