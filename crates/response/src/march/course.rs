//! A march over the whole grid towards few outputs.

use eigentone_modes::{Bounds, FirstOrder, Precision};

use super::blocks::{self, Blocks};
use super::estimate::{Estimate, is_stiff};
use super::grid_loads::GridLoads;
use super::modal_basis::Basis;
use super::modal_march::{self, ModalMarch};
use super::strides::{Strides, all_finite, largest};
use crate::answer::{History, Output};
use crate::exponential::second_order;
use crate::hold::exact;
use crate::problem::{Plant, Problem, ResponseError, rest};

/// The question, once it is known that strides can answer it.
pub(crate) struct Course<'a, 'b> {
    problem: &'a Problem<'b>,
    outputs: &'a [Output],
    form: FirstOrder,
    plant: Plant,
    loads: GridLoads<'a>,
    estimate: Estimate,
    /// The state at 0, after any blows.
    start: Vec<f64>,
    /// The displacements where loads that are constant all the time let it rest.
    rest: Option<Vec<f64>>,
}

impl<'a, 'b> Course<'a, 'b> {
    /// `None` where the problem has more than that: chosen instants, events between instants,
    /// massless nodes.
    pub(crate) fn of(problem: &'a Problem<'b>, outputs: &'a [Output]) -> Option<Course<'a, 'b>> {
        if problem.instants().is_some() {
            return None;
        }
        let form = FirstOrder::of(problem.system()).ok()?;
        if form.massive().len() != problem.system().len() {
            return None;
        }
        let loads = GridLoads::of(problem)?;
        let plant = Plant::of(problem, &form);
        let mut start = form.state(problem.initial_displacement(), problem.initial_velocity());
        for (input, momentum) in &loads.blows {
            for (entry, b) in start.iter_mut().zip(plant.b.col(*input).iter()) {
                *entry += b * momentum;
            }
        }
        let constant = loads.constant(problem.system().len());
        let rest = constant.and_then(|force| rest(problem.system(), &force));
        Some(Course {
            problem,
            outputs,
            estimate: Estimate::of(problem.system(), &form),
            form,
            plant,
            loads,
            start,
            rest,
        })
    }

    /// The way to march; `None` where the plan knows a better one.
    pub(crate) fn strides(&self) -> Option<Box<dyn Strides>> {
        let structure = self.problem.system().structure();
        let classical = structure.is_undamped() || structure.is_classical();
        let stiff = is_stiff(&self.estimate, self.problem.grid());
        let (states, outputs) = (self.form.states(), self.outputs.len());
        let (signals, last) = (&self.loads.signals, self.problem.grid().last());
        let in_blocks = blocks::work(states, outputs, signals, last);
        let by_modes = modal_march::work(states, classical, outputs, signals.len(), last);
        let quicker = by_modes < in_blocks;
        // Finding the modes of a large system would take longer than to march.
        let large = is_large(self.problem);
        if quicker || (!large && (classical || stiff)) {
            let basis = Basis::of(self.problem.system(), Precision::Double).ok();
            if let Some(basis) = basis.filter(ModalMarch::is_accurate) {
                return Some(Box::new(self.by_modes(basis)));
            }
        }
        (large || !(classical || stiff)).then(|| Box::new(self.in_blocks()) as Box<dyn Strides>)
    }

    fn by_modes(&self, basis: Basis) -> ModalMarch {
        let h = self.problem.grid().step();
        let b = self.plant.b.as_ref();
        ModalMarch::of(basis, b, &self.loads, h, &self.start, self.outputs)
    }

    fn in_blocks(&self) -> Blocks {
        let grid = self.problem.grid();
        let u = Plant::columns(self.plant.b.as_ref(), &self.loads.loaded);
        let laws = &self.loads.laws;
        let held = exact(second_order, self.form.a(), u.as_ref(), grid.step(), laws);
        let signals = &self.loads.signals;
        let (start, last) = (self.start.clone(), grid.last());
        Blocks::of(&held, signals, self.outputs, start, last)
    }

    /// # Errors
    /// [`ResponseError::TooLarge`], [`ResponseError::Overflow`].
    pub(crate) fn run(mut self, mut strides: Box<dyn Strides>) -> Result<History, ResponseError> {
        let (grid, width) = (*self.problem.grid(), self.outputs.len());
        let (last, n) = (grid.last(), self.problem.system().len());
        let bytes = last as f64 * (width as f64 + 1.0) * 8.0;
        crate::answer::check_size(last + 1, width, bytes)?;
        let (multiple, every) = (strides.multiple(), strides.together());
        let signals = self.loads.signals.len();
        let mut loads = vec![0.0; (every + 1) * signals];
        let mut values = vec![0.0; (last as usize + multiple + 1) * width];
        let (now, mut rest) = values.split_at_mut(width);
        let offset = |output: &Output| match (output, &self.rest) {
            (Output::Displacement(i), Some(rest)) => rest[*i],
            _ => 0.0,
        };
        let offsets: Vec<f64> = self.outputs.iter().map(offset).collect();
        let farthest = largest(self.rest.as_deref().unwrap_or_default());
        let at_rest = self.rest.as_ref().map(|rest| {
            let still = vec![0.0; self.start.len() - rest.len()];
            [rest.as_slice(), &still].concat()
        });
        let mut deviates = false;
        for (value, output) in now.iter_mut().zip(self.outputs) {
            *value = match output {
                Output::Displacement(i) => self.start[*i],
                Output::Velocity(i) => self.start[n + i],
            };
        }
        self.estimate = self.estimate.by_way_of(strides.detour());
        let [x, v] = strides.largest();
        let mut estimates = vec![two(self.estimate.bounds(x + farthest, v))];
        let mut first = 0;
        while first < last {
            let asked = (last - first).min(every as u64);
            // The last ones may go on beyond the end, where nothing is asked.
            let steps = (asked as usize).next_multiple_of(multiple);
            let (known, later) = rest.split_at_mut(steps * width);
            let mut done = 0;
            while done < steps {
                deviates = deviates || at_rest.as_ref().is_some_and(|rest| strides.deviate(rest));
                let left = steps - done;
                let part = match at_rest {
                    // Time after time, so that little of what decays is lost before.
                    Some(_) if !deviates => {
                        let soon = ((first as usize + done) / 8).max(16);
                        soon.next_multiple_of(multiple).min(left)
                    }
                    _ => left,
                };
                let loads = &mut loads[..(part + 1) * signals];
                match deviates {
                    true => loads.fill(0.0),
                    false => self.loads.fill(first + done as u64, loads),
                }
                let values = &mut known[done * width..(done + part) * width];
                strides.advance(loads, values, part);
                if deviates {
                    for values in values.chunks_exact_mut(width.max(1)) {
                        for (value, offset) in values.iter_mut().zip(&offsets) {
                            *value += offset;
                        }
                    }
                }
                done += part;
            }
            first += asked;
            let finite = strides.is_finite() || first == last;
            if !finite || !all_finite(&known[..asked as usize * width]) {
                return Err(ResponseError::Overflow { index: first });
            }
            rest = later;
            self.estimate.steps(asked, grid.step());
            let [x, v] = strides.largest();
            estimates.push(two(self.estimate.bounds(x + farthest, v)));
        }
        values.truncate((last as usize + 1) * width);
        Ok(History {
            outputs: self.outputs.to_vec(),
            grid,
            steps: None,
            values,
            estimates,
            every,
            bounds: Bounds::Estimated,
            operations: strides.operations(),
            method: strides.method(),
        })
    }
}

/// Those of displacements and velocities.
fn two([displacement, velocity, _]: [Option<f64>; 3]) -> [Option<f64>; 2] {
    [displacement, velocity]
}

/// Whether displacements and velocities at all instants would take more than 64 MB.
fn is_large(problem: &Problem<'_>) -> bool {
    const SMALL: f64 = 6.4e7;
    let grid = problem.grid();
    16.0 * problem.system().len() as f64 * (grid.last() as f64 + 1.0) > SMALL
}
