//! How much memory an answer takes, told before any of it is taken.

use eigentone::modes::System;
use eigentone::scene::Scene;

/// What is allowed unless more or less is asked for, in GB.
pub const DEFAULT: f64 = 8.5;

/// The most bytes that all modes of a system take: up to 64 matrices of its order at a time, measured with general
/// damping, where it is most. The largest system that has dense matrices at all stays below the default.
pub fn of_modes(system: &System) -> f64 {
    64.0 * (system.len() as f64).powi(2) * 8.0
}

/// The most bytes that a motion and what is drawn from it take: displacements and velocities twice, the forces in
/// the elements, energies and bounds, at every instant asked for.
pub fn of_motion(scene: &Scene, instants: u64) -> f64 {
    let system = scene.system();
    let elements = system.springs().len() + system.dampers().len();
    instants as f64 * (4 * system.len() + elements + 20) as f64 * 8.0
}

/// How many instants a scene has.
pub fn instants(scene: &Scene) -> u64 {
    let grid = scene.problem().and_then(Result::ok);
    grid.map_or(0, |problem| problem.grid().last() + 1)
}
