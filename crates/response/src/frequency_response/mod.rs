//! Steady motions under harmonic forces, and frequency response functions with their peaks. It knows `problem` and
//! `march`.

mod brackets;
mod columns;
mod dynamic_stiffness;
mod elimination;
mod enclosure;
mod features;
mod function;
mod grid;
mod harmonic_motion;
mod hessenberg;
mod inverse;
mod level_set;
mod limit;
mod modal_functions;
mod modal_refinement;
mod modal_series;
mod modal_sum;
mod modal_values;
mod odd_powers;
mod orders;
mod phasor;
mod ports;
mod power_series;
mod question;
mod random;
mod receptance;
mod refinement;
mod rigid;
mod sparse_factor;
mod state_form;
mod steady_state;
mod transfer;
mod turns;

pub use features::{Asymptote, Features, LargestGain, Peak};
pub use function::{FrequencyFunction, FrequencyFunctions, FrequencyMethod, FrequencyValue};
pub use grid::peak_grid;
pub use harmonic_motion::{HarmonicMotion, SteadyStateError};
pub use question::{FrequencyError, FrequencyResponse};
pub use receptance::receptance;
pub(crate) use state_form::{Acts, Equations, Reads, StateForm, powers};
pub use steady_state::SteadyState;
pub use transfer::{Adjoint, Transfer};
