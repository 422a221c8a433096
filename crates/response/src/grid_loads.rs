//! Loads that change at instants of the grid alone, step by step of it.

use crate::grid::TimeGrid;
use crate::hold::Laws;
use crate::load::{Harmonic, Hold, Load};
use crate::march::reduced_angle;
use crate::problem::{AppliedLoad, Problem};
use crate::timeline::{Instant, SampleGrid};

/// The loads of a problem as what [`exact`](crate::hold::exact) wants at the start of each step: for each
/// law in the order of [`crate::hold::Held::gamma`] one value for each loaded coordinate.
pub(crate) struct GridLoads<'a> {
    /// Indices of the coordinates that any load but an impulse acts on.
    pub(crate) loaded: Vec<usize>,
    pub(crate) laws: Laws,
    /// Blows at t = 0: coordinate and momentum.
    pub(crate) blows: Vec<(usize, f64)>,
    grid: &'a TimeGrid,
    /// Position of the first law, and what acts there.
    acting: Vec<(usize, Acting<'a>)>,
}

enum Acting<'a> {
    /// From this step on.
    Constant {
        force: f64,
        from: u64,
    },
    /// rate·(t − t_from + lead) from this step on.
    Growing {
        rate: f64,
        lead: f64,
        from: u64,
    },
    /// A sample every `every` steps.
    Sampled {
        values: &'a [f64],
        every: u64,
        hold: Hold,
    },
    Harmonic(&'a Harmonic),
}

impl<'a> GridLoads<'a> {
    /// `None` where a load changes between two instants of the grid, or a blow is not at t = 0.
    pub(crate) fn of(problem: &'a Problem<'_>) -> Option<GridLoads<'a>> {
        let grid = problem.grid();
        let loads = problem.loads();
        let lasting = loads
            .iter()
            .filter(|applied| !matches!(applied.load, Load::Impulse(_)));
        let mut loaded: Vec<usize> = lasting.map(|applied| applied.coordinate).collect();
        loaded.sort_unstable();
        loaded.dedup();
        let mut laws = Laws::default();
        for AppliedLoad { load, .. } in loads {
            match load {
                Load::Step(_) => laws.straight = true,
                Load::Ramp(_) => (laws.straight, laws.sloped) = (true, true),
                Load::Samples(samples) => {
                    laws.straight = true;
                    laws.sloped |= samples.hold == Hold::First;
                }
                Load::Harmonic(harmonic) => {
                    if !laws.frequencies.contains(&harmonic.frequency) {
                        laws.frequencies.push(harmonic.frequency);
                    }
                }
                Load::Impulse(_) => {}
            }
        }
        let straight = usize::from(laws.straight) + usize::from(laws.sloped);
        // The step at which something begins, beyond the last one if after the end.
        let begin = |start: f64| {
            if start <= 0.0 {
                return Some(0);
            }
            if start > grid.time(grid.last()) {
                return Some(u64::MAX);
            }
            Instant::event(grid, start).index()
        };
        let mut blows = Vec::new();
        let mut acting = Vec::new();
        for AppliedLoad { coordinate, load } in loads {
            let place = |law: usize| {
                let column = loaded.binary_search(coordinate).unwrap_or(0);
                law * loaded.len() + column
            };
            match load {
                Load::Step(step) => {
                    let (force, from) = (step.force, begin(step.start)?);
                    acting.push((place(0), Acting::Constant { force, from }));
                }
                Load::Ramp(ramp) => {
                    let (rate, from) = (ramp.rate, begin(ramp.start)?);
                    let lead = (-ramp.start).max(0.0);
                    acting.push((place(0), Acting::Growing { rate, lead, from }));
                }
                Load::Samples(samples) => {
                    let SampleGrid::Multiple(every) =
                        SampleGrid::of(samples.step, grid.step()).ok()?
                    else {
                        return None;
                    };
                    let sampled = Acting::Sampled {
                        values: &samples.values,
                        every,
                        hold: samples.hold,
                    };
                    acting.push((place(0), sampled));
                }
                Load::Harmonic(harmonic) => {
                    let known = laws.frequencies.iter();
                    let index = known
                        .clone()
                        .position(|frequency| *frequency == harmonic.frequency)?;
                    let place = place(straight + 2 * index);
                    acting.push((place, Acting::Harmonic(harmonic)));
                }
                Load::Impulse(impulse) => match begin(impulse.at)? {
                    0 => blows.push((*coordinate, impulse.magnitude)),
                    u64::MAX => {}
                    _ => return None,
                },
            }
        }
        Some(GridLoads {
            loaded,
            laws,
            blows,
            grid,
            acting,
        })
    }

    /// How many values there are in a step.
    pub(crate) fn width(&self) -> usize {
        let straight = usize::from(self.laws.straight) + usize::from(self.laws.sloped);
        self.loaded.len() * (straight + 2 * self.laws.frequencies.len())
    }

    /// The values of the steps from `first` on, one step after the other.
    pub(crate) fn fill(&self, first: u64, out: &mut [f64]) {
        let width = self.width();
        if width == 0 {
            return;
        }
        out.fill(0.0);
        // From the first to the second law of the same coordinate.
        let second = self.loaded.len();
        let h = self.grid.step();
        for (place, acting) in &self.acting {
            let steps = (first..).zip(out.chunks_exact_mut(width));
            match acting {
                Acting::Constant { force, from } => {
                    for (_, step) in steps.filter(|(k, _)| k >= from) {
                        step[*place] += force;
                    }
                }
                Acting::Growing { rate, lead, from } => {
                    for (k, step) in steps.filter(|(k, _)| k >= from) {
                        step[*place] += rate * ((k - from) as f64 * h + lead);
                        step[place + second] += rate * h;
                    }
                }
                Acting::Sampled {
                    values,
                    every: 1,
                    hold,
                } => {
                    let last = values.len() - 1;
                    let at = |k: u64| values[usize::try_from(k).map_or(last, |k| k.min(last))];
                    let sloped = *hold == Hold::First;
                    for (k, step) in steps {
                        let value = at(k);
                        step[*place] += value;
                        if sloped {
                            step[place + second] += at(k + 1) - value;
                        }
                    }
                }
                Acting::Sampled {
                    values,
                    every,
                    hold,
                } => {
                    let last = values.len() - 1;
                    let at = |j: u64| values[usize::try_from(j).map_or(last, |j| j.min(last))];
                    for (k, step) in steps {
                        let (j, rest) = (k / every, k % every);
                        let value = at(j);
                        match hold {
                            Hold::Zero => step[*place] += value,
                            Hold::First => {
                                let rise = (at(j + 1) - value) / *every as f64;
                                step[*place] += value + rise * rest as f64;
                                step[place + second] += rise;
                            }
                        }
                    }
                }
                Acting::Harmonic(harmonic) => {
                    let Harmonic {
                        amplitude,
                        frequency,
                        phase,
                    } = harmonic;
                    for (k, step) in steps {
                        let time = Instant::on_grid(self.grid, k).time();
                        let (sine, cosine) = reduced_angle(*frequency, time, *phase).sin_cos();
                        step[*place] += amplitude * sine;
                        step[place + second] += amplitude * cosine;
                    }
                }
            }
        }
    }
}
