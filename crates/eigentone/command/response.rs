//! `eigentone response SCENE [--json] [--steps …] [--modes COUNT]`.

use clap::Args;
use eigentone::report::ResponseReport;
use eigentone::response::{ModalTruncation, ResponsePlan, SteadyState};
use eigentone::switching::Switching;

use super::form::Form;
use super::progress::Progress;
use super::{Failure, Question, index, memory, refuse_switches};

/// Prints the motion at every sample instant
#[derive(Debug, Args)]
pub struct Response {
    #[command(flatten)]
    question: Question,
    #[command(flatten)]
    form: Form,
    /// Print only these samples, in this order: whole numbers from 0 on, as 0,10,400
    #[arg(long, value_name = "INDICES", value_delimiter = ',', value_parser = index)]
    steps: Option<Vec<u64>>,
    /// Superpose only this many modes of the lowest frequencies, with the others as static deflections; needs no dense
    /// matrices
    #[arg(long, value_name = "COUNT", value_parser = super::count)]
    modes: Option<u32>,
}

impl Response {
    pub fn run(self) -> Result<(), Failure> {
        let scene = self.question.scene()?;
        let file = &self.question.scene;
        let switches = scene.switch_places();
        if self.modes.is_some() {
            refuse_switches(&self.question.scene, &scene, "--modes")?;
        }
        if self.modes.is_none() {
            self.question.admit_modes(&scene)?;
        }
        let instants = match &self.steps {
            Some(steps) => steps.len() as u64,
            None => memory::instants(&scene),
        };
        self.question
            .admit(memory::of_motion(&scene, instants), "instants")?;
        let no_time = || Failure::NoTime {
            scene: file.clone(),
        };
        if !switches.is_empty() {
            let mut problem = scene.problem().ok_or_else(no_time)?;
            if let Some(steps) = &self.steps {
                problem = problem.and_then(|problem| problem.at(steps));
            }
            let problem = problem.map_err(Failure::response(file))?;
            let problem = problem.to(self.question.precision());
            let motion = {
                let _progress = Progress::of("response");
                let switching = Switching::new(&problem, scene.switches());
                let motion = switching.and_then(|switching| switching.run());
                motion.map_err(Failure::switching(file, switches.clone()))?
            };
            let report = ResponseReport::new(motion.trajectory(), scene.system().names())
                .with_units(&problem)
                .with_events(motion.events(), &switches);
            return self.print(&report);
        }
        let solve = || {
            let mut problem = scene.problem().ok_or_else(no_time)?;
            if let Some(steps) = &self.steps {
                problem = problem.and_then(|problem| problem.at(steps));
            }
            let _progress = Progress::of("response");
            problem
                .map(|problem| problem.to(self.question.precision()))
                .and_then(|problem| {
                    if let Some(modes) = self.modes {
                        let modes = modes as usize;
                        let trajectory = ModalTruncation { modes }.run(&problem)?;
                        return Ok((problem, trajectory, None));
                    }
                    let trajectory = ResponsePlan::of(&problem)?.run(&problem)?;
                    let steady_state = SteadyState::of(&problem).ok();
                    Ok((problem, trajectory, steady_state))
                })
                .map_err(Failure::response(file))
        };
        let (problem, trajectory, steady_state) = solve()?;
        self.question.report_doubts_of_motion(&trajectory);
        let report = ResponseReport::new(&trajectory, scene.system().names())
            .with_units(&problem)
            .with_steady_state(steady_state.as_ref());
        self.print(&report)
    }

    fn print(&self, report: &ResponseReport<'_>) -> Result<(), Failure> {
        self.form.print(
            |out| report.json(out),
            |out| report.csv(out),
            |out| report.text(out),
        )
    }
}
