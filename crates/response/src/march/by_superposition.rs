//! The exact response by modal superposition: small blocks instead of one large state.

use std::collections::HashMap;

use eigentone_digits::DoubleDouble;
use eigentone_modes::{Precision, System};
use faer::{Mat, MatMut};

use super::by_exponential::accumulate;
use super::flow::{Coordinates, Flow, Outputs, march};
use super::modal_basis::{Basis, BasisError, Block, HeldBlock, add_to_block};
use crate::answer::{Operations, ResponseMethod, Trajectory};
use crate::hold::{Inputs, Signals};
use crate::problem::{Plant, Problem, ResponseError};

/// The state as a sum of modes, each of which moves by itself and exactly: O(n) a step, and without
/// drift over any number of them.
///
/// Classically damped systems use their real shapes and keep displacement and velocity of each, so
/// that rigid-body motion, resonance and critical damping stay exact. Other systems use pairs of
/// complex shapes, where those are well conditioned; at defective roots it refuses.
#[derive(Clone, Copy, Debug)]
pub struct BySuperposition;

impl ResponseMethod for BySuperposition {
    fn name(&self) -> &'static str {
        "superposition"
    }

    fn refuses(&self, problem: &Problem<'_>) -> Option<String> {
        let error = Superposition::of(problem).err()?;
        Some(error.to_string())
    }

    fn run(&self, problem: &Problem<'_>) -> Result<Trajectory, ResponseError> {
        match Superposition::of(problem) {
            Ok(superposition) => superposition.run(problem),
            Err(BasisError::Modes(error)) => Err(error.into()),
            Err(BasisError::Refused(reason)) => Err(ResponseError::NotApplicable {
                method: self.name(),
                reason,
            }),
        }
    }
}

/// The modes of a system, found once for any number of its motions.
pub(crate) struct Superposition {
    /// A clone, which shares what is proved.
    system: System,
    basis: Basis,
}

impl Superposition {
    pub(crate) fn of(problem: &Problem<'_>) -> Result<Superposition, BasisError> {
        if let Some(reason) = integrates(problem) {
            return Err(BasisError::Refused(reason));
        }
        Ok(Superposition {
            system: problem.system().clone(),
            basis: Basis::of(problem.system(), Precision::default())?,
        })
    }

    /// Whether it was found from this system or from a clone.
    pub(crate) fn is_of(&self, system: &System) -> bool {
        std::ptr::eq(self.system.structure(), system.structure())
    }

    /// The motion of a problem of the same system.
    pub(crate) fn run(&self, problem: &Problem<'_>) -> Result<Trajectory, ResponseError> {
        if let Some(reason) = integrates(problem) {
            let method = BySuperposition.name();
            return Err(ResponseError::NotApplicable { method, reason });
        }
        let basis = &self.basis;
        let inputs = Inputs::of(problem);
        let form = &basis.form;
        let plant = Plant::of(problem, form);
        let b = &basis.inverse * &plant.b;
        let mut flow = Blocks {
            blocks: &basis.blocks,
            low: vec![0.0; form.states()],
            u: inputs.columns(b.as_ref()),
            inputs,
            held: HashMap::new(),
            operations: Operations::default(),
            modal: Vec::new(),
        };
        let enter = |z: &[f64]| {
            let mut modal = vec![0.0; z.len()];
            accumulate(&basis.inverse, z, &mut modal);
            modal
        };
        let coordinates = Coordinates {
            detour: basis.detour,
            b: b.as_ref(),
            enter: &enter,
            outputs: &Outputs::of(&plant, Some(basis.t.as_ref())),
            integrals: 0,
        };
        march(
            BySuperposition.name(),
            problem,
            &mut flow,
            form,
            &coordinates,
        )
    }
}

/// The integrals of a support's velocity or acceleration are no modes.
fn integrates(problem: &Problem<'_>) -> Option<String> {
    let mut channels = problem.channels().iter();
    let integrated = channels.any(|channel| channel.integrals > 0);
    integrated.then(|| {
        "the motion of a support is given by its velocity or acceleration, whose integrals are no modes; \
         the exponential takes it"
            .to_owned()
    })
}

/// Independent blocks of one or two states. Each is carried on in double-double, so that rounding
/// does not add up over any number of steps.
struct Blocks<'a> {
    blocks: &'a [Block],
    /// What the states have beyond doubles.
    low: Vec<f64>,
    /// T⁻¹B for the loaded coordinates.
    u: Mat<f64>,
    inputs: Inputs,
    held: HashMap<[u64; 2], Vec<HeldBlock>>,
    operations: Operations,
    modal: Vec<f64>,
}

/// So many lengths of step are kept.
const KEPT: usize = 64;

impl Flow for Blocks<'_> {
    fn advance(&mut self, h: DoubleDouble, z: &mut [f64], signals: &Signals) {
        let key = [h.high(), h.low()].map(f64::to_bits);
        if self.held.len() >= KEPT && !self.held.contains_key(&key) {
            self.held.clear();
        }
        let held = self.held.entry(key).or_insert_with(|| {
            self.operations.exponentials += self.blocks.len() as u64;
            let hold = |block: &Block| HeldBlock::of(block, h, &self.inputs.laws);
            self.blocks.iter().map(hold).collect()
        });
        self.operations.steps += 1;
        // The forces on each modal coordinate, law by law.
        let laws = signals.values.len();
        self.modal.clear();
        self.modal.resize(laws * z.len(), 0.0);
        for (law, values) in signals.values.iter().enumerate() {
            accumulate(
                &self.u,
                values,
                &mut self.modal[law * z.len()..(law + 1) * z.len()],
            );
        }
        let mut first = 0;
        for held in held.iter() {
            let width = held.width;
            let range = first..first + width;
            let mut pushed = [0.0; 2];
            for (law, gamma) in held.gamma.iter().enumerate() {
                let at = law * z.len() + first;
                add_to_block(gamma.as_ref(), &self.modal[at..at + width], &mut pushed);
            }
            let mut next = pushed.map(DoubleDouble::from);
            for (i, next) in next.iter_mut().enumerate().take(width) {
                for (j, at) in range.clone().enumerate() {
                    let state = DoubleDouble::new(z[at], self.low[at]);
                    *next += held.phi[i * width + j] * state;
                }
            }
            for (at, next) in range.zip(next) {
                (z[at], self.low[at]) = (next.high(), next.low());
            }
            first += width;
        }
    }

    fn together(&self) -> usize {
        /// Below, what modes make of the motion is too little for products.
        const MANY_STATES: usize = 48;
        const TOGETHER: usize = 128;
        if self.low.len() < MANY_STATES {
            1
        } else {
            TOGETHER
        }
    }

    fn advance_all(
        &mut self,
        h: DoubleDouble,
        z: &mut [f64],
        signals: &[Signals],
        mut states: MatMut<'_, f64>,
    ) {
        for (signals, state) in signals.iter().zip(states.as_mut().col_iter_mut()) {
            self.advance(h, z, signals);
            state.iter_mut().zip(&*z).for_each(|(to, from)| *to = *from);
        }
    }

    fn preparation(&self) -> u64 {
        256
    }

    fn operations(&self) -> Operations {
        self.operations
    }
}
