//! `eigentone response SCENE [--json] [--steps …]`.

use clap::Args;
use eigentone::report::ResponseReport;
use eigentone::response::ResponsePlan;

use super::progress::Progress;
use super::{Failure, Question, print};

/// Prints the motion at every sample instant
#[derive(Debug, Args)]
pub struct Response {
    #[command(flatten)]
    question: Question,
    /// Print one JSON object with every digit
    #[arg(long)]
    json: bool,
    /// Print only these sample indices, in this order
    #[arg(long, value_name = "INDICES", value_delimiter = ',')]
    steps: Option<Vec<u64>>,
}

impl Response {
    pub fn run(self) -> Result<(), Failure> {
        let scene = self.question.scene()?;
        let file = &self.question.scene;
        let no_time = || Failure::NoTime {
            scene: file.clone(),
        };
        let solve = || {
            let mut problem = scene.problem().ok_or_else(no_time)?;
            if let Some(steps) = &self.steps {
                problem = problem.and_then(|problem| problem.at(steps));
            }
            let _progress = Progress::of("response");
            problem
                .map(|problem| problem.to(self.question.precision()))
                .and_then(|problem| ResponsePlan::of(&problem)?.run(&problem))
                .map_err(Failure::response(file))
        };
        let trajectory = solve()?;
        let report = ResponseReport::new(&trajectory, scene.system().names());
        print(|out| match self.json {
            true => report.json(out),
            false => report.text(out),
        })
    }
}
