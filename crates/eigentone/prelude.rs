//! What most programs need: `use eigentone::prelude::*;`.

pub use crate::modes::{
    Bounds, Eigenvalue, Frequency, GROUND, MatrixKind, Mode, ModeSolver, Modes, Motion, Precision,
    Structure, System,
};
pub use crate::response::{
    Harmonic, Hold, Impulse, Load, Ramp, Response, ResponseMethod, Samples, State, Step, Trajectory,
};
