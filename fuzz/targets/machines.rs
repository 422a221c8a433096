//! Machines: points on masses and supports, supports that move, damping of the whole, outputs. Answered in all precisions, and
//! no two proofs contradict each other.

#![no_main]

#[path = "../../tests/random/choices.rs"]
mod choices;
#[path = "../../tests/random/examine.rs"]
mod examine;
#[path = "../../tests/random/number.rs"]
mod number;
#[path = "../../tests/random/scene.rs"]
mod scene;

use std::path::Path;

use eigentone::scene::Scene;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let text = scene::machine(&mut choices::Choices::of(bytes));
    if let Ok(scene) = Scene::parse(&text, Path::new("scene.json")) {
        examine::examined(&scene, examine::Proven::All);
    }
});
