//! Where the energy of the motion is, what took it and what brought it.

use eigentone_response::{Energy, Trajectory};

use super::chart::{Chart, Series};
use crate::report::axis::Axis;

pub(super) fn figure(energy: &Energy, trajectory: &Trajectory) -> String {
    let times = trajectory.times();
    let kinds = [
        ("kinetic", energy.kinetic()),
        ("potential", energy.potential()),
        ("dissipated by dampers", energy.dissipated()),
        ("work of loads and supports", energy.work()),
    ];
    // What never is anything is left out.
    let kinds = kinds
        .into_iter()
        .filter(|(_, values)| values.iter().any(|value| *value != 0.0));
    let series = kinds.map(|(name, values)| Series {
        name: name.to_owned(),
        note: String::new(),
        len: times.len().min(values.len()),
        point: Box::new(move |k| (times[k], values[k])),
        marks: Vec::new(),
        joined: true,
    });
    let chart = Chart {
        heading: "Energy".to_owned(),
        x: Axis::linear("time", "s"),
        y: Axis::linear("energy", "J"),
        series: series.collect(),
        behind: Vec::new(),
        caption: "At every instant kinetic + potential + dissipated = initial energy + work."
            .to_owned(),
    };
    chart.figure()
}
