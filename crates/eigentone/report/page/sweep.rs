//! A sweep as one page: curves and maps of its metrics, its roots, and a table.

use super::chart::{Chart, LINES, Series};
use super::html::{Section, document, remark, table};
use crate::report::axis::Axis;
use crate::report::number;
use crate::report::sweep::SweepReport;
use crate::report::table::{Align, Table};
use crate::report::unit;

/// Designs of the table; `sweep.csv` has all.
const ROWS: usize = 500;
/// Roots that are drawn.
const DOTS: usize = 40_000;

/// The page as HTML.
pub(in crate::report) fn html(report: &SweepReport<'_>) -> String {
    let lead = format!(
        "{}: {}. Swept by eigentone {}.",
        number::count(report.designs.len(), "design", "designs"),
        report.table.parameters.join(", "),
        env!("CARGO_PKG_VERSION")
    );
    let mut sections = Vec::new();
    if !report.table.metrics.is_empty() {
        let all = (0..report.table.metrics.len()).map(|k| metric(report, k));
        sections.push(Section {
            id: "metrics",
            heading: "Metrics".to_owned(),
            body: format!("<div class=\"cards\">\n{}</div>\n", all.collect::<String>()),
        });
    }
    if let Some(svg) = report.stability() {
        let note = "Where the largest Re λ is above 0, beyond the red line, motions grow.";
        sections.push(Section {
            id: "stability",
            heading: "Stability".to_owned(),
            body: drawing(&svg) + &remark(note),
        });
    }
    sections.push(Section {
        id: "roots",
        heading: "Roots".to_owned(),
        body: roots(report),
    });
    sections.push(Section {
        id: "designs",
        heading: "Designs".to_owned(),
        body: designs(report),
    });
    document(report.title, &remark(&lead), &sections)
}

fn drawing(svg: &str) -> String {
    format!("<figure class=\"wide\">\n{svg}</figure>\n")
}

/// Curves to read values from, or a map.
fn metric(report: &SweepReport<'_>, k: usize) -> String {
    if let Some(svg) = report.map(k) {
        return drawing(&svg);
    }
    let [x, y] = report.axes(k);
    let mut families = report.families();
    let count = families.len();
    families.truncate(LINES);
    let heading = &report.table.metrics[k];
    let series = families.into_iter().map(|(name, family)| Series {
        name: if name.is_empty() {
            heading.clone()
        } else {
            name
        },
        note: String::new(),
        len: family.len(),
        point: Box::new(move |i| {
            let value = family[i].values.last().copied().unwrap_or(f64::NAN);
            (value, family[i].metrics[k].unwrap_or(f64::NAN))
        }),
        marks: Vec::new(),
        joined: true,
    });
    let chart = Chart {
        heading: heading.clone(),
        x,
        y,
        series: series.collect(),
        behind: Vec::new(),
        caption: match count > LINES {
            true => format!("Drawn are the first {LINES} of {count} curves."),
            false => String::new(),
        },
    };
    chart.figure()
}

/// The root locus.
fn roots(report: &SweepReport<'_>) -> String {
    let (places, count) = (report.places(), report.designs.len());
    let each = (places * count).div_ceil(DOTS).max(1);
    let shown = count.div_ceil(each);
    let series = (0..places.min(LINES)).map(|place| Series {
        name: format!("root {}", place + 1),
        note: String::new(),
        len: shown,
        point: Box::new(move |i| report.root(i * each, place)),
        marks: Vec::new(),
        joined: false,
    });
    let mut remarks = Vec::new();
    if each > 1 {
        remarks.push(format!("Drawn is one design of {each}."));
    }
    let designs = report.designs.iter();
    let doubtful = designs.filter(|design| !design.doubtful_roots.is_empty());
    match doubtful.count() {
        0 => {}
        some => remarks.push(format!(
            "Roots of {some} of {count} designs are doubtful and not drawn; sweep.csv says which."
        )),
    }
    let chart = Chart {
        heading: "Roots of all designs".to_owned(),
        x: Axis::linear("Re λ", "1/s"),
        y: Axis::linear("Im λ", "rad/s"),
        series: series.collect(),
        behind: Vec::new(),
        caption: remarks.join(" "),
    };
    format!("<div class=\"cards\">\n{}</div>\n", chart.figure())
}

fn designs(report: &SweepReport<'_>) -> String {
    let shown = &report.designs[..report.designs.len().min(ROWS)];
    let indices = shown.iter().map(|design| design.index.to_string());
    let mut all = Table::default().column("design", Align::Right, indices);
    for k in 0..report.table.parameters.len() {
        let [name, unit] = report.table.parameter(k);
        let values = shown.iter().map(|design| Some(design.values[k]));
        all = all.column(
            &unit::labelled(name, unit),
            Align::Point,
            number::column(values),
        );
    }
    for k in 0..report.table.metrics.len() {
        let [name, unit] = report.table.metric(k);
        let values = shown.iter().map(|design| design.metrics[k]);
        all = all.column(
            &unit::labelled(name, unit),
            Align::Point,
            number::column(values),
        );
    }
    let mut body = table(&all);
    if shown.len() < report.designs.len() {
        let note = format!(
            "The first {ROWS} of {}; sweep.csv has all.",
            report.designs.len()
        );
        body += &remark(&note);
    }
    body
}
