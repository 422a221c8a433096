//! `eigentone modes SCENE [--json]`.

use clap::Args;
use eigentone::report::ModeReport;

use super::progress::Progress;
use super::{Failure, Question, print};

/// Prints the mode table
#[derive(Debug, Args)]
pub struct Modes {
    #[command(flatten)]
    question: Question,
    /// Print one JSON object with every digit
    #[arg(long)]
    json: bool,
}

impl Modes {
    pub fn run(self) -> Result<(), Failure> {
        let scene = self.question.scene()?;
        let progress = Progress::of("modes");
        let modes = scene.system().modes_to(self.question.precision());
        drop(progress);
        let modes = modes.map_err(Failure::modes(&self.question.scene))?;
        let report = ModeReport::new(&modes, scene.system().names());
        print(|out| match self.json {
            true => report.json(out),
            false => out.write_all(report.text().as_bytes()),
        })
    }
}
