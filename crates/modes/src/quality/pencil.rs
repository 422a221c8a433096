//! Q(λ) = λ²M + λC + K applied to shapes, with the norms that scale its residuals.

use std::ops::{Add, AddAssign, Mul};

use eigentone_digits::{DoubleDouble, Lu, product, svd};
use faer::{ColRef, Mat, MatRef};
use num_complex::Complex;

use crate::model::{Element, MatrixKind};
use crate::system::System;

/// M, C, K in doubles with their Frobenius norms.
pub(crate) struct Pencil {
    coefficients: [Coefficient; 3],
    norms: [f64; 3],
}

/// M, C or K.
enum Coefficient {
    Sparse(Sparse),
    Full(Mat<f64>),
}

/// The entries of a matrix that are not zero, column by column.
struct Sparse {
    /// Where each column's entries start, and where the last one's end.
    starts: Vec<usize>,
    rows: Vec<usize>,
    entries: Vec<f64>,
}

/// A double, real or complex.
trait Factor:
    Copy
    + Add<Complex<f64>, Output = Complex<f64>>
    + Mul<Complex<f64>, Output = Complex<f64>>
    + Mul<f64, Output = Self>
    + AddAssign
{
}

impl Factor for f64 {}
impl Factor for Complex<f64> {}

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

/// Up to so many entries plain loops are quicker than a blocked product.
const FEW: usize = 2048;

impl Pencil {
    pub(crate) fn of(system: &System) -> Pencil {
        let kinds = [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness];
        let coefficients = kinds.map(|kind| Coefficient::of(system, kind));
        Pencil {
            norms: coefficients.each_ref().map(Coefficient::norm),
            coefficients,
        }
    }

    /// |λ|²‖M‖ + |λ|‖C‖ + ‖K‖.
    fn scale(&self, lambda: Complex<f64>) -> f64 {
        let size = lambda.norm();
        (size * self.norms[0] + self.norms[1]) * size + self.norms[2]
    }

    /// The quality of every eigenvalue (Tisseur 2000, *Lin. Alg. Appl.* 309).
    pub(crate) fn qualities(&self, roots: &[Approximate<'_>]) -> Vec<Quality> {
        use Coefficient::Sparse;
        if let [Sparse(m), Sparse(c), Sparse(k)] = &self.coefficients {
            let mut products = [m, c, k].map(|matrix| vec![Complex::ZERO; matrix.columns()]);
            let each = roots.iter().map(|root| {
                for (matrix, product) in [m, c, k].into_iter().zip(&mut products) {
                    matrix.times(root.shape, product);
                }
                self.quality(root, products.each_ref().map(Vec::as_slice))
            });
            return each.collect();
        }
        let blocks = roots.chunks(BLOCK).flat_map(|block| {
            let shapes: Vec<&[Complex<f64>]> = block.iter().map(|root| root.shape).collect();
            let all = self.coefficients.each_ref();
            let are_real = shapes.iter().all(|shape| is_real(shape));
            let each: Vec<Quality> = if are_real {
                let shapes = Mat::from_fn(self.order(), block.len(), |i, j| shapes[j][i].re);
                let products = all.map(|matrix| matrix.real_products(shapes.as_ref()));
                let columns = |j| products.each_ref().map(|product| product.col_as_slice(j));
                let each = block.iter().enumerate();
                each.map(|(j, root)| self.quality(root, columns(j)))
                    .collect()
            } else {
                let [m, c, k] = all.map(|matrix| matrix.products(&shapes));
                let each = block.iter().zip(m).zip(c).zip(k);
                each.map(|(((root, mx), cx), kx)| self.quality(root, [&mx, &cx, &kx]))
                    .collect()
            };
            each
        });
        blocks.collect()
    }

    /// Of an undamped mode with this ω² and shape, from the products Mx and Kx.
    pub(crate) fn undamped_quality(
        &self,
        square: f64,
        shape: &[f64],
        mx: &[f64],
        kx: &[f64],
    ) -> Quality {
        let residual = kx.iter().zip(mx).map(|(k, m)| k - square * m);
        let residual: Vec<f64> = residual.collect();
        let [x, mx, residual] = [shape, mx, &residual].map(ColRef::from_slice);
        let size = x.norm_l2();
        let lambda = Complex::from(-square).sqrt();
        let slope = 2.0 * lambda.norm() * (x.transpose() * mx).abs();
        self.judged(lambda, residual.norm_l2(), [size, size], slope)
    }

    /// From the products Mx, Cx and Kx.
    fn quality<T: Factor>(&self, root: &Approximate<'_>, products: [&[T]; 3]) -> Quality {
        let lambda = root.value;
        let [mx, cx, kx] = products;
        let entries = || mx.iter().zip(cx).zip(kx);
        let residual = norm_of(entries().map(|((m, c), k)| *k + (*c + *m * lambda) * lambda));
        let size = norm(root.shape);
        let slopes = mx.iter().zip(cx).map(|(m, c)| *c + *m * lambda * 2.0);
        let (slope, left_size): (Complex<f64>, f64) = match root.left {
            Some(left) => (
                left.iter().zip(slopes).map(|(y, s)| y.conj() * s).sum(),
                norm(left),
            ),
            None => (
                root.shape.iter().zip(slopes).map(|(x, s)| x * s).sum(),
                size,
            ),
        };
        self.judged(lambda, residual, [size, left_size], slope.norm())
    }

    /// From ‖Q(λ)x‖, ‖x‖ and ‖y‖, and |y*Q′(λ)x|.
    fn judged(
        &self,
        lambda: Complex<f64>,
        residual: f64,
        [size, left_size]: [f64; 2],
        slope: f64,
    ) -> Quality {
        let scale = self.scale(lambda);
        let condition = scale * size * left_size / (lambda.norm() * slope);
        Quality {
            // The residual is no larger than its scale: 1 where their sizes leave the doubles.
            backward_error: if residual == 0.0 {
                0.0
            } else {
                Some(residual / (scale * size))
                    .filter(|quotient| quotient.is_finite())
                    .unwrap_or(1.0)
            },
            condition: condition.is_finite().then_some(condition),
        }
    }

    fn order(&self) -> usize {
        self.coefficients[0].order()
    }

    /// Q(λ) over its scale.
    fn at(&self, lambda: Complex<f64>) -> Option<Mat<Complex<f64>>> {
        let scale = self.scale(lambda);
        let n = self.order();
        let mut q = Mat::zeros(n, n);
        let factors = [
            lambda * lambda / scale,
            lambda / scale,
            Complex::from(1.0 / scale),
        ];
        for (matrix, factor) in self.coefficients.iter().zip(factors) {
            matrix.add_to(&mut q, factor);
        }
        q.norm_max().is_finite().then_some(q)
    }

    /// The shapes x and y that Q(λ) nearly annuls from the right and from the left, near those that
    /// are given: by two steps of inverse iteration. `None` where a number leaves its range.
    pub(crate) fn inverse_iteration(
        &self,
        near: &Approximate<'_>,
    ) -> Option<[Vec<Complex<f64>>; 2]> {
        let lu = Lu::of(self.at(near.value)?.as_ref());
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
        let svd = svd(q.as_ref())?;
        let last = |vectors: MatRef<'_, Complex<f64>>| {
            vectors.col(n - 1).iter().copied().collect::<Vec<_>>()
        };
        Some([last(svd.V()), last(svd.U())])
    }
}

fn conjugates(x: &[Complex<f64>]) -> Vec<Complex<f64>> {
    x.iter().map(|entry| entry.conj()).collect()
}

impl Coefficient {
    fn of(system: &System, kind: MatrixKind) -> Coefficient {
        if system.added(kind).is_none() {
            return Coefficient::Sparse(Sparse::of_elements(system, kind));
        }
        let matrix = match kind {
            MatrixKind::Mass => system.mass_matrix(),
            MatrixKind::Damping => system.damping_matrix(),
            MatrixKind::Stiffness => system.stiffness_matrix(),
        };
        match Sparse::of(matrix.as_ref()) {
            Some(sparse) => Coefficient::Sparse(sparse),
            None => Coefficient::Full(matrix),
        }
    }

    fn order(&self) -> usize {
        match self {
            Coefficient::Sparse(sparse) => sparse.columns(),
            Coefficient::Full(matrix) => matrix.ncols(),
        }
    }

    /// Frobenius.
    fn norm(&self) -> f64 {
        match self {
            Coefficient::Sparse(sparse) => {
                norm_of(sparse.entries.iter().map(|entry| Complex::from(*entry)))
            }
            Coefficient::Full(matrix) => matrix.norm_l2(),
        }
    }

    fn products(&self, shapes: &[&[Complex<f64>]]) -> Vec<Vec<Complex<f64>>> {
        match self {
            Coefficient::Sparse(sparse) => sparse.products(shapes),
            Coefficient::Full(matrix) => products(matrix.as_ref(), shapes),
        }
    }

    /// The same of real shapes, column by column.
    fn real_products(&self, shapes: MatRef<'_, f64>) -> Mat<f64> {
        match self {
            Coefficient::Sparse(sparse) => {
                let mut products = Mat::zeros(shapes.nrows(), shapes.ncols());
                for (j, shape) in shapes.col_iter().enumerate() {
                    sparse.add_times(shape.iter().copied(), products.col_as_slice_mut(j));
                }
                products
            }
            Coefficient::Full(matrix) => product(matrix.as_ref(), shapes),
        }
    }

    fn add_to(&self, q: &mut Mat<Complex<f64>>, factor: Complex<f64>) {
        match self {
            Coefficient::Sparse(sparse) => {
                for (j, column) in sparse.starts.windows(2).enumerate() {
                    for at in column[0]..column[1] {
                        q[(sparse.rows[at], j)] += factor * sparse.entries[at];
                    }
                }
            }
            Coefficient::Full(matrix) => {
                for j in 0..matrix.ncols() {
                    for i in 0..matrix.nrows() {
                        q[(i, j)] += factor * matrix[(i, j)];
                    }
                }
            }
        }
    }
}

impl Sparse {
    /// Of masses, springs or dampers, each entry summed in double-double and rounded once.
    fn of_elements(system: &System, kind: MatrixKind) -> Sparse {
        let elements = match kind {
            MatrixKind::Mass => {
                return Sparse::diagonal(system.masses());
            }
            MatrixKind::Damping => system.dampers(),
            MatrixKind::Stiffness => system.springs(),
        };
        // Column, row and value of every share.
        let mut shares: Vec<(usize, usize, f64)> = Vec::with_capacity(4 * elements.len());
        for Element {
            first,
            second,
            coefficient,
        } in elements
        {
            for (end, other) in [(first, second), (second, first)] {
                let Some(i) = end.coordinate() else { continue };
                shares.push((i, i, *coefficient));
                if let Some(j) = other.coordinate() {
                    shares.push((j, i, -*coefficient));
                }
            }
        }
        shares.sort_by_key(|(j, i, _)| (*j, *i));
        let mut starts = vec![0; system.len() + 1];
        let mut rows = Vec::with_capacity(shares.len());
        let mut entries = Vec::with_capacity(shares.len());
        for same in shares.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let values = same.iter().map(|share| DoubleDouble::from(share.2));
            let sum = values
                .fold(DoubleDouble::ZERO, |sum, value| sum + value)
                .to_f64();
            if sum != 0.0 {
                rows.push(same[0].1);
                entries.push(sum);
                starts[same[0].0 + 1] += 1;
            }
        }
        for j in 0..system.len() {
            starts[j + 1] += starts[j];
        }
        Sparse {
            starts,
            rows,
            entries,
        }
    }

    fn diagonal(values: &[f64]) -> Sparse {
        Sparse {
            starts: (0..=values.len()).collect(),
            rows: (0..values.len()).collect(),
            entries: values.to_vec(),
        }
    }

    /// `None` where a product with all entries is as quick.
    fn of(matrix: MatRef<'_, f64>) -> Option<Sparse> {
        const FULL: usize = 8;
        let n = matrix.nrows();
        let filled = |column: ColRef<'_, f64>| column.iter().filter(|x| **x != 0.0).count();
        let count = matrix.col_iter().map(filled).sum();
        if n * n > FEW && FULL * count > n * n {
            return None;
        }
        let mut starts = Vec::with_capacity(n + 1);
        let (mut rows, mut entries) = (Vec::with_capacity(count), Vec::with_capacity(count));
        starts.push(0);
        for j in 0..n {
            for (i, entry) in matrix.col(j).iter().enumerate() {
                if *entry != 0.0 {
                    rows.push(i);
                    entries.push(*entry);
                }
            }
            starts.push(entries.len());
        }
        Some(Sparse {
            starts,
            rows,
            entries,
        })
    }

    fn columns(&self) -> usize {
        self.starts.len() - 1
    }

    fn products(&self, shapes: &[&[Complex<f64>]]) -> Vec<Vec<Complex<f64>>> {
        let product = |x: &&[Complex<f64>]| {
            let mut product = vec![Complex::ZERO; x.len()];
            self.times(x, &mut product);
            product
        };
        shapes.iter().map(product).collect()
    }

    /// product = A·x.
    fn times(&self, x: &[Complex<f64>], product: &mut [Complex<f64>]) {
        product.fill(Complex::ZERO);
        self.add_times(x.iter().copied(), product);
    }

    /// product += A·x.
    fn add_times<T: Factor>(&self, x: impl Iterator<Item = T>, product: &mut [T]) {
        for (column, x) in self.starts.windows(2).zip(x) {
            let range = column[0]..column[1];
            for (i, entry) in self.rows[range.clone()].iter().zip(&self.entries[range]) {
                product[*i] += x * *entry;
            }
        }
    }
}

/// A matrix, sparse or full, times complex vectors.
pub(crate) fn applied(
    matrix: MatRef<'_, f64>,
    shapes: &[&[Complex<f64>]],
) -> Vec<Vec<Complex<f64>>> {
    match Sparse::of(matrix) {
        Some(sparse) => sparse.products(shapes),
        None => products(matrix, shapes),
    }
}

/// A real matrix times complex vectors.
pub(crate) fn products(
    matrix: MatRef<'_, f64>,
    shapes: &[&[Complex<f64>]],
) -> Vec<Vec<Complex<f64>>> {
    let n = matrix.ncols();
    if n * matrix.nrows() <= FEW {
        return shapes.iter().map(|x| times(matrix, x)).collect();
    }
    if shapes.iter().all(|x| is_real(x)) {
        let parts = Mat::from_fn(n, shapes.len(), |i, j| shapes[j][i].re);
        let product = product(matrix, parts.as_ref());
        let column = |j| product.col(j).iter().map(|re| Complex::from(*re)).collect();
        return (0..shapes.len()).map(column).collect();
    }
    let parts = Mat::from_fn(n, 2 * shapes.len(), |i, j| {
        let entry = shapes[j / 2][i];
        if j % 2 == 0 { entry.re } else { entry.im }
    });
    let product = product(matrix, parts.as_ref());
    let column = |j: usize| {
        let (re, im) = (product.col(2 * j), product.col(2 * j + 1));
        let parts = re.iter().zip(im.iter());
        parts.map(|(re, im)| Complex::new(*re, *im)).collect()
    };
    (0..shapes.len()).map(column).collect()
}

fn is_real(x: &[Complex<f64>]) -> bool {
    x.iter().all(|entry| entry.im == 0.0)
}

/// A small real matrix times a complex vector.
fn times(matrix: MatRef<'_, f64>, x: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let mut product = vec![Complex::ZERO; matrix.nrows()];
    for (column, x) in matrix.col_iter().zip(x) {
        for (sum, entry) in product.iter_mut().zip(column.iter()) {
            *sum += x * entry;
        }
    }
    product
}

/// ‖x‖, without overflow on the way.
pub(crate) fn norm(x: &[Complex<f64>]) -> f64 {
    norm_of(x.iter().copied())
}

fn norm_of(x: impl Iterator<Item = Complex<f64>> + Clone) -> f64 {
    let square: f64 = x.clone().map(|entry| entry.norm_sqr()).sum();
    if (1e-200..1e200).contains(&square) {
        return square.sqrt();
    }
    let parts = x.clone().flat_map(|entry| [entry.re.abs(), entry.im.abs()]);
    let largest = parts.fold(0.0, |a: f64, b| if b > a || b.is_nan() { b } else { a });
    if largest == 0.0 || !largest.is_finite() {
        return largest;
    }
    // Both factors are powers of two, and neither leaves the doubles.
    let half = (-0.5 * largest.log2()).round().exp2();
    let scaled = x.map(|entry| entry * half * half);
    let square: f64 = scaled.map(|entry| entry.norm_sqr()).sum();
    square.sqrt() / half / half
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::GROUND;

    /// 3, 4i and 12 in any unit, also where squares leave the doubles.
    #[test]
    fn lengths_of_any_size() {
        for power in [-900, -600, 0, 600, 1000] {
            let unit = 2f64.powi(power);
            let x = [(3.0, 0.0), (0.0, 4.0), (-12.0, 0.0)];
            let x = x.map(|(re, im)| Complex::new(re * unit, im * unit));
            assert_eq!(norm(&x), 13.0 * unit);
        }
        assert_eq!(norm(&[Complex::ZERO]), 0.0);
    }

    /// λ = 2i where ±i is right: |1 − 4| of 4 + 1, and a condition of 5/(2·|2·2i|) (Tisseur 2000).
    #[test]
    fn one_mass_far_off() {
        let system = System::builder().mass("m", 1.0).spring(GROUND, "m", 1.0);
        let pencil = Pencil::of(&system.build().unwrap());
        let near = Approximate {
            value: Complex::new(0.0, 2.0),
            shape: &[Complex::ONE],
            left: None,
        };
        let quality = pencil.qualities(&[near])[0];
        assert!((quality.backward_error - 0.6).abs() < 1e-15);
        assert!((quality.condition.unwrap() - 0.625).abs() < 1e-15);
    }

    /// From products that are at hand, oscillating and diverging: the same as of the root with its complex shape.
    #[test]
    fn undamped_modes_are_judged_alike() {
        let system = System::builder()
            .mass("a", 1.5)
            .mass("b", 0.25)
            .spring("a", "b", 3.0)
            .spring(GROUND, "a", 2.0);
        let system = system.build().unwrap();
        let pencil = Pencil::of(&system);
        let x = [1.0, -0.75];
        let shape = x.map(Complex::from);
        let [m, k] = [system.mass_matrix(), system.stiffness_matrix()];
        let times = |a: &Mat<f64>| [0, 1].map(|i| a[(i, 0)] * x[0] + a[(i, 1)] * x[1]);
        for (square, value) in [
            (2.25, Complex::new(0.0, 1.5)),
            (-4.0, Complex::new(2.0, 0.0)),
        ] {
            let left = None;
            let near = Approximate {
                value,
                shape: &shape,
                left,
            };
            let expected = pencil.qualities(&[near])[0];
            let found = pencil.undamped_quality(square, &x, &times(&m), &times(&k));
            assert!((found.backward_error / expected.backward_error - 1.0).abs() < 1e-15);
            let quotient = found.condition.unwrap() / expected.condition.unwrap();
            assert!((quotient - 1.0).abs() < 1e-15);
        }
    }

    /// Both measures by their definitions, entry by entry, for matrices without any symmetry.
    #[test]
    fn matrices_without_symmetry() {
        let m = [[2.0, 0.5], [-0.25, 1.0]];
        let c = [[1.0, 2.0], [0.0, 0.5]];
        let k = [[3.0, -1.0], [1.5, 2.0]];
        let matrix = |entries: [[f64; 2]; 2]| Mat::from_fn(2, 2, |i, j| entries[i][j]);
        let mut builder = System::builder().mass("a", 0.0).mass("b", 0.0);
        for (kind, entries) in [
            (MatrixKind::Mass, m),
            (MatrixKind::Damping, c),
            (MatrixKind::Stiffness, k),
        ] {
            builder = builder.matrix(kind, matrix(entries).as_ref());
        }
        let pencil = Pencil::of(&builder.build().unwrap());
        let lambda = Complex::new(-0.5, 1.5);
        let x = [Complex::ONE, Complex::new(0.5, -0.25)];
        let y = [Complex::new(0.3, 0.7), Complex::new(-0.2, 1.0)];
        let near = Approximate {
            value: lambda,
            shape: &x,
            left: Some(&y),
        };
        let quality = pencil.qualities(&[near])[0];

        let square = |entries: [[f64; 2]; 2]| entries.iter().flatten().map(|e| e * e).sum::<f64>();
        let length = |v: &[Complex<f64>]| v.iter().map(|e| e.norm_sqr()).sum::<f64>().sqrt();
        let scale = lambda.norm_sqr() * square(m).sqrt()
            + lambda.norm() * square(c).sqrt()
            + square(k).sqrt();
        let row = |i: usize, j: usize| lambda * lambda * m[i][j] + lambda * c[i][j] + k[i][j];
        let residual = [0, 1].map(|i| row(i, 0) * x[0] + row(i, 1) * x[1]);
        let expected = length(&residual) / (scale * length(&x));
        assert!((quality.backward_error / expected - 1.0).abs() < 1e-14);

        let mut product = Complex::<f64>::ZERO;
        for i in 0..2 {
            for j in 0..2 {
                product += y[i].conj() * (lambda * 2.0 * m[i][j] + c[i][j]) * x[j];
            }
        }
        let expected = scale * length(&x) * length(&y) / (lambda.norm() * product.norm());
        assert!((quality.condition.unwrap() / expected - 1.0).abs() < 1e-14);
    }
}
