//! What can go wrong, and the exit status it ends with.

use std::io;
use std::path::{Path, PathBuf};

use eigentone::design::CampbellError;
use eigentone::modes::{ModesError, SparseError};
use eigentone::response::{FrequencyError, ResponseError, SpectrumError, StateSpaceError};
use eigentone::scene::{RecordError, SceneError};
use eigentone::switching::{CycleError, SwitchingError};
use eigentone::tables::TableError;
use thiserror::Error;

use super::slepc::SlepcError;

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
    #[error(
        "{}: {coordinates} coordinates are too many for dense matrices, which would take {gigabytes:.1} GB: ask for some modes, as with `eigentone modes SCENE --lowest 20` or `--near FREQUENCY`, or for a response of them, as with `eigentone response SCENE --modes 20`",
        scene.display()
    )]
    Large {
        scene: PathBuf,
        coordinates: usize,
        gigabytes: f64,
    },
    #[error(
        "{}: it may take {} GB of memory, more than the {} GB allowed: {}allow more with --memory-limit",
        scene.display(), gigabytes(*needed), gigabytes(*allowed),
        fewer.map(|what| format!("ask for fewer {what}, or ")).unwrap_or_default()
    )]
    Memory {
        scene: PathBuf,
        needed: f64,
        allowed: f64,
        /// What takes less where there is less of it, and can be asked for.
        fewer: Option<&'static str>,
    },
    #[error("{}: {error}", scene.display())]
    Sparse { scene: PathBuf, error: SparseError },
    #[error("{}: {error}", scene.display())]
    Modes { scene: PathBuf, error: ModesError },
    #[error("{}: {error}", scene.display())]
    Slepc { scene: PathBuf, error: SlepcError },
    #[error(
        "--engine slepc finds some modes: ask for them by --lowest COUNT, or by --near FREQUENCY"
    )]
    EngineForAll,
    #[error("{}: {error}", scene.display())]
    Response {
        scene: PathBuf,
        error: ResponseError,
    },
    #[error("{}: {}", scene.display(), error.with_names(switches))]
    Switching {
        scene: PathBuf,
        error: SwitchingError,
        /// What each switch is in the scene.
        switches: Vec<String>,
    },
    #[error(
        "{}: it has {first}, and {what} is for linear motions alone: leave the frictions, stops, impacts and controlled dampers out, or take `eigentone response`",
        scene.display()
    )]
    Switches {
        scene: PathBuf,
        first: String,
        what: &'static str,
    },
    #[error("{}: {}", scene.display(), error.with_names(switches))]
    Cycle {
        scene: PathBuf,
        error: CycleError,
        /// What each switch is in the scene.
        switches: Vec<String>,
    },
    #[error("{}: {}", scene.display(), frequency(error))]
    Frequency {
        scene: PathBuf,
        error: FrequencyError,
    },
    #[error("{}: {error}", scene.display())]
    StateSpace {
        scene: PathBuf,
        error: StateSpaceError,
    },
    #[error(
        "{}: a spring with a `loss_factor` has a force for each frequency, but none in time, so that there is no state-space form: give dampers, or damping ratios by \"damping\": {{\"modal\": …}}",
        scene.display()
    )]
    LossFactor { scene: PathBuf },
    #[error(
        "{}: it has no `noise`: add \"noise\": [{{\"on\": …, \"force\": …}}] or [{{\"of\": …, \"acceleration\": …}}]",
        scene.display()
    )]
    NoNoise { scene: PathBuf },
    #[error("--hold and --step belong together: give both, as in --hold zero --step 0.01, or none")]
    HoldWithoutStep,
    #[error(transparent)]
    Record(#[from] RecordError),
    #[error("{}: {error}", record.display())]
    Spectrum {
        record: PathBuf,
        error: SpectrumError,
    },
    #[error(
        "--from {from:?} Hz is not below --to {to:?} Hz: give the lower frequency first, or a --count of 1"
    )]
    Frequencies { from: f64, to: f64 },
    #[error("{}: {error}", scene.display())]
    Campbell {
        scene: PathBuf,
        error: CampbellError,
    },
    #[error("{}: {error}", scene.display())]
    Table { scene: PathBuf, error: TableError },
    #[error("{}: {option} {name:?} is no name of the scene: {hint}", scene.display())]
    UnknownName {
        scene: PathBuf,
        option: &'static str,
        name: String,
        hint: String,
    },
    #[error("the gallery has no scene {name:?}: {hint}")]
    NoSuchScene { name: String, hint: String },
    #[error("--methods: there is no method {name:?}: {hint}")]
    NoSuchMethod { name: String, hint: String },
    #[error("{}: {message}", scene.display())]
    Study { scene: PathBuf, message: String },
    #[error("{}: {message}", file.display())]
    Parts { file: PathBuf, message: String },
    #[error("{}: this result would replace the scene itself: give --out another directory", file.display())]
    OverScene { file: PathBuf },
    #[error("{}: cannot be written: {error}", file.display())]
    Write { file: PathBuf, error: io::Error },
    #[error("standard output cannot be written: {0}")]
    Output(io::Error),
}

/// What is wrong with a frequency response, and the option that mends it.
fn frequency(error: &FrequencyError) -> String {
    match error {
        FrequencyError::NoInput => {
            "nothing drives the scene, and it has too many masses to take each: name an input, as with --from NAME".to_owned()
        }
        error => error.to_string(),
    }
}

/// To a digit after the point, or what there is of it.
fn gigabytes(size: f64) -> String {
    match size {
        0.1.. => format!("{size:.1}"),
        size => format!("{size:.1e}"),
    }
}

impl Failure {
    pub fn modes(scene: &Path) -> impl FnOnce(ModesError) -> Failure {
        let scene = scene.to_owned();
        |error| match error {
            ModesError::TooLarge {
                coordinates,
                gigabytes,
            } => Failure::Large {
                scene,
                coordinates,
                gigabytes,
            },
            error => Failure::Modes { scene, error },
        }
    }

    pub fn sparse(scene: &Path) -> impl FnOnce(SparseError) -> Failure + use<> {
        let scene = scene.to_owned();
        |error| Failure::Sparse { scene, error }
    }

    pub fn response(scene: &Path) -> impl FnOnce(ResponseError) -> Failure {
        let scene = scene.to_owned();
        |error| match error {
            ResponseError::Large {
                coordinates,
                gigabytes,
            } => Failure::Large {
                scene,
                coordinates,
                gigabytes,
            },
            error => Failure::Response { scene, error },
        }
    }

    pub fn switching(
        scene: &Path,
        switches: Vec<String>,
    ) -> impl FnOnce(SwitchingError) -> Failure {
        let scene = scene.to_owned();
        |error| match error {
            SwitchingError::Response(error) => Failure::response(&scene)(error),
            error => Failure::Switching {
                scene,
                error,
                switches,
            },
        }
    }

    pub fn table(scene: &Path) -> impl FnOnce(TableError) -> Failure {
        let scene = scene.to_owned();
        |error| Failure::Table { scene, error }
    }

    /// 2 where what was asked is wrong, 1 where the answer could not be computed or written.
    pub fn status(&self) -> u8 {
        match self {
            Failure::Scene(_)
            | Failure::NoTime { .. }
            | Failure::ToleranceInDoubles
            | Failure::LossFactor { .. }
            | Failure::NoNoise { .. }
            | Failure::Switches { .. }
            | Failure::HoldWithoutStep
            | Failure::EngineForAll
            | Failure::Record(_)
            | Failure::Frequencies { .. }
            | Failure::OverScene { .. }
            | Failure::Study { .. }
            | Failure::Parts { .. }
            | Failure::UnknownName { .. }
            | Failure::NoSuchScene { .. }
            | Failure::NoSuchMethod { .. }
            | Failure::Memory { .. }
            | Failure::Large { .. } => 2,
            Failure::Campbell { error, .. } => match error {
                CampbellError::Modes {
                    error: ModesError::TooLarge { .. },
                    ..
                } => 2,
                CampbellError::Modes { .. } | CampbellError::Follow { .. } => 1,
                _ => 2,
            },
            Failure::Sparse { error, .. } => match error {
                SparseError::NoConvergence | SparseError::OutOfRange => 1,
                _ => 2,
            },
            Failure::Response { error, .. } => match error {
                ResponseError::NotApplicable { .. }
                | ResponseError::Overflow { .. }
                | ResponseError::Lost { .. }
                | ResponseError::Stopped { .. }
                | ResponseError::Modes(_)
                | ResponseError::Sparse(SparseError::NoConvergence | SparseError::OutOfRange) => 1,
                _ => 2,
            },
            Failure::Frequency {
                error: FrequencyError::OutOfRange { .. },
                ..
            }
            | Failure::StateSpace {
                error: StateSpaceError::Overflow { .. } | StateSpaceError::Lost,
                ..
            } => 1,
            Failure::Table {
                error: TableError::Response(_),
                ..
            }
            | Failure::Frequency { .. }
            | Failure::StateSpace { .. }
            | Failure::Spectrum { .. } => 2,
            Failure::Switching { error, .. } => match error {
                SwitchingError::Switch { .. }
                | SwitchingError::Dependent { .. }
                | SwitchingError::Jammed { .. }
                | SwitchingError::TooLong { .. } => 2,
                _ => 1,
            },
            Failure::Cycle { error, .. } => match error {
                CycleError::Halted(SwitchingError::TooLong { .. }) => 2,
                CycleError::Lost | CycleError::Halted(_) | CycleError::NoMultipliers { .. } => 1,
                _ => 2,
            },
            Failure::Modes { .. }
            | Failure::Slepc { .. }
            | Failure::Table { .. }
            | Failure::Write { .. }
            | Failure::Output(_) => 1,
        }
    }
}
