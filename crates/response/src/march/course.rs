//! A march over the whole grid towards few outputs.

use std::sync::Arc;

use eigentone_modes::{Bounds, FirstOrder, Precision};

use super::blocks::{self, Blocks};
use super::estimate::{Estimate, is_stiff};
use super::flow::Outputs;
use super::grid_loads::GridLoads;
use super::modal_basis::Basis;
use super::modal_march::{self, ModalMarch};
use super::strides::{BY_EXPONENTIAL, BY_SUPERPOSITION, Strides, all_finite, largest};
use crate::answer::{Collector, History, Output, Trajectory, Wanted};
use crate::exponential::second_order;
use crate::hold::{Inputs, exact};
use crate::problem::{Plant, Problem, ResponseError, Source, rest};

/// The question, once it is known that strides can answer it.
pub(crate) struct Course<'a, 'b> {
    problem: &'a Problem<'b>,
    outputs: &'a [Output],
    form: FirstOrder,
    plant: Plant,
    loads: GridLoads<'a>,
    estimate: Estimate,
    /// The state at 0, after any impulses.
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
        let plant = Plant::of(problem, &form).evened();
        let mut start = form.state(problem.initial_displacement(), problem.initial_velocity());
        start.resize(start.len() + plant.integrals, 0.0);
        for (input, momentum) in &loads.impulses {
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
        if self.plant.integrals > 0 {
            // They are no modes.
            return Some(Box::new(self.in_blocks()));
        }
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
                return Some(Box::new(self.by_modes(Arc::new(basis))));
            }
        }
        (large || !(classical || stiff)).then(|| Box::new(self.in_blocks()) as Box<dyn Strides>)
    }

    fn by_modes(&self, basis: Arc<Basis>) -> ModalMarch {
        let h = self.problem.grid().step();
        let plant = &self.plant;
        ModalMarch::of(basis, plant, &self.loads, h, &self.start, self.outputs)
    }

    fn in_blocks(&self) -> Blocks {
        let grid = self.problem.grid();
        let u = Plant::columns(self.plant.b.as_ref(), &self.loads.loaded);
        let laws = &self.loads.laws;
        let a = self.plant.a.as_ref();
        let held = exact(second_order, a, u.as_ref(), grid.step(), laws);
        let signals = &self.loads.signals;
        let (start, last) = (self.start.clone(), grid.last());
        let coordinates = self.problem.system().len();
        Blocks::of(&held, signals, self.outputs, start, coordinates, last)
    }

    /// # Errors
    /// [`ResponseError::TooLarge`], [`ResponseError::Overflow`].
    pub(crate) fn run(mut self, mut strides: Box<dyn Strides>) -> Result<History, ResponseError> {
        let (grid, width) = (*self.problem.grid(), self.outputs.len());
        let bytes = grid.last() as f64 * (width as f64 + 1.0) * 8.0;
        crate::answer::check_size(grid.last() + 1, width, bytes)?;
        let mut values = Vec::with_capacity((grid.last() as usize + 1) * width);
        let mut estimates = Vec::new();
        self.walk(&mut *strides, |reached| {
            values.extend_from_slice(reached.values);
            let [displacement, velocity, _] = reached.bounds;
            estimates.push([displacement, velocity]);
        })?;
        Ok(History {
            outputs: self.outputs.to_vec(),
            grid,
            steps: None,
            values,
            estimates,
            every: strides.together(),
            bounds: Bounds::Estimated,
            operations: strides.operations(),
            method: strides.method(),
        })
    }

    /// Goes through all instants of the grid: the first by itself, then so many at a time as are best taken together.
    fn walk(
        &mut self,
        strides: &mut dyn Strides,
        mut take: impl FnMut(Reached<'_>),
    ) -> Result<(), ResponseError> {
        let (grid, width) = (*self.problem.grid(), self.outputs.len());
        let (last, n) = (grid.last(), self.problem.system().len());
        let (multiple, every) = (strides.multiple(), strides.together());
        let signals = self.loads.signals.len();
        let mut loads = vec![0.0; (every + 1) * signals];
        let mut values = vec![0.0; (every + multiple) * width];
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
        let now = self.outputs.iter().map(|output| match output {
            Output::Displacement(i) => self.start[*i],
            Output::Velocity(i) => self.start[n + i],
        });
        self.estimate.detour = strides.detour();
        let at_once = Outputs::of(&self.plant, None);
        for (frequency, sizes) in Inputs::of(self.problem).amplitudes() {
            self.estimate.swing(at_once.at_once(&sizes), frequency);
        }
        if let Some(sizes) = self.loads.cancelled(self.plant.b.ncols()) {
            let at_once = at_once.at_once(&sizes);
            self.estimate.cancel(at_once, grid.step());
        }
        let mut before = strides.largest();
        let [x, v] = before;
        self.loads.fill(0, &mut loads[..signals]);
        take(Reached {
            values: &now.collect::<Vec<f64>>(),
            loads: &loads[..signals],
            bounds: self.estimate.bounds([x + farthest, v, 0.0]),
        });
        let mut first = 0;
        while first < last {
            let asked = (last - first).min(every as u64);
            // The last ones may go on beyond the end, where nothing is asked.
            let steps = (asked as usize).next_multiple_of(multiple);
            let mut done = 0;
            let mut kept = 0;
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
                kept = (part + 1) * signals;
                match deviates {
                    true => loads[..kept].fill(0.0),
                    false => self.loads.fill(first + done as u64, &mut loads[..kept]),
                }
                let values = &mut values[done * width..(done + part) * width];
                strides.advance(&loads[..kept], values, part);
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
            let reached = &values[..asked as usize * width];
            let finite = strides.is_finite() || first == last;
            if !finite || !all_finite(reached) {
                return Err(ResponseError::Overflow { index: first });
            }
            self.estimate.steps(asked, grid.step());
            // What was rounded on the way may be larger than what is left at the end.
            let after = strides.largest();
            let mut tops = [0, 1].map(|kind| f64::max(before[kind], after[kind]));
            for values in reached.chunks_exact(width.max(1)) {
                for (value, output) in values.iter().zip(self.outputs) {
                    let kind = usize::from(matches!(output, Output::Velocity(_)));
                    tops[kind] = tops[kind].max(value.abs());
                }
            }
            let [x, v] = tops;
            before = after;
            take(Reached {
                values: reached,
                loads: &loads[..kept],
                bounds: self.estimate.bounds([x + farthest, v, 0.0]),
            });
        }
        Ok(())
    }

    /// The signals that make displacement and velocity of each support, as far as any combination asks for them; `None` where
    /// they are no signals by themselves.
    fn supports(&self) -> Option<Vec<[Vec<usize>; 2]>> {
        let n = self.problem.system().len();
        let sources = self.problem.sources().iter();
        let terms = sources.flat_map(|source| source.terms.iter().enumerate());
        let terms = terms.flat_map(|(order, terms)| terms.iter().map(move |(i, _)| (order, *i)));
        let asked: Vec<(usize, usize)> = terms
            .filter_map(|(order, i)| Some((order, i.checked_sub(n)?)))
            .collect();
        let count = self.problem.system().supports().len();
        let mut supports = vec![[Vec::new(), Vec::new()]; count];
        for (at, channel) in self.problem.channels().iter().enumerate() {
            let Some(support) = channel.support else {
                continue;
            };
            for order in (0..3).filter(|order| asked.contains(&(*order, support))) {
                let own = channel.integrals == 0 && channel.orders().any(|one| one == order);
                let signals = self.loads.of_input(n + 3 * at + order);
                supports[support]
                    .get_mut(order)
                    .filter(|_| own)?
                    .extend(signals);
            }
        }
        Some(supports)
    }
}

/// Some instants of the way.
struct Reached<'a> {
    /// The outputs, instant after instant.
    values: &'a [f64],
    /// Signal after signal as many values each, of which the last are those at the instants.
    loads: &'a [f64],
    bounds: [Option<f64>; 3],
}

/// The whole motion, by a basis of modes or by exponentials, where it takes many steps of few states on the grid and no
/// accelerations; `None` elsewhere.
pub(crate) fn whole(
    problem: &Problem<'_>,
    basis: Option<&Arc<Basis>>,
) -> Option<Result<Trajectory, ResponseError>> {
    /// Below, it does not pay.
    const MANY_STEPS: u64 = 1_000;
    /// Above, several steps at a time are products of matrices.
    const FEW_STATES: usize = 48;
    let n = problem.system().len();
    let mut sources = problem.sources().iter();
    let accelerates = problem.wants_acceleration() || sources.any(Source::accelerates);
    if accelerates || problem.grid().last() < MANY_STEPS || 2 * n >= FEW_STATES {
        return None;
    }
    let displacements = (0..n).map(Output::Displacement);
    let outputs: Vec<Output> = displacements.chain((0..n).map(Output::Velocity)).collect();
    let mut course = Course::of(problem, &outputs)?;
    let supports = course.supports()?;
    Some(match basis {
        None => {
            let mut strides = course.in_blocks();
            course.collect(&mut strides, BY_EXPONENTIAL, &supports)
        }
        // The integrals of signals are no modes.
        Some(basis) if course.plant.integrals > 0 || !ModalMarch::is_accurate(basis) => {
            return None;
        }
        Some(basis) => {
            let mut strides = course.by_modes(Arc::clone(basis)).fine();
            course.collect(&mut strides, BY_SUPERPOSITION, &supports)
        }
    })
}

impl Course<'_, '_> {
    fn collect(
        &mut self,
        strides: &mut dyn Strides,
        method: &'static str,
        supports: &[[Vec<usize>; 2]],
    ) -> Result<Trajectory, ResponseError> {
        let (problem, n) = (self.problem, self.problem.system().len());
        let mut collector = Collector::new(problem, Wanted::by(problem))?;
        let mut motion: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0; n + supports.len()]);
        let signals = self.loads.signals.len().max(1);
        self.walk(strides, |reached| {
            let each = reached.loads.len() / signals;
            // But for the very first instant, signals are known at the one before too.
            let first = usize::from(each > 1);
            for (k, values) in reached.values.chunks_exact(2 * n).enumerate() {
                motion[0][..n].copy_from_slice(&values[..n]);
                motion[1][..n].copy_from_slice(&values[n..]);
                for (support, orders) in supports.iter().enumerate() {
                    for (motion, signals) in motion.iter_mut().zip(orders) {
                        let now = signals
                            .iter()
                            .map(|at| reached.loads[at * each + first + k]);
                        motion[n + support] = now.sum();
                    }
                }
                collector.close(&motion, reached.bounds);
            }
        })?;
        Ok(collector.finish(method).after(strides.operations()))
    }
}

/// Whether displacements and velocities at all instants would take more than 64 MB.
fn is_large(problem: &Problem<'_>) -> bool {
    const SMALL: f64 = 6.4e7;
    let grid = problem.grid();
    16.0 * problem.system().len() as f64 * (grid.last() as f64 + 1.0) > SMALL
}
