//! Campbell diagrams as tables, JSON, CSV and plots.

use std::f64::consts::TAU;
use std::io::{self, Write};

use eigentone_design::{Branch, CampbellDiagram, CriticalSpeed, Whirl};
use serde::Serialize;

use super::axis::Axis;
use super::csv;
use super::number;
use super::plot::{Line, Plot};
use super::table::{Align, Table};

/// Turns a minute of a speed in rad/s.
const RPM: f64 = 60.0 / TAU;

/// Speeds of the table of frequencies, at most.
const ROWS: usize = 24;

/// Prints a Campbell diagram.
#[derive(Clone, Copy, Debug)]
pub struct CampbellReport<'a> {
    /// What stands above the plots.
    pub title: &'a str,
    /// The diagram.
    pub diagram: &'a CampbellDiagram,
}

impl<'a> CampbellReport<'a> {
    /// Critical speeds, then the damped frequencies of the modes against speed.
    pub fn text(&self) -> String {
        let diagram = self.diagram;
        let all = diagram.critical_speeds();
        let column_of = |value: fn(&CriticalSpeed) -> f64| {
            number::column(all.iter().map(|c| Some(value(c))).collect::<Vec<_>>())
        };
        let mut text = String::new();
        if all.is_empty() {
            text += "No critical speed was found.\n";
        } else {
            text += &Table::default()
                .column(
                    "critical speed, rad/s",
                    Align::Point,
                    column_of(|c| c.speed),
                )
                .column(
                    "±",
                    Align::Right,
                    all.iter().map(|c| number::bound(c.bound)),
                )
                .column("rpm", Align::Point, column_of(|c| c.speed * RPM))
                .column(
                    "order",
                    Align::Right,
                    all.iter().map(|c| number::short(c.order)),
                )
                .column(
                    "modes",
                    Align::Right,
                    all.iter().map(|c| c.count.to_string()),
                )
                .column("damping ratio", Align::Point, column_of(damping))
                .column("whirl", Align::Left, all.iter().map(|c| word(c.whirl)))
                .text();
        }
        let speeds = diagram.speeds();
        let (first, last) = (speeds[0], speeds[speeds.len() - 1]);
        let [first, last] = [first, last].map(number::significant);
        text += &match diagram.is_complete() {
            true => format!(
                "\nProven: there are no others of these orders from {first} to {last} rad/s.\n"
            ),
            false => format!(
                "\nNot proven to be all from {first} to {last} rad/s: between two speeds of the table, or at its ends, others may be missing; more speeds may show them.\n"
            ),
        };
        if !diagram.is_sure() {
            text += "Some modes came so close to each other that which is which beyond that speed is uncertain.\n";
        }
        let step = speeds.len().div_ceil(ROWS);
        let rows: Vec<usize> = (0..speeds.len()).step_by(step).collect();
        let column = |values: &dyn Fn(usize) -> f64| {
            number::column(rows.iter().map(|k| Some(values(*k))).collect::<Vec<_>>())
        };
        let mut table = Table::default()
            .column("speed, rad/s", Align::Point, column(&|k| speeds[k]))
            .column("rpm", Align::Point, column(&|k| speeds[k] * RPM));
        for (i, branch) in diagram.branches().iter().enumerate() {
            let header = format!("{}, rad/s", name(i, branch));
            table = table
                .column(&header, Align::Point, column(&|k| branch.roots[k].im))
                .column("Hz", Align::Point, column(&|k| branch.roots[k].im / TAU));
        }
        text + "\n" + &table.text()
    }

    /// One JSON object with every digit.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn json(&self, mut out: impl Write) -> io::Result<()> {
        let diagram = self.diagram;
        let branches = diagram.branches().iter().map(|branch| BranchJson {
            re: branch.roots.iter().map(|root| root.re).collect(),
            im: branch.roots.iter().map(|root| root.im).collect(),
            whirl: branch.whirl.iter().map(|whirl| whirl.map(key)).collect(),
        });
        let critical = diagram.critical_speeds().iter().map(|found| CriticalJson {
            order: found.order,
            speed: found.speed,
            bound: found.bound,
            count: found.count,
            eigenvalue: RootJson {
                re: found.root.re,
                im: found.root.im,
            },
            whirl: found.whirl.map(key),
        });
        let json = Json {
            bounds: super::worth(diagram.bounds()),
            complete: diagram.is_complete(),
            followed: diagram.is_sure(),
            speed: diagram.speeds(),
            orders: diagram.orders(),
            critical: critical.collect(),
            branches: branches.collect(),
        };
        serde_json::to_writer(&mut out, &json)?;
        writeln!(out)
    }

    /// One row for each speed with all digits.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn csv(&self, mut out: impl Write) -> io::Result<()> {
        let branches = self.diagram.branches();
        let headers = (1..=branches.len()).flat_map(|i| {
            [
                format!("re {i} [1/s]"),
                format!("im {i} [rad/s]"),
                format!("im {i} [Hz]"),
                format!("whirl {i}"),
            ]
        });
        let first = ["speed [rad/s]", "speed [rpm]"].map(str::to_owned);
        csv::row(&mut out, first.into_iter().chain(headers))?;
        for (k, speed) in self.diagram.speeds().iter().enumerate() {
            let first = [csv::number(*speed), csv::number(speed * RPM)];
            let cells = branches.iter().flat_map(|branch| {
                let (root, whirl) = (branch.roots[k], branch.whirl[k]);
                [
                    csv::number(root.re),
                    csv::number(root.im),
                    csv::number(root.im / TAU),
                    whirl.map_or("", key).to_owned(),
                ]
            });
            csv::row(&mut out, first.into_iter().chain(cells))?;
        }
        Ok(())
    }

    /// Plots by the names of their files: frequencies in rad/s against rad/s, and in Hz against turns a minute.
    pub fn plots(&self) -> Vec<(&'static str, Plot<'a>)> {
        let units = [
            ("campbell.svg", "rad/s", 1.0, "rad/s", 1.0),
            ("campbell-rpm.svg", "rpm", RPM, "Hz", 1.0 / TAU),
        ];
        let plots = units.map(|(file, x_unit, x, y_unit, y)| {
            let plot = Plot {
                title: format!("{}: frequencies against speed", self.title),
                x: Axis::linear("speed", x_unit),
                y: Axis::linear("damped frequency", y_unit),
                lines: self.lines(x, y),
                ring: None,
            };
            (file, plot)
        });
        plots.into()
    }

    /// Modes, lines of the orders as far as modes reach, and critical speeds, in other units by factors.
    fn lines(&self, x: f64, y: f64) -> Vec<Line<'a>> {
        let diagram = self.diagram;
        let (speeds, critical) = (diagram.speeds(), diagram.critical_speeds());
        let mut lines = Vec::new();
        if !critical.is_empty() {
            let at = move |k: usize| {
                (
                    critical[k].speed * x,
                    critical[k].order * critical[k].speed * y,
                )
            };
            lines.push(Line::new("critical", critical.len(), at).dots());
        }
        let mut highest = 0.0;
        for (i, branch) in diagram.branches().iter().enumerate() {
            highest = branch
                .roots
                .iter()
                .map(|root| root.im)
                .fold(highest, f64::max);
            let at = move |k: usize| (speeds[k] * x, branch.roots[k].im * y);
            lines.push(Line::new(&name(i, branch), speeds.len(), at));
        }
        for &order in diagram.orders() {
            let from = speeds[0].min(highest / order);
            let to = speeds[speeds.len() - 1].min(highest / order);
            let ends = [from, to].map(|speed| (speed * x, order * speed * y));
            let name = format!("{} × speed", number::short(order));
            lines.push(Line::new(&name, 2, move |k| ends[k]));
        }
        lines
    }
}

fn damping(found: &CriticalSpeed) -> f64 {
    -found.root.re / found.root.norm()
}

fn key(whirl: Whirl) -> &'static str {
    match whirl {
        Whirl::Forward => "forward",
        Whirl::Backward => "backward",
    }
}

fn word(whirl: Option<Whirl>) -> &'static str {
    whirl.map_or(number::NONE, key)
}

/// Its number, and its whirl at the highest speed.
fn name(index: usize, branch: &Branch) -> String {
    match branch.whirl.last().copied().flatten() {
        Some(whirl) => format!("{} {}", index + 1, key(whirl)),
        None => format!("{}", index + 1),
    }
}

#[derive(Serialize)]
struct Json<'a> {
    bounds: &'static str,
    complete: bool,
    followed: bool,
    speed: &'a [f64],
    orders: &'a [f64],
    critical: Vec<CriticalJson>,
    branches: Vec<BranchJson>,
}

#[derive(Serialize)]
struct CriticalJson {
    order: f64,
    speed: f64,
    bound: f64,
    count: usize,
    eigenvalue: RootJson,
    whirl: Option<&'static str>,
}

#[derive(Serialize)]
struct RootJson {
    re: f64,
    im: f64,
}

#[derive(Serialize)]
struct BranchJson {
    re: Vec<f64>,
    im: Vec<f64>,
    whirl: Vec<Option<&'static str>>,
}
