//! The scene file: one vibrating system, its initial state, its loads and its instants, as JSON.

use std::path::{Path, PathBuf};

use eigentone_modes::System;
use eigentone_response::{Problem, ResponseError};
use thiserror::Error;

/// A scene that has been read and checked.
#[derive(Clone, Debug)]
pub struct Scene {}

impl Scene {
    /// Reads and checks a scene file.
    ///
    /// # Errors
    /// [`SceneError`] naming the file, the place in it, what is wrong and what would be right.
    pub fn read(_path: &Path) -> Result<Scene, SceneError> {
        todo!()
    }

    /// The title, if it has one.
    pub fn title(&self) -> Option<&str> {
        todo!()
    }

    /// The system it describes.
    pub fn system(&self) -> &System {
        todo!()
    }

    /// The response it asks for, or `None` if it has no `time`.
    ///
    /// # Errors
    /// None after [`read`](Scene::read), which checks the same; the type is the library's.
    pub fn problem(&self) -> Option<Result<Problem<'_>, ResponseError>> {
        todo!()
    }
}

/// What is wrong with a scene file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// It cannot be read.
    #[error("{}: cannot be read: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
}
