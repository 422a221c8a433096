//! Displacements and velocities against time, with their peaks, and their bounds.

use eigentone_digits::sort_by_number;
use eigentone_modes::{Bounds, CoordinateKind, System};
use eigentone_response::{Peaks, Summary, Trajectory};
use eigentone_switching::SwitchedPeaks;

use super::chart::{Chart, LINES, Series, Spans};
use crate::report::axis::Axis;
use crate::report::number;
use crate::report::outline::{Outline, Quantity};
use crate::report::response::doubts;
use crate::report::unit;

/// A motion to be drawn.
pub(super) struct Motion<'a> {
    pub(super) system: &'a System,
    pub(super) trajectory: &'a Trajectory,
    pub(super) peaks: Source<'a>,
    /// When switches act.
    pub(super) behind: Vec<Spans>,
}

/// Where peaks are known from.
#[derive(Clone, Copy)]
pub(super) enum Source<'a> {
    Summary(&'a Summary),
    Switched(&'a SwitchedPeaks),
}

impl<'a> Source<'a> {
    fn switched(peaks: &SwitchedPeaks, quantity: Quantity, row: usize) -> &Peaks {
        match quantity {
            Quantity::Displacement => peaks.displacement(row),
            Quantity::Velocity => peaks.velocity(row),
        }
    }

    /// When, and what, the largest is.
    fn largest(self, quantity: Quantity, row: usize) -> (f64, f64) {
        match self {
            Source::Summary(summary) => {
                let one = &summary.coordinates()[row];
                match quantity {
                    Quantity::Displacement => (one.peak_time, one.peak),
                    Quantity::Velocity => (one.fastest_time, one.fastest),
                }
            }
            Source::Switched(peaks) => {
                let peak = Source::switched(peaks, quantity, row).largest();
                (peak.time, peak.value)
            }
        }
    }

    fn outline(self, quantity: Quantity, trajectory: &'a Trajectory, row: usize) -> Outline<'a> {
        match self {
            Source::Summary(summary) => Outline::of(quantity, trajectory, summary, row),
            Source::Switched(peaks) => {
                let samples = match quantity {
                    Quantity::Displacement => trajectory.displacement(),
                    Quantity::Velocity => trajectory.velocity(),
                };
                let peaks = Source::switched(peaks, quantity, row);
                let sample = move |k| samples[(row, k)];
                Outline::of_peaks(trajectory.times(), sample, Some(peaks))
            }
        }
    }

    fn is_between(self) -> bool {
        match self {
            Source::Summary(summary) => summary.is_between(),
            Source::Switched(_) => true,
        }
    }
}

/// The charts of a motion, those of rotations after the others.
pub(super) fn figures(motion: &Motion<'_>) -> String {
    let kinds = unit::kinds(motion.system);
    let each = kinds.flat_map(|kind| {
        [Quantity::Displacement, Quantity::Velocity]
            .map(|quantity| lines(motion, kind, quantity).figure())
    });
    each.collect()
}

/// Beside the largest, bounds below this are not drawn: at the first instant only what was given is rounded.
const NEGLIGIBLE: f64 = 1e-9;

/// How far displacements and velocities may be off, against time.
pub(super) fn bounds(trajectory: &Trajectory, system: &System) -> Option<String> {
    let times = trajectory.times();
    let of_all = |what: &str, quantity| unit::labelled(what, &unit::of_all(system, quantity));
    let kinds = [
        (
            of_all("displacement", eigentone_response::Quantity::Displacement),
            trajectory.displacement_bound(),
        ),
        (
            of_all("velocity", eigentone_response::Quantity::Velocity),
            trajectory.velocity_bound(),
        ),
    ];
    let largest = |bounds: &[Option<f64>]| bounds.iter().flatten().copied().fold(0.0, f64::max);
    let series: Vec<Series<'_>> = kinds
        .into_iter()
        .filter(|(_, bounds)| largest(bounds) > 0.0)
        .map(|(name, bounds)| {
            let least = NEGLIGIBLE * largest(bounds);
            let drawn = move |k: usize| bounds[k].filter(|bound| *bound >= least);
            Series {
                name,
                note: String::new(),
                len: times.len(),
                point: Box::new(move |k| (times[k], drawn(k).unwrap_or(f64::NAN))),
                marks: Vec::new(),
                joined: true,
            }
        })
        .collect();
    let kind = match trajectory.bounds() {
        Bounds::Proven => "proven bound of the error",
        Bounds::Estimated => "estimated bound of the error",
    };
    (!series.is_empty()).then(|| {
        let chart = Chart {
            heading: "How far the motion can be off".to_owned(),
            x: Axis::linear("time", "s"),
            y: Axis::logarithmic(kind, ""),
            series,
            behind: Vec::new(),
            caption:
                "Over all coordinates. Where no line is drawn the value is exact, has no bound, or one below \
                 1e−9 of the largest."
                    .to_owned(),
        };
        format!("<div class=\"cards\">\n{}</div>\n", chart.figure())
    })
}

/// The lines that go farthest of one kind of coordinate, in the order of their coordinates.
fn lines<'a>(motion: &'a Motion<'_>, kind: CoordinateKind, quantity: Quantity) -> Chart<'a> {
    let (system, source) = (motion.system, motion.peaks);
    let peak = |row: usize| source.largest(quantity, row);
    let own = (0..system.len()).filter(|row| system.kind_of(*row) == kind);
    let mut chosen: Vec<usize> = own.collect();
    let count = chosen.len();
    if count > LINES {
        sort_by_number(&mut chosen, |i| -peak(*i).1.abs());
        chosen.truncate(LINES);
        chosen.sort_unstable();
    }
    let when = match source.is_between() {
        true => "between samples too",
        false => "at a sample",
    };
    let axis = quantity.axis(kind);
    let mut caption = format!("Rings: the largest {}, {when}.", axis.quantity);
    if let Some(doubts) = doubts(motion.trajectory) {
        caption += &format!(" {doubts}: no bound is known for them.");
    }
    if count > LINES {
        caption += &format!(" Drawn are the {LINES} of {count} that go farthest.");
    }
    let series = chosen.into_iter().map(|row| {
        let outline = source.outline(quantity, motion.trajectory, row);
        let (time, most) = peak(row);
        Series {
            name: crate::report::plot::shorten(&system.names()[row], 14),
            note: format!(
                "{} {} at {} s",
                number::significant(most),
                axis.unit,
                number::significant(time)
            ),
            len: outline.len(),
            point: Box::new(move |k| outline.point(k)),
            marks: vec![(time, most)],
            joined: true,
        }
    });
    let mut heading = axis.quantity.clone();
    heading[..1].make_ascii_uppercase();
    Chart {
        heading,
        x: Axis::linear("time", "s"),
        series: series.collect(),
        y: axis,
        behind: motion.behind.clone(),
        caption,
    }
}
