//! The `eigentone` command.

mod command;

use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    match command::Cli::read().run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            let red = clap::builder::styling::AnsiColor::Red.on_default().bold();
            // Colours reach terminals alone, and none where NO_COLOR is set. If standard error is closed, nobody can be
            // informed.
            let _ = writeln!(anstream::stderr(), "{red}error:{red:#} {failure}");
            ExitCode::from(failure.status())
        }
    }
}
