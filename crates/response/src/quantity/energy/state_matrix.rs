//! A and B of z′ = A z + B f for lumped masses, in any precision.

use eigentone_digits::Real;
use eigentone_modes::{MatrixKind, System};

/// The masses, where each coordinate has its own and nothing else has inertia.
pub(super) fn lumped(system: &System) -> Option<&[f64]> {
    let masses = system.masses();
    let all = system.added(MatrixKind::Mass).is_none() && masses.iter().all(|mass| *mass != 0.0);
    all.then_some(masses)
}

/// A and B of z = (x, v), from the elements: no sum of springs is rounded to doubles.
pub(super) fn state_matrix<T: Real>(system: &System, masses: &[f64]) -> (Vec<T>, Vec<T>) {
    let n = system.len();
    let mut a = vec![T::ZERO; 4 * n * n];
    let mut b = vec![T::ZERO; 2 * n * n];
    let mut add = |i: usize, j: usize, value: f64| {
        let at = &mut a[(n + i) * 2 * n + j];
        *at = *at - T::from(value);
    };
    for (kind, from) in [(MatrixKind::Stiffness, 0), (MatrixKind::Damping, n)] {
        for term in system.terms(kind) {
            add(term.row, from + term.column, term.value);
        }
    }
    for (i, mass) in masses.iter().enumerate() {
        a[i * 2 * n + n + i] = T::ONE;
        b[(n + i) * n + i] = T::ONE / T::from(*mass);
        for entry in &mut a[(n + i) * 2 * n..][..2 * n] {
            *entry = *entry / T::from(*mass);
        }
    }
    (a, b)
}
