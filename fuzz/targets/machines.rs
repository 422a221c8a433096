//! Machines: points on masses and supports, supports that move, damping of the whole, outputs. Answered in all precisions, and
//! no two proofs contradict each other.

#![no_main]

mod random;

use libfuzzer_sys::fuzz_target;
use random::examine::{Proven, examined};

fuzz_target!(|bytes: &[u8]| {
    if let Some(scene) = random::drawn(bytes, random::scene::machine) {
        examined(&scene, Proven::All);
    }
});
