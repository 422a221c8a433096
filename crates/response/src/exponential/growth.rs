//! A bound of e^{At} that rounding errors cannot exceed.

use eigentone_digits::symmetric_eigenvalues;
use faer::{Mat, MatRef};

/// ‖e^{At}‖₂ ≤ e^{μt} with the logarithmic norm μ, the largest eigenvalue of (A + Aᵀ)/2 (Dahlquist
/// 1958; Ström 1975, SIAM J. Numer. Anal. 12).
///
/// When ‖A‖u exceeds 1, no phase of a fast oscillation is known any more, and the rounding errors
/// of the squarings alone would let it grow without end. This keeps its size right.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Growth {
    /// μ / ln 2: how often the bound doubles in a unit of time.
    doublings: f64,
}

impl Growth {
    /// The bound for A, to rounding: a μ that rounding alone could have made positive is taken as 0.
    pub(crate) fn of(a: MatRef<'_, f64>) -> Growth {
        let n = a.nrows();
        let size = a.norm_max();
        if size == 0.0 || !size.is_finite() {
            let doublings = if size == 0.0 { 0.0 } else { f64::INFINITY };
            return Growth { doublings };
        }
        let half = Mat::from_fn(n, n, |i, j| 0.5 * (a[(i, j)] / size + a[(j, i)] / size));
        let largest = match symmetric_eigenvalues(&half) {
            Some(values) => values.last().copied().unwrap_or(0.0),
            None => f64::INFINITY,
        };
        let doubt = 4.0 * (n * n) as f64 * f64::EPSILON;
        let mu = if largest.abs() <= doubt {
            0.0
        } else {
            largest + doubt
        };
        Growth {
            doublings: mu * size / std::f64::consts::LN_2,
        }
    }

    /// A bound of ‖e^{As}‖₂ for all s from 0 to `time`.
    pub(crate) fn until(self, time: f64) -> f64 {
        (self.doublings.max(0.0) * time).exp2()
    }

    /// By how many powers of two (S + X)·2^exponent, S the diagonal matrix of `ones`, exceeds every
    /// e^{At}, and 0 if it need not: ‖·‖_F/√n is at most ‖·‖₂.
    pub(super) fn excess(self, x: &[f64], ones: &[f64], exponent: i64, time: f64) -> f64 {
        let n = ones.len();
        let mut squares: f64 = x.iter().map(|entry| entry * entry).sum();
        for (entry, one) in x.iter().step_by(n + 1).zip(ones) {
            squares += one * (2.0 * entry + one);
        }
        let size = 0.5 * (squares / n as f64).log2() + exponent as f64;
        // f64::max passes over NaN, and nothing exceeds an infinite bound.
        (size - self.doublings * time).max(0.0)
    }
}
