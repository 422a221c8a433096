//! How a result is printed.

use std::io::{self, Write};

use clap::Args;

use super::{Failure, print};

/// As a table for people, or for programs.
#[derive(Clone, Copy, Debug, Args)]
pub struct Form {
    /// Print one JSON object with every digit
    #[arg(long)]
    json: bool,
    /// Print comma-separated values with every digit, units in the first line
    #[arg(long, conflicts_with = "json")]
    csv: bool,
}

impl Form {
    /// Prints in the form asked for.
    pub fn print(
        self,
        json: impl FnOnce(&mut dyn Write) -> io::Result<()>,
        csv: impl FnOnce(&mut dyn Write) -> io::Result<()>,
        text: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        match (self.json, self.csv) {
            (true, _) => print(json),
            (_, true) => print(csv),
            _ => print(text),
        }
    }
}
