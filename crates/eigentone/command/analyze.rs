//! `eigentone analyze SCENE [--out DIR]`.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use eigentone::modes::{Modes, Participation, System};
use eigentone::report::{
    Analysis, Answer, DemandReport, EnergyReport, FrequencyReport, MOST_DEMANDS,
    MOST_PARTICIPATING, ModeReport, Page, ResponseReport, SwitchedReport, events_csv,
};
use eigentone::response::{
    Energy, Features, FrequencyFunctions, FrequencyValue, Problem, ResponseError, ResponsePlan,
    SteadyState, SteadyStateError, Summary, Trajectory, peak_grid,
};
use eigentone::scene::Scene;
use eigentone::switching::Switching;

use super::files::Files;
use super::progress::Progress;
use super::{Failure, Question, frf, memory, print, report_switches};

/// Prints structure, chosen methods, modes, response and error bounds
#[derive(Debug, Args)]
pub struct Analyze {
    #[command(flatten)]
    question: Question,
    /// Say why these methods ran and what was left out
    #[arg(long)]
    explain: bool,
    /// Write tables, data and plots into this directory, replacing files of the same names
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Analyze {
    pub fn run(self) -> Result<(), Failure> {
        let scene = self.question.scene()?;
        let file = &self.question.scene;
        let system = scene.system();
        self.question.admit_modes(&scene)?;
        let motion = memory::of_motion(&scene, memory::instants(&scene));
        self.question.admit(motion, "instants")?;
        let progress = Progress::of("structure");
        let structure = system.structure();
        progress.say("modes");
        let modes = system
            .modes_to(self.question.precision())
            .map_err(Failure::modes(file))?;
        let switches = scene.switch_places();
        let linear = scene.problem().filter(|_| switches.is_empty());
        let mut without_demands = None;
        let solved = match linear {
            None => None,
            Some(problem) => Some(
                problem
                    .map(|problem| problem.to(self.question.precision()))
                    .and_then(|problem| {
                        let demands = demands(system) as u64;
                        let work = demands * memory::instants(&scene);
                        let few = demands <= MOST_DEMANDS as u64 && work <= MOST_FOLLOWED;
                        if self.out.is_none() && !few {
                            return solve(problem, &modes, &progress);
                        }
                        let all = problem.clone().with_acceleration().with_forces();
                        // A force may leave the range of doubles where the motion does not.
                        solve(all, &modes, &progress).or_else(|error| {
                            let solved = solve(problem, &modes, &progress)?;
                            without_demands = Some(error.to_string());
                            Ok(solved)
                        })
                    })
                    .map_err(Failure::response(file))?,
            ),
        };
        let response = solved.as_ref().map(|solved| Answer {
            problem: &solved.problem,
            plan: &solved.plan,
            trajectory: &solved.trajectory,
            summary: &solved.summary,
            steady_state: &solved.steady_state,
        });
        let asked = match scene.problem() {
            Some(problem) if !switches.is_empty() => {
                let problem = problem.map_err(Failure::response(file))?;
                let problem = problem.to(self.question.precision());
                Some(problem.with_acceleration().with_forces())
            }
            _ => None,
        };
        let switched = match &asked {
            None => None,
            Some(problem) => {
                progress.say("response");
                let motion = Switching::new(problem, scene.switches());
                let motion =
                    motion.and_then(|switching| switching.with_losses().with_peaks().run());
                Some(motion.map_err(Failure::switching(file, switches.clone()))?)
            }
        };
        let name = self.question.name();
        let switched = asked.as_ref().zip(switched.as_ref());
        let switched = switched.map(|(problem, motion)| SwitchedReport {
            title: scene.title().unwrap_or(&name),
            problem,
            motion,
            switches: &switches,
        });
        let participation = match self.out {
            Some(_) => Participation::of_parts(system),
            None => Participation::of_parts_up_to(system, MOST_PARTICIPATING),
        };
        let analysis = Analysis {
            participation: &participation,
            title: scene.title().unwrap_or(&name),
            system,
            structure,
            modes: &modes,
            response,
            switched,
        };
        let mut without_energy = None;
        if let Some(directory) = &self.out {
            progress.say("report");
            let files = Files::into(directory)?.beside(file);
            without_energy = write(&analysis, &scene, files, &progress)?;
        }
        drop(progress);
        for (what, reason) in [
            ("accelerations and forces", without_demands),
            ("energies", without_energy),
        ] {
            if let Some(reason) = reason {
                let file = file.display();
                let _ = writeln!(io::stderr(), "note: {file}: {what} are left out: {reason}");
            }
        }
        report_switches(&self.question.scene, &scene);
        print(|out| {
            let text = match self.explain {
                true => analysis.explained(),
                false => analysis.text(),
            };
            out.write_all(text.as_bytes())
        })?;
        self.question.report_loss_factors(&scene);
        self.question.report_doubts(&modes);
        self.question.report_rounding(scene.system(), &modes);
        if let Some(answer) = &analysis.response {
            self.question.report_doubts_of_motion(answer.trajectory);
        }
        Ok(())
    }
}

/// Accelerations and forces times instants: beyond it the analysis would wait for them.
const MOST_FOLLOWED: u64 = 100_000;

/// How many accelerations and forces the system has.
fn demands(system: &System) -> usize {
    system.len() + system.springs().len() + system.dampers().len()
}

struct Solved<'a> {
    problem: Problem<'a>,
    plan: ResponsePlan,
    trajectory: Trajectory,
    summary: Summary,
    steady_state: Result<SteadyState, SteadyStateError>,
}

fn solve<'a>(
    problem: Problem<'a>,
    modes: &Modes,
    progress: &Progress,
) -> Result<Solved<'a>, ResponseError> {
    progress.say("response");
    let plan = ResponsePlan::of(&problem)?;
    let trajectory = plan.run(&problem)?;
    progress.say("peaks between the samples");
    let summary = Summary::of(&problem, &trajectory, modes).expect("a grid has an instant, 0");
    let steady_state = SteadyState::of(&problem);
    Ok(Solved {
        problem,
        plan,
        trajectory,
        summary,
        steady_state,
    })
}

/// From what the scene drives, else its supports, else each mass of few; `None` where it would take long, or nothing moves.
fn frequency_response(scene: &Scene, modes: &Modes) -> Option<(FrequencyFunctions, Vec<Features>)> {
    /// Functions times coordinates: beyond it the rest of the analysis waits.
    const MOST: usize = 200;
    let system = scene.system();
    let asked = frf::asked(scene, &[], &[]);
    let grid = match scene.frequencies() {
        Some(given) => given.to_vec(),
        None => peak_grid(system, modes, scene.loss_factors()),
    };
    let count = asked.at(&[]).ok()?.functions().len();
    if count * system.len() > MOST {
        return None;
    }
    let functions = asked.at(&grid).ok()?;
    // Supports may reach the masses through switches alone.
    let is_zero = |value: &FrequencyValue| value.known().is_some_and(|(h, _)| h.norm() == 0.0);
    let mut all = functions.functions().iter();
    if all.all(|function| function.values().iter().all(is_zero)) {
        return None;
    }
    let features = asked.features(&peak_grid(system, modes, scene.loss_factors()));
    Some((functions, features.ok()?))
}

fn write_demands(report: &DemandReport<'_>, title: &str, files: &mut Files) -> Result<(), Failure> {
    if report.has_accelerations() {
        files.write("accelerations.csv", |out| report.accelerations(out))?;
    }
    if report.has_forces() {
        files.write("forces.csv", |out| report.forces(out))?;
    }
    if report.has_outputs() {
        files.write("outputs.csv", |out| report.outputs(out))?;
    }
    files.write("peaks.csv", |out| report.peaks(out))?;
    let plots = [
        ("acceleration.svg", report.acceleration_plot(title)),
        ("forces.svg", report.force_plot(title)),
    ];
    for (name, plot) in plots {
        if let Some(plot) = plot {
            files.write(name, |out| out.write_all(plot.svg().as_bytes()))?;
        }
    }
    Ok(())
}

/// All files; the reason why energies are not among them.
fn write(
    analysis: &Analysis<'_>,
    scene: &Scene,
    mut files: Files,
    progress: &Progress,
) -> Result<Option<String>, Failure> {
    let system = scene.system();
    let modes = ModeReport::new(analysis.modes, system.names());
    let response = analysis.response.as_ref();
    let energy = response.map(|answer| Energy::along(answer.problem, answer.trajectory));
    let (energy, without) = match energy {
        Some(Ok(energy)) => (Some(energy), None),
        Some(Err(ResponseError::NotApplicable { reason, .. })) => (None, Some(reason)),
        Some(Err(error)) => (None, Some(error.to_string())),
        None => (None, None),
    };
    files.write("modes.json", |out| modes.json(out))?;
    files.write("modes.csv", |out| modes.csv(out))?;
    files.write("modes.md", |out| out.write_all(modes.markdown().as_bytes()))?;
    if let Some(answer) = &analysis.response {
        let response = ResponseReport::new(answer.trajectory, system.names())
            .with_units(answer.problem)
            .with_steady_state(answer.steady_state.as_ref().ok());
        files.write("response.json", |out| response.json(out))?;
        files.write("response.csv", |out| response.csv(out))?;
        let trajectory = answer.trajectory;
        let report = DemandReport::new(answer.problem, trajectory, answer.summary.extrema());
        write_demands(&report, analysis.title, &mut files)?;
        if let Some(energy) = &energy {
            let report = EnergyReport::new(energy, trajectory);
            files.write("energy.csv", |out| report.csv(out))?;
        }
    }
    if let Some(report) = &analysis.switched {
        let events = report.motion.events();
        let response = ResponseReport::new(report.motion.trajectory(), system.names())
            .with_units(report.problem)
            .with_events(events, report.switches);
        files.write("response.json", |out| response.json(out))?;
        files.write("response.csv", |out| response.csv(out))?;
        files.write("events.csv", |out| events_csv(events, report.switches, out))?;
        write_demands(&report.demands(), analysis.title, &mut files)?;
        for (name, plot) in report.plots() {
            files.write(&name, |out| out.write_all(plot.svg().as_bytes()))?;
        }
    }
    for (what, plot) in analysis.motion_plots() {
        let name = format!("{}.svg", what.replace(' ', "-"));
        files.write(&name, |out| out.write_all(plot.svg().as_bytes()))?;
    }
    for (number, plot) in (1..).zip(analysis.output_plots()) {
        files.write(&format!("output-{number}.svg"), |out| {
            out.write_all(plot.svg().as_bytes())
        })?;
    }
    progress.say("frequency response and its peaks");
    let frequency = frequency_response(scene, analysis.modes);
    progress.say("report");
    let frequency = frequency
        .as_ref()
        .map(|(functions, features)| FrequencyReport {
            title: analysis.title,
            system,
            outputs: scene.outputs(),
            functions,
            features: Some(features),
        });
    if let Some(report) = &frequency {
        files.write("frf.csv", |out| report.csv(out))?;
        for (name, plot) in report.plots() {
            files.write(name, |out| out.write_all(plot.svg().as_bytes()))?;
        }
    }
    let page = Page {
        analysis,
        energy: energy.as_ref(),
        frequency,
    };
    files.write("report.html", |out| out.write_all(page.html().as_bytes()))?;
    files.keep()?;
    Ok(without)
}
