//! Solutions of the dynamic equations by an approximate inverse, proved by what it leaves of them.
//!
//! With any S and F = I − SZ the error of any x̃ is e = S(f − Zx̃) + Fe. Where F is small in some lengths, a residual
//! bounds e, whatever x̃ is (Rump 2010, *Acta Numerica* 19, section 10).

use eigentone_digits::{Ball, ComplexDoubleDouble, Real, WideComplex};
use num_complex::Complex;

/// By so much bounds are rounded up: they are sums of doubles, of a few thousand terms at most.
pub(super) const UPWARD: f64 = 1.0 + 1e-9;

/// Absorbs what underflows.
pub(super) const FLOOR: f64 = 1e-300;

/// The largest of some numbers, or NaN where one is NaN.
pub(super) fn largest(numbers: impl Iterator<Item = f64>) -> f64 {
    numbers.fold(0.0, |top: f64, number| {
        if top.is_nan() || number <= top {
            top
        } else {
            number
        }
    })
}

/// S, and what it leaves of the dynamic stiffness Z, whose entries have the digits of T.
pub(super) trait ApproximateInverse<T: Real> {
    /// S f, in so many digits that errors of doubles are within the span of the columns of S.
    fn apply(&self, right: &[Complex<f64>]) -> Vec<ComplexDoubleDouble>;

    /// |S| f, from above.
    fn sizes(&self, right: &[f64]) -> Vec<f64>;

    /// Z x.
    fn times(&self, x: &[Ball<T>]) -> Vec<Ball<T>>;

    /// Lengths, and the norm of F in them, which is below ½.
    fn defect(&self) -> (&[f64], f64);

    /// An enclosure of Z⁻¹f.
    fn solve(&self, right: &[Ball<T>]) -> Option<Vec<Ball<T>>> {
        /// Each leaves as much of the error as the norm of F says, or what the digits do not hold.
        const STEPS: usize = 3;
        const MOST: usize = 12;
        /// Steps that leave more of the work of the residual are the last.
        const WORTH: f64 = 1e-2;
        let (lengths, norm) = self.defect();
        let mut x = vec![WideComplex::<T>::ZERO; right.len()];
        let mut residual = right.to_vec();
        let mut before = f64::INFINITY;
        for step in 0..MOST {
            let doubles = residual.iter().map(|rest| rest.middle());
            let doubles = doubles.map(|rest| Complex::new(rest.re.to_f64(), rest.im.to_f64()));
            let change = self.apply(&doubles.collect::<Vec<_>>());
            for (x, change) in x.iter_mut().zip(change) {
                for (part, change) in [(&mut x.re, change.re), (&mut x.im, change.im)] {
                    *part = *part + T::from(change.high()) + T::from(change.low());
                }
            }
            let moved = self.times(&x.iter().copied().map(Ball::from).collect::<Vec<_>>());
            let rest = right.iter().zip(moved).map(|(right, moved)| *right - moved);
            residual = rest.collect();
            let terms = residual.iter().zip(lengths);
            let work = terms
                .map(|(rest, length)| rest.middle().norm() * length)
                .sum();
            if step + 1 >= STEPS && work > before * WORTH {
                break;
            }
            before = work;
        }
        let left: Vec<f64> = residual
            .iter()
            .map(|residual| residual.upper().to_f64() * UPWARD + FLOOR)
            .collect();
        let error = self.sizes(&left);
        let ratios = error.iter().zip(lengths);
        let ratio = largest(ratios.map(|(error, length)| error / length));
        let more = ratio * norm / (1.0 - norm) * UPWARD;
        let enclosed = x.into_iter().zip(error).zip(lengths);
        enclosed
            .map(|((x, error), length)| {
                let radius = (error + length * more) * UPWARD + FLOOR;
                radius.is_finite().then(|| Ball::new(x, radius.into()))
            })
            .collect()
    }
}
