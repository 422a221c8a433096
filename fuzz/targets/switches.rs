//! Machines with friction, stops, impacts and controlled dampers: answered in all precisions, events and bounds agree, and
//! periodic motions come back.

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
    let text = scene::switched_machine(&mut choices::Choices::of(bytes));
    if let Ok(scene) = Scene::parse(&text, Path::new("scene.json")) {
        examine::examined_with_switches(&scene);
    }
});
