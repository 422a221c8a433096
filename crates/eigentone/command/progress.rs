//! A sign of life on standard error while long work runs, on a terminal only.

use std::io::{self, IsTerminal};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::interrupt::quicker;

/// Work that takes less says nothing.
const PATIENCE: Duration = Duration::from_millis(250);
const TURN: Duration = Duration::from_millis(100);
/// After which what is quicker is said.
const LONG: Duration = Duration::from_secs(10);

/// Turns until it is dropped, then leaves no trace.
#[derive(Debug)]
pub struct Progress(Option<(Sender<String>, JoinHandle<()>)>);

impl Progress {
    /// Says what is being done.
    pub fn of(message: &str) -> Progress {
        if !io::stderr().is_terminal() {
            return Progress(None);
        }
        let (sender, receiver) = mpsc::channel::<String>();
        let mut message = message.to_owned();
        let turn = move || {
            let mut bar: Option<ProgressBar> = None;
            let mut wait = PATIENCE;
            let start = Instant::now();
            loop {
                match receiver.recv_timeout(wait) {
                    Ok(next) => message = next,
                    Err(RecvTimeoutError::Disconnected) => break,
                    Err(RecvTimeoutError::Timeout) => {
                        wait = TURN;
                        let bar = bar.get_or_insert_with(spinner);
                        let quicker = quicker().filter(|_| start.elapsed() > LONG);
                        bar.set_message(match quicker {
                            Some(quicker) => format!("{message}; quicker: {quicker}"),
                            None => message.clone(),
                        });
                        bar.tick();
                    }
                }
            }
            if let Some(bar) = bar {
                bar.finish_and_clear();
            }
        };
        Progress(Some((sender, thread::spawn(turn))))
    }

    /// Says what is being done now.
    pub fn say(&self, message: &str) {
        if let Some((sender, _)) = &self.0 {
            let _ = sender.send(message.to_owned()); // it outlives this
        }
    }
}

fn spinner() -> ProgressBar {
    let bar = ProgressBar::new_spinner();
    match ProgressStyle::with_template("{spinner} {msg} ({elapsed})") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some((sender, thread)) = self.0.take() {
            drop(sender);
            let _ = thread.join(); // a thread that only draws
        }
    }
}
