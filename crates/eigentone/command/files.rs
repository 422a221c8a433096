//! Files that appear together, and only when all of them are complete.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::{Failure, interrupt};

/// Files written under temporary names in their directory. Dropped, they are gone, and so is the directory if it
/// was made for them.
#[derive(Debug)]
pub struct Files {
    directory: PathBuf,
    /// Directories that did not exist before, the outermost first.
    made: Vec<PathBuf>,
    staged: Vec<(PathBuf, PathBuf)>,
    /// What must not be replaced, without links.
    input: Option<PathBuf>,
}

impl Files {
    /// Creates the directory if it does not exist.
    pub fn into(directory: &Path) -> Result<Files, Failure> {
        if directory.is_file() {
            let reason = io::Error::other("it is a file: name a directory");
            return Err(failure(directory, reason));
        }
        let ancestors = directory.ancestors();
        let missing = ancestors.take_while(|path| !path.as_os_str().is_empty() && !path.exists());
        let mut made: Vec<PathBuf> = missing.map(Path::to_owned).collect();
        made.reverse();
        let files = Files {
            directory: directory.to_owned(),
            made,
            staged: Vec::new(),
            input: None,
        };
        fs::create_dir_all(directory).map_err(|error| failure(directory, error))?;
        Ok(files)
    }

    /// The same files, none of which may take the place of the scene that they are made from.
    pub fn beside(mut self, scene: &Path) -> Files {
        self.input = fs::canonicalize(scene).ok();
        self
    }

    /// Writes one file, not yet under its name.
    pub fn write(
        &mut self,
        name: &str,
        content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        let file = self.directory.join(name);
        if self.input.is_some() && fs::canonicalize(&file).ok() == self.input {
            return Err(Failure::OverScene { file });
        }
        // It is found before any file has its name: all of them appear, or none.
        if file.is_dir() {
            let reason = io::Error::other("a directory has this name: remove it, or name another");
            return Err(failure(&file, reason));
        }
        let temporary = format!(".{name}.{}.tmp", std::process::id());
        let temporary = self.directory.join(temporary);
        self.staged.push((temporary.clone(), file.clone()));
        let write = || {
            let open = interrupt::create(&temporary)?;
            let mut out = BufWriter::with_capacity(1 << 16, open);
            content(&mut out)?;
            out.flush()
        };
        write().map_err(|error| failure(&file, error))
    }

    /// Gives every file its name.
    pub fn keep(mut self) -> Result<(), Failure> {
        let mut temporaries = interrupt::hold();
        while let Some((temporary, file)) = self.staged.pop() {
            if let Err(error) = fs::rename(&temporary, &file) {
                self.staged.push((temporary, file.clone()));
                drop(temporaries);
                return Err(failure(&file, error));
            }
            temporaries.retain(|known| *known != temporary);
        }
        self.made.clear();
        Ok(())
    }
}

impl Drop for Files {
    fn drop(&mut self) {
        for (temporary, _) in &self.staged {
            interrupt::remove(temporary);
        }
        for directory in self.made.iter().rev() {
            let _ = fs::remove_dir(directory); // it may not have come to exist, or hold more by now
        }
    }
}

fn failure(file: &Path, error: io::Error) -> Failure {
    Failure::Write {
        file: file.to_owned(),
        error,
    }
}
