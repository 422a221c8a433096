//! The instants asked for, gathered in the order in which time meets them.

use faer::Mat;

use crate::problem::{Problem, ResponseError};
use crate::trajectory::Trajectory;

/// The most memory that a trajectory may take, in bytes.
const BUDGET: f64 = 2e9;

/// Keeps the instants asked for, each once and by time, and hands them back in the order in which
/// they were asked for.
pub(crate) struct Collector<'a, 'b> {
    problem: &'a Problem<'b>,
    /// Distinct indices in ascending order, or `None` for the whole grid.
    wanted: Option<Vec<u64>>,
    count: usize,
    taken: usize,
    /// Displacement, velocity and, where asked for, acceleration: one column for each instant.
    pub(crate) values: [Mat<f64>; 3],
    bounds: [Vec<Option<f64>>; 2],
}

impl<'a, 'b> Collector<'a, 'b> {
    /// # Errors
    /// [`ResponseError::TooLarge`].
    pub(crate) fn new(problem: &'a Problem<'b>) -> Result<Collector<'a, 'b>, ResponseError> {
        let n = problem.system().len();
        let wanted = problem.instants().map(|instants| {
            let mut wanted = instants.to_vec();
            wanted.sort_unstable();
            wanted.dedup();
            wanted
        });
        let instants = match &wanted {
            Some(wanted) => wanted.len() as u64,
            None => problem.grid().last() + 1,
        };
        let kinds = 2 + usize::from(problem.wants_acceleration());
        let bytes = instants as f64 * (kinds * n + 6) as f64 * 8.0;
        if bytes > BUDGET {
            let (gigabytes, limit) = (bytes / 1e9, BUDGET / 1e9);
            return Err(ResponseError::TooLarge {
                instants,
                coordinates: n,
                gigabytes,
                limit,
            });
        }
        let count = instants as usize;
        let columns = |wanted: bool| Mat::zeros(n, if wanted { count } else { 0 });
        Ok(Collector {
            problem,
            wanted,
            count,
            taken: 0,
            values: [
                columns(true),
                columns(true),
                columns(problem.wants_acceleration()),
            ],
            bounds: [Vec::with_capacity(count), Vec::with_capacity(count)],
        })
    }

    /// The index of the next instant to be recorded.
    pub(crate) fn next(&self) -> Option<u64> {
        if self.taken == self.count {
            return None;
        }
        Some(match &self.wanted {
            Some(wanted) => wanted[self.taken],
            None => self.taken as u64,
        })
    }

    /// The column of the next instant.
    pub(crate) fn column(&self) -> usize {
        self.taken
    }

    /// The column is filled: bounds of its displacements and velocities.
    pub(crate) fn close(&mut self, displacement: Option<f64>, velocity: Option<f64>) {
        self.bounds[0].push(displacement);
        self.bounds[1].push(velocity);
        self.taken += 1;
    }

    pub(crate) fn finish(self, method: &'static str) -> Trajectory {
        let grid = self.problem.grid();
        let [x, v, a] = self.values;
        let [x_bound, v_bound] = self.bounds;
        let with_acceleration = self.problem.wants_acceleration();
        let times = |steps: &[u64]| steps.iter().map(|step| grid.time(*step)).collect();
        let (Some(wanted), Some(asked)) = (&self.wanted, self.problem.instants()) else {
            let steps: Vec<u64> = (0..=grid.last()).collect();
            let trajectory = Trajectory::new(method, steps.clone(), times(&steps), x, v)
                .with_bounds(x_bound, v_bound);
            return if with_acceleration {
                trajectory.with_acceleration(a)
            } else {
                trajectory
            };
        };
        let place = |step: &u64| {
            wanted
                .binary_search(step)
                .expect("wanted holds what was asked")
        };
        let pick: Vec<usize> = asked.iter().map(place).collect();
        let columns = |m: &Mat<f64>| Mat::from_fn(m.nrows(), pick.len(), |i, j| m[(i, pick[j])]);
        let bounds = |b: &[Option<f64>]| pick.iter().map(|j| b[*j]).collect();
        let trajectory = Trajectory::new(
            method,
            asked.to_vec(),
            times(asked),
            columns(&x),
            columns(&v),
        )
        .with_bounds(bounds(&x_bound), bounds(&v_bound));
        if with_acceleration {
            trajectory.with_acceleration(columns(&a))
        } else {
            trajectory
        }
    }
}
