//! Loads that change at instants of the grid alone, step by step of it.

use crate::hold::{CANCELS, Laws};
use crate::problem::{
    AppliedLoad, Channel, Harmonic, Hold, Instant, Load, Problem, SampleGrid, Samples, TimeGrid,
    reduced_angle,
};

/// The loads of a problem as signals of which each step needs the values at its start and, where they run on,
/// at its end.
pub(crate) struct GridLoads<'a> {
    /// The inputs of the [`Plant`](crate::problem::Plant) that any load but an impulse acts on.
    pub(crate) loaded: Vec<usize>,
    pub(crate) laws: Laws,
    /// Impulses at t = 0: input and momentum.
    pub(crate) impulses: Vec<(usize, f64)>,
    /// One for each coordinate and way to act on it.
    pub(crate) signals: Vec<Signal<'a>>,
    grid: &'a TimeGrid,
}

/// A signal and what takes it up: columns of the blocks of [`crate::hold::Held::gamma`] side by side.
pub(crate) struct Signal<'a> {
    /// The column for the value at the start of a step.
    pub(crate) value: usize,
    /// The one for its rise up to the end, where it runs straight from step to step without a leap.
    pub(crate) rise: Option<usize>,
    parts: Vec<Part<'a>>,
}

enum Part<'a> {
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
    /// A sample every `every` steps, straight lines or steps in between.
    Sampled {
        values: &'a [f64],
        every: u64,
        hold: Hold,
    },
    /// The slope of the line from sample to sample.
    Slope {
        values: &'a [f64],
        every: u64,
    },
    Sine(&'a Harmonic),
    Cosine(&'a Harmonic),
}

impl<'a> GridLoads<'a> {
    /// `None` where a load changes between two instants of the grid, or an impulse is not at t = 0.
    pub(crate) fn of(problem: &'a Problem<'_>) -> Option<GridLoads<'a>> {
        let plain = |channel: &Channel| !channel.orders().any(|k| k > 1);
        if !problem.channels().iter().all(plain) {
            return None;
        }
        let (grid, n) = (problem.grid(), problem.system().len());
        let loads = problem.drives();
        // The input of a channel's signal itself.
        let input = |on: usize| on.checked_sub(n).map_or(on, |channel| n + 3 * channel);
        // That of its slope, where this acts too.
        let sloped = |on: usize| {
            let channel = problem.channels().get(on.checked_sub(n)?)?;
            channel
                .orders()
                .any(|order| order == 1)
                .then(|| input(on) + 1)
        };
        let lasting = loads
            .iter()
            .filter(|applied| !matches!(applied.load, Load::Impulse(_)));
        let inputs = |on: usize| std::iter::once(input(on)).chain(sloped(on));
        let mut loaded: Vec<usize> = lasting
            .flat_map(|applied| inputs(applied.coordinate))
            .collect();
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
                Load::HalfSine(_) | Load::Versine(_) | Load::Polynomial(_) => return None,
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
        // Steps from sample to sample.
        let every = |samples: &Samples| match SampleGrid::of(samples.step, grid.step()) {
            Ok(SampleGrid::Multiple(every)) => Some(every),
            _ => None,
        };
        let mut impulses = Vec::new();
        let mut signals: Vec<Signal<'a>> = Vec::new();
        for AppliedLoad { coordinate, load } in loads {
            let mut add_to = |on: usize, law: usize, runs: bool, part| {
                let column = loaded.binary_search(&on).unwrap_or(0);
                let place = |law: usize| law * loaded.len() + column;
                let (value, rise) = (place(law), runs.then(|| place(law + 1)));
                let same = |signal: &&mut Signal<'_>| (signal.value, signal.rise) == (value, rise);
                match signals.iter_mut().find(same) {
                    Some(signal) => signal.parts.push(part),
                    None => signals.push(Signal {
                        value,
                        rise,
                        parts: vec![part],
                    }),
                }
            };
            if let Some(slope) = sloped(*coordinate) {
                // Any other jump would be an impulse on the way.
                let Load::Samples(samples) = load else {
                    return None;
                };
                let every = every(samples).filter(|_| samples.hold == Hold::First)?;
                let values = &samples.values;
                add_to(slope, 0, false, Part::Slope { values, every });
                impulses.push((slope, values[0]));
            }
            let mut add = |law, runs, part| add_to(input(*coordinate), law, runs, part);
            match load {
                Load::Step(step) => {
                    let (force, from) = (step.force, begin(step.start)?);
                    add(0, false, Part::Constant { force, from });
                }
                Load::Ramp(ramp) => {
                    let (rate, from) = (ramp.rate, begin(ramp.start)?);
                    let lead = (-ramp.start).max(0.0);
                    add(0, true, Part::Growing { rate, lead, from });
                }
                Load::Samples(samples) => {
                    let sampled = Part::Sampled {
                        values: &samples.values,
                        every: every(samples)?,
                        hold: samples.hold,
                    };
                    add(0, samples.hold == Hold::First, sampled);
                }
                Load::Harmonic(harmonic) => {
                    let known = laws.frequencies.iter();
                    let index = known
                        .clone()
                        .position(|frequency| *frequency == harmonic.frequency)?;
                    add(straight + 2 * index, false, Part::Sine(harmonic));
                    add(straight + 2 * index + 1, false, Part::Cosine(harmonic));
                }
                Load::HalfSine(_) | Load::Versine(_) | Load::Polynomial(_) => return None,
                Load::Impulse(impulse) => match begin(impulse.at)? {
                    0 => impulses.push((input(*coordinate), impulse.magnitude)),
                    u64::MAX => {}
                    _ => return None,
                },
            }
        }
        Some(GridLoads {
            loaded,
            laws,
            impulses,
            signals,
            grid,
        })
    }

    /// The force on each of `n` coordinates, if all loads are constant from the start and act on coordinates.
    pub(crate) fn constant(&self, n: usize) -> Option<Vec<f64>> {
        if self.loaded.last().is_some_and(|input| *input >= n) {
            return None;
        }
        let mut sum = vec![0.0; n];
        for signal in &self.signals {
            for part in &signal.parts {
                let Part::Constant { force, from: 0 } = part else {
                    return None;
                };
                // The only law, so that columns are those of coordinates.
                sum[self.loaded[signal.value]] += force;
            }
        }
        Some(sum)
    }

    /// The signals that add up to an input of the plant, by their places.
    pub(crate) fn of_input(&self, input: usize) -> Vec<usize> {
        let straight = usize::from(self.laws.straight) + usize::from(self.laws.sloped);
        let count = self.loaded.len().max(1);
        let signals = self.signals.iter().enumerate();
        let own = signals.filter(|(_, signal)| {
            let (law, column) = (signal.value / count, signal.value % count);
            // Of a sinusoid the sine is the one, what is a quarter period ahead is not.
            let counts = law == 0 && straight > 0 || law >= straight && (law - straight) % 2 == 0;
            counts && self.loaded[column] == input
        });
        own.map(|(place, _)| place).collect()
    }

    /// The sizes of the parts of every input of the plant at the start, where they cancel; `None` where none do. Later on,
    /// what they have done before is no smaller.
    pub(crate) fn cancelled(&self, inputs: usize) -> Option<Vec<f64>> {
        let mut sizes = vec![0.0; inputs];
        let mut cancels = false;
        for input in &self.loaded {
            let places = self.of_input(*input).into_iter();
            let parts = places.flat_map(|place| &self.signals[place].parts);
            let (mut sum, mut size) = (0.0, 0.0);
            for part in parts {
                let mut value = [0.0];
                part.add(self.grid, 0, &mut value);
                sum += value[0];
                size += value[0].abs();
            }
            if size > CANCELS * f64::abs(sum) {
                sizes[*input] = size;
                cancels = true;
            }
        }
        cancels.then_some(sizes)
    }

    /// The values at the instants from `first` on, signal after signal, `out.len()` / their number each.
    pub(crate) fn fill(&self, first: u64, out: &mut [f64]) {
        out.fill(0.0);
        let each = out.len().checked_div(self.signals.len()).unwrap_or(0);
        for (signal, out) in self.signals.iter().zip(out.chunks_exact_mut(each.max(1))) {
            for part in &signal.parts {
                part.add(self.grid, first, out);
            }
        }
    }
}

impl Part<'_> {
    /// Adds the values at the instants from `first` on.
    fn add(&self, grid: &TimeGrid, first: u64, out: &mut [f64]) {
        // What has begun by then, and for how many steps at the first of it.
        let begun = |out, from: u64| -> (&mut [f64], u64) {
            let out: &mut [f64] = out;
            let wait = from.saturating_sub(first).min(out.len() as u64) as usize;
            (&mut out[wait..], first.saturating_sub(from))
        };
        match *self {
            Part::Constant { force, from } => {
                let (out, _) = begun(out, from);
                out.iter_mut().for_each(|value| *value += force);
            }
            Part::Growing { rate, lead, from } => {
                let (out, since) = begun(out, from);
                for (k, value) in (since..).zip(out) {
                    *value += rate * (k as f64 * grid.step() + lead);
                }
            }
            Part::Sampled {
                values, every: 1, ..
            } => {
                let known = usize::try_from(first).unwrap_or(usize::MAX);
                let known = values.get(known..).unwrap_or_default();
                let (out, after) = out.split_at_mut(known.len().min(out.len()));
                for (value, sample) in out.iter_mut().zip(known) {
                    *value += sample;
                }
                let last = values.last().copied().unwrap_or(0.0);
                after.iter_mut().for_each(|value| *value += last);
            }
            Part::Sampled {
                values,
                every,
                hold,
            } => {
                for (k, value) in (first..).zip(out) {
                    let (j, rest) = (k / every, k % every);
                    let at = |j| sample(values, j);
                    let sample = at(j);
                    *value += match hold {
                        Hold::Zero => sample,
                        Hold::First => sample + (at(j + 1) - sample) / every as f64 * rest as f64,
                    };
                }
            }
            Part::Slope { values, every } => {
                let length = every as f64 * grid.step();
                for (k, value) in (first..).zip(out) {
                    let j = k / every;
                    *value += (sample(values, j + 1) - sample(values, j)) / length;
                }
            }
            Part::Sine(harmonic) => along(harmonic, grid, first, out, f64::sin),
            Part::Cosine(harmonic) => along(harmonic, grid, first, out, f64::cos),
        }
    }
}

/// The last one goes on for ever.
fn sample(values: &[f64], j: u64) -> f64 {
    let last = values.len() - 1;
    values[usize::try_from(j).map_or(last, |j| j.min(last))]
}

/// Adds the amplitude times a function of the phase at each instant.
fn along(
    harmonic: &Harmonic,
    grid: &TimeGrid,
    first: u64,
    out: &mut [f64],
    function: fn(f64) -> f64,
) {
    for (k, value) in (first..).zip(out) {
        let time = Instant::on_grid(grid, k).time();
        let angle = reduced_angle(harmonic.frequency, time, harmonic.phase);
        *value += harmonic.amplitude * function(angle);
    }
}
