//! The eigenvalues in the complex plane: both axes to one scale, with lines of constant ζ.

use std::fmt::Write;

use eigentone_digits::sort_by_number;
use eigentone_modes::{Modes, Motion};

use super::chart::axes;
use crate::report::axis::{Axis, Range, Ruler};
use crate::report::number;
use crate::report::plot::escape;

const WIDTH: f64 = 520.0;
const HEIGHT: f64 = 430.0;
const LEFT: f64 = 74.0;
const RIGHT: f64 = WIDTH - 20.0;
const TOP: f64 = 22.0;
const BOTTOM: f64 = HEIGHT - 48.0;
/// Lines of constant ζ.
const RATIOS: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];
/// Where the next root is this many times smaller, those from there on get a map of their own.
const GAP: f64 = 25.0;
/// Maps at most.
const MAPS: usize = 3;
/// The kinds of motion with their colours and words.
const KINDS: [(Motion, usize, &str); 5] = [
    (Motion::Oscillating, 0, "oscillating"),
    (Motion::Decaying, 2, "decaying"),
    (Motion::Rigid, 6, "rigid"),
    (Motion::Growing, 1, "growing"),
    (Motion::Doubtful, 3, "doubtful"),
];

/// One figure, or several where roots differ much in size.
pub(super) fn figures(modes: &Modes) -> String {
    let mut sizes: Vec<f64> = modes
        .eigenvalues()
        .iter()
        .map(|root| root.value.norm())
        .collect();
    sort_by_number(&mut sizes, |size| -size);
    sizes.retain(|size| *size > 0.0);
    let mut reaches: Vec<f64> = sizes.first().copied().into_iter().collect();
    for pair in sizes.windows(2) {
        if pair[1] * GAP < pair[0] {
            reaches.push(pair[1]);
        }
    }
    if reaches.is_empty() {
        reaches.push(1.0);
    }
    // The largest and the smallest say most.
    if reaches.len() > MAPS {
        let last = reaches.split_off(reaches.len() - 1);
        reaches.truncate(MAPS - 1);
        reaches.extend(last);
    }
    let figure = |(k, reach): (usize, &f64)| figure(modes, *reach, k > 0);
    reaches.iter().enumerate().map(figure).collect()
}

fn figure(modes: &Modes, reach: f64, near: bool) -> String {
    let shown: Vec<(f64, f64, Motion, usize)> = modes
        .iter()
        .filter(|mode| mode.eigenvalue().value.norm() <= reach * (1.0 + 1e-9))
        .flat_map(|mode| {
            let root = mode.eigenvalue().value;
            let motion = mode.motion();
            let count = mode.multiplicity().or(mode.cluster_found()).unwrap_or(1);
            let pair = if root.im == 0.0 { 1 } else { 2 };
            [
                (root.re, root.im, motion, count),
                (root.re, -root.im, motion, count),
            ]
            .into_iter()
            .take(pair)
        })
        .collect();
    let (x, y) = rulers(&shown, reach);
    let heading = match near {
        false => "Eigenvalues".to_owned(),
        true => format!(
            "Eigenvalues near 0: |λ| ≤ {} rad/s",
            number::significant(reach)
        ),
    };
    let mut out = format!(
        "<figure>\n<h3>{heading}</h3>\n<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{heading} in the complex plane\" font-size=\"13\">\n"
    );
    axes(&mut out, &x, &y);
    rays(&mut out, &x, &y);
    let mut drawn: Vec<(f64, f64)> = Vec::new();
    for (re, im, motion, count) in &shown {
        let at = (x.place(*re), y.place(*im));
        if drawn.contains(&at) {
            continue; // once for all shapes of a repeated root
        }
        drawn.push(at);
        pole(&mut out, at, *motion, *count, (*re, *im));
    }
    out.push_str("</svg>\n<ul class=\"legend\">\n");
    for (motion, colour, word) in KINDS {
        if shown.iter().any(|(_, _, found, _)| *found == motion) {
            let _ = writeln!(
                out,
                "<li><svg viewBox=\"0 0 30 12\" aria-hidden=\"true\"><g class=\"s{colour}\">{}</g></svg><span>{word}</span></li>",
                marker(motion, (15.0, 6.0))
            );
        }
    }
    out + "</ul>\n<figcaption>Rays: lines of equal damping ratio ζ. Both axes have the same scale.</figcaption>\n</figure>\n"
}

/// Rulers of one scale that hold every root and the origin.
fn rulers(shown: &[(f64, f64, Motion, usize)], reach: f64) -> (Ruler, Ruler) {
    let most =
        |part: fn(&(f64, f64, Motion, usize)) -> f64| shown.iter().map(part).fold(0.0, f64::max);
    let margin = 0.12 * reach;
    let (low, high) = (-most(|root| -root.0) - margin, most(|root| root.0) + margin);
    let top = most(|root| root.1.abs()) + margin;
    let (wide, tall) = (RIGHT - LEFT, BOTTOM - TOP);
    let unit = ((high - low) / wide).max(2.0 * top / tall);
    let spare = unit * wide - (high - low);
    // What is spare goes to the left, where damping is.
    let xs = Range {
        low: low - 0.75 * spare,
        high: high + 0.25 * spare,
    };
    let ys = Range {
        low: -0.5 * unit * tall,
        high: 0.5 * unit * tall,
    };
    let x = Ruler::of(&Axis::linear("Re λ", "1/s"), xs, 0.0, LEFT, RIGHT);
    let y = Ruler::of(&Axis::linear("Im λ", "rad/s"), ys, 0.0, BOTTOM, TOP);
    (x, y)
}

/// ζ = const from the origin to the edge, both ways, with its number at the upper end.
fn rays(out: &mut String, x: &Ruler, y: &Ruler) {
    let (x0, y0) = (x.place(0.0), y.place(0.0));
    for ratio in RATIOS {
        // Down the drawing is −Im; the scale is the same both ways.
        let (across, along) = (ratio, (1.0 - ratio * ratio).sqrt());
        let length = ((x0 - LEFT) / across).min((y0 - TOP) / along);
        let (ex, ey) = (x0 - length * across, y0 - length * along);
        let _ = writeln!(
            out,
            "<path class=\"a\" stroke-dasharray=\"2 4\" d=\"M{x0:.1} {y0:.1}L{ex:.1} {ey:.1}M{x0:.1} {y0:.1}L{ex:.1} {:.1}\"/>",
            2.0 * y0 - ey
        );
        let side = ex < LEFT + 1.0;
        let (tx, ty, anchor) = match side {
            true => (ex + 4.0, ey - 4.0, "start"),
            false => (ex, ey - 5.0, "middle"),
        };
        let _ = writeln!(
            out,
            "<text class=\"soft\" font-size=\"11\" x=\"{tx:.1}\" y=\"{ty:.1}\" text-anchor=\"{anchor}\">{}{ratio}</text>",
            if ratio == RATIOS[RATIOS.len() - 1] || side {
                "ζ = "
            } else {
                ""
            }
        );
    }
}

fn pole(out: &mut String, at: (f64, f64), motion: Motion, count: usize, (re, im): (f64, f64)) {
    let colour = KINDS
        .iter()
        .find(|kind| kind.0 == motion)
        .map_or(6, |kind| kind.1);
    let sign = if im < 0.0 { "−" } else { "+" };
    let value = match im == 0.0 {
        true => format!("λ = {} 1/s", number::significant(re)),
        false => format!(
            "λ = {} {sign} {}i 1/s",
            number::significant(re),
            number::significant(im.abs())
        ),
    };
    let times = match count {
        0 | 1 => String::new(),
        count => format!(", {count} roots"),
    };
    let _ = writeln!(
        out,
        "<g class=\"s{colour}\"><title>{}</title>{}</g>",
        escape(&format!("{value}, {motion}{times}")),
        marker(motion, at)
    );
    if count > 1 {
        let _ = writeln!(
            out,
            "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"12\">×{count}</text>",
            at.0 + 8.0,
            at.1 - 6.0
        );
    }
}

/// A shape of its own for each kind of motion.
fn marker(motion: Motion, (x, y): (f64, f64)) -> String {
    let path = match motion {
        Motion::Oscillating => {
            return format!("<circle class=\"pole\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4.6\"/>");
        }
        Motion::Decaying => format!("M{:.1} {y:.1}l5.5 5.5 5.5-5.5-5.5-5.5z", x - 5.5),
        Motion::Rigid => format!("M{:.1} {:.1}h9v9h-9z", x - 4.5, y - 4.5),
        Motion::Doubtful => format!("M{:.1} {:.1}l9 9m0-9l-9 9", x - 4.5, y - 4.5),
        _ => format!("M{:.1} {:.1}l5.5 9.5h-11z", x, y - 6.0),
    };
    format!("<path class=\"pole\" d=\"{path}\"/>")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn maps() -> Vec<(Ruler, Ruler)> {
        let roots = |list: &[(f64, f64)]| -> Vec<(f64, f64, Motion, usize)> {
            let each = list.iter();
            each.map(|(re, im)| (*re, *im, Motion::Oscillating, 1))
                .collect()
        };
        let lists: [&[(f64, f64)]; 5] = [
            &[(-0.3, 0.91f64.sqrt()), (-0.3, -(0.91f64.sqrt()))],
            &[(-5e8, 0.0), (-1.0, 3.0)],
            &[(0.0, 2e-9)],
            &[(3.0, 4.0), (-3.0, 4.0)],
            &[(0.0, 0.0)],
        ];
        let reach = |list: &[(f64, f64)]| {
            let sizes = list.iter().map(|(re, im)| re.hypot(*im));
            let most = sizes.fold(0.0, f64::max);
            if most > 0.0 { most } else { 1.0 }
        };
        lists.map(|list| rulers(&roots(list), reach(list))).into()
    }

    #[test]
    fn both_axes_have_one_scale() {
        for (x, y) in maps() {
            let unit = (x.high - x.low) / (x.to - x.from);
            let other = (y.high - y.low) / (y.from - y.to);
            // Each axis names a power of ten of its own.
            let power = |axis: &Ruler| axis.power;
            let ratio = unit / other * 10f64.powi(power(&x) - power(&y));
            assert!((ratio - 1.0).abs() < 1e-9, "{ratio}");
        }
    }

    #[test]
    fn a_root_lies_on_the_ray_of_its_damping_ratio() {
        let (x, y) = maps().remove(0);
        let mut out = String::new();
        rays(&mut out, &x, &y);
        let ray = out.lines().nth(2).expect("that of 0.3");
        assert!(
            out.lines()
                .nth(3)
                .expect("its label")
                .ends_with(">0.3</text>")
        );
        let path = ray.split("d=\"M").nth(1).expect("a path");
        let numbers: Vec<f64> = path
            .split(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-'))
            .filter_map(|part| part.parse().ok())
            .collect();
        let (ex, ey) = (numbers[2] - numbers[0], numbers[3] - numbers[1]);
        let root = (
            x.place(-0.3) - numbers[0],
            y.place(0.91f64.sqrt()) - numbers[1],
        );
        let off = ex * root.1 - ey * root.0;
        assert!(off.abs() < 0.2 * ex.hypot(ey), "{ray}");
    }
}
