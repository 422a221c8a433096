//! What can go wrong, and the exit status it ends with.

use std::io;
use std::path::{Path, PathBuf};

use eigentone::modes::ModesError;
use eigentone::response::ResponseError;
use eigentone::scene::SceneError;
use eigentone::tables::TableError;
use thiserror::Error;

/// Why a command has no result.
#[derive(Debug, Error)]
pub enum Failure {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(
        "{}: it has no `time`, so there is no response: add \"time\": {{\"end\": …, \"step\": …}}",
        scene.display()
    )]
    NoTime { scene: PathBuf },
    #[error(
        "--tolerance cannot be held with --precision double, which only estimates: leave out one of the two"
    )]
    ToleranceInDoubles,
    #[error("{}: {error}", scene.display())]
    Modes { scene: PathBuf, error: ModesError },
    #[error("{}: {error}", scene.display())]
    Response {
        scene: PathBuf,
        error: ResponseError,
    },
    #[error("{}: {error}", scene.display())]
    Table { scene: PathBuf, error: TableError },
    #[error("{}: cannot be written: {error}", file.display())]
    Write { file: PathBuf, error: io::Error },
    #[error("standard output cannot be written: {0}")]
    Output(io::Error),
}

impl Failure {
    pub fn modes(scene: &Path) -> impl FnOnce(ModesError) -> Failure {
        let scene = scene.to_owned();
        |error| Failure::Modes { scene, error }
    }

    pub fn response(scene: &Path) -> impl FnOnce(ResponseError) -> Failure {
        let scene = scene.to_owned();
        |error| Failure::Response { scene, error }
    }

    pub fn table(scene: &Path) -> impl FnOnce(TableError) -> Failure {
        let scene = scene.to_owned();
        |error| Failure::Table { scene, error }
    }

    /// 2 where what was asked is wrong, 1 where the answer could not be had or written.
    pub fn status(&self) -> u8 {
        match self {
            Failure::Scene(_) | Failure::NoTime { .. } | Failure::ToleranceInDoubles => 2,
            Failure::Response { error, .. } => match error {
                ResponseError::NotApplicable { .. }
                | ResponseError::Overflow { .. }
                | ResponseError::Stopped { .. }
                | ResponseError::Modes(_) => 1,
                _ => 2,
            },
            Failure::Table {
                error: TableError::Response(_),
                ..
            } => 2,
            Failure::Modes { .. }
            | Failure::Table { .. }
            | Failure::Write { .. }
            | Failure::Output(_) => 1,
        }
    }
}
