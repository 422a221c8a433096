//! The processor's vector registers after products of whole matrices.

use std::hint::black_box;

use pulp::Arch;

/// Clears the upper halves of the vector registers. The kernels of faer's products leave something in
/// them, and x86 processors run code for the lower halves, which is what compilers make of ordinary
/// arithmetic, half as fast from then on. A function compiled for whole registers clears them as it returns.
pub fn settle() {
    let mut lanes = [1.0f64; 8];
    Arch::new().dispatch(|| {
        for lane in black_box(&mut lanes) {
            *lane += 1.0;
        }
    });
    black_box(lanes);
}
