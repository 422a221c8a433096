//! `eigentone sweep SCENE --vary PATH=RANGE … [--metric M]… [--shard i/N] [--json]`.

use std::path::PathBuf;

use clap::Args;
use eigentone::design::{FollowError, Followed, Follower, Grid, Range};
use eigentone::modes::{Modes, System};
use eigentone::report::{SweepReport, SweptDesign};
use eigentone::scene::Scene;
use serde_json::Value;

use super::files::Files;
use super::progress::Progress;
use super::study::{METRICS, Metric, Varied, object};
use super::{Accuracy, Failure, print, source, tell_switches, tolerance};

/// Varies numbers of the scene: eigenvalues and metrics of each design
#[derive(Debug, Args)]
pub struct Sweep {
    /// The scene file; - is standard input
    #[arg(value_parser = source::parser())]
    scene: PathBuf,
    /// What varies: NAME.key or a JSON Pointer, and FROM:TO:COUNT, FROM:TO:COUNT:log or values with commas between
    #[arg(long, required = true, value_name = "PATH=RANGE", value_parser = varied)]
    vary: Vec<(String, Range)>,
    #[arg(long, value_name = "METRIC", help = METRICS)]
    metric: Vec<Metric>,
    /// Only part i of N, from 1
    #[arg(long, value_name = "i/N", value_parser = shard)]
    shard: Option<(u64, u64)>,
    /// Print one JSON object for each design with every digit
    #[arg(long)]
    json: bool,
    /// Write all designs into this directory, as CSV, with plots of the metrics and of the roots
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Plain doubles, or more digits where bounds demand it
    #[arg(long, value_enum, default_value_t = super::Precision::Double)]
    precision: super::Precision,
    /// Largest relative error wanted, at least 2^-53 [default: the last digits]
    #[arg(long, value_name = "REL", value_parser = tolerance)]
    tolerance: Option<f64>,
}

/// The designs, and what is asked of them.
struct Study<'a> {
    sweep: &'a Sweep,
    varied: Varied,
    grid: Grid,
}

/// What a step to a design has found.
struct Reached {
    scene: Scene,
    modes: Modes,
    followed: Followed,
}

impl Sweep {
    pub fn run(self) -> Result<(), Failure> {
        let accuracy = Accuracy {
            precision: self.precision,
            tolerance: self.tolerance,
        };
        let names = self.vary.iter().map(|(path, _)| path.as_str());
        let (scene, varied) = Varied::read(&self.scene, accuracy.precision()?, names)?;
        let refuse = |message: String| varied.refuse(message);
        let ranges = self.vary.iter().map(|(_, range)| range.clone());
        let grid = Grid::new(ranges.collect()).map_err(|error| refuse(error.to_string()))?;
        let (part, parts) = self.shard.unwrap_or((1, 1));
        let designs = grid.part(part, parts);
        let designs = designs.map_err(|error| refuse(format!("--shard: {error}")))?;
        tell_switches(&self.scene, &scene);
        let study = Study {
            sweep: &self,
            varied,
            grid,
        };
        let name = self.scene.file_stem().unwrap_or(self.scene.as_os_str());
        let name = name.to_string_lossy();
        study.run(designs, scene.title().unwrap_or(&name))
    }
}

impl Study<'_> {
    fn run(&self, designs: std::ops::Range<u64>, title: &str) -> Result<(), Failure> {
        let mut trail: Vec<(u64, Follower)> = Vec::new();
        let mut all: Vec<SweptDesign> = Vec::new();
        let (start, count) = (designs.start, designs.end - designs.start);
        let progress = Progress::of("designs");
        for index in designs {
            let design = self.design(index, &mut trail)?;
            let line = self.line(&design, index == start);
            print(|out| out.write_all(line.as_bytes()))?;
            progress.say(&format!("design {} of {count}", index - start + 1));
            if self.sweep.out.is_some() {
                all.push(design);
            }
        }
        drop(progress);
        let Some(directory) = &self.sweep.out else {
            return Ok(());
        };
        let parameters: Vec<&str> = self.varied.names().collect();
        let metrics = self.sweep.metric.iter().map(|metric| metric.text.as_str());
        let metrics: Vec<&str> = metrics.collect();
        let report = SweepReport {
            title,
            parameters: &parameters,
            metrics: &metrics,
            designs: &all,
        };
        let mut files = Files::into(directory)?.beside(&self.sweep.scene);
        files.write("sweep.csv", |out| report.csv(out))?;
        for (name, plot) in report.plots() {
            files.write(&name, |out| out.write_all(plot.svg().as_bytes()))?;
        }
        files.keep()
    }

    /// A design, followed from those before it.
    fn design(&self, index: u64, trail: &mut Vec<(u64, Follower)>) -> Result<SweptDesign, Failure> {
        let values = self.grid.design(index).unwrap_or_default();
        let named = |message: String| self.failure(&values, index, &message);
        let reached = self.follow(index, trail)?;
        let roots = match trail.last() {
            Some((_, follower)) => follower.roots(),
            None => &[],
        };
        let mut metrics = Vec::new();
        for metric in &self.sweep.metric {
            let (scene, modes) = (&reached.scene, &reached.modes);
            let told = self.varied.measure(&metric.kind, scene, modes);
            let told = told.map_err(|why| named(format!("{}: {why}", metric.text)))?;
            metrics.push(told.filter(|value| value.is_finite()));
        }
        Ok(SweptDesign {
            index,
            roots: roots.iter().map(|root| [root.re, root.im]).collect(),
            metrics,
            is_doubtful: reached.followed == Followed::Doubtful,
            values,
        })
    }

    /// What is printed of a design, a header before the first of a table.
    fn line(&self, design: &SweptDesign, is_first: bool) -> String {
        let (index, roots) = (design.index, &design.roots);
        let values = design.values.iter().map(|value| Some(*value));
        let parameters = self.varied.names().zip(values);
        let texts = self.sweep.metric.iter().map(|metric| metric.text.as_str());
        let metrics = texts.zip(design.metrics.iter().copied());
        let is_doubtful = design.is_doubtful;
        if self.sweep.json {
            let roots = roots.iter().map(|root| Value::from(root.to_vec()));
            let roots = Value::from(roots.collect::<Vec<_>>());
            let doubtful = if is_doubtful {
                ", \"doubtful\": true"
            } else {
                ""
            };
            return format!(
                "{{\"index\": {index}, \"parameters\": {}, \"eigenvalues\": {roots}{doubtful}, \"metrics\": {}}}\n",
                object(parameters),
                object(metrics)
            );
        }
        let roots = roots.iter().enumerate().flat_map(|(i, root)| {
            let header = |part: &str| format!("{part} {}", i + 1);
            [(header("re"), Some(root[0])), (header("im"), Some(root[1]))]
        });
        let owned = |(name, value): (&str, Option<f64>)| (name.to_owned(), value);
        let cells = parameters.map(owned).chain(metrics.map(owned)).chain(roots);
        let (mut head, mut line) = (format!("{:>8}", "design"), format!("{index:>8}"));
        for (name, value) in cells {
            let width = name.chars().count().max(12);
            let value = value.map_or("–".to_owned(), |value| format!("{value:.5e}"));
            head += &format!("  {name:>width$}");
            line += &format!("  {value:>width$}");
        }
        if is_doubtful {
            line += "  places doubtful";
        }
        match is_first {
            true => format!("{head}\n{line}\n"),
            false => format!("{line}\n"),
        }
    }

    /// Puts the roots of a design at the end of the trail, which keeps those that others are followed from.
    fn follow(&self, index: u64, trail: &mut Vec<(u64, Follower)>) -> Result<Reached, Failure> {
        let values = self.grid.design(index).unwrap_or_default();
        let named = |message: String| self.failure(&values, index, &message);
        let Some(before) = self.grid.before(index) else {
            let (scene, modes) = self.varied.solve(&values).map_err(named)?;
            let follower = Follower::at(scene.system(), &modes);
            trail.push((index, follower.map_err(|error| named(error.to_string()))?));
            let followed = Followed::Surely;
            return Ok(Reached {
                scene,
                modes,
                followed,
            });
        };
        while trail.last().is_some_and(|(known, _)| *known > before) {
            trail.pop();
        }
        if trail.last().is_none_or(|(known, _)| *known < before) {
            self.follow(before, trail)?;
        }
        let mut follower = match trail.last() {
            Some((_, follower)) => follower.clone(),
            None => return Err(named("there is nothing to follow from".to_owned())), // the call above has put it there
        };
        let start = self.grid.design(before).unwrap_or_default();
        let (mut why, mut goal) = (None, None);
        let followed = follower.advance(|t| {
            let at = |(from, to): (&f64, &f64)| {
                if t == 1.0 {
                    *to
                } else {
                    from + t * (to - from)
                }
            };
            let between: Vec<f64> = start.iter().zip(&values).map(at).collect();
            match self.varied.solve(&between) {
                Ok((scene, modes)) => {
                    let answer = (System::clone(scene.system()), modes.clone());
                    if t == 1.0 {
                        goal = Some((scene, modes));
                    }
                    Some(answer)
                }
                Err(message) => {
                    why.get_or_insert(message);
                    None
                }
            }
        });
        let (followed, (scene, modes)) = match (followed, goal, why) {
            (Ok(followed), Some(goal), _) => (followed, goal),
            (Err(FollowError::NoDesign), _, Some(why)) => return Err(named(why)),
            (Err(error), ..) => return Err(named(error.to_string())),
            (Ok(_), None, _) => return Err(named(FollowError::NoDesign.to_string())),
        };
        // Along one range nothing more is followed from the design before.
        let step = self.grid.before(before).map(|earlier| before - earlier);
        if step == Some(index - before) {
            trail.pop();
        }
        trail.push((index, follower));
        Ok(Reached {
            scene,
            modes,
            followed,
        })
    }

    fn failure(&self, values: &[f64], index: u64, message: &str) -> Failure {
        let design = self.varied.told(values);
        let message = format!("design {index} ({design}): {message}");
        self.varied.refuse(message)
    }
}

fn varied(text: &str) -> Result<(String, Range), String> {
    let (path, range) = text
        .rsplit_once('=')
        .ok_or("write PATH=RANGE, as absorber.stiffness=1:10:50")?;
    let range = range.parse::<Range>().map_err(|error| error.to_string())?;
    Ok((path.to_owned(), range))
}

fn shard(text: &str) -> Result<(u64, u64), String> {
    let parts = text
        .split_once('/')
        .and_then(|(part, parts)| Some((part.parse().ok()?, parts.parse().ok()?)));
    let parts = parts.filter(|(part, parts)| (1..=*parts).contains(part));
    parts.ok_or_else(|| "write i/N with i from 1 to N, as 2/5".to_owned())
}
