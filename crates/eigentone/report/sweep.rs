//! The designs of a sweep as CSV and plots.

use std::io::{self, Write};

use super::axis::Axis;
use super::csv;
use super::plot::{Line, Plot};

/// One design of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct SweptDesign {
    /// Its index among all designs.
    pub index: u64,
    /// The values of what varies.
    pub values: Vec<f64>,
    /// The metrics; `None` where one is infinite or not known.
    pub metrics: Vec<Option<f64>>,
    /// Re λ and Im λ of each root at its place.
    pub roots: Vec<[f64; 2]>,
    /// Whether the places of the roots are a choice.
    pub is_doubtful: bool,
}

/// Designs in the order of their indices.
#[derive(Clone, Copy, Debug)]
pub struct SweepReport<'a> {
    /// What stands above the plots.
    pub title: &'a str,
    /// What varies, the last first.
    pub parameters: &'a [&'a str],
    /// What is told of each design.
    pub metrics: &'a [&'a str],
    /// The designs.
    pub designs: &'a [SweptDesign],
}

impl SweepReport<'_> {
    /// A row for each design with all digits.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn csv(&self, mut out: &mut dyn Write) -> io::Result<()> {
        let places = self.designs.iter().map(|design| design.roots.len()).max();
        let names = self.parameters.iter().chain(self.metrics);
        let names = names.map(|name| csv::text(name).into_owned());
        let roots = (1..=places.unwrap_or(0)).flat_map(|k| [format!("re {k}"), format!("im {k}")]);
        let head = ["design".to_owned()].into_iter().chain(names).chain(roots);
        csv::row(&mut out, head.chain(["doubtful".to_owned()]))?;
        for design in self.designs {
            let values = design.values.iter().map(|value| csv::number(*value));
            let metrics = design.metrics.iter().map(|value| csv::optional(*value));
            let roots = design.roots.iter().flatten().map(|part| csv::number(*part));
            let cells = [design.index.to_string()].into_iter().chain(values);
            let cells = cells.chain(metrics).chain(roots);
            csv::row(&mut out, cells.chain([design.is_doubtful.to_string()]))?;
        }
        Ok(())
    }

    /// Name and plot of each metric, a curve for each design of all parameters but the last, and of the roots in the complex
    /// plane.
    pub fn plots(&self) -> Vec<(String, Plot<'_>)> {
        let families: Vec<&[SweptDesign]> = self
            .designs
            .chunk_by(|a, b| {
                let others = a.values.len().saturating_sub(1);
                a.values[..others] == b.values[..others]
            })
            .collect();
        let last = self.parameters.last().copied().unwrap_or_default();
        let mut plots = Vec::new();
        for (k, metric) in self.metrics.iter().enumerate() {
            let lines = families.iter().map(|family| {
                let others = self.parameters.iter().zip(&family[0].values);
                let others = others.take(self.parameters.len().saturating_sub(1));
                let others: Vec<String> = others.map(|(_, value)| format!("{value}")).collect();
                let name = match others.is_empty() {
                    true => (*metric).to_owned(),
                    false => others.join(", "),
                };
                let family = *family;
                Line::new(&name, family.len(), move |i| {
                    let value = family[i].values.last().copied().unwrap_or(f64::NAN);
                    (value, family[i].metrics[k].unwrap_or(f64::NAN))
                })
            });
            let plot = Plot {
                title: format!("{}: {metric}", self.title),
                x: Axis::linear(last, ""),
                y: Axis::linear(metric, ""),
                lines: lines.collect(),
                ring: None,
            };
            plots.push((format!("metric-{}.svg", k + 1), plot));
        }
        let places = self.designs.iter().map(|design| design.roots.len()).max();
        let lines = (0..places.unwrap_or(0)).map(|k| {
            let line = Line::new(&format!("root {}", k + 1), self.designs.len(), move |i| {
                let root = self.designs[i].roots.get(k);
                root.map_or((f64::NAN, f64::NAN), |root| (root[0], root[1]))
            });
            line.dots()
        });
        let plot = Plot {
            title: format!("{}: roots", self.title),
            x: Axis::linear("Re λ", "1/s"),
            y: Axis::linear("Im λ", "rad/s"),
            lines: lines.collect(),
            ring: None,
        };
        plots.push(("roots.svg".to_owned(), plot));
        plots
    }
}
