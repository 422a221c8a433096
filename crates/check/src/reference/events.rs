//! What sets a system in motion, as changes at exact instants.

use eigentone_response::{HalfSine, Harmonic, Hold, Load, Problem, Samples, TimeGrid, Versine};
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::Zero;

use super::equation::exactly;
use super::error::ReferenceError;

/// A change of one load at an instant.
pub(super) struct Event {
    /// In s.
    pub(super) time: BigRational,
    /// Which load, from 0.
    pub(super) load: usize,
    /// The coordinate; beyond them, the channel.
    pub(super) coordinate: usize,
    pub(super) change: Change,
}

/// What changes.
pub(super) enum Change {
    /// The force jumps, in N.
    Force(BigRational),
    /// Its growth jumps, in N/s.
    Slope(BigRational),
    /// An impulse, in N·s.
    Impulse(BigRational),
}

/// A sinusoid that lasts for a time, from rest to rest.
pub(super) struct Pulse {
    /// Which load, from 0.
    pub(super) load: usize,
    /// The coordinate; beyond them, the channel.
    pub(super) coordinate: usize,
    /// In s.
    pub(super) start: BigRational,
    pub(super) end: BigRational,
    /// The largest value.
    pub(super) height: BigRational,
    /// height·sin φ of one half turn, or height/2·(1 − cos φ) of two.
    pub(super) half_turns: u8,
}

/// All loads of a problem.
#[derive(Default)]
pub(super) struct Events {
    /// Of the loads that run straight, and the impulses; in no order.
    pub(super) changes: Vec<Event>,
    /// By coordinate, or beyond them channel; they run from 0 on.
    pub(super) harmonics: Vec<(usize, Harmonic)>,
    pub(super) pulses: Vec<Pulse>,
}

impl Events {
    pub(super) fn of(problem: &Problem<'_>) -> Result<Events, ReferenceError> {
        let grid = problem.grid();
        let mut events = Events::default();
        for (load, applied) in problem.drives().iter().enumerate() {
            let coordinate = applied.coordinate;
            let mut at = |time: BigRational, change| {
                events.changes.push(Event {
                    time,
                    load,
                    coordinate,
                    change,
                });
            };
            match &applied.load {
                Load::Step(step) => {
                    at(event(grid, step.start), Change::Force(exactly(step.force)));
                }
                Load::Ramp(ramp) => {
                    let (start, rate) = (event(grid, ramp.start), exactly(ramp.rate));
                    if ramp.start < 0.0 {
                        let reached = -exactly(ramp.start) * &rate;
                        at(start.clone(), Change::Force(reached));
                    }
                    at(start, Change::Slope(rate));
                }
                Load::Impulse(impulse) => {
                    let change = Change::Impulse(exactly(impulse.magnitude));
                    at(event(grid, impulse.at), change);
                }
                Load::Samples(samples) => sampled(samples, grid, at),
                Load::Harmonic(harmonic) => events.harmonics.push((coordinate, *harmonic)),
                Load::HalfSine(HalfSine {
                    force,
                    duration,
                    start,
                })
                | Load::Versine(Versine {
                    force,
                    duration,
                    start,
                }) => {
                    let start = event(grid, *start);
                    events.pulses.push(Pulse {
                        load,
                        coordinate,
                        end: &start + exactly(*duration),
                        start,
                        height: exactly(*force),
                        half_turns: match applied.load {
                            Load::HalfSine(_) => 1,
                            _ => 2,
                        },
                    });
                }
                _ => return Err(ReferenceError::UnknownLoad { load }),
            }
        }
        Ok(events)
    }
}

/// t_k = k·step.
pub(super) fn grid_time(grid: &TimeGrid, index: u64) -> BigRational {
    exactly(grid.step()) * BigRational::from(BigInt::from(index))
}

/// The instant of an event at the double `at`: t_k where it is the double printed for that, and 0
/// where it comes before.
fn event(grid: &TimeGrid, at: f64) -> BigRational {
    let index = (at / grid.step()).round();
    if at <= 0.0 {
        BigRational::zero()
    } else if index <= grid.last() as f64 && grid.time(index as u64) == at {
        grid_time(grid, index as u64)
    } else {
        exactly(at)
    }
}

/// Jumps of a force that is held, or of the slope of one that runs from sample to sample.
fn sampled(samples: &Samples, grid: &TimeGrid, mut at: impl FnMut(BigRational, Change)) {
    let spacing = spacing(samples.step, grid);
    let values: Vec<BigRational> = samples.values.iter().map(|value| exactly(*value)).collect();
    let time = |j: usize| &spacing * BigRational::from(BigInt::from(j));
    match samples.hold {
        Hold::Zero => {
            let mut before = BigRational::zero();
            for (j, value) in values.into_iter().enumerate() {
                at(time(j), Change::Force(&value - before));
                before = value;
            }
        }
        Hold::First => {
            at(time(0), Change::Force(values[0].clone()));
            let mut before = BigRational::zero();
            for j in 0..values.len() {
                let slope = match values.get(j + 1) {
                    Some(next) => (next - &values[j]) / &spacing,
                    None => BigRational::zero(),
                };
                at(time(j), Change::Slope(&slope - before));
                before = slope;
            }
        }
    }
}

/// The samples' spacing: the grid's step times or divided by the whole number that is meant.
fn spacing(sample: f64, grid: &TimeGrid) -> BigRational {
    let step = exactly(grid.step());
    let whole = |ratio: f64| exactly(ratio.round());
    match sample >= 0.5 * grid.step() && (sample / grid.step()).round() >= 1.0 {
        true if fits(sample / grid.step()) => step * whole(sample / grid.step()),
        _ => step / whole(grid.step() / sample),
    }
}

/// Whether a ratio is a whole number up to what doubles leave open.
fn fits(ratio: f64) -> bool {
    (ratio - ratio.round()).abs() <= 1e-12 * ratio
}
