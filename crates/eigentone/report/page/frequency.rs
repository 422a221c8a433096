//! Magnitudes of frequency responses, one chart for each unit, and what is notable in them.

use std::f64::consts::TAU;

use super::chart::{Chart, LINES, Series};
use super::html::{remark, table};
use crate::report::axis::Axis;
use crate::report::frequency::FrequencyReport;

pub(super) fn body(report: &FrequencyReport<'_>) -> String {
    let functions = report.functions.functions();
    let mut units: Vec<String> = Vec::new();
    for function in functions {
        let unit = report.unit(function);
        if !units.contains(&unit) {
            units.push(unit);
        }
    }
    let frequencies = report.functions.frequencies();
    let chart = |unit: &String| {
        let own = functions.iter().enumerate();
        let own = own.filter(|(_, function)| report.unit(function) == *unit);
        let count = own.clone().count();
        let mut caption = "Rings: peaks, at their true places.".to_owned();
        if count > LINES {
            caption += &format!(" Drawn are the first {LINES} of {count}.");
        }
        let series = own.take(LINES).map(|(index, function)| {
            let features = report.features.and_then(|features| features.get(index));
            let peaks = features.into_iter().flat_map(|features| features.peaks());
            let marks = peaks
                .filter(|peak| report.shows(peak))
                .filter_map(|peak| Some((peak.frequency().0 / TAU, peak.gain()?.0)));
            Series {
                name: report.name(function),
                note: String::new(),
                len: frequencies.len(),
                point: Box::new(move |k| {
                    let known = function.values()[k].known();
                    let size = known.map_or(f64::NAN, |(value, _)| value.norm());
                    (frequencies[k] / TAU, size)
                }),
                marks: marks.collect(),
                joined: true,
            }
        });
        let chart = Chart {
            heading: "Magnitude".to_owned(),
            x: Axis::logarithmic("frequency", "Hz"),
            y: Axis::logarithmic("|H|", unit),
            series: series.collect(),
            behind: Vec::new(),
            caption,
        };
        chart.figure()
    };
    let charts: String = units.iter().map(chart).collect();
    let mut body = format!("<div class=\"cards\">\n{charts}</div>\n");
    if let Some(features) = report.features {
        body += &table(&report.notable(features));
        body += &remark(&report.meaning());
        body += &remark(&report.completeness(features));
    }
    body
}
