//! Which modes are wanted, where not all of them are.

use clap::Args;
use eigentone::modes::{Frequency, Modes, ModesError, SparseError, SparseModes, System};

use super::frequency::Asked;

/// Some modes instead of all.
#[derive(Clone, Debug, Args)]
pub struct Selection {
    /// Only this many modes, those of the lowest frequencies; beyond 400 coordinates without dense
    /// matrices
    #[arg(long, value_name = "COUNT", value_parser = super::count)]
    lowest: Option<u32>,
    /// Only modes near this natural frequency, in rad/s or with a unit, as 88 or 14Hz
    #[arg(long, value_name = "FREQUENCY", value_parser = str::parse::<Asked>, conflicts_with = "lowest")]
    near: Option<Asked>,
    /// A frequency of --near without a unit is in Hz
    #[arg(long, requires = "near")]
    hz: bool,
    /// How many modes near that frequency [default: 10]
    #[arg(long, value_name = "COUNT", requires = "near", value_parser = super::count)]
    count: Option<u32>,
}

/// Up to so many coordinates all modes are found, which bounds them better, and some are chosen.
const ALL: usize = 400;

impl Selection {
    /// Those of all the modes of a system that is small enough for them; `None` for others and where all are
    /// wanted.
    pub fn among_all(
        &self,
        system: &System,
        modes: impl FnOnce() -> Result<Modes, ModesError>,
    ) -> Option<Result<Modes, ModesError>> {
        let (target, count) = self.wanted()?;
        let small = system.len() <= ALL;
        small.then(|| modes().map(|modes| modes.nearest(target, count)))
    }

    /// Whether all modes of the system are found, be it to choose among them.
    pub fn takes_all(&self, system: &System) -> bool {
        self.wanted().is_none() || system.len() <= ALL
    }

    /// What frequency they are to be near, and how many; the lowest are near 0.
    pub fn wanted(&self) -> Option<(Frequency, usize)> {
        const DEFAULT: u32 = 10;
        let (target, count) = match self.lowest {
            Some(count) => (0.0, count),
            None => (
                self.near?.radians_per_second(self.hz),
                self.count.unwrap_or(DEFAULT),
            ),
        };
        Some((Frequency::from_radians_per_second(target), count as usize))
    }

    /// Those modes, or `None` where all are wanted.
    pub fn of(&self, system: &System) -> Option<Result<SparseModes, SparseError>> {
        let (target, count) = self.wanted()?;
        Some(match self.lowest {
            Some(_) => SparseModes::lowest(system, count),
            None => SparseModes::nearest(system, target, count),
        })
    }
}
