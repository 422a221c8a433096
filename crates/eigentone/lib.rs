//! Exact analysis of linear vibrating systems M x″ + C x′ + K x = f(t): natural frequencies, damping
//! ratios and mode shapes, and the motion at the instants asked for without any error from time
//! steps. Both come with proven bounds.
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
//! # What people ask
//!
//! | question | answer |
//! |---|---|
//! | Which frequencies, dampings and shapes does it have? | [`System::modes`](modes::System::modes) |
//! | How does it move from here, under these loads? | [`Response`](response::Response) |
//! | How far off is my integrator? | [`Trajectory`](response::Trajectory) at its instants, with bounds |
//! | What are the peaks, and when does it settle? | [`Summary`](response::Summary), between the instants too |
//! | Which forces act in springs and dampers? | [`ElementForces`](response::ElementForces) |
//! | How does it answer a harmonic force? | [`FrequencyResponse`](response::FrequencyResponse), [`SteadyState`](response::SteadyState) |
//! | What does an earthquake or a shaker do? | [`ResponseSpectrum`](response::ResponseSpectrum), motions of supports |
//! | How large is the motion under noise? | [`RandomVibration`](response::RandomVibration) |
//! | What is e^A, and how far may it be off? | [`expm`], [`expm_bounded`] |
//! | Which matrices does my controller take? | [`StateSpace`](response::StateSpace), continuous or held |
//! | How do roots follow a spring? | [`Sweep`](response::Sweep), [`Sensitivity`](modes::Sensitivity) at one design |
//!
//! # Where to find what
//!
//! - [`prelude`]: what most programs need.
//! - [`modes`]: from elements to a [`System`](modes::System), what is proved of it, its
//!   [`Modes`](modes::Modes), sensitivities, and every solver as a value.
//! - [`response`]: loads, initial [`State`](response::State)s and the exact
//!   [`Trajectory`](response::Trajectory), by every method as a value; its
//!   [`Extrema`](response::Extrema), [`Energy`](response::Energy) and
//!   [`ElementForces`](response::ElementForces); the [`SteadyState`](response::SteadyState) under harmonic
//!   loads, and receptances.
//! - [`switching`]: friction, stops, impacts and switched dampers; the exact motion through their events.
//! - [`design`]: which designs a study looks at, and which root of one is which of the next.
//! - [`check`]: closed forms and numerical integrators to compare with, an independent reference with
//!   any number of digits, and tables of error against run time.
//! - [`scene`]: the scene file.
//! - [`report`]: results as tables, JSON, CSV and plots.
//! - [`tables`]: reference tables to 15 digits, every one of which is right.
//! - `gallery`: scenes with 34-digit answers; with the feature `gallery`.
//!
//! The book in `docs/` has recipes for library users (docs/cookbook.md), the theory with numbered formulas
//! that this documentation refers to (docs/theory.md, (1) to (38)), and what is promised and how it is tested
//! (docs/guarantees.md).
//!
//! # Conventions
//!
//! Matrices are those of the crate `faer`. Coordinates come in the order in which masses are given; a trajectory has one row for each
//! coordinate and one column for each instant. Units must be coherent; the documentation assumes SI.
//! Frequencies are [`Frequency`](modes::Frequency) values, rad/s inside and Hz only by asking. What is
//! *proven* holds as a theorem; what is *estimated* is to first order, and marked so. Nothing panics for any
//! input, but an index that does not exist; errors say what was wrong and what would be right.
//!
//! # Features
//!
//! `cli`, on by default, builds the command line, and needs `check`, `scene`, `report` and `gallery`, the modules of
//! these names; [`tables`] is there with the first three. `serde`, which `report` needs, writes [`System`](modes::System)s under the keys
//! of scenes and reads them back, and writes [`Modes`](modes::Modes), [`Trajectory`](response::Trajectory) and
//! [`Structure`](modes::Structure). `stiff` adds integrators of the crate `diffsol` to the comparisons; `rayon`
//! spreads sweeps over threads. `default-features = false` leaves all out, and with them half of the packages.

#[cfg(feature = "gallery")]
pub mod gallery;
pub mod prelude;
#[cfg(feature = "report")]
pub mod report;
#[cfg(feature = "scene")]
pub mod scene;
#[cfg(all(feature = "check", feature = "report", feature = "scene"))]
pub mod tables;

#[cfg(feature = "check")]
pub use eigentone_check as check;
pub use eigentone_design as design;
pub use eigentone_modes as modes;
pub use eigentone_response as response;
pub use eigentone_switching as switching;

pub use eigentone_response::{expm, expm_bounded};

// The snippets of the pages are tests.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct ReadMe;

#[cfg(doctest)]
#[doc = include_str!("../../docs/cookbook.md")]
struct Cookbook;
