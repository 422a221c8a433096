//! Differences of eighth order.

/// Weights of nine values 1 apart for the first derivative at the one in place `at`, from 0: exact for polynomials of degree eight.
///
/// # Panics
/// If `at` is beyond 8.
pub fn difference(at: usize) -> [f64; 9] {
    assert!(at <= 8, "there are nine values");
    let product = |k: usize, without: usize, from: usize| -> f64 {
        let others = (0..9usize).filter(|m| *m != k && *m != without);
        others.map(|m| from as f64 - m as f64).product()
    };
    std::array::from_fn(|k| match k == at {
        true => {
            let others = (0..9usize).filter(|m| *m != at);
            others.map(|m| 1.0 / (at as f64 - m as f64)).sum()
        }
        false => product(k, at, at) / product(k, k, k),
    })
}
