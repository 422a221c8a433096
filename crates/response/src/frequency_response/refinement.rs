//! Solutions of the dynamic equations by an approximate inverse, proved by what it leaves of them.
//!
//! With any S and F = I − SZ the error of any x̃ is e = S(f − Zx̃) + Fe. Where F is small in some lengths, a residual
//! bounds e, whatever x̃ is (Rump 2010, *Acta Numerica* 19, section 10).

use eigentone_digits::{Ball, ComplexDoubleDouble, DoubleDouble};
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

/// S, and what it leaves of the dynamic stiffness Z.
pub(super) trait ApproximateInverse {
    /// S f in doubles.
    fn apply(&self, right: &[Complex<f64>]) -> Vec<Complex<f64>>;

    /// |S| f, from above.
    fn sizes(&self, right: &[f64]) -> Vec<f64>;

    /// f − Zx.
    fn left(
        &self,
        right: &[Ball<DoubleDouble>],
        x: &[ComplexDoubleDouble],
    ) -> Vec<Ball<DoubleDouble>>;

    /// Lengths, and the norm of F in them, which is below ½.
    fn defect(&self) -> (&[f64], f64);

    /// An enclosure of Z⁻¹f.
    fn solve(&self, right: &[Ball<DoubleDouble>]) -> Option<Vec<Ball<DoubleDouble>>> {
        /// Each leaves as much of the error as the norm of F says, or what double-double does not hold.
        const STEPS: usize = 2;
        let mut x = vec![ComplexDoubleDouble::ZERO; right.len()];
        let mut residual = right.to_vec();
        for _ in 0..=STEPS {
            let middles = residual.iter().map(|residual| {
                let middle = residual.middle();
                Complex::new(middle.re.to_f64(), middle.im.to_f64())
            });
            let step = self.apply(&middles.collect::<Vec<_>>());
            for (x, step) in x.iter_mut().zip(step) {
                x.re += DoubleDouble::from(step.re);
                x.im += DoubleDouble::from(step.im);
            }
            residual = self.left(right, &x);
        }
        let left: Vec<f64> = residual
            .iter()
            .map(|residual| residual.upper().to_f64() * UPWARD + FLOOR)
            .collect();
        let error = self.sizes(&left);
        let (lengths, norm) = self.defect();
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
