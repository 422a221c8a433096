//! The state between two steps by two-point Hermite interpolation (any textbook: Stoer & Bulirsch,
//! *Introduction to Numerical Analysis*, §2.1.5). The equation of motion is linear, so further
//! derivatives of the state cost one evaluation each; three of them at both ends give degree 7 and
//! an error of at most (h/2)^8/8! times the eighth derivative, far below that of a step of h.

use super::equation::{EquationOfMotion, Forces};

/// The state [x; x′] and its first three derivatives at one instant.
pub(super) struct Jet {
    elapsed: f64,
    derivatives: [Vec<f64>; 4],
}

impl Jet {
    /// How many evaluations a jet takes.
    pub(super) const EVALUATIONS: u64 = 3;

    /// The jet of a state `elapsed` s after the forces' piece began.
    pub(super) fn of(
        equation: &EquationOfMotion,
        forces: &Forces<'_>,
        elapsed: f64,
        state: &[f64],
    ) -> Jet {
        let n = equation.len();
        let next = |order: u8, state: &[f64]| {
            let mut next = vec![0.0; 2 * n];
            next[..n].copy_from_slice(&state[n..]);
            equation.derivative(order, state, forces, elapsed, &mut next[n..]);
            next
        };
        let first = next(0, state);
        let second = next(1, &first);
        let third = next(2, &second);
        Jet {
            elapsed,
            derivatives: [state.to_vec(), first, second, third],
        }
    }

    /// The state at an instant between this and a later jet.
    pub(super) fn state_before(&self, later: &Jet, elapsed: f64, state: &mut [f64]) {
        let step = later.elapsed - self.elapsed;
        let ahead = (elapsed - self.elapsed) / step;
        let left = weights(ahead);
        let right = weights(1.0 - ahead);
        state.fill(0.0);
        // The right end sees time run backwards: odd derivatives change their sign.
        let (mut forth, mut back) = (1.0, 1.0);
        for order in 0..4 {
            let (a, b) = (left[order] * forth, right[order] * back);
            let ends = self.derivatives[order]
                .iter()
                .zip(&later.derivatives[order]);
            for (value, (start, end)) in state.iter_mut().zip(ends) {
                *value += a * start + b * end;
            }
            forth *= step;
            back *= -step;
        }
    }
}

/// The weights of f, h f′, h² f″, h³ f‴ at the near end, for a point θ of the way from it:
/// θ^k/k! (1−θ)⁴ Σ_{j ≤ 3−k} C(3+j, j) θ^j.
fn weights(theta: f64) -> [f64; 4] {
    let far = (1.0 - theta).powi(4);
    let t = theta;
    [
        far * (1.0 + t * (4.0 + t * (10.0 + t * 20.0))),
        far * t * (1.0 + t * (4.0 + t * 10.0)),
        far * t * t / 2.0 * (1.0 + t * 4.0),
        far * t * t * t / 6.0,
    ]
}
