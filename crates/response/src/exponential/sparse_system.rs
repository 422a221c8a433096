//! Second-order systems with sparse stiffness and damping, as those of chains, trees and grids.

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, Mat, MatMut, MatRef, Par};

use super::algebra::Algebra;
use super::choice::{Choice, Size, THETA, is_upper};
use super::contiguous::Columns;
use super::dense::Dense;
use super::growth::Growth;
use super::series::Series;
use super::sparse::{LANES, LowerHalf, Panel, accumulate};
use super::squaring::square;
use super::taylor::store;
use pulp::{Simd, WithSimd};

use super::vector::run;

/// 2^-s [0 G; −K −C].
pub(super) struct SparseSystem {
    m: usize,
    g: Vec<f64>,
    lower: LowerHalf,
    choice: Choice,
    /// Whether R and Q may be squared by themselves.
    halves: bool,
}

/// Beyond this norm, for two squarings, R and Q are not squared by themselves.
const LARGEST: f64 = 4.0 * THETA;

impl SparseSystem {
    /// `None` for a matrix of another form.
    pub(super) fn of(a: Columns<'_>) -> Option<SparseSystem> {
        let m = a.nrows() / 2;
        let column = |j: usize| a.col(j).as_slice();
        if !(0..m).all(|j| is_upper(m, j, column(j), column(m + j))) {
            return None;
        }
        // Where an eighth of both is not zero, dense products cost less than the series, if not small.
        let most = (m * m / 4).max(8 * m);
        let lower = (0..2 * m).map(|j| &column(j)[m..]);
        let mut lower = LowerHalf::of(m, lower, most)?;
        let mut g: Vec<f64> = (0..m).map(|j| column(m + j)[j]).collect();
        let mut scratch = vec![0.0; 4 * m];
        let (x, rest) = scratch.split_at_mut(m);
        let (v, rest) = rest.split_at_mut(m);
        let (by_k, by_c) = rest.split_at_mut(m);
        let stiffness = lower.stiffness_norm();
        let size = Size::of(&g, stiffness, [x, v, by_k, by_c], |w, by_k, by_c| {
            for ([k, c], (by_k, by_c)) in lower.weighted(w).zip(by_k.iter_mut().zip(by_c)) {
                (*by_k, *by_c) = (k, c);
            }
        });
        let damping = lower.largest_damping();
        let choice = Choice::of(&size, damping)?;
        let even = g.iter().all(|entry| *entry == g[0]);
        let halves = choice.squarings > 0
            && size.is_within(LARGEST)
            && damping <= 1.0
            && even
            && lower.is_symmetric();
        if choice.squarings > 0 {
            let epsilon = 2f64.powi(-choice.squarings);
            lower.rescale(|_| epsilon, epsilon);
            g.iter_mut().for_each(|entry| *entry *= epsilon);
        }
        Some(SparseSystem {
            m,
            g,
            lower,
            choice,
            halves,
        })
    }

    /// e^A, and what it cost in products of the order of A.
    pub(super) fn exponential(&self, a: MatRef<'_, f64>) -> (Mat<f64>, f64) {
        let (m, n) = (self.m, 2 * self.m);
        let Choice { degree, squarings } = self.choice;
        let [mut r, mut q] = run(Series {
            m,
            lower: &self.lower,
            g: &self.g,
            degree,
        });
        let sparse = f64::from(degree) * self.lower.len() as f64 / (8 * m * m) as f64;
        if squarings == 0 || self.halves {
            let mut work = Work::new(if self.halves { m } else { 0 });
            for _ in 0..squarings {
                self.square(&mut r, &mut q, &mut work);
            }
            let mut result = Mat::zeros(n, n);
            self.assemble(&r, &q, 1.0, result.as_mut());
            // A product of half the order, and two halves of one, beside 8 for a whole one.
            return (result, sparse + 0.25 * f64::from(squarings));
        }
        let mut dense = Dense::new(n);
        let mut less_one = dense.zeros();
        let target = MatMut::from_column_major_slice_mut(&mut less_one, n, n);
        self.assemble(&r, &q, 0.0, target);
        let times = squarings.unsigned_abs();
        let result = square(&mut dense, less_one, times, || Growth::of(a));
        let matrix = store(a, &result, times);
        dense.recycle(result.element);
        (matrix, sparse + f64::from(squarings))
    }

    /// R and Q of (E − I)(E − I) + 2(E − I), with K for KG: R is 2R − RKR + QQ, of which one half is
    /// computed, and Q is 2Q − W − Wᵀ with W = (RK + QC/2) Q.
    fn square(&self, r: &mut Panel, q: &mut Panel, work: &mut Work) {
        let m = self.m;
        let g = self.g[0];
        run(Applied {
            system: self,
            r: &*r,
            q: &*q,
            rk: &mut work.rk,
            sum: &mut work.sum,
        });
        for j in 0..m {
            let to = &mut work.left[m * j..m * (j + 1)];
            to.copy_from_slice(&work.rk.column(j)[..m]);
            let to = &mut work.left[m * (m + j)..m * (m + j + 1)];
            to.copy_from_slice(&q.column(j)[..m]);
            let (upper, lower) = work.right[2 * m * j..2 * m * (j + 1)].split_at_mut(m);
            for (entry, r) in upper.iter_mut().zip(r.column(j)) {
                *entry = -g * r;
            }
            lower.copy_from_slice(&q.column(j)[..m]);
        }
        let stride = r.stride();
        matmul(
            MatMut::from_column_major_slice_mut(&mut work.w, m, m),
            Accum::Replace,
            of_panel(m, &work.sum),
            of_panel(m, q),
            1.0,
            Par::Seq,
        );
        r.entries_mut().iter_mut().for_each(|entry| *entry *= 2.0);
        triangular::matmul(
            MatMut::from_column_major_slice_with_stride_mut(r.entries_mut(), m, m, stride),
            BlockStructure::TriangularLower,
            Accum::Add,
            MatRef::from_column_major_slice(&work.left, m, 2 * m),
            BlockStructure::Rectangular,
            MatRef::from_column_major_slice(&work.right, 2 * m, m),
            BlockStructure::Rectangular,
            1.0,
            Par::Seq,
        );
        let (r, q) = (r.entries_mut(), q.entries_mut());
        for j in 0..m {
            for i in j..m {
                r[i * stride + j] = r[j * stride + i];
                let sum = 2.0 * q[j * stride + i] - (work.w[j * m + i] + work.w[i * m + j]);
                q[j * stride + i] = sum;
                q[i * stride + j] = sum;
            }
        }
    }

    /// The polynomial from R and Q, with `one` for the identity, into zeros.
    fn assemble(&self, r: &Panel, q: &Panel, one: f64, target: MatMut<'_, f64>) {
        run(Assembly {
            system: self,
            r,
            q,
            one,
            target,
        });
    }
}

fn of_panel(m: usize, panel: &Panel) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice_with_stride(panel.entries(), m, m, panel.stride())
}

/// Buffers for squarings.
struct Work {
    /// [RK Q], 2m columns of m.
    left: Vec<f64>,
    /// [−R; Q], m columns of 2m.
    right: Vec<f64>,
    rk: Panel,
    /// RK + QC/2.
    sum: Panel,
    w: Vec<f64>,
}

impl Work {
    fn new(m: usize) -> Work {
        Work {
            left: vec![0.0; 2 * m * m],
            right: vec![0.0; 2 * m * m],
            rk: Panel::zeros(m),
            sum: Panel::zeros(m),
            w: vec![0.0; m * m],
        }
    }
}

/// RK, not yet with G, and RKG + QC/2.
struct Applied<'a> {
    system: &'a SparseSystem,
    r: &'a Panel,
    q: &'a Panel,
    rk: &'a mut Panel,
    sum: &'a mut Panel,
}

impl WithSimd for Applied<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let SparseSystem { m, g, lower, .. } = self.system;
        for (j, g) in g.iter().enumerate() {
            let all = self.r.near(j, *m);
            let rk = self.rk.part_mut(j, all.clone());
            rk.fill([0.0; LANES]);
            accumulate(simd, rk, self.r, all.clone(), 1.0, lower.k(j));
            let sum = self.sum.part_mut(j, all.clone());
            for (sum, rk) in sum.iter_mut().zip(&*rk) {
                *sum = rk.map(|rk| g * rk);
            }
            accumulate(simd, sum, self.q, all, 0.5, lower.c(j));
        }
    }
}

/// [I − GRK, GQ; −QK, I − RKG − QC].
struct Assembly<'a> {
    system: &'a SparseSystem,
    r: &'a Panel,
    q: &'a Panel,
    one: f64,
    target: MatMut<'a, f64>,
}

impl WithSimd for Assembly<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let SparseSystem {
            m,
            g,
            lower,
            choice,
            halves,
        } = self.system;
        let m = *m;
        let band = match halves {
            true => m,
            false => m.min((choice.degree as usize + 1).saturating_mul(lower.band())),
        };
        let mut column = [(); 3].map(|()| vec![[0.0; LANES]; m.div_ceil(LANES)]);
        let (left, right) = self.target.split_at_col_mut(m);
        for (j, (left, right)) in left.col_iter_mut().zip(right.col_iter_mut()).enumerate() {
            let contiguous = "the columns of new matrices are contiguous";
            let left = left
                .try_as_col_major_mut()
                .expect(contiguous)
                .as_slice_mut();
            let right = right
                .try_as_col_major_mut()
                .expect(contiguous)
                .as_slice_mut();
            let (position, velocity) = left.split_at_mut(m);
            let (by_push, faded) = right.split_at_mut(m);
            let groups = self.r.near(j, band);
            let rows = groups.start * LANES..m.min(groups.end * LANES);
            let [rk, qk, sum] = column.each_mut().map(|column| &mut column[groups.clone()]);
            for part in [&mut *rk, &mut *qk] {
                part.fill([0.0; LANES]);
            }
            accumulate(simd, rk, self.r, groups.clone(), -1.0, lower.k(j));
            accumulate(simd, qk, self.q, groups.clone(), -1.0, lower.k(j));
            for (sum, rk) in sum.iter_mut().zip(&*rk) {
                *sum = rk.map(|rk| g[j] * rk);
            }
            accumulate(simd, sum, self.q, groups, -1.0, lower.c(j));
            let g = &g[rows.clone()];
            let q = &self.q.column(j)[rows.clone()];
            for ((to, rk), g) in position[rows.clone()]
                .iter_mut()
                .zip(rk.as_flattened())
                .zip(g)
            {
                *to = rk * g;
            }
            for ((to, q), g) in by_push[rows.clone()].iter_mut().zip(q).zip(g) {
                *to = q * g;
            }
            let count = rows.len();
            velocity[rows.clone()].copy_from_slice(&qk.as_flattened()[..count]);
            faded[rows].copy_from_slice(&sum.as_flattened()[..count]);
            position[j] += self.one;
            faded[j] += self.one;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exponential::contiguous::with_columns;

    fn of(a: &Mat<f64>) -> Option<SparseSystem> {
        with_columns(a.as_ref(), SparseSystem::of)
    }

    /// A chain of ten with dampers of c in parallel to its springs, at 0.1 s.
    fn chain(c: f64) -> Mat<f64> {
        let mut a = Mat::<f64>::zeros(20, 20);
        for i in 0..10 {
            a[(i, 10 + i)] = 0.1;
            for (factor, first) in [(0.1, 0), (0.1 * c, 10)] {
                a[(10 + i, first + i)] = -2.0 * factor;
                if i > 0 {
                    a[(10 + i, first + i - 1)] = factor;
                    a[(9 + i, first + i)] = factor;
                }
            }
        }
        a
    }

    #[test]
    fn chains_are_recognised() {
        let short = of(&chain(0.1)).expect("a chain");
        assert_eq!(short.choice.squarings, 0);
        // ‖K‖ = 4 and h = 3: the norm of powers is between 6 and 8.
        let longer = of(&(chain(1e-4) * faer::Scale(30.0))).expect("a chain");
        assert_eq!(longer.choice.squarings, 2);
        assert!(longer.halves);
        let long = of(&(chain(1e-4) * faer::Scale(1e4))).expect("a chain");
        assert!(long.choice.squarings > 2 && !long.halves);
    }

    #[test]
    fn stiff_chains_are_seen_in_their_own_time() {
        // The same motion in thousandths of a second: K 1e6 times larger.
        let mut a = chain(1e-4);
        for i in 0..10 {
            a[(i, 10 + i)] *= 1e-3;
            for j in 0..10 {
                a[(10 + i, j)] *= 1e3;
            }
        }
        assert_eq!(of(&a).expect("a chain").choice.squarings, 0);
    }

    #[test]
    fn decay_is_squared_whole() {
        assert!(
            of(&(chain(0.01) * faer::Scale(30.0)))
                .expect("a chain")
                .halves
        );
        let damped = of(&chain(6.0)).expect("a chain");
        assert!(damped.choice.squarings > 0 && !damped.halves);
    }

    #[test]
    fn other_matrices_are_not() {
        let alter = |i: usize, j: usize, value: f64| {
            let mut a = chain(0.1);
            a[(i, j)] = value;
            of(&a).is_some()
        };
        assert!(alter(10, 0, 0.2) && alter(10, 1, 0.2) && alter(0, 10, 0.2));
        assert!(!alter(0, 10, 0.0) && !alter(0, 10, -1.0));
        assert!(!alter(3, 3, 0.1) && !alter(0, 11, 0.1));
        assert!(!alter(10, 0, f64::NAN) && !alter(10, 0, 1e300));
        assert!(of(&Mat::zeros(20, 20)).is_none());
        let full = Mat::from_fn(20, 20, |i, j| match (i < 10, j < 10) {
            (true, _) => f64::from(u8::from(j == i + 10)),
            _ => -0.1,
        });
        assert!(of(&full).is_none());
    }
}
