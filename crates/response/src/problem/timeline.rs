//! All loads together, cut into pieces at the instants where one of them changes.

use std::cmp::Ordering;

use eigentone_digits::{DoubleDouble, Magnitude};

use super::angle::reduced_angle;
use super::applied_load::AppliedLoad;
use super::grid::TimeGrid;
use super::instant::{Instant, SampleGrid};
use super::law::{Law, Run};
use super::load::{HalfSine, Harmonic, Hold, Load, Samples, Versine};
use super::rate::Rate;
use super::straight_loads::StraightLoads;

/// A force on one coordinate, or a signal on one channel, that runs straight through a piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Straight {
    /// Index of the coordinate; beyond them, of the channel.
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
    changes: Vec<Law>,
    straight: Vec<Straight>,
    impulses: Vec<(usize, f64)>,
    /// Those of the pulses that last through it, by their index.
    pulses: Vec<usize>,
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

    /// The impulses at its start: index of the coordinate, or beyond them of the channel, and momentum in N·s.
    pub fn impulses(&self) -> &[(usize, f64)] {
        &self.impulses
    }

    /// Which of the [pulses](Timeline::pulses) last through it.
    pub(crate) fn pulses(&self) -> &[usize] {
        &self.pulses
    }
}

/// A sinusoid that lasts for a time: a half-sine pulse, or what a versine has beside a constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pulse {
    /// Index of the coordinate; beyond them, of the channel.
    pub(crate) coordinate: usize,
    pub(crate) start: Instant,
    end: Instant,
    /// What the sine and what the cosine of the angle since its start are multiplied by; one of them is 0.
    pub(crate) sine: f64,
    pub(crate) cosine: f64,
    pub(crate) rate: Rate,
}

impl Pulse {
    /// Its value and its slope, in units of the rate, at its start and at its end.
    pub(crate) fn ends(&self) -> [[f64; 2]; 2] {
        match self.rate {
            // cos π = −1, cos 2π = 1, and the sines are 0.
            Rate::HalfTurns(1, _) => [[self.cosine, self.sine], [-self.cosine, -self.sine]],
            _ => [[self.cosine, self.sine]; 2],
        }
    }

    /// Whether it begins with this piece, and whether it ends with it.
    pub(crate) fn bounds(&self, piece: &Piece) -> [bool; 2] {
        [self.start, self.end].map(|end| end.order(&piece.start).is_eq())
    }

    /// The angle since its start.
    pub(crate) fn angle(&self, now: &Instant) -> f64 {
        let elapsed = now.time - self.start.time;
        match self.rate {
            Rate::Given(rate) => (elapsed * rate).to_f64(),
            Rate::HalfTurns(count, duration) => {
                let turns = elapsed / DoubleDouble::from(duration);
                (turns * DoubleDouble::TAU * (0.5 * f64::from(count))).to_f64()
            }
        }
    }
}

/// All loads of a problem, in pieces.
#[derive(Clone, Debug, PartialEq)]
pub struct Timeline {
    pieces: Vec<Piece>,
    harmonics: Vec<(usize, Harmonic)>,
    pulses: Vec<Pulse>,
}

impl Timeline {
    /// The pieces; the first begins at 0.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// The sinusoidal forces, which run through all pieces: index of the coordinate, or beyond them of the channel, and
    /// the load.
    pub fn harmonics(&self) -> &[(usize, Harmonic)] {
        &self.harmonics
    }

    /// The sinusoids that last for a time.
    pub(crate) fn pulses(&self) -> &[Pulse] {
        &self.pulses
    }

    /// Calls `push` with every part of the signals at time `t` s, by the law of the given piece and without impulses: the
    /// index of the coordinate, or beyond them of the channel, its value and its first four time derivatives.
    pub(crate) fn signals(&self, piece: usize, t: f64, mut push: impl FnMut(usize, [f64; 5])) {
        let begun = &self.pieces[piece];
        let now = DoubleDouble::from(t);
        for straight in &begun.straight {
            let elapsed = (now - begun.start.time).to_f64();
            let value = straight.value + straight.slope * elapsed;
            push(straight.coordinate, [value, straight.slope, 0.0, 0.0, 0.0]);
        }
        self.waves(piece, now, |on, [sine, cosine], angle, rate| {
            let (s, c) = angle.sin_cos();
            let (value, growth) = (sine * s + cosine * c, sine * c - cosine * s);
            let mut power = 1.0;
            push(
                on,
                [value, growth, -value, -growth, value].map(|part| {
                    let derivative = part * power;
                    power *= rate;
                    derivative
                }),
            );
        });
    }

    /// Calls `visit` with every sinusoid in a piece: the index of the coordinate, or beyond them of the channel, what
    /// sine and cosine are multiplied by, the angle at a time `now` in s, and the rate.
    pub(super) fn waves(
        &self,
        piece: usize,
        now: DoubleDouble,
        mut visit: impl FnMut(usize, [f64; 2], f64, f64),
    ) {
        for (coordinate, harmonic) in &self.harmonics {
            let (parts, rate) = ([harmonic.amplitude, 0.0], harmonic.frequency);
            let angle = reduced_angle(rate, now, harmonic.phase);
            visit(*coordinate, parts, angle, rate);
        }
        let piece = &self.pieces[piece];
        for pulse in piece.pulses.iter().map(|index| &self.pulses[*index]) {
            let (parts, rate) = ([pulse.sine, pulse.cosine], pulse.rate.to_f64());
            let elapsed = now - piece.start.time;
            let angle = reduced_angle(rate, elapsed, pulse.angle(&piece.start));
            visit(pulse.coordinate, parts, angle, rate);
        }
    }

    /// The largest angular frequency of any sinusoid, in rad/s.
    pub fn fastest(&self) -> f64 {
        let harmonics = self.harmonics.iter().map(|(_, one)| one.frequency.abs());
        let pulses = self.pulses.iter().map(|pulse| pulse.rate.to_f64());
        harmonics.chain(pulses).fold(0.0, f64::max)
    }

    /// Cuts checked loads into pieces; what happens after the grid's end is left out.
    pub(crate) fn of(loads: &[AppliedLoad], grid: &TimeGrid) -> Timeline {
        let origin = Instant::on_grid(grid, 0);
        let end = Instant::on_grid(grid, grid.last());
        let mut laws: Vec<Law> = Vec::new();
        let mut impulses = Vec::new();
        let mut harmonics = Vec::new();
        let mut pulses = Vec::new();
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
                // Steps stand for it.
                Load::Polynomial(_) => {}
                Load::Harmonic(harmonic) => harmonics.push((coordinate, *harmonic)),
                Load::Samples(samples) => sample_laws(samples, grid, law),
                Load::HalfSine(HalfSine {
                    force,
                    duration,
                    start,
                }) => {
                    let start = begin(*start).0;
                    pulses.push(Pulse {
                        coordinate,
                        start,
                        end: start.after(*duration),
                        sine: *force,
                        cosine: 0.0,
                        rate: Rate::HalfTurns(1, *duration),
                    });
                }
                Load::Versine(Versine {
                    force,
                    duration,
                    start,
                }) => {
                    let start = begin(*start).0;
                    let (end, half) = (start.after(*duration), force / 2.0);
                    law(start, Run::Constant(half));
                    law(end, Run::Constant(0.0));
                    pulses.push(Pulse {
                        coordinate,
                        start,
                        end,
                        sine: 0.0,
                        cosine: -half,
                        rate: Rate::HalfTurns(2, *duration),
                    });
                }
            }
        }
        pulses.retain(|pulse: &Pulse| pulse.start.order(&end) != Ordering::Greater);
        laws.retain(|law| law.since.order(&end) != Ordering::Greater);
        impulses.retain(|(at, ..)| at.order(&end) != Ordering::Greater);
        laws.sort_by(|a, b| a.since.order(&b.since));

        let mut starts: Vec<Instant> = vec![origin];
        starts.extend(laws.iter().map(|law| law.since));
        starts.extend(impulses.iter().map(|(at, ..)| *at));
        let edges = pulses.iter().flat_map(|pulse| [pulse.start, pulse.end]);
        starts.extend(edges.filter(|edge| edge.order(&end) != Ordering::Greater));
        starts.sort_by(Instant::order);
        starts.dedup_by(|a, b| a.order(b) == Ordering::Equal);

        impulses.sort_by(|a, b| a.0.order(&b.0));
        let mut now = StraightLoads::<DoubleDouble>::of(loads);
        let seconds = |from: &Instant, to: &Instant| (to.elapsed(from, grid), Magnitude::ZERO);
        let mut upcoming = laws.into_iter().peekable();
        let mut impulses = impulses.into_iter().peekable();
        let pieces = starts.into_iter().map(|start| {
            let mut changes = Vec::new();
            while let Some(law) =
                upcoming.next_if(|law| law.since.order(&start) != Ordering::Greater)
            {
                now.set(&law, seconds);
                changes.push(law);
            }
            let here = std::iter::from_fn(|| {
                impulses.next_if(|(at, ..)| at.order(&start) != Ordering::Greater)
            });
            let straight = now.now(|since| seconds(since, &start));
            let straight = straight.map(|(coordinate, straight)| Straight {
                coordinate,
                value: straight.value.0.to_f64(),
                slope: straight.slope.0.to_f64(),
            });
            let lasts = |pulse: &Pulse| {
                pulse.start.order(&start) != Ordering::Greater
                    && pulse.end.order(&start) == Ordering::Greater
            };
            Piece {
                start,
                changes,
                pulses: (0..pulses.len())
                    .filter(|index| lasts(&pulses[*index]))
                    .collect(),
                straight: straight.collect(),
                impulses: here
                    .map(|(_, coordinate, magnitude)| (coordinate, magnitude))
                    .collect(),
            }
        });
        let pieces = pieces.collect();
        Timeline {
            pieces,
            harmonics,
            pulses,
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
    /// sin(Ωt + φ) to 17 digits where Ωt is 3.3e17, and the same from a step on.
    #[test]
    fn the_angle_of_very_many_turns_is_known() {
        let system = eigentone_modes::System::builder().mass("m", 1.0);
        let system = system.build().expect("a system");
        let response = crate::Response::of(&system)
            .load("m", crate::Harmonic::of(1.0, 1e17).with_phase(1e17))
            .load("m", crate::Impulse::of(1.0).at(1.3));
        let problem = response.every(0.5).until(10.0).problem();
        let problem = problem.expect("a problem");
        for piece in [0, 1] {
            let mut force = 0.0;
            let timeline = problem.timeline();
            timeline.signals(piece, 3.3, |_, [value, ..]| force += value);
            let wanted = -0.329_619_931_339_242_55;
            assert!((force - wanted).abs() < 1e-14, "{piece}: {force}");
        }
    }

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
            let mut force = 0.0;
            let timeline = problem.timeline();
            timeline.signals(piece, time, |_, [value, ..]| force += value);
            let wanted = straight + 3.0 * (0.5 * time + 0.25).sin();
            assert!((force - wanted).abs() < 1e-14, "{time}: {force}");
        }
    }
}
