//! The exact response by modal superposition: small blocks instead of one large state.

use std::collections::HashMap;
use std::sync::Arc;

use eigentone_digits::DoubleDouble;
use eigentone_modes::Precision;
use faer::{Mat, MatMut};

use super::course;
use super::estimate::Estimate;
use super::flow::{Coordinates, Flow, Outputs, march};
use super::modal_basis::{Basis, BasisError, Block, HeldBlock, add_to_block, integrated};
use super::strides::BY_SUPERPOSITION;
use crate::answer::{Operations, ResponseMethod, Trajectory};
use crate::hold::{Inputs, Laws, accumulate};
use crate::problem::{Plant, Problem, ResponseError};

/// The state as a sum of modes, each of which moves by itself and exactly: O(n) a step, and without
/// drift over any number of them. What supports move that are given by velocities or accelerations is integrated beside the
/// modes, and drives them as polynomials of time.
///
/// Classically damped systems use their real shapes and keep displacement and velocity of each, so
/// that rigid-body motion, resonance and critical damping stay exact. Other systems use pairs of
/// complex shapes, where those are well conditioned; at defective roots it refuses.
#[derive(Clone, Copy, Debug)]
pub struct BySuperposition;

impl ResponseMethod for BySuperposition {
    fn name(&self) -> &'static str {
        BY_SUPERPOSITION
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
#[derive(Clone)]
pub(crate) struct Superposition {
    basis: Arc<Basis>,
}

impl Superposition {
    pub(crate) fn of(problem: &Problem<'_>) -> Result<Superposition, BasisError> {
        Ok(Superposition {
            basis: Arc::new(Basis::of(problem.system(), Precision::default())?),
        })
    }

    /// The motion of a problem of the same system.
    pub(crate) fn run(&self, problem: &Problem<'_>) -> Result<Trajectory, ResponseError> {
        if let Some(answer) = course::whole(problem, Some(&self.basis)) {
            return answer;
        }
        let basis = &self.basis;
        let inputs = Inputs::of(problem);
        let form = &basis.form;
        let plant = Plant::of(problem, form);
        let own = form.states();
        let states = own + plant.integrals;
        // What is integrated stays as it is.
        let whole = |matrix: &Mat<f64>| {
            Mat::from_fn(states, states, |i, j| match i < own && j < own {
                true => matrix[(i, j)],
                false => f64::from(u8::from(i == j)),
            })
        };
        let (t, inverse) = (whole(&basis.t), whole(&basis.inverse));
        let b = &inverse * &plant.b;
        let driven =
            inverse.submatrix(0, 0, own, own) * plant.a.submatrix(0, own, own, plant.integrals);
        let mut flow = Blocks {
            blocks: basis.blocks(&plant.moving),
            low: vec![0.0; states],
            u: inputs.columns(b.subrows(0, own)),
            integrals: Integrals::of(problem, &inputs, driven, own),
            inputs,
            held: HashMap::new(),
            operations: Operations::default(),
            modal: Vec::new(),
        };
        let enter = |z: &[f64]| {
            let mut modal = vec![0.0; z.len()];
            accumulate(&inverse, z, &mut modal);
            modal
        };
        let mut estimate = Estimate::of(problem.system(), form);
        estimate.detour = Some(basis.detour);
        let coordinates = Coordinates {
            estimate,
            b: b.as_ref(),
            enter: &enter,
            outputs: &Outputs::of(&plant, Some(t.as_ref())),
            integrals: plant.integrals,
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

/// The integrals of signals, which drive the blocks as polynomials of time and what the signals add to these.
struct Integrals {
    /// Of each channel that integrates: the state of u, how often, and the place of its signal among the loaded inputs, if it
    /// has any.
    chains: Vec<(usize, usize, Option<usize>)>,
    /// What each of them does to the modal coordinates.
    driven: Mat<f64>,
    /// The most integrals of a signal.
    most: usize,
}

/// How a step of one length goes.
struct Held {
    /// Each block, and what is added where loads are integrated first, by how often and law; the constant comes first.
    blocks: Vec<(HeldBlock, Vec<Vec<Mat<f64>>>)>,
    /// 1, h, h²/2, ….
    powers: Vec<DoubleDouble>,
    /// What the integrals of a signal add up to, by how often and law.
    sums: Vec<Vec<f64>>,
}

impl Integrals {
    fn of(problem: &Problem<'_>, inputs: &Inputs, driven: Mat<f64>, own: usize) -> Integrals {
        let n = problem.system().len();
        let mut first = own;
        let mut chains = Vec::new();
        for (at, channel) in problem.channels().iter().enumerate() {
            let count = channel.integrals;
            if count > 0 {
                chains.push((
                    first,
                    count,
                    inputs.loaded.binary_search(&(n + 3 * at)).ok(),
                ));
            }
            first += count;
        }
        let most = chains.iter().map(|(_, count, _)| *count).max();
        Integrals {
            most: most.unwrap_or(0),
            driven,
            chains,
        }
    }

    fn held(&self, blocks: &[Block], h: DoubleDouble, laws: &Laws) -> Held {
        let constant = Laws {
            straight: true,
            ..laws.clone()
        };
        let times = 0..if self.most > 0 { self.most + 1 } else { 0 };
        let each = |block: &Block| {
            let integrals = times.clone();
            let integrals = integrals.map(|times| integrated(block, h, &constant, times));
            (HeldBlock::of(block, h, laws), integrals.collect())
        };
        let still = Block::of_one(DoubleDouble::ZERO);
        let mut power = DoubleDouble::from(1.0);
        let powers = times.clone().map(|k| {
            let now = power;
            power = power * h / DoubleDouble::from(k as f64 + 1.0);
            now
        });
        Held {
            powers: powers.collect(),
            // An integral more is that of the state that stands still.
            sums: times
                .clone()
                .map(|times| {
                    let gamma = integrated(&still, h, &constant, times);
                    gamma.iter().map(|gamma| gamma[(0, 0)]).collect()
                })
                .collect(),
            blocks: blocks.iter().map(each).collect(),
        }
    }
}

/// Independent blocks of one or two states, and the integrals of signals. Each is carried on in double-double, so that rounding
/// does not add up over any number of steps.
struct Blocks {
    blocks: Vec<Block>,
    /// What the states have beyond doubles.
    low: Vec<f64>,
    /// T⁻¹B for the loaded inputs.
    u: Mat<f64>,
    inputs: Inputs,
    integrals: Integrals,
    held: HashMap<[u64; 2], Held>,
    operations: Operations,
    modal: Vec<f64>,
}

/// So many lengths of step are kept.
const KEPT: usize = 64;

impl Flow for Blocks {
    fn advance(&mut self, h: DoubleDouble, z: &mut [f64], signals: &[f64]) {
        let key = [h.high(), h.low()].map(f64::to_bits);
        if self.held.len() >= KEPT && !self.held.contains_key(&key) {
            self.held.clear();
        }
        let held = self.held.entry(key).or_insert_with(|| {
            self.operations.exponentials += self.blocks.len() as u64;
            self.integrals.held(&self.blocks, h, &self.inputs.laws)
        });
        self.operations.steps += 1;
        // The forces on each modal coordinate, law by law.
        let by_law = || self.inputs.by_law(signals);
        let (laws, own) = (by_law().len(), self.u.nrows());
        self.modal.clear();
        self.modal.resize(laws * own, 0.0);
        for (law, values) in by_law().enumerate() {
            accumulate(&self.u, values, &mut self.modal[law * own..(law + 1) * own]);
        }
        let Integrals { chains, driven, .. } = &self.integrals;
        // Where the constant is no law of the signals, it stands before them.
        let skipped = usize::from(!self.inputs.laws.straight);
        let mut first = 0;
        for (held, integrated) in &held.blocks {
            let width = held.width;
            let range = first..first + width;
            let mut pushed = [0.0; 2];
            // No forces by any law where no input reaches a mode.
            for (gamma, forces) in held.gamma.iter().zip(self.modal.chunks_exact(own.max(1))) {
                add_to_block(gamma.as_ref(), &forces[range.clone()], &mut pushed);
            }
            for &(chain, count, signal) in chains {
                for (k, state) in (chain..chain + count).enumerate() {
                    let column = driven.col(state - own);
                    let direction: [f64; 2] =
                        std::array::from_fn(|i| if i < width { column[first + i] } else { 0.0 });
                    let mut push = |gamma: &Mat<f64>, size: f64| {
                        let force = direction.map(|part| part * size);
                        add_to_block(gamma.as_ref(), &force[..width], &mut pushed);
                    };
                    // u⁽ᵏ⁾ goes on by its own derivatives, as far as they are integrals, and by the signal.
                    for (times, at) in (state..chain + count).enumerate() {
                        push(&integrated[times][0], z[at]);
                    }
                    if let Some(signal) = signal {
                        let gammas = integrated[count - k][skipped..].iter();
                        for (gamma, values) in gammas.zip(by_law()) {
                            push(gamma, values[signal]);
                        }
                    }
                }
            }
            let mut next = pushed.map(DoubleDouble::from);
            for (i, next) in next.iter_mut().enumerate().take(width) {
                for (j, at) in range.clone().enumerate() {
                    let state = DoubleDouble::new(z[at], self.low[at]);
                    *next += held.phi[i * width + j] * state;
                }
            }
            for (at, next) in range.zip(next) {
                // Those of the integrals are not yet changed.
                (z[at], self.low[at]) = (next.high(), next.low());
            }
            first += width;
        }
        for &(chain, count, signal) in chains {
            for (k, state) in (chain..chain + count).enumerate() {
                let mut next = DoubleDouble::ZERO;
                if let Some(signal) = signal {
                    // The signal integrated count − k times: of what stands still it is one integral more.
                    let sums = held.sums[count - k - 1][skipped..].iter();
                    for (sum, values) in sums.zip(by_law()) {
                        next += DoubleDouble::product(*sum, values[signal]);
                    }
                }
                for (power, at) in held.powers.iter().zip(state..chain + count) {
                    next += *power * DoubleDouble::new(z[at], self.low[at]);
                }
                (z[state], self.low[state]) = (next.high(), next.low());
            }
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
        signals: &[f64],
        mut states: MatMut<'_, f64>,
    ) {
        let width = signals.len() / states.ncols().max(1);
        for (step, state) in states.as_mut().col_iter_mut().enumerate() {
            self.advance(h, z, &signals[step * width..(step + 1) * width]);
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
