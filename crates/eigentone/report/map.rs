//! A value over two parameters: tiles in shades, and lines along which it is the same.

use std::fmt::Write;

use super::axis::{Axis, Range, Ruler, Scale};
use super::plot::{FONT, escape, shorten};

/// Values on the product of two lists, which ascend strictly.
pub(super) struct Map<'a> {
    /// What stands above it.
    pub(super) title: String,
    /// To the right, and upwards.
    pub(super) axes: [Axis; 2],
    pub(super) places: [Vec<f64>; 2],
    /// What is shown, and where it is not known.
    pub(super) what: &'a str,
    pub(super) unit: &'a str,
    /// By the places to the right and upwards.
    pub(super) value: Box<dyn Fn(usize, usize) -> Option<f64> + 'a>,
}

const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 560.0;
const LEFT: f64 = 92.0;
const RIGHT: f64 = 790.0;
const TOP: f64 = 56.0;
const BOTTOM: f64 = 488.0;
/// The bar of shades.
const BAR: [f64; 2] = [822.0, 846.0];
/// Shades that are distinguished from each other.
const SHADES: usize = 48;

/// After cividis (Nuñez, Anderton & Renslow 2018), which colour-blind readers see as others do; the lowest first.
const COLOURS: [[f64; 3]; 9] = [
    [0.0, 48.0, 111.0],
    [59.0, 73.0, 108.0],
    [87.0, 93.0, 109.0],
    [112.0, 113.0, 115.0],
    [138.0, 135.0, 121.0],
    [166.0, 157.0, 117.0],
    [195.0, 179.0, 105.0],
    [225.0, 204.0, 85.0],
    [254.0, 232.0, 56.0],
];

/// Shades of this one and above are light.
const LIGHT: usize = SHADES * 9 / 16;

impl Map<'_> {
    /// One SVG document with a `viewBox`, on a white card; `None` where no value is known.
    pub(super) fn svg(&self) -> Option<String> {
        let [columns, rows] = [self.places[0].len(), self.places[1].len()];
        let values: Vec<Option<f64>> = (0..rows)
            .flat_map(|j| (0..columns).map(move |i| (i, j)))
            .map(|(i, j)| (self.value)(i, j).filter(|value| value.is_finite()))
            .collect();
        let mut range = Range::NONE;
        let known = || values.iter().flatten();
        known().for_each(|value| range.include(*value));
        known().next()?;
        // Equal ratios where values differ by orders of magnitude.
        let shades = match range.low > 0.0 && range.high / range.low > 100.0 {
            true => Axis::logarithmic(self.what, self.unit),
            false => Axis::linear(self.what, self.unit),
        };
        let bar = Ruler::of(&shades, range, 0.0, BOTTOM, TOP);
        let [x, y] = [(0, LEFT, RIGHT), (1, BOTTOM, TOP)].map(|(k, from, to)| {
            let mut range = Range::NONE;
            self.places[k]
                .iter()
                .for_each(|place| range.include(*place));
            Ruler::of(&self.axes[k], range, 0.0, from, to)
        });
        let [across, up] = [(&x, 0), (&y, 1)].map(|(ruler, k)| -> Vec<f64> {
            self.places[k]
                .iter()
                .map(|place| ruler.place(*place))
                .collect()
        });
        let shade = |value: f64| {
            let share = (bar.place(value) - BOTTOM) / (TOP - BOTTOM);
            ((share * SHADES as f64) as usize).min(SHADES - 1)
        };
        let title = escape(&shorten(&self.title, 88));
        let mut svg = format!(
            r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{title}" font-family="{FONT}" font-size="14" fill="#222222">
<rect x="0.5" y="0.5" width="{}" height="{}" rx="8" fill="#ffffff" stroke="#d0d0d0"/>
<text x="{LEFT}" y="34" font-size="18" font-weight="600">{title}</text>
"##,
            WIDTH - 1.0,
            HEIGHT - 1.0
        );
        tiles(&mut svg, &values, &across, &up, &shade);
        for tick in &bar.ticks {
            let level = inverse(&bar, tick.at, &shades);
            let path = contour(&values, &across, &up, level);
            let width = if tick.zero { 2.6 } else { 1.0 };
            let ink = if shade(level) >= LIGHT {
                "#222222"
            } else {
                "#ffffff"
            };
            let ink = if tick.zero { "#b0202a" } else { ink };
            if !path.is_empty() {
                let _ = writeln!(
                    svg,
                    r##"<path d="{path}" fill="none" stroke="{ink}" stroke-width="{width}"/>"##
                );
            }
        }
        self.frame(&mut svg, &x, &y, &bar);
        svg.push_str("</svg>\n");
        Some(svg)
    }

    /// Axes, and the bar of shades.
    fn frame(&self, svg: &mut String, x: &Ruler, y: &Ruler, bar: &Ruler) {
        for tick in &x.ticks {
            let _ = writeln!(
                svg,
                r##"<path d="M{at:.1} {BOTTOM}v6" stroke="#444444"/><text x="{at:.1}" y="{}" text-anchor="middle">{}</text>"##,
                BOTTOM + 22.0,
                tick.label,
                at = tick.at
            );
        }
        for tick in &y.ticks {
            let _ = writeln!(
                svg,
                r##"<path d="M{LEFT} {at:.1}h-6" stroke="#444444"/><text x="{}" y="{:.1}" text-anchor="end">{}</text>"##,
                LEFT - 10.0,
                tick.at + 5.0,
                tick.label,
                at = tick.at
            );
        }
        let [from, to] = BAR;
        let each = (BOTTOM - TOP) / SHADES as f64;
        for k in 0..SHADES {
            let _ = writeln!(
                svg,
                r##"<rect x="{from}" y="{:.2}" width="{}" height="{:.2}" fill="{}"/>"##,
                BOTTOM - each * (k + 1) as f64,
                to - from,
                each + 0.3,
                colour(k)
            );
        }
        for tick in &bar.ticks {
            let _ = writeln!(
                svg,
                r##"<path d="M{to} {at:.1}h6" stroke="#444444"/><text x="{}" y="{:.1}">{}</text>"##,
                to + 10.0,
                tick.at + 5.0,
                tick.label,
                at = tick.at
            );
        }
        let _ = writeln!(
            svg,
            r##"<rect x="{LEFT}" y="{TOP}" width="{}" height="{}" fill="none" stroke="#444444"/>
<text x="{}" y="{}" text-anchor="middle">{}</text>
<text transform="translate(24 {middle}) rotate(-90)" text-anchor="middle">{}</text>
<text transform="translate({} {middle}) rotate(-90)" text-anchor="middle">{}</text>"##,
            RIGHT - LEFT,
            BOTTOM - TOP,
            f64::midpoint(LEFT, RIGHT),
            BOTTOM + 48.0,
            escape(&x.label),
            escape(&y.label),
            WIDTH - 18.0,
            escape(&bar.label),
            middle = f64::midpoint(TOP, BOTTOM)
        );
    }
}

/// The value at a place of a ruler.
fn inverse(ruler: &Ruler, at: f64, axis: &Axis) -> f64 {
    let share = (at - ruler.from) / (ruler.to - ruler.from);
    let reduced = ruler.low + share * (ruler.high - ruler.low);
    match axis.scale {
        Scale::Linear => reduced * 10f64.powi(ruler.power),
        Scale::Logarithmic => 10f64.powf(reduced),
    }
}

fn colour(shade: usize) -> String {
    let at = shade as f64 / (SHADES - 1) as f64 * (COLOURS.len() - 1) as f64;
    let below = (at as usize).min(COLOURS.len() - 2);
    let part = at - below as f64;
    let [r, g, b] = [0, 1, 2].map(|k| {
        let (from, to) = (COLOURS[below][k], COLOURS[below + 1][k]);
        (from + part * (to - from)).round() as u8
    });
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Where tiles end: half-way between neighbours, the first and the last at the frame or as far as on their other sides.
fn edges(places: &[f64], frame: [f64; 2]) -> Vec<f64> {
    let [low, high] = [frame[0].min(frame[1]), frame[0].max(frame[1])];
    let beyond = |end: f64, next: f64| (1.5 * end - 0.5 * next).clamp(low, high);
    let between = places
        .windows(2)
        .map(|pair| f64::midpoint(pair[0], pair[1]));
    let last = places.len() - 1;
    let edges = [beyond(places[0], places[1.min(last)])]
        .into_iter()
        .chain(between);
    edges
        .chain([beyond(places[last], places[last.saturating_sub(1)])])
        .collect()
}

/// A tile for each value, those of one shade side by side as one.
fn tiles(
    svg: &mut String,
    values: &[Option<f64>],
    across: &[f64],
    up: &[f64],
    shade: &impl Fn(f64) -> usize,
) {
    let (lefts, floors) = (edges(across, [LEFT, RIGHT]), edges(up, [BOTTOM, TOP]));
    let mut paths = vec![String::new(); SHADES + 1];
    for (j, row) in values.chunks(across.len()).enumerate() {
        let mut i = 0;
        let shades = row.iter().map(|value| value.map_or(SHADES, shade));
        for run in shades.collect::<Vec<usize>>().chunk_by(|a, b| a == b) {
            let (from, to) = (lefts[i], lefts[i + run.len()]);
            let _ = write!(
                paths[run[0]],
                "M{from:.1} {:.1}H{to:.1}V{:.1}H{from:.1}z",
                floors[j],
                floors[j + 1]
            );
            i += run.len();
        }
    }
    for (k, path) in paths
        .iter()
        .enumerate()
        .filter(|(_, path)| !path.is_empty())
    {
        let fill = if k == SHADES {
            "#ffffff".to_owned()
        } else {
            colour(k)
        };
        // Neighbours of one colour touch without a gap.
        let _ = writeln!(
            svg,
            r##"<path d="{path}" fill="{fill}" stroke="{fill}" stroke-width="0.4"/>"##
        );
    }
}

/// Where the value is this one: straight pieces between the sides of squares (Lorensen & Cline 1987, in the plane), parted by the
/// middle where two ways fit.
fn contour(values: &[Option<f64>], across: &[f64], up: &[f64], level: f64) -> String {
    let columns = across.len();
    let mut path = String::new();
    for j in 1..up.len() {
        for i in 1..columns {
            let corners = [(i - 1, j - 1), (i, j - 1), (i, j), (i - 1, j)];
            let known = corners.map(|(i, j)| values[j * columns + i].map(|value| value - level));
            let [Some(a), Some(b), Some(c), Some(d)] = known else {
                continue;
            };
            let off = [a, b, c, d];
            let above = off.map(|value| value >= 0.0);
            let crossing = |k: usize| {
                let next = (k + 1) % 4;
                (above[k] != above[next]).then(|| {
                    let part = off[k] / (off[k] - off[next]);
                    let [(p, q), (r, s)] = [corners[k], corners[next]];
                    (
                        across[p] + part * (across[r] - across[p]),
                        up[q] + part * (up[s] - up[q]),
                    )
                })
            };
            let mut found: Vec<(f64, f64)> = (0..4).filter_map(crossing).collect();
            if found.len() == 4 && (a + b + c + d >= 0.0) != above[0] {
                found.rotate_left(1);
            }
            for pair in found.chunks_exact(2) {
                let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
                let _ = write!(path, "M{x0:.1} {y0:.1}L{x1:.1} {y1:.1}");
            }
        }
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x² + y² on a grid: the line of level 1 lies on the circle, as near as chords do.
    #[test]
    fn lines_of_a_level_lie_on_it() {
        let places: Vec<f64> = (0..=40).map(|k| f64::from(k) / 20.0 - 1.0).collect();
        let values: Vec<Option<f64>> = places
            .iter()
            .flat_map(|y| places.iter().map(move |x| Some(x * x + y * y)))
            .collect();
        let scaled: Vec<f64> = places.iter().map(|place| place * 1000.0).collect();
        let path = contour(&values, &scaled, &scaled, 0.5);
        let numbers = path
            .split(['M', 'L', ' '])
            .filter_map(|text| text.parse().ok());
        let numbers: Vec<f64> = numbers.collect();
        assert!(numbers.len() > 200);
        for point in numbers.chunks(2) {
            let radius = point[0].hypot(point[1]) / 1000.0;
            assert!((radius - 0.5f64.sqrt()).abs() < 1.5e-3, "{radius}");
        }
    }

    #[test]
    fn saddles_are_parted_by_their_middle() {
        let of = |a: f64| [Some(1.0), Some(-1.0), Some(-1.0), Some(a)];
        // Corners above 0 are joined where the middle is above it.
        for (value, first) in [(3.0, "M0.5 0.0L1.0 0.2"), (0.5, "M1.0 0.7L0.7 1.0")] {
            let path = contour(&of(value), &[0.0, 1.0], &[0.0, 1.0], 0.0);
            assert!(path.starts_with(first), "{path}");
            assert_eq!(path.matches('M').count(), 2, "{path}");
        }
    }
}
