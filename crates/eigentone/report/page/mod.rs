//! The report as one page of HTML that loads nothing, prints, and follows the reader's light or dark. Its script adds
//! reading, zoom and sorting to what is all there without it.

mod chart;
mod damping;
mod energy;
mod frequency;
mod html;
mod mode_shapes;
mod motion;
mod pole_map;
mod schematic;
pub(super) mod sweep;

use eigentone_digits::sort_by_number;
use eigentone_modes::ElementKind;
use eigentone_response::{Energy, Problem};

use super::analysis::{Analysis, heading};
use super::demands::{DemandReport, TENSIONS};
use super::frequency::FrequencyReport;
use super::modes::ModeReport;
use super::number;
use super::participation;
use super::plot::escape;
use super::steady_state::SteadyStateReport;
use super::switched::HELD;
use chart::Spans;
use html::{Section, definitions, paragraph, remark, table};
use motion::{Motion, Source};

/// What the page is made from. What is `None` is left out.
pub struct Page<'a> {
    /// What was found out about the scene.
    pub analysis: &'a Analysis<'a>,
    /// The energies along its motion.
    pub energy: Option<&'a Energy>,
    /// Frequency responses with their peaks.
    pub frequency: Option<FrequencyReport<'a>>,
}

impl Page<'_> {
    fn problem(&self) -> Option<&Problem<'_>> {
        let linear = self.analysis.response.as_ref().map(|answer| answer.problem);
        linear.or_else(|| self.analysis.switched.as_ref().map(|report| report.problem))
    }

    /// The page as HTML.
    pub fn html(&self) -> String {
        let mut sections = vec![self.scene(), self.plan(), self.modes()];
        sections.push(Section {
            id: "shapes",
            heading: "Mode shapes".to_owned(),
            body: mode_shapes::figures(self.analysis.modes, self.analysis.system),
        });
        sections.extend(self.frequency.as_ref().map(|report| Section {
            id: "frequency",
            heading: "Frequency response".to_owned(),
            body: frequency::body(report),
        }));
        sections.extend(self.response());
        sections.extend(self.switched());
        sections.push(self.bounds());
        html::document(self.analysis.title, &self.lead(), &sections)
    }

    fn lead(&self) -> String {
        let system = self.analysis.system;
        let mut parts = vec![number::count(system.len(), "coordinate", "coordinates")];
        let elements = [
            (system.points().len(), "point", "points"),
            (system.supports().len(), "support", "supports"),
            (
                system.elements(ElementKind::Spring).len(),
                "spring",
                "springs",
            ),
            (
                system.elements(ElementKind::Damper).len(),
                "damper",
                "dampers",
            ),
            (
                self.problem().map_or(0, |problem| problem.loads().len()),
                "load",
                "loads",
            ),
        ];
        let present = elements.into_iter().filter(|(number, _, _)| *number > 0);
        parts.extend(present.map(|(count, one, many)| number::count(count, one, many)));
        remark(&format!(
            "{}. Analysed by eigentone {}.",
            parts.join(", "),
            env!("CARGO_PKG_VERSION")
        ))
    }

    fn scene(&self) -> Section {
        let body = match schematic::figure(self.analysis.system, self.problem()) {
            Ok(figure) => figure,
            Err(reason) => paragraph(&reason),
        };
        Section {
            id: "scene",
            heading: "Scene".to_owned(),
            body: body + &definitions(&self.analysis.structure.to_string()),
        }
    }

    fn plan(&self) -> Section {
        Section {
            id: "plan",
            heading: "Plan".to_owned(),
            body: definitions(&self.analysis.plan()),
        }
    }

    fn modes(&self) -> Section {
        let modes = self.analysis.modes;
        let report = ModeReport::new(modes, self.analysis.system.names());
        let mut body = table(&report.table());
        for line in report.remarks().lines() {
            body += &remark(line);
        }
        body += &format!(
            "<div class=\"cards\">\n{}{}</div>\n",
            pole_map::figures(modes),
            damping::figure(modes).unwrap_or_default()
        );
        body += &self.participation();
        Section {
            id: "modes",
            heading: "Modes".to_owned(),
            body,
        }
    }

    fn participation(&self) -> String {
        let mut out = String::new();
        for (heading, part) in participation::parts(self.analysis) {
            out += &format!("<h3>{}</h3>\n", escape(&heading));
            out += &match part {
                Ok(one) => table(&one),
                Err(reason) => paragraph(&reason),
            };
        }
        if !out.is_empty() {
            out += &remark(&participation::EXPLAINED.replace('\n', " "));
        }
        out
    }

    fn response(&self) -> Vec<Section> {
        let Some(answer) = &self.analysis.response else {
            return Vec::new();
        };
        let system = self.analysis.system;
        let mut body = String::from("<div class=\"cards\">\n");
        body += &motion::figures(&Motion {
            system,
            trajectory: answer.trajectory,
            peaks: Source::Summary(answer.summary),
            behind: Vec::new(),
        });
        if let Some(energy) = self.energy {
            body += &energy::figure(energy, answer.trajectory);
        }
        body += "</div>\n";
        body += &table(&answer.table(system));
        body += &remark(&answer.explained().replace('\n', " "));
        if let Some(outputs) = answer.outputs() {
            body += "<h3>Outputs</h3>\n";
            body += &table(&outputs);
        }
        let extrema = answer.summary.extrema();
        let demands = DemandReport::new(answer.problem, answer.trajectory, extrema);
        if let Some(peaks) = demands.table() {
            body += "<h3>Accelerations and forces</h3>\n";
            body += &(table(&peaks) + &remark(&TENSIONS.replace('\n', " ")));
        }
        let mut sections = vec![Section {
            id: "response",
            heading: answer.heading(),
            body,
        }];
        let steady = match answer.steady_state {
            Ok(steady_state) if steady_state.motions().is_empty() => None,
            Ok(steady_state) => {
                let report = SteadyStateReport {
                    steady_state,
                    names: system.names(),
                    summary: answer.summary,
                    modes: self.analysis.modes,
                };
                let explained = report.explained().replace('\n', " ");
                Some(table(&report.table(system)) + &remark(&explained))
            }
            Err(error) => Some(paragraph(&format!("There is none: {error}."))),
        };
        sections.extend(steady.map(|body| Section {
            id: "steady-state",
            heading: "Steady state under the harmonic loads".to_owned(),
            body,
        }));
        sections
    }

    fn switched(&self) -> Option<Section> {
        /// Events that are looked at; `events.csv` has all.
        const EVENTS: usize = 500;
        let report = self.analysis.switched.as_ref()?;
        let trajectory = report.motion.trajectory();
        let mut body = String::new();
        if let Some(peaks) = report.motion.peaks() {
            let behind = report.acting().into_iter().map(|one| {
                let strokes = one.strokes.into_iter().map(|time| [time, time]);
                let mut of: Vec<[f64; 2]> = one.spans.into_iter().chain(strokes).collect();
                sort_by_number(&mut of, |one| one[0]);
                Spans {
                    name: one.name.to_owned(),
                    of,
                }
            });
            let figures = motion::figures(&Motion {
                system: self.analysis.system,
                trajectory,
                peaks: Source::Switched(peaks),
                behind: behind.collect(),
            });
            body += &format!("<div class=\"cards\">\n{figures}</div>\n");
            body += &remark(
                "Bands: while a friction holds or a stop is pressed. Vertical lines: impacts, and changes of controlled dampers.",
            );
        }
        body += &paragraph(&format!("The motion is {}.", report.explained()));
        let parts = [
            (
                "Largest displacements, between samples too",
                report.peaks(),
                "",
            ),
            (
                "Accelerations and forces",
                report.demands().table(),
                TENSIONS,
            ),
            ("Energy taken", report.losses(), HELD),
        ];
        for (heading, part, note) in parts {
            let Some(part) = part else { continue };
            body += &format!("<h3>{heading}</h3>\n{}", table(&part));
            if !note.is_empty() {
                body += &remark(&note.replace('\n', " "));
            }
        }
        let (events, more) = report.first_events(EVENTS);
        if events.rows() > 0 {
            body += &format!("<h3>Events</h3>\n{}", table(&events));
        }
        if more > 0 {
            body += &remark(&format!("… and {more} more, which events.csv lists."));
        }
        Some(Section {
            id: "response",
            heading: heading(trajectory),
            body,
        })
    }

    fn bounds(&self) -> Section {
        let mut body = definitions(&self.analysis.bounds());
        let trajectory = self.analysis.trajectory();
        body += &trajectory
            .and_then(|trajectory| motion::bounds(trajectory, self.analysis.system))
            .unwrap_or_default();
        Section {
            id: "bounds",
            heading: "Error bounds".to_owned(),
            body,
        }
    }
}
