//! Few outputs of a response, and nothing else of it.

use eigentone_modes::Bounds;
use faer::MatRef;

use super::operations::Operations;
use super::output::Output;
use crate::problem::TimeGrid;

/// The time histories of chosen outputs at the instants asked for: a response of which nothing else is
/// stored.
///
/// In doubles, where every load changes at instants of the grid alone, every coordinate has mass, and all
/// instants of the grid are asked for, nothing else is even formed. There are two ways then. Mode by mode
/// ("modal recurrence") a step costs O(N) for N states, and as much for each output: so it is for classical
/// damping, for stiff systems, and where it is quicker, if going to modes and back does not enlarge rounding
/// errors beyond what the bounds allow for. Otherwise several steps are one product of a matrix and a vector, which gives
/// their outputs and the state after them ("exponential"). Where neither fits, and where bounds are to be
/// proven, the whole motion is computed, and the outputs are picked.
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
    pub(crate) outputs: Vec<Output>,
    pub(crate) grid: TimeGrid,
    pub(crate) steps: Option<Vec<u64>>,
    /// Instant by instant.
    pub(crate) values: Vec<f64>,
    /// Of displacements and of velocities, for so many instants each.
    pub(crate) estimates: Vec<[Option<f64>; 2]>,
    pub(crate) every: usize,
    pub(crate) bounds: Bounds,
    pub(crate) operations: Operations,
    pub(crate) method: &'static str,
}

impl History {
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
