//! `eigentone optimise SCENE --vary PATH=lo:hi … --minimise M [--minimise M] [--json] [--out DIR]`.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::{ArgGroup, Args};
use eigentone::design::{Optimum, OptimumError, Piece, front_with, minimise_with};
use eigentone::modes::{Modes, Precision};
use eigentone::report::{FrontDesign, FrontReport, significant};
use eigentone::response::Transfer;
use eigentone::scene::Scene;
use eigentone_digits::sort_by_number;
use num_complex::Complex;
use serde_json::{Value, json};

use super::files::Files;
use super::progress::Progress;
use super::study::{
    Kind, METRICS, Metric, Varied, decays, mean_square, object, peaks_by_values, peaks_in_doubles,
    rates, ratios, sensitivities, transfer,
};
use super::{Failure, print, report_switches, source};

/// Finds the numbers of the scene that make a metric smallest, and shows that they do; with two metrics, the designs between the two
/// optima
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("aims").required(true).multiple(true).args(["minimise", "maximise"])))]
pub struct Optimise {
    /// The scene file; - is standard input
    #[arg(value_parser = source::parser())]
    scene: PathBuf,
    /// What varies: NAME.key or a JSON Pointer, and its limits; may be repeated, up to 8 times
    #[arg(long, required = true, value_name = "PATH=lo:hi", value_parser = varied)]
    vary: Vec<(String, (f64, f64))>,
    #[arg(long, value_name = "METRIC", help = METRICS)]
    minimise: Vec<Metric>,
    /// A metric to make largest instead
    #[arg(long, value_name = "METRIC")]
    maximise: Vec<Metric>,
    /// How many designs from one optimum of two metrics to the other, both included [default: 11]
    #[arg(long, value_name = "COUNT", value_parser = super::whole(2..=1000))]
    front: Option<u32>,
    /// Print one JSON object with every digit
    #[arg(long)]
    json: bool,
    /// Write the designs between the two optima into this directory, as CSV and as a plot
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// A metric and the direction that is wanted.
#[derive(Clone, Copy, Debug)]
pub struct Aim<'a> {
    pub metric: &'a Metric,
    /// 1 to make it least, −1 to make it largest.
    pub sign: f64,
}

impl Optimise {
    pub fn run(self) -> Result<(), Failure> {
        let names = self.vary.iter().map(|(path, _)| path.as_str());
        let (scene, varied) = Varied::read(&self.scene, Precision::Double, names)?;
        let least = self.minimise.into_iter().map(|metric| (metric, 1.0));
        let most = self.maximise.into_iter().map(|metric| (metric, -1.0));
        let wanted = least.chain(most).map(|(metric, sign)| {
            let metric = metric.of(&scene).map_err(|why| varied.refuse(why))?;
            Ok((metric, sign))
        });
        let wanted = wanted.collect::<Result<Vec<_>, Failure>>()?;
        let aims = wanted
            .iter()
            .map(|&(ref metric, sign)| Aim { metric, sign });
        let aims: Vec<Aim<'_>> = aims.collect();
        let modes = scene.system().modes_to(Precision::Double);
        let modes = modes.map_err(Failure::modes(&self.scene))?;
        for Aim { metric, .. } in &aims {
            // Names that are wrong are wrong in every design.
            let measured = varied.measure(&metric.kind, &scene, &modes);
            measured.map_err(|why| varied.refuse(format!("{}: {why}", metric.text)))?;
        }
        report_switches(&self.scene, &scene);
        let limits: Vec<(f64, f64)> = self.vary.iter().map(|(_, limits)| *limits).collect();
        match aims[..] {
            [aim] => {
                let given = [
                    ("--out", self.out.is_some()),
                    ("--front", self.front.is_some()),
                ];
                match given.into_iter().find(|(_, is_given)| *is_given) {
                    None => best(aim, &limits, varied, self.json),
                    Some((option, _)) => Err(varied.refuse(format!(
                        "{option} is for the designs between the bests of two metrics: give a second one, or leave it out"
                    ))),
                }
            }
            [first, second] if first.metric.kind != second.metric.kind => {
                let files = self.out.as_deref().map(Files::into).transpose()?;
                let files = files.map(|files| files.beside(&self.scene));
                between(
                    [first, second],
                    &limits,
                    varied,
                    self.front.unwrap_or(11),
                    self.json,
                    files,
                )
            }
            _ => {
                let message = "give one metric, or two that differ, to --minimise or to --maximise";
                Err(varied.refuse(message.to_owned()))
            }
        }
    }
}

/// The designs that a search has asked for, and why the first of them that has no answer has none.
struct Tried<'a> {
    varied: &'a Varied,
    progress: Progress,
    count: usize,
    why: Option<String>,
    /// Which aims some design has no value of.
    missing: Vec<bool>,
}

impl Tried<'_> {
    fn of<'a>(varied: &'a Varied, aims: &[Aim<'_>]) -> Tried<'a> {
        Tried {
            varied,
            progress: Progress::of("designs"),
            count: 0,
            why: None,
            missing: vec![false; aims.len()],
        }
    }

    fn pieces(&mut self, aims: &[Aim<'_>], values: &[f64]) -> Option<Vec<Vec<Piece>>> {
        self.count += 1;
        self.progress.say(&format!("{} designs", self.count));
        match self.varied.pieces(aims, values) {
            Ok(pieces) => {
                for (missing, pieces) in self.missing.iter_mut().zip(&pieces) {
                    *missing |= pieces.is_none();
                }
                pieces.into_iter().collect()
            }
            Err(message) => {
                let varied = self.varied;
                self.why
                    .get_or_insert_with(|| format!("{}: {message}", varied.named(values)));
                None
            }
        }
    }

    fn refuse(self, aims: &[Aim<'_>], error: OptimumError) -> Failure {
        let metrics: Vec<&str> = aims.iter().map(|aim| aim.metric.text.as_str()).collect();
        let why = match (error, self.why) {
            (OptimumError::Nowhere { .. }, Some(why)) => why,
            (error @ OptimumError::Nowhere { .. }, None) => {
                let missing = aims.iter().zip(&self.missing);
                let missing = missing.filter(|(_, missing)| **missing);
                let mut whys: Vec<String> = missing
                    .map(|(aim, _)| match aims {
                        [_] => aim.metric.kind.is_missing().to_owned(),
                        _ => format!("of {}, {}", aim.metric.text, aim.metric.kind.is_missing()),
                    })
                    .collect();
                if whys.is_empty() {
                    whys.push("what is found leaves the range of doubles".to_owned());
                }
                format!("{error}: {}", whys.join("; "))
            }
            (error, _) => error.to_string(),
        };
        self.varied.refuse(format!("{}: {why}", metrics.join(", ")))
    }
}

/// Whether a proven value, if there is one, is the one that was followed in doubles: what a proven answer has above the peaks
/// that were followed has not been minimised.
fn is_followed(proven: Option<f64>, followed: f64) -> bool {
    proven.is_none_or(|proven| (proven - followed).abs() <= 1e-9 * proven.abs())
}

/// The best design for one metric.
fn best(aim: Aim<'_>, limits: &[(f64, f64)], varied: Varied, json: bool) -> Result<(), Failure> {
    let Aim { metric, sign } = aim;
    let mut tried = Tried::of(&varied, &[aim]);
    let found = minimise_with(
        limits,
        |values| tried.pieces(&[aim], values)?.pop(),
        |values| varied.gradients(&[aim], values, limits)?.pop(),
    );
    let optimum = match found {
        Ok(optimum) => optimum,
        Err(error) => return Err(tried.refuse(&[aim], error)),
    };
    drop(tried);
    // What was followed was in doubles.
    let varied = varied.to(Precision::default());
    let refuse = |why: String| varied.refuse(format!("{}: {why}", metric.text));
    let (scene, modes) = varied.solve(&optimum.point).map_err(refuse)?;
    let value = varied.measure(&metric.kind, &scene, &modes);
    let value = value.map_err(refuse)?;
    let answer = Answer {
        varied: &varied,
        metric,
        is_proven: value.is_some() && metric.kind.is_proven(),
        is_shown: optimum.is_shown() && is_followed(value, sign * optimum.value),
        value: value.unwrap_or(sign * optimum.value),
        optimum: &optimum,
        sign,
    };
    print(|out| match json {
        true => writeln!(out, "{}", answer.json()),
        false => out.write_all(answer.text().as_bytes()),
    })
}

/// The designs between the bests of two metrics.
fn between(
    aims: [Aim<'_>; 2],
    limits: &[(f64, f64)],
    varied: Varied,
    count: u32,
    json: bool,
    files: Option<Files>,
) -> Result<(), Failure> {
    let mut tried = Tried::of(&varied, &aims);
    let found = front_with(
        limits,
        count as usize,
        |values| tried.pieces(&aims, values)?.try_into().ok(),
        |values| varied.gradients(&aims, values, limits)?.try_into().ok(),
    );
    let points = match found {
        Ok(points) => points,
        Err(error) => return Err(tried.refuse(&aims, error)),
    };
    drop(tried);
    let varied = varied.to(Precision::default());
    let mut designs = Vec::new();
    let mut units = [const { String::new() }; 2];
    for point in points {
        let (scene, modes) = varied
            .solve(&point.point)
            .map_err(|why| varied.refuse(why))?;
        let mut is_shown = point.is_shown;
        let mut metrics = [0.0; 2];
        for ((value, aim), followed) in metrics.iter_mut().zip(aims).zip(point.aims) {
            let proven = varied.measure(&aim.metric.kind, &scene, &modes);
            let proven = proven.map_err(|why| varied.refuse(why))?;
            is_shown &= is_followed(proven, aim.sign * followed);
            *value = proven.unwrap_or(aim.sign * followed);
        }
        units = aims.map(|aim| aim.metric.kind.unit(&scene));
        designs.push(FrontDesign {
            parameters: point.point,
            metrics,
            is_shown,
        });
    }
    let parameters: Vec<&str> = varied.names().collect();
    let report = FrontReport {
        title: varied.title(),
        parameters: &parameters,
        metrics: aims.map(|aim| aim.metric.text.as_str()),
        units: units.each_ref().map(String::as_str),
        designs: &designs,
    };
    if let Some(mut files) = files {
        files.write("front.csv", |out| report.csv(out))?;
        files.write("front.svg", |out| {
            out.write_all(report.plot().svg().as_bytes())
        })?;
        files.keep()?;
    }
    print(|out| match json {
        true => report.json(out),
        false => out.write_all(report.text().as_bytes()),
    })
}

struct Answer<'a> {
    varied: &'a Varied,
    metric: &'a Metric,
    optimum: &'a Optimum,
    value: f64,
    sign: f64,
    is_shown: bool,
    is_proven: bool,
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
            "proven": self.is_proven,
            "constant": optimum.is_constant,
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
            let _ = writeln!(text, "{name:<width$}  {}{note}", significant(*value));
        }
        let (name, value) = (&self.metric.text, significant(self.value));
        let _ = writeln!(text, "{name:<width$}  {value}");
        if optimum.is_constant {
            let _ = writeln!(
                text,
                "the same at all {} points within the limits that were tried: what varies may not change it",
                optimum.evaluations
            );
            return text;
        }
        let word = match self.sign > 0.0 {
            true => "minimum",
            false => "maximum",
        };
        let _ = match self.is_shown {
            true if self.is_proven => {
                writeln!(text, "a local {word}: gradients and curvature show it")
            }
            true => writeln!(
                text,
                "a local {word} within the accuracy of doubles: gradients and curvature show it, but the value is not proven"
            ),
            false => writeln!(
                text,
                "the best found; derivatives do not show a local {word}"
            ),
        };
        if optimum.active.len() < 2 || !optimum.is_balanced() {
            return text;
        }
        for (frequency, value, weight) in self.active() {
            let at = frequency.map_or(String::new(), |at| {
                if at == f64::INFINITY {
                    return " as the frequency grows".to_owned();
                }
                let hertz = significant(at / std::f64::consts::TAU);
                format!(" at {} rad/s, {hertz} Hz", significant(at))
            });
            let _ = writeln!(
                text,
                "one of the largest: {}{at}, weight {weight:.4}",
                significant(value)
            );
        }
        text += "weights: with them the derivatives of the largest cancel, so that none can fall without another rising\n";
        text
    }
}

/// What is reported of scenes beside the one that was solved, one number for each function, with its solution held.
type Held<'a> = Box<dyn Fn(&Scene) -> Option<Vec<f64>> + 'a>;

impl Varied {
    /// For each aim the functions of which the largest is minimised: ± the metric; `None` for one that has no value.
    fn pieces(&self, aims: &[Aim<'_>], values: &[f64]) -> Result<Vec<Option<Vec<Piece>>>, String> {
        let (scene, modes) = self.solve(values)?;
        let each = aims.iter().map(|aim| self.pieces_of(aim, &scene, &modes));
        each.collect()
    }

    fn pieces_of(
        &self,
        aim: &Aim<'_>,
        scene: &Scene,
        modes: &Modes,
    ) -> Result<Option<Vec<Piece>>, String> {
        let single = |value: f64| Piece {
            place: 0.0,
            value: aim.sign * value,
        };
        match &aim.metric.kind {
            Kind::Gain(from, to, band) if aim.sign > 0.0 && decays(scene, modes)? => {
                let peaks = match peaks_in_doubles(scene, from, to, *band)? {
                    None => peaks_by_values(scene, modes, from, to, *band)?,
                    known => known,
                };
                let limit = match (band, &peaks) {
                    (None, Some(all)) => all.iter().map(|(at, _)| *at).reduce(f64::max),
                    _ => None,
                };
                let piece = |&(frequency, value): &(f64, f64)| Piece {
                    place: match Some(frequency) == limit {
                        true => HIGHEST,
                        false => f64::ln(frequency).max(LOWEST),
                    },
                    value,
                };
                return Ok(peaks.map(|peaks| peaks.iter().map(piece).collect()));
            }
            Kind::Damping if aim.sign < 0.0 => {
                let all = ratios(modes).map(|(size, ratio)| Piece {
                    place: size.ln(),
                    value: -ratio,
                });
                return Ok(Some(all.collect()));
            }
            _ => {}
        }
        let value = self.measure(&aim.metric.kind, scene, modes)?;
        Ok(value.map(|value| vec![single(value)]))
    }

    /// The same with the derivatives of each by the numbers: those of roots, gains and mean squares in closed form. `None` where
    /// there are none.
    fn gradients(
        &self,
        aims: &[Aim<'_>],
        values: &[f64],
        limits: &[(f64, f64)],
    ) -> Option<Vec<Sloped>> {
        let (scene, modes) = self.solve(values).ok()?;
        let each = aims.iter().map(|aim| {
            let pieces = self.pieces_of(aim, &scene, &modes).ok()??;
            let columns = match &aim.metric.kind {
                Kind::Peak(name) => {
                    let slopes = self.slopes_of_peak(&scene, name, values, limits)?;
                    slopes.iter().map(|slope| vec![aim.sign * slope]).collect()
                }
                _ => {
                    let held = held(aim, &scene, &modes, &pieces)?;
                    self.derivatives(values, Some(limits), &held)?
                }
            };
            let gradient = |j: usize| columns.iter().map(|column| column[j]).collect();
            let each = pieces.iter().enumerate();
            Some(each.map(|(j, piece)| (*piece, gradient(j))).collect())
        });
        each.collect()
    }
}

/// Pieces with their derivatives by the numbers.
type Sloped = Vec<(Piece, Vec<f64>)>;

/// The logarithm of the least frequency.
const LOWEST: f64 = -1e4;

/// Where the limit for frequencies that grow stands: the exponential is infinite.
const HIGHEST: f64 = 1e4;

/// What the functions of an aim are with the solution held; `None` where that is not known.
fn held<'a>(
    aim: &'a Aim<'_>,
    scene: &'a Scene,
    modes: &'a Modes,
    pieces: &[Piece],
) -> Option<Held<'a>> {
    let sign = aim.sign;
    match &aim.metric.kind {
        Kind::Damping => {
            let moving = modes
                .into_iter()
                .filter(|mode| mode.eigenvalue().value.norm() > 0.0);
            let mut all = sensitivities(scene, moving)?;
            if sign > 0.0 {
                let ratio = |root: &Complex<f64>| -root.re / root.norm();
                sort_by_number(&mut all, |(one, _)| ratio(one));
                all.truncate(1);
            }
            Some(Box::new(move |other| {
                let each = all.iter().map(|(root, sensitivity)| {
                    let rate = sensitivity.toward(other.system()).ok()?;
                    Some(sign * rates(*root, rate)[1])
                });
                each.collect()
            }))
        }
        Kind::Frequency(k) => {
            let mut all = sensitivities(scene, modes.into_iter().skip(k - 1).take(1))?;
            let (root, sensitivity) = all.pop().filter(|(root, _)| root.norm() > 0.0)?;
            Some(Box::new(move |other| {
                let rate = sensitivity.toward(other.system()).ok()?;
                Some(vec![sign * rates(root, rate)[0]])
            }))
        }
        Kind::Gain(from, to, band) => {
            let transfer = transfer(scene, from, to).ok()??;
            let mut peaks = peaks_in_doubles(scene, from, to, *band).ok()??;
            if sign < 0.0 {
                sort_by_number(&mut peaks, |peak| -peak.1);
                peaks.truncate(1);
            }
            let adjoints = peaks
                .iter()
                .map(|(frequency, _)| transfer.adjoint(*frequency));
            let adjoints = adjoints.collect::<Option<Vec<_>>>()?;
            (adjoints.len() == pieces.len()).then_some(())?;
            Some(Box::new(move |other| {
                let transfer = transfer_of(other, from, to)?;
                let each = adjoints.iter().map(|adjoint| {
                    let value = adjoint.value();
                    let along = adjoint.along(&transfer);
                    sign * (value.conj() * along).re / value.norm()
                });
                Some(each.collect())
            }))
        }
        Kind::Rms(name, weighting) => {
            let square = mean_square(scene, name, *weighting).ok()??;
            let twice = 2.0 * square.value().sqrt();
            Some(Box::new(move |other| {
                let along = square.along(&other.noise()?).ok()??;
                Some(vec![sign * along / twice])
            }))
        }
        Kind::Peak(_) | Kind::Settling(_) => None,
    }
}

fn transfer_of(scene: &Scene, from: &String, to: &String) -> Option<Transfer> {
    transfer(scene, from, to).ok()?
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
