//! Many equal steps under any loads, every state on the way, by products of whole matrices.

use eigentone_digits::{even, product, settle};
use faer::linalg::matmul::matmul;
use faer::{Accum, ColRef, Mat, MatMut, MatRef, Par};

use super::strides::all_finite;
use crate::hold::Held;

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
    /// Φ, [even], as the other matrices.
    phi: Mat<f64>,
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
            let earlier = product(power.as_ref(), pushed.as_ref());
            products += 1.0 + pushed.ncols() as f64 / n.max(1) as f64;
            power = product(power.as_ref(), power.as_ref());
            let mut both = Mat::zeros(n, width << (doubling + 1));
            both.subcols_mut(0, earlier.ncols()).copy_from(&earlier);
            let mut later = both.subcols_mut(earlier.ncols(), pushed.ncols());
            later.copy_from(&pushed);
            pushed = both;
        }
        let batch = Batch {
            steps: 1 << doublings,
            phi: even(held.phi.as_ref()),
            power: even(power.as_ref()),
            pushed: even(pushed.as_ref()),
            gamma: even(gamma.as_ref()),
            products,
        };
        // What grows beyond the range of doubles within a block need not have been set in motion.
        let is_finite =
            |matrix: &Mat<f64>| (0..matrix.ncols()).all(|j| all_finite(matrix.col_as_slice(j)));
        match doublings == 0 || is_finite(&batch.power) && is_finite(&batch.pushed) {
            true => batch,
            false => Batch::of(held, 0),
        }
    }

    /// How many steps are a block.
    pub(super) fn steps(&self) -> usize {
        self.steps
    }

    /// Takes a step for each column of `states` from the state z, under signals that follow each other; writes the state after
    /// each, and leaves the last one in z.
    pub(super) fn advance(&self, z: &mut [f64], signals: &[f64], mut states: MatMut<'_, f64>) {
        let (n, width, s) = (z.len(), self.gamma.ncols(), self.steps);
        let steps = states.ncols();
        let blocks = steps.div_ceil(s);
        // The inputs of a block are a column; beyond the last step there are none.
        let mut inputs = Mat::<f64>::zeros(s * width, blocks);
        for (block, signals) in signals.chunks(s * width.max(1)).enumerate() {
            inputs.col_as_slice_mut(block)[..signals.len()].copy_from_slice(signals);
        }
        let add = |to: MatMut<'_, f64>, by: &Mat<f64>, from: MatRef<'_, f64>| {
            matmul(to, Accum::Add, by.as_ref(), from, 1.0, Par::Seq);
        };
        // All with the rows of zeros that the factors have: kernels read what is added to by whole registers too.
        let rows = self.phi.nrows();
        let mut starts = Mat::<f64>::zeros(rows, blocks + 1);
        starts.col_as_slice_mut(0)[..n].copy_from_slice(z);
        add(starts.subcols_mut(1, blocks), &self.pushed, inputs.as_ref());
        for block in 1..=blocks {
            let (before, after) = starts.as_mut().split_at_col_mut(block);
            let before = before.as_ref().submatrix(0, block - 1, n, 1);
            add(after.subcols_mut(0, 1), &self.power, before);
        }
        let mut now = starts.as_ref().subcols(0, blocks).to_owned();
        let mut next = Mat::zeros(rows, blocks);
        for step in 1..=s {
            if step == s {
                next.copy_from(starts.as_ref().subcols(1, blocks));
            } else {
                let of_step = inputs.as_ref().subrows((step - 1) * width, width);
                next.fill(0.0);
                add(next.as_mut(), &self.gamma, of_step);
                add(next.as_mut(), &self.phi, now.as_ref().subrows(0, n));
            }
            for block in 0..blocks {
                let at = block * s + step - 1;
                if at < steps {
                    let state = &next.col_as_slice(block)[..n];
                    states
                        .as_mut()
                        .col_mut(at)
                        .copy_from(ColRef::from_slice(state));
                }
            }
            std::mem::swap(&mut now, &mut next);
        }
        settle();
        let last = states.as_ref().col(steps - 1);
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

#[cfg(test)]
mod tests {
    use eigentone_modes::{FirstOrder, MatrixKind, System};

    use super::*;
    use crate::exponential::second_order;
    use crate::hold::accumulate;
    use crate::hold::{Inputs, exact};
    use crate::march::ByExponential;
    use crate::problem::{Instant, Leg, Plant, Walk};
    use crate::{Harmonic, Hold, Response, ResponseMethod, Samples, State, Step, Trajectory};

    const N: usize = 30;

    /// Full M, C and K of oscillators turned by a reflection, so that the motion is known; the last `free` have no spring, and
    /// negative numbers make the first grow.
    fn turned(free: usize, growth: f64) -> System {
        let w = |i: usize| (1.0 + i as f64).sin() + 1.5;
        let size: f64 = (0..N).map(|i| w(i) * w(i)).sum();
        let q = |i: usize, j: usize| f64::from(u8::from(i == j)) - 2.0 * w(i) * w(j) / size;
        let of = |diagonal: &dyn Fn(usize) -> f64| {
            Mat::from_fn(N, N, |i, j| {
                let terms = (0..N).map(|k| q(i, k) * diagonal(k) * q(j, k));
                terms.sum::<f64>()
            })
        };
        let symmetric = |m: Mat<f64>| Mat::from_fn(N, N, |i, j| 0.5 * (m[(i, j)] + m[(j, i)]));
        let stiff = |k: usize| if k + free >= N { 0.0 } else { 1.0 + k as f64 };
        System::builder()
            .matrix(MatrixKind::Mass, Mat::<f64>::identity(N, N).as_ref())
            .matrix(
                MatrixKind::Damping,
                symmetric(of(&|k| if k == 0 { growth } else { 0.01 * k as f64 })).as_ref(),
            )
            .matrix(MatrixKind::Stiffness, symmetric(of(&stiff)).as_ref())
            .build()
            .expect("a system")
    }

    fn asked(system: &System) -> Response<'_> {
        let samples = |hold, seed: f64| Samples {
            step: 0.1,
            values: (0..400).map(|k| (seed * f64::from(k)).sin()).collect(),
            hold,
        };
        Response::of(system)
            .from(State::at_rest().displace("x3", 0.5).push("x7", -1.0))
            .load("x1", samples(Hold::Zero, 0.7))
            .load("x2", samples(Hold::First, 0.3))
            .load("x5", Harmonic::of(2.0, 3.0))
            .load("x9", Step::of(1.0).starting_at(12.34))
            .every(0.1)
            .until(60.0)
            .with_acceleration()
    }

    fn distance(a: &Trajectory, b: &Trajectory) -> f64 {
        let parts = [
            (a.displacement(), b.displacement()),
            (a.velocity(), b.velocity()),
            (a.acceleration().unwrap(), b.acceleration().unwrap()),
        ];
        let off = |(a, b): (faer::MatRef<'_, f64>, faer::MatRef<'_, f64>)| {
            (a - b).norm_max() / a.norm_max()
        };
        parts.into_iter().map(off).fold(0.0, f64::max)
    }

    /// Held and straight samples, a sinusoid, springs or none, and growth.
    #[test]
    fn blocks_of_steps_are_the_steps_one_by_one() {
        for (free, growth) in [(0, 0.0), (2, 0.0), (1, -0.05)] {
            let system = turned(free, growth);
            let problem = asked(&system).problem().unwrap();
            let together = ByExponential.run(&problem).unwrap();
            assert!(together.operations().products > 8.0, "blocks were taken");
            let form = FirstOrder::of(&system).unwrap();
            let plant = Plant::of(&problem, &form);
            let inputs = Inputs::of(&problem);
            let u = inputs.columns(plant.b.as_ref());
            let h = problem.grid().step();
            let held = exact(second_order, plant.a.as_ref(), u.as_ref(), h, &inputs.laws);
            // The steps one by one, up to the event.
            let mut z = form.state(problem.initial_displacement(), problem.initial_velocity());
            let mut signals = inputs.empty_signals();
            let mut walk = Walk::of(&problem);
            for k in 1..=123 {
                let target = Instant::on_grid(problem.grid(), k);
                while let Some(leg) = walk.towards(&target) {
                    let Leg::Pass { from, .. } = leg else {
                        continue;
                    };
                    inputs.signals(&from, walk.piece(), h.into(), &mut signals);
                    let mut next = vec![0.0; z.len()];
                    accumulate(&held.phi, &z, &mut next);
                    for (gamma, values) in held.gamma.iter().zip(inputs.by_law(&signals.values)) {
                        accumulate(gamma, values, &mut next);
                    }
                    z = next;
                }
                let size = z.iter().fold(0.0f64, |top, z| top.max(z.abs()));
                for (i, z) in z[..N].iter().enumerate() {
                    let off = (together.displacement()[(i, k as usize)] - z).abs();
                    assert!(off <= 1e-13 * size, "{free} {growth} step {k}: {off:e}");
                }
            }
        }
    }

    /// By the modes, which know nothing of blocks.
    #[test]
    fn blocks_agree_with_superposition() {
        let system = turned(0, 0.02);
        let together = asked(&system).run_by(&ByExponential).unwrap();
        let modal = asked(&system).run_by(&crate::BySuperposition).unwrap();
        assert!(distance(&together, &modal) < 1e-11);
    }

    /// e^(800 t) within a few steps of .3 s leaves the range of doubles, but nothing sets it in motion.
    #[test]
    fn what_grows_beyond_all_range_within_a_block_but_rests_is_left_at_rest() {
        let mut held = Held {
            products: 0.0,
            phi: Mat::identity(4, 4),
            gamma: vec![Mat::zeros(4, 1)],
        };
        held.phi[(0, 0)] = 1e200;
        held.gamma[0][(1, 0)] = 1.0;
        let batch = Batch::of(&held, 1_000_000);
        assert_eq!(batch.steps(), 1);
        let mut states = Mat::zeros(4, 9);
        let mut z = [0.0, 0.0, 2.0, 0.0];
        batch.advance(&mut z, &[1.0; 9], states.as_mut());
        assert_eq!(z, [0.0, 9.0, 2.0, 0.0]);
        assert_eq!(states[(1, 4)], 5.0);
    }
}
