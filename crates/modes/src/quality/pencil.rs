//! Q(λ) = λ²M + λC + K applied to shapes, with the norms that scale its residuals.

use faer::{Mat, MatRef};
use num_complex::Complex;

use crate::system::System;

/// M, C, K in doubles with their Frobenius norms.
pub(crate) struct Pencil {
    matrices: [Mat<f64>; 3],
    norms: [f64; 3],
}

impl Pencil {
    pub(crate) fn of(system: &System) -> Pencil {
        let matrices = [
            system.mass_matrix(),
            system.damping_matrix(),
            system.stiffness_matrix(),
        ];
        let norms = [0, 1, 2].map(|i: usize| matrices[i].norm_l2());
        Pencil { matrices, norms }
    }

    /// |λ|²‖M‖ + |λ|‖C‖ + ‖K‖.
    fn scale(&self, lambda: Complex<f64>) -> f64 {
        let size = lambda.norm();
        (size * self.norms[0] + self.norms[1]) * size + self.norms[2]
    }

    /// η = ‖Q(λ)x‖ / ((|λ|²‖M‖ + |λ|‖C‖ + ‖K‖)‖x‖).
    pub(crate) fn backward_error(&self, lambda: Complex<f64>, x: &[Complex<f64>]) -> f64 {
        let [m, c, k] = &self.matrices;
        let [mx, cx, kx] = [m, c, k].map(|matrix| product(matrix.as_ref(), x));
        let residual: f64 = (0..x.len())
            .map(|i| ((mx[i] * lambda + cx[i]) * lambda + kx[i]).norm())
            .fold(0.0, f64::hypot);
        let size = self.scale(lambda) * norm(x);
        if residual == 0.0 {
            0.0
        } else {
            residual / size
        }
    }

    /// The shapes x and y that Q(λ) nearly annuls from the right and from the left: the singular
    /// vectors of its smallest singular value. `None` where the iteration fails.
    pub(crate) fn null_vectors(&self, lambda: Complex<f64>) -> Option<[Vec<Complex<f64>>; 2]> {
        let [m, c, k] = &self.matrices;
        let n = m.nrows();
        let scale = self.scale(lambda);
        let q = Mat::from_fn(n, n, |i, j| {
            ((lambda * m[(i, j)] + c[(i, j)]) * lambda + k[(i, j)]) / scale
        });
        if !q.norm_max().is_finite() {
            return None;
        }
        let svd = q.svd().ok()?;
        let last = |vectors: MatRef<'_, Complex<f64>>| {
            vectors.col(n - 1).iter().copied().collect::<Vec<_>>()
        };
        Some([last(svd.V()), last(svd.U())])
    }

    /// κ = (|λ|²‖M‖ + |λ|‖C‖ + ‖K‖)‖x‖‖y‖ / (|λ||y*(2λM + C)x|); `None` where it does not exist.
    pub(crate) fn condition(
        &self,
        lambda: Complex<f64>,
        x: &[Complex<f64>],
        y: &[Complex<f64>],
    ) -> Option<f64> {
        let [m, c, _] = &self.matrices;
        let (mx, cx) = (product(m.as_ref(), x), product(c.as_ref(), x));
        let slope: Complex<f64> = (0..x.len())
            .map(|i| y[i].conj() * (mx[i] * lambda * 2.0 + cx[i]))
            .sum();
        let condition = self.scale(lambda) * norm(x) * norm(y) / (lambda.norm() * slope.norm());
        condition.is_finite().then_some(condition)
    }
}

fn product(matrix: MatRef<'_, f64>, x: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let mut result = vec![Complex::ZERO; x.len()];
    for (j, entry) in x.iter().enumerate() {
        for (sum, factor) in result.iter_mut().zip(matrix.col(j).iter()) {
            *sum += entry * factor;
        }
    }
    result
}

pub(crate) fn norm(x: &[Complex<f64>]) -> f64 {
    x.iter().map(|entry| entry.norm()).fold(0.0, f64::hypot)
}
