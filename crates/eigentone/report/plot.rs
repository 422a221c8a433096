//! Line plots as SVG: quantities against time, and errors against run time on logarithmic axes.

use std::fmt::Write;

use super::axis::{Axis, Range, Ruler, Scale};
use super::table::visible;
use super::thinned::{Thinned, apart};

/// Fonts that are there without being loaded.
pub(super) const FONT: &str = "system-ui, 'Segoe UI', 'DejaVu Sans', Helvetica, Arial, sans-serif";

/// Size of the whole drawing.
const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 540.0;
/// Edges of the drawing area; the legend stands to the right of it, and takes what it needs.
const LEFT: f64 = 84.0;
const TOP: f64 = 56.0;
const BOTTOM: f64 = 478.0;

/// Colours that remain apart for colour-blind readers on white (Okabe & Ito 2008, without the
/// yellow, which white swallows).
const COLOURS: [&str; 7] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000",
];
/// Dash patterns; as their number and that of the colours have no common divisor, the first 42
/// lines all differ.
const DASHES: [&str; 6] = ["", "9 4", "2 3", "9 3 2 3", "16 4", "9 3 2 3 2 3"];
/// Lines that the legend has room for.
const LEGEND: usize = 18;
/// Letters of a legend entry that fit, and the room a letter needs at most on average.
const LETTERS: usize = 24;
const LETTER: f64 = 8.6;
/// Half the width of a dot, and how many of one line are drawn so large, with a rim that parts them.
const DOT: f64 = 3.2;
const MANY: usize = 50;
const RIM: &str = r##" stroke="#ffffff" stroke-width="0.8""##;
/// A line this many times longer than the drawing is wide fills an area, where dashes are noise.
const DENSE: f64 = 12.0;

/// One line of a plot: points in the order of their x.
pub struct Line<'a> {
    name: String,
    len: usize,
    point: Box<dyn Fn(usize) -> (f64, f64) + 'a>,
    look: Look,
}

/// How the points of a line are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Look {
    Joined,
    Marked,
    Dots,
    /// A stroke from the lower edge to the upper one at each x.
    Upright,
    /// A band from the lower edge to the upper one between two x.
    Shaded,
}

impl<'a> Line<'a> {
    /// A line through `len` points, given by their index; they are asked for as often as needed
    /// and never all kept. Points that are not finite are left out.
    pub fn new(name: &str, len: usize, point: impl Fn(usize) -> (f64, f64) + 'a) -> Line<'a> {
        Line {
            name: name.to_owned(),
            len,
            point: Box::new(point),
            look: Look::Joined,
        }
    }

    /// Strokes across the whole height at so many instants, by their index.
    pub fn upright(name: &str, len: usize, x: impl Fn(usize) -> f64 + 'a) -> Line<'a> {
        Line {
            look: Look::Upright,
            ..Line::new(name, len, move |k| (x(k), 0.0))
        }
    }

    /// Bands across the whole height from one x to another, so many, by their index.
    pub fn shaded(name: &str, len: usize, ends: impl Fn(usize) -> [f64; 2] + 'a) -> Line<'a> {
        Line {
            look: Look::Shaded,
            ..Line::new(name, 2 * len, move |k| (ends(k / 2)[k % 2], 0.0))
        }
    }

    /// Dots alone, without a line through them.
    pub fn dots(self) -> Line<'a> {
        Line {
            look: Look::Dots,
            ..self
        }
    }

    /// The same line with a dot on every point.
    pub fn marked(self) -> Line<'a> {
        Line {
            look: Look::Marked,
            ..self
        }
    }
}

/// A plot of lines over common axes.
///
/// ```
/// use eigentone::report::{Axis, Line, Plot};
///
/// let plot = Plot {
///     title: "A swing".to_owned(),
///     x: Axis::linear("time", "s"),
///     y: Axis::linear("displacement", "m"),
///     lines: vec![Line::new("m", 100, |i| (0.1 * i as f64, (0.1 * i as f64).cos()))],
///     ring: None,
/// };
/// assert!(plot.svg().starts_with("<svg"));
/// ```
pub struct Plot<'a> {
    /// What stands above it.
    pub title: String,
    /// The axis to the right.
    pub x: Axis,
    /// The axis upwards.
    pub y: Axis,
    /// The lines; the first is drawn on top.
    pub lines: Vec<Line<'a>>,
    /// A point that stands out, if there is one.
    pub ring: Option<Ring>,
}

/// A ring about a point, and a word beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    /// The point.
    pub at: (f64, f64),
    /// The word.
    pub text: String,
}

impl Plot<'_> {
    /// The plot as one SVG document with a `viewBox`, on a white card. Lines with more points than
    /// the drawing has columns keep the first, lowest, highest and last of each column, so that no
    /// extreme is lost.
    pub fn svg(&self) -> String {
        let (mut xs, mut ys, mut dots) = (Range::NONE, Range::NONE, Range::NONE);
        for line in &self.lines {
            for (x, y) in self.points(line) {
                xs.include(x);
                if matches!(line.look, Look::Dots | Look::Marked) {
                    dots.include(x);
                }
                if !matches!(line.look, Look::Upright | Look::Shaded) {
                    ys.include(y);
                }
            }
        }
        if let Some(Ring { at, .. }) = &self.ring {
            xs.include(at.0);
            ys.include(at.1);
        }
        let right = self.right();
        // The frame would cut dots at either end.
        let is_cut = dots.low <= xs.low || dots.high >= xs.high;
        let margin = if is_cut { 0.02 } else { 0.0 };
        let x = Ruler::of(&self.x, xs, margin, LEFT, right);
        let y = Ruler::of(&self.y, ys, 0.04, BOTTOM, TOP);
        let mut svg = String::new();
        self.frame(&mut svg, &x, &y);
        let _ = writeln!(
            svg,
            r##"<g clip-path="url(#area)" fill="none" stroke-width="1.8" stroke-linejoin="round" stroke-linecap="round">"##
        );
        let mut strokes = vec![String::new(); self.lines.len()];
        for (index, line) in self.lines.iter().enumerate().rev() {
            strokes[index] = self.draw(&mut svg, index, line, &x, &y);
        }
        svg.push_str("</g>\n");
        if let Some(ring) = &self.ring {
            draw_ring(&mut svg, ring, &x, &y);
        }
        self.legend(&mut svg, &strokes);
        svg.push_str("</svg>\n");
        svg
    }

    /// The points that can be shown.
    fn points<'b>(&'b self, line: &'b Line<'_>) -> impl Iterator<Item = (f64, f64)> + 'b {
        let shown =
            |scale: Scale, value: f64| value.is_finite() && (scale == Scale::Linear || value > 0.0);
        (0..line.len)
            .map(|index| (line.point)(index))
            .filter(move |(x, y)| shown(self.x.scale, *x) && shown(self.y.scale, *y))
    }

    /// Where the drawing area ends, so that the longest name fits beside it.
    fn right(&self) -> f64 {
        let letters = self.lines.iter().map(|line| line.name.chars().count());
        let least = if self.lines.len() > LEGEND { 10 } else { 6 };
        let longest = letters.max().unwrap_or(0).clamp(least, LETTERS);
        WIDTH - 70.0 - LETTER * longest as f64
    }

    fn frame(&self, svg: &mut String, x: &Ruler, y: &Ruler) {
        let right = x.to;
        let title = escape(&self.title);
        let _ = write!(
            svg,
            r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-labelledby="title" font-family="{FONT}" font-size="14" fill="#222222">
<title id="title">{title}</title>
<defs><clipPath id="area"><rect x="{LEFT}" y="{TOP}" width="{}" height="{}"/></clipPath></defs>
<rect x="0.5" y="0.5" width="{}" height="{}" rx="8" fill="#ffffff" stroke="#d0d0d0"/>
"##,
            right - LEFT,
            BOTTOM - TOP,
            WIDTH - 1.0,
            HEIGHT - 1.0,
        );
        let title = shorten(&self.title, 88);
        // Bold letters are at most about 0.66 of their size wide on average.
        let room = (WIDTH - LEFT - 16.0) / (0.66 * title.chars().count().max(1) as f64);
        let _ = writeln!(
            svg,
            r##"<text x="{LEFT}" y="34" font-size="{:.1}" font-weight="600">{}</text>"##,
            room.min(18.0),
            escape(&title)
        );
        for tick in &x.ticks {
            let at = tick.at;
            let colour = if tick.zero { "#8a8a8a" } else { "#e4e4e4" };
            let _ = writeln!(
                svg,
                r##"<path d="M{at:.2} {TOP}V{BOTTOM}" stroke="{colour}"/><text x="{at:.2}" y="{}" text-anchor="middle">{}</text>"##,
                BOTTOM + 20.0,
                tick.label
            );
        }
        for tick in &y.ticks {
            let at = tick.at;
            let colour = if tick.zero { "#8a8a8a" } else { "#e4e4e4" };
            let _ = writeln!(
                svg,
                r##"<path d="M{LEFT} {at:.2}H{right}" stroke="{colour}"/><text x="{}" y="{:.2}" text-anchor="end">{}</text>"##,
                LEFT - 8.0,
                at + 5.0,
                tick.label
            );
        }
        let _ = writeln!(
            svg,
            r##"<path d="M{LEFT} {TOP}V{BOTTOM}H{right}" fill="none" stroke="#444444"/>
<text x="{}" y="{}" text-anchor="middle">{}</text>
<text transform="translate(22 {}) rotate(-90)" text-anchor="middle">{}</text>"##,
            f64::midpoint(LEFT, right),
            BOTTOM + 46.0,
            escape(&x.label),
            f64::midpoint(TOP, BOTTOM),
            escape(&y.label),
        );
    }

    /// Draws a line, and gives the stroke that the legend shows.
    fn draw(
        &self,
        svg: &mut String,
        index: usize,
        line: &Line<'_>,
        x: &Ruler,
        y: &Ruler,
    ) -> String {
        if let Look::Upright | Look::Shaded = line.look {
            return self.draw_across(svg, index, line, x);
        }
        let places = self.points(line).map(|(px, py)| (x.place(px), y.place(py)));
        let places: Vec<(f64, f64)> = match line.look {
            Look::Dots => apart(places),
            _ => Thinned::of(places).collect(),
        };
        let Some(((x0, y0), rest)) = places.split_first() else {
            return stroke(index);
        };
        let mut path = format!("M{x0:.1} {y0:.1}");
        for (px, py) in rest {
            let _ = write!(path, "L{px:.1} {py:.1}");
        }
        let pairs = places.windows(2);
        let length: f64 = pairs.map(|p| (p[1].1 - p[0].1).abs()).sum();
        let stroke = if length > DENSE * (x.to - x.from) {
            let colour = COLOURS[index % COLOURS.len()];
            format!(r##" stroke="{colour}" stroke-opacity="0.6""##)
        } else {
            stroke(index)
        };
        if line.look != Look::Dots {
            let _ = writeln!(svg, r##"<path d="{path}"{stroke}/>"##);
        }
        if line.look != Look::Joined {
            let size = match places.len() {
                // A point by itself has no line that leads the eye to it.
                1 => 5.0,
                2..=MANY => DOT,
                _ => 0.6 * DOT,
            };
            places
                .iter()
                .for_each(|place| mark(svg, index, *place, size));
        }
        stroke
    }

    /// Draws what crosses the whole height.
    fn draw_across(&self, svg: &mut String, index: usize, line: &Line<'_>, x: &Ruler) -> String {
        let colour = COLOURS[index % COLOURS.len()];
        let places: Vec<f64> = self.points(line).map(|(px, _)| x.place(px)).collect();
        let mut path = String::new();
        if line.look == Look::Shaded {
            for ends in places.chunks_exact(2) {
                let (from, to) = (ends[0], ends[1].max(ends[0] + 0.5));
                let _ = write!(path, "M{from:.1} {TOP}V{BOTTOM}H{to:.1}V{TOP}z");
            }
            let stroke = format!(r##" stroke="{colour}" stroke-opacity="0.25""##);
            let fill = format!(r##" fill="{colour}" fill-opacity="0.12" stroke="none""##);
            let _ = writeln!(svg, r##"<path d="{path}"{fill}/>"##);
            return stroke;
        }
        // Many in one column are one.
        let mut last = f64::NEG_INFINITY;
        for place in places {
            if place - last >= 0.5 {
                let _ = write!(path, "M{place:.1} {TOP}V{BOTTOM}");
                last = place;
            }
        }
        let stroke = format!(r##" stroke="{colour}""##);
        let _ = writeln!(svg, r##"<path d="{path}"{stroke} stroke-width="0.7"/>"##);
        stroke
    }

    fn legend(&self, svg: &mut String, strokes: &[String]) {
        let count = self.lines.len();
        let shown = if count > LEGEND { LEGEND - 1 } else { count };
        let x = self.right() + 18.0;
        for (index, line) in self.lines.iter().take(shown).enumerate() {
            let y = TOP + 12.0 + 23.0 * index as f64;
            let width = if line.look == Look::Shaded { 12.0 } else { 2.2 };
            if line.look != Look::Dots {
                let _ = writeln!(
                    svg,
                    r##"<path d="M{x} {y}h34" fill="none" stroke-width="{width}"{}/>"##,
                    strokes[index],
                );
            }
            let _ = writeln!(
                svg,
                r##"<text x="{}" y="{}">{}</text>"##,
                x + 42.0,
                y + 5.0,
                escape(&shorten(&line.name, LETTERS)),
            );
            if let Look::Marked | Look::Dots = line.look {
                mark(svg, index, (x + 17.0, y), DOT);
            }
        }
        if shown < count {
            let _ = writeln!(
                svg,
                r##"<text x="{x}" y="{}" fill="#666666">and {} more</text>"##,
                TOP + 17.0 + 23.0 * shown as f64,
                count - shown
            );
        }
    }
}

/// The word stands where there is more room.
fn draw_ring(svg: &mut String, ring: &Ring, x: &Ruler, y: &Ruler) {
    const RADIUS: f64 = 10.0;
    let (px, py) = (x.place(ring.at.0), y.place(ring.at.1));
    let right = px < f64::midpoint(x.from, x.to);
    let (side, anchor) = if right { (1.0, "start") } else { (-1.0, "end") };
    let _ = writeln!(
        svg,
        r##"<circle cx="{px:.1}" cy="{py:.1}" r="{RADIUS}" fill="none" stroke="#222222" stroke-width="1.6"/><text x="{:.1}" y="{:.1}" text-anchor="{anchor}" font-weight="600">{}</text>"##,
        px + side * (RADIUS + 5.0),
        py + 5.0,
        escape(&ring.text)
    );
}

/// A dot on a line; where colours come round again, a square and then a diamond.
fn mark(svg: &mut String, index: usize, (x, y): (f64, f64), size: f64) {
    let colour = COLOURS[index % COLOURS.len()];
    let shape = match index / COLOURS.len() % 3 {
        0 => format!(r#"circle cx="{x:.1}" cy="{y:.1}" r="{size}""#),
        1 => {
            let half = 0.9 * size;
            let (left, top, side) = (x - half, y - half, 2.0 * half);
            format!(r#"rect x="{left:.1}" y="{top:.1}" width="{side:.1}" height="{side:.1}""#)
        }
        _ => {
            let half = 1.3 * size;
            format!(
                r#"path d="M{:.1} {y:.1}l{half:.1} {half:.1} {half:.1} -{half:.1} -{half:.1} -{half:.1}z""#,
                x - half
            )
        }
    };
    let rim = if size < DOT { "" } else { RIM };
    let _ = writeln!(svg, r##"<{shape} fill="{colour}"{rim}/>"##);
}

/// Colour and dashes of a line.
fn stroke(index: usize) -> String {
    let colour = COLOURS[index % COLOURS.len()];
    match DASHES[index % DASHES.len()] {
        "" => format!(r##" stroke="{colour}""##),
        dashes => format!(r##" stroke="{colour}" stroke-dasharray="{dashes}""##),
    }
}

/// The text, or its beginning and an ellipsis, which parts no number or word where there is a gap in the second half.
pub(super) fn shorten(text: &str, letters: usize) -> String {
    if text.chars().count() <= letters {
        return text.to_owned();
    }
    let kept: String = text.chars().take(letters - 1).collect();
    match kept.rfind(' ') {
        Some(gap) if 2 * gap > kept.len() => format!("{} …", kept[..gap].trim_end_matches(',')),
        _ => kept + "…",
    }
}

/// Text for SVG; what XML cannot hold is made visible.
pub(super) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in visible(text).chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot<'a>(lines: Vec<Line<'a>>) -> Plot<'a> {
        Plot {
            title: "A <title> & more".to_owned(),
            x: Axis::linear("time", "s"),
            y: Axis::linear("displacement", "m"),
            lines,
            ring: None,
        }
    }

    /// Where the drawing area of a plot with short names ends.
    const RIGHT: f64 = WIDTH - 70.0 - LETTER * 6.0;

    /// The places of every line's path, top line first.
    fn paths(svg: &str) -> Vec<Vec<(f64, f64)>> {
        let body = svg.split("<g clip-path").nth(1).expect("a group of lines");
        let body = body.split("</g>").next().expect("its end");
        let paths = body
            .lines()
            .filter_map(|line| line.strip_prefix("<path d=\"M"));
        let mut paths: Vec<Vec<(f64, f64)>> = paths
            .map(|line| {
                let data = line.split('"').next().expect("a quote");
                let pairs = data.split('L').map(|pair| {
                    let (x, y) = pair.split_once(' ').expect("x and y");
                    (x.parse().expect("a number"), y.parse().expect("a number"))
                });
                pairs.collect()
            })
            .collect();
        paths.reverse();
        paths
    }

    fn labels(svg: &str) -> Vec<&str> {
        let texts = svg
            .split("<text")
            .skip(1)
            .filter(|text| text.contains("anchor=\"end\"") || text.contains("anchor=\"middle\""))
            .filter_map(|text| text.split('>').nth(1));
        texts.filter_map(|text| text.split('<').next()).collect()
    }

    #[test]
    fn a_spike_of_one_sample_in_a_million_survives() {
        let n = 1_000_000;
        let value = |k: usize| if k == 654_321 { -3.0 } else { (k as f64).sin() };
        let svg = plot(vec![Line::new("m1", n, move |k| (k as f64, value(k)))]).svg();
        let path = &paths(&svg)[0];
        assert!(path.len() < 4 * 850, "{} points", path.len());
        let (x, lowest) =
            path.iter().fold(
                (0.0, 0.0f64),
                |(x, y), p| {
                    if p.1 > y { (p.0, p.1) } else { (x, y) }
                },
            );
        // The drawing runs downwards; 4 % of the range lie below the lowest point.
        let bottom = BOTTOM - (BOTTOM - TOP) * 0.04 / 1.08;
        assert!((lowest - bottom).abs() <= 0.05, "{lowest} {bottom}");
        let at = LEFT + (RIGHT - LEFT) * 654_321.0 / 999_999.0;
        assert!((x - at).abs() <= 1.0, "{x} {at}");
        assert!(path.windows(2).all(|pair| pair[0].0 <= pair[1].0));
    }

    #[test]
    fn no_dot_is_lost_or_cut() {
        let dots = |at: fn(usize) -> (f64, f64)| {
            let svg = plot(vec![Line::new("root", 40, at).dots()]).svg();
            let circles = svg.split("<circle cx=\"").skip(1);
            let places = circles.map(|circle| circle.split('"').next()?.parse::<f64>().ok());
            places.collect::<Option<Vec<f64>>>().expect("places")
        };
        // One stands in the legend.
        let upright = dots(|k| (1.0, k as f64));
        assert_eq!(upright.len(), 41);
        let level = dots(|k| (k as f64, 1.0));
        assert_eq!(level.len(), 41);
        assert!(
            level[..40]
                .iter()
                .all(|x| (LEFT + DOT..=RIGHT - DOT).contains(x))
        );
    }

    #[test]
    fn any_range_of_doubles_is_drawn_inside_the_area() {
        let ranges = [
            (0.0, 0.0),
            (3.5, 3.5),
            (-1e-9, 2e-9),
            (1e-320, 3e-320),
            (-1.7e308, 1.7e308),
            (1.0, 1.0 + 1e-15),
            (-4e5, 1e5),
            (0.0, 1e-3),
        ];
        for (low, high) in ranges {
            let line = Line::new("m", 2, move |k| (k as f64, if k == 0 { low } else { high }));
            let svg = plot(vec![line]).svg();
            assert!(
                !svg.contains("NaN") && !svg.contains("inf"),
                "{low:e} {high:e}: {svg}"
            );
            for (x, y) in &paths(&svg)[0] {
                assert!(
                    (LEFT..=RIGHT).contains(x) && (TOP..=BOTTOM).contains(y),
                    "{low:e}"
                );
            }
            let ticks = svg.matches("text-anchor=\"end\"").count();
            assert!((3..=12).contains(&ticks), "{low:e} {high:e}: {ticks} ticks");
            assert!(labels(&svg).iter().all(|label| label.chars().count() < 24));
        }
        let small = Line::new("m", 2, |k| (k as f64, 2e-9 * k as f64));
        assert!(plot(vec![small]).svg().contains("displacement, 10⁻⁹ m"));
    }

    #[test]
    fn a_reader_can_take_the_value_off_the_axis() {
        let line = Line::new("m", 3, |k| (k as f64, [0.0, 0.3, 0.6][k]));
        let svg = plot(vec![line]).svg();
        // The gridline labelled 0.3 passes through the point at 0.3.
        let y = paths(&svg)[0][1].1;
        let label = svg.lines().find(|line| line.contains(">0.3<"));
        let gridline = label.expect("a label").split(['M', ' ', 'H']);
        let at: f64 = gridline
            .filter_map(|part| part.parse().ok())
            .nth(1)
            .expect("M x y H x");
        assert!((at - y).abs() <= 0.051, "{at} {y}");
    }

    #[test]
    fn names_cannot_break_the_document() {
        let line = Line::new("<script>&\u{1b}\0\"", 1, |_| (0.0, 1.0));
        let svg = plot(vec![line]).svg();
        assert!(!svg.contains("<script") && !svg.chars().any(|c| c.is_control() && c != '\n'));
        let opened = svg.matches('<').count();
        assert_eq!(opened, svg.matches('>').count());
    }

    #[test]
    fn more_lines_than_the_legend_holds_are_counted() {
        let lines = (0..200).map(|i| Line::new("m", 2, move |k| (k as f64, f64::from(i))));
        let svg = plot(lines.collect()).svg();
        assert_eq!(paths(&svg).len(), 200);
        assert!(svg.contains("and 183 more"));
    }

    #[test]
    fn logarithmic_axes_leave_out_what_they_cannot_show() {
        let points = [(1e-5, 1e-13), (1e-4, 0.0), (1e-3, 1e-3), (1e-2, f64::NAN)];
        let line = Line::new("RK4", points.len(), move |k| points[k]).marked();
        let svg = Plot {
            title: "Error against run time".to_owned(),
            x: Axis::logarithmic("run time", "s"),
            y: Axis::logarithmic("error", ""),
            lines: vec![line],
            ring: None,
        }
        .svg();
        assert_eq!(paths(&svg)[0].len(), 2);
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        assert!(labels(&svg).contains(&"10⁻⁴"));
    }
}
