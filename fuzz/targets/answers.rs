//! Scenes that keep to the format, of every size of numbers: answered in all precisions, and no two proofs contradict each
//! other. Estimates are not compared.

#![no_main]

mod random;

use libfuzzer_sys::fuzz_target;
use random::examine::{Proven, examined};

fuzz_target!(|bytes: &[u8]| {
    if let Some(scene) = random::drawn(bytes, random::scene::text) {
        examined(&scene, Proven::All);
    }
});
