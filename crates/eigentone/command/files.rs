//! Files that appear together, and only when all of them are complete.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::Failure;

/// Files written under temporary names in their directory. Dropped, they are gone.
#[derive(Debug)]
pub struct Files {
    directory: PathBuf,
    staged: Vec<(PathBuf, PathBuf)>,
}

impl Files {
    /// Creates the directory if it does not exist.
    pub fn into(directory: &Path) -> Result<Files, Failure> {
        fs::create_dir_all(directory).map_err(|error| failure(directory, error))?;
        Ok(Files {
            directory: directory.to_owned(),
            staged: Vec::new(),
        })
    }

    /// Writes one file, not yet under its name.
    pub fn write(
        &mut self,
        name: &str,
        content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        let file = self.directory.join(name);
        let temporary = format!(".{name}.{}.tmp", std::process::id());
        let temporary = self.directory.join(temporary);
        self.staged.push((temporary.clone(), file.clone()));
        let write = || {
            let mut out = BufWriter::with_capacity(1 << 16, File::create(&temporary)?);
            content(&mut out)?;
            out.flush()
        };
        write().map_err(|error| failure(&file, error))
    }

    /// Gives every file its name.
    pub fn keep(mut self) -> Result<(), Failure> {
        while let Some((temporary, file)) = self.staged.pop() {
            if let Err(error) = fs::rename(&temporary, &file) {
                self.staged.push((temporary, file.clone()));
                return Err(failure(&file, error));
            }
        }
        Ok(())
    }
}

impl Drop for Files {
    fn drop(&mut self) {
        for (temporary, _) in &self.staged {
            let _ = fs::remove_file(temporary); // it may not have come to exist
        }
    }
}

fn failure(file: &Path, error: io::Error) -> Failure {
    Failure::Write {
        file: file.to_owned(),
        error,
    }
}
