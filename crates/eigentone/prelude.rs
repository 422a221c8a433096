//! What most programs need: `use eigentone::prelude::*;`.

pub use crate::modes::{
    Eigenvalue, Frequency, GROUND, MatrixKind, Mode, ModeSolver, Modes, Motion, Structure, System,
};
pub use crate::response::{
    Harmonic, Hold, Impulse, Load, Ramp, Response, ResponseMethod, Samples, State, Step, Trajectory,
};
