//! From masses, springs and dampers to natural frequencies, damping ratios and mode shapes, with proven
//! bounds.
//!
//! A vibrating system M x″ + C x′ + K x = f (docs/theory.md, (1)) is a [`System`], built from named
//! elements or from matrices. [`System::modes`] solves its quadratic eigenproblem
//! (λ²M + λC + K) φ = 0 (docs/theory.md, (3)).
//!
//! ```
//! use eigentone_modes::{Bounds, GROUND, Motion, System};
//!
//! let system = System::builder()
//!     .mass("m1", 2.0)
//!     .mass("m2", 1.0)
//!     .spring(GROUND, "m1", 2.0)
//!     .spring("m1", "m2", 0.2)
//!     .damper("m1", "m2", 0.1)
//!     .build()?;
//! let modes = system.modes()?;
//! assert_eq!(modes.bounds(), Bounds::Proven);
//! for mode in &modes {
//!     assert_eq!(mode.motion(), Motion::Oscillating);
//!     let (hertz, zeta) = (mode.natural_frequency().hertz(), mode.damping_ratio());
//!     println!("{hertz:.4} Hz, ζ = {zeta:?}, shape {:?}", mode.shape());
//! }
//! // The plan says which solver was picked, and why not the others.
//! println!("{}", modes.plan());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | you want | take |
//! |---|---|
//! | frequencies, dampings, shapes | [`System::modes`] → [`Modes`] of [`Mode`]s; [`System::modes_to`] for less or estimated [`Precision`] |
//! | what is proved of a system, without tolerances | [`System::structure`] → [`Structure`] |
//! | what eigenpairs of another program are worth | [`examine_pairs`] |
//! | one solver and no other | [`solvers`], each a [`ModeSolver`] |
//! | real shapes and modal masses (docs/theory.md, (10), (16)) | [`ClassicalModes`] |
//! | how a mode depends on each element (docs/theory.md, (18)) | [`Sensitivity`] |
//! | effective modal masses | [`Participation`] |
//! | how alike shapes are | [`modal_assurance`], [`phase_collinearity`] |
//! | the state matrix (docs/theory.md, (8)) | [`FirstOrder`]; [`EnclosedFirstOrder`] with bounds |
//!
//! Elements are kept, and solvers work from them where they can: a spring of 1 beside one of 1e20 is lost as
//! soon as K is assembled in doubles, while every frequency is well determined by the springs
//! (docs/theory.md, (13), (14)). Nothing here prints or reads files.

mod assurance;
mod exact;
mod first_order;
mod inclusion;
mod linear;
mod model;
mod modes;
mod participation;
mod quality;
#[cfg(test)]
#[path = "../tests/modes/random.rs"]
mod random;
mod sensitivity;
mod solver;
mod sparse;
mod structure;
mod sweep;
mod system;

pub use assurance::{AssuranceError, modal_assurance, phase_collinearity};
pub use exact::null_space::null_vectors;
pub use exact::rank::is_singular;
pub use first_order::{EnclosedFirstOrder, FirstOrder, FirstOrderError};
pub use linear::{Balanced, balance, eigenvalues};
pub use model::{
    CoordinateKind, Element, ElementKind, Form, GROUND, GivenElement, MAX_COORDINATES,
    MAX_DENSE_COORDINATES, MatrixKind, Names, NoCoordinate, Node, Point, Term,
};
pub use modes::{Bounds, Eigenvalue, Frequency, Mode, ModePlan, Modes, Motion, Precision};
pub use participation::{Participation, ParticipationError};
pub use sensitivity::{Derivative, Sensitivity, SensitivityError};
pub use solver::{
    Classical, ClassicalModes, DamperFactor, LowRank, ModalMatrix, ModeSolver, ModesError,
    SpringFactor, StateMatrix, Symmetric, dense_gigabytes, solvers,
};
pub use sparse::{
    Amplitudes, Eigenpair, ExaminedPairs, SparseDynamicStiffness, SparseError, SparseModes,
    SparseWork, examine_pairs,
};
pub use structure::Structure;
pub use sweep::{Design, DesignError, ModesWorkspace};
pub use system::{Beam, BeamEnd, BuildError, Parameter, Rod, RodEnd, System, SystemBuilder};
