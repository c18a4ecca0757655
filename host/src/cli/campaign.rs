//! `flotilla campaign`: starts `flotilla-campaign`, which is a package of its own, so that the first command needs no Parquet.

use std::ffi::OsString;
use std::io::ErrorKind;
use std::process::Command;

use super::{Failure, could};

const PROGRAM: &str = "flotilla-campaign";

#[derive(clap::Args)]
#[command(disable_help_flag = true)]
pub(super) struct Arguments {
    /// Handed on; `flotilla campaign --help` tells them
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "ARGUMENTS")]
    all: Vec<OsString>,
}

pub(super) fn main(arguments: &Arguments) -> Result<(), Failure> {
    // The one beside this program goes before any other in PATH.
    let beside =
        std::env::current_exe().ok().map(|path| path.with_file_name(PROGRAM)).filter(|path| path.exists());
    let program = beside.unwrap_or_else(|| PROGRAM.into());
    let mut command = Command::new(&program);
    command.args(&arguments.all);
    let error = run(&mut command);
    Err(match error.kind() {
        ErrorKind::NotFound => Failure::Could(format!(
            "{PROGRAM} is neither beside this program nor in PATH: cargo build --release -p campaign makes it"
        )),
        _ => could(format!("{}: {error}", program.display())),
    })
}

/// Becomes the other program, which so gets every signal; comes back only if it cannot.
#[cfg(unix)]
fn run(command: &mut Command) -> std::io::Error {
    use std::os::unix::process::CommandExt;
    command.exec()
}

/// Starts the other program and ends as it does; comes back only if it cannot.
#[cfg(not(unix))]
fn run(command: &mut Command) -> std::io::Error {
    match command.status() {
        Ok(status) => std::process::exit(status.code().unwrap_or(1)),
        Err(error) => error,
    }
}
