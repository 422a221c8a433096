//! The closed form of one mass as a response method.

use std::ops::Add;

use eigentone_digits::DoubleDouble;
use eigentone_modes::{MatrixKind, System};
use eigentone_response::{Instant, Load, Problem, ResponseError, ResponseMethod, Trajectory};
use faer::Mat;

use super::mass_spring_damper::{Kinematics, MassSpringDamper};
use crate::instants;

const NAME: &str = "closed form";

/// Beyond this phase 106 bits no longer hold ω t to the last place of a double.
const MAX_PHASE: f64 = (1u64 << 48) as f64;

/// The exact motion of one mass with springs and dampers to ground, from any initial state, under
/// steps and impulses (superposed). It refuses everything else that moves the mass. Outputs and forces in elements are not
/// computed: the answer has none.
///
/// Each motion is exact to a few units in the last place of its current amplitude; where several
/// loads are superposed, of the largest of theirs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OneMass;

impl OneMass {
    fn prepare(problem: &Problem<'_>) -> Result<MassSpringDamper, String> {
        let system = problem.system();
        if system.len() != 1 {
            return Err(format!("it has {} coordinates, not one", system.len()));
        }
        // Of these the list of loads below knows nothing.
        if !problem.channels().is_empty() {
            return Err(
                "motions of supports, forces on points and polynomial loads are not covered"
                    .to_owned(),
            );
        }
        for (index, applied) in problem.loads().iter().enumerate() {
            let kind = match applied.load {
                Load::Step(_) | Load::Impulse(_) => continue,
                Load::Ramp(_) => "a ramp",
                Load::Harmonic(_) => "harmonic",
                Load::Samples(_) => "given by samples",
                _ => "of another kind",
            };
            return Err(format!(
                "load {index} is {kind}, and only steps and impulses are covered"
            ));
        }
        let motion = MassSpringDamper::from_sums(
            sum(system, MatrixKind::Mass),
            sum(system, MatrixKind::Damping),
            sum(system, MatrixKind::Stiffness),
        )
        .map_err(|error| error.to_string())?;
        let end = problem.grid().time(problem.grid().last());
        if motion.phase(end) >= MAX_PHASE {
            return Err(format!(
                "its phase reaches {:.1e} rad, more than 2^48",
                motion.phase(end)
            ));
        }
        Ok(motion)
    }
}

/// The only entry of a matrix.
fn sum(system: &System, kind: MatrixKind) -> DoubleDouble {
    let terms = system.terms(kind);
    terms.fold(DoubleDouble::ZERO, |total, term| total + term.value)
}

/// What sets the mass in motion, and when.
enum Cause {
    Step(f64),
    Impulse(f64),
}

impl ResponseMethod for OneMass {
    fn name(&self) -> &'static str {
        NAME
    }

    fn refuses(&self, problem: &Problem<'_>) -> Option<String> {
        OneMass::prepare(problem).err()
    }

    fn run(&self, problem: &Problem<'_>) -> Result<Trajectory, ResponseError> {
        let motion = OneMass::prepare(problem).map_err(|reason| ResponseError::NotApplicable {
            method: NAME,
            reason,
        })?;
        let steps = instants::wanted(problem)?;
        let grid = problem.grid();
        let (x0, v0) = (
            problem.initial_displacement()[0],
            problem.initial_velocity()[0],
        );
        let origin = Instant::on_grid(grid, 0);
        let causes: Vec<(Instant, Cause)> = problem
            .loads()
            .iter()
            .filter_map(|applied| match applied.load {
                Load::Step(step) if step.start <= 0.0 => Some((origin, Cause::Step(step.force))),
                Load::Step(step) => {
                    Some((Instant::event(grid, step.start), Cause::Step(step.force)))
                }
                Load::Impulse(impulse) => Some((
                    Instant::event(grid, impulse.at),
                    Cause::Impulse(impulse.magnitude),
                )),
                _ => None,
            })
            .collect();
        let at = |index: u64| {
            let now = Instant::on_grid(grid, index);
            let free = motion.free_after(x0, v0, now.elapsed(&origin, grid));
            let total = causes
                .iter()
                .filter(|(start, _)| start.order(&now).is_le())
                .map(|(start, cause)| {
                    let elapsed = now.elapsed(start, grid);
                    match cause {
                        Cause::Step(force) => motion.step_after(*force, elapsed),
                        Cause::Impulse(momentum) => motion.impulse_after(*momentum, elapsed),
                    }
                })
                .fold(free, Kinematics::add);
            let finite = [total.displacement, total.velocity, total.acceleration];
            match finite.iter().all(|value| value.is_finite()) {
                true => Ok(total),
                false => Err(ResponseError::Overflow { index }),
            }
        };
        let motions: Vec<Kinematics> = steps.iter().map(|k| at(*k)).collect::<Result<_, _>>()?;
        let row = |value: fn(&Kinematics) -> f64| {
            Mat::from_fn(1, motions.len(), |_, column| value(&motions[column]))
        };
        let times = steps.iter().map(|k| grid.time(*k)).collect();
        let trajectory = Trajectory::new(
            NAME,
            steps,
            times,
            row(|motion| motion.displacement),
            row(|motion| motion.velocity),
        )
        .with_names(problem.system().coordinate_names());
        Ok(match problem.wants_acceleration() {
            true => trajectory.with_acceleration(row(|motion| motion.acceleration)),
            false => trajectory,
        })
    }
}
