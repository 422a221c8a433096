//! The motion at the instants asked for, with a bound of every value's error.

use eigentone_response::{Problem, Trajectory};
use faer::MatRef;

use super::Reference;
use super::ball::Ball;
use super::driven_form::DrivenForm;
use super::error::ReferenceError;
use super::events::grid_time;
use super::march::{March, Moment};
use crate::trajectory_error::{TrajectoryError, relative};

/// The longest numbers that are tried.
const MOST_BITS: u64 = 1 << 14;

/// The exact motion at the instants asked for, each value within a radius that is proven.
#[derive(Clone, Debug)]
pub struct ReferenceResponse {
    steps: Vec<u64>,
    /// Of the grid, in s.
    step: f64,
    moments: Vec<Moment>,
    bits: u64,
}

/// What an instant costs besides the step to it, in multiplications: its values have to be kept.
const INSTANT: f64 = 500.0;

/// What is smaller by so many powers of two than the states could make it is at rest: doubles do
/// not span as much.
const REST: f64 = 2200.0;

impl Reference {
    /// The response to `problem` at the instants it asks for.
    ///
    /// The system is taken to first order, with coordinates without mass eliminated in exact
    /// fractions; loads become states, so that z′ = A z from one event to the next, and z is carried
    /// over each gap by e^(A t), from scaling, the Taylor series and squaring. Events and instants
    /// are exact fractions too. All is done with more bits until every radius is at most 10^−digits
    /// of the largest coordinate at its instant, or 10^−(2·digits) of the
    /// largest until then. What lies beyond the range of doubles below the rest counts as 0.
    ///
    /// # Errors
    /// [`ReferenceError`] where the work is too much, where so many digits cannot be reached, and for
    /// systems without a mass matrix that is regular apart from coordinates without mass.
    pub fn response(&self, problem: &Problem<'_>) -> Result<ReferenceResponse, ReferenceError> {
        let grid = problem.grid();
        let count = match problem.instants() {
            Some(instants) => instants.len() as u64,
            None => grid.last() + 1,
        };
        let states = 2.0 * problem.system().len() as f64;
        self.afford(10.0 * states.powi(3) + count as f64 * (INSTANT + states.powi(2)))?;
        let steps: Vec<u64> = match problem.instants() {
            Some(instants) => instants.to_vec(),
            None => (0..count).collect(),
        };
        let mut sorted = steps.clone();
        sorted.sort_unstable();
        sorted.dedup();
        let times = sorted.iter().map(|index| grid_time(grid, *index)).collect();
        let march = March::new(DrivenForm::of(problem)?, times);
        let mut bits = (f64::from(self.digits) * 3.33) as u64 + 4 * march.doublings() + 64;
        loop {
            bits = bits.next_multiple_of(64);
            self.afford(march.work(bits))?;
            let found = march.run(bits)?.filter(|found| self.reached(found));
            if let Some(found) = found {
                let place = |step| {
                    let place = sorted.binary_search(step);
                    place.expect("it was collected from these")
                };
                let moments = match steps == sorted {
                    true => found,
                    false => steps
                        .iter()
                        .map(|step| found[place(step)].clone())
                        .collect(),
                };
                return Ok(ReferenceResponse {
                    steps,
                    step: grid.step(),
                    moments,
                    bits,
                });
            }
            if bits >= MOST_BITS {
                let digits = self.digits;
                return Err(ReferenceError::TooManyBits { digits, bits });
            }
            bits *= 2;
        }
    }

    fn reached(&self, moments: &[Moment]) -> bool {
        let digits = f64::from(self.digits) * std::f64::consts::LOG2_10;
        let mut most = [f64::NEG_INFINITY; 2];
        moments.iter().all(|moment| {
            let kinds = [&moment.displacement, &moment.velocity];
            kinds.iter().enumerate().all(|(kind, values)| {
                let largest =
                    |of: fn(&Ball) -> f64| values.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
                let here = largest(Ball::log2);
                most[kind] = most[kind].max(here);
                let unit = here.max(most[kind] - digits).max(moment.reach[kind] - REST);
                largest(Ball::radius_log2) <= unit - digits
            })
        })
    }
}

impl ReferenceResponse {
    /// The index on the grid of each instant, in the order asked for.
    pub fn steps(&self) -> &[u64] {
        &self.steps
    }

    /// The `position`-th instant in s, exactly: its index times the grid's step.
    ///
    /// # Panics
    /// If there are not so many instants.
    pub fn time(&self, position: usize) -> Ball {
        let step = Ball::exactly(self.step).unwrap_or_else(|| Ball::unknown(0));
        let index = Ball::from(num_bigint::BigInt::from(self.steps[position]));
        step.with_bits(128) * index
    }

    /// The displacements of all coordinates at the `position`-th instant, in m.
    ///
    /// # Panics
    /// If there are not so many instants.
    pub fn displacement(&self, position: usize) -> &[Ball] {
        &self.moments[position].displacement
    }

    /// The velocities of all coordinates at the `position`-th instant, in m/s.
    ///
    /// # Panics
    /// If there are not so many instants.
    pub fn velocity(&self, position: usize) -> &[Ball] {
        &self.moments[position].velocity
    }

    /// How many bits its numbers had.
    pub fn bits(&self) -> u64 {
        self.bits
    }

    /// How far `trajectory` is off, as [`TrajectoryError::between`] has it, but measured far below
    /// the last place of a double.
    ///
    /// # Errors
    /// [`ReferenceError::OtherProblem`] where coordinates or instants differ.
    pub fn error_of(&self, trajectory: &Trajectory) -> Result<TrajectoryError, ReferenceError> {
        let coordinates = self
            .moments
            .first()
            .map_or(0, |moment| moment.displacement.len());
        let same = trajectory.steps() == self.steps
            && (self.moments.is_empty() || trajectory.displacement().nrows() == coordinates);
        if !same {
            return Err(ReferenceError::OtherProblem);
        }
        let distance = |values: MatRef<'_, f64>, truth: fn(&Moment) -> &[Ball]| {
            let moments = self.moments.iter().enumerate();
            relative(moments.flat_map(|(k, moment)| {
                let each = truth(moment).iter().enumerate();
                each.map(move |(i, truth)| {
                    let off = truth.minus(values[(i, k)]).abs();
                    (off, truth.nearest().abs())
                })
            }))
        };
        Ok(TrajectoryError {
            displacement: distance(trajectory.displacement(), |moment| &moment.displacement),
            velocity: distance(trajectory.velocity(), |moment| &moment.velocity),
        })
    }
}
