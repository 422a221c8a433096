//! What is known of stationary motions, as a table, JSON, CSV and a plot.

use std::f64::consts::TAU;
use std::io::{self, Write};

use eigentone_modes::{Bounds, System};
use eigentone_response::{
    Combination, Quantity, Rms, SpectralDensity, StationaryMotion, Statistics,
};
use serde::{Serialize, Serializer};

use super::axis::Axis;
use super::plot::{Line, Plot};
use super::table::{Align, Table};
use super::{csv, number, unit};

/// Prints root mean squares, zero crossings, expected peaks and spectral densities.
#[derive(Clone, Copy, Debug)]
pub struct RandomReport<'a> {
    /// What stands above the plot.
    pub title: &'a str,
    /// What moves.
    pub system: &'a System,
    /// What was asked for beside the motions of coordinates and points, in the order of the answers.
    pub outputs: &'a [Combination],
    /// The answers.
    pub motion: &'a StationaryMotion,
    /// In s, if peaks are to be expected within some time.
    pub duration: Option<f64>,
}

/// One motion: which quantity of it, and its unit.
#[derive(Clone, Copy)]
struct Row<'a> {
    of: &'a Statistics,
    what: &'static str,
    unit: &'static str,
}

const QUANTITIES: [(&str, Quantity); 3] = [
    ("displacement", Quantity::Displacement),
    ("velocity", Quantity::Velocity),
    ("acceleration", Quantity::Acceleration),
];

/// As many curves as can be distinguished from each other.
const CURVES: usize = 8;

impl<'a> RandomReport<'a> {
    fn of(&self, quantity: Quantity) -> &'a [Statistics] {
        match quantity {
            Quantity::Displacement => self.motion.displacement(),
            Quantity::Velocity => self.motion.velocity(),
            Quantity::Acceleration => self.motion.acceleration(),
        }
    }

    fn rows(&self) -> Vec<Row<'a>> {
        let system = self.system;
        let motions = QUANTITIES.into_iter().flat_map(|(what, quantity)| {
            self.of(quantity).iter().map(move |of| Row {
                of,
                what,
                unit: unit::motion(system.kind_at(&of.name), quantity),
            })
        });
        let outputs = self.outputs.iter().zip(self.motion.outputs());
        let outputs = outputs.map(|(output, of)| Row {
            of,
            what: "output",
            unit: unit::output(system, output),
        });
        motions.chain(outputs).collect()
    }

    fn peak(&self, of: &Statistics) -> Option<(f64, f64)> {
        of.expected_peak(self.duration?)
    }

    /// A table, with how much of it is proven.
    pub fn text(&self) -> String {
        let rows = self.rows();
        let known = || rows.iter().map(|row| row.of.rms.finite());
        let bounds = known().map(|known| match known {
            Some((_, bound)) => number::bound(bound),
            None => number::NONE.to_owned(),
        });
        let crossings = rows.iter().map(|row| row.of.zero_crossings());
        let mut table = Table::default()
            .column("of", Align::Left, rows.iter().map(|row| &row.of.name))
            .column("what", Align::Left, rows.iter().map(|row| row.what))
            .column("r.m.s.", Align::Point, number::known_column(known()))
            .column("unit", Align::Left, rows.iter().map(|row| row.unit))
            .column("proven within", Align::Right, bounds)
            .column(
                "zero crossings, Hz",
                Align::Point,
                number::known_column(crossings),
            );
        let mut notes =
            "zero crossings: upwards, for noise that is Gaussian (Rice 1944)\n".to_owned();
        if let Some(duration) = self.duration {
            let peaks = rows.iter().map(|row| self.peak(row.of));
            let header = format!("peak in {} s", number::short(duration));
            table = table.column(&header, Align::Point, number::known_column(peaks));
            notes += "peak: the largest magnitude to be expected on average in that time (Davenport 1964)\n";
        }
        let reasons: Vec<String> = rows.iter().map(|row| reason(&row.of.rms)).collect();
        if reasons.iter().any(|reason| !reason.is_empty()) {
            table = table.column("why", Align::Left, &reasons);
        }
        table.text() + &notes
    }

    /// One JSON object; what is not finite is null, with a `reason`.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn json(&self, mut out: impl Write) -> io::Result<()> {
        let rms = |of: &Statistics| Some(Value::of(&of.rms));
        let crossings = |of: &Statistics| of.zero_crossings().map(Value::known);
        let peak = |of: &Statistics| self.peak(of).map(Value::known);
        let motion = self.motion;
        let json = Json {
            bounds: super::worth(Bounds::Proven),
            rms: Quantities::of(motion, &rms),
            zero_crossings: Quantities::of(motion, &crossings),
            expected_peak: self.duration.map(|duration| Peaks {
                duration,
                of: Quantities::of(motion, &peak),
            }),
        };
        serde_json::to_writer(&mut out, &json)?;
        writeln!(out)
    }

    /// A row for each motion, with all digits; empty cells for what is not finite or not known.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn csv(&self, mut out: impl Write) -> io::Result<()> {
        let headers = [
            "of",
            "what",
            "unit",
            "rms",
            "bound",
            "zero crossings [Hz]",
            "zero crossings bound [Hz]",
        ];
        let of_peaks = self.duration.map(|duration| {
            let header = format!("expected peak in {} s", number::short(duration));
            let bound = format!("{header} bound");
            [header, bound]
        });
        let headers = headers.map(str::to_owned).into_iter();
        let headers = headers.chain(of_peaks.iter().flatten().cloned());
        csv::row(&mut out, headers.chain(["reason".to_owned()]))?;
        for row in self.rows() {
            let cells = |known: Option<(f64, f64)>| {
                let (value, bound) = known.unzip();
                [csv::optional(value), csv::optional(bound)]
            };
            let name = row.of.name.clone();
            let first = [name, row.what.to_owned(), row.unit.to_owned()].into_iter();
            let numbers = cells(row.of.rms.finite())
                .into_iter()
                .chain(cells(row.of.zero_crossings()));
            let peaks = of_peaks.iter().flat_map(|_| cells(self.peak(row.of)));
            let all = first.chain(numbers).chain(peaks);
            csv::row(&mut out, all.chain([reason(&row.of.rms)]))?;
        }
        Ok(())
    }

    fn density_name(&self, density: &SpectralDensity) -> (String, String) {
        let (what, unit) = match density.quantity {
            Some(quantity) => {
                let found = QUANTITIES.into_iter().find(|(_, known)| *known == quantity);
                let what = found.map_or("", |(what, _)| what);
                let kind = self.system.kind_at(&density.name);
                (
                    format!("{} {what}", density.name),
                    unit::motion(kind, quantity),
                )
            }
            None => {
                let mut outputs = self.outputs.iter();
                let output = outputs.find(|output| output.name == density.name);
                let unit = output.map_or("", |output| unit::output(self.system, output));
                (density.name.clone(), unit)
            }
        };
        let unit = match unit {
            "" => String::new(),
            unit if unit.contains(['/', '·', '²']) => format!("({unit})²/Hz"),
            unit => format!("{unit}²/Hz"),
        };
        (what, unit)
    }

    /// A row for each of these frequencies in rad/s: the densities with their bounds.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn densities_csv(
        &self,
        mut out: impl Write,
        frequencies: &[f64],
        densities: &[SpectralDensity],
    ) -> io::Result<()> {
        let first = ["frequency [rad/s]".to_owned(), "frequency [Hz]".to_owned()];
        let headers = densities.iter().flat_map(|density| {
            let (name, unit) = self.density_name(density);
            ["", " bound"].map(|part| unit::bracketed(&format!("{name}{part}"), &unit))
        });
        csv::row(&mut out, first.into_iter().chain(headers))?;
        for (k, &frequency) in frequencies.iter().enumerate() {
            let first = [frequency, frequency / TAU].map(csv::number);
            let values = densities.iter().flat_map(|density| {
                let (value, bound) = density.values[k].unzip();
                [csv::optional(value), csv::optional(bound)]
            });
            csv::row(&mut out, first.into_iter().chain(values))?;
        }
        Ok(())
    }

    /// The densities of the outputs against frequency, or of displacements where none is asked for.
    pub fn plot(&self, frequencies: &'a [f64], densities: &'a [SpectralDensity]) -> Plot<'a> {
        let wanted = match self.outputs {
            [] => Some(Quantity::Displacement),
            _ => None,
        };
        let shown = densities
            .iter()
            .filter(|density| density.quantity == wanted);
        let shown: Vec<&SpectralDensity> = shown.take(CURVES).collect();
        let mut units: Vec<String> = shown.iter().map(|one| self.density_name(one).1).collect();
        let names = shown.iter().map(|one| self.density_name(one));
        units.dedup();
        let common = units.len() == 1;
        let lines = shown
            .iter()
            .copied()
            .zip(names)
            .map(|(density, (name, unit))| {
                let name = if common {
                    name
                } else {
                    unit::labelled(&name, &unit)
                };
                Line::new(&name, frequencies.len(), move |k| {
                    let value = density.values[k].map_or(f64::NAN, |(value, _)| value);
                    (
                        frequencies[k] / TAU,
                        if value > 0.0 { value } else { f64::NAN },
                    )
                })
            });
        Plot {
            title: format!("{}: spectral densities", self.title),
            x: Axis::logarithmic("frequency", "Hz"),
            y: Axis::logarithmic("S", if common { &units[0] } else { "" }),
            lines: lines.collect(),
            ring: None,
        }
    }
}

/// Why there is no number; nothing where there is one.
fn reason(rms: &Rms) -> String {
    match rms {
        Rms::Finite { .. } => String::new(),
        Rms::Infinite { by } => format!("infinite, by the noise in {by}"),
        Rms::Undecided { by } => format!("perhaps infinite, by the noise in {by}"),
    }
}

#[derive(Serialize)]
struct Json {
    bounds: &'static str,
    rms: Quantities,
    zero_crossings: Quantities,
    #[serde(skip_serializing_if = "Option::is_none")]
    expected_peak: Option<Peaks>,
}

#[derive(Serialize)]
struct Peaks {
    duration: f64,
    #[serde(flatten)]
    of: Quantities,
}

#[derive(Serialize)]
struct Quantities {
    displacement: Map,
    velocity: Map,
    acceleration: Map,
    outputs: Map,
}

impl Quantities {
    fn of(motion: &StationaryMotion, value: &dyn Fn(&Statistics) -> Option<Value>) -> Quantities {
        let map = |all: &[Statistics]| {
            let all = all.iter().map(|of| (of.name.clone(), value(of)));
            Map(all.collect())
        };
        Quantities {
            displacement: map(motion.displacement()),
            velocity: map(motion.velocity()),
            acceleration: map(motion.acceleration()),
            outputs: map(motion.outputs()),
        }
    }
}

/// By name, in the order of the scene.
struct Map(Vec<(String, Option<Value>)>);

impl Serialize for Map {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

#[derive(Serialize)]
struct Value {
    value: Option<f64>,
    bound: Option<f64>,
    #[serde(skip_serializing_if = "String::is_empty")]
    reason: String,
}

impl Value {
    fn of(rms: &Rms) -> Value {
        let (value, bound) = rms.finite().unzip();
        let reason = reason(rms);
        Value {
            value,
            bound,
            reason,
        }
    }

    fn known((value, bound): (f64, f64)) -> Value {
        Value {
            value: Some(value),
            bound: Some(bound),
            reason: String::new(),
        }
    }
}
