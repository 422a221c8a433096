//! Many equal steps under any loads, every state on the way, by products of whole matrices.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, Par};

use crate::exponential::vector::settle;
use crate::hold::{Held, Signals};

/// z_{k+1} = Φ z_k + Γ u_k for blocks of s steps side by side. The states at the ends of the blocks come first, one
/// after the other by
///
/// z_{k+s} = Φˢ z_k + [Φˢ⁻¹Γ … ΦΓ Γ] [u_k … u_{k+s−1}],
///
/// and then those within all blocks together, the first of each, the second, and so on. A matrix of states is read
/// once for many of them, so that steps cost as much as arithmetic and not as memory; rounding errors are those of single
/// steps, as each entry of Φˢ errs by roundings of its own terms.
pub(super) struct Batch {
    steps: usize,
    power: Mat<f64>,
    /// Columns by step and then by input.
    pushed: Mat<f64>,
    /// Γ.
    gamma: Mat<f64>,
    /// How many products of N × N matrices it took.
    pub(super) products: f64,
}

impl Batch {
    /// For about so many steps in all.
    pub(super) fn of(held: &Held, count: u64) -> Batch {
        let n = held.phi.nrows();
        let width = held.gamma.iter().map(Mat::ncols).sum();
        let mut gamma = Mat::<f64>::zeros(n, width);
        let mut at = 0;
        for part in &held.gamma {
            gamma.subcols_mut(at, part.ncols()).copy_from(part);
            at += part.ncols();
        }
        let doublings = doublings(n, width, count);
        let mut power = held.phi.clone();
        let mut pushed = gamma.clone();
        let mut products = 0.0;
        for doubling in 0..doublings {
            let earlier = &power * &pushed;
            products += 1.0 + pushed.ncols() as f64 / n.max(1) as f64;
            power = &power * &power;
            let mut both = Mat::zeros(n, width << (doubling + 1));
            both.subcols_mut(0, earlier.ncols()).copy_from(&earlier);
            let mut later = both.subcols_mut(earlier.ncols(), pushed.ncols());
            later.copy_from(&pushed);
            pushed = both;
        }
        settle();
        let batch = Batch {
            steps: 1 << doublings,
            power,
            pushed,
            gamma,
            products,
        };
        // What grows beyond the range of doubles within a block need not have been set in motion.
        let is_finite = batch.power.norm_max().is_finite() && batch.pushed.norm_max().is_finite();
        match is_finite || doublings == 0 {
            true => batch,
            false => Batch::of(held, 0),
        }
    }

    /// How many steps are a block.
    pub(super) fn steps(&self) -> usize {
        self.steps
    }

    /// Takes a step under each of these signals from the state z; writes the state after each, and leaves the last one in
    /// z.
    pub(super) fn advance(
        &self,
        held: &Held,
        z: &mut [f64],
        signals: &[Signals],
        mut states: MatMut<'_, f64>,
    ) {
        let (n, width, s) = (z.len(), self.gamma.ncols(), self.steps);
        let blocks = signals.len().div_ceil(s);
        // The inputs of a block are a column; beyond the last step there are none.
        let mut inputs = Mat::<f64>::zeros(s * width, blocks);
        for (at, signals) in signals.iter().enumerate() {
            let column = inputs.col_as_slice_mut(at / s);
            let values = signals.values.iter().flatten();
            let to = &mut column[at % s * width..];
            to.iter_mut()
                .zip(values)
                .for_each(|(to, value)| *to = *value);
        }
        let add = |to: MatMut<'_, f64>, by: &Mat<f64>, from: faer::MatRef<'_, f64>| {
            matmul(to, Accum::Add, by, from, 1.0, Par::Seq);
        };
        let mut starts = Mat::<f64>::zeros(n, blocks + 1);
        starts.col_as_slice_mut(0).copy_from_slice(z);
        add(starts.subcols_mut(1, blocks), &self.pushed, inputs.as_ref());
        for block in 1..=blocks {
            let (before, after) = starts.as_mut().split_at_col_mut(block);
            let before = before.as_ref().subcols(block - 1, 1);
            add(after.subcols_mut(0, 1), &self.power, before);
        }
        let mut now = starts.as_ref().subcols(0, blocks).to_owned();
        for step in 1..=s {
            let next = match step == s {
                true => starts.as_ref().subcols(1, blocks).to_owned(),
                false => {
                    let mut next = Mat::zeros(n, blocks);
                    let of_step = inputs.as_ref().subrows((step - 1) * width, width);
                    add(next.as_mut(), &self.gamma, of_step);
                    add(next.as_mut(), &held.phi, now.as_ref());
                    next
                }
            };
            for block in 0..blocks {
                let at = block * s + step - 1;
                if at < signals.len() {
                    states.as_mut().col_mut(at).copy_from(next.col(block));
                }
            }
            now = next;
        }
        settle();
        let last = states.as_ref().col(signals.len() - 1);
        z.iter_mut()
            .zip(last.iter())
            .for_each(|(z, last)| *z = *last);
    }
}

/// log₂ s that takes the least time, counted in entries of matrices read from memory.
fn doublings(n: usize, width: usize, count: u64) -> u32 {
    /// Within products entries serve many times.
    const PRODUCT: f64 = 0.3;
    const MOST: u32 = 6;
    let (n, width, count) = (n as f64, width as f64, count as f64);
    let work = |doublings: &u32| {
        let s = 2f64.powi(*doublings as i32);
        let prepare = f64::from(*doublings) * n + s * width;
        (PRODUCT * prepare + count / s) * n * n
    };
    let all = (0..=MOST).map(|doublings| (doublings, work(&doublings)));
    let best = all.min_by(|(_, a), (_, b)| a.total_cmp(b));
    best.map_or(0, |(doublings, _)| doublings)
}
