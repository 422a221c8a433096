//! All solvers in their order of preference, and the first of them that a system does not make needless.

use super::classical::Classical;
use super::low_rank::LowRank;
use super::modal_matrix::ModalMatrix;
use super::mode_solver::{ModeSolver, ModesError};
use super::roots;
use super::spring_factor::SpringFactor;
use super::springless::DamperFactor;
use super::state_matrix::StateMatrix;
use super::symmetric::Symmetric;
use crate::modes::ModePlan;
use crate::system::System;

/// Every mode solver there is, in the order in which the plan prefers them.
///
/// ```
/// use eigentone_modes::{GROUND, System, solvers};
///
/// let system = System::builder()
///     .mass("m", 1.0)
///     .spring(GROUND, "m", 4.0)
///     .damper(GROUND, "m", 0.4)
///     .build()?;
/// for solver in solvers() {
///     match solver.refuses(&system) {
///         Some(reason) => println!("{}: {reason}", solver.name()),
///         None => {
///             let modes = solver.solve(&system)?;
///             let frequency = modes.as_slice()[0].natural_frequency();
///             assert!((frequency.radians_per_second() - 2.0).abs() < 1e-14);
///         }
///     }
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn solvers() -> &'static [&'static dyn ModeSolver] {
    &[
        &SpringFactor,
        &Symmetric,
        &Classical,
        &DamperFactor,
        &LowRank,
        &ModalMatrix,
        &StateMatrix,
    ]
}

/// Picks the first solver that does not refuse and is not needless.
pub(crate) fn plan(system: &System) -> Result<(&'static dyn ModeSolver, ModePlan), ModesError> {
    let mut left_out = Vec::new();
    let mut chosen: Option<&'static dyn ModeSolver> = None;
    for &solver in solvers() {
        if chosen.is_some() {
            left_out.push((solver.name(), "not needed".to_owned()));
            continue;
        }
        let reason = solver.refuses(system);
        let reason = reason.or_else(|| solver.needless(system));
        match reason {
            None => chosen = Some(solver),
            Some(reason) => left_out.push((solver.name(), reason)),
        }
    }
    let Some(solver) = chosen else {
        let (method, reason) = left_out.pop().expect("there are solvers");
        return Err(ModesError::Refused { method, reason });
    };
    let plan = ModePlan {
        solver: solver.name(),
        reason: solver.reason().to_owned(),
        bounds: roots::DOUBLES.to_owned(),
        left_out,
        incomplete: None,
    };
    Ok((solver, plan))
}
