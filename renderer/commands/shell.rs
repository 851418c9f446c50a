//! `nephroid completions` and `nephroid man`: what a shell and a manual want to know of the command line.

use std::io::{self, Write};

use clap::{Args, Command};
use clap_complete::Shell;
use clap_mangen::Man;
use thiserror::Error;

const COMPLETIONS_HELP: &str = "\
Examples:
  bash: nephroid completions bash > ~/.local/share/bash-completion/completions/nephroid
  zsh:  nephroid completions zsh > \"${fpath[1]}/_nephroid\"
  fish: nephroid completions fish > ~/.config/fish/completions/nephroid.fish";

const MAN_HELP: &str = "\
Examples:
  nephroid man | man -l -
  nephroid man render > nephroid-render.1";

/// Print a script that completes the command line in a shell
#[derive(Debug, Clone, Args)]
#[command(after_help = COMPLETIONS_HELP)]
pub struct CompletionsArgs {
    /// The shell the script is for
    pub shell: Shell,
}

/// Print a manual page, in roff
#[derive(Debug, Clone, Args)]
#[command(after_help = MAN_HELP)]
pub struct ManArgs {
    /// The command the page is about; all of Nephroid if left out
    pub command: Option<String>,
}

/// Why nothing was printed.
#[derive(Debug, Error)]
pub enum ShellError {
    #[error("there is no command '{found}' to print a manual page of; allowed are: {allowed}")]
    UnknownCommand { found: String, allowed: String },
    #[error("the text cannot be printed: {0}")]
    Print(#[from] io::Error),
}

/// Prints the completion script for `command`, the whole command line.
///
/// # Errors
/// [`ShellError::Print`].
pub fn completions(args: &CompletionsArgs, mut command: Command) -> Result<(), ShellError> {
    // Into memory first: the generator panics where a pipe is closed.
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, "nephroid", &mut script);
    print(&script)
}

/// Prints the manual page of `command`, the whole command line, or of one of its subcommands.
///
/// # Errors
/// [`ShellError::UnknownCommand`] or [`ShellError::Print`].
pub fn man(args: &ManArgs, mut command: Command) -> Result<(), ShellError> {
    // Gives the subcommands their full names and usage lines.
    command.build();
    let page = match &args.command {
        None => command,
        Some(name) => subcommand(&command, name)?,
    };
    let mut text = Vec::new();
    Man::new(page).render(&mut text)?;
    print(&text)
}

fn subcommand(command: &Command, name: &str) -> Result<Command, ShellError> {
    command.find_subcommand(name).cloned().ok_or_else(|| ShellError::UnknownCommand {
        found: name.to_owned(),
        allowed: command.get_subcommands().map(Command::get_name).collect::<Vec<_>>().join(", "),
    })
}

fn print(text: &[u8]) -> Result<(), ShellError> {
    let mut output = io::stdout().lock();
    output.write_all(text)?;
    Ok(output.flush()?)
}
