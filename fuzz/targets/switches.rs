//! Machines with friction, stops, impacts and controlled dampers: answered in all precisions, events and bounds agree, and
//! periodic motions come back.

#![no_main]

mod random;

use libfuzzer_sys::fuzz_target;
use random::examine::examined_with_switches;

fuzz_target!(|bytes: &[u8]| {
    if let Some(scene) = random::drawn(bytes, random::scene::switched_machine) {
        examined_with_switches(&scene);
    }
});
