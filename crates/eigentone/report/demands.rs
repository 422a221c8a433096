//! What a motion demands of a machine: accelerations of coordinates and forces in springs, dampers and switches, as CSV and
//! plots, and the peaks of these and of the outputs.

use std::collections::HashMap;
use std::io::{self, Write};

use eigentone_modes::{ElementKind, GivenElement};
use eigentone_response::{Extrema, Peaks, Problem, Quantity, Reached, Trajectory};
use eigentone_switching::{SwitchedMotion, SwitchedPeaks};

use super::axis::Axis;
use super::csv;
use super::number;
use super::outline::Outline;
use super::plot::{Line, Plot};
use super::table::{Align, Table, visible};
use super::unit;

/// A table of more of them is not looked at: `peaks.csv` has all.
pub const MOST_DEMANDS: usize = 24;

/// What signs mean.
pub(super) const TENSIONS: &str = "Forces are tensions: a spring or damper that is pulled has a positive one. Its error: how far the largest value may\n\
     be off, to first order.";

/// Prints accelerations and forces, those that a trajectory has.
#[derive(Clone, Copy, Debug)]
pub struct DemandReport<'a> {
    problem: &'a Problem<'a>,
    trajectory: &'a Trajectory,
    extrema: Option<&'a Extrema>,
    /// With the names of its switches.
    switched: Option<(&'a SwitchedMotion, &'a [String])>,
}

/// One quantity along the motion.
struct Demand<'a> {
    label: String,
    unit: &'static str,
    values: Vec<f64>,
    bounds: &'a [Option<f64>],
    peaks: Option<&'a Peaks>,
}

impl<'a> DemandReport<'a> {
    /// A report of what `trajectory`, the motion that `problem` asks for, has beside displacements and velocities; `extrema`
    /// are those of the same motion.
    pub fn new(
        problem: &'a Problem<'a>,
        trajectory: &'a Trajectory,
        extrema: Option<&'a Extrema>,
    ) -> DemandReport<'a> {
        DemandReport {
            problem,
            trajectory,
            extrema,
            switched: None,
        }
    }

    /// The same with the forces of these switches, and peaks from the motion that has them, whose trajectory it is.
    pub fn with_switches(
        self,
        motion: &'a SwitchedMotion,
        switches: &'a [String],
    ) -> DemandReport<'a> {
        DemandReport {
            switched: Some((motion, switches)),
            ..self
        }
    }

    /// The peaks of a motion with switches.
    fn switched_peaks(&self) -> Option<&'a SwitchedPeaks> {
        self.switched.and_then(|(motion, _)| motion.peaks())
    }

    /// One row for each instant with all digits: step, instant, the acceleration of each coordinate, and a bound of all.
    /// Nothing where accelerations were not asked for.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn accelerations(&self, out: impl Write) -> io::Result<()> {
        let all = self.of_coordinates();
        let bound = all.first().map(|one| ("bound".to_owned(), one.bounds));
        self.csv(out, &all, bound.as_slice())
    }

    /// One row for each instant with all digits: step, instant, the tension in each spring and damper, in their order, under
    /// its name or those of both ends (with its number, from 0, where another has the same), the force of each switch on its second end, and then the bound of each. Nothing where
    /// forces were not asked for.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn forces(&self, out: impl Write) -> io::Result<()> {
        let all = self.of_elements();
        let bounds = all.iter();
        let bounds = bounds.map(|one| (format!("bound {}", one.label), one.bounds));
        self.csv(out, &all, &bounds.collect::<Vec<_>>())
    }

    /// Whether accelerations were asked for.
    pub fn has_accelerations(&self) -> bool {
        !self.of_coordinates().is_empty()
    }

    /// Whether there are springs or dampers.
    pub fn has_forces(&self) -> bool {
        !self.of_elements().is_empty()
    }

    /// Whether there are outputs.
    pub fn has_outputs(&self) -> bool {
        self.trajectory.outputs().next().is_some()
    }

    /// One row for each instant with all digits: step, instant, the outputs in their order, and then the bound of each.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn outputs(&self, out: impl Write) -> io::Result<()> {
        let all: Vec<Demand<'a>> = self.of_outputs().collect();
        let bounds = all.iter();
        let bounds = bounds.map(|one| (format!("bound {}", one.label), one.bounds));
        self.csv(out, &all, &bounds.collect::<Vec<_>>())
    }

    /// One row for each acceleration, force and output: its highest and its lowest value, at any time and on both sides of jumps,
    /// when, and how far the value may be off.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn peaks(&self, mut out: impl Write) -> io::Result<()> {
        let header = [
            "quantity", "unit", "highest", "time [s]", "bound", "lowest", "time [s]", "bound",
        ];
        csv::row(&mut out, header)?;
        let all = self.of_coordinates().into_iter().chain(self.of_elements());
        for one in all.chain(self.of_outputs()) {
            let Some(peaks) = one.peaks else { continue };
            let cells = |peak: &Reached| [peak.value, peak.time, peak.bound].map(csv::number);
            let label = [one.label, one.unit.to_owned()].into_iter();
            let row = label.chain(cells(&peaks.highest));
            csv::row(&mut out, row.chain(cells(&peaks.lowest)))?;
        }
        Ok(())
    }

    /// The largest value of each acceleration and force at any time; `None` where there are none, where they are not known
    /// between the samples, and where there are too many to look at.
    pub(super) fn table(&self) -> Option<Table> {
        let all: Vec<Demand<'a>> = self
            .of_coordinates()
            .into_iter()
            .chain(self.of_elements())
            .collect();
        if all.is_empty() || all.len() > MOST_DEMANDS {
            return None;
        }
        let peaks = all.iter().map(|one| Some(one.peaks?.largest()));
        let peaks: Vec<Reached> = peaks.collect::<Option<_>>()?;
        let column = |value: fn(&Reached) -> f64| {
            number::column(peaks.iter().map(move |peak| Some(value(peak))))
        };
        let table = Table::default()
            .column(
                "quantity",
                Align::Left,
                all.iter().map(|one| visible(&one.label)),
            )
            .column("unit", Align::Left, all.iter().map(|one| one.unit))
            .column(
                "largest, between samples too",
                Align::Point,
                column(|peak| peak.value),
            )
            .column("at, s", Align::Point, column(|peak| peak.time))
            .column(
                "its error, estimated",
                Align::Right,
                peaks.iter().map(|peak| number::bound(peak.bound)),
            );
        Some(table)
    }

    /// The same as text, with what signs mean.
    pub(super) fn text(&self) -> Option<String> {
        Some(format!("{}{TENSIONS}\n", self.table()?.text()))
    }

    /// Accelerations against time; `None` where there are none.
    pub fn acceleration_plot(&self, title: &str) -> Option<Plot<'a>> {
        self.plot(title, "acceleration", self.of_coordinates())
    }

    /// Forces against time; `None` where there are none.
    pub fn force_plot(&self, title: &str) -> Option<Plot<'a>> {
        self.plot(title, "force", self.of_elements())
    }

    fn plot(&self, title: &str, what: &str, all: Vec<Demand<'a>>) -> Option<Plot<'a>> {
        let mut units: Vec<&str> = all.iter().map(|one| one.unit).collect();
        units.sort_unstable();
        units.dedup();
        let y = Axis::linear(what, units.join(" or ").trim_start_matches(" or "));
        let lines: Vec<Line<'a>> = all
            .into_iter()
            .map(|one| {
                let values = one.values;
                let sample = move |k: usize| values[k];
                let outline = Outline::of_peaks(self.trajectory.times(), sample, one.peaks);
                Line::new(&one.label, outline.len(), move |k| outline.point(k))
            })
            .collect();
        (!lines.is_empty()).then(|| Plot {
            title: title.to_owned(),
            x: Axis::linear("time", "s"),
            y,
            lines,
            ring: None,
        })
    }

    fn of_coordinates(&self) -> Vec<Demand<'a>> {
        let system = self.problem.system();
        let names = system.names().iter().enumerate();
        let all = self.trajectory.acceleration().map(|values| {
            names.map(move |(i, name)| Demand {
                label: format!("acceleration {name}"),
                unit: unit::motion(Some(system.kind_of(i)), Quantity::Acceleration),
                values: values.row(i).iter().copied().collect(),
                bounds: self.trajectory.acceleration_bound(),
                peaks: match self.switched_peaks() {
                    Some(peaks) => Some(peaks.acceleration(i)),
                    None => self.extrema.and_then(|extrema| extrema.acceleration(i)),
                },
            })
        });
        all.into_iter().flatten().collect()
    }

    fn of_elements(&self) -> Vec<Demand<'a>> {
        let system = self.problem.system();
        let mut all = Vec::new();
        for kind in [ElementKind::Spring, ElementKind::Damper] {
            let elements = system.elements(kind);
            let named = elements.iter().zip(labels(&elements));
            for (index, (element, label)) in named.enumerate() {
                let force = self.trajectory.force(kind, index);
                let bounds = self.trajectory.force_bound(kind, index);
                let Some((values, bounds)) = force.zip(bounds) else {
                    continue;
                };
                all.push(Demand {
                    label: format!("{kind} {label}"),
                    unit: unit::force(element.kind),
                    values: values.to_vec(),
                    bounds,
                    peaks: match self.switched_peaks() {
                        Some(peaks) => peaks.force(kind, index),
                        None => self.extrema.and_then(|extrema| extrema.force(kind, index)),
                    },
                });
            }
        }
        // What a switch joins is not known here: of one kind of coordinates it is that.
        let kinds: Vec<_> = unit::kinds(system).collect();
        let unit = unit::force(match kinds[..] {
            [kind] => Some(kind),
            _ => None,
        });
        let switches = self.switched.into_iter();
        let switches = switches
            .flat_map(|(motion, names)| names.iter().enumerate().map(move |one| (motion, one)));
        all.extend(switches.filter_map(|(motion, (switch, name))| {
            Some(Demand {
                label: name.clone(),
                unit,
                values: motion.switch_force(switch)?.to_vec(),
                bounds: motion.switch_force_bound(switch)?,
                peaks: motion.peaks().map(|peaks| peaks.switch(switch)),
            })
        }));
        all
    }

    fn of_outputs(&self) -> impl Iterator<Item = Demand<'a>> {
        let DemandReport {
            problem,
            trajectory,
            extrema,
            ..
        } = *self;
        let switched = self.switched_peaks();
        let all = trajectory.outputs().zip(problem.combinations());
        all.enumerate().map(move |(i, (name, combination))| Demand {
            label: format!("output {name}"),
            unit: unit::output(problem.system(), combination),
            values: trajectory.output(i).to_vec(),
            bounds: trajectory.output_bound(i),
            peaks: match switched {
                Some(peaks) => Some(peaks.output(i)),
                None => extrema.and_then(|extrema| extrema.output(i)),
            },
        })
    }

    fn csv(
        &self,
        mut out: impl Write,
        all: &[Demand<'_>],
        bounds: &[(String, &[Option<f64>])],
    ) -> io::Result<()> {
        if all.is_empty() {
            return Ok(());
        }
        let instant = ["step".to_owned(), "time [s]".to_owned()].into_iter();
        let values = all.iter().map(|one| unit::bracketed(&one.label, one.unit));
        let limits = bounds.iter().map(|(name, _)| name.clone());
        csv::row(&mut out, instant.chain(values).chain(limits))?;
        let instants = self.trajectory.steps().iter().zip(self.trajectory.times());
        for (k, (step, time)) in instants.enumerate() {
            let instant = [step.to_string(), csv::number(*time)].into_iter();
            let values = all.iter().map(|one| csv::number(one.values[k]));
            let limits = bounds.iter().map(|(_, bound)| csv::optional(bound[k]));
            csv::row(&mut out, instant.chain(values).chain(limits))?;
        }
        Ok(())
    }
}

/// The name of each element, else those of its ends, with its number where another one has the same.
fn labels(elements: &[GivenElement]) -> Vec<String> {
    let plain = |element: &GivenElement| {
        let [first, second] = &element.ends;
        let ends = || format!("{first}–{second}");
        element.name.clone().unwrap_or_else(ends)
    };
    let plain: Vec<String> = elements.iter().map(plain).collect();
    let mut counts = HashMap::new();
    plain
        .iter()
        .for_each(|label| *counts.entry(label).or_insert(0) += 1);
    let each = plain.iter().zip(elements).enumerate();
    each.map(|(index, (label, element))| match &element.name {
        None if counts[label] > 1 => format!("{label} ({index})"),
        _ => label.clone(),
    })
    .collect()
}
