//! Checks for the exact methods: motions known in closed form, numerical integrators to compare
//! with, and the error of every method against its run time.
//!
//! - [`MassSpringDamper`] is the textbook's single mass, exact to the last places at any damping;
//!   [`OneMass`] is the same as a [`ResponseMethod`](eigentone_response::ResponseMethod).
//! - [`ExactMass`], [`UniformChain`] and [`UndampedPair`] are closed forms in any number of digits.
//! - [`Reference`] gives eigenvalues and responses of any small system in any number of digits, by
//!   ways and in an arithmetic of its own.
//! - [`Integrator`]s are methods that are not exact: [`Dop853`], [`DormandPrince5`],
//!   [`Radau5`], [`RungeKutta4`], [`Newmark`], [`HhtAlpha`], [`GeneralizedAlpha`]. They count their [`Work`], and
//!   predict how many steps they will take. The feature `stiff` adds `Bdf`, `TrBdf2` and
//!   `Esdirk34` by the crate `diffsol`.
//! - [`EventDriven`] integrates systems with switches, and locates their events.
//! - [`WorkPrecision`] answers one problem by all of them and tables error, run time and work;
//!   [`ModeComparison`] does so for the mode solvers.
//!
//! To check an integrator of your own, implement [`ResponseMethod`](eigentone_response::ResponseMethod) for it, or
//! compare its numbers with an exact [`Trajectory`](eigentone_response::Trajectory); docs/cookbook.md shows both.
//!
//! Nothing here prints or touches files.
//!
//! ```
//! use eigentone_check::{Dop853, OneMass, TrajectoryError};
//! use eigentone_modes::{GROUND, System};
//! use eigentone_response::{Response, ResponseMethod, State, Step};
//!
//! let system = System::builder()
//!     .mass("m", 1.0)
//!     .spring(GROUND, "m", 4.0)
//!     .damper(GROUND, "m", 0.4)
//!     .build()?;
//! let problem = Response::of(&system)
//!     .from(State::at_rest().displace("m", 1.0))
//!     .load("m", Step::of(2.0).starting_at(3.0))
//!     .every(0.05)
//!     .until(20.0)
//!     .problem()?;
//! let exact = OneMass.run(&problem)?;
//! let integrated = Dop853::with_tolerance(1e-10).run(&problem)?;
//! let error = TrajectoryError::between(&integrated, &exact);
//! assert!(error.displacement < 1e-8 && error.displacement > 1e-15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod closed_form;
mod event_driven;
mod exponential_comparison;
mod instants;
mod integrator;
mod mode_comparison;
mod reference;
mod run_time;
mod stability;
mod trajectory_error;
mod truth;
mod work_precision;

pub use closed_form::{
    ChainEnds, ClosedFormError, Damping, ExactMass, ExactMotion, Kinematics, MassSpringDamper,
    OneMass, OneMassError, UndampedPair, UniformChain,
};
pub use event_driven::{EventDriven, EventDrivenMotion, OneStep};
pub use exponential_comparison::{ExponentialComparison, ExponentialRow};
pub use integrator::{
    Basis, Dop853, DormandPrince5, GeneralizedAlpha, HhtAlpha, Integrator, Knob, Limit, Newmark,
    Prediction, Radau5, RungeKutta4, Work,
};
#[cfg(feature = "stiff")]
pub use integrator::{Bdf, Esdirk34, TrBdf2};
pub use mode_comparison::{ModeComparison, ModeComparisonRow, ModeOutcome};
pub use reference::{
    Ball, EigenvalueError, Reference, ReferenceEigenvalue, ReferenceError, ReferenceModes,
    ReferenceResponse, Shape, ShapeComponent,
};
pub use run_time::RunTime;
pub use stability::{
    Cell, Difficulty, Family, FamilyStudy, StabilityRow, StabilityStudy, StudyProgress, Verdict,
};
pub use trajectory_error::TrajectoryError;
pub use work_precision::{
    Effort, EventsFound, Measurement, Outcome, Pick, Progress, WorkPrecision, WorkPrecisionRow,
    integrators,
};
