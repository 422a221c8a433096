//! All loads together, cut into pieces at the instants where one of them changes.

use std::cmp::Ordering;

use eigentone_digits::{DoubleDouble, Magnitude, Real};

use crate::grid::TimeGrid;
use crate::load::{Harmonic, Hold, Load, LoadError, Samples};
use crate::problem::AppliedLoad;
use crate::straight::{StraightLoad, StraightLoads, units};

/// An exact instant: a fraction of the grid's step times a whole number, or any double.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant {
    pub(crate) time: DoubleDouble,
    fraction: Option<Fraction>,
}

/// numerator/denominator, in lowest terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Fraction {
    pub(crate) numerator: u64,
    pub(crate) denominator: u64,
}

impl Fraction {
    fn of(numerator: u64, denominator: u64) -> Fraction {
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
            fraction: Some(Fraction::of(index, 1)),
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
            fraction: None,
        }
    }

    /// Earlier or later; two instants on the grid, or between its instants, by their fractions.
    pub fn order(&self, other: &Instant) -> Ordering {
        match (self.fraction, other.fraction) {
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
        let whole = self.fraction.filter(|fraction| fraction.denominator == 1);
        whole.map(|fraction| fraction.numerator)
    }

    /// How many steps of the grid it is away from 0, unless it is an event by itself.
    pub(crate) fn fraction(&self) -> Option<Fraction> {
        self.fraction
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
                let fraction = Fraction::of(j, p);
                let whole = DoubleDouble::product(fraction.numerator as f64, grid.step());
                Some(Instant {
                    time: whole / DoubleDouble::from(fraction.denominator as f64),
                    fraction: Some(fraction),
                })
            }
        }
    }

    /// The samples' spacing in steps of the grid.
    fn steps(self) -> Fraction {
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

/// What a load that runs straight does from an instant on, without rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Law {
    /// Which load, from 0; its next law ends this one.
    pub(crate) load: usize,
    pub(crate) coordinate: usize,
    pub(crate) since: Instant,
    run: Run,
}

/// The force as a function of the time τ since the law set in.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Run {
    Constant(f64),
    /// rate·(τ + lead).
    Growing {
        rate: f64,
        lead: f64,
    },
    /// from + (to − from)·τ/(steps·step).
    Towards {
        from: f64,
        to: f64,
        steps: Fraction,
        step: f64,
    },
}

impl Law {
    pub(crate) fn is_sloped(&self) -> bool {
        !matches!(self.run, Run::Constant(_))
    }

    /// Force and slope when the law sets in.
    pub(crate) fn start<T: Real>(&self) -> StraightLoad<T> {
        let known = |value: f64| (T::from(value), Magnitude::ZERO);
        match self.run {
            Run::Constant(force) => StraightLoad {
                value: known(force),
                slope: known(0.0),
            },
            Run::Growing { rate, lead } => {
                let start = T::from(rate) * T::from(lead);
                let error = match lead == 0.0 || rate == 0.0 {
                    true => Magnitude::ZERO,
                    false => start.upper() * T::unit() + T::floor(),
                };
                StraightLoad {
                    value: (start, error),
                    slope: known(rate),
                }
            }
            Run::Towards {
                from,
                to,
                steps,
                step,
            } => {
                let slope = (T::from(to) - T::from(from)) / (steps.value::<T>() * T::from(step));
                let error = slope.upper() * units::<T>() + T::floor();
                StraightLoad {
                    value: known(from),
                    slope: (slope, error),
                }
            }
        }
    }
}

/// A stretch of time in which no load changes its law.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    pub(crate) start: Instant,
    changes: Vec<Law>,
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

    /// The laws that set in at its start.
    pub(crate) fn changes(&self) -> &[Law] {
        &self.changes
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
        let mut laws: Vec<Law> = Vec::new();
        let mut impulses = Vec::new();
        let mut harmonics = Vec::new();
        for (load, applied) in loads.iter().enumerate() {
            let coordinate = applied.coordinate;
            let mut law = |since, run| {
                laws.push(Law {
                    load,
                    coordinate,
                    since,
                    run,
                });
            };
            // What starts before 0 is already on at 0.
            let begin = |start: f64| {
                if start <= 0.0 {
                    (origin, -start)
                } else {
                    (Instant::event(grid, start), 0.0)
                }
            };
            match &applied.load {
                Load::Step(step) => law(begin(step.start).0, Run::Constant(step.force)),
                Load::Ramp(ramp) => {
                    let (since, lead) = begin(ramp.start);
                    let rate = ramp.rate;
                    law(since, Run::Growing { rate, lead });
                }
                Load::Impulse(impulse) => {
                    let at = Instant::event(grid, impulse.at);
                    impulses.push((at, coordinate, impulse.magnitude));
                }
                Load::Harmonic(harmonic) => harmonics.push((coordinate, *harmonic)),
                Load::Samples(samples) => sample_laws(samples, grid, law),
            }
        }
        laws.retain(|law| law.since.order(&end) != Ordering::Greater);
        impulses.retain(|(at, ..)| at.order(&end) != Ordering::Greater);
        laws.sort_by(|a, b| a.since.order(&b.since));

        let mut starts: Vec<Instant> = vec![origin];
        starts.extend(laws.iter().map(|law| law.since));
        starts.extend(impulses.iter().map(|(at, ..)| *at));
        starts.sort_by(Instant::order);
        starts.dedup_by(|a, b| a.order(b) == Ordering::Equal);

        impulses.sort_by(|a, b| a.0.order(&b.0));
        let mut now = StraightLoads::<DoubleDouble>::of(loads);
        let seconds = |from: &Instant, to: &Instant| (to.elapsed(from, grid), Magnitude::ZERO);
        let mut upcoming = laws.into_iter().peekable();
        let mut blows = impulses.into_iter().peekable();
        let pieces = starts.into_iter().map(|start| {
            let mut changes = Vec::new();
            while let Some(law) =
                upcoming.next_if(|law| law.since.order(&start) != Ordering::Greater)
            {
                now.set(&law, seconds);
                changes.push(law);
            }
            let here = std::iter::from_fn(|| {
                blows.next_if(|(at, ..)| at.order(&start) != Ordering::Greater)
            });
            let straight = now.now(|since| seconds(since, &start));
            let straight = straight.map(|(coordinate, straight)| Straight {
                coordinate,
                value: straight.value.0.to_f64(),
                slope: straight.slope.0.to_f64(),
            });
            Piece {
                start,
                changes,
                straight: straight.collect(),
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

/// The laws that the samples of one load follow, up to the grid's end.
fn sample_laws(samples: &Samples, grid: &TimeGrid, mut law: impl FnMut(Instant, Run)) {
    let lie = SampleGrid::of(samples.step, grid.step()).expect("checked in Problem::new");
    for (j, value) in samples.values.iter().enumerate() {
        let Some(at) = lie.instant(j as u64, grid) else {
            break;
        };
        let run = match (samples.hold, samples.values.get(j + 1)) {
            (Hold::First, Some(next)) if next != value => Run::Towards {
                from: *value,
                to: *next,
                steps: lie.steps(),
                step: grid.step(),
            },
            _ => Run::Constant(*value),
        };
        law(at, run);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentone_digits::Wide;

    /// A sine of phase, a step at 1 s and a ramp from 2 s on.
    #[test]
    fn the_force_of_an_instant_is_the_sum_of_its_loads() {
        let system = eigentone_modes::System::builder().mass("m", 1.0);
        let system = system.build().expect("a system");
        let response = crate::Response::of(&system)
            .load("m", crate::Harmonic::of(3.0, 0.5).with_phase(0.25))
            .load("m", crate::Step::of(5.0).starting_at(1.0))
            .load("m", crate::Ramp::of(7.0).starting_at(2.0));
        let problem = response.every(0.5).until(10.0).problem();
        let problem = problem.expect("a problem");
        for (piece, time, straight) in [(0, 0.75, 0.0), (1, 1.5, 5.0), (2, 4.0, 19.0)] {
            let mut force = [f64::NAN];
            problem.timeline().force(piece, time, &mut force);
            let wanted = straight + 3.0 * (0.5 * time + 0.25).sin();
            assert!((force[0] - wanted).abs() < 1e-14, "{time}: {}", force[0]);
        }
    }

    /// Forces of 106 bits against those of 1024: what is rounded is within the errors stated, in units
    /// small and large.
    #[test]
    fn rounding_of_loads_is_counted() {
        let grid = TimeGrid::new(0.1, 1.0).expect("a grid");
        let time = DoubleDouble::from(1.0) / DoubleDouble::from(7.0);
        let mut rounded = 0;
        for unit in [1e-12, 1.0, 1e12] {
            for run in [
                Run::Growing {
                    rate: 0.3 * unit,
                    lead: 0.7,
                },
                Run::Towards {
                    from: 0.1 * unit,
                    to: 0.7 * unit,
                    steps: Fraction::of(1, 3),
                    step: 0.1,
                },
            ] {
                let law = Law {
                    load: 0,
                    coordinate: 0,
                    since: Instant::on_grid(&grid, 0),
                    run,
                };
                let coarse = law.start::<DoubleDouble>();
                let coarse = coarse.after((time, Magnitude::ZERO));
                let exact = law.start::<Wide<16>>();
                let exact = exact.after((Wide::from(time), Magnitude::ZERO));
                let (value, error) = coarse.value;
                let off = (exact.value.0 - Wide::from(value)).to_f64().abs();
                assert!(
                    off <= error.to_f64(),
                    "{run:?}: {off:e} {:e}",
                    error.to_f64()
                );
                assert!(error.to_f64() <= 1e-29 * exact.value.0.to_f64());
                rounded += usize::from(off > 0.0);
                let (slope, error) = coarse.slope;
                let off = (exact.slope.0 - Wide::from(slope)).to_f64().abs();
                assert!(
                    off <= error.to_f64(),
                    "{run:?}: {off:e} {:e}",
                    error.to_f64()
                );
            }
        }
        assert!(rounded >= 4, "these are to be rounded");
    }
}
