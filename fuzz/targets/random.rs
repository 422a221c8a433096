//! Scenes drawn as those of the tests, and what is asked of their answers.

#[path = "../../tests/random/choices.rs"]
mod choices;
#[path = "../../tests/random/examine.rs"]
pub mod examine;
#[path = "../../tests/random/number.rs"]
mod number;
#[path = "../../tests/random/scene.rs"]
pub mod scene;

use std::path::Path;

use choices::Choices;
use eigentone::scene::Scene;

pub fn drawn(bytes: &[u8], draw: fn(&mut Choices<'_>) -> String) -> Option<Scene> {
    Scene::parse(&draw(&mut Choices::of(bytes)), Path::new("scene.json")).ok()
}
