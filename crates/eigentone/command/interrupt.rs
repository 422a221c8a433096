//! Ctrl-C, and requests to end: no temporary file and no process stays behind.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::process::{self, Command, ExitStatus};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// What a shell reports of a program that Ctrl-C ended.
const STATUS: i32 = 130;

/// The files that are not complete, and directories of them. Whoever holds the list is not interrupted.
static TEMPORARIES: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A process that runs for the command.
static CHILD: Mutex<Option<process::Child>> = Mutex::new(None);

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
        Child.end();
        for temporary in temporaries.iter() {
            clear(temporary);
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
        clear(temporary);
        temporaries.retain(|known| known != temporary);
    }
}

/// Creates a directory of temporary files, for its owner alone to read.
pub fn create_directory(temporary: &Path) -> io::Result<()> {
    let mut temporaries = hold();
    let mut builder = fs::DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(temporary)?;
    temporaries.push(temporary.to_owned());
    Ok(())
}

fn clear(temporary: &Path) {
    let _ = match temporary.is_dir() {
        true => fs::remove_dir_all(temporary),
        false => fs::remove_file(temporary),
    };
}

/// The process that runs for the command.
#[derive(Debug)]
pub struct Child;

/// Starts a process that does not outlive the command; what it says, if that is piped.
pub fn spawn(command: &mut Command) -> io::Result<(Child, Option<process::ChildStderr>)> {
    let mut child = child();
    let mut started = command.spawn()?;
    let said = started.stderr.take();
    *child = Some(started);
    Ok((Child, said))
}

fn child() -> MutexGuard<'static, Option<process::Child>> {
    CHILD.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Child {
    /// How it ended; `None` while it runs.
    pub fn status(&self) -> Option<io::Result<ExitStatus>> {
        child().as_mut()?.try_wait().transpose()
    }

    /// Asks it to end, so that it can end what it started, and ends it where it does not.
    pub fn end(&self) {
        const PATIENCE: Duration = Duration::from_secs(5);
        const LOOK: Duration = Duration::from_millis(20);
        let Some(mut child) = child().take() else {
            return;
        };
        if matches!(child.try_wait(), Ok(Some(_))) {
            return;
        }
        let sent = Command::new("kill").arg(child.id().to_string()).status();
        let start = Instant::now();
        while sent.is_ok() && start.elapsed() < PATIENCE {
            if matches!(child.try_wait(), Ok(Some(_))) {
                return;
            }
            thread::sleep(LOOK);
        }
        let _ = child.kill();
        let _ = child.wait();
    }
}
