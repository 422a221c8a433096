//! Random numbers that are alike in all runs.

/// A linear congruential generator (Press et al. 2007, *Numerical Recipes*, section 7.1.2).
pub(super) struct Random(pub(super) u64);

impl Random {
    /// From [−1, 1).
    pub(super) fn signed(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(2_862_933_555_777_941_757)
            .wrapping_add(3_037_000_493);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}
