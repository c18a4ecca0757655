//! The program as from a terminal: a test that `nohup` has started ignores the hangup, and so would its children.

use std::path::Path;
use std::process::Command;

use crate::common::Process;

/// Starts `flotilla` with these arguments in `folder`.
pub fn start(folder: &Path, arguments: &[&str]) -> Process {
    let mut command = Command::new("env");
    command.args(["--default-signal=HUP", env!("CARGO_BIN_EXE_flotilla")]).args(arguments);
    command.current_dir(folder);
    Process::spawn(command)
}
