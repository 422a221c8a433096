//! `eigentone optimise SCENE --vary PATH=lo:hi … --minimise M [--json]`.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::{ArgGroup, Args};
use eigentone::design::{Optimum, OptimumError, Piece, minimise};
use eigentone::modes::Precision;
use serde_json::{Value, json};

use super::progress::Progress;
use super::study::{Kind, METRICS, Metric, Varied, object};
use super::{Failure, print, source, tell_switches};

/// Finds the numbers of the scene that make a metric least, and shows that they do
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("aim").required(true).args(["minimise", "maximise"])))]
pub struct Optimise {
    /// The scene file; - is standard input
    #[arg(value_parser = source::parser())]
    scene: PathBuf,
    /// What varies: NAME.key or a JSON Pointer, and its limits; may be repeated, up to 8 times
    #[arg(long, required = true, value_name = "PATH=lo:hi", value_parser = varied)]
    vary: Vec<(String, (f64, f64))>,
    #[arg(long, value_name = "METRIC", help = METRICS)]
    minimise: Option<Metric>,
    /// A metric to make largest instead
    #[arg(long, value_name = "METRIC")]
    maximise: Option<Metric>,
    /// Print one JSON object with every digit
    #[arg(long)]
    json: bool,
}

impl Optimise {
    pub fn run(self) -> Result<(), Failure> {
        let names = self.vary.iter().map(|(path, _)| path.as_str());
        let (scene, varied) = Varied::read(&self.scene, Precision::Double, names)?;
        let (metric, sign) = match (&self.minimise, &self.maximise) {
            (Some(metric), _) => (metric, 1.0),
            (None, Some(metric)) => (metric, -1.0),
            (None, None) => {
                let message = "say what to --minimise or to --maximise".to_owned();
                return Err(varied.refuse(message));
            }
        };
        let refuse = |why: String| varied.refuse(format!("{}: {why}", metric.text));
        let modes = scene.system().modes_to(Precision::Double);
        let modes = modes.map_err(Failure::modes(&self.scene))?;
        // Names that are wrong are wrong in every design.
        varied
            .measure(&metric.kind, &scene, &modes)
            .map_err(refuse)?;
        tell_switches(&self.scene, &scene);
        let limits: Vec<(f64, f64)> = self.vary.iter().map(|(_, limits)| *limits).collect();
        let progress = Progress::of("designs");
        let mut why: Option<String> = None;
        let mut count = 0usize;
        let found = minimise(&limits, |values| {
            count += 1;
            if count.is_multiple_of(100) {
                progress.say(&format!("{count} designs"));
            }
            match varied.pieces(&metric.kind, sign, values) {
                Ok(pieces) => pieces,
                Err(message) => {
                    why.get_or_insert_with(|| format!("{}: {message}", varied.told(values)));
                    None
                }
            }
        });
        drop(progress);
        let optimum = found.map_err(|error| match (error, why) {
            (OptimumError::Nowhere { .. }, Some(why)) => refuse(why),
            (error, _) => refuse(error.to_string()),
        })?;
        // What was followed was in doubles.
        let varied = varied.to(Precision::default());
        let refuse = |why: String| varied.refuse(format!("{}: {why}", metric.text));
        let (scene, modes) = varied.solve(&optimum.point).map_err(refuse)?;
        let value = varied.measure(&metric.kind, &scene, &modes);
        let value = value.map_err(refuse)?;
        let answer = Answer {
            varied: &varied,
            metric,
            // What a proven answer has above the peaks that were followed has not been minimised.
            is_shown: optimum.is_shown()
                && value.is_some_and(|value| {
                    (value - sign * optimum.value).abs() <= 1e-9 * value.abs()
                }),
            value: value.unwrap_or(sign * optimum.value),
            optimum: &optimum,
            sign,
        };
        print(|out| match self.json {
            true => writeln!(out, "{}", answer.json()),
            false => out.write_all(answer.text().as_bytes()),
        })
    }
}

struct Answer<'a> {
    varied: &'a Varied,
    metric: &'a Metric,
    optimum: &'a Optimum,
    value: f64,
    sign: f64,
    is_shown: bool,
}

impl Answer<'_> {
    /// The active functions: frequency in rad/s where they are peaks, value and weight.
    fn active(&self) -> impl Iterator<Item = (Option<f64>, f64, f64)> {
        let is_peak = matches!(self.metric.kind, Kind::Gain(..)) && self.sign > 0.0;
        self.optimum.active.iter().map(move |(piece, weight)| {
            let frequency = is_peak.then(|| piece.place.exp());
            (frequency, self.sign * piece.value, *weight)
        })
    }

    fn json(&self) -> String {
        let optimum = self.optimum;
        let parameters = optimum.point.iter().map(|value| Some(*value));
        let active: Vec<Value> = self
            .active()
            .map(|(frequency, value, weight)| match frequency {
                Some(frequency) => {
                    json!({"frequency": frequency, "value": value, "weight": weight})
                }
                None => json!({"value": value, "weight": weight}),
            })
            .collect();
        let limits = self.varied.names().zip(&optimum.limits);
        let limits: Vec<Value> = limits
            .filter(|(_, limit)| **limit != 0)
            .map(|(name, limit)| {
                let end = if *limit < 0 { "low" } else { "high" };
                json!({"parameter": name, "limit": end})
            })
            .collect();
        let others: Vec<f64> = optimum.others.iter().map(|v| self.sign * v).collect();
        let certificate = json!({
            "local_optimum": self.is_shown,
            "active": active,
            "spread": optimum.spread,
            "gradient": optimum.gradient,
            "curvature": optimum.curvature,
            "limits": limits,
            "others": others,
            "evaluations": optimum.evaluations,
        });
        format!(
            "{{\"parameters\": {}, \"metric\": {{\"name\": {}, \"value\": {}}}, \"certificate\": {certificate}}}",
            object(self.varied.names().zip(parameters)),
            Value::from(self.metric.text.as_str()),
            Value::from(self.value),
        )
    }

    fn text(&self) -> String {
        let optimum = self.optimum;
        let names: Vec<&str> = self.varied.names().collect();
        let width = names.iter().map(|name| name.chars().count());
        let width = width.chain([self.metric.text.chars().count()]).max();
        let width = width.unwrap_or_default();
        let mut text = String::new();
        // Writing to a string does not fail.
        for ((name, value), limit) in names.iter().zip(&optimum.point).zip(&optimum.limits) {
            let note = match limit {
                0 => "",
                1 => "  the upper limit",
                _ => "  the lower limit",
            };
            let _ = writeln!(text, "{name:<width$}  {value:.10e}{note}");
        }
        let _ = writeln!(text, "{:<width$}  {:.10e}", self.metric.text, self.value);
        let word = match self.sign > 0.0 {
            true => "minimum",
            false => "maximum",
        };
        let _ = match self.is_shown {
            true => writeln!(text, "a local {word}: gradients and curvature show it"),
            false => writeln!(
                text,
                "the best found; derivatives do not show a local {word}"
            ),
        };
        for (frequency, value, weight) in self.active().filter(|_| optimum.active.len() > 1) {
            let at = frequency.map_or(String::new(), |at| format!(" at {at:.6e} rad/s"));
            let _ = writeln!(text, "active: {value:.10e}{at}, weight {weight:.4}");
        }
        text
    }
}

impl Varied {
    /// The functions of which the largest is minimised: ± the metric.
    fn pieces(&self, kind: &Kind, sign: f64, values: &[f64]) -> Result<Option<Vec<Piece>>, String> {
        let (scene, modes) = self.solve(values)?;
        match kind {
            Kind::Gain(from, to) if sign > 0.0 => {
                let peaks = super::study::peaks_of_gain(&scene, &modes, from, to)?;
                let piece = |&(frequency, value): &(f64, f64)| Piece {
                    place: f64::ln(frequency).max(-1e4),
                    value,
                };
                Ok(peaks.map(|peaks| peaks.iter().map(piece).collect()))
            }
            Kind::Damping if sign < 0.0 => {
                let all = super::study::ratios(&modes).map(|(size, ratio)| Piece {
                    place: size.ln(),
                    value: -ratio,
                });
                Ok(Some(all.collect()))
            }
            kind => {
                let value = self.measure(kind, &scene, &modes)?;
                let piece = |value: f64| Piece {
                    place: 0.0,
                    value: sign * value,
                };
                Ok(value.map(|value| vec![piece(value)]))
            }
        }
    }
}

fn varied(text: &str) -> Result<(String, (f64, f64)), String> {
    const RIGHT: &str = "write PATH=lo:hi with the lower limit first, as absorber.stiffness=1:10";
    let (path, limits) = text.rsplit_once('=').ok_or(RIGHT)?;
    let (low, high) = limits.split_once(':').ok_or(RIGHT)?;
    let number = |text: &str| {
        let value = text.trim().parse().ok();
        value.filter(|value: &f64| value.is_finite()).ok_or(RIGHT)
    };
    let limits = (number(low)?, number(high)?);
    match limits.0 < limits.1 && (limits.1 - limits.0).is_finite() {
        true => Ok((path.to_owned(), limits)),
        false => Err(RIGHT.to_owned()),
    }
}
