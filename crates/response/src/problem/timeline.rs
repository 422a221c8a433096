//! All loads together, cut into pieces at the instants where one of them changes.

use std::cmp::Ordering;

use eigentone_digits::{DoubleDouble, Magnitude};

use super::applied_load::AppliedLoad;
use super::grid::TimeGrid;
use super::instant::{Instant, SampleGrid};
use super::law::{Law, Run};
use super::load::{Harmonic, Hold, Load, Samples};
use super::straight_loads::StraightLoads;

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
}
