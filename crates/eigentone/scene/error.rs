//! What can be wrong with a scene file, in words.

use std::path::PathBuf;

use eigentone_modes::{BuildError, MatrixKind};
use eigentone_response::ResponseError;
use thiserror::Error;

use super::matrix_market::MatrixMarketError;
use super::place::Place;
use super::words::listed;

/// The largest scene file that is read, in bytes.
pub const MAX_BYTES: u64 = 64 << 20;

/// What is wrong with a scene file: one message with the file, the place in it, what is wrong and
/// what would be right.
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
    /// It is a directory.
    #[error("{}: is a directory: give the scene file inside it", file.display())]
    Directory {
        /// The directory.
        file: PathBuf,
    },
    /// It is a pipe, a socket or a device.
    #[error("{}: is not a regular file: save the scene in one and give its path", file.display())]
    NotFile {
        /// What was given.
        file: PathBuf,
    },
    /// It has more than [`MAX_BYTES`].
    #[error("{}: is larger than {} MiB, the most a scene may have", file.display(), MAX_BYTES >> 20)]
    TooLarge {
        /// The file.
        file: PathBuf,
    },
    /// It has nothing in it.
    #[error(
        "{}: is empty: a scene is a JSON object with \"masses\" or \"matrices\"",
        file.display()
    )]
    Empty {
        /// The file.
        file: PathBuf,
    },
    /// It is not text, or not in UTF-8.
    #[error("{at}: is not UTF-8 text from here on: save the file as UTF-8")]
    NotUtf8 {
        /// The first wrong byte.
        at: Place,
    },
    /// It is not JSON.
    #[error("{at}: {}: {}", if source.is_eof() { "ends too early" } else { "is not JSON" }, reason(source))]
    NotJson {
        /// Where it stops being JSON.
        at: Place,
        /// What the JSON reader says.
        source: serde_json::Error,
    },
    /// A number is infinite or not a number at all.
    #[error("{at}: {number} is not a finite number: every number must be one, up to ±1.79e308")]
    NotFinite {
        /// The number.
        at: Place,
        /// Its text.
        number: String,
    },
    /// Something is missing, unknown, repeated or of another kind than belongs there.
    #[error("{at}: {}", reason(source))]
    Shape {
        /// Where.
        at: Place,
        /// What is wrong.
        source: serde_json::Error,
    },
    /// A name is not that of a coordinate.
    #[error("{at}: {name:?} is not the name of a coordinate: {hint}")]
    UnknownName {
        /// Where.
        at: Place,
        /// The name.
        name: String,
        /// The nearest known name, or the names there are.
        hint: String,
    },
    /// A load or an initial state was given to the ground.
    #[error("{at}: the ground does not move: name a mass instead")]
    OnGround {
        /// Where.
        at: Place,
    },
    /// A load has no kind, or more than one.
    #[error("{at}: {}", load_kinds(given))]
    LoadKind {
        /// The load.
        at: Place,
        /// The kinds given.
        given: Vec<&'static str>,
    },
    /// A matrix that is given by the name of a file is wrong there.
    #[error("{at}: {source}")]
    Matrix {
        /// The matrix.
        at: Place,
        /// What is wrong with its file.
        source: Box<MatrixMarketError>,
    },
    /// A row of a matrix has another length than the first one.
    #[error(
        "{at}: the row has {length} entries, the first one has {expected}: rows must be equally long"
    )]
    RaggedRow {
        /// The row.
        at: Place,
        /// Which matrix.
        kind: MatrixKind,
        /// Entries of the row.
        length: usize,
        /// Entries of the first row.
        expected: usize,
    },
    /// The parameters make no system.
    #[error("{at}: {source}")]
    System {
        /// Where.
        at: Place,
        /// What is wrong.
        source: Box<BuildError>,
    },
    /// The initial state, the loads or the instants make no response.
    #[error("{at}: {}", response_reason(source))]
    Response {
        /// Where.
        at: Place,
        /// What is wrong.
        source: Box<ResponseError>,
    },
}

/// What the JSON reader says, in words for people who do not write parsers, and without the
/// position, which the place has.
fn reason(error: &serde_json::Error) -> String {
    let position = format!(" at line {} column {}", error.line(), error.column());
    let text = error.to_string();
    let text = text.strip_suffix(&position).unwrap_or(&text);
    if let Some(rest) = text.strip_prefix("missing field `") {
        return format!(
            "the key {:?} is missing: give it",
            rest.trim_end_matches('`')
        );
    }
    if let Some(rest) = text.strip_prefix("EOF while parsing ") {
        return format!("{rest} is not finished");
    }
    match text {
        "expected value" => {
            "here should be a number, a text in quotes, a list or an object".to_owned()
        }
        "key must be a string" => "here should be a key in double quotes".to_owned(),
        "trailing comma" => "the comma before this bracket is one too many".to_owned(),
        "trailing characters" => "nothing may follow the scene".to_owned(),
        _ => text.to_owned(),
    }
}

/// What the response says, without the number of the load, which the place has.
fn response_reason(error: &ResponseError) -> String {
    match error {
        ResponseError::Load { error, .. } => error.to_string(),
        error => error.to_string(),
    }
}

fn load_kinds(given: &[&str]) -> String {
    let all = "\"step\", \"ramp\", \"impulse\", \"harmonic\" or \"samples\"";
    match given {
        [] => format!("the load has no force: give it one of {all}"),
        _ => format!(
            "the load has {}: give each a load of its own",
            listed(given.iter().map(|kind| format!("{kind:?}")), "and")
        ),
    }
}
