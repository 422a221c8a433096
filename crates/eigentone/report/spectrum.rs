//! Response spectra as tables, JSON, CSV and plots.

use std::f64::consts::TAU;
use std::io::{self, Write};

use eigentone_modes::Bounds;
use eigentone_response::{Baseline, ResponseSpectrum, SpectralPeak};
use serde::Serialize;

use super::axis::Axis;
use super::csv;
use super::number;
use super::plot::{Line, Plot};
use super::table::{Align, Table};

/// Prints a response spectrum.
#[derive(Clone, Copy, Debug)]
pub struct SpectrumReport<'a> {
    /// What stands above the plots.
    pub title: &'a str,
    /// The spectrum.
    pub spectrum: &'a ResponseSpectrum,
    /// What the record leaves of the base.
    pub baseline: &'a Baseline,
}

impl<'a> SpectrumReport<'a> {
    /// What the record is like, then the spectrum, a row for each frequency.
    pub fn text(&self) -> String {
        let Baseline {
            duration,
            peak,
            peak_time,
            mean,
            velocity,
            displacement,
        } = self.baseline;
        let said = |value: &f64| number::significant(*value);
        let mut text = format!(
            "Record: {} s, largest acceleration {} m/s² at {} s, mean {} m/s²; the base ends with {} m/s at {} m.\n",
            said(duration),
            said(peak),
            said(peak_time),
            said(mean),
            said(velocity),
            said(displacement)
        );
        text += &format!(
            "Damping ratio {}.\n\n",
            number::short(self.spectrum.ratio())
        );
        let frequencies = self.spectrum.frequencies();
        let values = |peaks: &[SpectralPeak]| {
            let values = peaks.iter().map(|peak| Some(peak.value));
            number::column(values.collect::<Vec<_>>())
        };
        let times = self.spectrum.displacement().iter();
        text += &Table::default()
            .column(
                "f, Hz",
                Align::Point,
                number::column(frequencies.iter().map(|f| Some(*f))),
            )
            .column(
                "displacement, m",
                Align::Point,
                values(self.spectrum.displacement()),
            )
            .column(
                "at, s",
                Align::Point,
                number::column(times.map(|peak| Some(peak.time))),
            )
            .column(
                "pseudo-velocity, m/s",
                Align::Point,
                values(self.spectrum.pseudo_velocity()),
            )
            .column(
                "pseudo-acceleration, m/s²",
                Align::Point,
                values(self.spectrum.pseudo_acceleration()),
            )
            .column(
                "acceleration, m/s²",
                Align::Point,
                values(self.spectrum.acceleration()),
            )
            .text();
        let relative = |peak: &SpectralPeak| peak.bound / peak.value;
        let relative = self
            .quantities()
            .into_iter()
            .flat_map(|(_, peaks)| peaks.iter().map(relative));
        let worst = relative.filter(|off| off.is_finite()).fold(0.0, f64::max);
        text + &format!(
            "\nLargest values at any time, relative to the base but for the acceleration, which is absolute; each is proven within a relative error of {}.\n",
            number::bound(worst)
        )
    }

    fn quantities(&self) -> [(&'static str, &'a [SpectralPeak]); 4] {
        [
            ("displacement", self.spectrum.displacement()),
            ("pseudo_velocity", self.spectrum.pseudo_velocity()),
            ("pseudo_acceleration", self.spectrum.pseudo_acceleration()),
            ("acceleration", self.spectrum.acceleration()),
        ]
    }

    /// One JSON object: frequencies in Hz, and value, bound and time of each quantity.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn json(&self, mut out: impl Write) -> io::Result<()> {
        let [
            displacement,
            pseudo_velocity,
            pseudo_acceleration,
            acceleration,
        ] = self.quantities().map(|(_, peaks)| PeaksJson::of(peaks));
        let baseline = self.baseline;
        let json = Json {
            bounds: super::worth(Bounds::Proven),
            ratio: self.spectrum.ratio(),
            frequency: self.spectrum.frequencies(),
            displacement,
            pseudo_velocity,
            pseudo_acceleration,
            acceleration,
            record: RecordJson {
                duration: baseline.duration,
                peak: baseline.peak,
                peak_time: baseline.peak_time,
                mean: baseline.mean,
                final_velocity: baseline.velocity,
                final_displacement: baseline.displacement,
            },
        };
        serde_json::to_writer(&mut out, &json)?;
        writeln!(out)
    }

    /// One row for each frequency with all digits.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn csv(&self, mut out: impl Write) -> io::Result<()> {
        let units = ["m", "m/s", "m/s²", "m/s²"];
        let headers = self.quantities().into_iter().zip(units);
        let headers = headers.flat_map(|((name, _), unit)| {
            let name = name.replace('_', "-");
            [
                format!("{name} [{unit}]"),
                format!("{name} bound [{unit}]"),
                format!("{name} time [s]"),
                format!("{name} time bound [s]"),
            ]
        });
        let first = ["frequency [Hz]".to_owned()];
        csv::row(&mut out, first.into_iter().chain(headers))?;
        for (k, frequency) in self.spectrum.frequencies().iter().enumerate() {
            let values = self.quantities().into_iter().flat_map(|(_, peaks)| {
                let SpectralPeak {
                    value,
                    bound,
                    time,
                    time_bound,
                } = peaks[k];
                [Some(value), Some(bound), Some(time), time_bound].map(csv::optional)
            });
            csv::row(
                &mut out,
                [csv::number(*frequency)].into_iter().chain(values),
            )?;
        }
        Ok(())
    }

    /// Plots by the names of their files: accelerations, displacement, and pseudo-velocity over lines of equal displacement
    /// and acceleration.
    pub fn plots(&self) -> Vec<(&'static str, Plot<'a>)> {
        let frequencies = self.spectrum.frequencies();
        let line = |name: &str, peaks: &'a [SpectralPeak]| {
            Line::new(name, peaks.len(), move |k| (frequencies[k], peaks[k].value))
        };
        let plot = |what: &str, y: Axis, lines: Vec<Line<'a>>| Plot {
            title: format!(
                "{}: {what}, ζ = {}",
                self.title,
                number::short(self.spectrum.ratio())
            ),
            x: Axis::logarithmic("frequency", "Hz"),
            y,
            lines,
            ring: None,
        };
        let accelerations = vec![
            line("absolute", self.spectrum.acceleration()),
            line("pseudo", self.spectrum.pseudo_acceleration()),
        ];
        let displacement = vec![line("relative", self.spectrum.displacement())];
        let mut tripartite = vec![line("pseudo-velocity", self.spectrum.pseudo_velocity())];
        tripartite.extend(self.equal_lines("d", "m", 1));
        tripartite.extend(self.equal_lines("a", "m/s²", -1));
        vec![
            (
                "spectrum-acceleration.svg",
                plot(
                    "largest acceleration",
                    Axis::logarithmic("acceleration", "m/s²"),
                    accelerations,
                ),
            ),
            (
                "spectrum-displacement.svg",
                plot(
                    "largest displacement",
                    Axis::logarithmic("displacement", "m"),
                    displacement,
                ),
            ),
            (
                "spectrum-tripartite.svg",
                plot(
                    "response spectrum",
                    Axis::logarithmic("pseudo-velocity", "m/s"),
                    tripartite,
                ),
            ),
        ]
    }

    /// Lines on which v/ω (`power` 1) or vω (−1) is a power of ten, within what the pseudo-velocities span.
    fn equal_lines(&self, name: &str, unit: &str, power: i32) -> Vec<Line<'a>> {
        const MOST: usize = 8;
        let frequencies = self.spectrum.frequencies();
        let points = frequencies.iter().zip(self.spectrum.pseudo_velocity());
        let points = points.filter(|(_, peak)| peak.value > 0.0);
        let points: Vec<(f64, f64)> = points.map(|(f, peak)| (*f, peak.value)).collect();
        let least = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::INFINITY, f64::min);
        let most = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        let (left, right) = (
            least(&mut points.iter().map(|p| p.0)),
            most(&mut points.iter().map(|p| p.0)),
        );
        let (low, high) = (
            least(&mut points.iter().map(|p| p.1)),
            most(&mut points.iter().map(|p| p.1)),
        );
        let level = |(f, v): &(f64, f64)| v / (TAU * f).powi(power);
        let (first, last) = (
            least(&mut points.iter().map(level)),
            most(&mut points.iter().map(level)),
        );
        if !(first > 0.0 && last.is_finite()) {
            return Vec::new();
        }
        let decades = first.log10().ceil() as i32..=last.log10().floor() as i32;
        let lines = decades.take(MOST).filter_map(|decade| {
            let value = 10f64.powi(decade);
            let at = |f: f64| value * (TAU * f).powi(power);
            // Where it enters and leaves the span.
            let reach = |v: f64| (v / value).powi(power) / TAU;
            let (from, to) = match power {
                1 => (reach(low), reach(high)),
                _ => (reach(high), reach(low)),
            };
            let (from, to) = (left.max(from), right.min(to));
            (from < to).then(|| {
                let ends = [(from, at(from)), (to, at(to))];
                let name = format!("{name} = {} {unit}", number::short(value));
                Line::new(&name, 2, move |k| ends[k])
            })
        });
        lines.collect()
    }
}

#[derive(Serialize)]
struct Json<'a> {
    bounds: &'static str,
    ratio: f64,
    frequency: &'a [f64],
    displacement: PeaksJson,
    pseudo_velocity: PeaksJson,
    pseudo_acceleration: PeaksJson,
    acceleration: PeaksJson,
    record: RecordJson,
}

#[derive(Serialize)]
struct PeaksJson {
    value: Vec<f64>,
    bound: Vec<f64>,
    time: Vec<f64>,
    time_bound: Vec<Option<f64>>,
}

impl PeaksJson {
    fn of(peaks: &[SpectralPeak]) -> PeaksJson {
        let each = |part: fn(&SpectralPeak) -> f64| peaks.iter().map(part).collect();
        PeaksJson {
            value: each(|peak| peak.value),
            bound: each(|peak| peak.bound),
            time: each(|peak| peak.time),
            time_bound: peaks.iter().map(|peak| peak.time_bound).collect(),
        }
    }
}

#[derive(Serialize)]
struct RecordJson {
    duration: f64,
    peak: f64,
    peak_time: f64,
    mean: f64,
    final_velocity: f64,
    final_displacement: f64,
}
