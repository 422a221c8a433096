//! What can be wrong with a scene file, in words.

use std::path::PathBuf;

use eigentone_modes::{BuildError, MatrixKind};
use eigentone_response::ResponseError;
use eigentone_switching::SwitchFault;
use thiserror::Error;

use super::matrix_error::MatrixFileError;
use super::place::Place;
use super::record::RecordError;
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
        "{}: is empty: a scene is a JSON object with \"masses\", \"matrices\", \"beams\" or \"rods\"",
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
    /// A name is not that of anything that may stand here.
    #[error("{at}: {name:?} is not the name of {what}: {hint}")]
    UnknownName {
        /// Where.
        at: Place,
        /// The name.
        name: Box<str>,
        /// What may stand here.
        what: &'static str,
        /// The nearest known name, or the names there are.
        hint: Box<str>,
    },
    /// A name stands for something else than belongs here.
    #[error("{at}: {name:?} is {is}: name {what}{}", instead(is, what))]
    WrongKind {
        /// Where.
        at: Place,
        /// The name.
        name: Box<str>,
        /// What it stands for.
        is: &'static str,
        /// What may stand here.
        what: &'static str,
    },
    /// A load, a motion or an initial state was given to the ground.
    #[error("{at}: the ground does not move: name a mass instead")]
    OnGround {
        /// Where.
        at: Place,
    },
    /// One of several keys must be given, and none or more are.
    #[error("{at}: {}", choice.message(given))]
    Choice {
        /// Where.
        at: Place,
        /// Between what.
        choice: Choice,
        /// The keys given.
        given: Vec<&'static str>,
    },
    /// Two outputs share a name, or one has the empty name.
    #[error(
        "{at}: an output is named {name:?}: names of outputs must not be empty, and must differ"
    )]
    OutputName {
        /// The name.
        at: Place,
        /// The name.
        name: String,
    },
    /// A sum of nothing.
    #[error("{at}: the sum is empty: give at least one name and what it is multiplied by")]
    EmptyOutput {
        /// The sum.
        at: Place,
    },
    /// A loss factor is negative.
    #[error("{at}: the loss factor is {value:?}: it must be 0 or more")]
    LossFactor {
        /// Where.
        at: Place,
        /// The value given.
        value: f64,
    },
    /// A spring with a loss factor in a scene that asks for a motion in time.
    #[error(
        "{at}: structural damping is defined for harmonic motion alone, and in time it would answer before it is asked: \
         leave out \"time\" and take the frequency response, or give dampers or \"damping\" in its place"
    )]
    LossFactorInTime {
        /// The loss factor.
        at: Place,
    },
    /// Frequencies that cannot be spread.
    #[error("{at}: {problem}")]
    Frequencies {
        /// Where.
        at: Place,
        /// What is wrong, and what would be right.
        problem: &'static str,
    },
    /// A noise that acts nowhere, or where its quantity cannot.
    #[error("{at}: {}", match force {
        true => "a force is noise \"on\" a coordinate or point: give that, and no \"of\"",
        false => "a motion is noise \"of\" a support: give that, and no \"on\"",
    })]
    NoisePlace {
        /// The noise.
        at: Place,
        /// Whether it is a force.
        force: bool,
    },
    /// A density below 0.
    #[error("{at}: a density must be 0 or more")]
    NoiseDensity {
        /// The density.
        at: Place,
    },
    /// The band of a noise is none.
    #[error(
        "{at}: a band is two frequencies in Hz, the first 0 or more and below the second: leave out \"band\" for white noise"
    )]
    NoiseBand {
        /// The band.
        at: Place,
    },
    /// A friction, stop, impact or controlled damper is wrong.
    #[error("{at}: {source}")]
    Switch {
        /// Where.
        at: Place,
        /// What is wrong.
        source: Box<SwitchFault>,
    },
    /// A controlled damper has a damper to the sky that its law does not ask for, or none that it does.
    #[error("{at}: {}", match clipped {
        true => "the law \"clipped skyhook\" needs \"sky\", the damping in N·s/m between b and the sky: give it",
        false => "only the law \"clipped skyhook\" has \"sky\": leave it out, or take that law",
    })]
    Sky {
        /// The damper.
        at: Place,
        /// Whether its law is the clipped one.
        clipped: bool,
    },
    /// A file with the values of samples is wrong.
    #[error("{at}: {source}")]
    Record {
        /// The values.
        at: Place,
        /// What is wrong with their file.
        source: Box<RecordError>,
    },
    /// A matrix that is given by the name of a file is wrong there.
    #[error("{at}: {source}")]
    Matrix {
        /// The matrix.
        at: Place,
        /// What is wrong with its file.
        source: Box<MatrixFileError>,
    },
    /// A row of a matrix has another length than the first one.
    #[error(
        "{at}: entries in this row: {length}, in the first one: {expected}; rows must be equally long"
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

/// What the response says, without the number of the load, motion or output, which the place has.
fn response_reason(error: &ResponseError) -> String {
    match error {
        ResponseError::Load { error, .. } | ResponseError::Motion { error, .. } => {
            error.to_string()
        }
        ResponseError::Combination { reason, .. } => reason.clone(),
        error => error.to_string(),
    }
}

/// What to do about a name of another kind.
fn instead(is: &str, what: &str) -> &'static str {
    match (is, what) {
        ("a point", "a coordinate") => ", such as those it moves with, which have the state",
        ("a support", "a coordinate") => ": supports are at rest at 0 before t = 0",
        ("a support", "a coordinate or point") => {
            ": a force on a support moves nothing, its motion is given"
        }
        ("a coordinate" | "a point", "a support") => {
            ": only the motion of those is given, by \"supports\""
        }
        _ => "",
    }
}

/// Keys of which exactly one must be given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Choice {
    /// The kinds of a load.
    Load,
    /// The quantity that a motion prescribes.
    Motion,
    /// The kinds of a motion.
    Course,
    /// Sums or a force.
    Output,
    /// The quantity that is noise.
    Noise,
}

impl Choice {
    fn message(self, given: &[&'static str]) -> String {
        let quoted =
            |words: &[&str], last| listed(words.iter().map(|word| format!("{word:?}")), last);
        let (what, lacks, all, each): (_, _, &[&str], _) = match self {
            Choice::Load => (
                "the load",
                "has no force",
                &[
                    "step",
                    "ramp",
                    "impulse",
                    "harmonic",
                    "half_sine",
                    "versine",
                    "polynomial",
                    "samples",
                ],
                "give each a load of its own",
            ),
            Choice::Motion => (
                "the motion",
                "says nothing",
                &["displacement", "velocity", "acceleration"],
                "give each a motion of its own",
            ),
            Choice::Noise => (
                "the noise",
                "has no density",
                &["force", "displacement", "velocity", "acceleration"],
                "give each a noise of its own",
            ),
            Choice::Course => (
                "the motion",
                "has no course",
                &[
                    "step",
                    "ramp",
                    "harmonic",
                    "half_sine",
                    "versine",
                    "polynomial",
                    "samples",
                ],
                "give each a motion of its own",
            ),
            Choice::Output => (
                "the output",
                "shows nothing",
                &["displacement", "velocity", "acceleration", "force"],
                "give the force an output of its own",
            ),
        };
        match given {
            [] => format!("{what} {lacks}: give it one of {}", quoted(all, "or")),
            _ => format!("{what} has {}: {each}", quoted(given, "and")),
        }
    }
}
