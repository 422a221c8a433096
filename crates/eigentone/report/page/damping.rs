//! Damping ratios on a logarithmic axis, where lightly damped roots lie apart.

use eigentone_modes::Modes;

use super::chart::{Chart, Series};
use crate::report::axis::Axis;

/// Of the modes that oscillate and are damped, or grow; nothing where there are fewer than two.
pub(super) fn figure(modes: &Modes) -> Option<String> {
    let ratios = |sign: f64| -> Vec<(f64, f64)> {
        let known = modes.iter().filter_map(|mode| {
            let ratio = sign * mode.damping_ratio()?;
            (ratio > 0.0).then_some((mode.natural_frequency().hertz(), ratio))
        });
        known.collect()
    };
    let kinds = [("damped, ζ", ratios(1.0)), ("growing, −ζ", ratios(-1.0))];
    let count: usize = kinds.iter().map(|(_, points)| points.len()).sum();
    let oscillating = modes
        .iter()
        .filter(|mode| mode.eigenvalue().value.im != 0.0);
    let left_out = oscillating.count() - count;
    let series = kinds.into_iter().filter(|(_, points)| !points.is_empty());
    let series = series.map(|(name, points)| Series {
        name: name.to_owned(),
        note: String::new(),
        len: points.len(),
        point: Box::new(move |k| points[k]),
        marks: Vec::new(),
        joined: false,
    });
    let mut caption = "Each dot is one oscillating mode.".to_owned();
    if left_out > 0 {
        caption +=
            &format!(" Not shown: {left_out} without damping or without a known damping ratio.");
    }
    let chart = Chart {
        heading: "Damping ratios".to_owned(),
        x: Axis::logarithmic("natural frequency", "Hz"),
        y: Axis::logarithmic("damping ratio", ""),
        series: series.collect(),
        behind: Vec::new(),
        caption,
    };
    (count > 1).then(|| chart.figure())
}
