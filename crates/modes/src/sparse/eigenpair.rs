//! An eigenvalue with its shape, as it was found.

use num_complex::Complex;

/// An approximate eigenpair (λ²M + λC + K) x ≈ 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Eigenpair {
    /// λ in 1/s.
    pub value: Complex<f64>,
    /// x, an entry for each coordinate, of any length and phase.
    pub shape: Vec<Complex<f64>>,
}
