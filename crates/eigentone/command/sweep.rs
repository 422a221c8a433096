//! `eigentone sweep SCENE --vary PATH=RANGE … [--metric M]… [--shard i/N] [--json] [--out DIR [--resume]]`.

use std::fmt::Write as _;
use std::io::{self, BufWriter, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use eigentone::design::{Grid, Range};
use eigentone::report::{SweepTable, SweptDesign, significant};
use serde_json::{Value, json};

use super::designs::Designs;
use super::parts::{Growing, Part};
use super::progress::Progress;
use super::study::{METRICS, Metric, Varied, object};
use super::{Accuracy, Failure, UNPROVEN, report_switches, source, tolerance};

/// What varies, and its values.
#[derive(Clone, Debug)]
struct Vary {
    path: String,
    /// The range as it was given.
    text: String,
    range: Range,
}

/// How often what is done is shown and kept.
const SAID: Duration = Duration::from_millis(200);

/// Varies numbers of the scene: eigenvalues and metrics of each design
#[derive(Debug, Args)]
pub struct Sweep {
    /// The scene file; - is standard input
    #[arg(value_parser = source::parser())]
    scene: PathBuf,
    /// What varies: NAME.key or a JSON Pointer, and FROM:TO:COUNT, FROM:TO:COUNT:log or values with commas between
    #[arg(long, required = true, value_name = "PATH=RANGE", value_parser = varied)]
    vary: Vec<Vary>,
    #[arg(long, value_name = "METRIC", help = METRICS)]
    metric: Vec<Metric>,
    /// Compute only part i of N; the first is 1
    #[arg(long, value_name = "i/N", value_parser = shard)]
    shard: Option<(u64, u64)>,
    /// Print one JSON object for each design with every digit
    #[arg(long)]
    json: bool,
    /// Write all designs into this directory, as CSV while they come, and then plots and a page; parts are for `merge`
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Continue the table in --out that an earlier run of the same sweep began
    #[arg(long, requires = "out")]
    resume: bool,
    /// Double precision alone, or more digits where proven bounds need them
    #[arg(long, value_enum, default_value_t = super::Precision::Double)]
    precision: super::Precision,
    /// Largest relative error wanted, at least 2^-53 [default: the last digits]
    #[arg(long, value_name = "REL", value_parser = tolerance)]
    tolerance: Option<f64>,
}

impl Sweep {
    pub fn run(mut self) -> Result<(), Failure> {
        let accuracy = Accuracy {
            precision: self.precision,
            tolerance: self.tolerance,
        };
        let names = self.vary.iter().map(|one| one.path.as_str());
        let (scene, varied) = Varied::read(&self.scene, accuracy.precision()?, names)?;
        let refuse = |message: String| varied.refuse(message);
        let metrics = std::mem::take(&mut self.metric).into_iter();
        let metrics = metrics.map(|metric| metric.of(&scene).map_err(refuse));
        self.metric = metrics.collect::<Result<_, _>>()?;
        let ranges = self.vary.iter().map(|one| one.range.clone());
        let grid = Grid::new(ranges.collect()).map_err(|error| refuse(error.to_string()))?;
        let (part, parts) = self.shard.unwrap_or((1, 1));
        let mut range = grid.part(part, parts);
        let range = range
            .as_mut()
            .map_err(|error| refuse(format!("--shard: {error}")))?;
        report_switches(&self.scene, &scene);
        let mut table = None;
        if let Some(directory) = &self.out {
            let name = self.scene.file_stem().unwrap_or(self.scene.as_os_str());
            let name = name.to_string_lossy();
            let metrics = self.metric.iter().map(|metric| metric.kind.unit(&scene));
            let units: Vec<String> = varied.units(&scene).chain(metrics).collect();
            let question = json!({
                "eigentone": env!("CARGO_PKG_VERSION"),
                "title": scene.title().unwrap_or(&name),
                "part": [part, parts],
                "designs": grid.count(),
                "vary": self.vary.iter().map(|one| [&one.path, &one.text]).collect::<Vec<_>>(),
                "metrics": self.metric.iter().map(|metric| &metric.text).collect::<Vec<_>>(),
                "units": units,
                "precision": format!("{:?}", self.precision),
                "tolerance": self.tolerance,
                "scene": varied.scene(),
            });
            let columns = SweepTable {
                parameters: varied.names().map(str::to_owned).collect(),
                metrics: self
                    .metric
                    .iter()
                    .map(|metric| metric.text.clone())
                    .collect(),
                units,
            };
            let files = Part::new(directory, question, grid.clone(), columns.clone());
            let Some((growing, done)) = files.open(&self.scene, self.resume)? else {
                let place = directory.display();
                let _ = writeln!(
                    io::stderr(),
                    "note: {place}: this sweep is complete already"
                );
                return Ok(());
            };
            range.start += done;
            table = Some((files, columns, growing));
        }
        let designs = Designs {
            varied: &varied,
            grid: &grid,
            metrics: &self.metric,
        };
        let result = self.report(&designs, range.clone(), &mut table);
        let Some((files, _, growing)) = table else {
            return result;
        };
        match &result {
            Ok(()) => files.close(growing),
            // There is no going on.
            Err(Failure::Study { .. }) => {
                files.remove(growing);
                result
            }
            Err(_) => result,
        }
    }

    /// Prints each design, and adds it to the table.
    fn report(
        &self,
        designs: &Designs<'_>,
        range: std::ops::Range<u64>,
        table: &mut Option<(Part, SweepTable, Growing)>,
    ) -> Result<(), Failure> {
        let (start, count) = (range.start, range.end - range.start);
        let progress = Progress::of("designs");
        let mut out = BufWriter::with_capacity(1 << 16, io::stdout());
        let mut said = Instant::now();
        let mut open = true;
        let mut headers = Vec::new();
        let mut missing = vec![0u64; self.metric.len()];
        let mut doubtful = 0u64;
        designs.each(range, |design| {
            for (missing, value) in missing.iter_mut().zip(&design.metrics) {
                *missing += u64::from(value.is_none());
            }
            doubtful += u64::from(!design.doubtful_roots.is_empty());
            if open {
                let mut text = String::new();
                if !self.json && headers.is_empty() {
                    headers = self.headers(designs.varied, &design);
                    text = format!("{:>8}  {}\n", "design", headers.join("  "));
                }
                text += &match self.json {
                    true => self.object(designs.varied, &design),
                    false => line(&headers, &design),
                };
                open = written(out.write_all(text.as_bytes()))?;
            }
            if let Some((_, columns, growing)) = table {
                growing.add(columns, &design)?;
            }
            if said.elapsed() > SAID {
                said = Instant::now();
                open = open && written(out.flush())?;
                if let Some((_, _, growing)) = table {
                    growing.flush()?;
                }
                progress.say(&format!("design {} of {count}", design.index - start + 1));
            }
            // Without a reader and a table nobody waits for more.
            Ok(open || table.is_some())
        })?;
        let flushed = written(out.flush()).map(drop);
        for (metric, missing) in self.metric.iter().zip(missing).filter(|(_, k)| *k > 0) {
            let _ = writeln!(
                io::stderr(),
                "note: {}: {}: no value in {missing} of {count} designs, where {}",
                self.scene.display(),
                metric.text,
                metric.kind.is_missing()
            );
        }
        if doubtful > 0 {
            let scene = self.scene.display();
            let help = match self.precision {
                super::Precision::Double => "take --precision certified",
                super::Precision::Certified => UNPROVEN,
            };
            let _ = writeln!(
                io::stderr(),
                "note: {scene}: roots of {doubtful} of {count} designs are doubtful: no bound is known for them, and they may be \
                 far from any root; {help}"
            );
        }
        flushed
    }

    /// What is printed of a design as JSON.
    fn object(&self, varied: &Varied, design: &SweptDesign) -> String {
        let values = design.values.iter().map(|value| Some(*value));
        let texts = self.metric.iter().map(|metric| metric.text.as_str());
        let roots = design.roots.iter().map(|root| Value::from(root.to_vec()));
        format!(
            "{{\"index\": {}, \"parameters\": {}, \"eigenvalues\": {}{}{}, \"metrics\": {}}}\n",
            design.index,
            object(varied.names().zip(values)),
            Value::from(roots.collect::<Vec<_>>()),
            if design.has_doubtful_places {
                ", \"doubtful\": true"
            } else {
                ""
            },
            match design.numbers_of_doubtful_roots(", ") {
                none if none.is_empty() => none,
                numbers => format!(", \"doubtful_roots\": [{numbers}]"),
            },
            object(texts.zip(design.metrics.iter().copied()))
        )
    }

    /// The headers of a table of designs.
    fn headers(&self, varied: &Varied, design: &SweptDesign) -> Vec<String> {
        let metrics = self.metric.iter().map(|metric| metric.text.clone());
        let roots = (1..=design.roots.len()).flat_map(|k| [format!("re {k}"), format!("im {k}")]);
        let names = varied.names().map(str::to_owned).chain(metrics);
        names
            .chain(roots)
            .map(|name| format!("{name:>12}"))
            .collect()
    }
}

/// A line of a table under these headers.
fn line(headers: &[String], design: &SweptDesign) -> String {
    let values = design.values.iter().map(|value| Some(*value));
    let roots = design.roots.iter().flatten().map(|part| Some(*part));
    let cells = values.chain(design.metrics.iter().copied()).chain(roots);
    let mut line = format!("{:>8}", design.index);
    for (header, value) in headers.iter().zip(cells) {
        let width = header.chars().count();
        let _ = match value {
            Some(value) => write!(line, "  {:>width$}", significant(value)),
            None => write!(line, "  {:>width$}", "–"),
        };
    }
    if design.has_doubtful_places {
        line += "  places doubtful";
    }
    if !design.doubtful_roots.is_empty() {
        line += &format!("  doubtful: {}", design.numbers_of_doubtful_roots(", "));
    }
    line.push('\n');
    line
}

/// Whether standard output still has a reader.
fn written(result: io::Result<()>) -> Result<bool, Failure> {
    match result {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(false),
        Err(error) => Err(Failure::Output(error)),
    }
}

fn varied(text: &str) -> Result<Vary, String> {
    let (path, text) = text
        .rsplit_once('=')
        .ok_or("write PATH=RANGE, as absorber.stiffness=1:10:50")?;
    let range = text.parse::<Range>().map_err(|error| error.to_string())?;
    Ok(Vary {
        path: path.to_owned(),
        text: text.to_owned(),
        range,
    })
}

fn shard(text: &str) -> Result<(u64, u64), String> {
    let parts = text
        .split_once('/')
        .and_then(|(part, parts)| Some((part.parse().ok()?, parts.parse().ok()?)));
    let parts = parts.filter(|(part, parts)| (1..=*parts).contains(part));
    parts.ok_or_else(|| "write i/N with i from 1 to N, as 2/5".to_owned())
}
