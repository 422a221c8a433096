//! Energies along a trajectory as CSV.

use std::io::{self, Write};

use eigentone_response::{Energy, Trajectory};

use super::csv;

/// Prints energies.
#[derive(Clone, Copy, Debug)]
pub struct EnergyReport<'a> {
    energy: &'a Energy,
    trajectory: &'a Trajectory,
}

impl<'a> EnergyReport<'a> {
    /// A report of `energy`, which was computed along `trajectory`.
    pub fn new(energy: &'a Energy, trajectory: &'a Trajectory) -> EnergyReport<'a> {
        EnergyReport { energy, trajectory }
    }

    /// One row for each instant with all digits: step, instant, kinetic and potential energy, what
    /// the dampers took and what the loads brought, and a bound of the error of each of the four.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn csv(&self, mut out: impl Write) -> io::Result<()> {
        let columns = [
            ("kinetic [J]", self.energy.kinetic()),
            ("potential [J]", self.energy.potential()),
            ("dissipated [J]", self.energy.dissipated()),
            ("work [J]", self.energy.work()),
            ("bound [J]", self.energy.bound()),
        ];
        let headers = columns.iter().map(|(header, _)| *header);
        csv::row(&mut out, ["step", "time [s]"].into_iter().chain(headers))?;
        let instants = self.trajectory.steps().iter().zip(self.trajectory.times());
        for (k, (step, time)) in instants.enumerate() {
            let cells = [step.to_string(), csv::number(*time)].into_iter();
            let energies = columns.iter();
            let energies = energies.filter_map(|(_, values)| values.get(k).copied());
            csv::row(&mut out, cells.chain(energies.map(csv::number)))?;
        }
        Ok(())
    }
}
