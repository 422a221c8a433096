//! The exact response by the matrix exponential of the whole state.

use std::collections::HashMap;

use eigentone_digits::DoubleDouble;
use eigentone_modes::{FirstOrder, FirstOrderError, System};
use faer::{Mat, MatMut};

use super::batch::Batch;
use super::course;
use super::estimate::{Estimate, is_stiff};
use super::flow::{Coordinates, Flow, Outputs, march};
use super::strides::BY_EXPONENTIAL;
use crate::answer::{Operations, ResponseMethod, Trajectory};
use crate::exponential::second_order;
use crate::hold::{Held, Inputs, accumulate, exact};
use crate::problem::{Plant, Problem, ResponseError, TimeGrid};

/// z(t + h) = e^{Ah} z(t) + what the loads add, each exactly: for every system with a first-order
/// form, at resonance, at critical damping and without supports. One exponential for each length of
/// step, then a matrix–vector product a step; of many states, and of long motions on the grid, several steps at a time.
#[derive(Clone, Copy, Debug)]
pub struct ByExponential;

impl ResponseMethod for ByExponential {
    fn name(&self) -> &'static str {
        BY_EXPONENTIAL
    }

    fn refuses(&self, problem: &Problem<'_>) -> Option<String> {
        FirstOrder::of(problem.system())
            .err()
            .map(|error| error.to_string())
    }

    fn run(&self, problem: &Problem<'_>) -> Result<Trajectory, ResponseError> {
        match Exponential::of(problem.system()) {
            Ok(exponential) => exponential.run(problem),
            Err(error) => Err(ResponseError::NotApplicable {
                method: self.name(),
                reason: error.to_string(),
            }),
        }
    }
}

/// The first-order form of a system and what is estimated of it, found once for any number of its motions.
pub(crate) struct Exponential {
    form: FirstOrder,
    estimate: Estimate,
}

impl Exponential {
    pub(crate) fn of(system: &System) -> Result<Exponential, FirstOrderError> {
        let form = FirstOrder::of(system)?;
        Ok(Exponential {
            estimate: Estimate::of(system, &form),
            form,
        })
    }

    /// Whether rounding the state matrix is estimated to spoil a motion visibly.
    pub(crate) fn is_stiff(&self, grid: &TimeGrid) -> bool {
        is_stiff(&self.estimate, grid)
    }

    /// The motion of a problem of the same system.
    pub(crate) fn run(&self, problem: &Problem<'_>) -> Result<Trajectory, ResponseError> {
        if let Some(answer) = course::whole(problem, None) {
            return answer;
        }
        let form = &self.form;
        let plant = Plant::of(problem, form).evened();
        let inputs = Inputs::of(problem);
        let mut flow = Dense {
            u: inputs.columns(plant.b.as_ref()),
            inputs,
            held: HashMap::new(),
            batches: HashMap::new(),
            count: problem.grid().last(),
            operations: Operations::default(),
            next: vec![0.0; plant.a.nrows()],
            a: plant.a.clone(),
        };
        let coordinates = Coordinates {
            estimate: self.estimate.clone(),
            b: plant.b.as_ref(),
            enter: &<[f64]>::to_vec,
            outputs: &Outputs::of(&plant, None),
            integrals: plant.integrals,
        };
        march(BY_EXPONENTIAL, problem, &mut flow, form, &coordinates)
    }
}

/// The whole state matrix, with the holds computed so far by the bits of their length.
struct Dense {
    a: Mat<f64>,
    u: Mat<f64>,
    inputs: Inputs,
    held: HashMap<u64, Held>,
    /// What takes many steps of a length at a time.
    batches: HashMap<u64, Batch>,
    /// How many steps the grid has.
    count: u64,
    operations: Operations,
    next: Vec<f64>,
}

/// So many lengths of step are kept.
const KEPT: usize = 64;

impl Dense {
    fn held(&mut self, h: f64) -> &Held {
        if self.held.len() >= KEPT && !self.held.contains_key(&h.to_bits()) {
            self.held.clear();
            self.batches.clear();
        }
        self.held.entry(h.to_bits()).or_insert_with(|| {
            let held = exact(
                second_order,
                self.a.as_ref(),
                self.u.as_ref(),
                h,
                &self.inputs.laws,
            );
            self.operations.exponentials += 1;
            self.operations.products += held.products;
            held
        })
    }
}

impl Flow for Dense {
    fn advance(&mut self, h: DoubleDouble, z: &mut [f64], signals: &[f64]) {
        let mut next = std::mem::take(&mut self.next);
        next.fill(0.0);
        self.held(h.to_f64());
        let held = &self.held[&h.to_f64().to_bits()];
        accumulate(&held.phi, z, &mut next);
        for (gamma, values) in held.gamma.iter().zip(self.inputs.by_law(signals)) {
            accumulate(gamma, values, &mut next);
        }
        z.copy_from_slice(&next);
        self.next = next;
        self.operations.steps += 1;
    }

    fn together(&self) -> usize {
        /// Below, a step is so short that products save nothing.
        const MANY_STATES: usize = 48;
        /// So many entries of states are held at a time, which lets products have many columns.
        const ENTRIES: usize = 1 << 19;
        match self.a.nrows() {
            0..MANY_STATES => 1,
            states => (ENTRIES / states).clamp(256, 4096),
        }
    }

    fn advance_all(
        &mut self,
        h: DoubleDouble,
        z: &mut [f64],
        signals: &[f64],
        mut states: MatMut<'_, f64>,
    ) {
        /// Fewer blocks are not worth their preparation.
        const BLOCKS: usize = 4;
        let (count, steps, h_bits) = (self.count, states.ncols(), h.to_f64().to_bits());
        self.held(h.to_f64());
        let held = &self.held[&h_bits];
        let fits = |batch: &Batch| batch.steps() > 1 && steps >= BLOCKS * batch.steps();
        if steps >= 2 * BLOCKS && !self.batches.contains_key(&h_bits) {
            let batch = Batch::of(held, count);
            self.operations.products += batch.products;
            self.batches.insert(h_bits, batch);
        }
        if let Some(batch) = self.batches.get(&h_bits).filter(|batch| fits(batch)) {
            batch.advance(z, signals, states);
            self.operations.steps += steps as u64;
            return;
        }
        let width = signals.len() / steps.max(1);
        for (step, state) in states.as_mut().col_iter_mut().enumerate() {
            self.advance(h, z, &signals[step * width..(step + 1) * width]);
            state.iter_mut().zip(&*z).for_each(|(to, from)| *to = *from);
        }
    }

    fn preparation(&self) -> u64 {
        32 * self.a.nrows() as u64
    }

    fn operations(&self) -> Operations {
        self.operations
    }
}
