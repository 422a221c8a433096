//! Marching in blocks of steps towards few outputs.

use eigentone_digits::product;
use faer::Mat;
use pulp::{Simd, WithSimd};

use super::deviation::is_near;
use super::estimate::Detour;
use super::grid_loads::Signal;
use super::strides::{BY_EXPONENTIAL, Strides, largest};
use crate::answer::{Operations, Output};
use crate::exponential::vector::run;
use crate::hold::Held;

/// From the state at the start of a block of B steps and the loads in it, the outputs at the end of
/// each step and the state at the end of the block, as one matrix times one vector:
///
/// [y_1 … y_B z_B] = [T O; F Φ^B] [u_0 … u_B z_0]
///
/// where z_{k+1} = Φ z_k + Γ_a u_k + Γ_b u_{k+1} and y_k = C z_k. States in between are never formed: a step
/// costs about (qB + N)(N + pB)/B multiplications for q outputs, N states and p loads, not N², less those
/// of later loads with earlier outputs, and rounding errors meet the state once a block. The matrix comes from
/// doublings, O_{2B} = [O_B; O_B Φ^B], F_{2B} = [Φ^B F_B, F_B], Φ^{2B} = (Φ^B)².
pub(crate) struct Blocks {
    steps: usize,
    outputs: Vec<Output>,
    /// Of each load, whether it runs on to the end of a step, so that u_B counts.
    runs: Vec<bool>,
    groups: Vec<Group>,
    /// Displacements, as many velocities, and what else moves.
    state: Vec<f64>,
    coordinates: usize,
    /// The largest displacement and velocity at the start.
    start: [f64; 2],
    /// The largest size of each row that was met.
    tops: Vec<[f64; ROWS]>,
    operations: Operations,
}

/// Rows that are summed together, in registers; the last group is filled up with zeros.
#[derive(Clone)]
struct Group {
    /// The last step whose output, or the state after it, is among the rows.
    until: usize,
    /// Load after load, each from u_0 on as far as it has an effect, and then the state.
    columns: Vec<[f64; ROWS]>,
}

/// How many rows.
const ROWS: usize = 16;

/// Coordinates that are not among the outputs are taken to be up to so many times as large within blocks as at
/// their ends.
const WITHIN: f64 = 2.0;

/// Loads and outputs of so many steps are taken together, to stay in a nearby cache.
const TOGETHER: usize = 512;

impl Blocks {
    /// Over `count` steps in all from this state: displacements of so many coordinates, their velocities, and what else moves.
    pub(crate) fn of(
        held: &Held,
        signals: &[Signal<'_>],
        outputs: &[Output],
        state: Vec<f64>,
        coordinates: usize,
        count: u64,
    ) -> Blocks {
        let n = held.phi.nrows();
        let selected = |i: usize| match outputs[i] {
            Output::Displacement(at) => at,
            Output::Velocity(at) => coordinates + at,
        };
        let width: usize = held.gamma.iter().map(Mat::ncols).sum();
        let q = outputs.len();
        let shape = Shape::of(n, q, signals);
        let (steps, _) = shape.best_size(width, count);
        let mut gamma = Mat::<f64>::zeros(n, width);
        let mut at = 0;
        for part in &held.gamma {
            gamma.as_mut().subcols_mut(at, part.ncols()).copy_from(part);
            at += part.ncols();
        }
        let mut power = held.phi.clone();
        let mut observed = Mat::from_fn(q, n, |i, j| f64::from(u8::from(selected(i) == j)));
        let mut pushed = gamma.clone();
        let mut size = 1;
        let mut products = 0.0;
        while size < steps {
            let later = product(observed.as_ref(), power.as_ref());
            let earlier = product(power.as_ref(), pushed.as_ref());
            observed = Mat::from_fn(2 * size * q, n, |i, j| match i.checked_sub(size * q) {
                None => observed[(i, j)],
                Some(i) => later[(i, j)],
            });
            pushed = Mat::from_fn(n, 2 * size * width, |i, j| {
                match j.checked_sub(size * width) {
                    None => earlier[(i, j)],
                    Some(j) => pushed[(i, j)],
                }
            });
            power = product(power.as_ref(), power.as_ref());
            products += 1.0 + (size * (q + width)) as f64 / n.max(1) as f64;
            size *= 2;
        }
        // C Φ^i Γ, and outputs one step later than `observed` has them.
        let response = product(observed.as_ref(), gamma.as_ref());
        let observed = product(observed.as_ref(), held.phi.as_ref());
        let rows = steps * q + n;
        // What the input of column `column` in step `step` makes of a row: nothing, if that comes before.
        let effect = |row: usize, step: usize, column: usize| match row.checked_sub(steps * q) {
            None if row / q < step => 0.0,
            None => response[(row - step * q, column)],
            Some(state) => pushed[(state, step * width + column)],
        };
        // What u_t makes of it, at the start of step t and at the end of the one before.
        let by_signal = |row: usize, t: usize, signal: &Signal<'_>| {
            let before = t.checked_sub(1);
            let starts = if t < steps {
                effect(row, t, signal.value)
            } else {
                0.0
            };
            let Some(rise) = signal.rise else {
                return starts;
            };
            let leaves = if t < steps { effect(row, t, rise) } else { 0.0 };
            let arrives = before.map_or(0.0, |before| effect(row, before, rise));
            (starts - leaves) + arrives
        };
        let by_state = |row: usize, j: usize| match row.checked_sub(steps * q) {
            None => observed[(row, j)],
            Some(state) => power[(state, j)],
        };
        let in_rows = |group: usize, entry: &dyn Fn(usize) -> f64| {
            std::array::from_fn(|row| match group * ROWS + row {
                row if row < rows => entry(row),
                _ => 0.0,
            })
        };
        let group = |group: usize| {
            let until = shape.until(steps, group);
            let mut columns = Vec::with_capacity(shape.columns(until));
            for signal in signals {
                let last = until + usize::from(signal.rise.is_some());
                columns.extend((0..last).map(|t| in_rows(group, &|i| by_signal(i, t, signal))));
            }
            columns.extend((0..n).map(|j| in_rows(group, &|i| by_state(i, j))));
            Group { until, columns }
        };
        let groups: Vec<Group> = (0..shape.groups(steps)).map(group).collect();
        let (x, v) = state[..2 * coordinates].split_at(coordinates);
        Blocks {
            coordinates,
            steps,
            outputs: outputs.to_vec(),
            runs: signals.iter().map(|signal| signal.rise.is_some()).collect(),
            start: [largest(x), largest(v)],
            tops: vec![[0.0; ROWS]; groups.len()],
            groups,
            state,
            operations: Operations {
                exponentials: 1,
                products: held.products + products,
                steps: 0,
            },
        }
    }
}

/// What it costs to prepare and to run, in multiplications that wait for nothing.
pub(crate) fn work(states: usize, outputs: usize, signals: &[Signal<'_>], steps: u64) -> f64 {
    let shape = Shape::of(states, outputs, signals);
    shape.best_size(signals.len(), steps).1
}

impl Strides for Blocks {
    fn method(&self) -> &'static str {
        BY_EXPONENTIAL
    }

    fn multiple(&self) -> usize {
        self.steps
    }

    fn together(&self) -> usize {
        (TOGETHER / self.steps).max(1) * self.steps
    }

    fn advance(&mut self, loads: &[f64], values: &mut [f64], steps: usize) {
        let count = steps / self.steps;
        run(March {
            blocks: self,
            count,
            loads,
            values,
        });
        self.operations.steps += count as u64;
    }

    fn deviate(&mut self, rest: &[f64]) -> bool {
        let near = is_near(&self.state, rest);
        if near {
            let pairs = self.state.iter_mut().zip(rest);
            pairs.for_each(|(entry, rest)| *entry -= rest);
        }
        near
    }

    fn detour(&self) -> Option<Detour> {
        None
    }

    fn largest(&self) -> [f64; 2] {
        let rows = self.steps * self.outputs.len();
        let tops = self.tops.as_flattened()[..rows + self.state.len()].split_at(rows);
        let (of_outputs, of_states) = tops;
        let (x, v) = of_states[..2 * self.coordinates].split_at(self.coordinates);
        let mut top = [x, v].map(|states| WITHIN * largest(states));
        for (size, output) in of_outputs.iter().zip(self.outputs.iter().cycle()) {
            let kind = usize::from(matches!(output, Output::Velocity(_)));
            top[kind] = top[kind].max(*size);
        }
        [0, 1].map(|kind| top[kind].max(self.start[kind]))
    }

    fn is_finite(&self) -> bool {
        self.state.iter().all(|entry| entry.is_finite())
    }

    fn operations(&self) -> Operations {
        self.operations
    }
}

/// What decides how much work there is.
struct Shape {
    states: usize,
    outputs: usize,
    signals: usize,
    /// How many of them run on to the end of a step.
    running: usize,
}

impl Shape {
    fn of(states: usize, outputs: usize, signals: &[Signal<'_>]) -> Shape {
        let running = signals.iter().filter(|signal| signal.rise.is_some());
        Shape {
            states,
            outputs,
            signals: signals.len(),
            running: running.count(),
        }
    }

    fn groups(&self, steps: usize) -> usize {
        (steps * self.outputs + self.states).div_ceil(ROWS)
    }

    /// The last step, from 1 on, that the rows of a group have to do with.
    fn until(&self, steps: usize, group: usize) -> usize {
        let after = (group + 1) * ROWS;
        if after > steps * self.outputs {
            steps
        } else {
            (after - 1) / self.outputs + 1
        }
    }

    fn columns(&self, until: usize) -> usize {
        self.signals * until + self.running + self.states
    }

    /// The size, a power of two, with the least work to prepare and to run, and that work; the hold has `width`
    /// columns of inputs.
    fn best_size(&self, width: usize, count: u64) -> (usize, f64) {
        /// The matrix may take 256 MB.
        const LARGEST: f64 = 3.2e7;
        /// Matrices beyond a nearby cache, of so many entries, are read at the speed of memory; in products
        /// each entry serves many times.
        const NEARBY: f64 = 6e4;
        const FAR: f64 = 4.0;
        const PRODUCT: f64 = 0.3;
        /// To hand the state over to the next block takes as long as so many entries.
        const BETWEEN: f64 = 300.0;
        let n = self.states as f64;
        let work = |exponent: i32| {
            let steps = 1usize << exponent;
            let groups = 0..self.groups(steps);
            let columns: usize = groups
                .map(|group| self.columns(self.until(steps, group)))
                .sum();
            let entries = (columns * ROWS) as f64;
            let size = steps as f64;
            let speed = if entries > NEARBY { FAR } else { 1.0 };
            let inputs = size * (self.outputs + width) as f64;
            let prepare = f64::from(exponent) * n * n * n + inputs * n * n;
            if entries > LARGEST && exponent > 0 {
                f64::INFINITY
            } else {
                prepare * PRODUCT + (count as f64 / size).ceil() * (entries * speed + BETWEEN)
            }
        };
        let sizes = (0..=12).map(|exponent| (1 << exponent, work(exponent)));
        let best = sizes.min_by(|(_, a), (_, b)| a.total_cmp(b));
        best.unwrap_or((1, f64::INFINITY))
    }
}

struct March<'a> {
    blocks: &'a mut Blocks,
    count: usize,
    loads: &'a [f64],
    values: &'a mut [f64],
}

impl WithSimd for March<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Blocks {
            steps,
            outputs,
            runs,
            groups,
            state,
            tops,
            ..
        } = self.blocks;
        let rows = *steps * outputs.len();
        let stride = self.loads.len().checked_div(runs.len()).unwrap_or(0);
        let mut result = vec![[0.0; ROWS]; groups.len()];
        for block in 0..self.count {
            for (result, group) in result.iter_mut().zip(&*groups) {
                let mut sum = [0.0; ROWS];
                let mut columns = group.columns.iter();
                for (signal, runs) in runs.iter().enumerate() {
                    let first = signal * stride + block * *steps;
                    let last = first + group.until + usize::from(*runs);
                    for (factor, column) in self.loads[first..last].iter().zip(&mut columns) {
                        add(simd, &mut sum, *factor, column);
                    }
                }
                // The state comes last: it is what the block before hands over at its very end.
                for (factor, column) in state.iter().zip(columns) {
                    add(simd, &mut sum, *factor, column);
                }
                *result = sum;
            }
            let (to_outputs, rest) = result.as_flattened().split_at(rows);
            self.values[block * rows..(block + 1) * rows].copy_from_slice(to_outputs);
            let states = state.len();
            state.copy_from_slice(&rest[..states]);
            for (tops, result) in tops.iter_mut().zip(&result) {
                for (top, value) in tops.iter_mut().zip(result) {
                    let size = value.abs();
                    *top = if size > *top { size } else { *top };
                }
            }
        }
    }
}

#[inline(always)]
fn add<S: Simd>(simd: S, sum: &mut [f64; ROWS], factor: f64, column: &[f64; ROWS]) {
    let (sum, rest) = S::as_mut_simd_f64s(sum);
    let (column, last) = S::as_simd_f64s(column);
    let factors = simd.splat_f64s(factor);
    for (sum, entry) in sum.iter_mut().zip(column) {
        *sum = simd.mul_add_e_f64s(factors, *entry, *sum);
    }
    for (sum, entry) in rest.iter_mut().zip(last) {
        *sum += factor * entry;
    }
}
