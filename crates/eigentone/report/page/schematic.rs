//! The scene as a schematic: masses, points and supports in a row, what joins neighbours between them, what joins others in
//! lanes below, the ground as walls and floors, loads above.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt::Write;

use eigentone_modes::{ElementKind, Form, MatrixKind, Point, System};
use eigentone_response::{Channel, Load, Problem, Quantity};

use crate::report::number;
use crate::report::plot::{escape, shorten};
use crate::report::unit;

/// Beyond these a drawing would not be readable.
const MOST_MASSES: usize = 14;
const MOST_ELEMENTS: usize = 48;
const MOST_LANES: usize = 8;

/// Room between neighbours, and of a box at least.
const GAP: f64 = 118.0;
const BOX: f64 = 86.0;
/// Height of one of several elements side by side, of a lane, and of a line of text.
const TRACK: f64 = 40.0;
const LANE: f64 = 42.0;
const LINE: f64 = 19.0;
/// Width of a port below a box: for an element to the floor with its label, and for a lane.
const FLOOR_PORT: f64 = 84.0;
const LANE_PORT: f64 = 16.0;
/// Length of an element to the floor.
const DROP: f64 = 74.0;
/// Letters of a name in a box.
const LETTERS: usize = 12;
/// Letters of what a point moves with.
const FORM_LETTERS: usize = 22;
/// Loads that are spelled out on one mass.
const LOADS: usize = 4;

/// The drawing, or a sentence that says why there is none.
pub(super) fn figure(system: &System, problem: Option<&Problem<'_>>) -> Result<String, String> {
    let kinds = [ElementKind::Spring, ElementKind::Damper];
    let elements: usize = kinds.iter().map(|kind| system.elements(*kind).len()).sum();
    if elements == 0 && system.masses().iter().all(|mass| *mass == 0.0) {
        return Err(
            "The system is given by its matrices, so there are no parts to draw.".to_owned(),
        );
    }
    let places = system.len() + system.points().len() + system.supports().len();
    if places > MOST_MASSES || elements > MOST_ELEMENTS {
        let what = match places > system.len() {
            true => "masses, points and supports",
            false => "masses",
        };
        return Err(format!(
            "{places} {what} with {elements} springs and dampers are too many for a readable drawing.",
        ));
    }
    let bodies = bodies(system);
    let parts = parts(system, &bodies);
    let ties = ties(&bodies);
    let mut plan = Plan::of(&bodies, &parts, &ties, problem);
    if plan.lanes > MOST_LANES && !ties.is_empty() {
        // What is below the names says the same.
        plan = Plan::of(&bodies, &parts, &[], problem);
    }
    if plan.lanes > MOST_LANES {
        return Err("Its springs and dampers cross too much for a readable drawing.".to_owned());
    }
    Ok(plan.draw(system))
}

/// Whether something of the system is in matrices and not in the drawing.
pub(super) fn has_matrices(system: &System) -> bool {
    [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness]
        .into_iter()
        .any(|kind| system.added(kind).is_some())
        && system.points().is_empty()
}

/// A box of the drawing.
struct Body {
    name: String,
    /// What stands below the name.
    text: String,
    /// Whether it has no mass of its own.
    light: bool,
    at: At,
    /// What it measures.
    kind: unit::Kind,
    form: BTreeMap<Place, f64>,
}

/// What a box is, and its index among those.
#[derive(Clone, Copy, PartialEq, Eq)]
enum At {
    Coordinate(usize),
    Point(usize),
    Support(usize),
}

/// A coordinate, or a support behind them.
type Place = (bool, usize);

/// A form by its places; the coefficients of one place are added up.
fn places(form: &Form) -> BTreeMap<Place, f64> {
    let mut places = BTreeMap::new();
    let coordinates = form.coordinates.iter().map(|&(i, a)| ((false, i), a));
    let supports = form.supports.iter().map(|&(i, a)| ((true, i), a));
    for (place, a) in coordinates.chain(supports) {
        *places.entry(place).or_insert(0.0) += a;
    }
    places
}

/// Coordinates, points and supports.
fn bodies(system: &System) -> Vec<Body> {
    let body = |name: &String, text: String, light: bool, at: At| Body {
        name: name.clone(),
        text,
        light,
        at,
        kind: system.kind_at(name),
        form: system.form(name).as_ref().map(places).unwrap_or_default(),
    };
    let coordinates = system.names().iter().zip(system.masses()).enumerate();
    let coordinates = coordinates.map(|(i, (name, mass))| {
        let text = match *mass == 0.0 {
            true if has_matrices(system) && system.added(MatrixKind::Mass).is_some() => {
                "matrix".to_owned()
            }
            true => "no mass".to_owned(),
            false => weight(*mass, system.kind_at(name)),
        };
        body(name, text, *mass == 0.0, At::Coordinate(i))
    });
    let points = system.points().iter().enumerate().map(|(k, point)| {
        let mass = match point.mass == 0.0 {
            true => String::new(),
            false => weight(point.mass, point.kind) + ", ",
        };
        let form = places(&point.form);
        let parts = form.iter().map(|(&(is_support, i), a)| {
            let names = if is_support {
                system.supports()
            } else {
                system.names()
            };
            (*a, &names[i])
        });
        let text = format!("{mass}{}", sum(parts));
        body(&point.name, text, point.mass == 0.0, At::Point(k))
    });
    let supports = system.supports().iter().enumerate();
    let supports =
        supports.map(|(s, name)| body(name, "support".to_owned(), false, At::Support(s)));
    coordinates.chain(points).chain(supports).collect()
}

fn weight(mass: f64, kind: unit::Kind) -> String {
    let text = format!("{} {}", short(mass), unit::inertia(kind));
    text.trim_end().to_owned()
}

/// Factors times names, as one writes it: `body − 1.2·pitch`.
fn sum<'a>(parts: impl Iterator<Item = (f64, &'a String)>) -> String {
    let mut text = String::new();
    for (factor, name) in parts {
        let sign = match (text.is_empty(), factor < 0.0) {
            (true, false) => "",
            (true, true) => "−",
            (false, false) => " + ",
            (false, true) => " − ",
        };
        let times = match factor.abs() {
            1.0 => String::new(),
            size => short(size) + "·",
        };
        let _ = write!(text, "{sign}{times}{name}");
    }
    text
}

/// A spring, a damper or a tie; an end is a box or the ground.
#[derive(Clone)]
struct Part {
    /// `None` where a point moves with something, which the coefficient is times.
    kind: Option<ElementKind>,
    coefficient: f64,
    /// Of the coefficient.
    unit: &'static str,
    ends: [Option<usize>; 2],
}

/// The springs and dampers between two boxes, or a box and the ground.
fn parts(system: &System, bodies: &[Body]) -> Vec<Part> {
    let still = BTreeMap::new();
    let forms: Vec<(Option<usize>, &BTreeMap<Place, f64>)> = std::iter::once((None, &still))
        .chain(
            bodies
                .iter()
                .enumerate()
                .map(|(k, body)| (Some(k), &body.form)),
        )
        .collect();
    let joined = |stretch: &BTreeMap<Place, f64>| {
        let pairs = forms
            .iter()
            .flat_map(|from| forms.iter().map(move |to| (from, to)));
        let mut pairs = pairs.filter(|(from, to)| from.0 != to.0);
        pairs.find_map(|((from, a), (to, b))| {
            let mut difference = (*b).clone();
            for (place, value) in *a {
                *difference.entry(*place).or_insert(0.0) -= value;
            }
            difference.retain(|_, value| *value != 0.0);
            (difference == *stretch).then_some([*from, *to])
        })
    };
    let kinds = [ElementKind::Spring, ElementKind::Damper].into_iter();
    let all = kinds.flat_map(|kind| {
        system
            .elements(kind)
            .into_iter()
            .map(move |part| (kind, part))
    });
    let drawn = all.filter_map(|(kind, part)| {
        let mut stretch = places(&part.stretch);
        stretch.retain(|_, value| *value != 0.0);
        let (coefficient, ends) = (part.coefficient, joined(&stretch)?);
        Some(Part {
            kind: Some(kind),
            coefficient,
            unit: unit::coefficient(part.kind, kind),
            ends,
        })
    });
    drawn.collect()
}

/// From each point to what it moves with.
fn ties(bodies: &[Body]) -> Vec<Part> {
    let points = bodies.iter().enumerate();
    let points = points.filter(|(_, body)| matches!(body.at, At::Point(_)));
    let led = |place: Place| {
        let at = match place {
            (false, i) => At::Coordinate(i),
            (true, s) => At::Support(s),
        };
        bodies.iter().position(|body| body.at == at)
    };
    let all = points.flat_map(|(point, body)| {
        let leads = body.form.iter().filter(|(_, times)| **times != 0.0);
        leads.map(move |(place, times)| Part {
            kind: None,
            coefficient: *times,
            unit: "",
            ends: [Some(point), led(*place)],
        })
    });
    all.collect()
}

/// What is where.
struct Plan<'a> {
    bodies: &'a [Body],
    /// Boxes from left to right.
    order: Vec<usize>,
    /// Between the wall, the masses and the wall: gap k lies before mass k.
    gaps: Vec<Vec<Part>>,
    /// Below each mass, to the ground.
    floors: Vec<Vec<Part>>,
    /// Between masses that are no neighbours: left end, right end, lane, element.
    links: Vec<(usize, usize, usize, Part)>,
    lanes: usize,
    /// Springs and dampers in the drawing.
    drawn: usize,
    /// Whether lines lead from points to what they move with.
    ties: bool,
    /// Lines above each mass.
    notes: Vec<Vec<Note>>,
}

struct Note {
    text: String,
    /// −1, 0 or 1: which way an arrow points.
    arrow: i8,
}

impl Note {
    /// An arrow, and as much of the text as has room above a mass and the gap beside it.
    fn new(text: &str, arrow: i8) -> Note {
        let letters = if arrow == 0 { 27 } else { 23 };
        Note {
            text: shorten(text, letters),
            arrow,
        }
    }

    fn indent(&self) -> f64 {
        if self.arrow == 0 { 0.0 } else { 26.0 }
    }

    fn width(&self) -> f64 {
        self.indent() + 7.4 * self.text.chars().count() as f64
    }
}

impl<'a> Plan<'a> {
    fn of(
        bodies: &'a [Body],
        parts: &[Part],
        ties: &[Part],
        problem: Option<&Problem<'_>>,
    ) -> Plan<'a> {
        let (n, drawn) = (bodies.len(), parts.len());
        let order = order(n, parts);
        let mut place = vec![0; n];
        for (position, body) in order.iter().enumerate() {
            place[*body] = position;
        }
        let mut gaps = vec![Vec::new(); n + 1];
        let mut floors = vec![Vec::new(); n];
        let mut far = Vec::new();
        for part in parts.iter().chain(ties).cloned() {
            match part.ends {
                [Some(a), Some(b)] => {
                    let (a, b) = (place[a].min(place[b]), place[a].max(place[b]));
                    match b - a {
                        1 => gaps[b].push(part),
                        _ => far.push((a, b, part)),
                    }
                }
                [Some(a), None] | [None, Some(a)] => match place[a] {
                    0 => gaps[0].push(part),
                    last if last + 1 == n => gaps[n].push(part),
                    middle => floors[middle].push(part),
                },
                [None, None] => {}
            }
        }
        // Short ones first, each in the highest lane that is free over its width.
        far.sort_by_key(|(a, b, _)| (b - a, *a));
        let mut links: Vec<(usize, usize, usize, Part)> = Vec::new();
        let mut lanes = 0;
        for (a, b, part) in far {
            let free = |lane: usize| {
                let mut same = links.iter().filter(|link| link.2 == lane);
                same.all(|(c, d, _, _)| b <= *c || *d <= a)
            };
            let lane = (0..).find(|lane| free(*lane)).unwrap_or(lanes);
            lanes = lanes.max(lane + 1);
            links.push((a, b, lane, part));
        }
        let ties = !ties.is_empty();
        let notes = order
            .iter()
            .map(|body| problem.map_or(Vec::new(), |problem| notes(&bodies[*body], problem)))
            .collect();
        Plan {
            bodies,
            order,
            gaps,
            floors,
            links,
            lanes,
            drawn,
            ties,
            notes,
        }
    }

    fn draw(&self, system: &System) -> String {
        let n = self.order.len();
        let ports = |k: usize| {
            let lanes = self
                .links
                .iter()
                .filter(|(a, b, _, _)| *a == k || *b == k)
                .count();
            FLOOR_PORT * self.floors[k].len() as f64 + LANE_PORT * lanes as f64 + 14.0
        };
        let most = self.gaps.iter().map(Vec::len).max().unwrap_or(0).max(1);
        let height = (TRACK * most as f64).max(58.0);
        let lines = self.notes.iter().map(Vec::len).max().unwrap_or(0);
        let top = 10.0 + LINE * lines as f64;
        let mut x = if self.gaps[0].is_empty() {
            16.0
        } else {
            16.0 + GAP
        };
        let mut boxes = Vec::with_capacity(n);
        for k in 0..n {
            let width = ports(k).max(BOX).max(self.name_width(k));
            boxes.push((x, width));
            x += width
                + if k + 1 < n || !self.gaps[n].is_empty() {
                    GAP
                } else {
                    0.0
                };
        }
        // What is said above the last mass may reach beyond it.
        let said = self
            .notes
            .iter()
            .zip(&boxes)
            .flat_map(|(notes, (x, _))| notes.iter().map(move |note| x + note.width() + 8.0));
        let width = said.fold(x + 16.0, f64::max);
        let floor = if self.floors.iter().any(|floor| !floor.is_empty()) {
            DROP + 16.0
        } else {
            8.0
        };
        let bottom = top + height;
        let total = bottom + floor + LANE * self.lanes as f64 + 8.0;
        let mut out = format!(
            "<figure class=\"schematic\"><div class=\"scroll\" tabindex=\"0\">\n<svg viewBox=\"0 0 {width:.0} {total:.0}\" style=\"min-width:{:.0}px;max-width:{:.0}px\" role=\"img\" aria-label=\"Masses, springs, dampers and loads\" font-size=\"12.5\">\n",
            0.8 * width,
            1.15 * width,
        );
        for (k, gap) in self.gaps.iter().enumerate() {
            if gap.is_empty() {
                continue;
            }
            let from = if k == 0 {
                16.0
            } else {
                boxes[k - 1].0 + boxes[k - 1].1
            };
            let to = if k < n { boxes[k].0 } else { from + GAP };
            if k == 0 {
                wall(&mut out, from, top, bottom, -1.0);
            }
            if k == n {
                wall(&mut out, to, top, bottom, 1.0);
            }
            let track = height / gap.len() as f64;
            for (row, part) in gap.iter().enumerate() {
                across(
                    &mut out,
                    part,
                    from,
                    to,
                    top + track * (row as f64 + 0.5) + 6.0,
                );
            }
        }
        self.below(&mut out, &boxes, bottom, floor);
        for (k, (x, width)) in boxes.iter().enumerate() {
            self.mass(&mut out, k, (*x, top), (*width, height));
        }
        out.push_str("</svg>\n</div>");
        let _ = writeln!(
            out,
            "<figcaption>{}</figcaption></figure>",
            self.caption(system)
        );
        out
    }

    /// What a name takes, if its letters are at most two thirds as wide as they are high, and what stands below it.
    fn name_width(&self, k: usize) -> f64 {
        let body = &self.bodies[self.order[k]];
        let letters = |text: &str, most: usize| text.chars().count().min(most) as f64;
        let below = 7.4 * letters(&body.text, FORM_LETTERS);
        f64::max(9.2 * letters(&body.name, LETTERS), below) + 14.0
    }

    fn mass(&self, out: &mut String, k: usize, (x, y): (f64, f64), (width, height): (f64, f64)) {
        let body = &self.bodies[self.order[k]];
        let class = match body.at {
            At::Support(_) => "box support",
            _ if body.light => "box light",
            _ => "box",
        };
        let name = escape(&shorten(&body.name, LETTERS));
        let middle = x + width / 2.0;
        let title = match body.at {
            At::Coordinate(_) => body.name.clone(),
            _ => format!("{}: {}", body.name, body.text),
        };
        let _ = writeln!(
            out,
            "<rect class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" rx=\"4\"><title>{}</title></rect>\n<text x=\"{middle:.1}\" y=\"{:.1}\" text-anchor=\"middle\" font-weight=\"600\" font-size=\"13.5\">{name}</text>\n<text x=\"{middle:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            escape(&title),
            y + height / 2.0 - 3.0,
            y + height / 2.0 + 15.0,
            escape(&shorten(&body.text, FORM_LETTERS))
        );
        let notes = &self.notes[k];
        for (line, note) in notes.iter().enumerate() {
            let base = y - 7.0 - LINE * (notes.len() - 1 - line) as f64;
            let class = if note.arrow == 0 { "soft" } else { "load-text" };
            let start = x.max(0.0);
            if note.arrow != 0 {
                let (tail, head, back) = match note.arrow > 0 {
                    true => (start, start + 20.0, -5.0),
                    false => (start + 20.0, start, 5.0),
                };
                let _ = writeln!(
                    out,
                    "<path class=\"load\" d=\"M{tail:.1} {at:.1}H{head:.1}m{back} -4l{} 4l{back} 4\"/>",
                    -back,
                    at = base - 4.0,
                );
            }
            let _ = writeln!(
                out,
                "<text class=\"{class}\" x=\"{:.1}\" y=\"{base:.1}\">{}</text>",
                start + note.indent(),
                escape(&note.text)
            );
        }
    }

    /// What hangs below the boxes: elements to the floor on the left, lanes on the right.
    fn below(&self, out: &mut String, boxes: &[(f64, f64)], bottom: f64, floor: f64) {
        let mut next: Vec<f64> = boxes.iter().map(|(x, _)| x + 8.0).collect();
        for (k, parts) in self.floors.iter().enumerate() {
            for part in parts {
                down(out, part, next[k] + 14.0, bottom, bottom + DROP);
                next[k] += FLOOR_PORT;
            }
        }
        let mut ports = vec![Vec::new(); boxes.len()];
        for (index, (a, b, lane, _)) in self.links.iter().enumerate() {
            ports[*a].push((true, *lane, index));
            ports[*b].push((false, *lane, index));
        }
        let mut at = vec![[0.0; 2]; self.links.len()];
        for (k, ports) in ports.iter_mut().enumerate() {
            // To the left before to the right; so that lines do not cross, left ones from the lowest
            // lane up and right ones down.
            ports.sort_by_key(|(right, lane, _)| match right {
                false => (false, usize::MAX - lane),
                true => (true, *lane),
            });
            ports.reverse();
            ports.sort_by_key(|(right, _, _)| *right);
            for (right, _, index) in ports.iter() {
                at[*index][usize::from(!*right)] = next[k] + LANE_PORT / 2.0;
                next[k] += LANE_PORT;
            }
        }
        for ((_, _, lane, part), [from, to]) in self.links.iter().zip(at) {
            let y = bottom + floor + LANE * (*lane as f64 + 0.5) + 4.0;
            let _ = writeln!(
                out,
                "<path class=\"{}\" d=\"M{from:.1} {bottom:.1}V{y:.1}M{to:.1} {bottom:.1}V{y:.1}\"/>",
                part.class(),
            );
            across(out, part, from, to, y);
        }
    }

    fn caption(&self, system: &System) -> String {
        let light = self.bodies.iter().any(|body| body.light);
        let mut text = String::new();
        for (kind, what) in [
            (ElementKind::Spring, "Springs"),
            (ElementKind::Damper, "dampers"),
        ] {
            let elements = system.elements(kind);
            let used = |unit: &&str| {
                elements
                    .iter()
                    .any(|e| unit::coefficient(e.kind, kind) == *unit)
            };
            let units = unit::KINDS.map(|of| unit::coefficient(Some(of), kind));
            let units: Vec<&str> = units.into_iter().filter(|unit| used(unit)).collect();
            if !units.is_empty() {
                let _ = write!(text, "{what} in {}, ", units.join(" or "));
            }
        }
        text += "elements side by side act in parallel.";
        text[..1].make_ascii_uppercase();
        if light && !has_matrices(system) {
            text.push_str(" Dashed boxes have no mass.");
        }
        if has_matrices(system) {
            text.push_str(" What the scene adds as matrices is not drawn.");
        }
        let moved = self.bodies.len() > system.len();
        if moved {
            text.push_str(match self.ties {
                true => " Points move with what stands below their names; dashed lines lead there.",
                false => " Points move with what stands below their names.",
            });
        }
        let kinds = [ElementKind::Spring, ElementKind::Damper];
        let given: usize = kinds.iter().map(|kind| system.elements(*kind).len()).sum();
        if given > self.drawn {
            let _ = write!(
                text,
                " {} elements between other places are not drawn.",
                given - self.drawn
            );
        }
        text
    }
}

/// Masses that form rows of neighbours stand in that order; others as they are given.
fn order(n: usize, parts: &[Part]) -> Vec<usize> {
    let mut near = vec![Vec::new(); n];
    for part in parts {
        if let [Some(a), Some(b)] = part.ends
            && !near[a].contains(&b)
        {
            near[a].push(b);
            near[b].push(a);
        }
    }
    let given: Vec<usize> = (0..n).collect();
    if near.iter().any(|others| others.len() > 2) {
        return given;
    }
    let mut order = Vec::with_capacity(n);
    let mut seen = vec![false; n];
    // Ends of rows first, in their order; what is left then are rings.
    let ends = given.iter().filter(|i| near[**i].len() < 2);
    for start in ends.chain(&given) {
        let mut here = Some(*start).filter(|start| !seen[*start]);
        while let Some(i) = here {
            seen[i] = true;
            order.push(i);
            here = near[i].iter().copied().find(|other| !seen[*other]);
        }
    }
    order
}

/// What acts on a box or moves it, and how it starts.
fn notes(body: &Body, problem: &Problem<'_>) -> Vec<Note> {
    let system = problem.system();
    let acting = problem.drives().iter().filter_map(|drive| {
        let signal = drive.coordinate.checked_sub(system.len());
        let Some(channel) = signal.map(|signal| &problem.channels()[signal]) else {
            let own = body.at == At::Coordinate(drive.coordinate);
            return own.then(|| note(&drive.load, unit::force(body.kind)));
        };
        let quantity = match channel.integrals {
            0 => Some(Quantity::Displacement),
            1 => Some(Quantity::Velocity),
            2 => Some(Quantity::Acceleration),
            _ => None,
        };
        let (own, unit) = match (channel.support, channel.directions[0].as_slice()) {
            (Some(support), _) => (
                At::Support(support),
                quantity.map(|quantity| unit::motion(body.kind, quantity)),
            ),
            (None, [(coordinate, 1.0)]) => (At::Coordinate(*coordinate), force(body, channel)),
            (None, form) => {
                let acted = |point: &Point| point.form.coordinates == form;
                let first = system.points().iter().position(acted);
                (At::Point(first?), force(body, channel))
            }
        };
        // What is integrated more often is a power of time in a polynomial.
        let power = || Note::new("polynomial of time", 1);
        (own == body.at).then(|| unit.map_or_else(power, |unit| note(&drive.load, unit)))
    });
    let mut notes: Vec<Note> = acting.collect();
    if notes.len() > LOADS {
        let more = format!("and {} more", notes.len() - LOADS);
        notes.truncate(LOADS);
        notes.push(Note::new(&more, 0));
    }
    let At::Coordinate(coordinate) = body.at else {
        return notes;
    };
    let starts = [
        (Quantity::Displacement, problem.initial_displacement()),
        (Quantity::Velocity, problem.initial_velocity()),
    ];
    let starts = starts.into_iter().filter_map(|(quantity, initial)| {
        let value = initial[coordinate];
        let unit = unit::motion(body.kind, quantity);
        (value != 0.0).then(|| format!("{} {unit}", short(value)))
    });
    let starts: Vec<String> = starts.collect();
    if !starts.is_empty() {
        notes.push(Note::new(&format!("starts at {}", starts.join(", ")), 0));
    }
    notes
}

/// The unit of a signal that is a force itself.
fn force(body: &Body, channel: &Channel) -> Option<&'static str> {
    (channel.integrals == 0).then(|| unit::force(body.kind))
}

/// What a signal in this unit does.
fn note(load: &Load, unit: &str) -> Note {
    let size = |value: f64, unit: &str| format!("{} {unit}", short(value)).trim_end().to_owned();
    let from = |start: f64| match start > 0.0 {
        true => format!(" from {} s", short(start)),
        false => String::new(),
    };
    let (sign, text) = match load {
        Load::Step(step) => (step.force, size(step.force, unit) + &from(step.start)),
        Load::Ramp(ramp) => (
            ramp.rate,
            size(ramp.rate, &unit::rate(unit)) + &from(ramp.start),
        ),
        Load::Impulse(impulse) => (
            impulse.magnitude,
            format!(
                "impulse {} at {} s",
                size(impulse.magnitude, &unit::momentum(unit)),
                short(impulse.at)
            ),
        ),
        Load::Harmonic(harmonic) => (
            1.0,
            format!(
                "{} at {} rad/s, {} Hz",
                size(harmonic.amplitude, unit),
                short(harmonic.frequency),
                number::significant(harmonic.frequency / TAU)
            ),
        ),
        Load::HalfSine(pulse) => (
            pulse.force,
            format!("half sine {}", size(pulse.force, unit)) + &from(pulse.start),
        ),
        Load::Versine(pulse) => (
            pulse.force,
            format!("versine {}", size(pulse.force, unit)) + &from(pulse.start),
        ),
        Load::Samples(samples) => {
            let samples = format!("{} samples", samples.values.len());
            (1.0, unit::labelled(&samples, unit))
        }
        _ => (1.0, "load".to_owned()),
    };
    Note::new(&text, if sign < 0.0 { -1 } else { 1 })
}

/// A number that a person gave, in at most some nine letters.
fn short(value: f64) -> String {
    let exact = number::short(value);
    match exact.chars().count() <= 9 {
        true => exact,
        false => number::significant(value),
    }
}

/// A vertical wall, hatched on one side.
fn wall(out: &mut String, x: f64, top: f64, bottom: f64, side: f64) {
    let mut path = format!("M{x:.1} {top:.1}V{bottom:.1}");
    let mut y = top + 8.0;
    while y <= bottom + 0.1 {
        let _ = write!(
            path,
            "M{x:.1} {y:.1}l{:.1} {:.1}",
            8.0 * side,
            -8.0 * side * side
        );
        y += 8.0;
    }
    let _ = writeln!(out, "<path class=\"wall\" d=\"{path}\"/>");
}

impl Part {
    /// The class of its lines.
    fn class(&self) -> &'static str {
        match self.kind {
            Some(_) => "part",
            None => "tie",
        }
    }

    /// Its number in a few letters, and all that is known of it.
    fn texts(&self) -> [String; 2] {
        let exact = number::short(self.coefficient);
        match self.kind {
            Some(kind) => [
                short(self.coefficient),
                format!("{kind} {exact} {}", self.unit),
            ],
            None => [
                format!("×{}", short(self.coefficient)),
                format!("moves {exact} times as far"),
            ],
        }
    }
}

/// An element from left to right, its number above it.
fn across(out: &mut String, part: &Part, from: f64, to: f64, y: f64) {
    let middle = f64::midpoint(from, to);
    let left = middle - 25.0;
    let path = match part.kind {
        None => format!("M{from:.1} {y:.1}H{to:.1}"),
        Some(ElementKind::Spring) => format!(
            "M{from:.1} {y:.1}H{left:.1}l4.2 -7l8.3 14l8.3 -14l8.4 14l8.3 -14l8.3 14l4.2 -7H{to:.1}"
        ),
        Some(ElementKind::Damper) => format!(
            "M{from:.1} {y:.1}H{:.1}m16 -7h-16v14h16M{:.1} {:.1}v10M{:.1} {y:.1}H{to:.1}",
            middle - 8.0,
            middle + 3.0,
            y - 5.0,
            middle + 3.0,
        ),
    };
    let [text, title] = part.texts();
    let _ = writeln!(
        out,
        "<path class=\"{}\" d=\"{path}\"><title>{title}</title></path><text x=\"{middle:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{text}</text>",
        part.class(),
        y - 10.0,
    );
}

/// An element from a box to the floor, its number beside it.
fn down(out: &mut String, part: &Part, x: f64, from: f64, to: f64) {
    let middle = f64::midpoint(from, to);
    let path = match part.kind {
        None => format!("M{x:.1} {from:.1}V{to:.1}"),
        Some(ElementKind::Spring) => format!(
            "M{x:.1} {from:.1}V{:.1}l-7 4.2l14 8.3l-14 8.3l14 8.4l-14 8.3l14 8.3l-7 4.2V{to:.1}",
            middle - 25.0
        ),
        Some(ElementKind::Damper) => format!(
            "M{x:.1} {from:.1}V{:.1}m-7 16v-16h14v16M{:.1} {:.1}h10M{x:.1} {:.1}V{to:.1}",
            middle - 8.0,
            x - 5.0,
            middle + 3.0,
            middle + 3.0,
        ),
    };
    let mut hatch = format!("M{:.1} {to:.1}h24", x - 12.0);
    for k in 0..4 {
        let _ = write!(hatch, "M{:.1} {to:.1}l-6 6", x - 6.0 + 6.0 * f64::from(k));
    }
    let [text, title] = part.texts();
    let _ = writeln!(
        out,
        "<path class=\"{}\" d=\"{path}\"><title>{title}</title></path><path class=\"wall\" d=\"{hatch}\"/><text x=\"{:.1}\" y=\"{:.1}\">{text}</text>",
        part.class(),
        x + 11.0,
        middle + 4.0,
    );
}
