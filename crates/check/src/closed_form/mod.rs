//! Motions that are known in closed form.

mod digits;
mod exact_mass;
mod mass_spring_damper;
mod one_mass;
mod undamped_pair;
mod uniform_chain;

pub use digits::{ClosedFormError, ExactMotion};
pub use exact_mass::ExactMass;
pub use mass_spring_damper::{Damping, Kinematics, MassSpringDamper, OneMassError};
pub use one_mass::OneMass;
pub use undamped_pair::UndampedPair;
pub use uniform_chain::{ChainEnds, UniformChain};
