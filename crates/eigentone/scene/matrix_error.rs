//! What is wrong with files that hold a matrix, and where; what is too large.

use std::fmt;
use std::path::PathBuf;

use eigentone_modes::MAX_COORDINATES;
use thiserror::Error;

/// The largest matrix file that is read, in bytes.
pub const MAX_MATRIX_BYTES: u64 = 4 << 30;

/// The most memory that reading a matrix may take, in bytes.
pub const MAX_MATRIX_MEMORY: u64 = 8 << 30;

/// What an entry takes while the matrix is put together, at most: as it was read with its place, sorted, with its
/// mirror image, and in the matrix itself.
const BYTES_AN_ENTRY: u64 = 160;

/// A place in a file: of text its line, of bytes the first of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Spot {
    /// A line, from 1.
    Line(usize),
    /// A byte, from 0.
    Byte(u64),
}

impl fmt::Display for Spot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Spot::Line(line) => write!(f, "{line}"),
            Spot::Byte(at) => write!(f, "byte {at}"),
        }
    }
}

/// What is wrong with a file that should hold a matrix, in Matrix Market or PETSc binary format: the file, the place in
/// it, what is wrong and what would be right.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MatrixFileError {
    /// It cannot be read.
    #[error("{}: cannot be read: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// It is a directory, a pipe or a device.
    #[error("{}: is not a file: name a Matrix Market or PETSc binary file", file.display())]
    NotFile {
        /// What was named.
        file: PathBuf,
    },
    /// It has more than [`MAX_MATRIX_BYTES`].
    #[error("{}: is larger than {} GiB, the most a matrix may have", file.display(), MAX_MATRIX_BYTES >> 30)]
    TooLarge {
        /// The file.
        file: PathBuf,
    },
    /// It announces more entries than fit into [`MAX_MATRIX_MEMORY`].
    #[error(
        "{}:{at}: {entries} entries would take {:.1} GB of memory, more than the {:.1} GB allowed",
        file.display(), *needed as f64 / 1e9, *allowed as f64 / 1e9
    )]
    Memory {
        /// The file.
        file: PathBuf,
        /// Where it says how many they are.
        at: Spot,
        /// How many entries it announces.
        entries: usize,
        /// What they would take, in bytes.
        needed: u64,
        /// What is allowed, in bytes.
        allowed: u64,
    },
    /// A place is wrong.
    #[error("{}:{at}: {problem}", file.display())]
    Wrong {
        /// The file.
        file: PathBuf,
        /// Where.
        at: Spot,
        /// What is wrong, and what would be right.
        problem: String,
    },
}

/// Why reading ended.
#[derive(Debug)]
pub(super) enum Refusal {
    Read(std::io::Error),
    Wrong(Spot, String),
    /// Where, how many entries, and the bytes that they would take.
    Memory(Spot, usize, u64),
}

/// What a file announces before anything is set aside for it.
pub(super) struct Announced;

impl Announced {
    /// Refuses orders that no system has.
    pub(super) fn order(rows: usize, columns: usize, at: Spot) -> Result<(), Refusal> {
        let problem = if rows != columns {
            format!("the matrix is {rows} × {columns}: M, C and K must be square")
        } else if rows == 0 {
            "the matrix is 0 × 0: it needs a row for each coordinate".to_owned()
        } else if rows > MAX_COORDINATES {
            format!(
                "the matrix has {rows} rows, more than the {MAX_COORDINATES} that a system may have"
            )
        } else {
            return Ok(());
        };
        Err(Refusal::Wrong(at, problem))
    }

    /// Refuses more entries than fit into memory.
    pub(super) fn entries(entries: usize, at: Spot) -> Result<(), Refusal> {
        let needed = (entries as u64).saturating_mul(BYTES_AN_ENTRY);
        match needed > MAX_MATRIX_MEMORY {
            true => Err(Refusal::Memory(at, entries, needed)),
            false => Ok(()),
        }
    }
}
