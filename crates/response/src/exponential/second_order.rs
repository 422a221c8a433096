//! The exponential of second-order systems, by their displacements alone.

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, Mat, MatMut, MatRef, Par};

use super::diagonals::Diagonals;
use super::norm::largest;
use super::taylor::first_shift;
use super::{Exponential, Taylor};

/// The exponential of A = [0 gI; −K −C] with symmetric K and C of few diagonals, such as those of a
/// chain of equal masses; other matrices are left to [`Taylor`].
///
/// For g = 1 every polynomial p in A with p(0) = 1 is [I − RK, Q; −QK, I − RK − QC]: only R and Q are
/// kept. Multiplying by A is cheap then, so that the plain Taylor series is summed at
/// ‖2^-s A‖ ≤ 2.43; and a squaring costs one product of half the order and two halves of one, instead
/// of eight, as R and Q are symmetric. (Without symmetry it would take four, and rounding errors that
/// do not commute with A grow: that is not done.) Where damping has time to act, c_jj > 1 for some j,
/// I − RK would cancel, and [`Taylor`] serves too, as it does where ‖A‖ exceeds 9.7.
///
/// R and Q are what a unit force does to displacements: R the response to a step, Q to an impulse.
#[derive(Clone, Copy, Debug)]
pub struct SecondOrder;

/// Degrees m of the Taylor polynomial, with the θ_m of Al-Mohy & Higham 2011 (*Computing the action of
/// the matrix exponential*, SIAM J. Sci. Comput. 33, table 3.1): up to this norm it is the exponential
/// of a matrix that differs by at most 2^-53 ‖A‖.
const DEGREES: [(i32, f64); 4] = [
    (10, 0.144_182_976_161_437_8),
    (15, 0.641_083_523_304_119_9),
    (20, 1.438_252_596_804_337),
    (25, 2.428_582_524_442_826_5),
];

/// The largest norm that needs no squaring.
const THETA: f64 = DEGREES[3].1;

/// The rounding errors of RK grow as ‖A‖², those of the dense method as ‖A‖: beyond this norm, for
/// two squarings, stiff systems would lose digits.
const LARGEST: f64 = 4.0 * THETA;

/// Below this order of A, the dense method is as quick.
const LEAST: usize = 20;

impl Exponential for SecondOrder {
    fn name(&self) -> &'static str {
        "second order"
    }

    fn counted(&self, a: MatRef<'_, f64>) -> (Mat<f64>, f64) {
        /// A product of half the order, and two halves of one, beside 8 for a whole one.
        const SQUARING: f64 = 0.25;
        match Halves::of(a) {
            Some(halves) => {
                let products = SQUARING * f64::from(halves.squarings);
                (halves.exponential(), products)
            }
            None => Taylor.counted(a),
        }
    }
}

/// A scaled to [0 I; −K −C].
struct Halves {
    m: usize,
    /// ε²KG and εC, with ε = 2^-squarings.
    k: Diagonals,
    c: Diagonals,
    /// εG.
    g: Vec<f64>,
    degree: i32,
    squarings: u32,
}

impl Halves {
    fn of(a: MatRef<'_, f64>) -> Option<Halves> {
        let n = a.nrows();
        let m = n / 2;
        if n < LEAST || n % 2 == 1 || first_shift(a) > 0 {
            return None;
        }
        let zero = |i: usize, j: usize| a[(i, j)] == 0.0;
        let structured = (0..m).all(|j| {
            a[(j, m + j)] > 0.0 && (0..m).all(|i| zero(i, j) && (i == j || zero(i, m + j)))
        });
        if !structured {
            return None;
        }
        let g: Vec<f64> = (0..m).map(|j| a[(j, m + j)]).collect();
        let ones = vec![1.0; m];
        let most = 3 + m / 16;
        let (lower_left, lower_right) = (a.submatrix(m, 0, m, m), a.submatrix(m, m, m, m));
        let k = Diagonals::of(lower_left, -1.0, &ones, most)?;
        let c = Diagonals::of(lower_right, -1.0, &ones, most)?;
        let even = g.iter().all(|entry| *entry == g[0]);
        if !even || !k.is_symmetric() || !c.is_symmetric() {
            return None;
        }
        let size = bound(&g, &k, &c);
        // Beyond c = 1, motions may have decayed by more than a factor of e.
        if !size.is_finite() || c.largest_diagonal() > 1.0 {
            return None;
        }
        if size > LARGEST {
            return None;
        }
        let squarings = (size / THETA).log2().ceil().clamp(0.0, 45.0) as i32;
        let epsilon = 2f64.powi(-squarings);
        let enough = DEGREES.iter().find(|(_, theta)| epsilon * size <= *theta);
        let (degree, _) = enough.unwrap_or(&DEGREES[3]);
        let scaled: Vec<f64> = g.iter().map(|g| epsilon * g).collect();
        let k = Diagonals::of(lower_left, -epsilon, &scaled, most)?;
        let c = Diagonals::of(lower_right, -epsilon, &ones, most)?;
        Some(Halves {
            m,
            k,
            c,
            g: scaled,
            degree: *degree,
            squarings: squarings as u32,
        })
    }

    fn exponential(&self) -> Mat<f64> {
        let n = 2 * self.m;
        let mut pair = self.series();
        let mut work = Work::new(self.m);
        for _ in 0..self.squarings {
            self.square(&mut pair, &mut work);
        }
        let mut whole = vec![0.0; n * n];
        self.assemble(&pair, &mut whole);
        whole
            .iter_mut()
            .step_by(n + 1)
            .for_each(|entry| *entry += 1.0);
        Mat::from_fn(n, n, |i, j| whole[i + n * j])
    }

    /// R and Q of the Taylor polynomial, side by side: Z ← (A + Z A)/k, where (R, Q) A is
    /// (Q, −RK − QC).
    fn series(&self) -> Vec<f64> {
        let m = self.m;
        let step = self.k.band().max(self.c.band());
        let (mut r, mut q) = (vec![0.0; m * m], vec![0.0; m * m]);
        let mut next = vec![0.0; m * m];
        let mut band = 0;
        for k in (1..=self.degree).rev() {
            let factor = 1.0 / f64::from(k);
            next.fill(0.0);
            next.iter_mut()
                .step_by(m + 1)
                .for_each(|entry| *entry = factor);
            self.k.add_right(-factor, &r, band, &mut next);
            self.c.add_right(-factor, &q, band, &mut next);
            q.iter_mut().for_each(|entry| *entry *= factor);
            // (r, q, next) → (q, next, free).
            std::mem::swap(&mut r, &mut q);
            std::mem::swap(&mut q, &mut next);
            band = (band + step).min(m);
        }
        r.append(&mut q);
        r
    }

    /// (R, Q) of (E − I)(E − I) + 2(E − I): R is 2R − RKR + QQ, of which one half is computed, and Q is
    /// 2Q − W − Wᵀ with W = Q (KR + CQ/2).
    fn square(&self, pair: &mut Vec<f64>, work: &mut Work) {
        let m = self.m;
        let (r, q) = pair.split_at(m * m);
        let kr = &mut work.kr;
        kr.fill(0.0);
        self.k.add_left(1.0, r, kr);
        let half = &mut work.right;
        for (j, column) in half.chunks_exact_mut(2 * m).enumerate() {
            for (entry, kr) in column[..m].iter_mut().zip(&kr[j * m..(j + 1) * m]) {
                *entry = -kr;
            }
            column[m..].copy_from_slice(&q[j * m..(j + 1) * m]);
        }
        self.c.add_left(0.5, q, kr);
        let w = &mut work.w;
        matmul(
            MatMut::from_column_major_slice_mut(w, m, m),
            Accum::Replace,
            MatRef::from_column_major_slice(q, m, m),
            MatRef::from_column_major_slice(kr, m, m),
            1.0,
            Par::Seq,
        );
        let (next_r, next_q) = work.next.split_at_mut(m * m);
        for (next, entry) in next_r.iter_mut().zip(r) {
            *next = 2.0 * entry;
        }
        triangular::matmul(
            MatMut::from_column_major_slice_mut(next_r, m, m),
            BlockStructure::TriangularLower,
            Accum::Add,
            MatRef::from_column_major_slice(pair, m, 2 * m),
            BlockStructure::Rectangular,
            MatRef::from_column_major_slice(half, 2 * m, m),
            BlockStructure::Rectangular,
            1.0,
            Par::Seq,
        );
        for j in 0..m {
            for i in j..m {
                next_r[i * m + j] = next_r[j * m + i];
                let sum = 2.0 * q[j * m + i] - (w[j * m + i] + w[i * m + j]);
                next_q[j * m + i] = sum;
                next_q[i * m + j] = sum;
            }
        }
        std::mem::swap(pair, &mut work.next);
    }

    /// E − I in the coordinates of A: [−RK, Q; −QK, −RK − QC], with rows and columns scaled by εG.
    fn assemble(&self, pair: &[f64], out: &mut [f64]) {
        let m = self.m;
        let (r, q) = pair.split_at(m * m);
        let mut rk = vec![0.0; m * m];
        let mut qk = vec![0.0; m * m];
        self.k.add_right(-1.0, r, m, &mut rk);
        self.k.add_right(-1.0, q, m, &mut qk);
        let mut corner = rk.clone();
        self.c.add_right(-1.0, q, m, &mut corner);
        for j in 0..m {
            let (left, right) = out.split_at_mut(2 * m * m);
            let left = &mut left[2 * m * j..2 * m * (j + 1)];
            let right = &mut right[2 * m * j..2 * m * (j + 1)];
            for i in 0..m {
                left[i] = rk[j * m + i] * self.g[i] / self.g[j];
                left[m + i] = qk[j * m + i] / self.g[j];
                right[i] = q[j * m + i] * self.g[i];
                right[m + i] = corner[j * m + i];
            }
        }
    }
}

/// Buffers for squarings.
struct Work {
    /// The right factor of R, m columns of 2m.
    right: Vec<f64>,
    w: Vec<f64>,
    kr: Vec<f64>,
    next: Vec<f64>,
}

impl Work {
    fn new(m: usize) -> Work {
        Work {
            right: vec![0.0; 2 * m * m],
            w: vec![0.0; m * m],
            kr: vec![0.0; m * m],
            next: vec![0.0; 2 * m * m],
        }
    }
}

/// A bound of ‖A^k‖^{1/k} for all k ≥ 6, from the column sums of |A|³ and |A|⁴ (Al-Mohy & Higham 2009,
/// theorem 4.2), with G, K and C as they are.
fn bound(g: &[f64], k: &Diagonals, c: &Diagonals) -> f64 {
    let m = g.len();
    let (mut x, mut v) = (vec![1.0; m], vec![1.0; m]);
    let mut roots = [0f64; 4];
    for (power, root) in (1..).zip(&mut roots) {
        let mut next_x = vec![0.0; m];
        k.add_sizes(&v, &mut next_x);
        let mut next_v: Vec<f64> = x.iter().zip(g).map(|(x, g)| x * g).collect();
        c.add_sizes(&v, &mut next_v);
        (x, v) = (next_x, next_v);
        *root = largest(&[largest(&x), largest(&v)]).powf(1.0 / f64::from(power));
    }
    roots[0].min(roots[2].max(roots[3]))
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let halves = Halves::of(chain(0.1).as_ref()).expect("a chain");
        assert_eq!(halves.squarings, 0);
        // ‖K‖ = 4 and h = 3: the norm of powers is between 6 and 8.
        let halves = Halves::of((chain(1e-4) * faer::Scale(30.0)).as_ref()).expect("a chain");
        assert_eq!(halves.squarings, 2);
        assert!(Halves::of((chain(1e-4) * faer::Scale(1e4)).as_ref()).is_none());
    }

    #[test]
    fn decay_is_left_to_the_dense_method() {
        assert!(Halves::of(chain(4.0).as_ref()).is_some());
        assert!(Halves::of(chain(6.0).as_ref()).is_none());
    }

    #[test]
    fn other_matrices_are_not() {
        let alter = |i: usize, j: usize, value: f64| {
            let mut a = chain(0.1);
            a[(i, j)] = value;
            Halves::of(a.as_ref()).is_some()
        };
        assert!(alter(10, 0, 0.2));
        assert!(!alter(10, 1, 0.2) && !alter(0, 10, 0.2));
        assert!(!alter(0, 10, 0.0) && !alter(0, 10, -1.0));
        assert!(!alter(3, 3, 0.1) && !alter(0, 11, 0.1));
        assert!(!alter(10, 0, f64::NAN) && !alter(10, 0, 1e300));
        assert!(Halves::of(Mat::zeros(20, 20).as_ref()).is_none());
        assert!(Halves::of(Mat::identity(21, 21).as_ref()).is_none());
    }
}
