//! A chart of lines over common axes, in the colours of the page, with its legend below.

use std::fmt::Write;

use crate::report::axis::{Axis, Range, Ruler, Scale};
use crate::report::plot::{escape, shorten};
use crate::report::thinned::Thinned;

const WIDTH: f64 = 520.0;
const HEIGHT: f64 = 320.0;
const LEFT: f64 = 74.0;
const RIGHT: f64 = WIDTH - 14.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = HEIGHT - 48.0;
/// Colours that the style has for lines.
pub(super) const COLOURS: usize = 7;
/// With so many and the colours, the first 42 lines all differ.
const DASHES: [&str; 6] = ["", "7 3", "2 3", "8 3 2 3", "13 3", "8 3 2 3 2 3"];
/// A line this many times longer than the drawing is wide fills an area, where dashes are noise.
const DENSE: f64 = 12.0;
/// Letters of a name in the legend.
const LETTERS: usize = 40;

/// A line through points that are asked for by their index, as often as needed.
pub(super) struct Series<'a> {
    pub(super) name: String,
    pub(super) len: usize,
    pub(super) point: Box<dyn Fn(usize) -> (f64, f64) + 'a>,
    /// Points that stand out.
    pub(super) marks: Vec<(f64, f64)>,
}

pub(super) struct Chart<'a> {
    pub(super) heading: String,
    pub(super) x: Axis,
    pub(super) y: Axis,
    /// The first is drawn on top.
    pub(super) series: Vec<Series<'a>>,
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
        let x = Ruler::of(&self.x, xs, 0.0, LEFT, RIGHT);
        let y = Ruler::of(&self.y, ys, 0.05, BOTTOM, TOP);
        let heading = escape(&self.heading);
        let mut out = format!(
            "<figure>\n<h3>{heading}</h3>\n<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{heading}\" font-size=\"13\">\n"
        );
        axes(&mut out, &x, &y);
        out.push_str("<g>\n");
        let mut styles = vec![String::new(); self.series.len()];
        for (index, series) in self.series.iter().enumerate().rev() {
            styles[index] = self.draw(&mut out, index, series, &x, &y);
        }
        out.push_str("</g>\n</svg>\n");
        let names = self.series.iter().map(|series| series.name.as_str());
        out.push_str(&legend(names.zip(&styles)));
        if !self.caption.is_empty() {
            let _ = writeln!(out, "<figcaption>{}</figcaption>", escape(&self.caption));
        }
        out + "</figure>\n"
    }

    /// The points that can be shown.
    fn points<'b>(&'b self, series: &'b Series<'_>) -> impl Iterator<Item = (f64, f64)> + 'b {
        let shown =
            |scale: Scale, value: f64| value.is_finite() && (scale == Scale::Linear || value > 0.0);
        (0..series.len)
            .map(|index| (series.point)(index))
            .filter(move |(x, y)| shown(self.x.scale, *x) && shown(self.y.scale, *y))
    }

    /// Draws a line and its marks, and gives the style that the legend shows.
    fn draw(
        &self,
        out: &mut String,
        index: usize,
        series: &Series<'_>,
        x: &Ruler,
        y: &Ruler,
    ) -> String {
        let places = self
            .points(series)
            .map(|(px, py)| (x.place(px), y.place(py)));
        let places: Vec<(f64, f64)> = Thinned::of(places).collect();
        let mut path = String::new();
        for (k, (px, py)) in places.iter().enumerate() {
            let letter = if k == 0 { 'M' } else { 'L' };
            let _ = write!(path, "{letter}{px:.1} {py:.1}");
        }
        if places.len() == 1 {
            path.push_str("h0"); // a dot
        }
        let length: f64 = places.windows(2).map(|p| (p[1].1 - p[0].1).abs()).sum();
        let style = if length > DENSE * (RIGHT - LEFT) {
            " stroke-opacity=\"0.65\"".to_owned()
        } else {
            dashes(index)
        };
        if !path.is_empty() {
            let _ = writeln!(
                out,
                "<path class=\"l s{}\" d=\"{path}\"{style}/>",
                index % COLOURS
            );
        }
        // A peak may leave the doubles.
        let shown = |(px, py): &&(f64, f64)| px.is_finite() && py.is_finite();
        for (px, py) in series.marks.iter().filter(shown) {
            let _ = writeln!(
                out,
                "<circle class=\"mark s{}\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"4.5\"/>",
                index % COLOURS,
                x.place(*px),
                y.place(*py)
            );
        }
        style
    }
}

/// Grid, tick labels and what the axes show.
pub(super) fn axes(out: &mut String, x: &Ruler, y: &Ruler) {
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
    let _ = writeln!(
        out,
        "<path class=\"a\" d=\"M{left} {top}V{bottom}H{right}\"/>\n<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\n<text transform=\"translate(14 {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
        f64::midpoint(left, right),
        bottom + 38.0,
        escape(&x.label),
        f64::midpoint(top, bottom),
        escape(&y.label),
    );
}

fn dashes(index: usize) -> String {
    match DASHES[index % DASHES.len()] {
        "" => String::new(),
        dashes => format!(" stroke-dasharray=\"{dashes}\""),
    }
}

fn legend<'a>(entries: impl Iterator<Item = (&'a str, &'a String)>) -> String {
    let mut out = String::from("<ul class=\"legend\">\n");
    for (index, (name, style)) in entries.enumerate() {
        let _ = writeln!(
            out,
            "<li><svg viewBox=\"0 0 30 12\" aria-hidden=\"true\"><path class=\"l s{}\" d=\"M1 6H29\"{}/></svg><span>{}</span></li>",
            index % COLOURS,
            style,
            escape(&shorten(name, LETTERS)),
        );
    }
    out + "</ul>\n"
}
