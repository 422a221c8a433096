//! Exact instants.

use std::cmp::Ordering;

use eigentone_digits::{DoubleDouble, Real};

use super::grid::TimeGrid;
use super::load::LoadError;

/// An exact instant: a fraction of the grid's step times a whole number, or any double; or so many seconds after either.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant {
    pub(crate) time: DoubleDouble,
    base: Base,
    /// In s.
    later: f64,
}

/// What an instant is counted from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Base {
    /// Steps of the grid after 0.
    Steps(Fraction),
    /// An event by itself, in s.
    Event(f64),
}

/// numerator/denominator, in lowest terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Fraction {
    pub(crate) numerator: u64,
    pub(crate) denominator: u64,
}

impl Fraction {
    pub(super) fn of(numerator: u64, denominator: u64) -> Fraction {
        let common = greatest_common_divisor(numerator, denominator);
        Fraction {
            numerator: numerator / common,
            denominator: denominator / common,
        }
    }

    /// As a number.
    pub(crate) fn value<T: Real>(self) -> T {
        T::from(self.numerator as f64) / T::from(self.denominator as f64)
    }
}

impl Instant {
    /// t_k = k·step, exactly.
    pub fn on_grid(grid: &TimeGrid, index: u64) -> Instant {
        Instant {
            time: DoubleDouble::product(index as f64, grid.step()),
            base: Base::Steps(Fraction::of(index, 1)),
            later: 0.0,
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
            base: Base::Event(at),
            later: 0.0,
        }
    }

    /// So many seconds later; not to be asked of such an instant again.
    pub(super) fn after(&self, seconds: f64) -> Instant {
        Instant {
            time: self.time + DoubleDouble::from(seconds),
            later: seconds,
            ..*self
        }
    }

    /// What it is counted from, and how many seconds it comes later.
    pub(crate) fn parts(&self) -> (Base, f64) {
        (self.base, self.later)
    }

    /// Earlier or later; two instants on the grid, or between its instants, by their fractions.
    pub fn order(&self, other: &Instant) -> Ordering {
        match (self.fraction(), other.fraction()) {
            (Some(a), Some(b)) => {
                let cross =
                    |a: Fraction, b: Fraction| u128::from(a.numerator) * u128::from(b.denominator);
                cross(a, b).cmp(&cross(b, a))
            }
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
        let whole = self.fraction().filter(|fraction| fraction.denominator == 1);
        whole.map(|fraction| fraction.numerator)
    }

    /// How many steps of the grid it is away from 0, unless it is an event by itself.
    pub(crate) fn fraction(&self) -> Option<Fraction> {
        match self.base {
            Base::Steps(fraction) if self.later == 0.0 => Some(fraction),
            _ => None,
        }
    }

    /// The seconds from an earlier instant to this one; whole steps exactly.
    pub fn elapsed(&self, earlier: &Instant, grid: &TimeGrid) -> DoubleDouble {
        match (earlier.index(), self.index()) {
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
    pub(super) fn instant(self, j: u64, grid: &TimeGrid) -> Option<Instant> {
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
                let fraction = Fraction::of(j, p);
                let whole = DoubleDouble::product(fraction.numerator as f64, grid.step());
                Some(Instant {
                    time: whole / DoubleDouble::from(fraction.denominator as f64),
                    base: Base::Steps(fraction),
                    later: 0.0,
                })
            }
        }
    }

    /// The samples' spacing in steps of the grid.
    pub(super) fn steps(self) -> Fraction {
        match self {
            SampleGrid::Multiple(p) => Fraction::of(p, 1),
            SampleGrid::Divided(p) => Fraction::of(1, p),
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
