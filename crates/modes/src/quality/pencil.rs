//! Q(λ) = λ²M + λC + K applied to shapes, with the norms that scale its residuals.

use faer::linalg::solvers::Solve;
use faer::{Mat, MatRef};
use num_complex::Complex;

use crate::system::System;

/// M, C, K in doubles with their Frobenius norms.
pub(crate) struct Pencil {
    matrices: [Mat<f64>; 3],
    sparse: [Option<Sparse>; 3],
    norms: [f64; 3],
}

/// The entries of a matrix that are not zero, column by column.
struct Sparse(Vec<Vec<(usize, f64)>>);

/// An eigenvalue with its shapes x and y, approximately.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Approximate<'a> {
    pub(crate) value: Complex<f64>,
    pub(crate) shape: &'a [Complex<f64>],
    /// `None` where y is the conjugate of x.
    pub(crate) left: Option<&'a [Complex<f64>]>,
}

/// How good an eigenvalue and its shapes are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quality {
    /// η = ‖Q(λ)x‖ / ((|λ|²‖M‖ + |λ|‖C‖ + ‖K‖)‖x‖).
    pub(crate) backward_error: f64,
    /// κ = (|λ|²‖M‖ + |λ|‖C‖ + ‖K‖)‖x‖‖y‖ / (|λ||y*(2λM + C)x|); `None` where it does not exist.
    pub(crate) condition: Option<f64>,
}

impl Quality {
    /// κη, which bounds |λ̂ − λ|/|λ| to first order (Tisseur 2000, §2.3); ∞ without κ. The residual
    /// rounds, so that η is only known to a few units.
    pub(crate) fn first_order(&self) -> f64 {
        const RESIDUAL: f64 = 4.0 * f64::EPSILON;
        self.condition.map_or(f64::INFINITY, |condition| {
            condition * (self.backward_error + RESIDUAL)
        })
    }
}

/// Shapes that are multiplied together by a full matrix.
const BLOCK: usize = 64;

impl Pencil {
    pub(crate) fn of(system: &System) -> Pencil {
        let matrices = [
            system.mass_matrix(),
            system.damping_matrix(),
            system.stiffness_matrix(),
        ];
        Pencil {
            norms: [0, 1, 2].map(|i: usize| matrices[i].norm_l2()),
            sparse: matrices
                .each_ref()
                .map(|matrix| Sparse::of(matrix.as_ref())),
            matrices,
        }
    }

    /// |λ|²‖M‖ + |λ|‖C‖ + ‖K‖.
    fn scale(&self, lambda: Complex<f64>) -> f64 {
        let size = lambda.norm();
        (size * self.norms[0] + self.norms[1]) * size + self.norms[2]
    }

    /// The quality of every eigenvalue (Tisseur 2000, *Lin. Alg. Appl.* 309).
    pub(crate) fn qualities(&self, roots: &[Approximate<'_>]) -> Vec<Quality> {
        let blocks = roots.chunks(BLOCK).flat_map(|block| {
            let shapes: Vec<&[Complex<f64>]> = block.iter().map(|root| root.shape).collect();
            let [m, c, k] = [0, 1, 2].map(|i: usize| match &self.sparse[i] {
                Some(sparse) => shapes.iter().map(|x| sparse.times(x)).collect(),
                None => products(self.matrices[i].as_ref(), &shapes),
            });
            let each = block.iter().zip(m).zip(c).zip(k);
            each.map(|(((root, mx), cx), kx)| self.quality(root, &mx, &cx, &kx))
                .collect::<Vec<Quality>>()
        });
        blocks.collect()
    }

    fn quality(
        &self,
        root: &Approximate<'_>,
        mx: &[Complex<f64>],
        cx: &[Complex<f64>],
        kx: &[Complex<f64>],
    ) -> Quality {
        let lambda = root.value;
        let n = root.shape.len();
        let residual: Vec<Complex<f64>> = (0..n)
            .map(|i| (mx[i] * lambda + cx[i]) * lambda + kx[i])
            .collect();
        let residual = norm(&residual);
        let size = norm(root.shape);
        let scale = self.scale(lambda);
        let slope = |i: usize| mx[i] * lambda * 2.0 + cx[i];
        let (slope, left_size): (Complex<f64>, f64) = match root.left {
            Some(left) => ((0..n).map(|i| left[i].conj() * slope(i)).sum(), norm(left)),
            None => ((0..n).map(|i| root.shape[i] * slope(i)).sum(), size),
        };
        let condition = scale * size * left_size / (lambda.norm() * slope.norm());
        Quality {
            backward_error: if residual == 0.0 {
                0.0
            } else {
                residual / (scale * size)
            },
            condition: condition.is_finite().then_some(condition),
        }
    }

    /// Q(λ) over its scale.
    fn at(&self, lambda: Complex<f64>) -> Option<Mat<Complex<f64>>> {
        let [m, c, k] = &self.matrices;
        let n = m.nrows();
        let scale = self.scale(lambda);
        let q = Mat::from_fn(n, n, |i, j| {
            ((lambda * m[(i, j)] + c[(i, j)]) * lambda + k[(i, j)]) / scale
        });
        q.norm_max().is_finite().then_some(q)
    }

    /// The shapes x and y that Q(λ) nearly annuls from the right and from the left, near those that
    /// are given: by two steps of inverse iteration. `None` where a number leaves its range.
    pub(crate) fn inverse_iteration(
        &self,
        near: &Approximate<'_>,
    ) -> Option<[Vec<Complex<f64>>; 2]> {
        let lu = self.at(near.value)?.partial_piv_lu();
        let n = near.shape.len();
        let (mut x, mut y) = (near.shape.to_vec(), conjugates(near.shape));
        if let Some(left) = near.left {
            y.copy_from_slice(left);
        }
        for _ in 0..2 {
            let unit = |v: &[Complex<f64>]| {
                let size = norm(v);
                let usable = size > 0.0 && size.is_finite();
                usable.then(|| Mat::from_fn(n, 1, |i, _| v[i] / size))
            };
            let entries = |column: Mat<Complex<f64>>| column.col(0).iter().copied().collect();
            x = entries(lu.solve(unit(&x)?));
            if near.left.is_some() {
                y = entries(lu.solve_adjoint(unit(&y)?));
            } else {
                y = conjugates(&x);
            }
        }
        let finite = |v: &[Complex<f64>]| v.iter().all(|entry| entry.is_finite());
        (finite(&x) && finite(&y)).then_some([x, y])
    }

    /// The shapes x and y that Q(λ) nearly annuls from the right and from the left, wherever they
    /// are: the singular vectors of its smallest singular value. `None` where the iteration fails.
    pub(crate) fn null_vectors(&self, near: &Approximate<'_>) -> Option<[Vec<Complex<f64>>; 2]> {
        let q = self.at(near.value)?;
        let n = q.nrows();
        let svd = q.svd().ok()?;
        let last = |vectors: MatRef<'_, Complex<f64>>| {
            vectors.col(n - 1).iter().copied().collect::<Vec<_>>()
        };
        Some([last(svd.V()), last(svd.U())])
    }
}

fn conjugates(x: &[Complex<f64>]) -> Vec<Complex<f64>> {
    x.iter().map(|entry| entry.conj()).collect()
}

impl Sparse {
    /// `None` where a product with all entries is as quick.
    fn of(matrix: MatRef<'_, f64>) -> Option<Sparse> {
        const FULL: usize = 8;
        let n = matrix.nrows();
        let entries = |j: usize| matrix.col(j).iter().copied().enumerate();
        let filled: usize = (0..n)
            .map(|j| entries(j).filter(|(_, entry)| *entry != 0.0).count())
            .sum();
        let column = |j| entries(j).filter(|(_, entry)| *entry != 0.0).collect();
        (FULL * filled <= n * n || n <= BLOCK).then(|| Sparse((0..n).map(column).collect()))
    }

    fn times(&self, x: &[Complex<f64>]) -> Vec<Complex<f64>> {
        let mut result = vec![Complex::ZERO; x.len()];
        for (column, x) in self.0.iter().zip(x) {
            for (i, entry) in column {
                result[*i] += x * entry;
            }
        }
        result
    }
}

/// A real matrix times complex vectors.
pub(crate) fn products(
    matrix: MatRef<'_, f64>,
    shapes: &[&[Complex<f64>]],
) -> Vec<Vec<Complex<f64>>> {
    let n = matrix.ncols();
    let parts = Mat::from_fn(n, 2 * shapes.len(), |i, j| {
        let entry = shapes[j / 2][i];
        if j % 2 == 0 { entry.re } else { entry.im }
    });
    let product = matrix * parts;
    let column = |j: usize| {
        let (re, im) = (product.col(2 * j), product.col(2 * j + 1));
        let parts = re.iter().zip(im.iter());
        parts.map(|(re, im)| Complex::new(*re, *im)).collect()
    };
    (0..shapes.len()).map(column).collect()
}

/// ‖x‖, without overflow on the way.
pub(crate) fn norm(x: &[Complex<f64>]) -> f64 {
    let square: f64 = x.iter().map(|entry| entry.norm_sqr()).sum();
    if (1e-200..1e200).contains(&square) {
        return square.sqrt();
    }
    let parts = x.iter().flat_map(|entry| [entry.re.abs(), entry.im.abs()]);
    let largest = parts.fold(0.0, |a: f64, b| if b > a || b.is_nan() { b } else { a });
    if largest == 0.0 || !largest.is_finite() {
        return largest;
    }
    // Both factors are powers of two, and neither leaves the doubles.
    let half = (-0.5 * largest.log2()).round().exp2();
    let scaled = x.iter().map(|entry| entry * half * half);
    let square: f64 = scaled.map(|entry| entry.norm_sqr()).sum();
    square.sqrt() / half / half
}
