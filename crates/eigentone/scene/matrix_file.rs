//! Files that hold one matrix, in either of two formats.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use faer::sparse::SparseColMat;

use super::matrix_error::{MAX_MATRIX_BYTES, MAX_MATRIX_MEMORY, MatrixFileError, Refusal};
use super::{matrix_market, petsc};

/// The matrix in a file, with what symmetry leaves out filled in. Its first bytes show its format.
pub(super) fn read(path: &Path) -> Result<SparseColMat<usize, f64>, MatrixFileError> {
    let file = path.to_owned();
    let failed = |source| MatrixFileError::Read {
        file: path.to_owned(),
        source,
    };
    let metadata = std::fs::metadata(path).map_err(failed)?;
    if !metadata.is_file() {
        return Err(MatrixFileError::NotFile { file });
    }
    let bytes = metadata.len();
    if bytes > MAX_MATRIX_BYTES {
        return Err(MatrixFileError::TooLarge { file });
    }
    let mut content = BufReader::with_capacity(1 << 16, File::open(path).map_err(failed)?);
    let is_binary = petsc::is_start(content.fill_buf().map_err(failed)?);
    let read = match is_binary {
        true => petsc::matrix(content, bytes),
        false => matrix_market::matrix(content, bytes),
    };
    read.map_err(|refusal| match refusal {
        Refusal::Read(source) => failed(source),
        Refusal::Wrong(at, problem) => MatrixFileError::Wrong { file, at, problem },
        Refusal::Memory(at, entries, needed) => MatrixFileError::Memory {
            file,
            at,
            entries,
            needed,
            allowed: MAX_MATRIX_MEMORY,
        },
    })
}
