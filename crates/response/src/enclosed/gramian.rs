//! Gramians of an exponential, ∫ e^{Wt} Q e^{Wᵀt} dt, with a proven bound.
//!
//! By doubling, P(2t) = P(t) + e^{Wt} P(t) e^{Wᵀt}, from a series over a short t. The exponential of [−W Q; 0 Wᵀ] (Van Loan
//! 1978, *IEEE Trans. Autom. Control* 23), which grows as e^{|λ|h} where the answer does not, is never taken. Once e^{Wt}
//! contracts, doubling ends (Smith 1968, *SIAM J. Appl. Math.* 16): P − P(t) = e^{Wt} P e^{Wᵀt}.

use eigentone_digits::{Magnitude, Real};

use super::exponential::exponential;
use super::normed::Normed;

/// How often an integral over all the time is doubled at most.
const DOUBLINGS: i64 = 1000;

/// ∫ e^{Wt} rate e^{Wᵀt} dt over a step in s, which is known to a relative error, or over all the time, with the step to begin
/// with; `None` where the digits of T do not suffice, or where it is to end by itself and does not.
pub(crate) fn gramian<T: Real>(
    w: &Normed<T>,
    rate: &Normed<T>,
    (step, off): (T, Magnitude),
    forever: bool,
) -> Option<Normed<T>> {
    // ‖W‖t ≤ ½.
    let size = w.true_norm() * step.upper();
    if !size.is_finite() {
        return None;
    }
    let halvings = (size.exponent() + 1).max(0);
    let short = step.scale(-halvings);
    let mut power = exponential(w, short, off);
    let mut sum = series(w, rate, (short, off));
    let most = if forever { DOUBLINGS } else { halvings };
    for _ in 0..most {
        // What a longer time adds is less than what all the time does.
        let left = left_out(&power, &sum).filter(|left| *left <= sum.true_norm() * T::unit());
        if let Some(left) = left {
            return Some(sum.with_more_error(left));
        }
        let carried = power.times(&sum).times(&power.transposed());
        sum = sum.plus(&carried);
        // Motions that have died out long ago leave the range of T.
        let (square, exponent) = power.times(&power).normalised();
        power = square.scaled(exponent);
        if !sum.error().is_finite() || power.error() >= Magnitude::from(1.0) {
            return None;
        }
    }
    (!forever).then_some(sum)
}

/// A bound of what the integral over all the time has beyond Q(t): ‖E‖²‖P‖ with ‖P‖ ≤ ‖Q‖/(1 − ‖E‖²); `None` unless
/// E = e^{At} contracts.
fn left_out<T: Real>(power: &Normed<T>, sum: &Normed<T>) -> Option<Magnitude> {
    let square = power.true_norm() * power.true_norm();
    let least = Magnitude::from(1.0).minus(square);
    (!least.is_zero()).then(|| square * sum.true_norm() / least)
}

/// Σ t^{k+1}/(k+1)! Lᵏ(Q) with L(X) = W X + X Wᵀ, for ‖W‖t ≤ ½: the terms fall faster than 1/(k + 1)!.
fn series<T: Real>(w: &Normed<T>, rate: &Normed<T>, (t, off): (T, Magnitude)) -> Normed<T> {
    let relative = T::unit() + T::unit() + off;
    let mut term = rate.times_scalar(t, off);
    let first = term.true_norm();
    let mut sum = term.clone();
    let mut tail = first;
    let mut k = 1.0;
    while !tail.is_zero() && T::unit() * first < tail {
        let once = w.times(&term);
        let factor = t / T::from(k + 1.0);
        term = once.plus(&once.transposed()).times_scalar(factor, relative);
        sum = sum.plus(&term);
        k += 1.0;
        // ‖term‖ ≤ first/k!, and the terms that follow are less than it together.
        tail = tail / Magnitude::from(k);
    }
    sum.with_more_error(tail)
}
