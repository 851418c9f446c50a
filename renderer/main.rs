//! The command line of Nephroid.

use std::error::Error;
use std::io::{self, Write};
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};
#[cfg(feature = "viewer")]
use nephroid::commands::view;
use nephroid::commands::{animate, compare, conformance, devices, render, shell, volume};

const EXAMPLES: &str = "\
Examples:
  nephroid render scenes/pool.toml --technique reference -o pool.png
  nephroid devices
  nephroid compare pool.exr truth.exr --layer caustic

Exit status: 0 done, 1 failed, 2 wrong usage, 130 stopped by Ctrl-C.";

/// Renders caustics on any Vulkan device
#[derive(Parser)]
#[command(name = "nephroid", version, max_term_width = 100, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Render(Box<render::RenderArgs>),
    Animate(Box<animate::AnimateArgs>),
    #[cfg(feature = "viewer")]
    View(Box<view::ViewArgs>),
    Compare(compare::CompareArgs),
    Volume(Box<volume::VolumeArgs>),
    Devices(devices::DevicesArgs),
    Conformance(Box<conformance::ConformanceArgs>),
    Completions(shell::CompletionsArgs),
    Man(shell::ManArgs),
}

fn main() -> ExitCode {
    match run(Cli::parse().command) {
        Ok(status) => status,
        Err(error) if is_broken_pipe(error.as_ref()) => ExitCode::SUCCESS,
        Err(error) => {
            // Nobody is left to tell where standard error is closed.
            let _ = writeln!(io::stderr(), "nephroid: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(command: Command) -> Result<ExitCode, Box<dyn Error>> {
    match command {
        Command::Render(args) => return Ok(render::run(&args)?),
        Command::Animate(args) => return Ok(animate::run(&args)?),
        #[cfg(feature = "viewer")]
        Command::View(args) => return Ok(view::run(&args)?),
        Command::Conformance(args) => return Ok(conformance::run(&args)?),
        Command::Compare(args) => compare::run(&args)?,
        Command::Volume(args) => volume::run(&args)?,
        Command::Devices(args) => devices::run(&args)?,
        Command::Completions(args) => shell::completions(&args, Cli::command())?,
        Command::Man(args) => shell::man(&args, Cli::command())?,
    }
    Ok(ExitCode::SUCCESS)
}

/// Whether the reader of standard output has had enough, as in `nephroid man | head`.
fn is_broken_pipe(error: &(dyn Error + 'static)) -> bool {
    let here = error.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe);
    here || error.source().is_some_and(is_broken_pipe)
}
