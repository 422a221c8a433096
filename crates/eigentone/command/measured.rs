//! A table of measurements, and what the scene gives in place of each: for `fit`.
//!
//! Columns have the names that they have in the tables of `modes`, `frf` and `response`.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;

use eigentone::modes::Precision;
use eigentone::report::{FrequencyReport, motion_columns};
use eigentone::response::{
    Adjoint, Combination, FrequencyFunctions, Problem, Quantity, ResponsePlan, Transfer,
};
use eigentone::scene::{RecordError, Scene, Table, did_you_mean};
use num_complex::Complex;

use super::frf::asked;
use super::study::{Varied, is_end, is_to, motion, numbers_beside, rates, sensitivities};

/// What was measured, and how the scene gives it.
#[derive(Debug)]
pub struct Measured {
    pub columns: Vec<Column>,
    /// Columns of the file that say nothing to this.
    pub left_out: Vec<String>,
    source: Source,
}

/// One column: what it holds, and for each measurement its row, line, value and standard deviation.
#[derive(Debug)]
pub struct Column {
    pub name: String,
    of: Of,
    pub entries: Vec<Entry>,
}

#[derive(Clone, Copy, Debug)]
pub struct Entry {
    pub line: usize,
    pub value: f64,
    /// Standard deviation, where it is known.
    deviation: Option<f64>,
    /// In parts of what a residual is, where no deviation is known.
    scale: f64,
    /// Of all that was measured of the same thing at the same place.
    size: f64,
    /// Which mode, frequency or instant.
    at: usize,
}

impl Entry {
    pub fn residual(&self, model: f64) -> f64 {
        (model - self.value) / self.deviation.unwrap_or(self.scale)
    }

    /// In parts of how large the measured function is there alone, so that resonances do not hide the rest.
    pub fn relative(&self, model: f64) -> f64 {
        (model - self.value) / self.size
    }

    /// How much a residual, or a relative one, changes with the model.
    pub fn per_model(&self, is_relative: bool) -> f64 {
        match is_relative {
            true => 1.0 / self.size,
            false => 1.0 / self.deviation.unwrap_or(self.scale),
        }
    }

    pub fn model(&self, residual: f64) -> f64 {
        self.value + residual * self.deviation.unwrap_or(self.scale)
    }
}

#[derive(Clone, Copy, Debug)]
enum Of {
    /// Natural frequency, in parts of a rad/s.
    Natural(f64),
    Damped(f64),
    Ratio,
    /// Function `function` of asked question `asked`; its imaginary part, or its real part.
    Function {
        asked: usize,
        function: usize,
        is_imaginary: bool,
    },
    Output(usize),
}

/// What has to be solved.
#[derive(Debug)]
enum Source {
    Modes,
    Frequencies {
        /// In rad/s.
        at: Vec<f64>,
        asked: Vec<Asked>,
    },
    Motion {
        instants: Vec<u64>,
        outputs: Vec<Combination>,
    },
}

#[derive(Debug)]
struct Asked {
    from: Vec<String>,
    to: Vec<String>,
    quantity: Quantity,
}

/// Why measurements cannot be used.
#[derive(Debug)]
pub enum Unfit {
    Record(RecordError),
    /// The scene has nothing that they could be of.
    Scene(String),
}

impl From<RecordError> for Unfit {
    fn from(error: RecordError) -> Unfit {
        Unfit::Record(error)
    }
}

/// Why a scene gives no numbers in place of the measurements.
#[derive(Debug)]
enum Lack {
    /// It has no good one for one of them.
    Number(String),
    /// It has no answer at all.
    Answer(String),
}

impl From<String> for Lack {
    fn from(message: String) -> Lack {
        Lack::Answer(message)
    }
}

/// What stands before the name of a column that has the standard deviations of another.
const DEVIATION: &str = "sd ";

impl Measured {
    pub fn read(path: &Path, scene: &Scene) -> Result<Measured, Unfit> {
        let table = Table::read(path)?;
        let names = table.names();
        let find = |name: &str| names.iter().position(|known| known == name);
        if let Some(at) = find("frequency [rad/s]") {
            return frequencies(&table, scene, at, 1.0);
        }
        if let Some(at) = find("frequency [Hz]") {
            return frequencies(&table, scene, at, TAU);
        }
        match find("time [s]") {
            Some(at) => motions(&table, scene, at),
            None => modes(&table, scene),
        }
    }

    /// Whether a search first looks at relative errors: beside the resonances of a function that is too far off, nothing leads
    /// to where its peaks agree.
    pub fn begins_relatively(&self) -> bool {
        matches!(self.source, Source::Frequencies { .. })
    }

    /// Whether the deviations of all are known.
    pub fn has_deviations(&self) -> bool {
        let mut all = self.columns.iter().flat_map(|column| &column.entries);
        all.all(|entry| entry.deviation.is_some())
    }

    /// What the scene gives, column by column: with proof also where doubles give no good number.
    ///
    /// # Errors
    /// Why there is none, in words.
    pub fn model(&self, scene: &Scene, precision: Precision) -> Result<Vec<f64>, String> {
        let found = match (self.model_to(scene, precision), precision) {
            (Err(Lack::Number(_)), Precision::Double) => self.model_to(scene, Precision::default()),
            (found, _) => found,
        };
        found.map_err(|(Lack::Number(message) | Lack::Answer(message))| message)
    }

    fn model_to(&self, scene: &Scene, precision: Precision) -> Result<Vec<f64>, Lack> {
        match &self.source {
            Source::Modes => self.of_modes(scene, precision),
            Source::Frequencies { at, asked } => self.of_functions(scene, precision, at, asked),
            Source::Motion { instants, outputs } => {
                self.of_motion(scene, precision, instants, outputs)
            }
        }
    }

    /// The derivatives of what the scene gives by each of its numbers, in closed form; `None` where there are none.
    pub fn derivatives(&self, varied: &Varied, values: &[f64]) -> Option<Vec<Vec<f64>>> {
        let scene = varied.scene_of(values).ok()?;
        match &self.source {
            Source::Modes => [Precision::Double, Precision::default()]
                .into_iter()
                .find_map(|precision| self.of_roots(varied, values, &scene, precision)),
            Source::Frequencies { at, asked } => {
                self.of_adjoints(varied, values, &scene, at, asked)
            }
            Source::Motion { instants, outputs } => {
                self.of_tangents(varied, values, &scene, instants, outputs)
            }
        }
    }

    fn of_roots(
        &self,
        varied: &Varied,
        values: &[f64],
        scene: &Scene,
        precision: Precision,
    ) -> Option<Vec<Vec<f64>>> {
        /// Double-doubles show no smaller change of a ratio.
        const LEAST: f64 = 1e-26;
        let modes = scene.system().modes_to(precision).ok()?;
        let all: Vec<_> = modes.into_iter().collect();
        let entries = self.columns.iter().flat_map(|column| &column.entries);
        let mut used: Vec<usize> = entries.map(|entry| entry.at).collect();
        used.sort_unstable();
        used.dedup();
        let modes = used.iter().map(|at| all.get(*at).copied());
        let modes: Vec<_> = modes.collect::<Option<_>>()?;
        let known = sensitivities(scene, modes.into_iter())?;
        let least = self.each(|of, at| {
            let (root, _) = known[used.binary_search(&at).unwrap_or_default()];
            Ok(Some(match of {
                Of::Natural(unit) => f64::EPSILON * root.norm() / unit,
                Of::Damped(unit) => f64::EPSILON * root.im.abs() / unit,
                _ => (f64::EPSILON * (root.re / root.norm()).abs()).max(LEAST),
            }))
        });
        let columns = varied.derivatives(values, None, &|other| {
            let rates_of = known
                .iter()
                .map(|(root, sensitivity)| Some((*root, sensitivity.toward(other.system()).ok()?)));
            let rates_of = rates_of.collect::<Option<Vec<_>>>()?;
            let each = self.each(|of, at| {
                let (root, rate) = rates_of[used.binary_search(&at).unwrap_or_default()];
                let [frequency, ratio] = rates(root, rate);
                Ok(match of {
                    Of::Natural(unit) => Some(frequency / unit),
                    Of::Damped(unit) => Some(rate.im * root.im.signum() / unit),
                    Of::Ratio => Some(ratio),
                    _ => None,
                })
            });
            each.ok()
        });
        Some(cleared(columns?, values, &least.ok()?))
    }

    fn of_adjoints(
        &self,
        varied: &Varied,
        values: &[f64],
        scene: &Scene,
        at: &[f64],
        asked: &[Asked],
    ) -> Option<Vec<Vec<f64>>> {
        /// What rounding may leave of the differences of eighth order, in parts of the function.
        const ROUNDING: f64 = 2048.0 * f64::EPSILON;
        let place = |of: Of| match of {
            Of::Function {
                asked, function, ..
            } => Some((asked, function)),
            _ => None,
        };
        let mut used: Vec<_> = self
            .columns
            .iter()
            .filter_map(|column| place(column.of))
            .collect();
        used.sort_unstable();
        used.dedup();
        let ends = used.iter().map(|&(question, function)| {
            let asked = &asked[question];
            let functions = asked.at(scene, Precision::Double, &[]).ok()?;
            let function = &functions.functions()[function];
            Some(Asked {
                from: vec![function.from().to_owned()],
                to: vec![function.to().to_owned()],
                quantity: asked.quantity,
            })
        });
        let ends: Vec<Asked> = ends.collect::<Option<_>>()?;
        let adjoints = ends.iter().map(|one| {
            let transfer = one.transfer(scene)?;
            at.iter()
                .map(|frequency| transfer.adjoint(*frequency))
                .collect()
        });
        let adjoints_of: Vec<Vec<Adjoint>> = adjoints.collect::<Option<_>>()?;
        let least = self.each(|of, k| {
            let adjoints = place(of).and_then(|place| used.binary_search(&place).ok());
            Ok(adjoints.map(|at| ROUNDING * adjoints_of[at][k].value().norm()))
        });
        let columns = varied.derivatives(values, None, &|other| {
            let slopes = ends.iter().zip(&adjoints_of).map(|(one, adjoints)| {
                let transfer = one.transfer(other)?;
                let along = adjoints.iter().map(|adjoint| adjoint.along(&transfer));
                Some(along.collect::<Vec<_>>())
            });
            let slopes = slopes.collect::<Option<Vec<_>>>()?;
            let each = self.each_value(|asked, function, k| {
                Some(slopes[used.binary_search(&(asked, function)).ok()?][k])
            });
            each.ok()
        });
        Some(cleared(columns?, values, &least.ok()?))
    }

    fn of_tangents(
        &self,
        varied: &Varied,
        values: &[f64],
        scene: &Scene,
        instants: &[u64],
        outputs: &[Combination],
    ) -> Option<Vec<Vec<f64>>> {
        let here = question(scene, Precision::Double, instants, outputs).ok()?;
        let rates = varied.derivatives(values, None, &|other| {
            let there = question(other, Precision::Double, instants, outputs).ok()?;
            numbers_beside(&here, &there)
        })?;
        let each = rates.iter().map(|rates| {
            let system = here.tangent_system(rates).ok()?;
            let slopes = |precision: Precision| {
                let problem = here.tangent(&system, rates).to(precision);
                let trajectory = ResponsePlan::of(&problem).ok()?.run(&problem).ok()?;
                let bounded = self.each(|of, k| {
                    let Of::Output(output) = of else {
                        return Ok(None);
                    };
                    let bound = trajectory.output_bound(output)[k];
                    let bound = bound.filter(|_| !trajectory.is_doubtful(k));
                    Ok(bound.map(|bound| (trajectory.output(output)[k], bound)))
                });
                bounded.ok()
            };
            let quick = slopes(Precision::Double);
            let is_good = quick.as_ref().is_some_and(|slopes| self.is_good(slopes));
            let found = match is_good {
                true => quick,
                false => slopes(Precision::default()).or(quick),
            };
            // What lies within its bound is not shown to be any dependence.
            let each = found?.into_iter();
            let each = each.map(|(slope, bound)| if slope.abs() <= bound { 0.0 } else { slope });
            Some(each.collect())
        });
        each.collect()
    }

    /// Whether derivatives, with their bounds, are known to as many digits as a fit needs to tell parameters apart.
    fn is_good(&self, slopes: &[(f64, f64)]) -> bool {
        const ENOUGH: f64 = 1e-9;
        let entries = self.columns.iter().flat_map(|column| &column.entries);
        let (mut size, mut off) = (0f64, 0f64);
        for (entry, (slope, bound)) in entries.zip(slopes) {
            let weight = entry.per_model(false);
            size = size.hypot(slope * weight);
            off = off.hypot(bound * weight);
        }
        off <= ENOUGH * size
    }

    fn each<T>(
        &self,
        value: impl Fn(Of, usize) -> Result<Option<T>, String>,
    ) -> Result<Vec<T>, Lack> {
        let all = self.columns.iter();
        let all = all.flat_map(|column| {
            let each = column.entries.iter();
            each.map(|entry| {
                value(column.of, entry.at)?.ok_or_else(|| {
                    Lack::Number(format!(
                        "the scene gives no good number in place of {:?} in column {:?}, line {} of the measurements",
                        entry.value, column.name, entry.line
                    ))
                })
            })
        });
        all.collect()
    }

    fn of_modes(&self, scene: &Scene, precision: Precision) -> Result<Vec<f64>, Lack> {
        let modes = scene.system().modes_to(precision);
        let modes = modes.map_err(|error| error.to_string())?;
        let all: Vec<_> = modes.into_iter().collect();
        self.each(|of, at| {
            let Some(mode) = all.get(at) else {
                let count = all.len();
                return Err(format!(
                    "mode {} was measured, but there are only {count}",
                    at + 1
                ));
            };
            let root = mode.eigenvalue();
            if root.is_doubtful() {
                return Ok(None);
            }
            Ok(match of {
                Of::Natural(unit) => Some(mode.natural_frequency().radians_per_second() / unit),
                Of::Damped(unit) => Some(root.value.im.abs() / unit),
                Of::Ratio => mode.damping_ratio(),
                _ => None,
            })
        })
    }

    fn of_functions(
        &self,
        scene: &Scene,
        precision: Precision,
        at: &[f64],
        asked: &[Asked],
    ) -> Result<Vec<f64>, Lack> {
        let all: Vec<FrequencyFunctions> = asked
            .iter()
            .map(|one| one.at(scene, precision, at))
            .collect::<Result<_, _>>()?;
        self.each_value(|asked, function, k| {
            let value = all[asked].functions()[function].values()[k].known();
            value.map(|(value, _)| value)
        })
    }

    /// Real or imaginary parts, as they were measured, of what functions have at frequencies.
    fn each_value(
        &self,
        value: impl Fn(usize, usize, usize) -> Option<Complex<f64>>,
    ) -> Result<Vec<f64>, Lack> {
        self.each(|of, k| {
            let Of::Function {
                asked,
                function,
                is_imaginary,
            } = of
            else {
                return Ok(None);
            };
            let value = value(asked, function, k);
            Ok(value.map(|value| if is_imaginary { value.im } else { value.re }))
        })
    }

    fn of_motion(
        &self,
        scene: &Scene,
        precision: Precision,
        instants: &[u64],
        outputs: &[Combination],
    ) -> Result<Vec<f64>, Lack> {
        let problem = question(scene, precision, instants, outputs)?;
        let plan = ResponsePlan::of(&problem).map_err(|error| error.to_string())?;
        let trajectory = plan.run(&problem).map_err(|error| error.to_string())?;
        self.each(|of, k| {
            let Of::Output(output) = of else {
                return Ok(None);
            };
            let value = trajectory.output(output)[k];
            Ok((!trajectory.is_doubtful(k)).then_some(value))
        })
    }
}

/// Derivatives by some numbers: those by which a change of such a number by all of itself shows no more than the least are 0.
fn cleared(mut columns: Vec<Vec<f64>>, numbers: &[f64], least: &[f64]) -> Vec<Vec<f64>> {
    for (column, number) in columns.iter_mut().zip(numbers) {
        for (slope, least) in column.iter_mut().zip(least) {
            if (*slope * number).abs() <= *least {
                *slope = 0.0;
            }
        }
    }
    columns
}

/// The motion that gives these outputs at these instants.
fn question<'s>(
    scene: &'s Scene,
    precision: Precision,
    instants: &[u64],
    outputs: &[Combination],
) -> Result<Problem<'s>, String> {
    let problem = motion(scene)?.to(precision);
    let problem = problem.with_combinations(outputs.to_vec());
    let problem = problem.and_then(|problem| problem.at(instants));
    problem.map_err(|error| error.to_string())
}

impl Asked {
    fn at(
        &self,
        scene: &Scene,
        precision: Precision,
        frequencies: &[f64],
    ) -> Result<FrequencyFunctions, String> {
        let asked = asked(scene, &self.from, &self.to).quantity(self.quantity);
        let found = asked.precision(precision).at(frequencies);
        found.map_err(|error| error.to_string())
    }

    fn transfer(&self, scene: &Scene) -> Option<Transfer> {
        let asked = asked(scene, &self.from, &self.to).quantity(self.quantity);
        asked.transfer().ok()?
    }
}

/// Reads columns of which something is known, with their deviations; the others are left out.
struct Reader<'a> {
    table: &'a Table,
    used: Vec<usize>,
    columns: Vec<Column>,
}

impl<'a> Reader<'a> {
    /// `index` has what the rows are of.
    fn new(table: &'a Table, index: Option<usize>) -> Reader<'a> {
        Reader {
            table,
            used: index.into_iter().collect(),
            columns: Vec::new(),
        }
    }

    /// Adds a column: `rows` has of each row its mode, frequency or instant.
    fn add(&mut self, column: usize, of: Of, rows: &[usize]) -> Result<(), RecordError> {
        let names = self.table.names();
        let name = names[column].clone();
        let deviations = names
            .iter()
            .position(|other| other.strip_prefix(DEVIATION) == Some(&name));
        self.used.push(column);
        self.used.extend(deviations);
        let values = self.table.column(column)?;
        let deviations = deviations.map(|at| self.table.column(at)).transpose()?;
        let mut entries = Vec::new();
        for (row, (line, value)) in values.into_iter().enumerate() {
            let Some(value) = value else { continue };
            let deviation = deviations.as_ref().map(|all| all[row].1);
            let deviation = match deviation {
                None => None,
                Some(Some(deviation)) if deviation > 0.0 => Some(deviation),
                Some(_) => {
                    let problem =
                        format!("{DEVIATION}{name}: a standard deviation must be greater than 0");
                    return Err(self.table.refuse(line, problem));
                }
            };
            entries.push(Entry {
                line,
                value,
                deviation,
                scale: 1.0,
                size: 1.0,
                at: rows[row],
            });
        }
        self.columns.push(Column { name, of, entries });
        Ok(())
    }

    fn finish(mut self, source: Source, known: &[String]) -> Result<Measured, Unfit> {
        let names = self.table.names();
        self.columns.retain(|column| !column.entries.is_empty());
        let Some(first) = self.columns.first() else {
            let rest = names
                .iter()
                .enumerate()
                .find(|(i, _)| !self.used.contains(i));
            let hint = match rest {
                Some((_, name)) => format!("{name:?} is none: {}", did_you_mean(name, known)),
                None => "the columns are empty".to_owned(),
            };
            let problem = format!("no column has measurements of this scene: {hint}");
            return Err(self.table.refuse(1, problem).into());
        };
        let has = |column: &Column| column.entries.iter().all(|entry| entry.deviation.is_some());
        if let Some(other) = self.columns.iter().find(|other| has(other) != has(first)) {
            let (with, without) = if has(first) {
                (first, other)
            } else {
                (other, first)
            };
            let problem = format!(
                "{:?} has standard deviations, and {:?} has none: give a column \"{DEVIATION}{}\" too, or no such column",
                with.name, without.name, without.name
            );
            return Err(self.table.refuse(1, problem).into());
        }
        let left_out = names
            .iter()
            .enumerate()
            .filter(|(i, _)| !self.used.contains(i));
        Ok(Measured {
            left_out: left_out.map(|(_, name)| name.clone()).collect(),
            columns: self.columns,
            source,
        })
    }
}

fn modes(table: &Table, scene: &Scene) -> Result<Measured, Unfit> {
    /// Several headers of one quantity: the first that is there is taken.
    const KNOWN: [&[(&str, Of)]; 2] = [
        &[
            ("natural_frequency [rad/s]", Of::Natural(1.0)),
            ("natural_frequency [Hz]", Of::Natural(TAU)),
            ("damped_frequency [rad/s]", Of::Damped(1.0)),
            ("damped_frequency [Hz]", Of::Damped(TAU)),
        ],
        &[("damping_ratio", Of::Ratio)],
    ];
    let names = table.names();
    let find = |name: &str| names.iter().position(|known| known == name);
    let index = find("mode");
    let numbered = index.map(|at| table.column(at)).transpose()?;
    // Where the scene has none at all, its own refusal says more.
    let solved = scene.system().modes_to(Precision::Double).ok();
    let count = solved.map_or(usize::MAX, |modes| modes.len());
    let mut reader = Reader::new(table, index);
    for headers in KNOWN {
        let found = headers
            .iter()
            .find_map(|(name, of)| Some((find(name)?, *of)));
        let Some((column, of)) = found else { continue };
        let rows = table.column(column)?;
        let mut places = Vec::new();
        for (row, (line, value)) in rows.iter().enumerate() {
            let number = numbered.as_ref().map(|all| all[row].1.unwrap_or(0.0));
            let place = match number {
                None => row,
                Some(number) if number >= 1.0 && number.fract() == 0.0 => number as usize - 1,
                Some(_) if value.is_none() => row,
                Some(_) => {
                    let problem =
                        "a mode is a whole number from 1 on: its place in the order of frequencies";
                    return Err(table.refuse(*line, problem.to_owned()).into());
                }
            };
            places.push(place);
        }
        reader.add(column, of, &places)?;
        let entries = reader.columns.last_mut().into_iter();
        for entry in entries.flat_map(|column| &mut column.entries) {
            if entry.at >= count {
                let place = entry.at + 1;
                let problem = format!("this is mode {place}, and the scene has {count}");
                return Err(table.refuse(entry.line, problem).into());
            }
            let problem = match of {
                Of::Ratio if entry.value.abs() > 1.0 => {
                    "a damping ratio is −Re λ/|λ|, a number from -1 to 1: 0.02 for two percent"
                }
                Of::Natural(_) | Of::Damped(_) if entry.value < 0.0 => {
                    "a frequency is a number from 0 on"
                }
                _ => {
                    let size = entry.value.abs();
                    entry.scale = if size > 0.0 { size } else { 1.0 };
                    continue;
                }
            };
            return Err(table.refuse(entry.line, problem.to_owned()).into());
        }
    }
    let known = KNOWN
        .iter()
        .flat_map(|headers| headers.iter().map(|(name, _)| name));
    let known = ["time [s]", "frequency [rad/s]", "frequency [Hz]"]
        .iter()
        .chain(known);
    let known: Vec<String> = known.map(|name| (*name).to_owned()).collect();
    reader.finish(Source::Modes, &known)
}

fn frequencies(table: &Table, scene: &Scene, index: usize, unit: f64) -> Result<Measured, Unfit> {
    let names = table.names();
    let mut at = Vec::new();
    for (line, value) in table.column(index)? {
        match value {
            Some(value) if value >= 0.0 => at.push(value * unit),
            _ => {
                let problem = "each row needs its frequency, a number from 0 on".to_owned();
                return Err(table.refuse(line, problem).into());
            }
        }
    }
    // The ends of all functions, by the arrow between them.
    let (mut from, mut to) = (Vec::new(), Vec::new());
    for name in names.iter().filter(|name| !name.starts_with(DEVIATION)) {
        let Some((first, rest)) = name.split_once(" → ") else {
            continue;
        };
        let parts = [" re", " im"]
            .iter()
            .filter_map(|part| Some(&rest[..rest.rfind(part)?]));
        let first = first
            .strip_prefix('\'')
            .filter(|_| !is_end(scene, first))
            .unwrap_or(first);
        for second in parts.filter(|second| is_end(scene, first) && is_to(scene, second)) {
            let push = |list: &mut Vec<String>, name: &str| {
                if !list.iter().any(|known| known == name) {
                    list.push(name.to_owned());
                }
            };
            push(&mut from, first);
            push(&mut to, second);
        }
    }
    let mut reader = Reader::new(table, Some(index));
    reader
        .used
        .extend(names.iter().position(|name| name == "frequency [Hz]"));
    let mut questions = Vec::new();
    let mut known = Vec::new();
    let rows: Vec<usize> = (0..at.len()).collect();
    for quantity in [
        Quantity::Displacement,
        Quantity::Velocity,
        Quantity::Acceleration,
    ] {
        let asked = Asked {
            from: from.clone(),
            to: to.clone(),
            quantity,
        };
        if from.is_empty() || at.is_empty() {
            continue;
        }
        let functions = asked
            .at(scene, Precision::Double, &at[..1])
            .map_err(Unfit::Scene)?;
        let report = FrequencyReport {
            title: "",
            system: scene.system(),
            outputs: scene.outputs(),
            functions: &functions,
            features: None,
        };
        let headers = report.headers();
        let mut is_used = false;
        for (k, header) in headers.iter().enumerate().filter(|(k, _)| k % 3 < 2) {
            let column = names.iter().position(|name| name == header);
            // Outputs are the same whatever is asked of masses.
            let Some(column) = column.filter(|column| !reader.used.contains(column)) else {
                continue;
            };
            is_used = true;
            let of = Of::Function {
                asked: questions.len(),
                function: k / 3,
                is_imaginary: k % 3 == 1,
            };
            reader.add(column, of, &rows)?;
        }
        known.extend(headers);
        if is_used {
            questions.push(asked);
        }
    }
    if known.is_empty() {
        let system = scene.system();
        let name = system.names().first().map_or("m", String::as_str);
        known.push(format!("{name} → {name} re [m/N]"));
    }
    share_scales(&mut reader.columns, |of| match of {
        Of::Function {
            asked, function, ..
        } => (asked, function),
        _ => (0, 0),
    });
    let source = Source::Frequencies {
        at,
        asked: questions,
    };
    reader.finish(source, &known)
}

fn motions(table: &Table, scene: &Scene, index: usize) -> Result<Measured, Unfit> {
    /// How far a time may be from an instant, in parts of the step.
    const NEAR: f64 = 1e-6;
    let problem = motion(scene).map_err(Unfit::Scene)?;
    let grid = *problem.grid();
    let mut instants = Vec::new();
    for (line, time) in table.column(index)? {
        let refuse = |problem: String| Err(Unfit::from(table.refuse(line, problem)));
        let Some(time) = time else {
            return refuse("each row needs its time".to_owned());
        };
        let (step, end) = (grid.step(), grid.last() as f64 * grid.step());
        let k = (time / step).round();
        if !(0.0..=grid.last() as f64).contains(&k) {
            return refuse(format!(
                "{time:?} s is not between 0 and {end:?} s, the `time.end` of the scene"
            ));
        }
        if (time / step - k).abs() > NEAR {
            return refuse(format!(
                "{time:?} s is no multiple of {step:?} s, the `time.step` of the scene: give it the step of the measurements"
            ));
        }
        instants.push(k as u64);
    }
    let rows: Vec<usize> = (0..instants.len()).collect();
    let all = motion_columns(scene.system(), scene.outputs());
    let mut reader = Reader::new(table, Some(index));
    let mut outputs = Vec::new();
    for (header, combination) in &all {
        let column = table.names().iter().position(|name| name == header);
        if let Some(column) = column {
            reader.add(column, Of::Output(outputs.len()), &rows)?;
            outputs.push(combination.clone());
        }
    }
    share_scales(&mut reader.columns, |of| match of {
        Of::Output(output) => (output, 0),
        _ => (0, 0),
    });
    let known: Vec<String> = all.into_iter().map(|(header, _)| header).collect();
    reader.finish(Source::Motion { instants, outputs }, &known)
}

/// Measurements without deviations are in parts of the root mean square of all that are of one kind.
fn share_scales(columns: &mut [Column], kind: impl Fn(Of) -> (usize, usize)) {
    let mut sizes: BTreeMap<((usize, usize), usize), f64> = BTreeMap::new();
    let mut kinds: BTreeMap<(usize, usize), (f64, usize)> = BTreeMap::new();
    for column in &*columns {
        let own = kind(column.of);
        for entry in &column.entries {
            let size = sizes.entry((own, entry.line)).or_default();
            *size = size.hypot(entry.value);
            let (all, count) = kinds.entry(own).or_default();
            (*all, *count) = (all.hypot(entry.value), *count + 1);
        }
    }
    let or = |size: f64, other: f64| if size > 0.0 { size } else { other };
    for column in columns {
        let own = kind(column.of);
        let (all, count) = kinds.get(&own).copied().unwrap_or_default();
        let scale = or(all / (count as f64).sqrt(), 1.0);
        for entry in &mut column.entries {
            let size = sizes.get(&(own, entry.line)).copied();
            entry.scale = scale;
            entry.size = or(size.unwrap_or_default(), scale);
        }
    }
}
