//! Motions that are known in closed form.

mod mass_spring_damper;
mod one_mass;

pub use mass_spring_damper::{Damping, Kinematics, MassSpringDamper, OneMassError};
pub use one_mass::OneMass;
