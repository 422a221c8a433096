//! Ctrl-C, and being told to end: no temporary file stays behind.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::process;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

/// What a shell reports of a program that Ctrl-C ended.
const STATUS: i32 = 130;

/// The files that are not complete. Whoever holds the list is not interrupted.
static TEMPORARIES: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// What would have been quicker.
static QUICKER: OnceLock<&str> = OnceLock::new();

/// From now on an interrupt removes the temporary files, says what is quicker, and ends the program.
pub fn watch(quicker: Option<&'static str>) {
    if let Some(quicker) = quicker {
        let _ = QUICKER.set(quicker); // once for a program
    }
    // Without a handler an interrupt ends the program as well, only less tidily.
    let _ = ctrlc::set_handler(|| {
        let temporaries = hold();
        for temporary in temporaries.iter() {
            let _ = fs::remove_file(temporary);
        }
        if let Some(quicker) = self::quicker() {
            eprintln!("interrupted; quicker: {quicker}");
        }
        // The list is still held, so that no other file comes to be.
        process::exit(STATUS);
    });
}

/// What is quicker than the command that runs, if anything is.
pub fn quicker() -> Option<&'static str> {
    QUICKER.get().copied()
}

/// The list, and with it the time until it is dropped.
pub fn hold() -> MutexGuard<'static, Vec<PathBuf>> {
    TEMPORARIES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Creates a temporary file.
pub fn create(temporary: &Path) -> io::Result<File> {
    let mut temporaries = hold();
    let file = File::create(temporary)?;
    temporaries.push(temporary.to_owned());
    Ok(file)
}

/// Removes a temporary file, if it has come to exist.
pub fn remove(temporary: &Path) {
    let mut temporaries = hold();
    if temporaries.iter().any(|known| known == temporary) {
        let _ = fs::remove_file(temporary);
        temporaries.retain(|known| known != temporary);
    }
}
