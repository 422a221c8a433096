//! `eigentone completions SHELL` and `eigentone man`: what shells and `man` know of the command line.

use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};
use clap_mangen::Man;

use super::{Cli, Failure, print};

/// Prints completions for a shell, to be saved where it looks for them
#[derive(Debug, Args)]
pub struct Completions {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

impl Completions {
    pub fn run(self) -> Result<(), Failure> {
        let mut text = Vec::new();
        generate(self.shell, &mut Cli::command(), "eigentone", &mut text);
        print(|out| out.write_all(&text))
    }
}

/// Prints the manual page: eigentone man | man -l -
#[derive(Debug, Args)]
pub struct Manual {}

impl Manual {
    pub fn run(self) -> Result<(), Failure> {
        let mut all = Cli::command();
        all.build();
        print(|out| {
            Man::new(all.clone()).render(out)?;
            // The commands' own pages, one behind the other, without what repeats the front page.
            let commands = all.get_subcommands();
            for command in commands.filter(|command| command.get_name() != "help") {
                let page = Man::new(command.clone());
                page.render_title(out)?;
                page.render_name_section(out)?;
                page.render_synopsis_section(out)?;
                page.render_options_section(out)?;
            }
            Ok(())
        })
    }
}
