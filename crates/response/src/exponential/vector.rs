//! Loops compiled for the vector units that the processor is found to have.

use std::hint::black_box;

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

/// Clears the upper halves of the vector registers, which products of whole matrices leave such that ordinary arithmetic
/// runs half as fast after them.
pub(crate) fn settle() {
    struct Clear([f64; 8]);
    impl WithSimd for &mut Clear {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, _: S) {
            for lane in black_box(&mut self.0) {
                *lane += 1.0;
            }
        }
    }
    let mut lanes = Clear([1.0; 8]);
    run(&mut lanes);
    black_box(lanes.0);
}
