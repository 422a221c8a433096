//! `eigentone merge DIR`.

use std::path::PathBuf;

use clap::Args;

use super::progress::Progress;
use super::{Failure, parts, print};

/// Makes one table, and its plots, of the parts that `sweep --shard i/N --out DIR` wrote
#[derive(Debug, Args)]
pub struct Merge {
    /// The directory of all the parts
    #[arg(value_name = "DIR")]
    directory: PathBuf,
}

impl Merge {
    pub fn run(self) -> Result<(), Failure> {
        let progress = Progress::of("parts");
        let designs = parts::merge(&self.directory)?;
        drop(progress);
        let file = self.directory.join("sweep.csv");
        print(|out| writeln!(out, "{}: {designs} designs", file.display()))
    }
}
