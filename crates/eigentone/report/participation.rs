//! Effective modal masses of the parts of a system, as tables.

use std::f64::consts::TAU;

use eigentone_modes::{CoordinateKind, Participation, ParticipationError};

use super::analysis::Analysis;
use super::number;
use super::plot::shorten;
use super::table::{Align, Table, visible};
use super::unit;

/// What the tables say.
pub(super) const EXPLAINED: &str = "\
Without damping, for a motion of the ground that is the same for all masses that springs and dampers connect.\n\
Participation: how strongly that motion drives the mode, whose shape has a largest entry of 1. Effective mass:\n\
the part of the mass that the ground feels through the mode; over all modes it adds up to the total, but for a part of\n\
what supports and held ends carry, and so do moments of inertia.";

/// A heading and a table for each part that has effective masses, or why there are none.
pub(super) fn parts(analysis: &Analysis<'_>) -> Vec<(String, Result<Table, String>)> {
    let part =
        |(coordinates, participation): &(Vec<usize>, Result<Participation, ParticipationError>)| {
            match participation {
                Ok(one) if one.total_mass() > 0.0 => {
                    let names = coordinates
                        .iter()
                        .map(|i| analysis.system.names()[*i].as_str());
                    let names = shorten(&names.collect::<Vec<&str>>().join(", "), 60);
                    let of = if coordinates.len() < analysis.system.len() {
                        format!(" of {}", visible(&names))
                    } else {
                        String::new()
                    };
                    let kind = analysis.system.kind_of(coordinates[0]);
                    let is_alone = unit::kinds(analysis.system).count() == 1;
                    Some((format!("Participation{of}"), Ok(table(one, kind, is_alone))))
                }
                Err(
                    error @ (ParticipationError::NoCommonDirection | ParticipationError::Modes(_)),
                ) => {
                    let reason = format!("There are no effective masses: {error}.");
                    Some(("Participation".to_owned(), Err(reason)))
                }
                _ => None,
            }
        };
    analysis.participation.iter().filter_map(part).collect()
}

/// Of a direction of one kind; shapes that go beyond it, to coordinates of the other kind, have masses without a unit.
fn table(participation: &Participation, kind: CoordinateKind, is_alone: bool) -> Table {
    let what = match kind {
        CoordinateKind::Displacement => "mass",
        CoordinateKind::Rotation => "inertia",
    };
    let unit = unit::inertia(Some(kind));
    let of_shape = if is_alone { unit } else { "" };
    let modal = unit::labelled(&format!("modal {what}"), of_shape);
    let effective = unit::labelled(&format!("effective {what}"), unit);
    let modes = participation.modes();
    let stiffness = modes.stiffness().iter().zip(modes.mass());
    // A mode that springs push away has none.
    let frequencies = stiffness.map(|(k, m)| (*k >= 0.0).then(|| (k / m).sqrt()));
    let frequencies: Vec<Option<f64>> = frequencies.collect();
    let hertz = frequencies.iter().map(|one| one.map(|omega| omega / TAU));
    let column = |values: &[f64]| number::column(values.iter().copied().map(Some));
    let total = participation.total_mass();
    let shares = participation
        .effective_masses()
        .iter()
        .map(|mass| Some(100.0 * mass / total));
    let count = modes.mass().len();
    Table::default()
        .column("#", Align::Right, (1..=count).map(|k| k.to_string()))
        .column(
            "undamped ω, rad/s",
            Align::Point,
            number::column(frequencies.iter().copied()),
        )
        .column("f, Hz", Align::Point, number::column(hertz))
        .column(&modal, Align::Point, column(modes.mass()))
        .column(
            "participation",
            Align::Point,
            column(participation.factors()),
        )
        .column(
            &effective,
            Align::Point,
            column(participation.effective_masses()),
        )
        .column("of the total, %", Align::Point, number::column(shares))
}
