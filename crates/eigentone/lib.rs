//! Exact analysis of linear vibrating systems M x″ + C x′ + K x = f(t): natural frequencies, damping
//! ratios and mode shapes, with proven bounds, and the motion at chosen instants without any error
//! from integration, with an estimate of its rounding.
//!
//! ```
//! use eigentone::prelude::*;
//!
//! let system = System::builder()
//!     .mass("m1", 2.0)
//!     .mass("m2", 1.0)
//!     .spring(GROUND, "m1", 2.0)
//!     .spring("m1", "m2", 0.2)
//!     .damper("m1", "m2", 2.0)
//!     .build()?;
//!
//! for mode in &system.modes()? {
//!     let (frequency, ratio) = (mode.natural_frequency(), mode.damping_ratio());
//!     println!("{} at {:.4} Hz, ζ = {ratio:?}", mode.motion(), frequency.hertz());
//! }
//!
//! let response = Response::of(&system)
//!     .from(State::at_rest().displace("m1", 1.0))
//!     .load("m2", Step::of(1.0))
//!     .every(0.5)
//!     .until(500.0)
//!     .run()?;
//! // It comes to rest where the springs balance the force: 1/2 m, and 1/0.2 m more.
//! assert!((response.displacement()[(1, 1000)] - 5.5).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! - [`prelude`]: what most programs need.
//! - [`modes`]: from elements to a [`System`](modes::System), what is proved of it, its
//!   [`Modes`](modes::Modes), and every solver as a value.
//! - [`response`]: loads, initial [`State`](response::State)s and the exact
//!   [`Trajectory`](response::Trajectory), by every method as a value; its
//!   [`Energy`](response::Energy) and [`ElementForces`](response::ElementForces); the
//!   [`SteadyState`](response::SteadyState) under harmonic loads, and receptances.
//! - [`check`]: closed forms and numerical integrators to compare with, and tables of error against
//!   run time.
//! - [`scene`]: the scene file.
//! - [`report`]: results as tables, JSON, CSV and plots.
//! - [`tables`]: reference tables to 15 digits, every one of which is right.
//! - `gallery`: scenes with 34-digit answers; with the feature `gallery`.
//!
//! Matrices are [`faer`]'s. Units must be coherent; the documentation assumes SI. The feature `cli`
//! builds the command line and is the only one on by default besides `gallery`, which it needs.

#[cfg(feature = "gallery")]
pub mod gallery;
pub mod prelude;
pub mod report;
pub mod scene;
pub mod tables;

pub use eigentone_check as check;
pub use eigentone_modes as modes;
pub use eigentone_response as response;

#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct ReadMe;
