//! Forces in springs and dampers along a trajectory as CSV.

use std::io::{self, Write};

use eigentone_modes::{Element, System};
use eigentone_response::{ElementForces, Trajectory};
use faer::MatRef;

use super::csv;

/// Prints element forces.
#[derive(Clone, Copy, Debug)]
pub struct ElementForceReport<'a> {
    forces: &'a ElementForces,
    system: &'a System,
    trajectory: &'a Trajectory,
}

impl<'a> ElementForceReport<'a> {
    /// A report of `forces`, which were computed for `system` along `trajectory`.
    pub fn new(
        forces: &'a ElementForces,
        system: &'a System,
        trajectory: &'a Trajectory,
    ) -> ElementForceReport<'a> {
        ElementForceReport {
            forces,
            system,
            trajectory,
        }
    }

    /// One row for each instant with all digits: step, instant, and the tension in each spring and
    /// damper, in their order, under the names of both ends.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn csv(&self, mut out: impl Write) -> io::Result<()> {
        let system = self.system;
        let header = |kind: &str, element: &Element| {
            let [first, second] = [element.first, element.second].map(|end| {
                let name = end.coordinate().map(|i| system.names()[i].as_str());
                name.unwrap_or(eigentone_modes::GROUND)
            });
            format!("{kind} {first}–{second} [N]")
        };
        let instant = ["step".to_owned(), "time [s]".to_owned()].into_iter();
        let springs = system
            .springs()
            .iter()
            .map(|spring| header("spring", spring));
        let dampers = system
            .dampers()
            .iter()
            .map(|damper| header("damper", damper));
        csv::row(&mut out, instant.chain(springs).chain(dampers))?;
        let instants = self.trajectory.steps().iter().zip(self.trajectory.times());
        for (column, (step, time)) in instants.enumerate() {
            let instant = [step.to_string(), csv::number(*time)].into_iter();
            let at = |of: MatRef<'a, f64>| {
                (0..of.nrows()).map(move |row| csv::number(of[(row, column)]))
            };
            let (springs, dampers) = (at(self.forces.springs()), at(self.forces.dampers()));
            csv::row(&mut out, instant.chain(springs).chain(dampers))?;
        }
        Ok(())
    }
}
