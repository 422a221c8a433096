//! `eigentone sweep SCENE --vary PATH=RANGE … [--metric M]… [--shard i/N] [--json]`.

use std::fs;
use std::path::PathBuf;
use std::slice::from_ref;
use std::str::FromStr;

use clap::Args;
use eigentone::design::{FollowError, Follower, Grid, Range};
use eigentone::modes::{Modes, Precision, System};
use eigentone::response::{LargestGain, peak_grid};
use eigentone::scene::Scene;
use serde_json::Value;

use super::frf::asked;
use super::{Accuracy, Failure, print, tell_switches, tolerance};

/// Varies numbers of the scene: eigenvalues and metrics of each design
#[derive(Debug, Args)]
pub struct Sweep {
    /// The scene file
    scene: PathBuf,
    /// What varies: NAME.key or a JSON Pointer, and FROM:TO:COUNT, FROM:TO:COUNT:log or values with commas between
    #[arg(long, required = true, value_name = "PATH=RANGE", value_parser = varied)]
    vary: Vec<(String, Range)>,
    /// "damping", "frequency K", "gain FROM TO" or "rms NAME"
    #[arg(long, value_name = "METRIC")]
    metric: Vec<Metric>,
    /// Only part i of N, from 1
    #[arg(long, value_name = "i/N", value_parser = shard)]
    shard: Option<(u64, u64)>,
    /// Print one JSON object for each design with every digit
    #[arg(long)]
    json: bool,
    /// Plain doubles, or more digits where bounds demand it
    #[arg(long, value_enum, default_value_t = super::Precision::Double)]
    precision: super::Precision,
    /// Largest relative error wanted, at least 2^-53 [default: the last digits]
    #[arg(long, value_name = "REL", value_parser = tolerance)]
    tolerance: Option<f64>,
}

/// What is told of a design.
#[derive(Clone, Debug)]
struct Metric {
    text: String,
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    Damping,
    Frequency(usize),
    Gain(String, String),
    Rms(String),
}

impl FromStr for Metric {
    type Err = String;

    fn from_str(text: &str) -> Result<Metric, String> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let kind = match words[..] {
            ["damping"] => Kind::Damping,
            ["frequency", k] => match k.parse() {
                Ok(k) if k >= 1 => Kind::Frequency(k),
                _ => return Err("the modes of \"frequency K\" count from 1".to_owned()),
            },
            ["gain", from, to] => Kind::Gain(from.to_owned(), to.to_owned()),
            ["rms", name] => Kind::Rms(name.to_owned()),
            ["peak" | "settling", ..] => {
                return Err("a sweep has no metrics of motions in time yet: take \"damping\", \"frequency K\", \"gain FROM TO\" or \"rms NAME\"".to_owned());
            }
            _ => {
                return Err(
                    "metrics are \"damping\", \"frequency K\", \"gain FROM TO\" and \"rms NAME\""
                        .to_owned(),
                );
            }
        };
        let text = words.join(" ");
        Ok(Metric { text, kind })
    }
}

/// The scene with its varied numbers.
struct Study<'a> {
    sweep: &'a Sweep,
    precision: Precision,
    grid: Grid,
    value: Value,
    /// A JSON Pointer for each range.
    pointers: Vec<String>,
}

impl Sweep {
    pub fn run(self) -> Result<(), Failure> {
        let accuracy = Accuracy {
            precision: self.precision,
            tolerance: self.tolerance,
        };
        let precision = accuracy.precision()?;
        let scene = Scene::read(&self.scene)?;
        let refuse = |message: String| Failure::Sweep {
            scene: self.scene.clone(),
            message,
        };
        let text = fs::read_to_string(&self.scene).map_err(|error| refuse(error.to_string()))?;
        let value: Value = serde_json::from_str(text.trim_start_matches('\u{feff}'))
            .map_err(|error| refuse(error.to_string()))?;
        let mut pointers: Vec<String> = Vec::new();
        for (path, _) in &self.vary {
            let pointer = pointer(&value, path).map_err(refuse)?;
            if pointers.contains(&pointer) {
                return Err(refuse(format!("--vary {path}: this number varies already")));
            }
            pointers.push(pointer);
        }
        let ranges = self.vary.iter().map(|(_, range)| range.clone());
        let grid = Grid::new(ranges.collect()).map_err(|error| refuse(error.to_string()))?;
        let (part, parts) = self.shard.unwrap_or((1, 1));
        let designs = grid.part(part, parts);
        let designs = designs.map_err(|error| refuse(format!("--shard: {error}")))?;
        tell_switches(&self.scene, &scene);
        let study = Study {
            sweep: &self,
            precision,
            grid,
            value,
            pointers,
        };
        study.run(designs)
    }
}

impl Study<'_> {
    fn run(&self, designs: std::ops::Range<u64>) -> Result<(), Failure> {
        let mut trail: Vec<(u64, Follower)> = Vec::new();
        for index in designs.clone() {
            let line = self.line(index, index == designs.start, &mut trail)?;
            print(|out| out.write_all(line.as_bytes()))?;
        }
        Ok(())
    }

    /// What is printed of a design, a header before the first of a table.
    fn line(
        &self,
        index: u64,
        is_first: bool,
        trail: &mut Vec<(u64, Follower)>,
    ) -> Result<String, Failure> {
        let values = self.grid.design(index).unwrap_or_default();
        let named = |message: String| self.failure(&values, index, &message);
        self.follow(index, trail)?;
        let roots = match trail.last() {
            Some((_, follower)) => follower.roots(),
            None => &[],
        };
        let mut metrics = Vec::new();
        if !self.sweep.metric.is_empty() {
            let (scene, modes) = self.solve(&values).map_err(named)?;
            for metric in &self.sweep.metric {
                let told = self.measure(&metric.kind, &scene, &modes);
                let told = told.map_err(|why| named(format!("{}: {why}", metric.text)))?;
                metrics.push(told.filter(|value| value.is_finite()));
            }
        }
        let names = self.sweep.vary.iter().map(|(path, _)| path.as_str());
        let parameters = names.zip(values.iter().map(|value| Some(*value)));
        let texts = self.sweep.metric.iter().map(|metric| metric.text.as_str());
        let metrics = texts.zip(metrics);
        if self.sweep.json {
            let roots: Vec<[f64; 2]> = roots.iter().map(|root| [root.re, root.im]).collect();
            let roots = Value::from(
                roots
                    .iter()
                    .map(|root| Value::from(root.to_vec()))
                    .collect::<Vec<_>>(),
            );
            return Ok(format!(
                "{{\"index\": {index}, \"parameters\": {}, \"eigenvalues\": {roots}, \"metrics\": {}}}\n",
                object(parameters),
                object(metrics)
            ));
        }
        let roots = roots.iter().enumerate().flat_map(|(i, root)| {
            let header = |part: &str| format!("{part} {}", i + 1);
            [(header("re"), Some(root.re)), (header("im"), Some(root.im))]
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
        Ok(match is_first {
            true => format!("{head}\n{line}\n"),
            false => format!("{line}\n"),
        })
    }

    /// Puts the roots of a design at the end of the trail, which keeps those that others are followed from.
    fn follow(&self, index: u64, trail: &mut Vec<(u64, Follower)>) -> Result<(), Failure> {
        let values = self.grid.design(index).unwrap_or_default();
        let named = |message: String| self.failure(&values, index, &message);
        let Some(before) = self.grid.before(index) else {
            let (scene, modes) = self.solve(&values).map_err(named)?;
            let follower = Follower::at(scene.system(), &modes);
            trail.push((index, follower.map_err(|error| named(error.to_string()))?));
            return Ok(());
        };
        while trail.last().is_some_and(|(known, _)| *known > before) {
            trail.pop();
        }
        if trail.last().is_none_or(|(known, _)| *known < before) {
            self.follow(before, trail)?;
        }
        let Some((_, follower)) = trail.last() else {
            return Ok(()); // the call above has put it there
        };
        let mut follower = follower.clone();
        let start = self.grid.design(before).unwrap_or_default();
        let mut why = None;
        let followed = follower.advance(|t| {
            let at = |(from, to): (&f64, &f64)| {
                if t == 1.0 {
                    *to
                } else {
                    from + t * (to - from)
                }
            };
            let between: Vec<f64> = start.iter().zip(&values).map(at).collect();
            let solved: Result<(Scene, Modes), String> = self.solve(&between);
            match solved {
                Ok((scene, modes)) => Some((System::clone(scene.system()), modes)),
                Err(message) => {
                    why.get_or_insert(message);
                    None
                }
            }
        });
        if let Err(error) = followed {
            let message = match (error, why) {
                (FollowError::NoDesign, Some(why)) => why,
                (error, _) => error.to_string(),
            };
            return Err(named(message));
        }
        // Along one range nothing more is followed from the design before.
        let step = self.grid.before(before).map(|earlier| before - earlier);
        if step == Some(index - before) {
            trail.pop();
        }
        trail.push((index, follower));
        Ok(())
    }

    fn solve(&self, values: &[f64]) -> Result<(Scene, Modes), String> {
        let mut value = self.value.clone();
        for (pointer, number) in self.pointers.iter().zip(values) {
            if let Some(place) = value.pointer_mut(pointer) {
                *place = Value::from(*number);
            }
        }
        let file = &self.sweep.scene;
        let scene = Scene::parse(&value.to_string(), file).map_err(|error| {
            let message = error.to_string();
            // Lines and columns are not those of the file.
            let place = format!("{}:", file.display());
            let rest = message
                .strip_prefix(&place)
                .and_then(|rest| rest.split_once(": "));
            rest.map_or(message.clone(), |(_, rest)| rest.to_owned())
        })?;
        let modes = scene.system().modes_to(self.precision);
        let modes = modes.map_err(|error| error.to_string())?;
        Ok((scene, modes))
    }

    /// A metric, or `None` where it is infinite or not known.
    fn measure(&self, kind: &Kind, scene: &Scene, modes: &Modes) -> Result<Option<f64>, String> {
        match kind {
            Kind::Damping => {
                if modes.eigenvalues().iter().any(|root| root.is_doubtful()) {
                    return Ok(None);
                }
                let roots = modes.into_iter().map(|mode| mode.eigenvalue().value);
                let ratios = roots
                    .filter(|root| root.norm() > 0.0)
                    .map(|root| -root.re / root.norm());
                Ok(ratios.reduce(f64::min))
            }
            Kind::Frequency(k) => match modes.into_iter().nth(k - 1) {
                Some(mode) => Ok(Some(mode.natural_frequency().radians_per_second())),
                None => Err(format!(
                    "there are only {} modes",
                    modes.into_iter().count()
                )),
            },
            Kind::Gain(from, to) => {
                let grid = peak_grid(scene.system(), modes, scene.loss_factors());
                let asked = asked(scene, from_ref(from), from_ref(to)).precision(self.precision);
                let features = asked.features(&grid).map_err(|error| error.to_string())?;
                let gain = features
                    .first()
                    .and_then(|features| features.largest_gain());
                Ok(match gain {
                    Some(LargestGain::Unbounded { .. }) | None => None,
                    Some(LargestGain::Finite { gain, .. }) => Some(gain),
                })
            }
            Kind::Rms(name) => {
                if scene.loss_factors().iter().any(|factor| *factor != 0.0) {
                    return Err("a spring with a `loss_factor` has no force in time".to_owned());
                }
                let noise = scene.noise().ok_or("the scene has no `noise`")?;
                let motion = noise.solve().map_err(|error| error.to_string())?;
                let mut all = motion.outputs().iter().chain(motion.displacement());
                let found = all.find(|of| of.name == *name);
                let found =
                    found.ok_or_else(|| format!("there is no output, mass or point {name:?}"))?;
                Ok(found.rms.finite().map(|(value, _)| value))
            }
        }
    }

    fn failure(&self, values: &[f64], index: u64, message: &str) -> Failure {
        let paths = self.sweep.vary.iter().map(|(path, _)| path);
        let design = paths
            .zip(values)
            .map(|(path, value)| format!("{path} = {value:?}"));
        let design: Vec<String> = design.collect();
        Failure::Sweep {
            scene: self.sweep.scene.clone(),
            message: format!("design {index} ({}): {message}", design.join(", ")),
        }
    }
}

/// A JSON object in the order given.
fn object<'a>(entries: impl Iterator<Item = (&'a str, Option<f64>)>) -> String {
    let entries =
        entries.map(|(name, value)| format!("{}: {}", Value::from(name), Value::from(value)));
    format!("{{{}}}", entries.collect::<Vec<_>>().join(", "))
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

/// The place of a number of the scene as a JSON Pointer.
fn pointer(scene: &Value, path: &str) -> Result<String, String> {
    let is_number = |pointer: &str| scene.pointer(pointer).is_some_and(Value::is_number);
    if path.starts_with('/') {
        return match is_number(path) {
            true => Ok(path.to_owned()),
            false => Err(format!("--vary {path}: no number of the scene is there")),
        };
    }
    let mut known = Vec::new();
    let lists = scene.as_object().into_iter().flatten();
    for (list, items) in lists {
        for (i, item) in items.as_array().into_iter().flatten().enumerate() {
            let Some(name) = item.get("name").and_then(Value::as_str) else {
                continue;
            };
            let numbers = item.as_object().into_iter().flatten();
            for (key, _) in numbers.filter(|(_, value)| value.is_number()) {
                known.push((format!("{name}.{key}"), format!("/{list}/{i}/{key}")));
            }
        }
    }
    if let Some((_, pointer)) = known.iter().find(|(name, _)| name == path) {
        return Ok(pointer.clone());
    }
    let distance = |name: &str| strsim::osa_distance(name, path);
    let nearest = known.iter().min_by_key(|(name, _)| distance(name));
    let hint = match nearest {
        Some((name, _)) if 3 * distance(name) <= path.len() => format!("did you mean {name:?}?"),
        _ => "write NAME.key of an element with that number, or a JSON Pointer, as /springs/0/stiffness".to_owned(),
    };
    Err(format!(
        "--vary {path}: no number of the scene has this name: {hint}"
    ))
}
