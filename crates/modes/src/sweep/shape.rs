//! The shape that belongs to a root, and the root that belongs to the shape.

use num_complex::Complex;

use crate::model::{Element, Node};

use super::design::Design;

/// λ²M + λC + K with room for its factors.
#[derive(Clone, Debug)]
pub(super) struct Shifted {
    /// n × n, column by column.
    q: Vec<Complex<f64>>,
    pivots: Vec<usize>,
}

impl Shifted {
    pub(super) fn new(n: usize) -> Shifted {
        Shifted {
            q: vec![Complex::ZERO; n * n],
            pivots: vec![0; n],
        }
    }

    /// The shape x with Q(λ)x ≈ 0, by two steps of inverse iteration from a start without pattern,
    /// which `seed` varies; its largest entry is 1.
    pub(super) fn shape(
        &mut self,
        design: &Design,
        [c, k]: [&[f64]; 2],
        lambda: Complex<f64>,
        seed: usize,
        x: &mut [Complex<f64>],
    ) {
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let n = x.len();
        let mut largest = 0.0f64;
        for (entry, (c, k)) in self.q.iter_mut().zip(c.iter().zip(k)) {
            *entry = lambda * *c + *k;
        }
        for (i, mass) in design.masses().iter().enumerate() {
            self.q[i + n * i] += lambda * lambda * *mass;
            largest = largest.max(mass * lambda.norm_sqr());
        }
        self.factor(n, largest * f64::EPSILON);
        for (i, entry) in x.iter_mut().enumerate() {
            *entry = Complex::from(0.5 + (GOLDEN * ((i + 1) * (seed + 1)) as f64).fract());
        }
        for _ in 0..2 {
            self.solve(x);
            unit(x);
        }
    }

    /// LU with row interchanges; pivots that vanish become `tiny`.
    fn factor(&mut self, n: usize, tiny: f64) {
        let q = &mut self.q;
        for p in 0..n {
            let size = |i: &usize| q[i + n * p].norm_sqr();
            let pivot = (p..n)
                .max_by(|a, b| size(a).total_cmp(&size(b)))
                .unwrap_or(p);
            self.pivots[p] = pivot;
            if pivot != p {
                for j in 0..n {
                    q.swap(p + n * j, pivot + n * j);
                }
            }
            if q[p + n * p].norm_sqr() <= tiny * tiny {
                q[p + n * p] = Complex::from(tiny.max(f64::MIN_POSITIVE));
            }
            let inverse = q[p + n * p].inv();
            for i in p + 1..n {
                q[i + n * p] *= inverse;
            }
            let (left, right) = q.split_at_mut(n * (p + 1));
            let column = &left[n * p + p + 1..];
            for other in right.chunks_exact_mut(n) {
                let (head, rest) = other[p..].split_at_mut(1);
                for (entry, factor) in rest.iter_mut().zip(column) {
                    *entry -= factor * head[0];
                }
            }
        }
    }

    fn solve(&self, x: &mut [Complex<f64>]) {
        let n = x.len();
        for p in 0..n {
            x.swap(p, self.pivots[p]);
            let (head, rest) = x[p..].split_at_mut(1);
            for (entry, factor) in rest.iter_mut().zip(&self.q[n * p + p + 1..]) {
                *entry -= factor * head[0];
            }
        }
        for p in (0..n).rev() {
            x[p] /= self.q[p + n * p];
            let (rest, head) = x[..=p].split_at_mut(p);
            for (entry, factor) in rest.iter_mut().zip(&self.q[n * p..]) {
                *entry -= factor * head[0];
            }
        }
    }
}

/// Makes the largest entry 1.
fn unit(x: &mut [Complex<f64>]) {
    let size = |x: &Complex<f64>| x.norm_sqr();
    let largest = x.iter().map(size).fold(0.0, f64::max);
    let Some(pivot) = x.iter().position(|entry| size(entry) >= largest) else {
        return;
    };
    let inverse = x[pivot].inv();
    if inverse.is_finite() {
        x.iter_mut().for_each(|entry| *entry *= inverse);
        x[pivot] = Complex::ONE;
    }
}

/// The root near λ of mλ² + cλ + k with m = xᵀMx, c = xᵀCx, k = xᵀKx, summed over the elements
/// (Lancaster 1966, *Lambda-matrices and vibrating systems*, §5.5); λ itself where that root is not
/// well defined.
pub(super) fn improved(
    design: &Design,
    x: &[Complex<f64>],
    lambda: Complex<f64>,
    is_undamped: bool,
) -> Complex<f64> {
    /// What the QR algorithm may be off by.
    const NEAR: f64 = 1e-6;
    let masses = design.masses().iter().zip(x);
    let m: Complex<f64> = masses.map(|(mass, x)| x * x * *mass).sum();
    let k = form(design.springs(), x);
    if is_undamped {
        let square = (k / m).re;
        return if (square.sqrt() - lambda.norm()).abs() <= NEAR * lambda.norm() {
            Complex::new(0.0, square.sqrt())
        } else {
            Complex::new(0.0, lambda.norm())
        };
    }
    let c = form(design.dampers(), x);
    let mut root = lambda;
    for _ in 0..2 {
        let step = ((m * root + c) * root + k) / (m * root * 2.0 + c);
        root -= step;
    }
    let off = (root - lambda).norm();
    let mut root = if off.is_finite() && off <= NEAR * lambda.norm() {
        root
    } else {
        lambda
    };
    if lambda.im == 0.0 {
        root.im = 0.0;
    }
    // Nothing that only resists can make a motion grow.
    root.re = root.re.min(0.0);
    root
}

/// Σ c(x_a − x_b)².
fn form(elements: &[Element], x: &[Complex<f64>]) -> Complex<f64> {
    let at = |node: Node| node.coordinate().map_or(Complex::ZERO, |i| x[i]);
    let each = elements.iter().map(|element| {
        let stretch = at(element.first) - at(element.second);
        stretch * stretch * element.coefficient
    });
    each.sum()
}
