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

/// At most so many steps.
const STEPS: usize = 4;

/// Eigenpairs from the vectors that were found; `next` is the nearest to the shift of all others.
pub(crate) fn refined(
    operator: &ShiftInvert<'_>,
    vectors: Vec<Vector>,
    next: Option<f64>,
) -> Vec<Pair> {
    let (stiffness, mass) = (&operator.pencil.stiffness, &operator.pencil.mass);
    let mut inverses: Vec<f64> = vectors.iter().map(|vector| vector.inverse).collect();
    let mut shapes: Vec<Vec<f64>> = vectors.into_iter().map(|vector| vector.shape).collect();
    let mut residuals = vec![0.0; shapes.len()];
    for step in 0..STEPS {
        let sizes = improve(operator, &mut shapes, &mut inverses);
        residuals = sizes;
        if step + 1 == STEPS || residuals.iter().all(|size| *size <= ROUGH) {
            break;
        }
        separate(operator, &mut shapes);
    }
    let pairs = shapes.into_iter().enumerate();
    pairs
        .map(|(k, shape)| {
            let square = stiffness.quadratic(&shape) / mass.quadratic(&shape);
            let part = relative_error(k, &inverses, &residuals, next);
            let rounding = 4.0 * f64::EPSILON * square.abs();
            let error = 2.0 * part * (square - operator.shift).abs() + rounding;
            Pair {
                square,
                shape,
                error: (part <= SMALL && error.is_finite()).then_some(error),
            }
        })
        .collect()
}

/// Beyond that no error is estimated.
const SMALL: f64 = 1e-3;

/// One refined step of inverse iteration for each shape; ρ of each, as it was before the step.
fn improve(
    operator: &ShiftInvert<'_>,
    shapes: &mut [Vec<f64>],
    inverses: &mut [f64],
) -> Vec<f64> {
    let mass = &operator.pencil.mass;
    let n = operator.pencil.len();
    let (mut product, mut work) = (vec![0.0; n], vec![0.0; n]);
    let mut sizes = Vec::with_capacity(shapes.len());
    for (shape, inverse) in shapes.iter_mut().zip(inverses) {
        let doubt = operator.refined(shape, &mut product, &mut work);
        mass.apply(shape, &mut work);
        *inverse = dot(&work, &product) / dot(&work, shape);
        for (x, y) in shape.iter_mut().zip(&product) {
            *x = y - *inverse * *x;
        }
        let norm = mass.quadratic(&product).sqrt();
        let residual = mass.quadratic(shape).max(0.0).sqrt() / norm;
        // What refinement leaves is smaller than the square of what it corrected.
        sizes.push(residual + doubt * doubt);
        for (x, y) in shape.iter_mut().zip(&product) {
            *x = y / norm;
        }
    }
    sizes
}

/// Rotates the shapes to those of the smallest and largest Rayleigh quotients in their span, with all forms
/// summed over the elements.
fn separate(operator: &ShiftInvert<'_>, shapes: &mut [Vec<f64>]) {
    let (stiffness, mass) = (&operator.pencil.stiffness, &operator.pencil.mass);
    let count = shapes.len();
    let form = |i: usize, j: usize| {
        let mass = mass.bilinear(&shapes[i], &shapes[j]);
        (stiffness.bilinear(&shapes[i], &shapes[j]) - operator.shift * mass, mass)
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
    let factors: Vec<Vec<f64>> = order
        .iter()
        .map(|&j| (0..count).map(|i| vectors[(i, j)] * scale[i]).collect())
        .collect();
    if factors.iter().flatten().all(|factor| factor.is_finite()) {
        combine(shapes, &factors);
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
