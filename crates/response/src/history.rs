//! Few outputs of a response, and nothing else of it.

use eigentone_modes::{Bounds, FirstOrder, Precision};
use faer::MatRef;

use crate::blocks::Blocks;
use crate::by_exponential::ByExponential;
use crate::certified::{self, ByCertifiedExponential};
use crate::estimate::Estimate;
use crate::exponential::SecondOrder;
use crate::grid::TimeGrid;
use crate::grid_loads::GridLoads;
use crate::hold::exact;
use crate::method::ResponseMethod;
use crate::operations::Operations;
use crate::plan::ResponsePlan;
use crate::problem::{Problem, ResponseError};
use crate::trajectory::Trajectory;

/// A quantity to follow along a response.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// The displacement of the coordinate of this index, in m.
    Displacement(usize),
    /// The velocity of the coordinate of this index, in m/s.
    Velocity(usize),
}

impl Output {
    fn coordinate(self) -> usize {
        match self {
            Output::Displacement(coordinate) | Output::Velocity(coordinate) => coordinate,
        }
    }
}

/// The time histories of chosen outputs at the instants asked for: a response of which nothing else is
/// stored.
///
/// Where the plan picks the exponential in doubles, every load changes at instants of the grid
/// alone, every coordinate has mass, and all instants of the grid are asked for, the states in between
/// are not even formed: several steps are one product of a matrix and a vector, which gives their
/// outputs and the state after them. So it is too, instead of superposition, where the whole motion
/// would take more than 64 MB. Otherwise the whole motion is computed, and the outputs are picked.
///
/// ```
/// use eigentone_modes::{GROUND, Precision, System};
/// use eigentone_response::{Output, Response, State};
///
/// let system = System::builder()
///     .mass("a", 1.0)
///     .mass("b", 1.0)
///     .spring(GROUND, "a", 1.0)
///     .spring("a", "b", 1.0)
///     .damper("a", "b", 0.1)
///     .build()?;
/// let history = Response::of(&system)
///     .from(State::at_rest().displace("b", 1.0))
///     .every(0.1)
///     .until(100.0)
///     .to(Precision::Double)
///     .follow(&[Output::Displacement(1)])?;
/// assert_eq!(history.values().shape(), (1, 1001));
/// assert_eq!(history.values()[(0, 0)], 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct History {
    outputs: Vec<Output>,
    grid: TimeGrid,
    steps: Option<Vec<u64>>,
    /// Instant by instant.
    values: Vec<f64>,
    /// Of displacements and of velocities, for so many instants each.
    estimates: Vec<[Option<f64>; 2]>,
    every: usize,
    bounds: Bounds,
    operations: Operations,
    method: &'static str,
}

impl History {
    /// The outputs of the problem's answer.
    ///
    /// # Errors
    /// [`ResponseError::NoCoordinate`] for an index that the system does not have, and what the method
    /// reports.
    pub fn of(problem: &Problem<'_>, outputs: &[Output]) -> Result<History, ResponseError> {
        let coordinates = problem.system().len();
        let mut indices = outputs.iter().map(|output| output.coordinate());
        if let Some(index) = indices.find(|index| *index >= coordinates) {
            return Err(ResponseError::NoCoordinate { index, coordinates });
        }
        let course = || Course::of(problem, outputs);
        let proven = matches!(problem.precision(), Precision::Certified { .. })
            && coordinates <= certified::LARGEST
            && ByCertifiedExponential.refuses(problem).is_none();
        // The plan would look for the modes of a large system, which takes longer than to march.
        if !proven
            && is_large(problem)
            && let Some(course) = course()
        {
            return course.run();
        }
        let plan = ResponsePlan::of(problem)?;
        if plan.method.name() == ByExponential.name()
            && let Some(course) = course()
        {
            return course.run();
        }
        let trajectory = plan.run(problem)?;
        Ok(History::picked(problem, outputs, &trajectory))
    }

    fn picked(problem: &Problem<'_>, outputs: &[Output], trajectory: &Trajectory) -> History {
        let (x, v) = (trajectory.displacement(), trajectory.velocity());
        let instants = 0..trajectory.len();
        let values = instants.flat_map(|j| {
            outputs.iter().map(move |output| match output {
                Output::Displacement(i) => x[(*i, j)],
                Output::Velocity(i) => v[(*i, j)],
            })
        });
        let bounds = trajectory.displacement_bound().iter();
        let bounds = bounds.zip(trajectory.velocity_bound());
        History {
            outputs: outputs.to_vec(),
            grid: *problem.grid(),
            steps: problem.instants().map(<[u64]>::to_vec),
            values: values.collect(),
            estimates: bounds.map(|(x, v)| [*x, *v]).collect(),
            every: 1,
            bounds: trajectory.bounds(),
            operations: trajectory.operations(),
            method: trajectory.method(),
        }
    }

    /// What was followed: one row each of [`values`](Self::values).
    pub fn outputs(&self) -> &[Output] {
        &self.outputs
    }

    /// How many instants it has.
    #[allow(clippy::len_without_is_empty)] // there is always the instant asked for
    pub fn len(&self) -> usize {
        match &self.steps {
            Some(steps) => steps.len(),
            None => self.grid.last() as usize + 1,
        }
    }

    /// The step index of the j-th instant.
    pub fn step(&self, j: usize) -> u64 {
        match &self.steps {
            Some(steps) => steps[j],
            None => j as u64,
        }
    }

    /// The j-th instant in s.
    pub fn time(&self, j: usize) -> f64 {
        self.grid.time(self.step(j))
    }

    /// The outputs: row i is the i-th one, column j the j-th instant.
    pub fn values(&self) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(&self.values, self.outputs.len(), self.len())
    }

    /// How far the i-th output may be off at the j-th instant, proven or a first-order estimate, as
    /// [`bounds`](Self::bounds) says; `None` where none can be given. Where states were not formed
    /// at every instant, it holds at all instants since the state before.
    pub fn bound(&self, i: usize, j: usize) -> Option<f64> {
        let [displacement, velocity] = self.estimates[j.div_ceil(self.every)];
        match self.outputs[i] {
            Output::Displacement(_) => displacement,
            Output::Velocity(_) => velocity,
        }
    }

    /// What the bounds are worth.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// What it took.
    pub fn operations(&self) -> Operations {
        self.operations
    }

    /// The name of the method that computed it.
    pub fn method(&self) -> &'static str {
        self.method
    }
}

/// Whether displacements and velocities at all instants would take more than 64 MB.
fn is_large(problem: &Problem<'_>) -> bool {
    const SMALL: f64 = 6.4e7;
    let grid = problem.grid();
    16.0 * problem.system().len() as f64 * (grid.last() as f64 + 1.0) > SMALL
}

/// A march over the whole grid in blocks of steps.
struct Course<'a, 'b> {
    problem: &'a Problem<'b>,
    outputs: &'a [Output],
    form: FirstOrder,
    loads: GridLoads<'a>,
}

impl<'a, 'b> Course<'a, 'b> {
    /// `None` where the problem has more than that: chosen instants, events between instants,
    /// massless nodes.
    fn of(problem: &'a Problem<'b>, outputs: &'a [Output]) -> Option<Course<'a, 'b>> {
        let form = FirstOrder::of(problem.system()).ok()?;
        let all_massive = form.massive().len() == problem.system().len();
        if problem.instants().is_some() || !all_massive {
            return None;
        }
        Some(Course {
            problem,
            outputs,
            form,
            loads: GridLoads::of(problem)?,
        })
    }

    fn run(&self) -> Result<History, ResponseError> {
        let (problem, outputs) = (self.problem, self.outputs);
        let (grid, n) = (problem.grid(), problem.system().len());
        let (last, h) = (grid.last(), grid.step());
        let size = |count: f64| count * (outputs.len() as f64 + 1.0) * 8.0;
        crate::collector::check_size(last + 1, outputs.len(), size(last as f64))?;
        let mut z = self
            .form
            .state(problem.initial_displacement(), problem.initial_velocity());
        for (coordinate, momentum) in &self.loads.blows {
            for (entry, b) in z.iter_mut().zip(self.form.b().col(*coordinate).iter()) {
                *entry += b * momentum;
            }
        }
        let selected: Vec<usize> = outputs
            .iter()
            .map(|output| match output {
                Output::Displacement(i) => *i,
                Output::Velocity(i) => n + i,
            })
            .collect();
        let b = self.form.b();
        let loaded = &self.loads.loaded;
        let u = faer::Mat::from_fn(b.nrows(), loaded.len(), |i, j| b[(i, loaded[j])]);
        let held = exact(&SecondOrder, self.form.a(), u.as_ref(), h, &self.loads.laws);
        let blocks = Blocks::of(&held, &selected, last);
        let mut estimate = Estimate::of(problem.system(), &self.form);
        let mut tops: Vec<f64> = z.iter().map(|entry| entry.abs()).collect();
        // So many blocks are taken together that their loads stay in a nearby cache.
        let together = (TOGETHER / (blocks.width() + blocks.steps)).max(1);
        let every = together * blocks.steps;
        let mut loads = vec![0.0; together * blocks.width()];
        let mut values = Vec::with_capacity((last as usize + every + 1) * outputs.len());
        values.extend(selected.iter().map(|i| z[*i]));
        let mut met = [0.0; 2];
        let mut estimates = vec![bounds(&mut estimate, &tops, met)];
        let mut first = 0;
        while first < last {
            let left = last - first;
            let count = together.min(left.div_ceil(blocks.steps as u64) as usize);
            let loads = &mut loads[..count * blocks.width()];
            self.loads.fill(first, loads);
            let known = values.len();
            blocks.advance(count, loads, &mut z, &mut values, &mut tops);
            meet(&mut met, outputs, &values[known..]);
            let steps = left.min((count * blocks.steps) as u64);
            estimate.steps(steps, h);
            first += steps;
            if z.iter().any(|entry| !entry.is_finite()) && first < last {
                return Err(ResponseError::Overflow { index: first });
            }
            estimates.push(bounds(&mut estimate, &tops, met));
        }
        // The last block may go on beyond the end, where nothing is asked.
        values.truncate((last as usize + 1) * outputs.len());
        if values.iter().any(|value| !value.is_finite()) {
            return Err(ResponseError::Overflow { index: last });
        }
        let operations = Operations {
            exponentials: 1,
            products: held.products + blocks.products,
            steps: last.div_ceil(blocks.steps as u64),
        };
        Ok(History {
            outputs: outputs.to_vec(),
            grid: *grid,
            steps: None,
            values,
            estimates,
            every,
            bounds: Bounds::Estimated,
            operations,
            method: ByExponential.name(),
        })
    }
}

/// Loads and outputs of so many instants are taken together.
const TOGETHER: usize = 1024;

/// Of displacements and velocities, from the largest of each coordinate at the ends of blocks and the
/// largest outputs of both kinds; other coordinates are taken to be up to twice as large within blocks.
fn bounds(estimate: &mut Estimate, tops: &[f64], met: [f64; 2]) -> [Option<f64>; 2] {
    const WITHIN: f64 = 2.0;
    let (x, v) = tops.split_at(tops.len() / 2);
    let top = |values: &[f64]| WITHIN * values.iter().copied().fold(0.0, f64::max);
    let (displacement, velocity) = estimate.bounds(top(x).max(met[0]), top(v).max(met[1]));
    [displacement, velocity]
}

/// Raises the largest displacement and velocity to those of these values, instant by instant.
fn meet(met: &mut [f64; 2], outputs: &[Output], values: &[f64]) {
    for values in values.chunks_exact(outputs.len().max(1)) {
        for (output, value) in outputs.iter().zip(values) {
            let kind = usize::from(matches!(output, Output::Velocity(_)));
            met[kind] = met[kind].max(value.abs());
        }
    }
}
