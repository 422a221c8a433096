//! Many steps of a grid at a time, towards few outputs.

use super::estimate::Detour;
use crate::answer::Operations;

/// The name of the method that steps by exponentials of the whole state.
pub(crate) const BY_EXPONENTIAL: &str = "exponential";

/// That of the one that steps mode by mode.
pub(crate) const BY_SUPERPOSITION: &str = "superposition";

/// A march of which nothing but its outputs is kept.
pub(crate) trait Strides {
    /// The name of the method.
    fn method(&self) -> &'static str;

    /// Steps are taken in multiples of this.
    fn multiple(&self) -> usize;

    /// So many are best taken together.
    fn together(&self) -> usize;

    /// Takes so many steps, under the values of the loads at their starts and at the end of the last one, load
    /// after load; writes the outputs at the end of each, step after step.
    fn advance(&mut self, loads: &[f64], values: &mut [f64], steps: usize);

    /// Goes on with the deviation from this state, if that is near; whether it is.
    fn deviate(&mut self, rest: &[f64]) -> bool;

    /// What modes make of rounding errors, if it goes by way of them.
    fn detour(&self) -> Option<Detour>;

    /// The largest displacement and velocity that it came by so far.
    fn largest(&self) -> [f64; 2];

    /// Whether the state reached is in the range of doubles.
    fn is_finite(&self) -> bool;

    /// What it took so far.
    fn operations(&self) -> Operations;
}

/// The largest size.
pub(crate) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |top, value| top.max(value.abs()))
}

/// Whether no value is infinite or NaN.
pub(crate) fn all_finite(values: &[f64]) -> bool {
    const LANES: usize = 8;
    let (blocks, rest) = values.as_chunks::<LANES>();
    // 0·∞ is NaN, and what is added to it stays so.
    let mut sums = [0.0; LANES];
    for block in blocks {
        for (sum, value) in sums.iter_mut().zip(block) {
            *sum += 0.0 * value;
        }
    }
    sums.iter().chain(rest).all(|value| value.is_finite())
}
