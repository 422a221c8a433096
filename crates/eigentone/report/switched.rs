//! The motion of a scene with switches.

use std::fmt::Write as _;

use eigentone_modes::Bounds;
use eigentone_response::{Problem, Quantity};
use eigentone_switching::{EventKind, SwitchedMotion};

use super::axis::Axis;
use super::demands::DemandReport;
use super::events;
use super::number;
use super::outline::{self, Outline};
use super::plot::{Line, Plot};
use super::table::visible;
use super::unit;

/// Summarises and plots a motion with events.
#[derive(Clone, Copy, Debug)]
pub struct SwitchedReport<'a> {
    /// Stands above the plots.
    pub title: &'a str,
    /// What was asked, without the switches.
    pub problem: &'a Problem<'a>,
    /// The answer.
    pub motion: &'a SwitchedMotion,
    /// What each switch is called.
    pub switches: &'a [String],
}

impl SwitchedReport<'_> {
    /// How it was computed, the largest displacements at the samples, where energy went, and the first events.
    pub fn text(&self) -> String {
        /// As many as are read.
        const SHOWN: usize = 40;
        let trajectory = self.motion.trajectory();
        let events = self.motion.events();
        let bounds = match trajectory.bounds() {
            Bounds::Proven => "proven",
            Bounds::Estimated => "estimated",
        };
        let largest =
            |bounds: &[Option<f64>]| bounds.iter().flatten().fold(0.0f64, |a, b| a.max(*b));
        let mut text = format!(
            "motion with switches: {}; {} events; bounds are {bounds}, at most {} for displacements\n",
            trajectory.method(),
            events.len(),
            number::significant(largest(trajectory.displacement_bound())),
        );
        let system = self.problem.system();
        if let Some(peaks) = self.motion.peaks() {
            text.push_str("largest displacement, between samples too\n");
            for (i, name) in system.names().iter().enumerate() {
                let unit = unit::motion(Some(system.kind_of(i)), Quantity::Displacement);
                let peak = peaks.displacement(i).largest();
                let [value, time] = [peak.value, peak.time].map(number::significant);
                let _ = writeln!(text, "  {}: {value} {unit} at {time} s", visible(name));
            }
        }
        if let Some(demands) = self.demands().text() {
            let _ = write!(text, "\n{demands}\n");
        }
        if let Some(losses) = self.motion.losses() {
            text.push_str("energy taken, J (a stop that is pressed holds a part of it)\n");
            let dampers: f64 = losses.dampers.iter().sum();
            if !losses.dampers.is_empty() {
                let _ = writeln!(text, "  dampers: {}", number::significant(dampers));
            }
            for (name, taken) in self.switches.iter().zip(&losses.switches) {
                let _ = writeln!(text, "  {}: {}", visible(name), number::significant(*taken));
            }
        }
        let shown = &events[..events.len().min(SHOWN)];
        text.push_str(&events::text(shown, self.switches));
        if events.len() > SHOWN {
            let _ = writeln!(
                text,
                "… and {} more: `eigentone response` lists them",
                events.len() - SHOWN
            );
        }
        text
    }

    /// Accelerations and forces, with their peaks.
    pub fn demands(&self) -> DemandReport<'_> {
        let report = DemandReport::new(self.problem, self.motion.trajectory(), None);
        report.with_switches(self.motion, self.switches)
    }

    /// When switches act: a stroke at each impact and each other law of a damper, a band while a friction holds or a stop is
    /// pressed.
    fn events(&self) -> Vec<Line<'_>> {
        let times = self.motion.trajectory().times();
        let end = times.last().copied().unwrap_or(0.0);
        let mut lines = Vec::new();
        for (switch, name) in self.switches.iter().enumerate() {
            let mut strokes = Vec::new();
            let mut bands: Vec<[f64; 2]> = Vec::new();
            let mut since = None;
            for event in self.motion.events() {
                match event.kind {
                    _ if event.switch != switch => {}
                    EventKind::Stick | EventKind::Contact => since = Some(event.time),
                    EventKind::Slip | EventKind::Release => {
                        bands.extend(since.take().map(|from| [from, event.time]));
                    }
                    EventKind::Impact | EventKind::Switch => strokes.push(event.time),
                }
            }
            bands.extend(since.map(|from| [from, end]));
            if !bands.is_empty() {
                lines.push(Line::shaded(name, bands.len(), move |k| bands[k]));
            }
            if !strokes.is_empty() {
                lines.push(Line::upright(name, strokes.len(), move |k| strokes[k]));
            }
        }
        lines
    }

    /// Displacements and velocities, by kinds of coordinates, with the events, each with the name of its file.
    pub fn plots(&self) -> Vec<(String, Plot<'_>)> {
        let system = self.problem.system();
        let trajectory = self.motion.trajectory();
        let kinds = unit::kinds(system).flat_map(|kind| {
            [Quantity::Displacement, Quantity::Velocity].map(|quantity| (kind, quantity))
        });
        let plots = kinds.map(|(kind, quantity)| {
            let values = match quantity {
                Quantity::Displacement => trajectory.displacement(),
                _ => trajectory.velocity(),
            };
            let name = match quantity {
                Quantity::Displacement => outline::Quantity::Displacement,
                _ => outline::Quantity::Velocity,
            };
            let name = name.name(kind);
            let of_kind = (0..system.len()).filter(|i| system.kind_of(*i) == kind);
            let peaks = self.motion.peaks();
            let mut lines: Vec<Line<'_>> = of_kind
                .map(|i| {
                    let own = peaks.map(|peaks| match quantity {
                        Quantity::Displacement => peaks.displacement(i),
                        _ => peaks.velocity(i),
                    });
                    let sample = move |k: usize| values[(i, k)];
                    let outline = Outline::of_peaks(trajectory.times(), sample, own);
                    let name = &system.names()[i];
                    Line::new(name, outline.len(), move |k| outline.point(k))
                })
                .collect();
            lines.extend(self.events());
            let plot = Plot {
                title: self.title.to_owned(),
                x: Axis::linear("time", "s"),
                y: Axis::linear(name, unit::motion(Some(kind), quantity)),
                lines,
                ring: None,
            };
            (format!("{}.svg", name.replace(' ', "-")), plot)
        });
        plots.collect()
    }
}
