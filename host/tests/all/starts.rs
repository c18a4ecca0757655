//! Two more ways to start `flotilla`: within an operator's reach, and with all of its input.

use std::io::Write;
use std::path::Path;
use std::process::Command;

use crate::common::{Finished, Process};

impl Process {
    /// Starts `flotilla` in `folder`, with a place there for sockets of its own, by which an operator reaches it.
    pub fn reachable(folder: &Path, arguments: &[&str]) -> Self {
        let sockets = folder.join("sockets");
        std::fs::create_dir_all(&sockets).expect("a folder");
        let mut command = Command::new(env!("CARGO_BIN_EXE_flotilla"));
        command.args(arguments).current_dir(folder).env("XDG_RUNTIME_DIR", sockets);
        Self::spawn(command)
    }

    /// What `flotilla` with these arguments leaves when it is given `input`.
    pub fn given(folder: &Path, arguments: &[&str], input: &str) -> Finished {
        let mut process = Self::start(folder, arguments);
        // It may have refused its arguments before it reads.
        let _ = process.input.as_mut().expect("a pipe").write_all(input.as_bytes());
        process.finish()
    }
}
