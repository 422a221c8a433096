//! From Ritz vectors to eigenvalues with their last digits.
//!
//! Each vector gets a step of inverse iteration whose solves are refined with residuals from the
//! elements in double-double. λ is its Rayleigh quotient, summed over the elements: an error ε of the
//! vector enters as ε². With ρ = ‖A x − μ x‖_M/|μ| and γ the distance from μ to the rest of the spectrum
//! of A relative to |μ|, the error of μ is at most min(ρ, ρ²/γ)·|μ| (Parlett 1998, *The Symmetric
//! Eigenvalue Problem*, theorem 11.7.1).

use faer::{Mat, Side};

use super::basis::{combine, dot};
use super::operator::ShiftInvert;
use super::search::Vector;

/// An eigenpair with its quality.
#[derive(Clone, Debug)]
pub(crate) struct Pair {
    /// λ = ω².
    pub(crate) square: f64,
    /// Of M-norm 1.
    pub(crate) shape: Vec<f64>,
    /// Estimated |λ̂ − λ|.
    pub(crate) error: Option<f64>,
}

/// Above this ρ a vector gets another step.
const ROUGH: f64 = 1e-8;

/// Vectors whose μ is so many times another's are taken out of it.
const FAR: f64 = 1e3;

/// At most so many steps.
const STEPS: usize = 4;

/// Eigenpairs from the vectors that were found; `next` is the nearest to the shift of all others.
pub(crate) fn refined(
    operator: &ShiftInvert<'_>,
    vectors: Vec<Vector>,
    next: Option<f64>,
) -> Vec<Pair> {
    let mut shapes = Shapes {
        operator,
        inverses: vectors.iter().map(|vector| vector.inverse).collect(),
        residuals: vec![0.0; vectors.len()],
        vectors: vectors.into_iter().map(|vector| vector.shape).collect(),
        doubt: 0.0,
    };
    for step in 0..STEPS {
        if shapes.vectors.is_empty() {
            break;
        }
        shapes.improve();
        if step + 1 == STEPS || shapes.residuals.iter().all(|size| *size <= ROUGH) {
            break;
        }
        shapes.separate();
    }
    shapes.pairs(next)
}

/// Vectors on their way to eigenvectors, with μ and ρ of each.
struct Shapes<'a, 'b> {
    operator: &'a ShiftInvert<'b>,
    vectors: Vec<Vec<f64>>,
    inverses: Vec<f64>,
    residuals: Vec<f64>,
    /// The relative error of solves.
    doubt: f64,
}

/// Beyond that no error is estimated.
const SMALL: f64 = 1e-3;

impl Shapes<'_, '_> {
    /// One step of inverse iteration for each vector; ρ is that before the step. Solves are refined
    /// unless those for the first and the last need none.
    fn improve(&mut self) {
        let n = self.operator.pencil.len();
        let (mut product, mut work) = (vec![0.0; n], vec![0.0; n]);
        let doubt = if self.operator.never_cancels() {
            2.0 * f64::EPSILON * (n as f64).sqrt()
        } else {
            self.probe(&mut product, &mut work)
        };
        let plain = doubt <= ROUGH;
        // What refinement leaves is smaller than the square of what it corrected.
        self.doubt = if plain { doubt } else { doubt * doubt };
        for k in 0..self.vectors.len() {
            self.operator
                .apply(&self.vectors[k], &mut product, &mut work);
            if plain {
                self.remove_nearer(k, &mut product, &mut work);
            } else {
                let missing = self.refine(k, &mut product, &mut work);
                let pairs = product.iter_mut().zip(&missing);
                pairs.for_each(|(y, missing)| *y += missing);
            }
            let mass = &self.operator.pencil.mass;
            mass.apply(&self.vectors[k], &mut work);
            let inverse = dot(&work, &product) / dot(&work, &self.vectors[k]);
            for (x, y) in self.vectors[k].iter_mut().zip(&product) {
                *x = y - inverse * *x;
            }
            let residual = self.norm(&self.vectors[k], &mut work);
            let size = self.norm(&product, &mut work);
            for (x, y) in self.vectors[k].iter_mut().zip(&product) {
                *x = y / size;
            }
            self.inverses[k] = inverse;
            self.residuals[k] = residual / size + self.doubt;
        }
    }

    /// The relative error of plain solves, by what the first and the last vector's lack.
    fn probe(&self, product: &mut [f64], work: &mut [f64]) -> f64 {
        let last = self.vectors.len() - 1;
        let probes = if last == 0 { vec![0] } else { vec![0, last] };
        let doubts = probes.into_iter().map(|k| {
            self.operator.apply(&self.vectors[k], product, work);
            let missing = self.refine(k, product, work);
            self.norm(&missing, work) / self.norm(product, work)
        });
        doubts.fold(0.0, f64::max)
    }

    /// What the product of vector k with A lacks; the product and this without what is nearer to the shift.
    fn refine(&self, k: usize, product: &mut [f64], work: &mut [f64]) -> Vec<f64> {
        let mut missing = self.operator.correction(&self.vectors[k], product, work);
        self.remove_nearer(k, product, work);
        self.remove_nearer(k, &mut missing, work);
        missing
    }

    /// A makes what rounding has left of vectors much nearer to the shift than vector k grow: makes a product
    /// orthogonal to them again.
    fn remove_nearer(&self, k: usize, product: &mut [f64], work: &mut [f64]) {
        let own = self.inverses[k].abs();
        for (nearer, inverse) in self.vectors[..k].iter().zip(&self.inverses) {
            if inverse.abs() > FAR * own {
                self.operator.pencil.mass.apply(product, work);
                let along = dot(nearer, work);
                let pairs = product.iter_mut().zip(nearer);
                pairs.for_each(|(y, x)| *y -= along * x);
            }
        }
    }

    /// The M-norm.
    fn norm(&self, x: &[f64], work: &mut [f64]) -> f64 {
        self.operator.pencil.mass.apply(x, work);
        dot(x, work).max(0.0).sqrt()
    }

    /// Rotates the vectors to the eigenvectors of the pencil in their span, those together whose μ lie not far
    /// apart.
    fn separate(&mut self) {
        let mut start = 0;
        for end in 1..=self.vectors.len() {
            let far = |k: usize| self.inverses[k - 1].abs() > FAR * self.inverses[k].abs();
            if end == self.vectors.len() || far(end) {
                rotate(self.operator, &mut self.vectors[start..end]);
                start = end;
            }
        }
    }

    /// Eigenvalues as Rayleigh quotients; but as σ + 1/μ where the rounding of the shape spoils the
    /// quotient, as that of very stiff systems does.
    fn pairs(self, next: Option<f64>) -> Vec<Pair> {
        const U: f64 = f64::EPSILON;
        let pencil = self.operator.pencil;
        let (stiffness, mass, shift) = (&pencil.stiffness, &pencil.mass, self.operator.shift);
        let diagonal = stiffness.diagonal();
        let errors: Vec<f64> = (0..self.vectors.len())
            .map(|k| relative_error(k, &self.inverses, &self.residuals, next))
            .collect();
        let all = self.vectors.into_iter().zip(self.inverses).zip(errors);
        all.map(|((shape, inverse), part)| {
            let norm = mass.quadratic(&shape);
            let quotient = stiffness.quadratic(&shape) / norm;
            let terms = shape.iter().zip(&diagonal);
            let noise: f64 = terms.map(|(x, k)| k.abs() * x * x).sum::<f64>() * U * U / norm;
            let distance = (quotient - shift).abs();
            let of_quotient = 2.0 * part * distance + noise + 4.0 * U * quotient.abs();
            let inverted = shift + 1.0 / inverse;
            let of_inverted = 2.0 * (part + self.doubt + 4.0 * U) * distance
                + 4.0 * U * (shift.abs() + inverted.abs());
            let (square, error) = if of_quotient <= 2.0 * of_inverted {
                (quotient, of_quotient)
            } else {
                (inverted, of_inverted)
            };
            Pair {
                square,
                shape,
                error: (part <= SMALL && error.is_finite()).then_some(error),
            }
        })
        .collect()
    }
}

/// Rotates vectors to the eigenvectors of the pencil in their span, with all forms summed over the
/// elements.
fn rotate(operator: &ShiftInvert<'_>, shapes: &mut [Vec<f64>]) {
    let (stiffness, mass) = (&operator.pencil.stiffness, &operator.pencil.mass);
    let count = shapes.len();
    let form = |i: usize, j: usize| {
        let mass = mass.bilinear(&shapes[i], &shapes[j]);
        (
            stiffness.bilinear(&shapes[i], &shapes[j]) - operator.shift * mass,
            mass,
        )
    };
    let mut k = Mat::<f64>::zeros(count, count);
    let mut m = Mat::<f64>::zeros(count, count);
    for j in 0..count {
        for i in 0..=j {
            (k[(i, j)], m[(i, j)]) = form(i, j);
            (k[(j, i)], m[(j, i)]) = (k[(i, j)], m[(i, j)]);
        }
    }
    // Scaled to a unit diagonal, which keeps the digits of the small ones.
    let scale: Vec<f64> = (0..count).map(|i| k[(i, i)].abs().sqrt().recip()).collect();
    let scaled = |a: &Mat<f64>| Mat::from_fn(count, count, |i, j| a[(i, j)] * scale[i] * scale[j]);
    let (k, m) = (scaled(&k), scaled(&m));
    let Ok(factor) = m.llt(Side::Lower) else {
        return;
    };
    let lower = factor.L();
    let mut reduced = k.clone();
    faer::linalg::triangular_solve::solve_lower_triangular_in_place(
        lower,
        reduced.as_mut(),
        faer::Par::Seq,
    );
    let mut reduced = reduced.transpose().to_owned();
    faer::linalg::triangular_solve::solve_lower_triangular_in_place(
        lower,
        reduced.as_mut(),
        faer::Par::Seq,
    );
    let Ok(eigen) = reduced.self_adjoint_eigen(Side::Lower) else {
        return;
    };
    let mut vectors = eigen.U().to_owned();
    faer::linalg::triangular_solve::solve_upper_triangular_in_place(
        lower.transpose(),
        vectors.as_mut(),
        faer::Par::Seq,
    );
    let value = |k: &usize| eigen.S()[*k].abs();
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|a, b| value(a).total_cmp(&value(b)));
    let factors = Mat::from_fn(count, count, |i, j| vectors[(i, order[j])] * scale[i]);
    if factors.norm_max().is_finite() {
        combine(shapes, factors.as_ref());
    }
}

/// Of μ_k: ρ, or ρ²/γ where that is less. Values that their residuals do not tell apart are judged
/// together.
fn relative_error(k: usize, inverses: &[f64], residuals: &[f64], next: Option<f64>) -> f64 {
    let own = inverses[k];
    let mut residual = residuals[k] * residuals[k];
    let mut gap = next.map_or(f64::INFINITY, |next| (own - next).abs());
    for (other, size) in inverses.iter().zip(residuals) {
        let apart = (own - other).abs();
        if apart > 4.0 * (residuals[k] * own.abs()).max(size * other.abs()) {
            gap = gap.min(apart);
        } else if size != &residuals[k] {
            residual += size * size;
        }
    }
    let gap = gap / own.abs();
    let residual = residual.sqrt();
    residual.min(residual * residual / gap)
}
