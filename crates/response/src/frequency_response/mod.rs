//! Steady motions under harmonic forces. It knows `problem` alone.

mod dynamic_stiffness;
mod elimination;
mod harmonic_motion;
mod phasor;
mod receptance;
mod steady_state;

pub use harmonic_motion::{HarmonicMotion, SteadyStateError};
pub use receptance::receptance;
pub use steady_state::SteadyState;
