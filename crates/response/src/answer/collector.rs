//! The instants asked for, collected in order of time.

use eigentone_modes::ElementKind;
use faer::Mat;

use super::combined::Combined;
use super::trajectory::Trajectory;
use crate::problem::{Instant, Problem, ResponseError, Source, TimeGrid};

/// The most memory that a trajectory may take, in bytes.
pub(crate) const BUDGET: f64 = 2e9;

/// # Errors
/// [`ResponseError::TooLarge`] for more bytes than that.
pub(crate) fn check_size(
    instants: u64,
    coordinates: usize,
    bytes: f64,
) -> Result<(), ResponseError> {
    if bytes > BUDGET {
        let (gigabytes, limit) = (bytes / 1e9, BUDGET / 1e9);
        return Err(ResponseError::TooLarge {
            instants,
            coordinates,
            gigabytes,
            limit,
        });
    }
    Ok(())
}

/// Keeps the instants asked for, each once and by time, and hands them back in the order in which
/// they were asked for.
pub(crate) struct Collector<'a, 'b> {
    problem: &'a Problem<'b>,
    wanted: Wanted<'a>,
    /// What was asked for, distinct and ascending; empty for the whole grid.
    ascending: Vec<Instant>,
    count: usize,
    taken: usize,
    /// Displacement, velocity and, where asked for, acceleration: one column for each instant.
    pub(crate) values: [Mat<f64>; 3],
    bounds: [Vec<Option<f64>>; 3],
    /// One for each combination, then for each element.
    combined: Vec<Combined>,
}

/// Which instants are asked for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Wanted<'a> {
    Grid,
    Steps(&'a [u64]),
    /// In s.
    Times(&'a [f64]),
}

impl<'a> Wanted<'a> {
    /// What the problem itself asks for.
    pub(crate) fn by(problem: &'a Problem<'_>) -> Wanted<'a> {
        problem.instants().map_or(Wanted::Grid, Wanted::Steps)
    }

    /// How many.
    pub(crate) fn count(&self, grid: &TimeGrid) -> u64 {
        match self {
            Wanted::Grid => grid.last() + 1,
            Wanted::Steps(steps) => steps.len() as u64,
            Wanted::Times(times) => times.len() as u64,
        }
    }

    /// In the order asked for; nothing for the whole grid.
    fn instants(&self, grid: &TimeGrid) -> Vec<Instant> {
        match self {
            Wanted::Grid => Vec::new(),
            Wanted::Steps(steps) => steps
                .iter()
                .map(|index| Instant::on_grid(grid, *index))
                .collect(),
            Wanted::Times(times) => times.iter().map(|t| Instant::event(grid, *t)).collect(),
        }
    }
}

impl<'a, 'b> Collector<'a, 'b> {
    /// # Errors
    /// [`ResponseError::TooLarge`].
    pub(crate) fn new(
        problem: &'a Problem<'b>,
        wanted: Wanted<'a>,
    ) -> Result<Collector<'a, 'b>, ResponseError> {
        let n = problem.system().len();
        let instants = wanted.count(problem.grid());
        let kinds = 2 + usize::from(problem.wants_acceleration());
        let combined = 3 * problem.sources().len();
        let bytes = instants as f64 * (kinds * n + combined + 8) as f64 * 8.0;
        check_size(instants, n, bytes)?;
        let mut ascending = wanted.instants(problem.grid());
        ascending.sort_by(Instant::order);
        ascending.dedup_by(|a, b| a.order(b).is_eq());
        let count = match wanted {
            Wanted::Grid => instants as usize,
            _ => ascending.len(),
        };
        let columns = |wanted: bool| Mat::zeros(n, if wanted { count } else { 0 });
        Ok(Collector {
            problem,
            wanted,
            ascending,
            count,
            taken: 0,
            values: [
                columns(true),
                columns(true),
                columns(problem.wants_acceleration()),
            ],
            bounds: [0, 1, 2].map(|_| Vec::with_capacity(count)),
            combined: vec![Combined::default(); problem.sources().len()],
        })
    }

    /// The next instant to be recorded.
    pub(crate) fn next(&self) -> Option<Instant> {
        self.after(0)
    }

    /// The one to be recorded after so many others.
    pub(crate) fn after(&self, others: usize) -> Option<Instant> {
        let at = self.taken + others;
        if at >= self.count {
            return None;
        }
        Some(match self.wanted {
            Wanted::Grid => Instant::on_grid(self.problem.grid(), at as u64),
            _ => self.ascending[at],
        })
    }

    /// The column of the next instant.
    pub(crate) fn column(&self) -> usize {
        self.taken
    }

    /// Whether any acceleration is asked for.
    pub(crate) fn accelerates(&self) -> bool {
        let mut sources = self.problem.sources().iter();
        self.problem.wants_acceleration() || sources.any(Source::accelerates)
    }

    /// Fills the column: displacements, velocities and, where asked for, accelerations of coordinates and then of
    /// supports, with a bound for all of a kind.
    pub(crate) fn close(&mut self, motion: &[Vec<f64>; 3], bounds: [Option<f64>; 3]) {
        for (values, motion) in self.values.iter_mut().zip(motion) {
            if values.ncols() > 0 {
                let column = values.col_mut(self.taken);
                column
                    .iter_mut()
                    .zip(motion)
                    .for_each(|(to, from)| *to = *from);
            }
        }
        for (source, combined) in self.problem.sources().iter().zip(&mut self.combined) {
            let (mut sum, mut size, mut bound) = (0.0, 0.0f64, Some(0.0f64));
            for ((terms, motion), error) in source.terms.iter().zip(motion).zip(bounds) {
                for (i, [a, b]) in terms {
                    let part = a * b * motion[*i];
                    sum += part;
                    size += part.abs();
                    let error = error.map(|error| (a * b).abs() * error);
                    bound = bound.zip(error).map(|(sum, error)| sum + error);
                }
            }
            let rounding = 4.0 * f64::EPSILON * size;
            combined.push(sum, bound.map(|bound| bound + rounding));
        }
        self.advance(bounds);
    }

    /// The value of a combination at this instant, and its bound.
    pub(crate) fn combine(&mut self, index: usize, value: f64, bound: f64) {
        self.combined[index].push(value, Some(bound));
    }

    /// On to the next instant: bounds of the displacements, velocities and accelerations of this one.
    pub(crate) fn advance(&mut self, bounds: [Option<f64>; 3]) {
        let all = self.bounds.iter_mut().zip(bounds);
        all.for_each(|(kept, bound)| kept.push(bound));
        self.taken += 1;
    }

    pub(crate) fn finish(self, method: &'static str) -> Trajectory {
        let grid = self.problem.grid();
        let asked = self.wanted.instants(grid);
        let [x, v, a] = self.values;
        let [x_bound, v_bound, a_bound] = self.bounds;
        let (steps, times): (Vec<u64>, Vec<f64>) = match self.wanted {
            Wanted::Grid => (0..=grid.last())
                .map(|step| (step, grid.time(step)))
                .unzip(),
            Wanted::Steps(steps) => steps.iter().map(|step| (*step, grid.time(*step))).unzip(),
            Wanted::Times(times) => (Vec::new(), times.to_vec()),
        };
        let mut combined = self.combined;
        let (x, v, a, x_bound, v_bound, a_bound) = if let Wanted::Grid = self.wanted {
            (x, v, a, x_bound, v_bound, a_bound)
        } else {
            let place = |instant: &Instant| {
                self.ascending
                    .binary_search_by(|known| known.order(instant))
                    .expect("it is one of those asked for")
            };
            let pick: Vec<usize> = asked.iter().map(place).collect();
            let columns = |m: Mat<f64>| match m.ncols() {
                0 => m,
                _ => Mat::from_fn(m.nrows(), pick.len(), |i, j| m[(i, pick[j])]),
            };
            for one in &mut combined {
                *one = one.picked(&pick);
            }
            let bounds = |b: Vec<Option<f64>>| pick.iter().map(|j| b[*j]).collect();
            (
                columns(x),
                columns(v),
                columns(a),
                bounds(x_bound),
                bounds(v_bound),
                bounds(a_bound),
            )
        };
        let asked = self.problem.combinations();
        let forces = combined.split_off(asked.len());
        let names = asked.iter().map(|combination| combination.name.clone());
        let trajectory = Trajectory::new(method, steps, times, x, v)
            .with_names(self.problem.system().coordinate_names())
            .with_bounds(x_bound, v_bound)
            .with_combined(names.zip(combined).collect());
        let trajectory = match self.problem.wants_forces() {
            true => {
                let springs = self.problem.system().elements(ElementKind::Spring);
                let forces = forces.into_iter().map(|force| (force.values, force.bounds));
                trajectory.with_forces(springs.len(), forces)
            }
            false => trajectory,
        };
        if self.problem.wants_acceleration() {
            trajectory
                .with_acceleration(a)
                .with_acceleration_bound(a_bound)
        } else {
            trajectory
        }
    }
}
