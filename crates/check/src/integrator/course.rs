//! The way through a problem that every integrator takes: from break to break, past the instants
//! asked for.

use eigentone_response::{Instant, Problem, ResponseError, TimeGrid, Trajectory};
use faer::Mat;

use super::equation::{EquationOfMotion, Forces};
use crate::instants;

/// A part of the way without break: one piece of the timeline, up to the last instant asked for.
pub(crate) struct Stretch<'a> {
    pub(crate) forces: Forces<'a>,
    pub(crate) grid: &'a TimeGrid,
    pub(crate) start: Instant,
    pub(crate) end: Instant,
    /// The grid indices asked for within it, ascending and without repeats; one at its end belongs
    /// to the next stretch, if there is one.
    pub(crate) stops: &'a [u64],
}

impl Stretch<'_> {
    /// Where it begins, in s.
    pub(crate) fn start(&self) -> f64 {
        self.forces.start()
    }

    /// Seconds from the start of the stretch.
    pub(crate) fn elapsed(&self, to: &Instant) -> f64 {
        to.elapsed(&self.start, self.grid).to_f64()
    }

    /// Its length in s.
    pub(crate) fn length(&self) -> f64 {
        self.elapsed(&self.end)
    }

    /// The instant of a stop.
    pub(crate) fn stop(&self, index: u64) -> Instant {
        Instant::on_grid(self.grid, index)
    }
}

/// Collects the states at the instants asked for.
pub(crate) struct Recorder {
    /// Grid index and column, by ascending index.
    order: Vec<(u64, usize)>,
    done: usize,
    displacement: Mat<f64>,
    velocity: Mat<f64>,
}

impl Recorder {
    /// Notes the state [x; x′] at a grid index; indices must come in ascending order.
    pub(crate) fn record(&mut self, index: u64, state: &[f64]) -> Result<(), ResponseError> {
        if !state.iter().all(|value| value.is_finite()) {
            return Err(ResponseError::Overflow { index });
        }
        let n = self.displacement.nrows();
        while let Some((_, column)) = self.order.get(self.done).filter(|(next, _)| *next == index) {
            for i in 0..n {
                self.displacement[(i, *column)] = state[i];
                self.velocity[(i, *column)] = state[n + i];
            }
            self.done += 1;
        }
        Ok(())
    }
}

/// The way to the last of `stops`, which are grid indices, ascending and without repeats.
pub(crate) fn stretches<'a>(
    problem: &'a Problem<'_>,
    stops: &'a [u64],
) -> impl Iterator<Item = Stretch<'a>> {
    let (grid, timeline) = (problem.grid(), problem.timeline());
    let finish = stops.last().map(|index| Instant::on_grid(grid, *index));
    let mut ahead = stops;
    (0..timeline.pieces().len()).map_while(move |piece| {
        let start = timeline.pieces()[piece].start_instant();
        let finish = finish.filter(|finish| start.order(finish).is_le())?;
        let next = timeline.pieces().get(piece + 1);
        let next = next.map(|piece| piece.start_instant());
        let before_next = |index: &u64| {
            next.is_none_or(|next| Instant::on_grid(grid, *index).order(&next).is_lt())
        };
        let (here, later) = ahead.split_at(ahead.partition_point(before_next));
        ahead = later;
        let end = next.filter(|next| next.order(&finish).is_lt());
        Some(Stretch {
            forces: Forces { problem, piece },
            grid,
            start,
            end: end.unwrap_or(finish),
            stops: here,
        })
    })
}

/// The last instant asked for, by its grid index, if there is one.
pub(crate) fn last_instant(problem: &Problem<'_>) -> Option<u64> {
    match problem.instants() {
        Some(instants) => instants.iter().copied().max(),
        None => Some(problem.grid().last()),
    }
}

/// Leads an integrator through a problem: `cross` takes the state [x; x′] over one stretch and
/// records it at every stop.
pub(crate) fn follow(
    name: &'static str,
    problem: &Problem<'_>,
    equation: &EquationOfMotion,
    mut cross: impl FnMut(&Stretch<'_>, &mut Vec<f64>, &mut Recorder) -> Result<(), ResponseError>,
) -> Result<Trajectory, ResponseError> {
    let steps = instants::wanted(problem)?;
    let (n, grid) = (equation.len(), problem.grid());
    let mut order: Vec<(u64, usize)> = steps.iter().copied().zip(0..).collect();
    order.sort_unstable();
    let mut stops: Vec<u64> = order.iter().map(|(index, _)| *index).collect();
    stops.dedup();
    let mut recorder = Recorder {
        order,
        done: 0,
        displacement: Mat::zeros(n, steps.len()),
        velocity: Mat::zeros(n, steps.len()),
    };
    let mut acceleration = problem
        .wants_acceleration()
        .then(|| Mat::zeros(n, steps.len()));

    let mut state = problem.initial_displacement().to_vec();
    state.extend_from_slice(problem.initial_velocity());
    for stretch in stretches(problem, &stops) {
        equation.apply_impulses(&mut state, &stretch.forces);
        let from = recorder.done;
        cross(&stretch, &mut state, &mut recorder)?;
        if let Some(acceleration) = &mut acceleration {
            let mut values = vec![0.0; n];
            let mut moving = vec![0.0; 2 * n];
            for (index, column) in &recorder.order[from..recorder.done] {
                for i in 0..n {
                    moving[i] = recorder.displacement[(i, *column)];
                    moving[n + i] = recorder.velocity[(i, *column)];
                }
                let elapsed = stretch.elapsed(&stretch.stop(*index));
                equation.acceleration(&moving, &stretch.forces, elapsed, &mut values);
                for i in 0..n {
                    acceleration[(i, *column)] = values[i];
                }
            }
        }
    }
    let times = steps.iter().map(|index| grid.time(*index)).collect();
    let trajectory = Trajectory::new(name, steps, times, recorder.displacement, recorder.velocity)
        .with_names(problem.system().coordinate_names());
    Ok(match acceleration {
        Some(acceleration) => trajectory.with_acceleration(acceleration),
        None => trajectory,
    })
}
