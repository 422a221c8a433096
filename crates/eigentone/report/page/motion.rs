//! Displacements and velocities against time, with their peaks, and their bounds.

use eigentone_modes::Bounds;

use super::chart::{Chart, Series};
use crate::report::analysis::Answer;
use crate::report::axis::Axis;
use crate::report::number;
use crate::report::outline::{Outline, Quantity};
use crate::report::response::doubts;

/// Lines in one chart.
const LINES: usize = 10;

/// The charts of a response.
pub(super) fn figures(answer: &Answer<'_>, names: &[String]) -> String {
    let mut out = String::new();
    let peaks: Vec<(f64, f64)> = answer
        .summary
        .coordinates()
        .iter()
        .map(|one| (one.peak_time, one.peak))
        .collect();
    let caption = match answer.summary.is_between() {
        true => "Rings: the largest displacement at any time.",
        false => "Rings: the largest displacement at a sample.",
    };
    let axis = Axis::linear("displacement", "m");
    let chart = lines(answer, names, Quantity::Displacement, axis, &peaks, caption);
    out.push_str(&chart.figure());
    let peaks: Vec<(f64, f64)> = answer
        .summary
        .coordinates()
        .iter()
        .map(|one| (one.fastest_time, one.fastest))
        .collect();
    let caption = match answer.summary.is_between() {
        true => "Rings: the largest velocity at any time.",
        false => "Rings: the largest velocity at a sample.",
    };
    let axis = Axis::linear("velocity", "m/s");
    let chart = lines(answer, names, Quantity::Velocity, axis, &peaks, caption);
    out + &chart.figure()
}

/// Beside the largest, bounds below this are not drawn: at the first instant only what was given is rounded.
const NEGLIGIBLE: f64 = 1e-9;

/// How far displacements and velocities may be off, against time.
pub(super) fn bounds(answer: &Answer<'_>) -> Option<String> {
    let trajectory = answer.trajectory;
    let times = trajectory.times();
    let kinds = [
        ("displacement, m", trajectory.displacement_bound()),
        ("velocity, m/s", trajectory.velocity_bound()),
    ];
    let largest = |bounds: &[Option<f64>]| bounds.iter().flatten().copied().fold(0.0, f64::max);
    let series: Vec<Series<'_>> = kinds
        .into_iter()
        .filter(|(_, bounds)| largest(bounds) > 0.0)
        .map(|(name, bounds)| {
            let least = NEGLIGIBLE * largest(bounds);
            let drawn = move |k: usize| bounds[k].filter(|bound| *bound >= least);
            Series {
                name: name.to_owned(),
                len: times.len(),
                point: Box::new(move |k| (times[k], drawn(k).unwrap_or(f64::NAN))),
                marks: Vec::new(),
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
            caption:
                "Over all coordinates. Where no line is drawn the value is exact, has no bound, or one below \
                 1e−9 of the largest."
                    .to_owned(),
        };
        format!("<div class=\"cards\">\n{}</div>\n", chart.figure())
    })
}

/// The lines that go farthest, in the order of their coordinates.
fn lines<'a>(
    answer: &'a Answer<'_>,
    names: &'a [String],
    quantity: Quantity,
    axis: Axis,
    peaks: &[(f64, f64)],
    caption: &str,
) -> Chart<'a> {
    let mut chosen: Vec<usize> = (0..names.len()).collect();
    if names.len() > LINES {
        chosen.sort_by(|a, b| peaks[*b].1.abs().total_cmp(&peaks[*a].1.abs()));
        chosen.truncate(LINES);
        chosen.sort_unstable();
    }
    let mut caption = caption.to_owned();
    if let Some(doubts) = doubts(answer.trajectory) {
        caption += &format!(" {doubts}: no bound is known for them.");
    }
    if names.len() > LINES {
        caption += &format!(
            " Drawn are the {LINES} of {} that go farthest.",
            names.len()
        );
    }
    let series = chosen.into_iter().map(|row| {
        let outline = Outline::of(quantity, answer.trajectory, answer.summary, row);
        Series {
            name: match peaks.get(row) {
                Some((time, peak)) => format!(
                    "{}: {} {} at {} s",
                    crate::report::plot::shorten(&names[row], 14),
                    number::significant(*peak),
                    axis.unit,
                    number::significant(*time)
                ),
                None => names[row].clone(),
            },
            len: outline.len(),
            point: Box::new(move |k| outline.point(k)),
            marks: peaks.get(row).copied().into_iter().collect(),
        }
    });
    let mut heading = axis.quantity.clone();
    heading[..1].make_ascii_uppercase();
    Chart {
        heading,
        x: Axis::linear("time", "s"),
        series: series.collect(),
        y: axis,
        caption,
    }
}
