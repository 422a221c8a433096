//! What a node without mass cannot be given.

use eigentone_modes::System;

use super::applied_load::AppliedLoad;
use super::error::ResponseError;
use super::load::Load;
use super::state::State;

/// Refuses initial values and impulses that a massless node cannot take.
pub(crate) fn check(
    system: &System,
    initial: &State,
    loads: &[AppliedLoad],
) -> Result<(), ResponseError> {
    let structure = system.structure();
    let without_mass = |i: usize| structure.massless().binary_search(&i).is_ok();
    let without_damper = |i: usize| structure.damped_massless().binary_search(&i).is_err();
    for (name, _) in &initial.displacements {
        if system
            .index_of(name)
            .is_some_and(|i| without_mass(i) && without_damper(i))
        {
            return Err(ResponseError::InitialOnMassless { name: name.clone() });
        }
    }
    for (name, velocity) in &initial.velocities {
        let Some(i) = system.index_of(name).filter(|i| without_mass(*i)) else {
            continue;
        };
        if without_damper(i) {
            return Err(ResponseError::InitialOnMassless { name: name.clone() });
        }
        if *velocity != 0.0 {
            return Err(ResponseError::VelocityOnMassless { name: name.clone() });
        }
    }
    for (index, applied) in loads.iter().enumerate() {
        let i = applied.coordinate;
        if matches!(applied.load, Load::Impulse(_)) && without_mass(i) && without_damper(i) {
            let name = system.names()[i].clone();
            return Err(ResponseError::ImpulseOnMassless { index, name });
        }
    }
    Ok(())
}
