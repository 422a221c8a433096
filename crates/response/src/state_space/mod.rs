//! State-space forms z′ = A z + B u, y = C z + D u, their exact discrete forms and covariances, every entry with a proven
//! bound. It knows `problem`, `enclosed` and `frequency_response`.

mod asked;
mod bounded;
mod coordinates;
mod discrete;
mod error;
mod ladder;
mod model;
mod noise;
mod random;
mod realisation;

pub use bounded::BoundedMatrix;
pub use error::StateSpaceError;
pub use model::{StateMatrices, StateSpace, StateSpaceBuilder};
pub use random::{
    MeanSquare, Noise, RandomVibration, Rms, SpectralDensity, StationaryMotion, Statistics,
    Weighting,
};
