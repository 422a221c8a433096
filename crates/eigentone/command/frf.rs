//! `eigentone frf SCENE [--from NAME]… [--to NAME]… [--quantity …] [--at …] [--json] [--out DIR]`.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use eigentone::modes::SparseModes;
use eigentone::report::FrequencyReport;
use eigentone::response::{FrequencyResponse, Quantity, peak_grid};
use eigentone::scene::Scene;

use super::files::Files;
use super::form::Form;
use super::frequency::Asked;
use super::progress::Progress;
use super::{Failure, Question, known_ends, report_switches};

/// Prints frequency response functions, their peaks and their dips
#[derive(Debug, Args)]
pub struct Frf {
    #[command(flatten)]
    question: Question,
    /// A unit force on this mass or point, or a unit displacement of this support; may be repeated [default: what the scene
    /// drives, else its supports, else each mass of up to 8]
    #[arg(long, value_name = "NAME")]
    from: Vec<String>,
    /// An output: a mass, a point, a support or an output of the scene; may be repeated [default: all masses, points and outputs]
    #[arg(long, value_name = "NAME")]
    to: Vec<String>,
    /// Which derivative of the motion of masses, points and supports
    #[arg(long, value_enum, default_value_t = Derivative::Displacement)]
    quantity: Derivative,
    /// At these frequencies, in rad/s or with a unit, as 1,2.5 or 14Hz [default: the "frequencies" of the scene, else a grid
    /// that shows every peak]
    #[arg(long, value_name = "FREQUENCIES", value_delimiter = ',', value_parser = str::parse::<Asked>)]
    at: Option<Vec<Asked>>,
    /// Frequencies of --at without a unit are in Hz
    #[arg(long, requires = "at")]
    hz: bool,
    #[command(flatten)]
    form: Form,
    /// Write data and plots into this directory, replacing files of the same names
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Derivative {
    Displacement,
    Velocity,
    Acceleration,
}

/// Systems with more coordinates show the lowest modes alone where no frequencies are given.
const MANY: usize = 400;
const LOWEST: usize = 20;

/// So far beyond the last of them.
const BEYOND: f64 = 1.01;

/// Functions times coordinates: beyond it proven peaks, and estimated ones of more coordinates, take minutes.
const MOST_PROVEN: usize = 2000;
const MOST_ESTIMATED: usize = 20_000;

/// As many inputs as are taken where none is named.
const INPUTS: usize = 8;

impl Frf {
    pub fn run(self) -> Result<(), Failure> {
        let scene = self.question.scene()?;
        known_ends(&self.question.scene, &scene, &self.from, &self.to)?;
        report_switches(&self.question.scene, &scene);
        let file = &self.question.scene;
        let failure = |error| Failure::Frequency {
            scene: file.clone(),
            error,
        };
        let quantity = match self.quantity {
            Derivative::Displacement => Quantity::Displacement,
            Derivative::Velocity => Quantity::Velocity,
            Derivative::Acceleration => Quantity::Acceleration,
        };
        let asked = asked(&scene, &self.from, &self.to)
            .quantity(quantity)
            .precision(self.question.precision());
        let progress = Progress::of("frequency response");
        let of_peaks = || -> Result<Vec<f64>, Failure> {
            let modes = match scene.system().len() > MANY {
                true => SparseModes::lowest(scene.system(), LOWEST)
                    .and_then(|found| found.modes())
                    .map_err(Failure::sparse(file))?,
                false => {
                    let modes = scene.system().modes_to(self.question.precision());
                    let modes = modes.map_err(Failure::modes(file))?;
                    self.question.report_rounding(scene.system(), &modes);
                    modes
                }
            };
            let mut grid = peak_grid(scene.system(), &modes, scene.loss_factors());
            if scene.system().len() > MANY {
                // Beyond the modes that were found peaks would be missed.
                let roots = modes.eigenvalues().iter().map(|root| root.value.norm());
                let last = BEYOND * roots.fold(0.0, f64::max);
                grid.retain(|frequency| *frequency <= last);
            }
            Ok(grid)
        };
        let grid = match (&self.at, scene.frequencies()) {
            (Some(at), _) => at.iter().map(|at| at.radians_per_second(self.hz)).collect(),
            (None, Some(given)) => given.to_vec(),
            (None, None) => of_peaks()?,
        };
        if scene.system().len() > MANY && self.at.is_none() && scene.frequencies().is_none() {
            let _ = writeln!(
                io::stderr(),
                "note: {}: {} coordinates: frequencies around the {LOWEST} lowest modes; name others with \"frequencies\" in the \
                 scene, or --at",
                file.display(),
                scene.system().len(),
            );
        }
        let functions = asked.at(&grid).map_err(failure)?;
        let count = functions.functions().len();
        let (searched, most) = (
            count * scene.system().len(),
            match scene.system().len() > MANY {
                true => MOST_ESTIMATED,
                false => MOST_PROVEN,
            },
        );
        let features = match self.at {
            Some(_) => None,
            None if searched > most => {
                let _ = writeln!(
                    io::stderr(),
                    "note: {}: peaks of {count} functions of {} coordinates would take minutes and are not sought: name fewer \
                     inputs and outputs with --from and --to",
                    file.display(),
                    scene.system().len(),
                );
                None
            }
            None => {
                progress.say("peaks");
                let mut grid = grid.clone();
                if let (Some(first), Some(last), true) =
                    (grid.first(), grid.last(), scene.frequencies().is_some())
                {
                    let within = *first..=*last;
                    let more = of_peaks()?.into_iter();
                    grid.extend(more.filter(|frequency| within.contains(frequency)));
                }
                Some(asked.features(&grid).map_err(failure)?)
            }
        };
        let name = self.question.name();
        let report = FrequencyReport {
            title: scene.title().unwrap_or(&name),
            system: scene.system(),
            outputs: scene.outputs(),
            functions: &functions,
            features: features.as_deref(),
        };
        if let Some(directory) = &self.out {
            progress.say("report");
            let mut files = Files::into(directory)?.beside(file);
            files.write("frf.json", |out| report.json(out))?;
            files.write("frf.csv", |out| report.csv(out))?;
            for (name, plot) in report.plots() {
                files.write(name, |out| out.write_all(plot.svg().as_bytes()))?;
            }
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

/// From the inputs named, or what the scene drives, else its supports, else each mass of few; to the outputs named, or all.
pub(super) fn asked<'a>(scene: &'a Scene, from: &[String], to: &[String]) -> FrequencyResponse<'a> {
    let system = scene.system();
    let many = scene.driven().is_empty() && system.supports().is_empty() && system.len() > INPUTS;
    let inputs = match from {
        [] if many => Vec::new(),
        [] => scene.inputs(),
        named => named.to_vec(),
    };
    scene.frequency_response(&inputs, (!to.is_empty()).then_some(to))
}
