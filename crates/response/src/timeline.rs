//! All loads together, cut into pieces at the instants where one of them changes.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use eigentone_digits::DoubleDouble;

use crate::grid::TimeGrid;
use crate::load::{Harmonic, Hold, Load, LoadError, Samples};
use crate::problem::AppliedLoad;

/// An exact instant: about 32 digits, and the grid index where it is one of the grid's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant {
    pub(crate) time: DoubleDouble,
    pub(crate) index: Option<u64>,
}

impl Instant {
    /// t_k = k·step, exactly.
    pub fn on_grid(grid: &TimeGrid, index: u64) -> Instant {
        let time = DoubleDouble::product(index as f64, grid.step());
        Instant {
            time,
            index: Some(index),
        }
    }

    /// An event's double; where it is the one printed for t_k, it is t_k.
    pub fn event(grid: &TimeGrid, at: f64) -> Instant {
        let index = (at / grid.step()).round();
        if (0.0..=grid.last() as f64).contains(&index) && grid.time(index as u64) == at {
            return Instant::on_grid(grid, index as u64);
        }
        Instant {
            time: DoubleDouble::from(at),
            index: None,
        }
    }

    /// Earlier or later; two grid instants by their indices.
    pub fn order(&self, other: &Instant) -> Ordering {
        match (self.index, other.index) {
            (Some(a), Some(b)) => a.cmp(&b),
            _ => self
                .time
                .partial_cmp(&other.time)
                .expect("instants are finite"),
        }
    }

    /// Its seconds since t = 0.
    pub fn time(&self) -> DoubleDouble {
        self.time
    }

    /// Its index on the grid, if it is one of the grid's own.
    pub fn index(&self) -> Option<u64> {
        self.index
    }

    /// The seconds from an earlier instant to this one; whole steps exactly.
    pub fn elapsed(&self, earlier: &Instant, grid: &TimeGrid) -> DoubleDouble {
        match (earlier.index, self.index) {
            (Some(a), Some(b)) => DoubleDouble::product((b - a) as f64, grid.step()),
            _ => self.time - earlier.time,
        }
    }

    /// [`elapsed`](Self::elapsed), rounded once.
    pub(crate) fn since(&self, earlier: &Instant, grid: &TimeGrid) -> f64 {
        self.elapsed(earlier, grid).to_f64()
    }
}

/// How the samples of a load lie on the response's grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SampleGrid {
    /// Sample j lies at j·p·step.
    Multiple(u64),
    /// Sample j lies at j·step/p.
    Divided(u64),
}

impl SampleGrid {
    /// Relates a sample spacing to the grid's; they fit where their ratio, or its inverse, is a
    /// whole number to 1e-12.
    pub(crate) fn of(sample: f64, grid: f64) -> Result<SampleGrid, LoadError> {
        let whole = |ratio: f64| {
            let p = ratio.round();
            let fits = (1.0..=9e15).contains(&p) && (ratio - p).abs() <= 1e-12 * p;
            fits.then_some(p as u64)
        };
        whole(sample / grid)
            .map(SampleGrid::Multiple)
            .or_else(|| whole(grid / sample).map(SampleGrid::Divided))
            .ok_or(LoadError::SampleGrid { step: sample, grid })
    }

    /// Where sample j lies, or `None` beyond the grid's end.
    fn instant(self, j: u64, grid: &TimeGrid) -> Option<Instant> {
        match self {
            SampleGrid::Multiple(p) => j
                .checked_mul(p)
                .filter(|index| *index <= grid.last())
                .map(|index| Instant::on_grid(grid, index)),
            SampleGrid::Divided(p) if j.is_multiple_of(p) => {
                SampleGrid::Multiple(1).instant(j / p, grid)
            }
            SampleGrid::Divided(p) if j / p >= grid.last() => None,
            SampleGrid::Divided(p) => {
                let common = greatest_common_divisor(j, p);
                let whole = DoubleDouble::product((j / common) as f64, grid.step());
                let time = whole / DoubleDouble::from((p / common) as f64);
                Some(Instant { time, index: None })
            }
        }
    }

    /// The samples' spacing in s.
    fn spacing(self, grid: &TimeGrid) -> DoubleDouble {
        match self {
            SampleGrid::Multiple(p) => DoubleDouble::product(p as f64, grid.step()),
            SampleGrid::Divided(p) => {
                DoubleDouble::from(grid.step()) / DoubleDouble::from(p as f64)
            }
        }
    }
}

fn greatest_common_divisor(a: u64, b: u64) -> u64 {
    if b == 0 {
        a
    } else {
        greatest_common_divisor(b, a % b)
    }
}

/// A force on one coordinate that runs straight through a piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Straight {
    /// Index of the coordinate.
    pub coordinate: usize,
    /// The force at the start of the piece, in N.
    pub value: f64,
    /// Its growth, in N/s.
    pub slope: f64,
}

/// A stretch of time in which no load changes its law.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    pub(crate) start: Instant,
    straight: Vec<Straight>,
    impulses: Vec<(usize, f64)>,
}

impl Piece {
    /// Where it begins, in s; it ends where the next one begins.
    pub fn start(&self) -> f64 {
        self.start.time.to_f64()
    }

    /// Where it begins, exactly.
    pub fn start_instant(&self) -> Instant {
        self.start
    }

    /// The forces that are constant or grow steadily, one entry for each coordinate that has any.
    pub fn straight(&self) -> &[Straight] {
        &self.straight
    }

    /// The blows at its start: index of the coordinate and momentum in N·s.
    pub fn impulses(&self) -> &[(usize, f64)] {
        &self.impulses
    }
}

/// All loads of a problem, in pieces.
#[derive(Clone, Debug, PartialEq)]
pub struct Timeline {
    pieces: Vec<Piece>,
    harmonics: Vec<(usize, Harmonic)>,
}

/// From an instant on, a load has this value and slope.
struct Change {
    at: Instant,
    load: usize,
    value: f64,
    slope: f64,
}

impl Timeline {
    /// The pieces; the first begins at 0.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// The sinusoidal forces, which run through all pieces: index of the coordinate, and the load.
    pub fn harmonics(&self) -> &[(usize, Harmonic)] {
        &self.harmonics
    }

    /// The force on every coordinate at time `t` s by the law of the given piece, without impulses;
    /// `force` has one entry for each coordinate.
    pub fn force(&self, piece: usize, t: f64, force: &mut [f64]) {
        force.fill(0.0);
        let piece = &self.pieces[piece];
        for straight in &piece.straight {
            let elapsed = (DoubleDouble::from(t) - piece.start.time).to_f64();
            force[straight.coordinate] += straight.value + straight.slope * elapsed;
        }
        for (coordinate, harmonic) in &self.harmonics {
            let angle = harmonic.frequency * t + harmonic.phase;
            force[*coordinate] += harmonic.amplitude * angle.sin();
        }
    }

    /// Cuts checked loads into pieces; what happens after the grid's end is left out.
    pub(crate) fn of(loads: &[AppliedLoad], grid: &TimeGrid) -> Timeline {
        let origin = Instant::on_grid(grid, 0);
        let end = Instant::on_grid(grid, grid.last());
        let mut changes = Vec::new();
        let mut impulses = Vec::new();
        let mut harmonics = Vec::new();
        for (index, applied) in loads.iter().enumerate() {
            let mut change = |at, value, slope| {
                changes.push(Change {
                    at,
                    load: index,
                    value,
                    slope,
                });
            };
            match &applied.load {
                Load::Step(step) if step.start <= 0.0 => change(origin, step.force, 0.0),
                Load::Step(step) => change(Instant::event(grid, step.start), step.force, 0.0),
                Load::Ramp(ramp) if ramp.start <= 0.0 => {
                    change(origin, ramp.rate * -ramp.start, ramp.rate);
                }
                Load::Ramp(ramp) => change(Instant::event(grid, ramp.start), 0.0, ramp.rate),
                Load::Impulse(impulse) => {
                    let at = Instant::event(grid, impulse.at);
                    impulses.push((at, applied.coordinate, impulse.magnitude));
                }
                Load::Harmonic(harmonic) => harmonics.push((applied.coordinate, *harmonic)),
                Load::Samples(samples) => sample_changes(samples, grid, change),
            }
        }
        changes.retain(|change| change.at.order(&end) != Ordering::Greater);
        impulses.retain(|(at, ..)| at.order(&end) != Ordering::Greater);
        changes.sort_by(|a, b| a.at.order(&b.at));

        let mut starts: Vec<Instant> = vec![origin];
        starts.extend(changes.iter().map(|change| change.at));
        starts.extend(impulses.iter().map(|(at, ..)| *at));
        starts.sort_by(Instant::order);
        starts.dedup_by(|a, b| a.order(b) == Ordering::Equal);

        impulses.sort_by(|a, b| a.0.order(&b.0));
        let mut now: BTreeMap<usize, Change> = BTreeMap::new();
        let mut upcoming = changes.into_iter().peekable();
        let mut blows = impulses.into_iter().peekable();
        let pieces = starts.into_iter().map(|start| {
            while let Some(change) =
                upcoming.next_if(|change| change.at.order(&start) != Ordering::Greater)
            {
                now.insert(change.load, change);
            }
            let here = std::iter::from_fn(|| {
                blows.next_if(|(at, ..)| at.order(&start) != Ordering::Greater)
            });
            Piece {
                start,
                straight: straight_at(&start, &now, loads, grid),
                impulses: here
                    .map(|(_, coordinate, magnitude)| (coordinate, magnitude))
                    .collect(),
            }
        });
        Timeline {
            pieces: pieces.collect(),
            harmonics,
        }
    }
}

/// The changes that the samples of one load make, up to the grid's end.
fn sample_changes(samples: &Samples, grid: &TimeGrid, mut change: impl FnMut(Instant, f64, f64)) {
    let lie = SampleGrid::of(samples.step, grid.step()).expect("checked in Problem::new");
    let spacing = lie.spacing(grid);
    for (j, value) in samples.values.iter().enumerate() {
        let Some(at) = lie.instant(j as u64, grid) else {
            break;
        };
        let slope = match (samples.hold, samples.values.get(j + 1)) {
            (Hold::First, Some(next)) => {
                ((DoubleDouble::from(*next) - DoubleDouble::from(*value)) / spacing).to_f64()
            }
            _ => 0.0,
        };
        change(at, *value, slope);
    }
}

/// The sum of all loads that run straight, by coordinate, at the start of a piece.
fn straight_at(
    start: &Instant,
    now: &BTreeMap<usize, Change>,
    loads: &[AppliedLoad],
    grid: &TimeGrid,
) -> Vec<Straight> {
    let mut sums: Vec<Straight> = Vec::new();
    for change in now.values() {
        let value = change.value + change.slope * start.since(&change.at, grid);
        let coordinate = loads[change.load].coordinate;
        match sums.iter_mut().find(|sum| sum.coordinate == coordinate) {
            Some(sum) => {
                sum.value += value;
                sum.slope += change.slope;
            }
            None => sums.push(Straight {
                coordinate,
                value,
                slope: change.slope,
            }),
        }
    }
    sums
}
