//! Which modes are wanted, where not all of them are.

use clap::Args;
use eigentone::modes::{Frequency, SparseError, SparseModes, System};

/// Some modes instead of all.
#[derive(Clone, Debug, Args)]
pub struct Selection {
    /// Only so many modes of the smallest frequencies, without damping that couples them to others;
    /// needs no dense matrices
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..))]
    lowest: Option<u32>,
    /// Only modes near this natural frequency, in rad/s
    #[arg(long, value_name = "FREQUENCY", value_parser = frequency, conflicts_with = "lowest")]
    near: Option<f64>,
    /// How many modes near that frequency [default: 10]
    #[arg(long, value_name = "COUNT", requires = "near", value_parser = clap::value_parser!(u32).range(1..))]
    count: Option<u32>,
}

impl Selection {
    /// Those modes, or `None` where all are wanted.
    pub fn of(&self, system: &System) -> Option<Result<SparseModes, SparseError>> {
        const DEFAULT: u32 = 10;
        if let Some(count) = self.lowest {
            return Some(SparseModes::lowest(system, count as usize));
        }
        let target = Frequency::from_radians_per_second(self.near?);
        let count = self.count.unwrap_or(DEFAULT);
        Some(SparseModes::nearest(system, target, count as usize))
    }
}

fn frequency(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        Ok(_) => Err("it must be a finite number of rad/s, 0 or more".to_owned()),
        Err(error) => Err(error.to_string()),
    }
}
