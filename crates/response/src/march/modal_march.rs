//! Marching mode by mode towards few outputs, in doubles.

use std::sync::Arc;

use eigentone_digits::DoubleDouble;
use pulp::{Simd, WithSimd};

use super::deviation::is_near;
use super::estimate::Detour;
use super::grid_loads::{GridLoads, Signal};
use super::modal_basis::{Basis, HeldBlock, add_to_block};
use super::strides::{Strides, largest};
use crate::answer::{Operations, Output};
use crate::exponential::vector::{multiply_add, run};
use crate::hold::accumulate;
use crate::problem::Plant;

/// z = T ζ, where each pair ζ_j of states moves by itself: ζ_j ← E_j ζ_j + G_j u with E_j 2 × 2, and outputs are
/// sums over all pairs. A step costs N (4 + q + p) multiplications for N states, q outputs and p loads.
///
/// E_j is kept to twice the digits of a double, so that its rounding does not let the phase drift; only the
/// roundings of the steps themselves are left, and where it is fine, ζ is kept to so many digits too.
pub(crate) struct ModalMarch {
    basis: Arc<Basis>,
    /// Group by group.
    powers: Vec<[Entries; 2]>,
    /// For each group, what each input adds: values at the start of a step, and at the end of it.
    pushes: Vec<Pair>,
    /// For each output, what each group adds.
    outputs: Vec<Pair>,
    state: Vec<Pair>,
    /// What the states have beyond doubles; empty where it is not fine.
    low: Vec<Pair>,
    /// Of each signal, whether its value at the end of a step counts too.
    runs: Vec<bool>,
    largest: [f64; 2],
    steps: u64,
}

/// So many pairs are taken together.
const LANES: usize = 4;
type Lanes = [f64; LANES];
/// First and second states of pairs; single states stand beside zeros.
type Pair = [Lanes; 2];
/// By rows.
type Entries = [Lanes; 4];

impl ModalMarch {
    /// Whether its error is within what methods in doubles estimate: roundings of a unit for each step, enlarged
    /// on the way to modes and back, beside eight units for each step and state.
    pub(crate) fn is_accurate(basis: &Basis) -> bool {
        basis.enlargement <= 8.0 * basis.form.states() as f64
    }

    /// From the state `z`, of the plant's inputs.
    pub(crate) fn of(
        basis: Arc<Basis>,
        plant: &Plant,
        loads: &GridLoads<'_>,
        h: f64,
        z: &[f64],
        outputs: &[Output],
    ) -> ModalMarch {
        let (n, states) = (basis.form.massive().len(), basis.form.states());
        let groups = basis.blocks.len().div_ceil(LANES);
        let u = basis.inverse.as_ref() * plant.b.as_ref();
        let inputs: usize = loads
            .signals
            .iter()
            .map(|signal| 1 + usize::from(signal.rise.is_some()))
            .sum();
        let mut zeta = vec![0.0; states];
        accumulate(&basis.inverse, z, &mut zeta);
        let mut march = ModalMarch {
            powers: vec![[[[0.0; LANES]; 4]; 2]; groups],
            pushes: vec![[[0.0; LANES]; 2]; groups * inputs],
            outputs: vec![[[0.0; LANES]; 2]; groups * outputs.len()],
            state: vec![[[0.0; LANES]; 2]; groups],
            low: Vec::new(),
            runs: loads
                .signals
                .iter()
                .map(|signal| signal.rise.is_some())
                .collect(),
            largest: [0.0; 2],
            steps: 0,
            basis,
        };
        let mut first = 0;
        let blocks = march.basis.blocks(&plant.moving);
        for (index, block) in blocks.iter().enumerate() {
            let (group, lane) = (index / LANES, index % LANES);
            let held = HeldBlock::of(block, DoubleDouble::from(h), &loads.laws);
            let width = held.width;
            for (at, entry) in held.phi.iter().enumerate() {
                let place = 2 * (at / width) + at % width;
                march.powers[group][0][place][lane] = entry.high();
                march.powers[group][1][place][lane] = entry.low();
            }
            let input = |column: usize| {
                let (law, loaded) = (column / loads.loaded.len(), column % loads.loaded.len());
                let on = loads.loaded[loaded];
                let force: Vec<f64> = (0..width).map(|i| u[(first + i, on)]).collect();
                let mut pushed = [0.0; 2];
                add_to_block(held.gamma[law].as_ref(), &force, &mut pushed);
                pushed
            };
            for (at, pushed) in loads
                .signals
                .iter()
                .flat_map(|signal| of_signal(signal, input))
                .enumerate()
            {
                for (half, pushed) in pushed.into_iter().enumerate() {
                    march.pushes[group * inputs + at][half][lane] = pushed;
                }
            }
            for half in 0..width {
                for (at, output) in outputs.iter().enumerate() {
                    let row = match output {
                        Output::Displacement(i) => *i,
                        Output::Velocity(i) => n + i,
                    };
                    let entry = march.basis.t[(row, first + half)];
                    march.outputs[at * groups + group][half][lane] = entry;
                }
            }
            first += width;
        }
        march.set(&zeta);
        march.meet();
        march
    }

    /// The same, with roundings of the steps that do not add up.
    pub(crate) fn fine(self) -> ModalMarch {
        ModalMarch {
            low: vec![[[0.0; LANES]; 2]; self.state.len()],
            ..self
        }
    }

    /// Where the states of each block stand: group, lane and half.
    fn places(&self) -> impl Iterator<Item = [usize; 3]> {
        let blocks = self.basis.blocks.iter().enumerate();
        blocks.flat_map(|(index, block)| {
            (0..block.width).map(move |half| [index / LANES, index % LANES, half])
        })
    }

    fn zeta(&self) -> Vec<f64> {
        let entry = |[group, lane, half]: [usize; 3]| self.state[group][half][lane];
        self.places().map(entry).collect()
    }

    fn set(&mut self, zeta: &[f64]) {
        let places: Vec<[usize; 3]> = self.places().collect();
        for ([group, lane, half], value) in places.into_iter().zip(zeta) {
            self.state[group][half][lane] = *value;
        }
    }

    /// Raises the largest displacement and velocity to those of the state reached.
    fn meet(&mut self) {
        let zeta = self.zeta();
        let mut z = vec![0.0; zeta.len()];
        accumulate(&self.basis.t, &zeta, &mut z);
        let (x, v) = z.split_at(self.basis.form.massive().len());
        for (top, values) in self.largest.iter_mut().zip([x, v]) {
            *top = top.max(largest(values));
        }
    }
}

/// What a signal adds by its value at the start of a step, and what by that at the end.
fn of_signal(
    signal: &Signal<'_>,
    input: impl Fn(usize) -> [f64; 2],
) -> impl Iterator<Item = [f64; 2]> {
    let value = input(signal.value);
    let rise = signal.rise.map(input);
    let start = rise.map_or(value, |rise| [value[0] - rise[0], value[1] - rise[1]]);
    std::iter::once(start).chain(rise)
}

impl Strides for ModalMarch {
    fn method(&self) -> &'static str {
        "modal recurrence"
    }

    fn multiple(&self) -> usize {
        1
    }

    fn together(&self) -> usize {
        // Their end is turned into displacements and velocities, which costs as much as some steps.
        (4 * self.basis.form.states()).max(512)
    }

    fn advance(&mut self, loads: &[f64], values: &mut [f64], steps: usize) {
        match self.low.is_empty() {
            true => run(March::<false> {
                modal: self,
                loads,
                values,
                steps,
            }),
            false => run(March::<true> {
                modal: self,
                loads,
                values,
                steps,
            }),
        }
        self.steps += steps as u64;
        self.meet();
    }

    fn deviate(&mut self, rest: &[f64]) -> bool {
        let mut rest_of_modes = vec![0.0; rest.len()];
        accumulate(&self.basis.inverse, rest, &mut rest_of_modes);
        let mut zeta = self.zeta();
        let near = is_near(&zeta, &rest_of_modes);
        if near {
            let pairs = zeta.iter_mut().zip(&rest_of_modes);
            pairs.for_each(|(entry, rest)| *entry -= rest);
            self.set(&zeta);
        }
        near
    }

    fn detour(&self) -> Option<Detour> {
        Some(self.basis.detour)
    }

    fn largest(&self) -> [f64; 2] {
        self.largest
    }

    fn is_finite(&self) -> bool {
        let mut all = self.state.iter().flatten().flatten();
        all.all(|entry| entry.is_finite())
    }

    fn operations(&self) -> Operations {
        Operations {
            exponentials: self.basis.blocks.len() as u64,
            products: 0.0,
            steps: self.steps,
        }
    }
}

struct March<'a, const FINE: bool> {
    modal: &'a mut ModalMarch,
    loads: &'a [f64],
    values: &'a mut [f64],
    steps: usize,
}

impl<const FINE: bool> WithSimd for March<'_, FINE> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let ModalMarch {
            powers,
            pushes,
            outputs,
            state,
            low,
            runs,
            ..
        } = self.modal;
        let groups = state.len();
        let q = outputs.len().checked_div(groups).unwrap_or(0);
        let stride = self.loads.len().checked_div(runs.len()).unwrap_or(0);
        let width = runs.iter().map(|runs| 1 + usize::from(*runs)).sum();
        let mut inputs: Vec<f64> = vec![0.0; width];
        for step in 0..self.steps {
            let mut to = inputs.iter_mut();
            for (signal, runs) in runs.iter().enumerate() {
                let at = signal * stride + step;
                let from = &self.loads[at..=at + usize::from(*runs)];
                for (value, to) in from.iter().zip(&mut to) {
                    *to = *value;
                }
            }
            let mut pushes = pushes.chunks_exact(width.max(1));
            let mut lows = low.iter_mut();
            for (pair, [power, rest]) in state.iter_mut().zip(&*powers) {
                let mut next = [[0.0; LANES]; 2];
                if width > 0 {
                    let pushes = pushes.next().unwrap_or_default();
                    for (push, input) in pushes.iter().zip(&inputs) {
                        let input = [*input; LANES];
                        add::<S>(&mut next[0], &push[0], &input);
                        add::<S>(&mut next[1], &push[1], &input);
                    }
                }
                if FINE && let Some(low) = lows.next() {
                    (*pair, *low) = fine::<S>(next, [power, rest], pair, low);
                    continue;
                }
                // The smallest terms first.
                for entries in [rest, power] {
                    for half in 0..2 {
                        add::<S>(&mut next[half], &entries[2 * half + 1], &pair[1]);
                        add::<S>(&mut next[half], &entries[2 * half], &pair[0]);
                    }
                }
                *pair = next;
            }
            let values = &mut self.values[step * q..(step + 1) * q];
            for (value, output) in values.iter_mut().zip(outputs.chunks_exact(groups.max(1))) {
                let mut sums = [[0.0; LANES]; 2];
                for (pair, factors) in state.iter().zip(output) {
                    add::<S>(&mut sums[0], &factors[0], &pair[0]);
                    add::<S>(&mut sums[1], &factors[1], &pair[1]);
                }
                let sum: Lanes = std::array::from_fn(|lane| sums[0][lane] + sums[1][lane]);
                *value = (sum[0] + sum[1]) + (sum[2] + sum[3]);
            }
        }
    }
}

/// E ζ and what is pushed, all but the latter to twice the digits of a double, rounded to a double and the rest.
#[inline(always)]
fn fine<S: Simd>(
    pushed: Pair,
    [power, rest]: [&Entries; 2],
    high: &Pair,
    low: &Pair,
) -> (Pair, Pair) {
    let (mut to, mut left) = (pushed, [[0.0; LANES]; 2]);
    for half in 0..2 {
        for lane in 0..LANES {
            let (mut sum, mut beyond) = (pushed[half][lane], 0.0);
            for from in 0..2 {
                let (entry, state) = (power[2 * half + from][lane], high[from][lane]);
                let product = entry * state;
                let second =
                    multiply_add::<S>(rest[2 * half + from][lane], state, entry * low[from][lane]);
                let cut = multiply_add::<S>(entry, state, -product);
                // Knuth's sum, which leaves nothing out.
                let added = sum + product;
                let part = added - sum;
                let lost = (sum - (added - part)) + (product - part);
                sum = added;
                beyond += (cut + second) + lost;
            }
            let rounded = sum + beyond;
            to[half][lane] = rounded;
            left[half][lane] = beyond - (rounded - sum);
        }
    }
    (to, left)
}

/// sum += x·y.
#[inline(always)]
fn add<S: Simd>(sum: &mut Lanes, x: &Lanes, y: &Lanes) {
    for lane in 0..LANES {
        sum[lane] = multiply_add::<S>(x[lane], y[lane], sum[lane]);
    }
}

/// What it costs to prepare and to run, in multiplications that wait for nothing.
pub(crate) fn work(
    states: usize,
    classical: bool,
    outputs: usize,
    loads: usize,
    steps: u64,
) -> f64 {
    /// Finding modes, in cubes of the number of states.
    const CLASSICAL: f64 = 2.0;
    const COMPLEX: f64 = 16.0;
    /// A step takes as long as so many multiplications beside them.
    const STEP: f64 = 150.0;
    let n = states as f64;
    let prepare = if classical { CLASSICAL } else { COMPLEX } * n * n * n;
    prepare + steps as f64 * (n * (4 + outputs + loads) as f64 + STEP)
}
