//! How a linear vibrating system moves: exactly at the instants asked for, with no error from time
//! steps, and with proven bounds.
//!
//! Say what is asked with [`Response`]: a [`System`](eigentone_modes::System), a [`State`] to start from, loads
//! ([`Step`], [`Ramp`], [`Impulse`], [`Harmonic`], [`Samples`], [`HalfSine`], [`Versine`], [`Polynomial`]) on coordinates and points, motions
//! of supports by any of their derivatives ([`Quantity`]), and the instants wanted. The answer is a [`Trajectory`].
//!
//! ```
//! use eigentone_modes::{Bounds, GROUND, System};
//! use eigentone_response::{Impulse, Response};
//!
//! let system = System::builder()
//!     .mass("m", 0.5)
//!     .spring(GROUND, "m", 200.0)
//!     .damper(GROUND, "m", 14.0)
//!     .build()?;
//! let answer = Response::of(&system)
//!     .load("m", Impulse::of(10.0))
//!     .every(0.1)
//!     .until(0.5)
//!     .run()?;
//! // ANSYS verification manual, VM74, prints 0.34180.
//! assert!((answer.displacement()[(0, 1)] - 0.341804).abs() < 1e-6);
//! assert_eq!(answer.bounds(), Bounds::Proven);
//! assert!(answer.displacement_bound()[1] < Some(1e-16));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | you want | take |
//! |---|---|
//! | the motion, by the method that fits | [`Response::run`]; [`ResponsePlan`] says which and why |
//! | by one method and no other | [`Response::run_by`] with one of [`methods`]: [`ByCertifiedExponential`], [`BySuperposition`], [`ByExponential`] |
//! | the same question for several methods | [`Response::problem`] → [`Problem`] |
//! | at instants that are on no grid | [`ByCertifiedExponential::at`] |
//! | peaks, also between the instants | [`Extrema`]; peaks, ends and settling times in one: [`Summary`] |
//! | the steady state under harmonic loads (docs/theory.md, (36)) | [`SteadyState`]; [`receptance`] |
//! | frequency response functions, their peaks and dips | [`FrequencyResponse`], [`peak_grid`], [`Features`] |
//! | differences of motions, accelerations, pulls of elements | [`Response::sum`], [`Response::pull`]; all of them: [`Response::with_acceleration`], [`Response::with_forces`] |
//! | where the energy goes (docs/theory.md, (33)) | [`Energy`] |
//! | the largest motions of one-mass systems on a shaken base | [`ResponseSpectrum`] |
//! | A, B, C, D for control and filters, also held, and their process noise | [`StateSpace`] |
//! | root mean squares and spectral densities of motions under noise | [`RandomVibration`] |
//! | forces in springs and dampers | [`ElementForces`] |
//! | e^A of any matrix | [`expm`], [`expm_bounded`], and its condition |
//!
//! A step of any length is one exact hold (docs/theory.md, (20) to (24)). The certified exponential works in energy
//! coordinates, where errors do not grow (docs/theory.md, (34), (35)), with as many digits as the bounds ask for.
//! Nothing here prints or reads files.

mod answer;
mod certified;
mod enclosed;
pub mod exponential;
mod frequency_response;
mod hold;
mod march;
mod plan;
mod problem;
mod quantity;
mod response_spectrum;
mod state_space;
mod sweep;

pub use answer::{History, Operations, Output, ResponseMethod, Trajectory};
pub use certified::{ByCertifiedExponential, Driven, KnownVector};
pub use exponential::{
    BoundedExponential, ExpmError, Exponential, Pade13, SecondOrder, Taylor, energy_condition,
    expm, expm_bounded, expm_condition,
};
pub use frequency_response::{
    Adjoint, Asymptote, Features, FrequencyError, FrequencyFunction, FrequencyFunctions,
    FrequencyMethod, FrequencyResponse, FrequencyValue, HarmonicMotion, LargestGain, Peak,
    SteadyState, SteadyStateError, Transfer, peak_grid, receptance,
};
pub use march::{ByExponential, BySuperposition};
pub use plan::{ModalTruncation, Response, ResponsePlan, methods};
pub use problem::{
    AppliedLoad, Channel, Combination, Drive, HalfSine, Harmonic, Hold, Impulse, Instant, Load,
    LoadError, MAX_STEPS, Piece, Polynomial, Problem, Quantity, Ramp, ResponseError, Samples,
    State, Step, Straight, Sum, TimeGrid, Timeline, Versine, turns,
};
pub use quantity::{
    CombinationRest, CoordinateSummary, Destination, Discontinuity, ElementForces, Energy, Extrema,
    Extremum, Fastest, Jump, Peaks, Reached, Summary,
};
pub use response_spectrum::{
    BaseAcceleration, Baseline, ResponseSpectrum, SpectralPeak, SpectrumError,
};
pub use state_space::{
    BoundedMatrix, MeanSquare, Noise, RandomVibration, Rms, SpectralDensity, StateMatrices,
    StateSpace, StateSpaceBuilder, StateSpaceError, StationaryMotion, Statistics, Weighting,
};
pub use sweep::{Answer, Sweep, SweepError};
