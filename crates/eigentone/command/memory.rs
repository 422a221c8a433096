//! How much memory an answer takes, estimated before any of it is taken.

use std::path::Path;

use clap::Args;
use eigentone::modes::System;
use eigentone::scene::Scene;

use super::Failure;

/// What is allowed unless more or less is asked for, in GB.
const DEFAULT: f64 = 8.5;

/// How much may be taken.
#[derive(Clone, Copy, Debug, Args)]
pub struct Limit {
    /// Refuse what would take more memory than this, in 1e9 bytes
    #[arg(long = "memory-limit", value_name = "GB", value_parser = gigabytes, default_value_t = DEFAULT)]
    allowed: f64,
}

impl Limit {
    /// Refuses what would take more than is allowed, before any is taken, and says of what there may be fewer.
    pub fn admit(
        &self,
        scene: &Path,
        bytes: f64,
        fewer: Option<&'static str>,
    ) -> Result<(), Failure> {
        let (needed, allowed) = (bytes / 1e9, self.allowed);
        if needed <= allowed {
            return Ok(());
        }
        Err(Failure::Memory {
            scene: scene.to_owned(),
            needed,
            allowed,
            fewer,
        })
    }

    /// The same for all modes; systems that are too large for dense matrices are recognised later.
    pub fn admit_modes(&self, file: &Path, scene: &Scene) -> Result<(), Failure> {
        match scene.system().is_large() {
            true => Ok(()),
            false => self.admit(file, of_modes(scene.system()), None),
        }
    }
}

/// The most bytes that all modes of a system take: up to 64 matrices of its order at a time, measured with general
/// damping, where it is most. The largest system that has dense matrices at all stays below the default.
pub fn of_modes(system: &System) -> f64 {
    64.0 * (system.len() as f64).powi(2) * 8.0
}

/// The most bytes that are kept of a rotor at so many speeds: roots with their bounds and whirls, and what is drawn from them.
pub fn of_speeds(system: &System, speeds: usize) -> f64 {
    speeds as f64 * (250 * system.len() + 300) as f64
}

/// The most bytes that a motion and what is drawn from it take: displacements, velocities and accelerations twice, the forces
/// in the elements with their bounds, energies and bounds, at every instant asked for.
pub fn of_motion(scene: &Scene, instants: u64) -> f64 {
    let system = scene.system();
    let elements = system.springs().len() + system.dampers().len();
    instants as f64 * (6 * system.len() + 6 * elements + 20) as f64 * 8.0
}

/// The most bytes that reference tables take: whole matrices, and for each coordinate at each instant rows of text in
/// five formats and the numbers before them; measured are 300 bytes and 1.3 kB. Systems beyond a thousand coordinates are
/// more work than a reference is worth, and refused by it before it takes any.
pub fn of_tables(scene: &Scene, instants: u64) -> f64 {
    let coordinates = (scene.system().len() as f64).min(1e3);
    1e3 * coordinates.powi(2) + 4e3 * coordinates * instants as f64
}

/// How many instants a scene has.
pub fn instants(scene: &Scene) -> u64 {
    let grid = scene.problem().and_then(Result::ok);
    grid.map_or(0, |problem| problem.grid().last() + 1)
}

fn gigabytes(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("it must be a number, finite and greater than 0".to_owned()),
    }
}
