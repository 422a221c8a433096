//! Marching in blocks of steps towards few outputs.

use faer::Mat;
use pulp::{Simd, WithSimd};

use crate::hold::Held;
use crate::vector::run;

/// From the state at the start of a block of B steps and the loads in it, the outputs at the end of
/// each step and the state at the end of the block, as one matrix times one vector:
///
/// [y_1 … y_B z_B] = [T O; F Φ^B] [s_0 … s_{B−1} z_0]
///
/// where z_{k+1} = Φ z_k + Γ s_k and y_k = C z_k. States in between are never formed: a step costs (qB +
/// N)(N + pB)/B multiplications for q outputs, N states and p values of loads, not N², and
/// rounding errors meet the state once a block. The matrix comes from doublings, O_{2B} = [O_B; O_B
/// Φ^B], F_{2B} = [Φ^B F_B, F_B], Φ^{2B} = (Φ^B)².
pub(crate) struct Blocks {
    pub(crate) steps: usize,
    pub(crate) outputs: usize,
    states: usize,
    /// Groups of rows, the last filled up with zeros; in each, column by column.
    matrix: Vec<[f64; ROWS]>,
    groups: usize,
    columns: usize,
    /// Products of N × N matrices that it took.
    pub(crate) products: f64,
}

impl Blocks {
    /// For outputs C = `selected` states, over `count` steps in all.
    pub(crate) fn of(held: &Held, selected: &[usize], count: u64) -> Blocks {
        let n = held.phi.nrows();
        let width: usize = held.gamma.iter().map(Mat::ncols).sum();
        let q = selected.len();
        let steps = best_size(n, q, width, count);
        let mut gamma = Mat::<f64>::zeros(n, width);
        let mut at = 0;
        for part in &held.gamma {
            gamma.as_mut().subcols_mut(at, part.ncols()).copy_from(part);
            at += part.ncols();
        }
        let mut power = held.phi.clone();
        let mut observed = Mat::from_fn(q, n, |i, j| f64::from(u8::from(selected[i] == j)));
        let mut pushed = gamma.clone();
        let mut size = 1;
        let mut products = 0.0;
        while size < steps {
            let (later, earlier) = (&observed * &power, &power * &pushed);
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
            power = &power * &power;
            products += 1.0 + (size * (q + width)) as f64 / n.max(1) as f64;
            size *= 2;
        }
        // C Φ^i Γ, and outputs one step later than `observed` has them.
        let response = &observed * &gamma;
        let observed = &observed * &held.phi;
        let (rows, before) = (steps * q + n, steps * width);
        let groups = rows.div_ceil(ROWS);
        let columns = before + n;
        let entry = |i: usize, j: usize| match (i < steps * q, j < before) {
            // What comes after has no effect.
            (true, true) if i / q < j / width => 0.0,
            (true, true) => response[(i - j / width * q, j % width)],
            (true, false) => observed[(i, j - before)],
            (false, true) => pushed[(i - steps * q, j)],
            (false, false) => power[(i - steps * q, j - before)],
        };
        let place = |index: usize| {
            let (group, j) = (index / columns, index % columns);
            std::array::from_fn(|row| match group * ROWS + row {
                i if i < rows => entry(i, j),
                _ => 0.0,
            })
        };
        Blocks {
            steps,
            outputs: q,
            states: n,
            matrix: (0..groups * columns).map(place).collect(),
            groups,
            columns,
            products,
        }
    }

    /// How many values of loads there are in a block.
    pub(crate) fn width(&self) -> usize {
        self.columns - self.states
    }

    /// Marches over `count` blocks with these loads, from the state `z`, which becomes the last one; adds the
    /// outputs to `values` and raises `tops` to the sizes of the states that it comes by.
    pub(crate) fn advance(
        &self,
        count: usize,
        loads: &[f64],
        z: &mut [f64],
        values: &mut Vec<f64>,
        tops: &mut [f64],
    ) {
        run(March {
            blocks: self,
            count,
            loads,
            z,
            values,
            tops,
        });
    }
}

/// The size, a power of two, with the least work to prepare and to run.
fn best_size(n: usize, q: usize, width: usize, count: u64) -> usize {
    /// The matrix may take 256 MB.
    const LARGEST: f64 = 3.2e7;
    /// Matrices beyond a nearby cache, of so many entries, are read at the speed of memory; in products
    /// each entry serves many times.
    const NEARBY: f64 = 6e4;
    const FAR: f64 = 4.0;
    const PRODUCT: f64 = 0.3;
    /// To hand the state over to the next block takes as long as so many entries.
    const BETWEEN: f64 = 100.0;
    let [n, q, width, count] = [n as f64, q as f64, width as f64, count as f64];
    let work = |exponent: i32| {
        let size = 2f64.powi(exponent);
        let rows = ((q * size + n) / ROWS as f64).ceil() * ROWS as f64;
        let entries = rows * (n + width * size);
        let speed = if entries > NEARBY { FAR } else { 1.0 };
        let prepare = f64::from(exponent) * n * n * n + size * (q + width) * n * n;
        if entries > LARGEST && exponent > 0 {
            f64::INFINITY
        } else {
            prepare * PRODUCT + (count / size).ceil() * (entries * speed + BETWEEN)
        }
    };
    let best = (0..=12).min_by(|a, b| work(*a).total_cmp(&work(*b)));
    1 << best.unwrap_or(0)
}

/// Rows that are summed together, in registers.
const ROWS: usize = 16;

struct March<'a> {
    blocks: &'a Blocks,
    count: usize,
    loads: &'a [f64],
    z: &'a mut [f64],
    values: &'a mut Vec<f64>,
    tops: &'a mut [f64],
}

impl WithSimd for March<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Blocks {
            matrix,
            columns,
            groups,
            steps,
            outputs,
            states,
            ..
        } = self.blocks;
        let (width, rows) = (columns - states, steps * outputs);
        let mut start = vec![0.0; *columns];
        start[width..].copy_from_slice(self.z);
        let mut result = vec![[0.0; ROWS]; *groups];
        for block in 0..self.count {
            start[..width].copy_from_slice(&self.loads[block * width..(block + 1) * width]);
            for (result, group) in result.iter_mut().zip(matrix.chunks_exact(*columns)) {
                let mut sum = [0.0; ROWS];
                // The state comes last: it is what the block before hands over at its very end.
                for (factor, column) in start.iter().zip(group) {
                    add(simd, &mut sum, *factor, column);
                }
                *result = sum;
            }
            let (to_outputs, rest) = result.as_flattened().split_at(rows);
            self.values.extend_from_slice(to_outputs);
            let state = &rest[..*states];
            start[width..].copy_from_slice(state);
            for (top, value) in self.tops.iter_mut().zip(state) {
                let size = value.abs();
                *top = if size > *top { size } else { *top };
            }
        }
        self.z.copy_from_slice(&start[width..]);
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
