//! Solvers of the quadratic eigenproblem (λ²M + λC + K)x = 0 behind one trait, and the choice among them. It knows
//! `first_order`, `inclusion`, `linear`, `model`, `modes`, `quality`, `structure` and `system`.

mod certified;
mod choice;
mod classical;
mod cluster;
mod coincidence;
mod consistency;
mod crowded;
mod improvement;
mod low_rank;
mod many_digits;
mod modal_damping;
mod modal_matrix;
mod mode_solver;
mod newton;
pub(crate) mod parts;
mod proof;
mod real_mode;
mod rigid;
mod roots;
mod secular;
mod shifted;
mod spring_factor;
mod springless;
mod star_mesh;
mod state_matrix;
mod symmetric;
mod tree_factor;
mod weak_coupling;

use num_complex::Complex;

pub use choice::solvers;
pub use classical::{Classical, ClassicalModes};
pub use low_rank::LowRank;
pub use modal_matrix::ModalMatrix;
pub use mode_solver::{ModeSolver, ModesError, dense_gigabytes};
pub use spring_factor::SpringFactor;
pub use springless::DamperFactor;
pub use state_matrix::StateMatrix;
pub use symmetric::Symmetric;

pub(crate) use roots::normalised;

use crate::modes::ModePlan;
use crate::modes::{Bounds, Mode, Modes, Precision};
use crate::structure::Structure;
use crate::system::System;
use choice::plan;
use mode_solver::admit_size;
use shifted::Shifted;

impl System {
    /// Natural frequencies, damping ratios and mode shapes with proven bounds, by the solver that
    /// the [plan](crate::ModePlan) picks: [`modes_to`](Self::modes_to) with the default precision.
    ///
    /// # Errors
    /// [`ModesError`] where no solver reaches an answer.
    pub fn modes(&self) -> Result<Modes, ModesError> {
        self.modes_to(Precision::default())
    }

    /// Modes to the given precision. Where a proof is not reached, the answer has estimated bounds
    /// and its plan says why.
    ///
    /// # Errors
    /// [`ModesError`] where no solver reaches an answer.
    pub fn modes_to(&self, precision: Precision) -> Result<Modes, ModesError> {
        admit_size(self)?;
        let parts = parts::parts(self);
        if parts.len() > 1 {
            let solved = parts.into_iter().map(|coordinates| {
                let part = parts::part(self, &coordinates);
                let modes = solve_part(&part, precision)?;
                Ok((coordinates, part, modes))
            });
            return Ok(parts::joined(
                self,
                solved.collect::<Result<_, ModesError>>()?,
            ));
        }
        solve_part(self, precision)
    }
}

fn solve_part(system: &System, precision: Precision) -> Result<Modes, ModesError> {
    if let Precision::Certified { tolerance } = precision
        && let Some(answer) = from_states(system, tolerance)
    {
        return Ok(answer);
    }
    let structure = system.structure();
    let solved: Result<(&'static dyn ModeSolver, Modes), ModesError> = if shifted::is_needed(system)
    {
        let modes = Shifted.solve(system);
        modes.map(|modes| (&Shifted as &'static dyn ModeSolver, modes))
    } else {
        in_doubles(system)
    };
    let (mut solver, mut answer) = match (solved, precision) {
        (Ok((solver, modes)), Precision::Certified { tolerance }) => {
            let answer = certified::certified(solver, system, modes, tolerance);
            (solver, answer)
        }
        (Err(error), Precision::Certified { tolerance }) => {
            let found = certified::from_guesses(&Shifted, system, tolerance);
            (&Shifted as &dyn ModeSolver, found.ok_or(error)?)
        }
        // What hides in doubles may show with more digits.
        (Err(ModesError::FirstOrder(_)), Precision::Double) => return Err(ModesError::Hidden),
        (solved, Precision::Double) => solved?,
    };
    if answer.bounds() == Bounds::Estimated && !consistency::holds(system, &answer) {
        (solver, answer) = consistent(system, solver, answer);
    }
    if answer.bounds() == Bounds::Estimated {
        crowded::enclose(solver, system, &mut answer);
    }
    coincidence::settle(system, &mut answer);
    // Squares of frequencies can leave the range of doubles where frequencies themselves do not.
    if !is_whole(structure, &answer) {
        return Err(ModesError::OutOfRange {
            method: solver.name(),
        });
    }
    Ok(answer)
}

/// Proved from the roots of the state matrix as they are, where the plan picks it.
fn from_states(system: &System, tolerance: f64) -> Option<Modes> {
    let structure = system.structure();
    if structure.zero_roots() != Some(0) || shifted::is_needed(system) {
        return None;
    }
    let (solver, plan) = plan(system).ok()?;
    if solver.name() != StateMatrix.name() {
        return None;
    }
    let mut roots = state_matrix::unrefined(system).ok()?;
    roots.retain(|root| root.value.im >= 0.0);
    let answer = certified::one_by_one(solver, plan, system, &roots, tolerance)?;
    is_whole(structure, &answer).then_some(answer)
}

/// By the solver that the plan picks; where rounding left it without an answer, or with modes that do not solve the
/// equation and that it cannot vouch for, by the first of the others that does better.
fn in_doubles(system: &System) -> Result<(&'static dyn ModeSolver, Modes), ModesError> {
    let structure = system.structure();
    const VISIBLE: f64 = 1e-6;
    let (first, plan) = match plan(system) {
        Ok((solver, plan)) => (solver, plan),
        // Doubles hide what determines the motion of massless nodes, but not that it is determined.
        Err(_) if Shifted.refuses(system).is_none() => {
            return Ok((&Shifted, Shifted.solve(system)?));
        }
        Err(error) => return Err(error),
    };
    let found = first.solve(system);
    let off = largest_doubt(structure, &found);
    if off <= VISIBLE {
        return Ok((first, Modes { plan, ..found? }));
    }
    let others = solvers()
        .iter()
        .copied()
        .chain([&Shifted as &dyn ModeSolver]);
    for other in others {
        if other.name() == first.name() || other.refuses(system).is_some() {
            continue;
        }
        let better = other.solve(system);
        if largest_doubt(structure, &better) >= off {
            continue;
        }
        let reason = match found {
            Err(error) => error.to_string(),
            Ok(_) if off.is_infinite() => "rounding lost it some of the roots".to_owned(),
            Ok(_) => format!("rounding left it with backward errors up to {off:.0e}"),
        };
        let plan = replaced(plan, other, first, reason);
        return Ok((other, Modes { plan, ..better? }));
    }
    Ok((first, Modes { plan, ..found? }))
}

/// Instead of roots that are not those of the system together: what another solver finds, if those are, or the same as doubtful.
fn consistent(
    system: &System,
    first: &'static dyn ModeSolver,
    mut found: Modes,
) -> (&'static dyn ModeSolver, Modes) {
    let structure = system.structure();
    const REASON: &str = "its roots do not sum up to those of M, C and K";
    for other in solvers().iter().copied() {
        if other.name() == found.plan.solver || other.refuses(system).is_some() {
            continue;
        }
        let better = other.solve(system);
        if largest_doubt(structure, &better).is_finite()
            && let Ok(modes) = better
            && consistency::holds(system, &modes)
        {
            return (
                other,
                Modes {
                    plan: replaced(found.plan, other, first, REASON.to_owned()),
                    ..modes
                },
            );
        }
    }
    roots::doubt(&mut found);
    found.plan.bounds = format!("doubtful: {REASON}");
    (first, found)
}

/// The plan with another solver in place of the first, and why.
fn replaced(
    mut plan: ModePlan,
    other: &dyn ModeSolver,
    first: &dyn ModeSolver,
    reason: String,
) -> ModePlan {
    plan.solver = other.name();
    plan.reason = other.reason().to_owned();
    plan.left_out.retain(|(name, _)| *name != other.name());
    plan.left_out.push((first.name(), reason));
    plan
}

/// Whether as many roots were found as are known to be finite, and to be 0, each with a shape.
fn is_whole(structure: &Structure, modes: &Modes) -> bool {
    let roots = || modes.eigenvalues.iter().map(|root| root.value);
    let zeros = roots().filter(|root| root.norm() == 0.0).count();
    let has_shape = |mode: &Mode| mode.shape.contains(&Complex::ONE);
    roots().all(|root| root.is_finite())
        && modes.iter().all(has_shape)
        && structure.zero_roots().is_none_or(|count| count == zeros)
        && structure
            .finite_roots()
            .is_none_or(|count| count == roots().count())
}

/// The largest backward error of a mode without a bound; infinite if one is not a number, or roots are missing.
fn largest_doubt(structure: &Structure, found: &Result<Modes, ModesError>) -> f64 {
    let Some(modes) = found
        .as_ref()
        .ok()
        .filter(|modes| is_whole(structure, modes))
    else {
        return f64::INFINITY;
    };
    let doubtful = modes.iter().filter(|mode| mode.eigenvalue().is_doubtful());
    let errors = doubtful.map(|mode| mode.backward_error());
    errors.fold(0.0, |top, error| {
        if error.is_nan() {
            f64::INFINITY
        } else {
            top.max(error)
        }
    })
}
