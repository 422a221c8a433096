//! `eigentone modes SCENE [--json] [--lowest COUNT | --near FREQUENCY [--count COUNT]]`.

use clap::Args;
use eigentone::modes::Modes as Found;
use eigentone::report::ModeReport;

use super::form::Form;
use super::progress::Progress;
use super::selection::Selection;
use super::{Failure, Question, tell_switches};

/// Prints the mode table
#[derive(Debug, Args)]
pub struct Modes {
    #[command(flatten)]
    question: Question,
    #[command(flatten)]
    selection: Selection,
    #[command(flatten)]
    form: Form,
}

impl Modes {
    pub fn run(self) -> Result<(), Failure> {
        let scene = self.question.scene()?;
        tell_switches(&self.question.scene, &scene);
        let progress = Progress::of("modes");
        let file = &self.question.scene;
        let names = scene.system().names();
        self.question.tell_loss_factors(&scene);
        let precision = self.question.precision();
        if self.selection.takes_all(scene.system()) {
            self.question.admit_modes(&scene)?;
        }
        let all = || scene.system().modes_to(precision);
        if let Some(modes) = self.selection.among_all(scene.system(), all) {
            drop(progress);
            let modes = modes.map_err(Failure::modes(file))?;
            self.question.tell_estimates(&modes);
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
        self.question.tell_estimates(&modes);
        self.print(&modes, |report| report, names)
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
        self.question.tell_doubts(modes);
        Ok(())
    }
}
