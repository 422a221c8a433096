//! The polynomial of collocation: of degree 3, through the start of a step and its three stages.

use super::tableau::C;

/// The polynomial of one step.
pub(super) struct Collocation {
    start: f64,
    h: f64,
    /// The state at the end of the step.
    end: Vec<f64>,
    /// Divided differences in (t − t₁)/h at the nodes 0, c₂ − 1, c₁ − 1, −1.
    differences: [Vec<f64>; 3],
}

impl Collocation {
    /// From the state at the end of the step, and the stages less the state at its start.
    pub(super) fn of(start: f64, h: f64, end: &[f64], z: &[Vec<f64>; 3]) -> Collocation {
        let mut differences = [end.to_vec(), end.to_vec(), end.to_vec()];
        for i in 0..end.len() {
            let (z1, z2, z3) = (z[0][i], z[1][i], z[2][i]);
            let from_2 = (z2 - z3) / (C[1] - 1.0);
            let from_1 = (z1 - z2) / (C[0] - C[1]);
            let second = (from_1 - from_2) / (C[0] - 1.0);
            let at_start = (from_1 - z1 / C[0]) / C[1];
            differences[0][i] = from_2;
            differences[1][i] = second;
            differences[2][i] = second - at_start;
        }
        Collocation {
            start,
            h,
            end: end.to_vec(),
            differences,
        }
    }

    /// The state at an instant; beyond the step, the polynomial continued.
    pub(super) fn at(&self, elapsed: f64, state: &mut [f64]) {
        let s = (elapsed - self.start) / self.h - 1.0;
        let [first, second, third] = &self.differences;
        for (i, value) in state.iter_mut().enumerate() {
            let inner = second[i] + (s - (C[0] - 1.0)) * third[i];
            *value = self.end[i] + s * (first[i] + (s - (C[1] - 1.0)) * inner);
        }
    }
}
