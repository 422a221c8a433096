//! Mode shapes: each coordinate's motion drawn upwards, swinging where styles can be animated.
//!
//! A component |x| e^{iφ} moves as |x| cos(ωt + φ). The stretch between two neighbours ends at both
//! motions because it is moved as the first and tilted by their difference, which is one cosine too.

use std::f64::consts::PI;
use std::fmt::Write;

use eigentone_modes::{CoordinateKind, Mode, Modes, System};
use num_complex::Complex;

use super::html::remark;
use crate::report::number;
use crate::report::plot::{escape, shorten};
use crate::report::unit;

const WIDTH: f64 = 300.0;
const HEIGHT: f64 = 150.0;
const LEFT: f64 = 22.0;
const RIGHT: f64 = WIDTH - 22.0;
/// The line of rest, and the room above and below it.
const MIDDLE: f64 = 66.0;
const REACH: f64 = 52.0;
/// Modes that are drawn.
const MODES: usize = 12;
/// Coordinates that are animated one by one.
const ANIMATED: usize = 24;
/// Seconds of half a swing, as the style has it.
const HALF: f64 = 1.3;

/// A figure for each of the first modes.
pub(super) fn figures(modes: &Modes, system: &System) -> String {
    let all = modes.as_slice();
    let mut out = String::from("<div class=\"cards small\">\n");
    for (k, mode) in all.iter().take(MODES).enumerate() {
        out.push_str(&figure(k + 1, mode, system));
    }
    out.push_str("</div>\n");
    let apart = match unit::kinds(system).count() {
        1 => "",
        _ => " Rotations stand below the others; each has its own scale.",
    };
    out.push_str(&remark(&format!(
        "Upwards is the positive direction, the largest component is 1, and the band is how far each \
         coordinate goes.{apart} All modes are shown equally fast. Oscillations do not show their decay.",
    )));
    if all.len() > MODES {
        let rest = all.len() - MODES;
        out.push_str(&remark(&format!(
            "{rest} further shapes are not drawn; modes.csv and modes.json have them."
        )));
    }
    out
}

fn figure(number: usize, mode: &Mode, system: &System) -> String {
    let mut about = about(mode);
    let panels: Vec<Panel<'_>> = unit::kinds(system)
        .map(|kind| Panel::of(mode, system, kind))
        .collect();
    if let [displacements, rotations] = panels.as_slice() {
        let _ = write!(
            about,
            "; displacements reach {}, rotations {}",
            number::significant(displacements.largest),
            number::significant(rotations.largest)
        );
    }
    let height = HEIGHT * panels.len() as f64;
    let mut out = format!(
        "<figure>\n<h3>Mode {number}</h3>\n<svg viewBox=\"0 0 {WIDTH} {height}\" role=\"img\" aria-label=\"Shape of mode {number}\" font-size=\"12\">\n"
    );
    for (k, panel) in panels.iter().enumerate() {
        let _ = writeln!(out, "<g transform=\"translate(0 {})\">", HEIGHT * k as f64);
        panel.draw(&mut out, Motion::of(mode));
        out.push_str("</g>\n");
    }
    let _ = writeln!(
        out,
        "</svg>\n<figcaption>{}</figcaption>\n</figure>",
        escape(&about)
    );
    out
}

/// The components of one kind of coordinate.
struct Panel<'a> {
    names: Vec<&'a str>,
    shape: Vec<Complex<f64>>,
    /// The largest size; 0 where none is more than its bound.
    largest: f64,
}

impl<'a> Panel<'a> {
    fn of(mode: &Mode, system: &'a System, kind: CoordinateKind) -> Panel<'a> {
        let own: Vec<usize> = (0..system.len())
            .filter(|i| system.kind_of(*i) == kind)
            .collect();
        let size = |i: &usize| mode.shape()[*i].norm();
        let is_known = |i: &usize| mode.shape_bound().is_none_or(|bound| size(i) > bound[*i]);
        let largest = own.iter().map(size).fold(0.0, f64::max);
        Panel {
            names: own.iter().map(|i| system.names()[*i].as_str()).collect(),
            shape: own.iter().map(|i| mode.shape()[*i]).collect(),
            largest: if own.iter().any(is_known) {
                largest
            } else {
                0.0
            },
        }
    }

    fn draw(&self, out: &mut String, motion: Motion) {
        let (shape, places) = (&self.shape, places(self.shape.len()));
        let scale = if self.largest > 0.0 {
            REACH / self.largest
        } else {
            0.0
        };
        reach(out, shape, &places, scale);
        let _ = writeln!(out, "<path class=\"z\" d=\"M{LEFT} {MIDDLE}H{RIGHT}\"/>");
        match shape.len() > ANIMATED {
            true => still(out, shape, &places, scale),
            false => moving(out, shape, &places, scale, motion),
        }
        labels(out, &self.names, &places);
    }
}

/// The caption of a mode.
fn about(mode: &Mode) -> String {
    use eigentone_modes::Motion;
    let root = mode.eigenvalue();
    let (Some(bound), Some(real_bound)) = (root.bound, root.real_bound) else {
        return "doubtful: no bound of λ is known".to_owned();
    };
    match mode.motion() {
        Motion::Rigid => "rigid".to_owned(),
        Motion::Oscillating | Motion::Growing if root.value.im != 0.0 => {
            let frequency = mode.natural_frequency().hertz();
            let frequency = number::known_digits(frequency, bound / std::f64::consts::TAU);
            let off = real_bound / root.value.norm();
            let ratio = number::known_digits(mode.damping_ratio().unwrap_or(0.0), off);
            format!("f_n = {frequency} Hz, ζ = {ratio}")
        }
        motion => format!(
            "{motion}, λ = {} 1/s",
            number::known_digits(root.value.re, real_bound)
        ),
    }
}

fn places(count: usize) -> Vec<f64> {
    match count {
        1 => vec![f64::midpoint(LEFT, RIGHT)],
        _ => (0..count)
            .map(|i| LEFT + (RIGHT - LEFT) * i as f64 / (count - 1) as f64)
            .collect(),
    }
}

/// How far each coordinate goes, both ways.
fn reach(out: &mut String, shape: &[Complex<f64>], places: &[f64], scale: f64) {
    let there = shape.iter().zip(places);
    let back = shape.iter().zip(places).rev();
    let mut path = String::new();
    let sides = there
        .map(|pair| (pair, -1.0))
        .chain(back.map(|pair| (pair, 1.0)));
    for (k, ((x, place), side)) in sides.enumerate() {
        let letter = if k == 0 { 'M' } else { 'L' };
        let _ = write!(
            path,
            "{letter}{place:.1} {:.1}",
            MIDDLE + side * scale * x.norm()
        );
    }
    let _ = writeln!(out, "<path class=\"reach\" d=\"{path}z\"/>");
}

/// The shape at one moment.
fn still(out: &mut String, shape: &[Complex<f64>], places: &[f64], scale: f64) {
    let mut path = String::new();
    for (k, (x, place)) in shape.iter().zip(places).enumerate() {
        let letter = if k == 0 { 'M' } else { 'L' };
        let _ = write!(path, "{letter}{place:.1} {:.1}", MIDDLE - scale * x.re);
    }
    let _ = writeln!(out, "<path class=\"link\" d=\"{path}\"/>");
}

/// How a drawing moves.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Motion {
    Still,
    /// Towards rest, again and again.
    Relaxes,
    Swings,
}

impl Motion {
    fn of(mode: &Mode) -> Motion {
        match mode.motion() {
            eigentone_modes::Motion::Oscillating => Motion::Swings,
            eigentone_modes::Motion::Growing if mode.eigenvalue().value.im != 0.0 => Motion::Swings,
            eigentone_modes::Motion::Decaying => Motion::Relaxes,
            _ => Motion::Still,
        }
    }
}

/// Stretches and dots.
fn moving(out: &mut String, shape: &[Complex<f64>], places: &[f64], scale: f64, motion: Motion) {
    let _ = write!(out, "<g transform=\"translate(0 {MIDDLE})\">");
    let group = |x: &Complex<f64>, dot: bool| {
        let (size, y) = (scale * x.norm(), -scale * x.re);
        match motion {
            Motion::Swings => format!(
                "<g class=\"swing\" style=\"--a:{size:.2}px;--y:{y:.2}px;--d:{:.3}s\">",
                delay(*x)
            ),
            Motion::Relaxes if dot => format!("<g class=\"fall\" style=\"--y:{y:.2}px\">"),
            _ => format!("<g transform=\"translate(0 {y:.2})\">"),
        }
    };
    // All stretches shrink towards rest together.
    out.push_str(if motion == Motion::Relaxes {
        "<g class=\"relax\">"
    } else {
        "<g>"
    });
    for (pair, ends) in shape.windows(2).zip(places.windows(2)) {
        let step = (pair[1] - pair[0]) * scale;
        let (size, width) = (step.norm(), ends[1] - ends[0]);
        let _ = write!(
            out,
            "{}<g transform=\"translate({:.1} 0)\">",
            group(&pair[0], false),
            ends[0]
        );
        // A difference with the cosine's sign turned: down the drawing is positive.
        let _ = match motion == Motion::Swings && size > 0.0 {
            true => write!(
                out,
                "<path class=\"link tilt\" style=\"--y:{:.3};--d:{:.3}s\" d=\"M0 0L{width:.1} {:.2}\"/>",
                step.re / size,
                delay(step),
                -size
            ),
            false => write!(
                out,
                "<path class=\"link\" d=\"M0 0L{width:.1} {:.2}\"/>",
                -step.re
            ),
        };
        out.push_str("</g></g>\n");
    }
    out.push_str("</g>\n");
    for (x, place) in shape.iter().zip(places) {
        let _ = writeln!(
            out,
            "{}<circle class=\"dot\" cx=\"{place:.1}\" cy=\"0\" r=\"5\"/></g>",
            group(x, true)
        );
    }
    out.push_str("</g>\n");
}

/// How long ago cos(ωt + φ) was at its top, in seconds of the style's swing.
fn delay(x: Complex<f64>) -> f64 {
    let phase = x.arg().rem_euclid(2.0 * PI);
    -phase / PI * HALF
}

/// As many names as have room.
fn labels(out: &mut String, names: &[&str], places: &[f64]) {
    const LETTER: f64 = 7.2;
    let longest = names
        .iter()
        .map(|name| name.chars().count())
        .max()
        .unwrap_or(0)
        .min(10);
    let room = (LETTER * longest as f64 + 6.0).max(14.0);
    let gap = places
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .fold(f64::INFINITY, f64::min);
    let each = if gap.is_finite() {
        (room / gap).ceil().max(1.0) as usize
    } else {
        1
    };
    let count = names.len();
    for (i, (name, place)) in names.iter().zip(places).enumerate().step_by(each) {
        // Names at the edges stay inside.
        let anchor = match (i, count) {
            (_, 1) => "middle",
            (0, _) if longest > 4 => "start",
            (i, _) if i + 1 == count && longest > 4 => "end",
            _ => "middle",
        };
        let edge = match anchor {
            "start" => place - 18.0,
            "end" => place + 18.0,
            _ => *place,
        };
        let _ = writeln!(
            out,
            "<text class=\"soft\" x=\"{edge:.1}\" y=\"{}\" text-anchor=\"{anchor}\">{}</text>",
            HEIGHT - 10.0,
            escape(&shorten(name, 10))
        );
    }
}
