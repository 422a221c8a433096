//! Designs between the bests of two metrics, as a table, as JSON, as CSV and as a curve.

use std::io::{self, Write};

use serde_json::{Map, Value, json};

use super::axis::Axis;
use super::csv;
use super::number;
use super::plot::{Line, Plot};
use super::table::{Align, Table};

/// A design on the front of two metrics.
#[derive(Clone, Debug)]
pub struct FrontDesign {
    /// The values that vary.
    pub parameters: Vec<f64>,
    /// Both metrics.
    pub metrics: [f64; 2],
    /// Whether derivatives show that neither metric can be better nearby without the other being worse.
    pub is_shown: bool,
}

/// Prints the front of two metrics.
#[derive(Clone, Copy, Debug)]
pub struct FrontReport<'a> {
    /// What stands above the plot.
    pub title: &'a str,
    /// The names of what varies.
    pub parameters: &'a [&'a str],
    /// The names of the metrics.
    pub metrics: [&'a str; 2],
    /// Their units, empty where one is not known.
    pub units: [&'a str; 2],
    /// The designs, from the best of the first metric to that of the second.
    pub designs: &'a [FrontDesign],
}

impl<'a> FrontReport<'a> {
    fn columns(&self) -> impl Iterator<Item = (&'a str, Vec<f64>)> {
        let designs = self.designs;
        let metrics = (0..2).map(move |k| designs.iter().map(move |one| one.metrics[k]).collect());
        let count = self.parameters.len();
        let parameters =
            (0..count).map(move |k| designs.iter().map(move |one| one.parameters[k]).collect());
        let names = self
            .metrics
            .into_iter()
            .chain(self.parameters.iter().copied());
        names.zip(metrics.chain(parameters))
    }

    /// A table with six significant digits, a row for each design.
    pub fn text(&self) -> String {
        let mut table = Table::default();
        for (name, values) in self.columns() {
            table = table.column(
                name,
                Align::Right,
                values.into_iter().map(number::significant),
            );
        }
        let marks = self
            .designs
            .iter()
            .map(|one| if one.is_shown { "" } else { "?" });
        let mut text = table.column("", Align::Left, marks).text();
        let open = self.designs.iter().filter(|one| !one.is_shown).count();
        if open > 0 {
            text += "?: the best found; derivatives do not show that no better one is near\n";
        }
        if self.designs.len() == 1 {
            text += "this design is the best for both\n";
        }
        text
    }

    /// One object with the list `front`: parameters, metrics and `local_optimum` of each design.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn json(&self, mut out: impl Write) -> io::Result<()> {
        let object = |names: &[&str], values: &[f64]| -> Map<String, Value> {
            let entries = names.iter().zip(values);
            entries
                .map(|(name, value)| ((*name).to_owned(), Value::from(*value)))
                .collect()
        };
        let designs: Vec<Value> = self
            .designs
            .iter()
            .map(|one| {
                json!({
                    "parameters": object(self.parameters, &one.parameters),
                    "metrics": object(&self.metrics, &one.metrics),
                    "local_optimum": one.is_shown,
                })
            })
            .collect();
        writeln!(out, "{}", json!({ "front": designs }))
    }

    /// A row for each design with all digits: both metrics, the parameters, and whether it is shown to be a local optimum.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn csv(&self, mut out: impl Write) -> io::Result<()> {
        let columns: Vec<(&str, Vec<f64>)> = self.columns().collect();
        let header = columns.iter().map(|(name, _)| (*name).to_owned());
        csv::row(&mut out, header.chain(["local_optimum".to_owned()]))?;
        for (row, one) in self.designs.iter().enumerate() {
            let values = columns.iter().map(|(_, values)| csv::number(values[row]));
            csv::row(&mut out, values.chain([one.is_shown.to_string()]))?;
        }
        Ok(())
    }

    /// The second metric against the first.
    pub fn plot(&self) -> Plot<'a> {
        let designs = self.designs;
        let [x, y] = self.metrics;
        let point = move |k: usize| (designs[k].metrics[0], designs[k].metrics[1]);
        Plot {
            title: format!("{}: {y} against {x}", self.title),
            x: Axis::linear(x, self.units[0]),
            y: Axis::linear(y, self.units[1]),
            lines: vec![Line::new("Pareto front", designs.len(), point).marked()],
            ring: None,
        }
    }
}
