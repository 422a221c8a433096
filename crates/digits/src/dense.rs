//! Factors, eigenvalues and singular values of full matrices of doubles, by faer.
//!
//! Its routines are generic: each package that calls one compiles it for itself, which takes longer than all else in it. Here they
//! are compiled once for all. What is not finite is refused where an iteration may not end on it, and registers are [settled](settle).

use faer::diag::Diag;
use faer::dyn_stack::MemStack;
use faer::linalg::evd::{self, ComputeEigenvectors};
use faer::linalg::solvers::{DenseSolveCore, Llt, PartialPivLu, SolveCore, Svd};
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::traits::ComplexField;
use faer::{Conj, Mat, MatMut, MatRef, Par, Side, c64};

use crate::{settle, workspace};

/// Doubles, real or complex: the entries of matrices that are factored here.
pub trait Entry: ComplexField<Real = f64> + kernel::Kernel {}

impl Entry for f64 {}
impl Entry for c64 {}

macro_rules! is_finite {
    ($a:ident) => {
        $a.col_iter()
            .all(|column| column.iter().all(|entry| entry.is_finite()))
    };
}

mod kernel {
    use super::*;

    /// What is compiled for each kind of entries.
    pub trait Kernel: Sized {
        fn size(&self) -> f64;
        fn factor(a: MatRef<'_, Self>) -> PartialPivLu<Self>;
        fn solve(factor: &PartialPivLu<Self>, b: MatMut<'_, Self>, transposed: bool, conj: Conj);
        fn inverse(factor: &PartialPivLu<Self>) -> Mat<Self>;
        fn eigen(a: MatRef<'_, Self>) -> Option<(Vec<c64>, Mat<c64>)>;
        fn eigenvalues(a: MatRef<'_, Self>) -> Option<Vec<c64>>;
        fn svd(a: MatRef<'_, Self>, thin: bool) -> Option<Svd<Self>>;
        fn singular_values(a: MatRef<'_, Self>) -> Option<Vec<f64>>;
    }

    macro_rules! kernel {
        ($T:ty, $size:path) => {
            impl Kernel for $T {
                fn size(&self) -> f64 {
                    $size(*self)
                }

                fn factor(a: MatRef<'_, $T>) -> PartialPivLu<$T> {
                    let factor = a.partial_piv_lu();
                    settle();
                    factor
                }

                fn solve(f: &PartialPivLu<$T>, b: MatMut<'_, $T>, transposed: bool, conj: Conj) {
                    match transposed {
                        false => f.solve_in_place_with_conj(conj, b),
                        true => f.solve_transpose_in_place_with_conj(conj, b),
                    }
                    settle();
                }

                fn inverse(factor: &PartialPivLu<$T>) -> Mat<$T> {
                    let inverse = factor.inverse();
                    settle();
                    inverse
                }

                fn eigen(a: MatRef<'_, $T>) -> Option<(Vec<c64>, Mat<c64>)> {
                    let eigen = is_finite!(a).then(|| a.eigen().ok())?;
                    settle();
                    let eigen = eigen?;
                    let values = eigen.S().column_vector().iter().copied().collect();
                    Some((values, eigen.U().to_owned()))
                }

                fn eigenvalues(a: MatRef<'_, $T>) -> Option<Vec<c64>> {
                    let values = is_finite!(a).then(|| a.eigenvalues().ok())?;
                    settle();
                    values
                }

                fn svd(a: MatRef<'_, $T>, thin: bool) -> Option<Svd<$T>> {
                    let decompose = if thin { Svd::new_thin } else { Svd::new };
                    let svd = is_finite!(a).then(|| decompose(a).ok())?;
                    settle();
                    svd
                }

                fn singular_values(a: MatRef<'_, $T>) -> Option<Vec<f64>> {
                    let values = is_finite!(a).then(|| a.singular_values().ok())?;
                    settle();
                    values
                }
            }
        };
    }

    kernel!(f64, f64::abs);
    kernel!(c64, c64::norm);
}

/// PA = LU of a square matrix, with partial pivoting. Nothing is refused: where A is singular, solutions are not finite.
///
/// ```
/// let a = faer::mat![[0.0, 2.0], [4.0, 0.0]];
/// let x = eigentone_digits::Lu::of(a.as_ref()).solve(faer::mat![[2.0], [8.0]]);
/// assert_eq!(x, faer::mat![[2.0], [1.0]]);
/// ```
#[derive(Clone, Debug)]
pub struct Lu<T: Entry>(PartialPivLu<T>);

impl<T: Entry> Lu<T> {
    /// The factors of a square matrix.
    pub fn of(a: MatRef<'_, T>) -> Lu<T> {
        Lu(T::factor(a))
    }

    /// The factors, unless a pivot is 0 or not finite.
    pub fn regular(a: MatRef<'_, T>) -> Option<Lu<T>> {
        let factor = Lu::of(a);
        let is_regular = |pivot: f64| pivot != 0.0 && pivot.is_finite();
        let regular = factor.pivots().all(is_regular);
        regular.then_some(factor)
    }

    /// The sizes of the pivots: their product is that of the determinant.
    pub fn pivots(&self) -> impl Iterator<Item = f64> {
        let u = self.0.U();
        (0..u.nrows()).map(move |i| u[(i, i)].size())
    }

    /// X with AX = B, in the place of B.
    pub fn solve(&self, mut b: Mat<T>) -> Mat<T> {
        self.solve_in_place(b.as_mut());
        b
    }

    /// B becomes X with AX = B.
    pub fn solve_in_place(&self, b: MatMut<'_, T>) {
        T::solve(&self.0, b, false, Conj::No);
    }

    /// B becomes X with AᵀX = B.
    pub fn solve_transpose_in_place(&self, b: MatMut<'_, T>) {
        T::solve(&self.0, b, true, Conj::No);
    }

    /// X with A*X = B, in the place of B.
    pub fn solve_adjoint(&self, mut b: Mat<T>) -> Mat<T> {
        T::solve(&self.0, b.as_mut(), true, Conj::Yes);
        b
    }

    /// A⁻¹.
    pub fn inverse(&self) -> Mat<T> {
        T::inverse(&self.0)
    }
}

/// The eigenvalues of a real matrix with vectors. Those of a conjugate pair are next to each other, Im λ > 0 first, and their columns
/// hold the real and the imaginary parts of the vectors of the first.
#[derive(Clone, Debug)]
pub struct RealEigen {
    /// λ.
    pub values: Vec<c64>,
    /// x with Ax = λx.
    pub right: Mat<f64>,
    /// y with y*A = λy*, where they were asked for.
    pub left: Option<Mat<f64>>,
}

/// By the QR algorithm and substitution in the Schur form, which may leave a vector that is 0 or not finite where roots coincide.
/// `None` as for [`eigen`].
pub fn real_eigen(a: MatRef<'_, f64>, with_left: bool) -> Option<RealEigen> {
    let n = a.nrows();
    let wanted = |yes| match yes {
        true => ComputeEigenvectors::Yes,
        false => ComputeEigenvectors::No,
    };
    if !is_finite!(a) {
        return None;
    }
    let (mut right, mut left) = (Mat::<f64>::zeros(n, n), Mat::<f64>::zeros(n, n));
    let (mut re, mut im) = (Diag::<f64>::zeros(n), Diag::<f64>::zeros(n));
    let scratch = evd::evd_scratch::<f64>(
        n,
        wanted(with_left),
        wanted(true),
        Par::Seq,
        Default::default(),
    );
    let done = evd::evd_real(
        a,
        re.as_mut(),
        im.as_mut(),
        with_left.then_some(left.as_mut()),
        Some(right.as_mut()),
        Par::Seq,
        MemStack::new(&mut workspace(scratch)),
        Default::default(),
    );
    settle();
    done.ok()?;
    Some(RealEigen {
        values: (0..n).map(|j| c64::new(re[j], im[j])).collect(),
        right,
        left: with_left.then_some(left),
    })
}

/// All eigenvalues of a square matrix with right eigenvectors, column by column; `None` where an entry is not finite, or the iteration
/// does not converge. Nothing is balanced.
pub fn eigen<T: Entry>(a: MatRef<'_, T>) -> Option<(Vec<c64>, Mat<c64>)> {
    T::eigen(a)
}

/// All eigenvalues of a square matrix; `None` as for [`eigen`].
pub fn eigenvalues<T: Entry>(a: MatRef<'_, T>) -> Option<Vec<c64>> {
    T::eigenvalues(a)
}

/// A = UΣV*, with square U and V; `None` as for [`eigen`].
pub fn svd<T: Entry>(a: MatRef<'_, T>) -> Option<Svd<T>> {
    T::svd(a, false)
}

/// The same with as many columns of U and V as there are singular values.
pub fn thin_svd<T: Entry>(a: MatRef<'_, T>) -> Option<Svd<T>> {
    T::svd(a, true)
}

/// All singular values, falling; `None` as for [`eigen`].
pub fn singular_values<T: Entry>(a: MatRef<'_, T>) -> Option<Vec<f64>> {
    T::singular_values(a)
}

/// A = LLᵀ of a symmetric positive definite matrix, of which the lower half is read.
#[derive(Clone, Debug)]
pub struct Cholesky(Llt<f64>);

impl Cholesky {
    /// `None` where A has no such factor in doubles.
    pub fn of(a: MatRef<'_, f64>) -> Option<Cholesky> {
        let factor = a.llt(Side::Lower).ok();
        settle();
        factor.map(Cholesky)
    }

    /// B becomes L⁻¹B.
    pub fn divide_by_lower(&self, b: MatMut<'_, f64>) {
        solve_lower_triangular_in_place(self.0.L(), b, Par::Seq);
        settle();
    }

    /// B becomes L⁻ᵀB.
    pub fn divide_by_upper(&self, b: MatMut<'_, f64>) {
        solve_upper_triangular_in_place(self.0.L().transpose(), b, Par::Seq);
        settle();
    }

    /// A⁻¹.
    pub fn inverse(&self) -> Mat<f64> {
        let inverse = self.0.inverse();
        settle();
        inverse
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whole numbers, of which products are exact.
    fn matrix(n: usize) -> Mat<f64> {
        Mat::from_fn(n, n, |i, j| {
            ((7 * i + 3 * j + i * j) % 11) as f64 - if i == j { 40.0 } else { 5.0 }
        })
    }

    fn turned(n: usize) -> Mat<c64> {
        let plain = matrix(n);
        Mat::from_fn(n, n, |i, j| c64::new(plain[(i, j)], plain[(j, n - 1 - i)]))
    }

    #[test]
    fn equations_are_solved_from_every_side() {
        for n in [1, 2, 5, 40] {
            let a = turned(n);
            let x = Mat::from_fn(n, 2, |i, j| c64::new(i as f64 - 3.0, j as f64 + 1.0));
            let factor = Lu::regular(a.as_ref()).expect("its diagonal is large");
            let near = |found: Mat<c64>| assert!((found - &x).norm_max() <= 1e-12 * n as f64);
            near(factor.solve(&a * &x));
            near(factor.solve_adjoint(a.adjoint() * &x));
            let mut transposed = a.transpose() * &x;
            factor.solve_transpose_in_place(transposed.as_mut());
            near(transposed);
            near(factor.inverse() * (&a * &x));
            let real = matrix(n);
            let size = Lu::of(real.as_ref()).pivots().product::<f64>();
            assert!((size / real.determinant().abs() - 1.0).abs() < 1e-12);
        }
        let singular = faer::mat![[1.0, 2.0], [2.0, 4.0]];
        assert!(Lu::regular(singular.as_ref()).is_none());
    }

    /// AX = XΛ and Y*A = ΛY*.
    #[test]
    fn eigenvectors_are_of_their_values() {
        for n in [1, 2, 5, 40] {
            let (a, real) = (turned(n), matrix(n));
            let as_complex = Mat::from_fn(n, n, |i, j| c64::from(real[(i, j)]));
            for (a, found) in [(&a, eigen(a.as_ref())), (&as_complex, eigen(real.as_ref()))] {
                let (values, x) = found.expect("it is finite");
                let scaled = Mat::from_fn(n, n, |i, j| x[(i, j)] * values[j]);
                assert!((a * &x - scaled).norm_max() <= 1e-11 * x.norm_max());
                let sum: c64 = eigenvalues(a.as_ref()).expect("it is finite").iter().sum();
                let trace: c64 = (0..n).map(|i| a[(i, i)]).sum();
                assert!((sum - trace).norm() <= 1e-12 * (1.0 + trace.norm()));
            }
            let found = real_eigen(real.as_ref(), true).expect("it is finite");
            let y = found.left.expect("asked for");
            for (j, value) in found.values.iter().enumerate().filter(|(_, z)| z.im >= 0.0) {
                let im = |i: usize| if value.im > 0.0 { y[(i, j + 1)] } else { 0.0 };
                let left = Mat::from_fn(1, n, |_, i| c64::new(y[(i, j)], -im(i)));
                let off = &left * &as_complex - &left * faer::Scale(*value);
                assert!(off.norm_max() <= 1e-11 * left.norm_max());
            }
        }
    }

    #[test]
    fn singular_values_are_those_of_the_products() {
        let a = Mat::from_fn(7, 3, |i, j| ((5 * i + 2 * j) % 7) as f64 - 3.0);
        let values = singular_values(a.as_ref()).expect("it is finite");
        let squares = symmetric(a.transpose() * &a);
        for (value, square) in values.iter().rev().zip(squares) {
            assert!((value * value - square).abs() <= 1e-13 * values[0] * values[0]);
        }
        let [whole, thin] = [svd(a.as_ref()), thin_svd(a.as_ref())].map(|svd| svd.expect("finite"));
        assert_eq!((whole.U().ncols(), thin.U().ncols()), (7, 3));
        let again = thin.U() * thin.S() * thin.V().transpose();
        assert!((again - a).norm_max() <= 1e-14 * values[0]);
    }

    fn symmetric(a: Mat<f64>) -> Vec<f64> {
        crate::symmetric_eigenvalues(&a).expect("it converges")
    }

    #[test]
    fn what_is_not_finite_is_refused() {
        for wrong in [f64::NAN, f64::INFINITY] {
            let mut a = matrix(60);
            a[(30, 7)] = wrong;
            let a = a.as_ref();
            assert!(eigen(a).is_none() && eigenvalues(a).is_none() && svd(a).is_none());
            assert!(singular_values(a).is_none() && real_eigen(a, false).is_none());
            assert!(Lu::regular(a).is_none());
        }
    }

    #[test]
    fn definite_matrices_have_a_triangle() {
        let half = matrix(9);
        let a = &half * half.transpose();
        let factor = Cholesky::of(a.as_ref()).expect("it is definite");
        let mut whole = a.clone();
        factor.divide_by_lower(whole.as_mut());
        factor.divide_by_upper(whole.as_mut());
        let one = Mat::<f64>::identity(9, 9);
        assert!((whole - &one).norm_max() < 1e-10);
        assert!((factor.inverse() * a - one).norm_max() < 1e-10);
        assert!(Cholesky::of((-half.transpose() * &half).as_ref()).is_none());
    }
}
