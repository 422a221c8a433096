//! Starting vectors that are the same in every run.

/// A number between −1 and 1, by Marsaglia's xorshift (2003, *J. Stat. Softw.* 8).
pub(crate) fn uniform(state: &mut u64) -> f64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    (*state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}
