//! `eigentone campbell SCENE --speeds FROM:TO:COUNT [--given-at SPEED] [--orders 1,2] [--json] [--out DIR]`.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use eigentone::design::{Campbell as Rotor, Range};
use eigentone::report::CampbellReport;

use super::files::Files;
use super::progress::Progress;
use super::{Failure, Question, memory, positive, print, report_switches};

/// Prints modes against the speed of a rotor, and its critical speeds
#[derive(Debug, Args)]
pub struct Campbell {
    #[command(flatten)]
    question: Question,
    /// Speeds of the rotor in rad/s: FROM:TO:COUNT, FROM:TO:COUNT:log or values with commas between them
    #[arg(long, value_name = "RANGE", value_parser = range)]
    speeds: Range,
    /// The speed in rad/s for which the gyroscopic terms of the scene are given; at others they are in proportion
    #[arg(long, value_name = "SPEED", value_parser = positive, default_value_t = 1.0)]
    given_at: f64,
    /// Orders of the excitation: how many times it acts in each turn; 1 is unbalance; several with commas between
    #[arg(long, value_name = "ORDERS", value_parser = positive, value_delimiter = ',', default_value = "1")]
    orders: Vec<f64>,
    /// Print one JSON object with every digit
    #[arg(long)]
    json: bool,
    /// Write data and plots into this directory, replacing files of the same names
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Campbell {
    pub fn run(self) -> Result<(), Failure> {
        let scene = self.question.scene()?;
        let file = &self.question.scene;
        report_switches(file, &scene);
        self.question.report_loss_factors(&scene);
        self.question.admit_modes(&scene)?;
        let system = scene.system();
        if !system.is_large() {
            let kept = memory::of_speeds(system, self.speeds.values().len());
            self.question
                .admit(memory::of_modes(system) + kept, "speeds")?;
        }
        let progress = Progress::of("modes at all speeds");
        let rotor = Rotor::of(scene.system())
            .given_at(self.given_at)
            .orders(self.orders.as_slice())
            .precision(self.question.precision());
        let diagram = rotor.over(self.speeds.values());
        let diagram = diagram.map_err(|error| Failure::Campbell {
            scene: file.clone(),
            error,
        })?;
        drop(progress);
        if scene.system().gyroscopic_terms().is_empty() {
            let _ = writeln!(
                io::stderr(),
                "note: {}: the damping matrix is symmetric, so that the modes are the same at every speed",
                file.display()
            );
        }
        let name = self.question.name();
        let report = CampbellReport {
            title: scene.title().unwrap_or(&name),
            diagram: &diagram,
        };
        if let Some(directory) = &self.out {
            let mut files = Files::into(directory)?.beside(file);
            files.write("campbell.json", |out| report.json(out))?;
            files.write("campbell.csv", |out| report.csv(out))?;
            for (name, plot) in report.plots() {
                files.write(name, |out| out.write_all(plot.svg().as_bytes()))?;
            }
            files.keep()?;
        }
        print(|out| match self.json {
            true => report.json(out),
            false => out.write_all(report.text().as_bytes()),
        })
    }
}

fn range(text: &str) -> Result<Range, String> {
    text.parse()
        .map_err(|error: eigentone::design::RangeError| error.to_string())
}
