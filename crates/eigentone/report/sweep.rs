//! The designs of a sweep as CSV, plots, maps and a page.

use std::io::{self, Write};

use eigentone_digits::sort_by_number;

use super::axis::{Axis, Scale};
use super::csv;
use super::map::Map;
use super::page;
use super::plot::{Line, Plot};
use super::table::visible;

/// One design of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct SweptDesign {
    /// Its index among all designs.
    pub index: u64,
    /// The values of what varies.
    pub values: Vec<f64>,
    /// The metrics; `None` where one is infinite or not known.
    pub metrics: Vec<Option<f64>>,
    /// Re λ and Im λ of each root at its place.
    pub roots: Vec<[f64; 2]>,
    /// The places of the roots that have no bound: they may be far from any root.
    pub doubtful_roots: Vec<usize>,
    /// Whether the places of the roots are a choice.
    pub has_doubtful_places: bool,
}

impl SweptDesign {
    /// The numbers of the doubtful roots, as in the names of their columns: the first is 1.
    pub fn numbers_of_doubtful_roots(&self, separator: &str) -> String {
        let numbers = self.doubtful_roots.iter();
        let numbers: Vec<String> = numbers.map(|place| (place + 1).to_string()).collect();
        numbers.join(separator)
    }
}

/// The columns of a table of designs: a row has index, parameters, metrics, roots, whether places are doubtful, and the numbers of
/// the roots that are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SweepTable {
    /// What varies.
    pub parameters: Vec<String>,
    /// What is reported of each design.
    pub metrics: Vec<String>,
    /// The units of both, one after the other; empty where one is not known.
    pub units: Vec<String>,
}

impl SweepTable {
    /// Name and unit of what varies.
    pub(super) fn parameter(&self, k: usize) -> [&str; 2] {
        [&self.parameters[k], self.unit(k)]
    }

    /// Name and unit of what is measured.
    pub(super) fn metric(&self, k: usize) -> [&str; 2] {
        [&self.metrics[k], self.unit(self.parameters.len() + k)]
    }

    fn unit(&self, k: usize) -> &str {
        self.units.get(k).map_or("", String::as_str)
    }

    /// The header of a table of designs that have so many roots.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn header(&self, roots: usize, out: &mut impl Write) -> io::Result<()> {
        let names = self.parameters.iter().chain(&self.metrics);
        let names = names.map(|name| visible(name));
        let roots = (1..=roots).flat_map(|k| [format!("re {k}"), format!("im {k}")]);
        let head = ["design".to_owned()].into_iter().chain(names).chain(roots);
        let doubts = ["doubtful", "doubtful roots"].map(str::to_owned);
        csv::row(out, head.chain(doubts))
    }

    /// A row with all digits.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn row(&self, design: &SweptDesign, out: &mut impl Write) -> io::Result<()> {
        let values = design.values.iter().map(|value| csv::number(*value));
        let metrics = design.metrics.iter().map(|value| csv::optional(*value));
        let roots = design.roots.iter().flatten().map(|part| csv::number(*part));
        let cells = [design.index.to_string()].into_iter().chain(values);
        let cells = cells.chain(metrics).chain(roots);
        let doubts = [
            design.has_doubtful_places.to_string(),
            design.numbers_of_doubtful_roots(" "),
        ];
        csv::row(out, cells.chain(doubts))
    }

    /// The design of a row; `None` where it is none of this table.
    pub fn read(&self, row: &str) -> Option<SweptDesign> {
        let mut cells = row.trim_end().split(',');
        let index = cells.next()?.parse().ok()?;
        let mut rest: Vec<&str> = cells.collect();
        let doubtful = rest.pop()?.split_whitespace();
        let doubtful = doubtful.map(|number| number.parse::<usize>().ok()?.checked_sub(1));
        let has_doubtful_places = rest.pop()?.parse().ok()?;
        let (parameters, metrics) = (self.parameters.len(), self.metrics.len());
        let number = |cell: &&str| cell.parse::<f64>().ok();
        let values = rest.get(..parameters)?.iter().map(number);
        let cells = rest.get(parameters..parameters + metrics)?.iter();
        let measured = cells.map(|cell| match *cell {
            "" => Some(None),
            cell => cell.parse().ok().map(Some),
        });
        let parts = rest.get(parameters + metrics..)?.iter().map(number);
        let parts = parts.collect::<Option<Vec<f64>>>()?;
        if parts.len() % 2 != 0 {
            return None;
        }
        Some(SweptDesign {
            index,
            values: values.collect::<Option<_>>()?,
            metrics: measured.collect::<Option<_>>()?,
            roots: parts
                .chunks_exact(2)
                .map(|part| [part[0], part[1]])
                .collect(),
            doubtful_roots: doubtful.collect::<Option<_>>()?,
            has_doubtful_places,
        })
    }
}

/// All designs of a sweep, in the order of their indices.
#[derive(Clone, Copy, Debug)]
pub struct SweepReport<'a> {
    /// What stands above the plots.
    pub title: &'a str,
    /// What varies, of which the last goes through its values first, and what is measured.
    pub table: &'a SweepTable,
    /// The designs.
    pub designs: &'a [SweptDesign],
}

/// A curve over the last parameter: the values of the others, and its designs.
pub(super) type Family<'a> = (String, &'a [SweptDesign]);

impl SweepReport<'_> {
    /// Name and SVG of each metric, as a curve or a few for the choices of the other parameters, as a map over two; of the
    /// largest Re λ over two; and of the roots in the complex plane.
    pub fn drawings(&self) -> Vec<(String, String)> {
        let mut drawings = Vec::new();
        for k in 0..self.table.metrics.len() {
            let svg = self.map(k).or_else(|| Some(self.curves(k)?.svg()));
            drawings.extend(svg.map(|svg| (format!("metric-{}.svg", k + 1), svg)));
        }
        let stability = self.stability();
        drawings.extend(stability.map(|svg| ("stability.svg".to_owned(), svg)));
        drawings.push(("roots.svg".to_owned(), self.roots().svg()));
        drawings
    }

    /// One page of HTML that loads nothing: curves to read values from, maps, roots and a table.
    pub fn html(&self) -> String {
        page::sweep::html(self)
    }

    /// The curves over the last parameter.
    pub(super) fn families(&self) -> Vec<Family<'_>> {
        let others = self.table.parameters.len().saturating_sub(1);
        let families = self
            .designs
            .chunk_by(|a, b| a.values[..others] == b.values[..others]);
        let named = families.map(|family| {
            let names = self.table.parameters.iter().zip(&family[0].values);
            let names = names
                .take(others)
                .map(|(name, value)| format!("{name} {value}"));
            (names.collect::<Vec<_>>().join(", "), family)
        });
        named.collect()
    }

    /// What the last parameter and a metric are drawn on.
    pub(super) fn axes(&self, metric: usize) -> [Axis; 2] {
        let last = self.table.parameters.len() - 1;
        let values = self.designs.iter().map(|design| design.values[last]);
        let [metric, unit] = self.table.metric(metric);
        [
            scaled(self.table.parameter(last), values),
            Axis::linear(metric, unit),
        ]
    }

    /// Curves of a metric; `None` where they are too many to be separated.
    fn curves(&self, k: usize) -> Option<Plot<'_>> {
        const MOST: usize = 12;
        let families = self.families();
        if families.len() > MOST {
            return None;
        }
        let [x, y] = self.axes(k);
        let others = &self.table.parameters[..self.table.parameters.len() - 1];
        let of = match others {
            [] => String::new(),
            names => format!(" for {}", names.join(", ")),
        };
        let lines = families.into_iter().map(|(_, family)| {
            // Names would not fit, and are in the title.
            let values = family[0].values[..others.len()].iter();
            let name = match others {
                [] => self.table.metrics[k].clone(),
                _ => values.map(f64::to_string).collect::<Vec<_>>().join(", "),
            };
            Line::new(&name, family.len(), move |i| {
                let value = family[i].values.last().copied().unwrap_or(f64::NAN);
                (value, family[i].metrics[k].unwrap_or(f64::NAN))
            })
        });
        Some(Plot {
            title: format!("{}: {}{of}", self.title, self.table.metrics[k]),
            x,
            y,
            lines: lines.collect(),
            ring: None,
        })
    }

    /// A metric over two parameters.
    pub(super) fn map(&self, k: usize) -> Option<String> {
        self.over_two(self.table.metric(k), &|design| design.metrics[k])
    }

    /// The largest Re λ over two parameters: above 0 motions grow.
    pub(super) fn stability(&self) -> Option<String> {
        self.over_two(["largest Re λ", "1/s"], &|design| {
            if !design.doubtful_roots.is_empty() {
                return None;
            }
            design.roots.iter().map(|root| root[0]).reduce(f64::max)
        })
    }

    fn over_two(
        &self,
        [what, unit]: [&str; 2],
        value: &dyn Fn(&SweptDesign) -> Option<f64>,
    ) -> Option<String> {
        if self.table.parameters.len() != 2 {
            return None;
        }
        let [first, second] = [0, 1].map(|k| self.table.parameter(k));
        // Values may be listed in any order.
        let sorted = |values: Vec<f64>| {
            let mut order: Vec<usize> = (0..values.len()).collect();
            sort_by_number(&mut order, |at| values[*at]);
            let places: Vec<f64> = order.iter().map(|at| values[*at]).collect();
            let ascend = places.len() > 1 && places.windows(2).all(|pair| pair[0] < pair[1]);
            ascend.then_some((order, places))
        };
        let families = self.families();
        let lengths = families.iter().map(|(_, family)| family.len());
        let columns = families.first()?.1.len();
        if !lengths.clone().all(|length| length == columns) {
            return None;
        }
        let across = families[0].1.iter().map(|design| design.values[1]);
        let (to_right, xs) = sorted(across.collect())?;
        let (upwards, ys) = sorted(
            families
                .iter()
                .map(|(_, family)| family[0].values[0])
                .collect(),
        )?;
        let map = Map {
            title: format!("{}: {what}", self.title),
            axes: [
                scaled(second, xs.iter().copied()),
                scaled(first, ys.iter().copied()),
            ],
            places: [xs, ys],
            what,
            unit,
            value: Box::new(|i, j| value(&families[upwards[j]].1[to_right[i]])),
        };
        map.svg()
    }

    /// Dots of the roots, each place in its colour.
    fn roots(&self) -> Plot<'_> {
        let lines = (0..self.places()).map(|k| {
            let line = Line::new(&format!("root {}", k + 1), self.designs.len(), move |i| {
                self.root(i, k)
            });
            line.dots()
        });
        Plot {
            title: format!("{}: roots", self.title),
            x: Axis::linear("Re λ", "1/s"),
            y: Axis::linear("Im λ", "rad/s"),
            lines: lines.collect(),
            ring: None,
        }
    }

    /// How many roots a design has at most.
    pub(super) fn places(&self) -> usize {
        let places = self.designs.iter().map(|design| design.roots.len());
        places.max().unwrap_or(0)
    }

    /// The root at a place in a design, as a point; none where it is doubtful.
    pub(super) fn root(&self, design: usize, place: usize) -> (f64, f64) {
        let design = &self.designs[design];
        let is_known = !design.doubtful_roots.contains(&place);
        let root = design.roots.get(place).filter(|_| is_known);
        root.map_or((f64::NAN, f64::NAN), |root| (root[0], root[1]))
    }
}

/// An axis of equal ratios where the values have them.
fn scaled([name, unit]: [&str; 2], values: impl Iterator<Item = f64>) -> Axis {
    let mut axis = Axis::linear(name, unit);
    let mut values: Vec<f64> = values.collect();
    sort_by_number(&mut values, |value| *value);
    values.dedup();
    if let [first, .., middle_or_last] = values[..] {
        let middle = values[values.len() / 2];
        let share = (values.len() / 2) as f64 / (values.len() - 1) as f64;
        let even = first + share * (middle_or_last - first);
        if first > 0.0 && middle_or_last / first > 10.0 && middle < even / 2.0 {
            axis.scale = Scale::Logarithmic;
        }
    }
    axis
}
