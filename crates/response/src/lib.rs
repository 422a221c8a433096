//! The exact response of a linear vibrating system at chosen instants, the steady state under harmonic
//! loads, and the energies and element forces along a motion.

mod blocks;
mod by_exponential;
mod by_superposition;
mod certified;
mod collector;
mod element_force;
mod energy;
mod equilibrium;
mod estimate;
mod exponential;
mod extrema;
mod grid;
mod grid_loads;
mod history;
mod hold;
mod load;
mod march;
mod massless;
mod method;
mod operations;
mod persistence;
mod plan;
mod problem;
mod response;
mod state;
mod steady_state;
mod summary;
mod timeline;
mod trajectory;
mod vector;

pub use by_exponential::ByExponential;
pub use by_superposition::BySuperposition;
pub use certified::ByCertifiedExponential;
pub use element_force::ElementForces;
pub use energy::Energy;
pub use exponential::{
    ExpmError, Exponential, Pade13, SecondOrder, Taylor, energy_condition, expm, expm_condition,
};
pub use extrema::{Extrema, Extremum};
pub use grid::{MAX_STEPS, TimeGrid};
pub use history::{History, Output};
pub use load::{Harmonic, Hold, Impulse, Load, LoadError, Ramp, Samples, Step};
pub use method::ResponseMethod;
pub use operations::Operations;
pub use plan::{ResponsePlan, methods};
pub use problem::{AppliedLoad, Problem, ResponseError};
pub use response::Response;
pub use state::State;
pub use steady_state::{HarmonicMotion, SteadyState, SteadyStateError, receptance};
pub use summary::{CoordinateSummary, Destination, Summary};
pub use timeline::{Instant, Piece, Straight, Timeline};
pub use trajectory::Trajectory;
