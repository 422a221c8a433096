//! Scenes that keep to the format, of every size of numbers: answered in all precisions, and no two proofs contradict each
//! other. Estimates are not compared.

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
    let text = scene::text(&mut choices::Choices::of(bytes));
    if let Ok(scene) = Scene::parse(&text, Path::new("scene.json")) {
        examine::examined(&scene, examine::Proven::All);
    }
});
