//! `eigentone random SCENE [--json] [--out DIR]`.

use std::path::PathBuf;

use clap::Args;
use eigentone::report::RandomReport;

use super::files::Files;
use super::progress::Progress;
use super::{Failure, Question, print};

/// Prints root mean squares of the stationary motion under the scene's white noise
#[derive(Debug, Args)]
pub struct Random {
    #[command(flatten)]
    question: Question,
    /// Print one JSON object with every digit
    #[arg(long)]
    json: bool,
    /// Write the root mean squares into this directory, as JSON and CSV
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Random {
    pub fn run(self) -> Result<(), Failure> {
        let scene = self.question.scene()?;
        let file = &self.question.scene;
        if scene.loss_factors().iter().any(|factor| *factor != 0.0) {
            let scene = file.clone();
            return Err(Failure::LossFactor { scene });
        }
        self.question.admit_modes(&scene)?;
        let Some(noise) = scene.noise() else {
            let scene = file.clone();
            return Err(Failure::NoNoise { scene });
        };
        let progress = Progress::of("random vibration");
        let motion = noise.solve().map_err(|error| Failure::StateSpace {
            scene: file.clone(),
            error,
        })?;
        drop(progress);
        let report = RandomReport {
            system: scene.system(),
            outputs: scene.outputs(),
            motion: &motion,
        };
        if let Some(directory) = &self.out {
            let mut files = Files::into(directory)?.beside(file);
            files.write("random.json", |out| report.json(out))?;
            files.write("random.csv", |out| report.csv(out))?;
            files.keep()?;
        }
        print(|out| match self.json {
            true => report.json(out),
            false => out.write_all(report.text().as_bytes()),
        })
    }
}
