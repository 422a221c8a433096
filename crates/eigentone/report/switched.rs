//! The motion of a scene with switches.

use std::fmt::Write as _;

use eigentone_modes::Bounds;
use eigentone_response::{Problem, Quantity, Reached};
use eigentone_switching::{EventKind, SwitchedMotion};

use super::analysis;
use super::axis::Axis;
use super::demands::DemandReport;
use super::number;
use super::outline::{self, Outline};
use super::plot::{Line, Plot};
use super::table::{Align, Table};
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

/// When a switch acts: at once at each impact and each other law of a damper, and from one instant to another while a friction
/// holds or a stop is pressed.
pub(super) struct Acting<'a> {
    pub(super) name: &'a str,
    pub(super) strokes: Vec<f64>,
    pub(super) spans: Vec<[f64; 2]>,
}

/// What else counts as taken.
pub(super) const HELD: &str = "Of a stop that is pressed at the end, the energy stored in its spring is counted too.\nWhere a support jumps at a damper, the energy that this takes has no limit and is not given.";

/// As many events as are read.
const SHOWN: usize = 40;

impl SwitchedReport<'_> {
    /// How it was computed, the largest displacements, accelerations and forces, where energy went, and the first events: each
    /// with its heading.
    pub(super) fn sections(&self) -> Vec<(String, String)> {
        let mut sections = vec![(
            analysis::heading(self.motion.trajectory()),
            self.explained() + "\n",
        )];
        let peaks = self.peaks().map(|table| table.text());
        let losses = self.losses().map(|table| table.text() + HELD + "\n");
        let (first, more) = self.first_events(SHOWN);
        let mut events = first.text();
        if more > 0 {
            let _ = writeln!(events, "… and {more} more: `eigentone response` lists them");
        }
        let parts = [
            ("Largest displacements, between samples too", peaks),
            ("Accelerations and forces", self.demands().text()),
            ("Energy taken", losses),
            ("Events", (first.rows() > 0).then_some(events)),
        ];
        let parts = parts.into_iter();
        sections.extend(parts.filter_map(|(heading, text)| Some((heading.to_owned(), text?))));
        sections
    }

    /// How it was computed, and how well it is known.
    pub(super) fn explained(&self) -> String {
        let trajectory = self.motion.trajectory();
        let bounds = match trajectory.bounds() {
            Bounds::Proven => "proven",
            Bounds::Estimated => "estimated",
        };
        let bound = trajectory.displacement_bound().iter().flatten();
        format!(
            "{}; {}; bounds are {bounds}, at most {} for displacements",
            trajectory.method(),
            number::count(self.motion.events().len(), "event", "events"),
            number::bound(bound.fold(0.0f64, |a, b| a.max(*b))),
        )
    }

    /// The largest displacements at any time.
    pub(super) fn peaks(&self) -> Option<Table> {
        let system = self.problem.system();
        let peaks = self.motion.peaks()?;
        let peaks: Vec<_> = (0..system.len())
            .map(|i| peaks.displacement(i).largest())
            .collect();
        let column = |value: fn(&Reached) -> f64| {
            number::column(peaks.iter().map(move |peak| Some(value(peak))))
        };
        let table = Table::default().column("of", Align::Left, system.names());
        let (table, unit) = unit::column(table, system, Quantity::Displacement, 1);
        let largest = unit::labelled("largest", unit);
        let table = table
            .column(&largest, Align::Point, column(|peak| peak.value))
            .column("at, s", Align::Point, column(|peak| peak.time));
        Some(table)
    }

    /// Where energy went.
    pub(super) fn losses(&self) -> Option<Table> {
        let losses = self.motion.losses()?;
        let dampers = (!losses.dampers.is_empty())
            .then(|| ("dampers".to_owned(), losses.dampers.iter().sum::<f64>()));
        let switches = self.switches.iter().cloned();
        let switches = switches.zip(losses.switches.iter().copied());
        let (names, taken): (Vec<String>, Vec<f64>) = dampers.into_iter().chain(switches).unzip();
        let table = Table::default().column("by", Align::Left, names).column(
            "energy, J",
            Align::Point,
            number::column(taken.into_iter().map(Some)),
        );
        Some(table)
    }

    /// The first events, and how many more there are.
    pub(super) fn first_events(&self, most: usize) -> (Table, usize) {
        let events = self.motion.events();
        let shown = &events[..events.len().min(most)];
        let table = Table::default()
            .column(
                "at, s",
                Align::Point,
                number::column(shown.iter().map(|event| Some(event.time))),
            )
            .column(
                "known to, s",
                Align::Right,
                shown.iter().map(|event| number::bound(event.bound)),
            )
            .column(
                "event",
                Align::Left,
                shown.iter().map(|event| event.kind.to_string()),
            )
            .column(
                "of",
                Align::Left,
                shown.iter().map(|event| &self.switches[event.switch]),
            );
        (table, events.len() - shown.len())
    }

    /// Accelerations and forces, with their peaks.
    pub fn demands(&self) -> DemandReport<'_> {
        let report = DemandReport::new(self.problem, self.motion.trajectory(), None);
        report.with_switches(self.motion, self.switches)
    }

    /// Of the switches that act at all.
    pub(super) fn acting(&self) -> Vec<Acting<'_>> {
        let times = self.motion.trajectory().times();
        let end = times.last().copied().unwrap_or(0.0);
        let each = self.switches.iter().enumerate().map(|(switch, name)| {
            let (mut strokes, mut spans, mut since) = (Vec::new(), Vec::new(), None);
            for event in self.motion.events() {
                match event.kind {
                    _ if event.switch != switch => {}
                    EventKind::Stick | EventKind::Contact => since = Some(event.time),
                    EventKind::Slip | EventKind::Release => {
                        spans.extend(since.take().map(|from| [from, event.time]));
                    }
                    EventKind::Impact | EventKind::Switch => strokes.push(event.time),
                }
            }
            spans.extend(since.map(|from| [from, end]));
            Acting {
                name,
                strokes,
                spans,
            }
        });
        each.filter(|one| !(one.strokes.is_empty() && one.spans.is_empty()))
            .collect()
    }

    /// The same as lines of a plot.
    fn events(&self) -> Vec<Line<'_>> {
        let mut lines = Vec::new();
        for Acting {
            name,
            strokes,
            spans,
        } in self.acting()
        {
            if !spans.is_empty() {
                lines.push(Line::shaded(name, spans.len(), move |k| spans[k]));
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
