//! What an answer took.

/// What an exact answer took, as far as it can be counted apart from run time; of a certified one, what the
/// attempt took whose digits sufficed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Operations {
    /// Matrix exponentials; one for each mode where every mode moves by itself.
    pub exponentials: u64,
    /// Products of matrices of the order of the state that they took, squarings included.
    pub products: f64,
    /// Steps of time, each a product of matrix and vector.
    pub steps: u64,
}
