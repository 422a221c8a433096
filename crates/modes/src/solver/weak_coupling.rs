//! All roots and shapes of λ²q + λΓq + Ω²q = 0 at once, where damping couples the undamped modes weakly.
//!
//! The modes without each other are the first approximations. With the inverse in partial fractions (Lancaster 1966,
//! *Lambda-matrices and vibrating systems*, §4.3)
//!
//! (λ²I + λΓ + Ω²)⁻¹ = Σ_j q_jq_jᵀ/(s_j(λ − λ_j)) + the same of the conjugate roots, s_j = q_jᵀ(2λ_jI + Γ)q_j,
//!
//! the residual r_k of root k moves its shape by the share −q_jᵀr_k/(s_j(λ_k − λ_j)) of each other one, and the root itself by
//! −q_kᵀr_k/s_k. What is left is of the second order, as in the refinement of symmetric eigenvectors by Ogita & Aishima (2018,
//! *Jpn. J. Ind. Appl. Math.* 35). Shapes with large shares of each other are first separated by the eigenproblem of their
//! group. A step takes 20n³ operations, in three products; the QR algorithm some 200n³ for the 2n states, few of them in products.

use eigentone_digits::{eigen, product};
use faer::{Mat, MatRef};
use num_complex::Complex;

use crate::inclusion::groups::join;

/// A step by shares below this leaves none above the rounding.
const SMALL: f64 = 2e-8;

/// Roots with Im λ > 0, one of each conjugate pair, and the amplitudes of the undamped modes in each.
pub(crate) type Coupled = (Vec<Complex<f64>>, Vec<Vec<Complex<f64>>>);

/// All modes, given the undamped frequencies Ω > 0 and the modal damping Γ; `None` where one of them does not vibrate, or
/// damping couples too many of them too strongly.
pub(crate) fn weakly_coupled(frequencies: &[f64], gamma: MatRef<'_, f64>) -> Option<Coupled> {
    /// Larger ones do not get smaller.
    const LARGEST: f64 = 1.5;
    /// As long as the QR algorithm takes.
    const STEPS: usize = 10;
    // In units of the largest, so that products of four stay in the range of doubles.
    let largest = frequencies.iter().fold(0.0, |top: f64, one| top.max(*one));
    let unit = largest.log2().round().exp2();
    let scaled: Vec<f64> = frequencies.iter().map(|one| one / unit).collect();
    let gamma = Mat::from_fn(gamma.nrows(), gamma.ncols(), |i, j| gamma[(i, j)] / unit);
    let mut modes = Approximation::alone(&scaled, gamma.as_ref())?;
    for _ in 0..STEPS {
        let shares = modes.step(&scaled, gamma.as_ref())?;
        if shares <= SMALL {
            return modes.found(unit);
        }
        if shares > LARGEST {
            break;
        }
    }
    None
}

/// Approximate roots, and their shapes q as columns: real parts of all, then imaginary ones.
struct Approximation {
    roots: Vec<Complex<f64>>,
    shapes: Mat<f64>,
}

impl Approximation {
    /// Each without the others.
    fn alone(frequencies: &[f64], gamma: MatRef<'_, f64>) -> Option<Approximation> {
        let n = frequencies.len();
        let root = |(i, frequency): (usize, &f64)| {
            let half = 0.5 * gamma[(i, i)];
            let height = (frequency - half.abs()) * (frequency + half.abs());
            (height > 0.0).then(|| Complex::new(-half, height.sqrt()))
        };
        let roots = frequencies.iter().enumerate().map(root);
        Some(Approximation {
            roots: roots.collect::<Option<_>>()?,
            shapes: Mat::from_fn(n, 2 * n, |i, j| if i == j { 1.0 } else { 0.0 }),
        })
    }

    fn found(self, unit: f64) -> Option<Coupled> {
        let n = self.roots.len();
        let shape = |k: usize| (0..n).map(|i| entry(&self.shapes, i, k)).collect();
        let vibrates = |root: &Complex<f64>| root.im > 0.0 && root.is_finite();
        self.roots.iter().all(vibrates).then(|| {
            let roots = self.roots.iter().map(|root| root * unit);
            (roots.collect(), (0..n).map(shape).collect())
        })
    }

    /// A step for all roots; the largest sum of the shares that move a shape, or `None` where one is not a number or too many
    /// shapes are mixed.
    fn step(&mut self, frequencies: &[f64], gamma: MatRef<'_, f64>) -> Option<f64> {
        /// Shapes with larger shares of each other are mixed.
        const MIXED: f64 = 0.2;
        /// Of roots so close, relative to their size, so many units of rounding of a residual are no share.
        const CLOSE: f64 = 1e-6;
        const UNITS: f64 = 8.0 * f64::EPSILON;
        let n = frequencies.len();
        let (residual, slopes) = self.residual(frequencies, gamma);
        let forms = product(self.shapes.transpose(), residual.as_ref());
        // q_jᵀr_k by the real part of q_j and by i times the imaginary one; with the conjugate of q_j it is their difference.
        let form = |j: usize, k: usize| {
            let (re, im) = (entry(&forms, j, k), entry(&forms, n + j, k));
            (re, Complex::new(-im.im, im.re))
        };
        let roots = &self.roots;
        let mut label: Vec<usize> = (0..n).collect();
        let mut worst = 0f64;
        // By rows: the factors of the real parts of all shapes, then of the imaginary ones.
        let mut shares = Mat::zeros(2 * n, 2 * n);
        for (k, root) in roots.iter().enumerate() {
            let size = root.norm();
            let mut sum = 0.0;
            for j in 0..n {
                let (re, im) = form(j, k);
                // s_j(λ_k − λ_j) and the same of the conjugate root. Where λ_k is much larger the shares nearly cancel, which
                // half the sum of these and half their difference do not.
                let product = slopes[j] * roots[j];
                let mean = root * slopes[j].re - product.re;
                let apart = (root * slopes[j].im - product.im) * Complex::I;
                let (own, opposite) = (mean + apart, mean - apart);
                let share = over(re - im, opposite);
                let (mut on_real, mut on_imaginary) = (-share, share);
                sum += share.l1_norm();
                let gap = (root - roots[j]).l1_norm() / size;
                let is_none = gap <= CLOSE && (re + im).l1_norm() <= UNITS * size * size;
                if j != k && !is_none {
                    let share = over(re + im, own).l1_norm();
                    if share > MIXED {
                        join(&mut label, j, k);
                        sum += share * gap;
                    } else {
                        sum += share;
                        let both = -2.0 * over(over(Complex::ONE, own), opposite);
                        on_real = (re * mean - im * apart) * both;
                        on_imaginary = (im * mean - re * apart) * both;
                    }
                }
                shares[(j, k)] = on_real.re;
                shares[(j, n + k)] = on_real.im;
                shares[(n + j, k)] = -on_imaginary.im;
                shares[(n + j, n + k)] = on_imaginary.re;
            }
            if !sum.is_finite() {
                return None;
            }
            worst = worst.max(sum);
        }
        // What couples the roots of a group: they are on the diagonal.
        let coupling = |j: usize, k: usize| {
            let (re, im) = form(j, k);
            let own = if j == k { roots[k] } else { Complex::ZERO };
            own - over(re + im, slopes[j])
        };
        let moved = (0..n).map(|k| coupling(k, k)).collect();
        let mut separated = Vec::new();
        for first in 0..n {
            let group: Vec<usize> = (first..n).filter(|k| label[*k] == first).collect();
            if group.len() > n.div_ceil(4) {
                return None;
            }
            if group.len() > 1 {
                let m = group.len();
                let coupling = Mat::from_fn(m, m, |j, k| coupling(group[j], group[k]));
                separated.push((eigen(coupling.as_ref())?, group));
            }
        }
        // Their other shares follow in the next step, if there is one.
        let is_last = worst <= SMALL;
        let later = separated.iter().flat_map(|(_, group)| group);
        for k in later.filter(|_| !is_last) {
            shares.col_mut(*k).fill(0.0);
            shares.col_mut(n + k).fill(0.0);
        }
        self.shapes += product(self.shapes.as_ref(), shares.as_ref());
        self.roots = moved;
        for ((roots, vectors), group) in separated {
            self.separate(&group, &roots, vectors.as_ref());
        }
        Some(worst)
    }

    /// The residuals r_k as columns, like the shapes, and the s_k.
    fn residual(
        &self,
        frequencies: &[f64],
        gamma: MatRef<'_, f64>,
    ) -> (Mat<f64>, Vec<Complex<f64>>) {
        let n = frequencies.len();
        // Γq, and the residual in its place.
        let mut residual = product(gamma, self.shapes.as_ref());
        let mut slopes = vec![Complex::ZERO; n];
        for (k, root) in self.roots.iter().enumerate() {
            for (i, frequency) in frequencies.iter().enumerate() {
                let (shape, force) = (entry(&self.shapes, i, k), entry(&residual, i, k));
                slopes[k] += shape * (2.0 * root * shape + force);
                let rest = root * force + (root * root + frequency * frequency) * shape;
                residual[(i, k)] = rest.re;
                residual[(i, n + k)] = rest.im;
            }
        }
        (residual, slopes)
    }

    /// Gives a group its roots, and the shapes that have these entries of its own.
    fn separate(
        &mut self,
        group: &[usize],
        roots: &[Complex<f64>],
        vectors: MatRef<'_, Complex<f64>>,
    ) {
        let n = self.roots.len();
        for i in 0..n {
            let row: Vec<Complex<f64>> = group.iter().map(|k| entry(&self.shapes, i, *k)).collect();
            for (&k, vector) in group.iter().zip(vectors.col_iter()) {
                let sum: Complex<f64> = row.iter().zip(vector.iter()).map(|(a, b)| a * b).sum();
                (self.shapes[(i, k)], self.shapes[(i, n + k)]) = (sum.re, sum.im);
            }
        }
        for (k, root) in group.iter().zip(roots) {
            self.roots[*k] = *root;
        }
    }
}

/// Entry i of column k of a matrix whose imaginary columns follow as many real ones.
fn entry(a: &Mat<f64>, i: usize, k: usize) -> Complex<f64> {
    Complex::new(a[(i, k)], a[(i, a.ncols() / 2 + k)])
}

/// a/b for sizes whose squares are doubles.
fn over(a: Complex<f64>, b: Complex<f64>) -> Complex<f64> {
    a * b.conj() * b.norm_sqr().recip()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn matrix(n: usize, entry: impl Fn(usize, usize) -> f64) -> Mat<f64> {
        Mat::from_fn(n, n, entry)
    }

    /// The largest residual, each entry relative to the sizes of what it is a sum of, with all of a shape in place of its own
    /// entry where the whole counts.
    fn error((roots, shapes): &Coupled, frequencies: &[f64], gamma: &Mat<f64>, whole: bool) -> f64 {
        let n = frequencies.len();
        let mut worst = 0f64;
        for (root, q) in roots.iter().zip(shapes) {
            let all = q.iter().map(|entry| entry.norm()).fold(0.0, f64::max);
            for i in 0..n {
                let force: Complex<f64> = (0..n).map(|j| gamma[(i, j)] * q[j]).sum();
                let sizes: f64 = (0..n).map(|j| (gamma[(i, j)] * q[j]).norm()).sum();
                let square = frequencies[i] * frequencies[i];
                let rest = root * root * q[i] + root * force + square * q[i];
                let share = if whole { all } else { q[i].norm() };
                let size = (root.norm_sqr() + square) * share + root.norm() * sizes;
                worst = worst.max(rest.norm() / size);
            }
        }
        worst
    }

    /// Whether no two roots have the same shape: bᵀb′ is 1 for shapes of length 1.
    fn are_independent((_, shapes): &Coupled) -> bool {
        let length = |q: &[Complex<f64>]| q.iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
        let along = |p: &[Complex<f64>], q: &[Complex<f64>]| {
            let sum: Complex<f64> = p.iter().zip(q).map(|(a, b)| a.conj() * b).sum();
            sum.norm() / (length(p) * length(q))
        };
        let mut pairs = (0..shapes.len()).flat_map(|k| (0..k).map(move |j| (j, k)));
        pairs.all(|(j, k)| along(&shapes[j], &shapes[k]) < 0.999)
    }

    proptest! {
        #[test]
        fn every_mode_is_found(
            n in 1..12usize,
            gaps in prop::collection::vec(0.02..1.0f64, 12),
            entries in prop::collection::vec(-1.0..1.0f64, 144),
            size in 0.0..0.02f64,
            power in -900..900i32,
        ) {
            let unit = f64::from(power).exp2();
            let frequencies: Vec<f64> = (0..n).map(|i| unit * (0.3 + gaps[..=i].iter().sum::<f64>())).collect();
            let gamma = matrix(n, |i, j| unit * size * entries[12 * i.max(j) + i.min(j)]);
            let found = weakly_coupled(&frequencies, gamma.as_ref());
            // Modes that are a fifth of the distance between two apart are mixed, and few of few may be.
            prop_assert!(found.is_some() || n < 8 && size > 1e-3);
            if let Some(found) = found {
                let one = |x: &f64| x / unit;
                let frequencies: Vec<f64> = frequencies.iter().map(one).collect();
                let gamma = matrix(n, |i, j| gamma[(i, j)] / unit);
                let found = (found.0.iter().map(|root| root / unit).collect(), found.1);
                let error = error(&found, &frequencies, &gamma, true);
                prop_assert!(error < 2e-15, "{error:e}");
                prop_assert!(are_independent(&found));
                let trace: f64 = (0..n).map(|i| gamma[(i, i)]).sum();
                let sum: f64 = found.0.iter().map(|root| 2.0 * root.re).sum();
                prop_assert!((trace + sum).abs() < 1e-13 * n as f64);
            }
        }
    }

    /// Two modes of one frequency, which only a third one couples, beside many others.
    #[test]
    fn repeated_frequencies_are_separated() {
        let n = 12;
        for damping in [1e-6, 1e-3, 0.1] {
            let frequency = |i: usize| if i < 2 { 1.0 } else { i as f64 };
            let frequencies: Vec<f64> = (0..n).map(frequency).collect();
            let along = |i: usize| [1.0, -2.0, 0.5][i % 3];
            let gamma = matrix(n, |i, j| match (i.min(j), i.max(j)) {
                (0, 1) => 0.0,
                (i, j) if i == j => damping,
                (i, j) => 0.2 * damping * along(i) * along(j),
            });
            let found = weakly_coupled(&frequencies, gamma.as_ref()).expect("it is weak");
            let error = error(&found, &frequencies, &gamma, true);
            assert!(error < 1e-15, "{damping} {error:e}");
            assert!(are_independent(&found), "{damping}");
        }
    }

    /// A damper at one place of a beam: the highest of its frequencies are a million times the lowest, and its modes move alike
    /// there.
    #[test]
    fn small_shares_of_low_modes_in_high_ones_keep_their_digits() {
        let n = 60;
        let frequencies: Vec<f64> = (1..=n).map(|i| 1e-3 * (i as f64).powi(4)).collect();
        let gamma = matrix(n, |i, j| {
            let along = |i: usize| (0.7 * (i + 1) as f64).sin();
            1e-4 * along(i) * along(j)
        });
        let found = weakly_coupled(&frequencies, gamma.as_ref()).expect("it is weak");
        let error = error(&found, &frequencies, &gamma, false);
        assert!(error < 1e-14, "{error:e}");
    }

    #[test]
    fn what_is_strong_or_not_a_number_is_refused() {
        let frequencies = [1.0, 2.0, 3.0, 4.0, 5.0];
        for size in [10.0, f64::NAN, f64::INFINITY, 1e300] {
            let strong = matrix(5, |i, j| size * (i + j) as f64);
            assert!(weakly_coupled(&frequencies, strong.as_ref()).is_none());
        }
        let plain = matrix(5, |i, j| if i == j { 1e-3 } else { 0.0 });
        assert!(weakly_coupled(&frequencies, plain.as_ref()).is_some());
        for frequency in [0.0, f64::NAN, f64::INFINITY] {
            let with = [1.0, 2.0, 3.0, 4.0, frequency];
            assert!(weakly_coupled(&with, plain.as_ref()).is_none());
        }
        let (roots, shapes) = weakly_coupled(&[], Mat::zeros(0, 0).as_ref()).expect("no mode");
        assert!(roots.is_empty() && shapes.is_empty());
    }
}
