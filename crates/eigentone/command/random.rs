//! `eigentone random SCENE [--peak-in T] [--json] [--out DIR]`.

use std::path::PathBuf;

use clap::Args;
use eigentone::report::RandomReport;
use eigentone::response::peak_grid;
use eigentone_digits::sort_by_number;

use super::files::Files;
use super::form::Form;
use super::progress::Progress;
use super::{Failure, Question, report_switches};

/// Prints root mean squares of the stationary motion under the scene's noise
#[derive(Debug, Args)]
pub struct Random {
    #[command(flatten)]
    question: Question,
    #[command(flatten)]
    form: Form,
    /// Print the expected largest value within this time, in s [default: the end of the scene's time]
    #[arg(long, value_name = "T", value_parser = duration)]
    peak_in: Option<f64>,
    /// Write the root mean squares into this directory, as JSON and CSV, and spectral densities, as CSV and SVG
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
        // Beside an error there is no note.
        report_switches(file, &scene);
        let name = self.question.name();
        let report = RandomReport {
            title: scene.title().unwrap_or(&name),
            system: scene.system(),
            outputs: scene.outputs(),
            motion: &motion,
            duration: self.peak_in.or(scene.end().filter(|end| *end > 0.0)),
        };
        if let Some(directory) = &self.out {
            progress.say("spectral densities");
            let modes = scene.system().modes_to(self.question.precision());
            let modes = modes.map_err(Failure::modes(file))?;
            let mut frequencies = match scene.frequencies() {
                Some(given) => given.to_vec(),
                None => peak_grid(scene.system(), &modes, scene.loss_factors()),
            };
            frequencies.extend(noise.ends());
            sort_by_number(&mut frequencies, |one| *one);
            frequencies.dedup();
            let densities = noise
                .densities(&frequencies)
                .map_err(|error| Failure::Frequency {
                    scene: file.clone(),
                    error,
                })?;
            let mut files = Files::into(directory)?.beside(file);
            files.write("random.json", |out| report.json(out))?;
            files.write("random.csv", |out| report.csv(out))?;
            files.write("spectra.csv", |out| {
                report.densities_csv(out, &frequencies, &densities)
            })?;
            let plot = report.plot(&frequencies, &densities).svg();
            files.write("spectra.svg", |out| out.write_all(plot.as_bytes()))?;
            files.keep()?;
        }
        drop(progress);
        self.form.print(
            |out| report.json(out),
            |out| report.csv(out),
            |out| out.write_all(report.text().as_bytes()),
        )
    }
}

fn duration(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(duration) if duration > 0.0 && f64::is_finite(duration) => Ok(duration),
        _ => Err("it must be a finite number of seconds greater than 0".to_owned()),
    }
}
