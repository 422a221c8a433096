//! `eigentone new KIND`.

use clap::{Args, ValueEnum};

use super::{Failure, print};

/// Prints a scene to start from: save it, put your numbers in, analyse it
#[derive(Debug, Args)]
pub struct New {
    /// The kind of machine
    #[arg(value_enum)]
    kind: Kind,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Kind {
    /// A body and a wheel on a road with a bump
    QuarterCar,
    /// Storeys on soil that is shaken
    Building,
    /// A machine with a tuned absorber under a harmonic force
    Absorber,
    /// Masses in a row between walls
    Chain,
    /// A shaft with gyroscopic forces, by matrices
    Rotor,
}

impl New {
    pub fn run(self) -> Result<(), Failure> {
        let text = match self.kind {
            Kind::QuarterCar => include_str!("templates/quarter-car.json"),
            Kind::Building => include_str!("templates/building.json"),
            Kind::Absorber => include_str!("templates/absorber.json"),
            Kind::Chain => include_str!("templates/chain.json"),
            Kind::Rotor => include_str!("templates/rotor.json"),
        };
        print(|out| out.write_all(text.as_bytes()))
    }
}
