//! Energy coordinates: in them the square of a state's length is twice its energy, so that a passive
//! system never lengthens an error.

use eigentone_digits::{BallMatrix, Magnitude, Real};
use eigentone_modes::EnclosedFirstOrder;

/// A change of coordinates ζ = R z, and Y ≈ R⁻¹. Both are taken exactly as they are; what R is good
/// for does not touch what is proved with it.
#[derive(Clone, Debug)]
pub(crate) struct Energy<T> {
    pub(crate) r: BallMatrix<T>,
    pub(crate) y: BallMatrix<T>,
    /// A bound of ‖RY − I‖, below 1/2.
    pub(crate) defect: Magnitude,
}

impl<T: Real> Energy<T> {
    /// R = diag(Lᵀ, M^{1/2}) with LLᵀ = K, or K + σM where K is not positive definite; `rate` = √σ in
    /// 1/s is the growth that a motion without restoring force is allowed, tried first where `supported`
    /// is false. `None` where the digits do not suffice.
    pub(crate) fn of(
        form: &EnclosedFirstOrder<T>,
        supported: bool,
        rate: f64,
    ) -> Option<Energy<T>> {
        let n = form.states();
        let nf = form.massive().len();
        let mass = symmetric_part(form.mass());
        let velocity = cholesky(nf, &mass).unwrap_or_else(|| diagonal_root(nf, &mass));
        let potential = potential(form, &mass, supported, rate);
        // The coordinates with mass come first in z, then their velocities, then the relaxing ones.
        let place = |i: usize| if i < nf { i } else { nf + i };
        let mut r = BallMatrix::zeros(n, n);
        let mut y = BallMatrix::zeros(n, n);
        let mut put = |upper: &[T], size: usize, place: &dyn Fn(usize) -> usize| {
            let inverse = upper_inverse(size, upper);
            for i in 0..size {
                for j in i..size {
                    let (at, to) = (i * size + j, (place(i), place(j)));
                    r.set(to.0, to.1, upper[at], Magnitude::ZERO);
                    y.set(to.0, to.1, inverse[at], Magnitude::ZERO);
                }
            }
        };
        put(&potential, n - nf, &place);
        put(&velocity, nf, &|i| nf + i);
        let residual = BallMatrix::identity(n).plus(&r.times(&y).negated());
        let defect = frobenius(&residual);
        (defect.to_f64() < 0.25).then_some(Energy { r, y, defect })
    }
}

/// An upper triangular U with UᵀU ≈ K, or K + σM for the least σ tried that allows it.
fn potential<T: Real>(
    form: &EnclosedFirstOrder<T>,
    mass: &[T],
    supported: bool,
    rate: f64,
) -> Vec<T> {
    let nf = form.massive().len();
    let size = form.states() - nf;
    let stiffness = symmetric_part(form.stiffness());
    // Relaxing coordinates have no mass of their own: they count as the heaviest.
    let inertia = |i: usize| {
        if i < nf {
            mass[i * nf + i].abs()
        } else {
            T::ZERO
        }
    };
    let heaviest = (0..nf).map(inertia).fold(T::ZERO, larger);
    let inertia = |i: usize| {
        let own = inertia(i);
        if !own.is_zero() {
            own
        } else if !heaviest.is_zero() {
            heaviest
        } else {
            T::ONE
        }
    };
    let square = T::from(rate) * T::from(rate);
    let mut shift = if supported { T::ZERO } else { square };
    for _ in 0..600 {
        let mut shifted = stiffness.clone();
        for i in 0..size {
            shifted[i * size + i] = shifted[i * size + i] + shift * inertia(i);
        }
        if let Some(upper) = cholesky(size, &shifted) {
            return upper;
        }
        shift = if shift.is_zero() {
            square
        } else {
            shift.scale(3)
        };
    }
    diagonal_root(size, &stiffness)
}

fn larger<T: Real>(a: T, b: T) -> T {
    if a < b { b } else { a }
}

/// ½(A + Aᵀ), from the middles.
fn symmetric_part<T: Real>(a: &BallMatrix<T>) -> Vec<T> {
    let n = a.rows();
    let entry = |at: usize| (a.middle(at / n, at % n) + a.middle(at % n, at / n)).scale(-1);
    (0..n * n).map(entry).collect()
}

/// U upper triangular with UᵀU ≈ A; `None` unless every pivot is positive.
fn cholesky<T: Real>(n: usize, a: &[T]) -> Option<Vec<T>> {
    let mut u = vec![T::ZERO; n * n];
    for i in 0..n {
        for j in i..n {
            let mut sum = a[i * n + j];
            for k in 0..i {
                let (left, right) = (u[k * n + i], u[k * n + j]);
                if !left.is_zero() && !right.is_zero() {
                    sum = sum - left * right;
                }
            }
            if i == j {
                let root = sum.sqrt();
                // What is left of a pivot after all its digits cancelled is no pivot.
                let digits = a[i * n + i].magnitude() * T::unit() * Magnitude::from(1024.0);
                if !(sum > T::ZERO && root.is_finite()) || sum.magnitude() < digits {
                    return None;
                }
                u[i * n + i] = root;
            } else {
                u[i * n + j] = sum / u[i * n + i];
            }
        }
    }
    Some(u)
}

/// The roots of the sizes on the diagonal; 1 where there is nothing.
fn diagonal_root<T: Real>(n: usize, a: &[T]) -> Vec<T> {
    let mut u = vec![T::ZERO; n * n];
    for i in 0..n {
        let size = a[i * n + i].abs();
        let root = size.sqrt();
        u[i * n + i] = if size.is_zero() || !root.is_finite() {
            T::ONE
        } else {
            root
        };
    }
    u
}

/// U⁻¹, about.
fn upper_inverse<T: Real>(n: usize, u: &[T]) -> Vec<T> {
    let mut inverse = vec![T::ZERO; n * n];
    for j in 0..n {
        for i in (0..=j).rev() {
            let mut sum = if i == j { T::ONE } else { T::ZERO };
            for k in i + 1..=j {
                let (left, right) = (u[i * n + k], inverse[k * n + j]);
                if !left.is_zero() && !right.is_zero() {
                    sum = sum - left * right;
                }
            }
            inverse[i * n + j] = sum / u[i * n + i];
        }
    }
    inverse
}

/// An upper bound of the Frobenius norm of all matrices held.
pub(crate) fn frobenius<T: Real>(matrix: &BallMatrix<T>) -> Magnitude {
    let mut sum = Magnitude::ZERO;
    for i in 0..matrix.rows() {
        for j in 0..matrix.columns() {
            let size = matrix.middle(i, j).upper() + matrix.radius(i, j);
            sum = sum + size * size;
        }
    }
    sum.sqrt()
}
