//! Roots of λ²M + λC + K near a shift σ, by Arnoldi's method on the inverse of the shifted first-order form
//! (Saad 2011, *Numerical Methods for Large Eigenvalue Problems*, §6.2 and §8.1; Tisseur & Meerbergen 2001,
//! *SIAM Review* 43, §3).
//!
//! For z = (x, λx) and A − σB of the first-order form, w = (A − σB)⁻¹B z = (p, σp + x) with
//! −Q(σ)p = (C + σM)x + M(λx), so that one factor of Q(σ) serves. Of a multiple root one run can find one
//! shape; others are found by runs that are orthogonal to what was found.

use eigentone_digits::{eigen, sort_by_number};
use faer::Mat;
use num_complex::Complex;

use super::eigenpair::Eigenpair;
use super::factor::{Factor, Sum};
use super::pencil::Pencil;
use super::random::uniform;

type Vector = Vec<Complex<f64>>;

/// What was found about a shift.
pub(crate) struct Arnoldi<'a> {
    pencil: &'a Pencil,
    factor: Factor<'a, Complex<f64>>,
    shift: Complex<f64>,
    /// Lengths of coordinates, and of velocities beside them: √(K_ii + |σ|²M_ii) makes both energies.
    weights: Vec<f64>,
    rate: f64,
    /// An orthonormal basis of what was found, and its products.
    basis: Vec<Vector>,
    products: Vec<Vector>,
    runs: u64,
}

/// Residuals at which a root counts as found, relative to 1/(λ − σ).
const TOLERANCE: f64 = 1e-9;

impl<'a> Arnoldi<'a> {
    /// About a shift; `rate` is the size of the roots looked for. `None` where Q(σ) has no factor.
    pub(crate) fn about(pencil: &'a Pencil, shift: Complex<f64>, rate: f64) -> Option<Arnoldi<'a>> {
        let factor = Factor::sum(pencil, Sum::at(shift), &[]);
        if !factor.is_finite() || factor.zeros > 0 {
            return None;
        }
        let diagonals = pencil.stiffness.diagonal().into_iter();
        let weights = diagonals.zip(pencil.mass.diagonal());
        let weights: Vec<f64> = weights
            .map(|(k, m)| (k.abs() + rate * rate * m.abs()).sqrt())
            .collect();
        let largest = weights.iter().copied().fold(0.0, f64::max);
        let weights = weights.iter().map(|w| w.max(1e-8 * largest)).collect();
        Some(Arnoldi {
            pencil,
            factor,
            shift,
            weights,
            rate,
            basis: Vec::new(),
            products: Vec::new(),
            runs: 0,
        })
    }

    /// Has motions at λ = 0 found, with velocities of their own where nothing damps them, so that no run finds them again.
    pub(crate) fn lock(&mut self, still: &[(&[f64], bool)]) {
        let zeros = vec![Complex::ZERO; self.weights.len()];
        for (shape, is_free) in still {
            let scaled = shape.iter().zip(&self.weights);
            let scaled: Vector = scaled.map(|(x, w)| Complex::from(x * w)).collect();
            self.keep([&scaled[..], &zeros].concat());
            if *is_free {
                self.keep([&zeros[..], &scaled].concat());
            }
        }
    }

    /// Adds what a vector has besides the basis; `false` where that is nothing but rounding.
    fn keep(&mut self, mut vector: Vector) -> bool {
        orthogonalise(&self.basis, &mut vector);
        if !normalise(&mut vector, 1e-8) {
            return false;
        }
        orthogonalise(&self.basis, &mut vector);
        if !normalise(&mut vector, 0.5) {
            return false;
        }
        self.products.push(self.apply(&vector));
        self.basis.push(vector);
        true
    }

    /// The size of the roots looked for.
    pub(crate) fn rate(&self) -> f64 {
        self.rate
    }

    /// The product of (A − σB)⁻¹B with a vector of weighted displacements and velocities.
    fn apply(&self, z: &[Complex<f64>]) -> Vector {
        let n = self.weights.len();
        let x: Vector = z[..n]
            .iter()
            .zip(&self.weights)
            .map(|(z, w)| z / w)
            .collect();
        let scales = self.weights.iter().map(|w| self.rate / w);
        let y: Vector = z[n..].iter().zip(scales).map(|(z, s)| z * s).collect();
        let mut p = vec![Complex::ZERO; n];
        self.pencil
            .mass
            .accumulate_complex(-Complex::ONE, &y, &mut p);
        self.pencil
            .damping
            .accumulate_complex(-Complex::ONE, &x, &mut p);
        self.pencil.mass.accumulate_complex(-self.shift, &x, &mut p);
        self.factor.solve(&mut p, &mut vec![Complex::ZERO; n]);
        let mut product = Vec::with_capacity(2 * n);
        product.extend(p.iter().zip(&self.weights).map(|(p, w)| p * w));
        let velocities = p.iter().zip(&x).zip(&self.weights);
        product.extend(velocities.map(|((p, x), w)| (self.shift * p + x) * (w / self.rate)));
        product
    }

    /// Looks for so many more, and returns how many were found: fewer where the method does not converge to them
    /// or there are no more.
    pub(crate) fn run(&mut self, wanted: usize) -> usize {
        let size = 2 * self.weights.len();
        let most = (6 * wanted + 120).min(size - self.basis.len().min(size));
        self.runs += 1;
        let mut state = 0x9e37_79b9_7f4a_7c15 ^ self.runs;
        let mut next: Vector = (0..size)
            .map(|_| Complex::from(uniform(&mut state)))
            .collect();
        orthogonalise(&self.basis, &mut next);
        if most == 0 || !normalise(&mut next, 1e-8) {
            return 0;
        }
        let mut vectors = vec![next];
        let mut columns: Vec<Vector> = Vec::new();
        let mut check = (2 * wanted).max(12);
        let found = loop {
            let last = columns.len();
            let mut product = self.apply(&vectors[last]);
            let before = norm(&product);
            let mut column = vec![Complex::ZERO; last + 2];
            for _ in 0..2 {
                orthogonalise(&self.basis, &mut product);
                for (entry, vector) in column.iter_mut().zip(&vectors) {
                    let along = inner(vector, &product);
                    *entry += along;
                    subtract(along, vector, &mut product);
                }
            }
            let rest = norm(&product);
            if !rest.is_finite() {
                return 0;
            }
            let ended = rest <= 1e-14 * before || last + 1 == most;
            column[last + 1] = Complex::from(rest);
            columns.push(column);
            if ended || columns.len() >= check {
                let exact = rest <= 1e-14 * before;
                let Some(ritz) = Ritz::of(&columns) else {
                    return 0;
                };
                let found = ritz.converged(if exact { 0.0 } else { rest });
                if ended || found >= wanted {
                    break ritz.combinations(&vectors, found.min(wanted + 2));
                }
                check = columns.len() + (columns.len() / 4).max(4);
            }
            product.iter_mut().for_each(|entry| *entry /= rest);
            vectors.push(product);
        };
        let kept = found.into_iter().map(|vector| self.keep(vector));
        kept.map(usize::from).sum()
    }

    /// The roots in the space that was found, those with Im λ ≥ 0 where roots come in pairs about a real shift.
    pub(crate) fn roots(&self) -> Vec<Eigenpair> {
        let count = self.basis.len();
        let form = Mat::from_fn(count, count, |i, j| {
            inner(&self.basis[i], &self.products[j])
        });
        let Some((values, vectors)) = eigen(form.as_ref()) else {
            return Vec::new();
        };
        let n = self.weights.len();
        let mut roots = Vec::new();
        for k in 0..count {
            let inverse = values[k];
            if inverse == Complex::ZERO {
                continue;
            }
            let value = self.shift + inverse.inv();
            if value.im < -1e-7 * value.norm() {
                continue;
            }
            let mut shape = vec![Complex::ZERO; n];
            for (i, vector) in self.basis.iter().enumerate() {
                let factor = vectors[(i, k)];
                subtract(-factor, &vector[..n], &mut shape);
            }
            shape
                .iter_mut()
                .zip(&self.weights)
                .for_each(|(x, w)| *x /= w);
            roots.push(Eigenpair { value, shape });
        }
        roots
    }
}

fn inner(x: &[Complex<f64>], y: &[Complex<f64>]) -> Complex<f64> {
    x.iter().zip(y).map(|(x, y)| x.conj() * y).sum()
}

fn norm(x: &[Complex<f64>]) -> f64 {
    x.iter().map(|x| x.norm_sqr()).sum::<f64>().sqrt()
}

fn subtract(factor: Complex<f64>, from: &[Complex<f64>], to: &mut [Complex<f64>]) {
    to.iter_mut()
        .zip(from)
        .for_each(|(to, x)| *to -= factor * x);
}

fn orthogonalise(basis: &[Vector], x: &mut Vector) {
    for vector in basis {
        let along = inner(vector, x);
        subtract(along, vector, x);
    }
}

/// To length 1, unless it is shorter than `least`.
fn normalise(x: &mut Vector, least: f64) -> bool {
    let size = norm(x);
    if !(size > least && size.is_finite()) {
        return false;
    }
    x.iter_mut().for_each(|entry| *entry /= size);
    true
}

/// Eigenvalues of the projected operator, the largest first, with their vectors.
struct Ritz {
    values: Vec<Complex<f64>>,
    vectors: Mat<Complex<f64>>,
}

impl Ritz {
    fn of(columns: &[Vector]) -> Option<Ritz> {
        let count = columns.len();
        let entry = |i: usize, j: usize| columns[j].get(i).copied().unwrap_or(Complex::ZERO);
        let projected = Mat::from_fn(count, count, entry);
        let (values, vectors) = eigen(projected.as_ref())?;
        let value = |k: &usize| values[*k];
        let mut order: Vec<usize> = (0..count).collect();
        sort_by_number(&mut order, |k| -value(k).norm());
        Some(Ritz {
            values: order.iter().map(value).collect(),
            vectors: Mat::from_fn(count, count, |i, j| vectors[(i, order[j])]),
        })
    }

    /// How many of the leading ones have residuals within the tolerance.
    fn converged(&self, rest: f64) -> usize {
        let count = self.values.len();
        let within = |k: &usize| {
            let column = self.vectors.col(*k);
            let size = column.norm_l2();
            rest * column[count - 1].norm() <= TOLERANCE * size * self.values[*k].norm()
        };
        (0..count).take_while(within).count()
    }

    fn combinations(&self, vectors: &[Vector], count: usize) -> Vec<Vector> {
        (0..count.min(self.values.len()))
            .map(|k| {
                let mut sum = vec![Complex::ZERO; vectors[0].len()];
                for (vector, factor) in vectors.iter().zip(self.vectors.col(k).iter()) {
                    subtract(-*factor, vector, &mut sum);
                }
                let size = norm(&sum);
                sum.iter_mut().for_each(|entry| *entry /= size);
                sum
            })
            .collect()
    }
}
