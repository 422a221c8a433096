//! A chart of lines over common axes, in the colours of the page: together with a legend below, or, where they are many,
//! each in a panel of its own. The script of the page reads points and axes back from the drawing.

use std::fmt::Write;

use crate::report::axis::{Axis, Range, Ruler, Scale};
use crate::report::plot::{escape, shorten};
use crate::report::thinned::{Thinned, apart};

/// Colours that the style has for lines.
pub(super) const COLOURS: usize = 7;
/// Beside colours, for readers who do not see these.
const DASHES: [&str; 6] = ["", "7 3", "2 3", "8 3 2 3", "13 3", "8 3 2 3 2 3"];
/// A line this many times longer than the drawing is wide fills an area, where dashes are noise.
const DENSE: f64 = 12.0;
/// Letters of a name in the legend, and of the note beside it.
const LETTERS: usize = 40;
/// Lines that can be distinguished in one drawing; more have panels of their own.
const TOGETHER: usize = 8;
/// Lines of one chart that are drawn at all.
pub(super) const LINES: usize = 50;
/// The drawing area in the units of its points, both ways.
const GRID: f64 = 1e5;
/// Points of all lines of a chart, and of one line.
const POINTS: usize = 24_000;
const POINTS_OF_ONE: usize = 3_000;

/// Where the drawing area lies in a drawing, and how many divisions its axes have at most.
struct Frame {
    width: f64,
    height: f64,
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    font: f64,
    divisions: usize,
}

const CARD: Frame = Frame {
    width: 520.0,
    height: 320.0,
    left: 74.0,
    right: 506.0,
    top: 12.0,
    bottom: 272.0,
    font: 13.0,
    divisions: usize::MAX,
};
const PANEL: Frame = Frame {
    width: 260.0,
    height: 130.0,
    left: 58.0,
    right: 250.0,
    top: 10.0,
    bottom: 104.0,
    font: 12.0,
    divisions: 4,
};

/// A line through points that are asked for by their index, as often as needed.
pub(super) struct Series<'a> {
    pub(super) name: String,
    /// What the legend says of it; may be empty.
    pub(super) note: String,
    pub(super) len: usize,
    pub(super) point: Box<dyn Fn(usize) -> (f64, f64) + 'a>,
    /// Points that stand out.
    pub(super) marks: Vec<(f64, f64)>,
    /// Without it, dots.
    pub(super) joined: bool,
}

/// When something acts: bands behind the lines.
#[derive(Clone)]
pub(super) struct Spans {
    pub(super) name: String,
    /// From where to where; a stroke where both are one.
    pub(super) of: Vec<[f64; 2]>,
}

pub(super) struct Chart<'a> {
    pub(super) heading: String,
    pub(super) x: Axis,
    pub(super) y: Axis,
    /// The first is drawn on top.
    pub(super) series: Vec<Series<'a>>,
    pub(super) behind: Vec<Spans>,
    /// Text below; may be empty.
    pub(super) caption: String,
}

impl Chart<'_> {
    /// A figure of its own.
    pub(super) fn figure(&self) -> String {
        let (mut xs, mut ys) = (Range::NONE, Range::NONE);
        for series in &self.series {
            for (x, y) in self.points(series).chain(series.marks.iter().copied()) {
                xs.include(x);
                ys.include(y);
            }
        }
        let together = self.series.len() <= TOGETHER;
        let frame = if together { CARD } else { PANEL };
        // The frame would cut dots at either end.
        let margin = if self.series.iter().all(|series| series.joined) {
            0.0
        } else {
            0.02
        };
        let mut x = Ruler::of(&self.x, xs, margin, frame.left, frame.right);
        let mut y = Ruler::of(&self.y, ys, 0.05, frame.bottom, frame.top);
        x.keep(frame.divisions);
        y.keep(frame.divisions);
        let heading = escape(&self.heading);
        let class = if together { "plot" } else { "plot wide" };
        let mut out = format!("<figure class=\"{class}\">\n<h3>{heading}</h3>\n");
        let all: Vec<usize> = (0..self.series.len()).collect();
        if together {
            let styles = self.drawing(&mut out, &heading, &frame, (&x, &y), &all);
            let entries = self.series.iter().zip(&styles).enumerate();
            let entries = entries.map(|(index, (series, style))| {
                let colour = index % COLOURS;
                format!(
                    "<li><svg viewBox=\"0 0 30 12\" aria-hidden=\"true\"><path class=\"l{} s{colour}\" d=\"{}\"{style}/></svg>{}</li>\n",
                    if series.joined { "" } else { " dots" },
                    if series.joined { "M1 6H29" } else { "M15 6h0" },
                    series.label()
                )
            });
            self.legend(&mut out, &entries.collect::<String>());
        } else {
            let (across, up) = (escape(&x.label), escape(&y.label));
            let _ = writeln!(
                out,
                "<p class=\"soft\">Across: {across}. Up: {up}. All panels have the same axes.</p>\n<div class=\"panels\">"
            );
            for index in all {
                let series = &self.series[index];
                let _ = writeln!(out, "<div class=\"panel\">\n<p>{}</p>", series.label());
                let what = format!("{heading}: {}", escape(&series.name));
                self.drawing(&mut out, &what, &frame, (&x, &y), &[index]);
                out.push_str("</div>\n");
            }
            out.push_str("</div>\n");
            self.legend(&mut out, "");
        }
        if !self.caption.is_empty() {
            let _ = writeln!(out, "<figcaption>{}</figcaption>", escape(&self.caption));
        }
        out + "</figure>\n"
    }

    /// Entries of lines, then of what acts behind them.
    fn legend(&self, out: &mut String, lines: &str) {
        let behind = (self.series.len()..).zip(&self.behind);
        let behind: String = behind
            .map(|(index, spans)| {
                format!(
                    "<li><svg viewBox=\"0 0 30 12\" aria-hidden=\"true\"><path class=\"l band s{}\" d=\"M9 1h12v10h-12z\"/></svg><span class=\"name\">{}</span></li>\n",
                    index % COLOURS,
                    escape(&shorten(&spans.name, LETTERS))
                )
            })
            .collect();
        if !(lines.is_empty() && behind.is_empty()) {
            let _ = writeln!(out, "<ul class=\"legend\">\n{lines}{behind}</ul>");
        }
    }

    /// The points that can be shown.
    fn points<'b>(&'b self, series: &'b Series<'_>) -> impl Iterator<Item = (f64, f64)> + 'b {
        let shown =
            |scale: Scale, value: f64| value.is_finite() && (scale == Scale::Linear || value > 0.0);
        (0..series.len)
            .map(|index| (series.point)(index))
            .filter(move |(x, y)| shown(self.x.scale, *x) && shown(self.y.scale, *y))
    }

    /// Draws the axes and some of the lines, and gives the styles that the legend shows.
    fn drawing(
        &self,
        out: &mut String,
        what: &str,
        frame: &Frame,
        (x, y): (&Ruler, &Ruler),
        lines: &[usize],
    ) -> Vec<String> {
        let Frame {
            width,
            height,
            left,
            right,
            top,
            bottom,
            font,
            ..
        } = frame;
        let _ = writeln!(
            out,
            "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{what}\" font-size=\"{font}\">"
        );
        out.push_str("<g class=\"axes\">\n");
        divisions(out, x, y);
        out.push_str("</g>\n");
        edges(out, x, y);
        if lines.len() == self.series.len() {
            labels(out, x, y);
        }
        let _ = writeln!(
            out,
            "<svg class=\"area\" x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{}\" viewBox=\"0 0 {GRID} {GRID}\" preserveAspectRatio=\"none\" data-x=\"{}\" data-y=\"{}\" data-n=\"{}\">",
            right - left,
            bottom - top,
            described(&self.x, x),
            described(&self.y, y),
            frame.divisions.min(8)
        );
        for (index, spans) in (self.series.len()..).zip(&self.behind) {
            let (colour, bands) = (index % COLOURS, bands(&spans.of, x, (right - left) * 2.0));
            let _ = writeln!(
                out,
                "<path class=\"l band s{colour}\" data-m=\"{index}\" d=\"{bands}\"/>"
            );
        }
        let mut styles = vec![String::new(); lines.len()];
        for (style, index) in styles.iter_mut().zip(lines).rev() {
            *style = self.draw(out, *index, x, y);
        }
        out.push_str("</svg>\n</svg>\n");
        styles
    }

    /// Draws a line and its marks, and gives the style that the legend shows.
    fn draw(&self, out: &mut String, index: usize, x: &Ruler, y: &Ruler) -> String {
        let series = &self.series[index];
        // Each column keeps four points at most.
        let columns = match series.joined {
            true => (POINTS / self.series.len() / 4).min(POINTS_OF_ONE / 4) as f64,
            false => x.to - x.from,
        };
        let across = columns / (x.to - x.from);
        let places = self.points(series);
        let places = places.map(|(px, py)| ((x.place(px) - x.from) * across, y.place(py)));
        let places: Vec<(f64, f64)> = match series.joined {
            true => Thinned::of(places).collect(),
            false => apart(places),
        };
        let on_grid = |place: f64, from: f64, to: f64| {
            ((place - from) / (to - from) * GRID)
                .round()
                .clamp(-1e9, 1e9) as i64
        };
        let grid: Vec<(i64, i64)> = places
            .iter()
            .map(|(px, py)| (on_grid(*px, 0.0, columns), on_grid(*py, y.to, y.from)))
            .collect();
        let length: f64 = places.windows(2).map(|p| (p[1].1 - p[0].1).abs()).sum();
        let dotted = !series.joined || grid.len() == 1;
        let style = if dotted {
            String::new()
        } else if length > DENSE * (x.to - x.from) {
            " stroke-opacity=\"0.65\"".to_owned()
        } else {
            match DASHES[index % DASHES.len()] {
                "" => String::new(),
                dashes if self.series.len() <= TOGETHER => {
                    format!(" stroke-dasharray=\"{dashes}\"")
                }
                _ => String::new(), // alone in its panel
            }
        };
        let colour = index % COLOURS;
        if !grid.is_empty() {
            let _ = writeln!(
                out,
                "<path class=\"l{} s{colour}\" data-i=\"{index}\" d=\"{}\"{style}/>",
                if dotted { " dots" } else { "" },
                if dotted { dots(&grid) } else { path(&grid) }
            );
        }
        // A peak may leave the doubles.
        let shown = |(px, py): &&(f64, f64)| px.is_finite() && py.is_finite();
        let marks = series.marks.iter().filter(shown).map(|(px, py)| {
            (
                on_grid(x.place(*px), x.from, x.to),
                on_grid(y.place(*py), y.to, y.from),
            )
        });
        let marks: Vec<(i64, i64)> = marks.collect();
        if !marks.is_empty() {
            let dots = dots(&marks);
            let _ = writeln!(
                out,
                "<path class=\"l ring s{colour}\" data-m=\"{index}\" d=\"{dots}\"/><path class=\"l hole\" data-m=\"{index}\" d=\"{dots}\"/>"
            );
        }
        style
    }
}

impl Series<'_> {
    /// What the legend says.
    fn label(&self) -> String {
        let name = escape(&shorten(&self.name, LETTERS));
        let note = match self.note.as_str() {
            "" => String::new(),
            note => format!(": {}", escape(&shorten(note, LETTERS))),
        };
        format!("<span><span class=\"name\">{name}</span>{note}</span>")
    }
}

/// What the script has to know of an axis: how it is divided, the power of ten, both ends divided by it (or their logarithms),
/// the quantity and the unit.
fn described(axis: &Axis, ruler: &Ruler) -> String {
    let scale = match axis.scale {
        Scale::Linear => "linear",
        Scale::Logarithmic => "logarithmic",
    };
    let Ruler {
        power, low, high, ..
    } = ruler;
    let words = format!(
        "{scale}|{power}|{low:e}|{high:e}|{}|{}",
        axis.quantity, axis.unit
    );
    escape(&words)
}

/// A line in steps from point to point, which are short to write.
fn path(points: &[(i64, i64)]) -> String {
    let mut out = format!("M{} {}l", points[0].0, points[0].1);
    for pair in points.windows(2) {
        for step in [pair[1].0 - pair[0].0, pair[1].1 - pair[0].1] {
            // A sign parts numbers as well as a space does.
            if step >= 0 && !out.ends_with('l') {
                out.push(' ');
            }
            let _ = write!(out, "{step}");
        }
    }
    out
}

/// Lines without length, which round ends make dots whatever the scales are.
fn dots(points: &[(i64, i64)]) -> String {
    let each = points.iter();
    each.map(|(x, y)| format!("M{x} {y}h0")).collect()
}

/// Bands over the whole height, at most so many; those that would not be separated are one.
fn bands(spans: &[[f64; 2]], x: &Ruler, most: f64) -> String {
    let on_grid = |value: f64| ((x.place(value) - x.from) / (x.to - x.from) * GRID).round() as i64;
    let mut last = i64::MIN;
    let mut out = String::new();
    for [from, to] in spans {
        let (from, to) = (on_grid(*from).max(last), on_grid(*to));
        if to <= last {
            continue;
        }
        last = to + (GRID / most) as i64;
        let _ = write!(out, "M{from} 0V{GRID}H{to}V0z");
    }
    out
}

/// Grid, tick labels and what the axes show.
pub(super) fn axes(out: &mut String, x: &Ruler, y: &Ruler) {
    divisions(out, x, y);
    edges(out, x, y);
    labels(out, x, y);
}

/// Grid and tick labels.
fn divisions(out: &mut String, x: &Ruler, y: &Ruler) {
    let (left, right, top, bottom) = (x.from, x.to, y.to, y.from);
    for tick in &x.ticks {
        let class = if tick.zero { "z" } else { "g" };
        // A label at the very edge would leave the drawing.
        let anchor = if tick.at > right - 10.0 {
            "end"
        } else {
            "middle"
        };
        let _ = writeln!(
            out,
            "<path class=\"{class}\" d=\"M{at:.1} {top}V{bottom}\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{}</text>",
            if anchor == "end" {
                right + 10.0
            } else {
                tick.at
            },
            bottom + 18.0,
            tick.label,
            at = tick.at,
        );
    }
    for tick in &y.ticks {
        let class = if tick.zero { "z" } else { "g" };
        let _ = writeln!(
            out,
            "<path class=\"{class}\" d=\"M{left} {at:.1}H{right}\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            left - 6.0,
            tick.at + 4.5,
            tick.label,
            at = tick.at,
        );
    }
}

/// The lines of the axes.
fn edges(out: &mut String, x: &Ruler, y: &Ruler) {
    let (left, right, top, bottom) = (x.from, x.to, y.to, y.from);
    let _ = writeln!(
        out,
        "<path class=\"a\" d=\"M{left} {top}V{bottom}H{right}\"/>"
    );
}

/// What the axes show.
fn labels(out: &mut String, x: &Ruler, y: &Ruler) {
    let _ = writeln!(
        out,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\n<text transform=\"translate(14 {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
        f64::midpoint(x.from, x.to),
        y.from + 38.0,
        escape(&x.label),
        f64::midpoint(y.to, y.from),
        escape(&y.label),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps, added up as a browser does, lead to every point.
    #[test]
    fn a_path_goes_through_its_points() {
        let points = [(0, 5), (7, -3), (7, 12), (100_000, 0), (100_000, -1)];
        let path = path(&points);
        assert_eq!(path, "M0 5l7-8 0 15 99993-12 0-1");
    }

    #[test]
    fn many_lines_have_panels_of_their_own() {
        let chart = |count: usize| {
            let series = (0..count).map(|i| Series {
                name: format!("m{i}"),
                note: String::new(),
                len: 100_000,
                point: Box::new(move |k| (k as f64, ((k * (i + 1)) as f64).sin())),
                marks: Vec::new(),
                joined: true,
            });
            let chart = Chart {
                heading: "Many".to_owned(),
                x: Axis::linear("time", "s"),
                y: Axis::linear("displacement", "m"),
                series: series.collect(),
                behind: Vec::new(),
                caption: String::new(),
            };
            chart.figure()
        };
        let (few, many) = (chart(8), chart(50));
        assert_eq!(few.matches("class=\"area\"").count(), 1);
        assert_eq!(many.matches("class=\"area\"").count(), 50);
        assert_eq!(many.matches("data-i=").count(), 50);
        // However long the motion is.
        assert!(
            few.len() < 400_000 && many.len() < 500_000,
            "{} {}",
            few.len(),
            many.len()
        );
    }
}
