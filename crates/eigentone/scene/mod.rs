//! The scene file: one vibrating system, its initial state, its loads and its instants, as JSON.
//!
//! `docs/scene.md` describes the format and `docs/scene.schema.json` is its JSON Schema. Reading is
//! strict: what is not part of the format, and what is said twice, is an error, and every error
//! names the file, the place in it, what is wrong and what would be right.

mod assemble;
mod error;
mod layout;
mod matrix_market;
mod place;
mod shape;
mod text;
mod words;

use std::path::Path;

use eigentone_modes::System;
use eigentone_response::{AppliedLoad, Problem, ResponseError, State, TimeGrid};

pub use error::{MAX_BYTES, SceneError};
pub use matrix_market::{MAX_MATRIX_BYTES, MAX_MATRIX_MEMORY, MatrixMarketError};
pub use place::Place;

/// A scene that has been read and checked.
#[derive(Clone, Debug)]
pub struct Scene {
    title: Option<String>,
    system: System,
    initial: State,
    loads: Vec<AppliedLoad>,
    grid: Option<TimeGrid>,
}

impl Scene {
    /// Reads and checks a scene file.
    ///
    /// # Errors
    /// [`SceneError`] naming the file, the place in it, what is wrong and what would be right.
    pub fn read(path: &Path) -> Result<Scene, SceneError> {
        Scene::parse(&text::read(path)?, path)
    }

    /// Checks the text of a scene; `file` is named in errors, and beside it are the Matrix Market files
    /// that the scene names.
    ///
    /// # Errors
    /// As [`read`](Scene::read), without those of reading the scene itself.
    ///
    /// ```
    /// use eigentone::scene::Scene;
    ///
    /// let text = r#"{ "masses": [{"name": "m", "mass": 2}],
    ///                 "springs": [{"between": ["ground", "m"], "stiffness": 8}] }"#;
    /// let scene = Scene::parse(text, "example.json".as_ref())?;
    /// assert_eq!(scene.system().names(), ["m"]);
    /// assert!(scene.problem().is_none());
    ///
    /// let error = Scene::parse(&text.replace("8", "null"), "example.json".as_ref()).unwrap_err();
    /// let message = "example.json:2:74: springs[0].stiffness: expected a number, found null";
    /// assert_eq!(error.to_string(), message);
    /// # Ok::<(), eigentone::scene::SceneError>(())
    /// ```
    pub fn parse(text: &str, file: &Path) -> Result<Scene, SceneError> {
        let source = text::Source::new(text, file)?;
        assemble::scene(source.layout()?, &source)
    }

    /// The title, if it has one.
    pub fn title(&self) -> Option<&str> {
        self.title.as_deref()
    }

    /// The system it describes.
    pub fn system(&self) -> &System {
        &self.system
    }

    /// The response it asks for, or `None` if it has no `time`.
    ///
    /// # Errors
    /// None after [`read`](Scene::read), which checks the same; the type is the library's.
    pub fn problem(&self) -> Option<Result<Problem<'_>, ResponseError>> {
        let grid = self.grid?;
        Some(Problem::new(
            &self.system,
            &self.initial,
            self.loads.clone(),
            grid,
        ))
    }
}
