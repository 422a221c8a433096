//! Eigenvalues and eigenvectors of a symmetric matrix; of one that some order of its coordinates
//! makes tridiagonal, as that of a chain, without the reduction to such a form.
//!
//! Any other is reduced by [reflections](crate::reflections).

use faer::linalg::evd::SelfAdjointEvdParams;
use faer::{Auto, Mat, Spec};

use crate::reflections::Reduced;
use crate::{Cholesky, tridiagonal};

/// All eigenvalues, rising, with their vectors, column by column; from the lower half of the matrix.
/// `None` where an entry is not finite or the iteration does not converge. Implicit QR steps (Golub & Van Loan, §8.3) leave most digits
/// of small eigenvalues of graded matrices.
pub fn symmetric_eigen(matrix: &Mat<f64>) -> Option<(Vec<f64>, Mat<f64>)> {
    eigen(matrix, usize::MAX)
}

/// The same by divide and conquer, several times as quick from some hundred rows on, with errors that are small against the
/// largest eigenvalue alone.
pub fn quick_symmetric_eigen(matrix: &Mat<f64>) -> Option<(Vec<f64>, Mat<f64>)> {
    eigen(matrix, tridiagonal::LEAF)
}

type Solver = fn(&Mat<f64>) -> Option<(Vec<f64>, Mat<f64>)>;

/// By implicit QR steps up to so many rows.
fn eigen(matrix: &Mat<f64>, leaf: usize) -> Option<(Vec<f64>, Mat<f64>)> {
    let n = matrix.nrows();
    let Some(path) = path(matrix) else {
        return whole(matrix, leaf);
    };
    let diagonal: Vec<f64> = path.iter().map(|i| matrix[(*i, *i)]).collect();
    let below = |pair: &[usize]| matrix[(pair[0].max(pair[1]), pair[0].min(pair[1]))];
    let below: Vec<f64> = path.windows(2).map(below).collect();
    let (values, mut vectors) = tridiagonal::eigen(&diagonal, &below, leaf)?;
    if path.iter().enumerate().any(|(place, i)| place != *i) {
        let mut place = vec![0; n];
        for (at, &i) in path.iter().enumerate() {
            place[i] = at;
        }
        vectors = Mat::from_fn(n, n, |i, j| vectors[(place[i], j)]);
    }
    Some((values, vectors))
}

/// All eigenvalues, rising; `None` as for [`symmetric_eigen`].
pub fn symmetric_eigenvalues(matrix: &Mat<f64>) -> Option<Vec<f64>> {
    let reduced = Reduced::of(matrix);
    tridiagonal::eigenvalues(&reduced.diagonal, &reduced.below)
}

/// Of a matrix of two rows or more that no order makes tridiagonal.
fn whole(matrix: &Mat<f64>, leaf: usize) -> Option<(Vec<f64>, Mat<f64>)> {
    let reduced = Reduced::of(matrix);
    let (values, mut vectors) = tridiagonal::eigen(&reduced.diagonal, &reduced.below, leaf)?;
    reduced.apply(vectors.as_mut());
    Some((values, vectors))
}

/// All λ with Ax = λBx, rising, with their vectors, for a symmetric A and a positive definite B: those of L⁻¹AL⁻ᵀ with
/// B = LLᵀ (Golub & Van Loan, §8.7). `None` where B has no such factor, or numbers leave their range.
pub fn definite_eigen(a: &Mat<f64>, b: &Mat<f64>) -> Option<(Vec<f64>, Mat<f64>)> {
    definite(a, b, symmetric_eigen)
}

/// The same by [`quick_symmetric_eigen`].
pub fn quick_definite_eigen(a: &Mat<f64>, b: &Mat<f64>) -> Option<(Vec<f64>, Mat<f64>)> {
    definite(a, b, quick_symmetric_eigen)
}

fn definite(a: &Mat<f64>, b: &Mat<f64>, solve: Solver) -> Option<(Vec<f64>, Mat<f64>)> {
    let factor = Cholesky::of(b.as_ref())?;
    let mut symmetric = a.to_owned();
    factor.divide_by_lower(symmetric.as_mut());
    factor.divide_by_lower(symmetric.as_mut().transpose_mut());
    let (values, mut vectors) = solve(&symmetric)?;
    factor.divide_by_upper(vectors.as_mut());
    Some((values, vectors))
}

/// faer's implicit QR steps at every size, in place of its divide and conquer, which errs by 1e-12 to 1e-11 of the largest
/// eigenvalue, and of some graded matrices by 1e-3 (0.24.4).
pub(crate) fn implicit_steps() -> Spec<SelfAdjointEvdParams, f64> {
    let chosen = <SelfAdjointEvdParams as Auto<f64>>::auto();
    Spec::new(SelfAdjointEvdParams {
        recursion_threshold: usize::MAX,
        ..chosen
    })
}

/// An order of the coordinates in which the matrix is tridiagonal: along its paths, if it is made of
/// paths.
fn path(matrix: &Mat<f64>) -> Option<Vec<usize>> {
    let n = matrix.nrows();
    let mut neighbours = vec![[None; 2]; n];
    let mut add = |i: usize, j: usize| {
        let free = neighbours[i].iter_mut().find(|place| place.is_none())?;
        *free = Some(j);
        Some(())
    };
    for j in 0..n {
        for i in j + 1..n {
            if matrix[(i, j)] != 0.0 {
                add(i, j)?;
                add(j, i)?;
            }
        }
    }
    let mut order = Vec::with_capacity(n);
    let mut seen = vec![false; n];
    for end in (0..n).filter(|i| neighbours[*i][1].is_none()) {
        let mut at = (!seen[end]).then_some(end);
        while let Some(i) = at {
            seen[i] = true;
            order.push(i);
            let next = neighbours[i].iter().flatten().find(|j| !seen[**j]);
            at = next.copied();
        }
    }
    // A ring has no end.
    (order.len() == n).then_some(order)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A·V − V·Λ and VᵀV − I, relative.
    fn residuals(matrix: &Mat<f64>) -> f64 {
        let of = [symmetric_eigen, quick_symmetric_eigen].map(|solve| residuals_of(matrix, solve));
        let (expected, _) = symmetric_eigen(matrix).unwrap();
        let found = symmetric_eigenvalues(matrix).unwrap();
        let off = found.iter().zip(&expected).map(|(a, b)| (a - b).abs());
        let apart = off.fold(0.0, f64::max);
        assert!(apart <= 1e-15 * (matrix.nrows() as f64) * matrix.norm_max());
        of[0].max(of[1])
    }

    fn residuals_of(matrix: &Mat<f64>, solve: Solver) -> f64 {
        let n = matrix.nrows();
        let (values, vectors) = solve(matrix).unwrap();
        assert!(values.is_sorted());
        let scaled = Mat::from_fn(n, n, |i, j| vectors[(i, j)] * values[j]);
        let symmetric = Mat::from_fn(n, n, |i, j| matrix[(i.max(j), i.min(j))]);
        let off = (&symmetric * &vectors - scaled).norm_max() / symmetric.norm_max();
        let apart = (vectors.transpose() * &vectors - Mat::<f64>::identity(n, n)).norm_max();
        off.max(apart)
    }

    /// A·V − B·V·Λ and VᵀBV − I; and what has no Cholesky factor.
    #[test]
    fn definite_pencils_are_solved() {
        for n in [1, 2, 7, 50, 130] {
            let entry = |i: usize, j: usize| ((7 * i + 3 * j + i * j) % 11) as f64 - 5.0;
            let factor = Mat::from_fn(n, n, entry);
            let a = Mat::from_fn(n, n, |i, j| entry(i.max(j), i.min(j)));
            let b = factor.transpose() * &factor + Mat::<f64>::identity(n, n);
            let (values, vectors) = definite_eigen(&a, &b).expect("it is definite");
            assert!(values.is_sorted());
            let by_mass = &b * &vectors;
            let scaled = Mat::from_fn(n, n, |i, j| by_mass[(i, j)] * values[j]);
            let apart = vectors.transpose() * &by_mass - Mat::<f64>::identity(n, n);
            // No eigenvalue of B is below 1.
            let rounding = 4.0 * f64::EPSILON * b.norm_l2();
            assert!(
                (&a * &vectors - scaled).norm_max() <= rounding * (1.0 + a.norm_l2()),
                "{n}"
            );
            assert!(apart.norm_max() <= rounding, "{n}");
            assert!(definite_eigen(&a, &-&b).is_none());
            assert!(definite_eigen(&a, &(&b * faer::Scale(0.0))).is_none());
        }
    }

    /// Chains whose masses are numbered out of order, alone and two side by side, a ring and a star.
    #[test]
    fn paths_and_others_are_solved_alike() {
        assert_eq!(symmetric_eigenvalues(&Mat::zeros(0, 0)), Some(Vec::new()));
        for n in [1, 2, 3, 7, 40, 90, 150, 260] {
            let at = |place: usize| (place * 37 + 11) % n;
            let joined = |pairs: &[(usize, usize)]| {
                let mut matrix = Mat::<f64>::zeros(n, n);
                for (step, (a, b)) in pairs.iter().enumerate() {
                    let k = 1.0 + 0.5 * (step % 3) as f64;
                    matrix[(*a, *a)] += k;
                    matrix[(*b, *b)] += k;
                    matrix[(*a.max(b), *a.min(b))] -= k;
                }
                matrix
            };
            let coprime = n % 37 != 0;
            assert!(coprime);
            let chain: Vec<_> = (1..n).map(|place| (at(place - 1), at(place))).collect();
            let halves: Vec<_> = chain.iter().copied().filter(|(a, _)| *a != 0).collect();
            let star: Vec<_> = (1..n).map(|i| (0, i)).collect();
            for pairs in [&chain, &halves, &star] {
                assert!(residuals(&joined(pairs)) <= 1e-15 * (n as f64), "{n}");
            }
            if n > 2 {
                let mut ring = chain.clone();
                ring.push((at(n - 1), at(0)));
                let matrix = joined(&ring);
                assert!(path(&matrix).is_none());
                assert!(residuals(&matrix) <= 1e-14 * (n as f64), "{n}");
                assert!(path(&joined(&chain)).is_some());
            }
        }
    }
}
