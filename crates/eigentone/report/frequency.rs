//! Frequency response functions as tables, JSON, CSV and plots.

use std::f64::consts::TAU;
use std::io::{self, Write};

use eigentone_modes::{Bounds, System};
use eigentone_response::{
    Asymptote, Combination, Features, FrequencyFunction, FrequencyFunctions, FrequencyMethod,
    FrequencyValue, LargestGain, Peak, Quantity,
};
use num_complex::Complex;
use serde::Serialize;

use super::axis::Axis;
use super::csv;
use super::number;
use super::plot::{Line, Plot};
use super::table::{Align, Table};
use super::unit::{self, Units};

/// Prints frequency response functions.
#[derive(Clone, Copy, Debug)]
pub struct FrequencyReport<'a> {
    /// What stands above the plots.
    pub title: &'a str,
    /// The system.
    pub system: &'a System,
    /// The outputs that may be among what is looked at.
    pub outputs: &'a [Combination],
    /// The functions.
    pub functions: &'a FrequencyFunctions,
    /// What is notable in each, if it was asked for.
    pub features: Option<&'a [Features]>,
}

const WIDTH: &str = "Ω → 0, Ω → ∞: the limit of |H|, to be multiplied by that power of Ω if one is given; width: between the frequencies of half power, |H|/√2, on both sides of a peak";
const INFINITE: &str = "∞: a peak without damping, or one narrower than 1e-25 of its frequency\n";
const UNKNOWN: &str = "∞: without damping, or too narrow for its height to be estimated\n";

/// Rows that a person reads.
const MANY: usize = 1000;

impl<'a> FrequencyReport<'a> {
    /// Peaks, dips and asymptotes of each function where they were asked for, else the value at each frequency.
    pub fn text(&self) -> String {
        let methods = self.methods();
        let lines = methods.iter().map(|(method, count)| {
            let frequencies = number::count(*count, "frequency", "frequencies");
            format!("{frequencies} by {method}\n")
        });
        match methods.as_slice() {
            // The usual way needs no words.
            [] | [(FrequencyMethod::Elimination | FrequencyMethod::Inverse, _)] => self.table(),
            _ => self.table() + &lines.collect::<String>(),
        }
    }

    /// How the values were found, and at how many frequencies.
    fn methods(&self) -> Vec<(FrequencyMethod, usize)> {
        let mut counts: Vec<(FrequencyMethod, usize)> = Vec::new();
        for method in self.functions.methods() {
            match counts.iter_mut().find(|(known, _)| known == method) {
                Some((_, count)) => *count += 1,
                None => counts.push((*method, 1)),
            }
        }
        counts
    }

    fn table(&self) -> String {
        match self.features {
            Some(features) => {
                let infinite = |peak: &Peak| peak.gain().is_none();
                let endless = features.iter().any(|one| one.peaks().iter().any(infinite));
                let more = match (endless, self.is_large()) {
                    (false, _) => "",
                    (true, false) => INFINITE,
                    (true, true) => UNKNOWN,
                };
                let (table, words) = (self.notable(features).text(), self.meaning());
                format!("{table}{words}\n{}\n{more}", self.completeness(features))
            }
            None if self.functions.frequencies().len() * self.functions.functions().len()
                > MANY =>
            {
                format!(
                    "{} at {}: for data take --json or --out DIR; for peaks name fewer outputs, with --to NAME\n",
                    number::count(self.functions.functions().len(), "function", "functions"),
                    number::count(
                        self.functions.frequencies().len(),
                        "frequency",
                        "frequencies"
                    ),
                )
            }
            None => self.values(),
        }
    }

    fn values(&self) -> String {
        let rows: Vec<(f64, &FrequencyFunction, FrequencyValue)> = self
            .functions
            .functions()
            .iter()
            .flat_map(|function| {
                let values = self.functions.frequencies().iter().zip(function.values());
                values.map(move |(&frequency, &value)| (frequency, function, value))
            })
            .collect();
        let known = || rows.iter().map(|(.., value)| value.known());
        let sizes = known().map(|known| known.map(|(value, _)| value.norm()));
        let phases = known().map(|known| {
            let (value, _) = known.filter(|(value, _)| value.norm() > 0.0)?;
            Some(value.arg().to_degrees())
        });
        let bounds = rows.iter().map(|(.., value)| match value {
            FrequencyValue::Known { bound, .. } => bound.map_or("–".to_owned(), number::bound),
            FrequencyValue::Pole => "pole".to_owned(),
            FrequencyValue::Undecided => "?".to_owned(),
        });
        let mut text = Table::default()
            .column(
                "Ω, rad/s",
                Align::Left,
                rows.iter().map(|row| number::significant(row.0)),
            )
            .column(
                "f, Hz",
                Align::Left,
                rows.iter().map(|row| number::significant(row.0 / TAU)),
            )
            .column("from", Align::Left, rows.iter().map(|row| row.1.from()))
            .column("to", Align::Left, rows.iter().map(|row| row.1.to()))
            .column("|H|", Align::Point, number::column(sizes))
            .column("unit", Align::Left, rows.iter().map(|row| self.unit(row.1)))
            .column("phase, °", Align::Point, number::column(phases))
            .column(
                match self.functions.bounds() {
                    Bounds::Proven => "proven within",
                    Bounds::Estimated => "estimated within",
                },
                Align::Right,
                bounds,
            )
            .text();
        let has = |one: FrequencyValue, at_0: bool| {
            let mut own = rows.iter().filter(|(.., value)| *value == one);
            own.any(|(frequency, ..)| (*frequency == 0.0) == at_0)
        };
        if has(FrequencyValue::Pole, false) {
            text += "pole: a natural frequency without damping, by proof; no steady motion exists there\n";
        }
        if has(FrequencyValue::Pole, true) {
            text += "pole at 0: infinite for Ω → 0, by proof\n";
        }
        if has(FrequencyValue::Undecided, false) {
            text +=
                "?: too near to a natural frequency without damping to decide whether it is one\n";
        }
        if has(FrequencyValue::Undecided, true) {
            text +=
                "? at 0: free to move, or nearly; not decided whether there is a limit for Ω → 0\n";
        }
        text
    }

    /// What the table of peaks and dips says.
    pub(super) fn meaning(&self) -> String {
        let known = if self.is_large() {
            "estimated"
        } else {
            "proven"
        };
        format!("|H| of peaks and dips is {known}; {WIDTH}")
    }

    /// Whether values and peaks come from sparse factors.
    fn is_large(&self) -> bool {
        let methods = self.functions.methods();
        methods.contains(&FrequencyMethod::SparseFactor)
    }

    /// Whether a peak is among the frequencies of the functions.
    pub(super) fn shows(&self, peak: &Peak) -> bool {
        let frequencies = self.functions.frequencies();
        let ends = frequencies.first().zip(frequencies.last());
        ends.is_some_and(|(first, last)| (*first..=*last).contains(&peak.frequency().0))
    }

    /// Of which functions the list of peaks and dips is proved to be complete, and the largest magnitude of these.
    pub(super) fn completeness(&self, features: &[Features]) -> String {
        let functions = self.functions.functions().iter().zip(features);
        let open: Vec<String> = functions
            .filter(|(_, features)| !features.is_complete())
            .map(|(function, _)| self.name(function))
            .collect();
        match open.as_slice() {
            [] => {
                "proven complete: no function has another peak or dip at any frequency".to_owned()
            }
            open if open.len() == features.len() => {
                "not proven complete: peaks and dips were searched for on a grid of frequencies only"
                    .to_owned()
            }
            open => format!(
                "proven complete but for {}: of these, peaks and dips were searched for on a grid of frequencies only",
                open.join(", ")
            ),
        }
    }

    /// Peaks, dips and asymptotes.
    pub(super) fn notable(&self, features: &[Features]) -> Table {
        /// What a row says: the function, what it is, where, how large, how wide.
        type Row<'a> = (
            &'a FrequencyFunction,
            String,
            Option<f64>,
            Option<(f64, f64)>,
            Option<f64>,
        );
        let mut rows: Vec<Row<'_>> = Vec::new();
        for (function, features) in self.functions.functions().iter().zip(features) {
            let tends = |word: &str, asymptote: Option<Asymptote>| {
                asymptote.map(|Asymptote { coefficient, power }| {
                    let law = match power {
                        0 => word.to_owned(),
                        power => format!("{word}, times Ω^{}", number::short(power.into())),
                    };
                    let gain = Some((coefficient, coefficient * f64::EPSILON));
                    (function, law, None, gain, None)
                })
            };
            rows.extend(tends("Ω → 0", features.low()));
            let row = |word: &str, peak: &Peak| {
                let frequency = Some(peak.frequency().0);
                let gain = peak.gain();
                (
                    function,
                    word.to_owned(),
                    frequency,
                    gain,
                    peak.relative_width(),
                )
            };
            let peaks = features.peaks().iter().map(|peak| row("peak", peak));
            let dips = features.dips().iter().map(|dip| row("dip", dip));
            let mut turns: Vec<Row<'_>> = peaks.chain(dips).collect();
            turns.sort_by(|a, b| a.2.partial_cmp(&b.2).unwrap_or(std::cmp::Ordering::Equal));
            rows.extend(turns);
            rows.extend(tends("Ω → ∞", features.high()));
        }
        let gains = rows.iter().map(|row| match (row.2, row.3) {
            (_, Some((gain, _))) => number::significant(gain),
            _ => "∞".to_owned(),
        });
        let hertz = |row: &Row<'_>| row.2.map(|frequency| frequency / TAU);
        Table::default()
            .column("from", Align::Left, rows.iter().map(|row| row.0.from()))
            .column("to", Align::Left, rows.iter().map(|row| row.0.to()))
            .column("what", Align::Left, rows.iter().map(|row| row.1.as_str()))
            .column(
                "Ω, rad/s",
                Align::Point,
                number::column(rows.iter().map(|row| row.2)),
            )
            .column(
                "f, Hz",
                Align::Point,
                number::column(rows.iter().map(hertz)),
            )
            .column("|H|", Align::Point, gains)
            .column("unit", Align::Left, rows.iter().map(|row| self.unit(row.0)))
            .column(
                "width/Ω",
                Align::Point,
                number::column(rows.iter().map(|row| row.4)),
            )
    }

    /// One JSON object: the frequencies in rad/s, and for each function real and imaginary parts with absolute bounds, null
    /// at poles. Where they were asked for, peaks and dips of each function.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn json(&self, mut out: impl Write) -> io::Result<()> {
        let functions = self.functions.functions().iter().enumerate();
        let functions = functions.map(|(index, function)| {
            let known = || function.values().iter().map(|value| value.known());
            let features = self.features.and_then(|features| features.get(index));
            let extremes = |peaks: &[Peak]| peaks.iter().map(PeakJson::of).collect::<Vec<_>>();
            FunctionJson {
                from: function.from(),
                to: function.to(),
                quantity: function.quantity().map_or("output", quantity_name),
                re: known().map(|known| Some(known?.0.re)).collect(),
                im: known().map(|known| Some(known?.0.im)).collect(),
                bound: known().map(|known| known?.1).collect(),
                peaks: features.map(|features| extremes(features.peaks())),
                dips: features.map(|features| extremes(features.dips())),
                complete: features.map(Features::is_complete),
                largest: features.map(|features| features.largest_gain().map(LargestJson::of)),
            }
        });
        let methods = self.methods().into_iter();
        let methods = methods.map(|(method, frequencies)| MethodJson {
            method: method.to_string(),
            frequencies,
        });
        let json = Json {
            bounds: super::worth(self.functions.bounds()),
            methods: methods.collect(),
            frequency: self.functions.frequencies(),
            functions: functions.collect(),
        };
        serde_json::to_writer(&mut out, &json)?;
        writeln!(out)
    }

    /// The headers that real part, imaginary part and bound of each function have in CSV: with the unit, or the quantity
    /// where it is not known and not a displacement.
    pub fn headers(&self) -> Vec<String> {
        let each = self.functions.functions().iter().flat_map(|function| {
            let (name, mut unit) = (self.name(function), self.unit(function));
            let others = function
                .quantity()
                .filter(|quantity| *quantity != Quantity::Displacement);
            if let (Some(quantity), true) = (others, unit.is_empty()) {
                unit = quantity_name(quantity).to_owned();
            }
            ["re", "im", "bound"].map(|part| {
                let header = unit::bracketed(&format!("{name} {part}"), &unit);
                csv::text(&header).into_owned()
            })
        });
        each.collect()
    }

    /// One row for each frequency with all digits: rad/s, Hz, then real part, imaginary part and bound of each function.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn csv(&self, mut out: impl Write) -> io::Result<()> {
        let functions = self.functions.functions();
        let first = ["frequency [rad/s]".to_owned(), "frequency [Hz]".to_owned()];
        csv::row(&mut out, first.into_iter().chain(self.headers()))?;
        for (k, &frequency) in self.functions.frequencies().iter().enumerate() {
            let first = [frequency, frequency / TAU].map(csv::number);
            let values = functions.iter().flat_map(|function| {
                let known = function.values()[k].known();
                let value = known.map(|(value, _)| value);
                let bound = known.and_then(|(_, bound)| bound);
                [
                    value.map(|value| value.re),
                    value.map(|value| value.im),
                    bound,
                ]
                .map(csv::optional)
            });
            csv::row(&mut out, first.into_iter().chain(values))?;
        }
        Ok(())
    }

    /// Plots by the names of their files: magnitude, phase, real and imaginary part against frequency, and the curve in the
    /// complex plane.
    pub fn plots(&self) -> Vec<(&'static str, Plot<'a>)> {
        let unit = self.common_unit();
        // Where functions differ in their units, each has its own, as no axis has one.
        let label = |function: &FrequencyFunction| match unit.as_str() {
            "" => unit::bracketed(&self.name(function), &self.unit(function)),
            _ => self.name(function),
        };
        let labels: Vec<String> = self.functions.functions().iter().map(label).collect();
        let plot = |what, y, part| self.plot(what, &labels, y, part);
        let size = |value: Complex<f64>| value.norm();
        let mut magnitude = plot("magnitude", Axis::logarithmic("|H|", &unit), size);
        let peaks = self
            .features
            .into_iter()
            .flatten()
            .flat_map(Features::peaks);
        let peaks: Vec<(f64, f64)> = peaks
            .filter(|peak| self.shows(peak))
            .filter_map(|peak| Some((peak.frequency().0 / TAU, peak.gain()?.0)))
            .collect();
        if !peaks.is_empty() {
            let line = Line::new("peaks", peaks.len(), move |k| peaks[k]);
            magnitude.lines.push(line.dots());
        }
        let frequencies = self.functions.frequencies();
        let phases = self.functions.functions().iter().map(|function| {
            let phases = unwrapped(function);
            Line::new(&self.name(function), frequencies.len(), move |k| {
                (frequencies[k] / TAU, phases[k])
            })
        });
        let phase = Plot {
            title: format!("{}: phase", self.title),
            x: hertz(),
            y: Axis::linear("phase", "°"),
            lines: phases.collect(),
            ring: None,
        };
        let curves = self.functions.functions().iter().zip(&labels);
        let curves = curves.map(|(function, label)| {
            Line::new(label, frequencies.len(), move |k| {
                let value = value(function, k);
                (value.re, value.im)
            })
        });
        let nyquist = Plot {
            title: format!("{}: complex plane", self.title),
            x: Axis::linear("real part", &unit),
            y: Axis::linear("imaginary part", &unit),
            lines: curves.collect(),
            ring: None,
        };
        let axis = |name: &str| Axis::linear(name, &unit);
        vec![
            ("frf-magnitude.svg", magnitude),
            ("frf-phase.svg", phase),
            (
                "frf-real.svg",
                plot("real part", axis("Re H"), |value| value.re),
            ),
            (
                "frf-imaginary.svg",
                plot("imaginary part", axis("Im H"), |value| value.im),
            ),
            ("frf-nyquist.svg", nyquist),
        ]
    }

    /// A part of each function against frequency.
    fn plot(
        &self,
        what: &str,
        labels: &[String],
        y: Axis,
        part: fn(Complex<f64>) -> f64,
    ) -> Plot<'a> {
        let frequencies = self.functions.frequencies();
        let lines = self.functions.functions().iter().zip(labels);
        let lines = lines.map(|(function, label)| {
            Line::new(label, frequencies.len(), move |k| {
                (frequencies[k] / TAU, part(value(function, k)))
            })
        });
        Plot {
            title: format!("{}: {what}", self.title),
            x: hertz(),
            y,
            lines: lines.collect(),
            ring: None,
        }
    }

    /// The unit that all functions have, or nothing.
    fn common_unit(&self) -> String {
        let mut units = self
            .functions
            .functions()
            .iter()
            .map(|function| self.unit(function));
        let first = units.next().unwrap_or_default();
        match units.all(|unit| unit == first) {
            true => first,
            false => String::new(),
        }
    }

    pub(super) fn name(&self, function: &FrequencyFunction) -> String {
        format!("{} → {}", function.from(), function.to())
    }

    /// Nothing where the unit of either end is not known.
    pub(super) fn unit(&self, function: &FrequencyFunction) -> String {
        let system = self.system;
        let output = match function.quantity() {
            Some(quantity) => unit::motion(system.kind_at(function.to()), quantity),
            None => {
                let mut outputs = self.outputs.iter();
                let asked = outputs.find(|output| output.name == function.to());
                asked.map_or("", |output| unit::output(system, output))
            }
        };
        let outputs = self.outputs;
        Units { system, outputs }.response(function.from(), output)
    }
}

fn hertz() -> Axis {
    Axis::logarithmic("frequency", "Hz")
}

fn value(function: &FrequencyFunction, k: usize) -> Complex<f64> {
    let known = function.values()[k].known();
    known.map_or(Complex::new(f64::NAN, f64::NAN), |(value, _)| value)
}

/// The phase in degrees, without jumps by whole turns between neighbours.
fn unwrapped(function: &FrequencyFunction) -> Vec<f64> {
    let mut last = 0.0;
    let phases = (0..function.values().len()).map(|k| {
        let phase = value(function, k).arg().to_degrees();
        if phase.is_finite() {
            last = phase - 360.0 * ((phase - last) / 360.0).round();
            return last;
        }
        f64::NAN
    });
    phases.collect()
}

fn quantity_name(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Displacement => "displacement",
        Quantity::Velocity => "velocity",
        Quantity::Acceleration => "acceleration",
    }
}

#[derive(Serialize)]
struct Json<'a> {
    bounds: &'static str,
    methods: Vec<MethodJson>,
    frequency: &'a [f64],
    functions: Vec<FunctionJson<'a>>,
}

#[derive(Serialize)]
struct MethodJson {
    method: String,
    frequencies: usize,
}

#[derive(Serialize)]
struct FunctionJson<'a> {
    from: &'a str,
    to: &'a str,
    quantity: &'static str,
    re: Vec<Option<f64>>,
    im: Vec<Option<f64>>,
    bound: Vec<Option<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    peaks: Option<Vec<PeakJson>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    dips: Option<Vec<PeakJson>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    complete: Option<bool>,
    /// null where it is not proved.
    #[serde(skip_serializing_if = "Option::is_none")]
    largest: Option<Option<LargestJson>>,
}

/// The largest magnitude: the frequency is null for Ω → ∞, gain and bound where it grows beyond all bounds.
#[derive(Serialize)]
struct LargestJson {
    frequency: Option<f64>,
    gain: Option<f64>,
    bound: Option<f64>,
}

impl LargestJson {
    fn of(largest: LargestGain) -> LargestJson {
        let (frequency, known) = match largest {
            LargestGain::Finite {
                frequency,
                gain,
                bound,
            } => (frequency, Some((gain, bound))),
            LargestGain::Unbounded { frequency } => (frequency, None),
        };
        LargestJson {
            frequency: Some(frequency).filter(|frequency| frequency.is_finite()),
            gain: known.map(|(gain, _)| gain),
            bound: known.map(|(_, bound)| bound),
        }
    }
}

#[derive(Serialize)]
struct PeakJson {
    frequency: f64,
    frequency_bound: f64,
    gain: Option<f64>,
    gain_bound: Option<f64>,
    half_power: Option<[f64; 2]>,
}

impl PeakJson {
    fn of(peak: &Peak) -> PeakJson {
        let (frequency, frequency_bound) = peak.frequency();
        PeakJson {
            frequency,
            frequency_bound,
            gain: peak.gain().map(|(gain, _)| gain),
            gain_bound: peak.gain().map(|(_, bound)| bound),
            half_power: peak.half_power(),
        }
    }
}
