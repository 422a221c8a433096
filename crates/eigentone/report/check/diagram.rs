//! The work-precision diagram.

use eigentone_check::WorkPrecision;

use super::measured;
use crate::report::axis::Axis;
use crate::report::plot::{Line, Plot, Ring};

/// What lies below is rounding of the answer to doubles, and is drawn there.
const LEAST: f64 = 1e-18;

pub(super) fn of<'a>(title: &str, response: &'a WorkPrecision) -> Plot<'a> {
    let rows = &response.rows;
    let place = |row: usize| {
        let measurement = measured(&rows[row])?;
        let error = measurement.error?.displacement;
        error
            .is_finite()
            .then_some((error.max(LEAST), measurement.time.median))
    };
    let mut names: Vec<&str> = Vec::new();
    for row in rows {
        if measured(row).is_some() && !names.contains(&row.method) {
            names.push(row.method);
        }
    }
    let lines = names.into_iter().filter_map(|name| {
        let of_method = (0..rows.len()).filter(|row| rows[*row].method == name);
        let points: Vec<(f64, f64)> = of_method.filter_map(place).collect();
        (!points.is_empty()).then(|| Line::new(name, points.len(), move |k| points[k]).marked())
    });
    let pick = response.pick.as_ref().and_then(|pick| place(pick.row));
    Plot {
        title: title.to_owned(),
        x: Axis::logarithmic("largest error of a displacement, relative to the peak", ""),
        y: Axis::logarithmic("run time", "s"),
        lines: lines.collect(),
        ring: pick.map(|at| Ring {
            at,
            text: "picked".to_owned(),
        }),
    }
}
