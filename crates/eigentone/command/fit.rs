//! `eigentone fit SCENE --vary PATH … --to FILE [--json | --as-scene]`.

use std::cell::{Cell, OnceCell};
use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::PathBuf;

use clap::Args;
use eigentone::design::{self, FitError, fit_with};
use eigentone::modes::Precision;
use eigentone::report::significant;
use eigentone_digits::sort_by_number;
use serde_json::{Value, json};

use super::measured::{Measured, Unfit};
use super::progress::Progress;
use super::study::{Varied, object};
use super::{Failure, print, source};

/// Finds the numbers of the scene that agree best with measurements, and how accurately these determine them
#[derive(Debug, Args)]
pub struct Fit {
    /// The scene file; - is standard input
    #[arg(value_parser = source::parser())]
    scene: PathBuf,
    /// What is to be found: NAME.key or a JSON Pointer; the search starts at its value in the scene; may be repeated
    #[arg(long, required = true, value_name = "PATH")]
    vary: Vec<String>,
    /// The measurements, in CSV with the column names of `modes --csv`, `frf --csv` or `response --csv`
    #[arg(long, value_name = "FILE")]
    to: PathBuf,
    /// Print one JSON object with every digit
    #[arg(long)]
    json: bool,
    /// Print the scene with the numbers that were found
    #[arg(long, conflicts_with = "json")]
    as_scene: bool,
}

impl Fit {
    pub fn run(self) -> Result<(), Failure> {
        let names = self.vary.iter().map(String::as_str);
        let (scene, varied) = Varied::read(&self.scene, Precision::Double, names)?;
        let measured = Measured::read(&self.to, &scene).map_err(|unfit| match unfit {
            Unfit::Record(error) => error.into(),
            Unfit::Scene(message) => varied.refuse(message),
        })?;
        if !measured.left_out.is_empty() {
            let names: Vec<String> = measured
                .left_out
                .iter()
                .map(|name| format!("{name:?}"))
                .collect();
            // If standard error is closed, nobody can be informed.
            let _ = writeln!(
                io::stderr(),
                "note: {}: left out: {}",
                self.to.display(),
                names.join(", ")
            );
        }
        let entries = || measured.columns.iter().flat_map(|column| &column.entries);
        let known = measured.has_deviations();
        let start = varied.start();
        let progress = Progress::of("fit");
        let count = Cell::new(0usize);
        let why: OnceCell<String> = OnceCell::new();
        let model = |values: &[f64], precision: Precision| -> Option<Vec<f64>> {
            count.set(count.get() + 1);
            progress.say(&format!("{} designs", count.get()));
            let scene = varied.scene_of(values);
            let model = scene.and_then(|scene| measured.model(&scene, precision));
            match model {
                Ok(model) => Some(model),
                Err(message) => {
                    why.get_or_init(|| format!("{}: {message}", varied.named(values)));
                    None
                }
            }
        };
        let residuals = |model: Option<Vec<f64>>| -> Option<Vec<f64>> {
            let each = entries().zip(model?);
            Some(each.map(|(entry, model)| entry.residual(model)).collect())
        };
        let derivatives = |values: &[f64], is_relative: bool| -> Option<Vec<Vec<f64>>> {
            let mut columns = measured.derivatives(&varied, values)?;
            for column in &mut columns {
                let each = column.iter_mut().zip(entries());
                each.for_each(|(slope, entry)| *slope *= entry.per_model(is_relative));
            }
            Some(columns)
        };
        let from = |start: &[f64]| {
            fit_with(
                start,
                known,
                |values| residuals(model(values, Precision::Double)),
                |values| derivatives(values, false),
            )
        };
        let relative = |values: &[f64]| -> Option<Vec<f64>> {
            let each = entries().zip(model(values, Precision::Double)?);
            Some(each.map(|(entry, model)| entry.relative(model)).collect())
        };
        let better = |one: Result<design::Fit, FitError>, other: Result<design::Fit, FitError>| {
            let left = |found: &Result<design::Fit, FitError>| {
                found
                    .as_ref()
                    .map_or(f64::INFINITY, |found| length(&found.residuals))
            };
            if left(&other) < left(&one) {
                other
            } else {
                one
            }
        };
        let search = |start: &[f64]| {
            let found = from(start);
            if !measured.begins_relatively() {
                return found;
            }
            let begun = fit_with(start, false, relative, |values| derivatives(values, true));
            better(found, begun.and_then(|begun| from(&begun.point)))
        };
        let mut found = search(&start);
        if let Ok(first) = &found
            && misfit(first, &measured, known).is_some()
        {
            /// Searches go out from so many points more, the best of all about the start.
            const MORE: usize = 4;
            let rated = around(&start).into_iter().filter_map(|point| {
                let left = length(&relative(&point)?);
                Some((left, point))
            });
            let mut rated: Vec<(f64, Vec<f64>)> = rated.collect();
            sort_by_number(&mut rated, |(left, _)| *left);
            for (_, point) in rated.into_iter().take(MORE) {
                found = better(found, search(&point));
            }
        }
        let point = found.as_ref().ok().map(|found| found.point.clone());
        let proven = point.and_then(|point| residuals(model(&point, Precision::default())));
        drop(progress);
        let mut found = found.map_err(|error| {
            varied.refuse(match (error, why.into_inner()) {
                (FitError::NoAnswer, Some(why)) => why,
                (FitError::Start { index, value }, _) => format!(
                    "--vary {}: the search cannot start at {value:?}, for changes are in parts of it: give the scene a value other than 0",
                    self.vary[index]
                ),
                (error, _) => error.to_string(),
            })
        })?;
        // What proven answers leave differs from what was made least.
        let is_doubtful = match &proven {
            Some(proven) => {
                let apart = proven
                    .iter()
                    .zip(&found.residuals)
                    .map(|(a, b)| (a - b).abs());
                let limit = 1e-9f64.max(1e-3 * found.deviation.unwrap_or(0.0));
                apart.fold(0.0, f64::max) > limit
            }
            None => true,
        };
        let is_settled = found.is_settled && !is_doubtful;
        if !is_settled {
            found.interval.fill(None);
        }
        let answer = Answer {
            varied: &varied,
            measured: &measured,
            is_settled,
            found,
            known,
        };
        print(|out| match (self.json, self.as_scene) {
            (true, _) => writeln!(out, "{}", answer.json()),
            (_, true) => writeln!(out, "{:#}", varied.written(&answer.found.point)),
            _ => out.write_all(answer.text().as_bytes()),
        })
    }
}

/// Of residuals together, whose squares may leave the doubles.
fn length(residuals: &[f64]) -> f64 {
    residuals.iter().copied().fold(0.0, f64::hypot)
}

/// Their root mean square.
fn mean(residuals: &[f64]) -> f64 {
    length(residuals) / (residuals.len() as f64).sqrt()
}

/// Points that fill the numbers within twice and half of those at the start (Martin Roberts's sequence, 2018: each is the one before and the
/// powers of 1/φ, φ^{d+1} = φ + 1, but for whole numbers).
fn around(start: &[f64]) -> Vec<Vec<f64>> {
    /// So many for each number.
    const POINTS: usize = 16;
    let d = start.len() as i32;
    let phi = (0..60).fold(2.0f64, |phi, _| (1.0 + phi).powf(1.0 / f64::from(d + 1)));
    let point = |k: usize| {
        let numbers = (1..).zip(start);
        let part = |i: i32| (k as f64 * phi.powi(-i)).fract();
        numbers
            .map(|(i, value)| value * (2.0 * part(i) - 1.0).exp2())
            .collect()
    };
    (1..=POINTS * start.len()).map(point).collect()
}

/// Why what was found is not to be relied on, if residuals show it.
fn misfit(found: &design::Fit, measured: &Measured, known: bool) -> Option<String> {
    /// Smaller ones, in parts of what was measured, are rounding.
    const ROUNDING: f64 = 1e-9;
    /// A model that says nothing leaves 1, and 1/√2 of complex values.
    const MOST: f64 = 0.5;
    /// The sum of many products of neighbours, over the root of that of their squares, is normal, and this far out once in a thousand
    /// times: the correlation of Durbin and Watson (1950, *Biometrika* 37) for errors of any sizes.
    const SELDOM: f64 = 3.29;
    let mut rest = &found.residuals[..];
    let (mut together, mut squares) = (0.0, 0.0f64);
    for column in &measured.columns {
        let Some(own) = rest.split_off(..column.entries.len()) else {
            break;
        };
        if !known && mean(own) > MOST {
            let name = &column.name;
            return Some(format!(
                "more than half of what was measured as {name} is left"
            ));
        }
        for pair in own.windows(2) {
            let product = pair[0] * pair[1];
            together += product;
            squares = squares.hypot(product);
        }
    }
    let size = length(&found.residuals);
    let correlation = together / size / size;
    let mean = mean(&found.residuals);
    if (known || mean > ROUNDING) && f64::abs(together) > SELDOM * squares {
        return Some(format!(
            "residuals of neighbouring lines have the correlation {correlation:.2}, which those of independent errors have less than once in a thousand times"
        ));
    }
    let (index, size) = found.outlier().filter(|_| known || mean > ROUNDING)?;
    let columns = measured.columns.iter();
    let mut all =
        columns.flat_map(|column| column.entries.iter().map(move |entry| (column, entry)));
    let (column, entry) = all.nth(index)?;
    Some(format!(
        "the residual of {} in line {} is {size:.1} standard deviations, which normal errors leave less than once in a thousand times",
        column.name, entry.line
    ))
}

struct Answer<'a> {
    varied: &'a Varied,
    measured: &'a Measured,
    found: design::Fit,
    is_settled: bool,
    known: bool,
}

impl Answer<'_> {
    fn misfit(&self) -> Option<String> {
        misfit(&self.found, self.measured, self.known)
    }

    fn json(&self) -> String {
        let found = &self.found;
        let names = || self.varied.names();
        let mut left = found.residuals.iter();
        let mut residuals = Vec::new();
        for column in &self.measured.columns {
            for (entry, left) in column.entries.iter().zip(left.by_ref()) {
                let model = entry.model(*left);
                residuals.push(json!({
                    "column": column.name, "line": entry.line,
                    "measured": entry.value, "model": model,
                }));
            }
        }
        let undetermined: Vec<String> = found
            .undetermined
            .iter()
            .map(|way| object(names().zip(way.iter().map(|part| Some(*part)))))
            .collect();
        format!(
            "{{\"parameters\": {}, \"interval\": {}, \"deviation\": {}, \"known_deviations\": {}, \"local_minimum\": {}, \"misfit\": {}, \"undetermined\": [{}], \"residuals\": {}, \"evaluations\": {}}}",
            object(names().zip(found.point.iter().map(|value| Some(*value)))),
            object(names().zip(found.interval.iter().copied())),
            Value::from(found.deviation),
            self.known,
            self.is_settled,
            Value::from(self.misfit()),
            undetermined.join(", "),
            Value::from(residuals),
            found.evaluations,
        )
    }

    fn text(&self) -> String {
        let found = &self.found;
        let names: Vec<&str> = self.varied.names().collect();
        let width = names.iter().map(|name| name.chars().count()).max();
        let width = width.unwrap_or_default();
        let mut text = String::new();
        // Writing to a string does not fail.
        for ((name, value), interval) in names.iter().zip(&found.point).zip(&found.interval) {
            let interval = match interval {
                Some(interval) => format!("± {interval:.1e}"),
                None => "± ?".to_owned(),
            };
            let _ = writeln!(text, "{name:<width$}  {}  {interval}", significant(*value));
        }
        let columns: Vec<String> = self
            .measured
            .columns
            .iter()
            .map(|column| format!("{} of {}", column.entries.len(), column.name))
            .collect();
        let _ = writeln!(text, "fitted to {}", columns.join(", "));
        if found.interval.iter().any(Option::is_some) {
            let rest = match self.known {
                true => "from the standard deviations given",
                false => "from the scatter of the residuals",
            };
            let _ = writeln!(text, "±: 95 % confidence intervals, {rest}");
        }
        let mean = mean(&found.residuals);
        let _ = match self.known {
            true => writeln!(
                text,
                "residuals: {mean:.3} standard deviations, root mean square"
            ),
            false => writeln!(
                text,
                "residuals: {mean:.1e} of the measured values, root mean square"
            ),
        };
        if let Some(why) = self.misfit() {
            let _ = writeln!(
                text,
                "doubtful: {why}: the model is another one, measurements are outliers, or other starts lead to less; the intervals hold for none of these"
            );
        }
        if self.is_settled && found.undetermined.is_empty() && found.deviation.is_none() {
            let _ = writeln!(
                text,
                "no intervals: there are no more measurements than parameters"
            );
        }
        for way in &found.undetermined {
            let parts: Vec<String> = names
                .iter()
                .zip(way)
                .filter(|(_, part)| part.abs() > 1e-9)
                .map(|(name, part)| format!("{name} by {:+.3} %", 100.0 * part))
                .collect();
            let _ = writeln!(
                text,
                "not determined: no measurement changes with {}",
                parts.join(" and ")
            );
        }
        if !self.is_settled {
            let _ = writeln!(
                text,
                "the best found: the search did not come to rest at a least sum of squares; start nearer to it"
            );
        }
        text
    }
}
