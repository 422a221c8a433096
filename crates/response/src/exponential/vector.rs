//! Loops compiled for the vector units that the processor is found to have.

use pulp::{Arch, Simd, WithSimd};

/// Runs the kernel on the widest registers there are. What it calls must be inlined into it, so that
/// it is compiled for them too.
#[inline]
pub(crate) fn run<K: WithSimd>(kernel: K) -> K::Output {
    Arch::new().dispatch(kernel)
}

/// a·b + c, rounded once where the processor has an instruction for that, which are those that have
/// vectors too.
#[inline(always)]
pub(crate) fn multiply_add<S: Simd>(a: f64, b: f64, c: f64) -> f64 {
    if S::F64_LANES > 1 {
        a.mul_add(b, c)
    } else {
        a * b + c
    }
}
