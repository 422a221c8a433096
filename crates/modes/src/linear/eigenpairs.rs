//! Eigenvalues of a balanced real matrix with right and left vectors.

use eigentone_digits::{Lu, real_eigen};
use faer::{Mat, MatRef};
use num_complex::Complex;

use crate::linear::balance::{Balanced, balance};
use crate::linear::small::{self, Eigenpairs, Unit};

/// Up to so many states the routines for small matrices are the quicker ones.
const SMALL: usize = 48;

/// All eigenvalues of a square real matrix in doubles, in no order, those of a conjugate pair beside each other; `None` where the
/// matrix is not square, an entry or an eigenvalue is not finite, or the iteration does not converge.
///
/// ```
/// let turn = faer::mat![[0.0, 2.0], [-2.0, 0.0]];
/// let roots = eigentone_modes::eigenvalues(turn.as_ref()).expect("it is finite");
/// assert!(roots.iter().all(|root| (root.im.abs() - 2.0).abs() < 1e-15 && root.re.abs() < 1e-15));
/// ```
pub fn eigenvalues(matrix: MatRef<'_, f64>) -> Option<Vec<Complex<f64>>> {
    let n = matrix.nrows();
    let columns = || matrix.col_iter().flat_map(|column| column.iter().copied());
    if matrix.ncols() != n || !columns().all(f64::is_finite) {
        return None;
    }
    if n <= SMALL {
        let mut roots = vec![Complex::ZERO; n];
        let found = small::eigenvalues(&mut columns().collect::<Vec<f64>>(), n, &mut roots);
        return found.map(|()| roots);
    }
    let mut balanced = balance(matrix).matrix;
    let largest = balanced.norm_max();
    let unit = Unit::of(largest);
    for column in balanced.col_iter_mut() {
        column
            .iter_mut()
            .for_each(|entry| *entry = unit.divide(*entry));
    }
    let roots = eigentone_digits::eigenvalues(balanced.as_ref())?.into_iter();
    let roots = roots.map(|root| Complex::new(unit.multiply(root.re), unit.multiply(root.im)));
    let roots: Vec<Complex<f64>> = roots.collect();
    roots.iter().all(|root| root.is_finite()).then_some(roots)
}

/// The eigenvalues, one of each conjugate pair, with their vectors; `None` where the iteration does not converge.
pub(crate) fn eigenpairs(balanced: &Balanced, with_left: bool) -> Option<Eigenpairs> {
    let matrix = balanced.matrix.as_ref();
    let n = matrix.nrows();
    let quick = || {
        let entries: Vec<f64> = matrix
            .col_iter()
            .flat_map(|column| column.iter().copied())
            .collect();
        small::eigenpairs(&entries, n, with_left)
    };
    (n <= SMALL)
        .then(quick)
        .flatten()
        .or_else(|| by_schur_form(matrix, with_left))
}

/// By the QR algorithm and substitution in the Schur form.
fn by_schur_form(a: MatRef<'_, f64>, with_left: bool) -> Option<Eigenpairs> {
    let n = a.nrows();
    let found = real_eigen(a, with_left)?;

    // The columns that begin a pair, or are real.
    let mut firsts = Vec::with_capacity(n);
    let mut j = 0;
    while j < n {
        let pair = found.values[j].im != 0.0 && j + 1 < n;
        firsts.push((j, pair));
        j += if pair { 2 } else { 1 };
    }
    let vectors = |vectors: &Mat<f64>| -> Vec<Vec<Complex<f64>>> {
        let vector = |(j, pair): &(usize, bool)| {
            let im = |i| if *pair { vectors[(i, j + 1)] } else { 0.0 };
            (0..n)
                .map(|i| Complex::new(vectors[(i, *j)], im(i)))
                .collect()
        };
        firsts.iter().map(vector).collect()
    };
    let value = |(j, _): &(usize, bool)| found.values[*j];
    let values: Vec<Complex<f64>> = firsts.iter().map(value).collect();
    let mut right = vectors(&found.right);
    for (value, z) in values.iter().zip(&mut right) {
        if !is_direction(z) {
            *z = by_inverse_iteration(a, *value);
        }
    }
    Some(Eigenpairs {
        values,
        right,
        left: found.left.as_ref().map(vectors),
    })
}

/// The vector of a root, by inverse iteration: where roots coincide, the substitution that follows the QR algorithm
/// may divide by 0. Half of the digits away from the root no pivot vanishes, not even that of a Jordan block, whose
/// vector is known to no more.
fn by_inverse_iteration(a: MatRef<'_, f64>, value: Complex<f64>) -> Vec<Complex<f64>> {
    let n = a.nrows();
    let shift = value + Complex::from(f64::EPSILON.sqrt() * a.norm_l2());
    let shifted = Mat::from_fn(n, n, |i, j| {
        let own = if i == j { shift } else { Complex::ZERO };
        Complex::from(a[(i, j)]) - own
    });
    let factors = Lu::of(shifted.as_ref());
    let mut z = Mat::from_fn(n, 1, |_, _| Complex::from(1.0));
    for _ in 0..3 {
        let next = factors.solve(z);
        let largest = next.norm_max();
        z = Mat::from_fn(n, 1, |i, _| next[(i, 0)] / largest);
    }
    (0..n).map(|i| z[(i, 0)]).collect()
}

/// Whether a vector is finite and not 0.
pub(crate) fn is_direction(vector: &[Complex<f64>]) -> bool {
    let size: f64 = vector.iter().map(Complex::l1_norm).sum();
    size.is_finite() && size > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One vector for a root that is there twice, and its own for another.
    #[test]
    fn a_jordan_block_has_its_one_vector() {
        let a = faer::mat![[-1.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -3.0]];
        for (value, own) in [(-1.0, 0), (-3.0, 2)] {
            let vector = by_inverse_iteration(a.as_ref(), Complex::from(value));
            assert_eq!(vector.len(), 3);
            for (i, entry) in vector.iter().enumerate() {
                let share = entry.norm() / vector[own].norm();
                assert!(i == own || share < 1e-6, "{value}: {share:e}");
            }
        }
    }

    /// s(1 ± i) for matrices of any size, by either routine, and what has none.
    #[test]
    fn eigenvalues_of_very_large_and_very_small_matrices() {
        for size in [1e308, 1e155, 1.0, 1e-165, 1e-300, 1e-320] {
            for n in [2, 3, 4, 2 * SMALL] {
                let turn = [[1.0, 1.0], [-1.0, 1.0]];
                let matrix = Mat::from_fn(n, n, |i, j| match i / 2 == j / 2 {
                    true => size * turn[i % 2][j % 2],
                    false => 0.0,
                });
                let roots = eigenvalues(matrix.as_ref()).expect("it converges");
                assert_eq!(roots.len(), n);
                let even = &roots.iter().filter(|root| root.im != 0.0);
                assert_eq!(even.clone().count(), n - n % 2, "{size:e} {n}: {roots:?}");
                for root in even.clone() {
                    let parts = [root.re / size, root.im.abs() / size];
                    let near = parts.iter().all(|part| (part - 1.0).abs() < 1e-3);
                    assert!(near, "{size:e} {n}: {root}");
                }
            }
        }
        // 1e300 and 1e-300 leave a root of 1 and −1.
        let wide = faer::mat![[0.0, 1e300], [1e-300, 0.0]];
        let roots = eigenvalues(wide.as_ref()).expect("it converges");
        assert!(
            roots
                .iter()
                .all(|root| (root.re.abs() - 1.0).abs() < 1e-14 && root.im == 0.0)
        );
        // The sum of two of the largest doubles is none.
        assert_eq!(eigenvalues(Mat::full(2, 2, f64::MAX).as_ref()), None);
        for (rows, columns) in [(2, 3), (3, 2), (0, 1), (60, 59)] {
            assert_eq!(eigenvalues(Mat::zeros(rows, columns).as_ref()), None);
        }
        assert_eq!(eigenvalues(Mat::zeros(0, 0).as_ref()), Some(Vec::new()));
    }

    #[test]
    fn what_is_0_or_not_finite_points_nowhere() {
        let points = |parts: [f64; 2]| is_direction(&parts.map(Complex::from));
        assert!(points([0.0, -1e-300]));
        for nowhere in [0.0, f64::NAN, f64::INFINITY] {
            assert!(!points([0.0, nowhere]));
        }
    }
}
