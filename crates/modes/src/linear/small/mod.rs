//! The eigenproblem of a small real matrix on plain slices, n × n, column by column: quicker than routines that are
//! made for large ones.

mod balance;
mod francis;
mod hessenberg;
mod inverse_iteration;

use num_complex::Complex;

use francis::francis;
use hessenberg::{Reflections, hessenberg};
use inverse_iteration::Shifted;

/// All eigenvalues of `a`, balanced first, which is overwritten; `None` where the iteration does not converge, or one leaves the
/// range of doubles.
pub(crate) fn eigenvalues(a: &mut [f64], n: usize, roots: &mut [Complex<f64>]) -> Option<()> {
    balance::balance(a, n);
    let largest = a.iter().fold(0.0, |top: f64, entry| top.max(entry.abs()));
    let unit = Unit::of(largest);
    if !unit.is_one() {
        a.iter_mut().for_each(|entry| *entry = unit.divide(*entry));
    }
    hessenberg(a, n, |_, _, _| ());
    francis(a, n, roots)?;
    if !unit.is_one() {
        for root in roots.iter_mut() {
            *root = Complex::new(unit.multiply(root.re), unit.multiply(root.im));
        }
    }
    roots.iter().all(|root| root.is_finite()).then_some(())
}

/// A power of two that brings a matrix near 1, where squares and products of its entries would leave the range of doubles; else 1.
#[derive(Clone, Copy)]
pub(crate) struct Unit {
    /// Both powers of two, of which the product may be none.
    halves: [f64; 2],
}

impl Unit {
    /// For a matrix with this largest entry.
    pub(crate) fn of(largest: f64) -> Unit {
        const FEW: std::ops::Range<f64> = 1e-100..1e100;
        if FEW.contains(&largest) || largest == 0.0 || !largest.is_finite() {
            return Unit { halves: [1.0; 2] };
        }
        // Above −1075 and below 1024: halves are in range.
        let half = (0.5 * largest.log2()).round();
        Unit {
            halves: [half.exp2(); 2],
        }
    }

    fn is_one(&self) -> bool {
        self.halves == [1.0; 2]
    }

    pub(crate) fn divide(&self, value: f64) -> f64 {
        value / self.halves[0] / self.halves[1]
    }

    pub(crate) fn multiply(&self, value: f64) -> f64 {
        value * self.halves[0] * self.halves[1]
    }
}

/// Eigenvalues, one of each conjugate pair, and their vectors, of any length.
pub(crate) struct Eigenpairs {
    pub(crate) values: Vec<Complex<f64>>,
    pub(crate) right: Vec<Vec<Complex<f64>>>,
    /// w with w*A = λw*, where they were asked for.
    pub(crate) left: Option<Vec<Vec<Complex<f64>>>>,
}

/// The eigenvalues of a balanced matrix by the QR algorithm, and the vectors of its Hessenberg form by inverse
/// iteration (Peters & Wilkinson 1979, *SIAM Review* 21). `None` where these are not as good as those that come with the
/// eigenvalues: where roots are close to each other, or small beside the largest, or the iteration does not converge.
pub(crate) fn eigenpairs(a: &[f64], n: usize, with_left: bool) -> Option<Eigenpairs> {
    const CLOSE: f64 = 1e-4;
    const SMALL: f64 = 1e-6;
    let mut h = a.to_vec();
    let mut reflections = Reflections::new(n);
    hessenberg(&mut h, n, |start, scale, v| {
        reflections.keep(start, scale, v)
    });
    let size = h.iter().fold(0.0, |top: f64, entry| top.max(entry.abs()));
    let mut shifted = Shifted::of(&h, n);
    let mut roots = vec![Complex::ZERO; n];
    francis(&mut h, n, &mut roots)?;

    let are_apart = |i: usize| {
        let norm = roots[i].norm();
        let reach = CLOSE * norm;
        let meets = |other: &Complex<f64>| {
            let apart = roots[i] - other;
            apart.re.abs() < reach && apart.im.abs() < reach
        };
        norm >= SMALL * size && !roots[..i].iter().any(meets)
    };
    if !(0..n).all(are_apart) {
        return None;
    }
    roots.retain(|root| root.im >= 0.0);
    let mut pairs = Eigenpairs {
        right: Vec::with_capacity(roots.len()),
        left: with_left.then(|| Vec::with_capacity(roots.len())),
        values: roots,
    };
    for value in &pairs.values {
        shifted.factor(*value);
        let mut vector = shifted.right()?;
        reflections.apply(&mut vector);
        pairs.right.push(vector);
        if let Some(left) = &mut pairs.left {
            let mut vector = shifted.left()?;
            reflections.apply(&mut vector);
            left.push(vector);
        }
    }
    Some(pairs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// A x = λ x and w*A = λ w* to a few units of the matrix's size, and all roots: their sum is the trace.
        #[test]
        fn vectors_solve_their_equations(
            n in 1..24usize,
            entries in prop::collection::vec(-1.0..1.0f64, 24 * 24),
        ) {
            let a = &entries[..n * n];
            let Some(pairs) = eigenpairs(a, n, true) else {
                return Ok(());
            };
            let near = 1e-13 * n as f64;
            let twice = |value: &Complex<f64>| if value.im == 0.0 { value.re } else { 2.0 * value.re };
            let trace: f64 = (0..n).map(|i| a[i + n * i]).sum();
            let sum: f64 = pairs.values.iter().map(twice).sum();
            prop_assert!((sum - trace).abs() < near, "{sum} {trace}");
            let left = pairs.left.as_ref().unwrap();
            for ((value, x), w) in pairs.values.iter().zip(&pairs.right).zip(left) {
                for vector in [x, w] {
                    let largest = vector.iter().map(Complex::l1_norm).fold(0.0, f64::max);
                    prop_assert!((0.3..3.0).contains(&largest));
                }
                for i in 0..n {
                    let row: Complex<f64> = (0..n).map(|j| x[j] * a[i + n * j]).sum();
                    prop_assert!((row - value * x[i]).norm() < near);
                    let column: Complex<f64> = (0..n).map(|j| w[j].conj() * a[j + n * i]).sum();
                    prop_assert!((column - value * w[i].conj()).norm() < near);
                }
            }
        }
    }

    #[test]
    fn what_is_close_is_left_to_others() {
        // A Jordan block, and the identity.
        assert!(eigenpairs(&[2.0, 0.0, 1.0, 2.0], 2, false).is_none());
        assert!(eigenpairs(&[1.0, 0.0, 0.0, 1.0], 2, false).is_none());
        assert!(eigenpairs(&[1.0, 0.0, 0.0, 1e-7], 2, false).is_none());
        assert!(eigenpairs(&[1.0, 0.0, 0.0, 2.0], 2, false).is_some());
        // Nothing that is not a number comes back, whatever the units.
        for size in [f64::INFINITY, f64::NAN, 1e300, 1e160, 1e-160, 1e-300, 0.0] {
            let a = [size, -size, 2.0 * size, -0.5 * size];
            if let Some(pairs) = eigenpairs(&a, 2, true) {
                let vectors = pairs.right.iter().chain(pairs.left.iter().flatten());
                assert!(vectors.flatten().all(|entry| entry.is_finite()), "{size:e}");
            }
        }
    }
}
