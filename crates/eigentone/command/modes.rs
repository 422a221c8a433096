//! `eigentone modes SCENE [--json] [--lowest COUNT | --near FREQUENCY [--count COUNT]] [--engine slepc --ranks COUNT …]`.

use std::io::{self, Write};

use clap::{Args, ValueEnum};
use eigentone::modes::{ExaminedPairs, Mode, Modes as Found, System, examine_pairs};
use eigentone::report::ModeReport;
use num_complex::Complex;

use super::form::Form;
use super::progress::Progress;
use super::selection::Selection;
use super::slepc::Slepc;
use super::{Failure, Question, report_switches};

/// Prints the mode table
#[derive(Debug, Args)]
pub struct Modes {
    #[command(flatten)]
    question: Question,
    #[command(flatten)]
    selection: Selection,
    #[command(flatten)]
    form: Form,
    /// Which program finds the modes; those of another program are checked here
    #[arg(long, value_enum, default_value_t = Engine::Own)]
    engine: Engine,
    /// Check the modes of SLEPc by their residuals alone, without a factorisation, which takes most of the time of large
    /// models: bounds are larger, and that no mode is missing is not checked
    #[arg(long)]
    no_factor: bool,
    #[command(flatten)]
    slepc: Slepc,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Engine {
    /// This program
    Own,
    /// SLEPc on PETSc over MPI, by slepc4py, for models beyond one machine
    Slepc,
}

/// The most multiplications that a factor may take which examines what another engine found: half a minute.
const OPERATIONS: f64 = 2e10;

impl Modes {
    pub fn run(self) -> Result<(), Failure> {
        let scene = self.question.scene()?;
        report_switches(&self.question.scene, &scene);
        let progress = Progress::of("modes");
        let file = &self.question.scene;
        let names = scene.system().names();
        self.question.report_loss_factors(&scene);
        if self.engine == Engine::Slepc {
            drop(progress);
            let modes = self.by_slepc(scene.system())?;
            return self.print(&modes, |report| report.selected(modes.is_complete()), names);
        }
        let precision = self.question.precision();
        if self.selection.takes_all(scene.system()) {
            self.question.admit_modes(&scene)?;
        }
        let all = || scene.system().modes_to(precision);
        if let Some(modes) = self.selection.among_all(scene.system(), all) {
            drop(progress);
            let modes = modes.map_err(Failure::modes(file))?;
            self.question.report_estimates(&modes);
            return self.print(&modes, |report| report.selected(modes.is_complete()), names);
        }
        if let Some(found) = self.selection.of(scene.system()) {
            let found = found.map_err(Failure::sparse(file))?;
            let modes = found.modes().map_err(Failure::sparse(file))?;
            drop(progress);
            return self.print(&modes, |report| report.selected(modes.is_complete()), names);
        }
        let modes = all();
        drop(progress);
        let modes = modes.map_err(Failure::modes(file))?;
        self.question.report_estimates(&modes);
        self.question.report_rounding(scene.system(), &modes);
        self.print(&modes, |report| report, names)
    }

    fn operations(&self) -> f64 {
        if self.no_factor { 0.0 } else { OPERATIONS }
    }

    /// Some modes that SLEPc found, with what is known of them here.
    fn by_slepc(&self, system: &System) -> Result<Found, Failure> {
        let scene = &self.question.scene;
        let (target, count) = self.selection.wanted().ok_or(Failure::EngineForAll)?;
        let failed = |error| Failure::Slepc {
            scene: scene.clone(),
            error,
        };
        // What cannot be examined, or kept, is not looked for.
        examine_pairs(system, target, count, Vec::new(), 0.0).map_err(Failure::sparse(scene))?;
        let shapes = 3.0 * (count as f64 + 6.0) * system.len() as f64;
        self.question
            .admit(shapes * size_of::<Complex<f64>>() as f64, "modes")?;
        let pairs = self.slepc.pairs(system, target, count).map_err(failed)?;
        let progress = Progress::of("examining what SLEPc found");
        let examined = examine_pairs(system, target, count, pairs, self.operations());
        drop(progress);
        let ExaminedPairs {
            modes,
            unfit,
            missing,
        } = examined.map_err(Failure::sparse(scene))?;
        let note = |text: String| {
            // If standard error is closed, nobody can be informed.
            let _ = writeln!(io::stderr(), "note: {}: {text}", scene.display());
        };
        if unfit > 0 {
            note(format!(
                "{unfit} of the pairs that SLEPc gave are no modes: left out"
            ));
        }
        if missing > 0 {
            note(format!(
                "SLEPc had missed {missing} of the modes, which a count found missing: added"
            ));
        }
        let pairs = |mode: &Mode| mode.roots().div_ceil(2);
        let found = modes.iter().map(pairs).sum::<usize>();
        if found < count.min(system.len()) {
            note(format!(
                "SLEPc found {found} modes, and {count} were asked for"
            ));
        }
        Ok(modes)
    }

    fn print<'a>(
        &self,
        modes: &'a Found,
        selected: impl FnOnce(ModeReport<'a>) -> ModeReport<'a>,
        names: &'a [String],
    ) -> Result<(), Failure> {
        let report = selected(ModeReport::new(modes, names));
        self.form.print(
            |out| report.json(out),
            |out| report.csv(out),
            |out| out.write_all(report.text().as_bytes()),
        )?;
        self.question.report_doubts(modes);
        Ok(())
    }
}
