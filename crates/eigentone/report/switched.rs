//! The motion of a scene with switches.

use std::fmt::Write as _;

use eigentone_modes::Bounds;
use eigentone_response::{Problem, Quantity};
use eigentone_switching::SwitchedMotion;

use super::axis::Axis;
use super::events;
use super::number;
use super::outline;
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
        let values = trajectory.displacement();
        text.push_str("largest displacement at the samples\n");
        for (i, name) in system.names().iter().enumerate() {
            let at = (0..values.ncols()).max_by(|a, b| {
                let size = |k: usize| values[(i, k)].abs();
                size(*a).total_cmp(&size(*b))
            });
            if let Some(k) = at {
                let unit = unit::motion(Some(system.kind_of(i)), Quantity::Displacement);
                let (value, time) = (values[(i, k)], trajectory.times()[k]);
                let [value, time] = [value, time].map(number::significant);
                let _ = writeln!(text, "  {}: {value} {unit} at {time} s", visible(name));
            }
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

    /// Displacements and velocities at the samples, by kinds of coordinates, each with the name of its file.
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
            let lines = of_kind.map(|i| {
                let point = move |k: usize| (trajectory.times()[k], values[(i, k)]);
                Line::new(&system.names()[i], trajectory.len(), point)
            });
            let plot = Plot {
                title: self.title.to_owned(),
                x: Axis::linear("time", "s"),
                y: Axis::linear(name, unit::motion(Some(kind), quantity)),
                lines: lines.collect(),
                ring: None,
            };
            (format!("{}.svg", name.replace(' ', "-")), plot)
        });
        plots.collect()
    }
}
