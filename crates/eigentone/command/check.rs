//! `eigentone check SCENE [--out DIR]`.

use std::path::PathBuf;

use clap::Args;
use eigentone::check::{
    Effort, ExponentialComparison, Integrator, ModeComparison, OneStep, Progress as Row,
    WorkPrecision, integrators,
};
use eigentone::report::CheckReport;
use eigentone::response::{ResponseMethod, methods};
use eigentone::scene::did_you_mean;

use super::files::Files;
use super::progress::Progress;
use super::{Failure, Question, memory, print, report_switches};

type Methods = (
    Vec<&'static dyn ResponseMethod>,
    Vec<Box<dyn Integrator>>,
    Vec<OneStep>,
);

/// Compares every solver and method that applies: error, run time, work
#[derive(Debug, Args)]
pub struct Check {
    #[command(flatten)]
    question: Question,
    /// Only these methods of the response, with commas between, as "certified exponential,DOP853" [default: all]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    methods: Vec<String>,
    /// Print one JSON object with every digit
    #[arg(long)]
    json: bool,
    /// Write the tables and the work-precision diagram into this directory, replacing files of the same names
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Check {
    pub fn run(self) -> Result<(), Failure> {
        let scene = self.question.scene()?;
        let file = &self.question.scene;
        let switches = scene.switches();
        let (exact, integrators, stepping) = self.methods(!switches.is_empty())?;
        self.question.admit_modes(&scene)?;
        let motion = memory::of_motion(&scene, memory::instants(&scene));
        self.question.admit(motion, "instants")?;
        let progress = Progress::of("check");
        let mut report = |row: Row| progress.say(&message(&row));
        let modes = ModeComparison::measure(scene.system(), &mut report);
        let modes = modes.map_err(Failure::modes(file))?;
        let problem = scene.problem().transpose();
        let problem = problem.map_err(Failure::response(file))?;
        let problem = problem.map(|problem| problem.to(self.question.precision()));
        // A system that is too large for proofs has no comparison of exponentials.
        let exponentials = problem.as_ref().and_then(|problem| {
            let step = problem.grid().step();
            ExponentialComparison::measure(scene.system(), step, &mut report).ok()
        });
        let places = scene.switch_places();
        let response = match &problem {
            Some(problem) if !switches.is_empty() => {
                let effort = Effort::default();
                let compared = WorkPrecision::measure_switched(
                    problem,
                    &switches,
                    &stepping,
                    effort,
                    &mut report,
                );
                Some(Ok(compared.map_err(Failure::switching(file, places))?))
            }
            Some(problem) => {
                let effort = Effort::default();
                Some(WorkPrecision::measure(
                    problem,
                    &exact,
                    &integrators,
                    effort,
                    &mut report,
                ))
            }
            None => None,
        };
        let name = self.question.name();
        let report = CheckReport {
            title: scene.title().unwrap_or(&name),
            modes: &modes,
            exponentials: exponentials.as_ref(),
            response: response.as_ref().map(Result::as_ref),
        };
        if let Some(directory) = &self.out {
            write(&report, Files::into(directory)?.beside(file))?;
        }
        drop(progress);
        report_switches(file, &scene);
        print(|out| match self.json {
            true => report.json(out),
            false => out.write_all(report.text().as_bytes()),
        })?;
        // What is said of the modes holds all the same.
        match response {
            Some(Err(error)) => Err(Failure::response(file)(error)),
            _ => Ok(()),
        }
    }

    /// The exact methods and the integrators that are asked for, by their names in the table; of scenes with switches, those
    /// that locate events.
    fn methods(&self, switched: bool) -> Result<Methods, Failure> {
        let (mut exact, mut integrators, mut stepping) = match switched {
            true => (Vec::new(), Vec::new(), OneStep::ALL.to_vec()),
            false => (methods().to_vec(), integrators(), Vec::new()),
        };
        if self.methods.is_empty() {
            return Ok((exact, integrators, stepping));
        }
        let mut all: Vec<&str> = exact.iter().map(|method| method.name()).collect();
        all.extend(integrators.iter().map(|method| method.name()));
        all.extend(stepping.iter().map(|method| method.name()));
        all.dedup();
        let is_same = |name: &str, known: &str| name.trim().to_lowercase() == known.to_lowercase();
        let asked = |known: &str| self.methods.iter().any(|name| is_same(name, known));
        let mut names = self.methods.iter();
        if let Some(name) = names.find(|name| !all.iter().any(|known| is_same(name, known))) {
            let hint = did_you_mean(name, &all);
            let name = name.clone();
            return Err(Failure::NoSuchMethod { name, hint });
        }
        exact.retain(|method| asked(method.name()));
        integrators.retain(|method| asked(method.name()));
        stepping.retain(|method| asked(method.name()));
        Ok((exact, integrators, stepping))
    }
}

fn message(row: &Row) -> String {
    let setting = row.knob.map(|knob| format!(", {knob}"));
    let setting = setting.unwrap_or_default();
    format!("{} of {}: {}{setting}", row.done + 1, row.total, row.method)
}

fn write(report: &CheckReport<'_>, mut files: Files) -> Result<(), Failure> {
    files.write("check.json", |out| report.json(out))?;
    files.write("check.md", |out| {
        out.write_all(report.markdown().as_bytes())
    })?;
    if let Some(plot) = report.plot() {
        files.write("work-precision.svg", |out| {
            out.write_all(plot.svg().as_bytes())
        })?;
    }
    files.keep()
}
