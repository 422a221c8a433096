//! `eigentone cycle SCENE [--period S | --cycles N] [--json | --csv | --as-scene]`.

use std::path::PathBuf;

use clap::Args;
use eigentone::report::CycleReport;
use eigentone::switching::{CycleError, LimitCycle, Period, Switching};
use serde_json::{Value, json};

use super::form::Form;
use super::progress::Progress;
use super::{Failure, memory, positive, print, source};
use eigentone::scene::Scene;

/// Finds a periodic motion near where the scene's motion ends, and whether it is stable
#[derive(Debug, Args)]
pub struct Cycle {
    /// The scene file; - is standard input
    #[arg(value_parser = source::parser())]
    scene: PathBuf,
    #[command(flatten)]
    memory: memory::Limit,
    #[command(flatten)]
    form: Form,
    /// The period, in s [default: one cycle of the slowest harmonic load; without such a load it is found from the motion]
    #[arg(long, value_name = "SECONDS", value_parser = positive, conflicts_with = "cycles")]
    period: Option<f64>,
    /// The period, in cycles of the slowest harmonic load
    #[arg(long, value_name = "COUNT", value_parser = super::whole(1..=10_000))]
    cycles: Option<u32>,
    /// Print the scene, with the start and the time of one period, for `response` and `analyze`
    #[arg(long, conflicts_with_all = ["json", "csv"])]
    as_scene: bool,
}

impl Cycle {
    pub fn run(self) -> Result<(), Failure> {
        let file = &self.scene;
        let text = source::text(file)?;
        let scene = Scene::parse(&text, file)?;
        self.memory.admit_modes(file, &scene)?;
        let no_time = || Failure::NoTime {
            scene: file.clone(),
        };
        let problem = scene.problem().ok_or_else(no_time)?;
        let problem = problem.map_err(Failure::response(file))?;
        let mut harmonics = problem.timeline().harmonics().iter();
        // One of frequency 0 is constant.
        let has_cycles = harmonics.any(|(_, harmonic)| harmonic.frequency != 0.0);
        let period = match (self.period, self.cycles) {
            (Some(seconds), _) => Period::Seconds(seconds),
            (None, Some(count)) => Period::Cycles(count),
            (None, None) if has_cycles => Period::Cycles(1),
            (None, None) => Period::Free,
        };
        let switches = scene.switch_places();
        let failure = |error| match error {
            CycleError::Switching(error) => Failure::switching(file, switches.clone())(error),
            error => Failure::Cycle {
                scene: file.clone(),
                error,
                switches: switches.clone(),
            },
        };
        let cycle = {
            let _progress = Progress::of("periodic motion");
            let switching = Switching::new(&problem, scene.switches());
            let cycle = switching.map_err(CycleError::from);
            let cycle = cycle.and_then(|switching| switching.limit_cycle(period));
            cycle.map_err(failure)?
        };
        if self.as_scene {
            let scene = started(&text, scene.system().names(), &cycle);
            return print(|out| writeln!(out, "{scene:#}"));
        }
        let report = CycleReport {
            system: scene.system(),
            cycle: &cycle,
            switches: &switches,
        };
        self.form.print(
            |out| report.json(out),
            |out| report.csv(out),
            |out| out.write_all(report.text().as_bytes()),
        )
    }
}

/// The scene that starts on the cycle, in 256 steps of a period.
fn started(text: &str, names: &[String], cycle: &LimitCycle) -> Value {
    // It was read before.
    let mut scene: Value =
        serde_json::from_str(text.trim_start_matches('\u{feff}')).unwrap_or_default();
    let starts = names
        .iter()
        .zip(cycle.displacement.iter().zip(&cycle.velocity));
    let starts =
        starts.map(|(name, (x, v))| (name.clone(), json!({"displacement": x, "velocity": v})));
    scene["initial"] = Value::Object(starts.collect());
    scene["time"] = json!({"end": cycle.period, "step": cycle.period / 256.0});
    scene
}
