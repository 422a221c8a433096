//! `eigentone spectrum RECORD --step h [--ratio …] [--from …] [--to …] [--count …] [--column …] [--hold …] [--json] [--out DIR]`.

use std::path::PathBuf;

use clap::Args;
use eigentone::report::SpectrumReport;
use eigentone::response::{Baseline, ResponseSpectrum, Samples};
use eigentone::scene::read_record;

use super::files::Files;
use super::form::Form;
use super::progress::Progress;
use super::{Accuracy, Failure, Hold, positive};

/// Prints the response spectrum of an acceleration record
#[derive(Debug, Args)]
pub struct Spectrum {
    /// A text file with a column of accelerations, in m/s²
    record: PathBuf,
    /// Time between the samples, in s
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    step: f64,
    /// Damping ratio of the one-mass systems
    #[arg(long, value_name = "RATIO", value_parser = ratio, default_value_t = 0.05)]
    ratio: f64,
    /// The lowest frequency, in Hz
    #[arg(long, value_name = "HZ", value_parser = positive, default_value_t = 0.1)]
    from: f64,
    /// The highest frequency, in Hz
    #[arg(long, value_name = "HZ", value_parser = positive, default_value_t = 50.0)]
    to: f64,
    /// How many frequencies, in equal ratios
    #[arg(long, value_name = "COUNT", value_parser = super::whole(1..=1_000_000), default_value_t = 200)]
    count: u32,
    /// The column of accelerations: its name in the first line, or its number, from 1 on [default: the only one]
    #[arg(long, value_name = "COLUMN")]
    column: Option<String>,
    /// Between samples: keep the value (zero), or a straight line to the next (first)
    #[arg(long, value_enum, default_value_t = Hold::First)]
    hold: Hold,
    #[command(flatten)]
    accuracy: Accuracy,
    #[command(flatten)]
    form: Form,
    /// Write data and plots into this directory, replacing files of the same names
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Spectrum {
    pub fn run(self) -> Result<(), Failure> {
        let precision = self.accuracy.precision()?;
        if self.count > 1 && self.from >= self.to {
            let (from, to) = (self.from, self.to);
            return Err(Failure::Frequencies { from, to });
        }
        let values = read_record(&self.record, self.column.as_deref())?;
        let failure = |error| Failure::Spectrum {
            record: self.record.clone(),
            error,
        };
        let record = Samples {
            step: self.step,
            values,
            hold: self.hold.into(),
        };
        let baseline = Baseline::of(&record).map_err(failure)?;
        let progress = Progress::of("response spectrum");
        let spectrum = ResponseSpectrum::of(record, self.ratio, &self.frequencies(), precision);
        let spectrum = spectrum.map_err(failure)?;
        drop(progress);
        let name = self.record.file_stem().unwrap_or(self.record.as_os_str());
        let report = SpectrumReport {
            title: &name.to_string_lossy(),
            spectrum: &spectrum,
            baseline: &baseline,
        };
        if let Some(directory) = &self.out {
            let mut files = Files::into(directory)?.beside(&self.record);
            files.write("spectrum.json", |out| report.json(out))?;
            files.write("spectrum.csv", |out| report.csv(out))?;
            for (name, plot) in report.plots() {
                files.write(name, |out| out.write_all(plot.svg().as_bytes()))?;
            }
            files.keep()?;
        }
        self.form.print(
            |out| report.json(out),
            |out| report.csv(out),
            |out| out.write_all(report.text().as_bytes()),
        )
    }

    /// From the lowest to the highest, both exactly.
    fn frequencies(&self) -> Vec<f64> {
        let last = self.count - 1;
        let at = |k: u32| match k {
            0 => self.from,
            k if k == last => self.to,
            k => {
                let part = f64::from(k) / f64::from(last);
                self.from * (part * (self.to.ln() - self.from.ln())).exp()
            }
        };
        (0..self.count).map(at).collect()
    }
}

fn ratio(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err("it must be a finite number, 0 or more".to_owned()),
    }
}
