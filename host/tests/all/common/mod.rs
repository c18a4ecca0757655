//! The `flotilla` binary as a child process that cannot outlive or hang its test.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Long enough for anything that ends at all, on a machine with much else to do: it only ends what hangs.
pub const PATIENCE: Duration = Duration::from_secs(600);

/// One running `flotilla`, or what else was spawned; killed when dropped.
pub struct Process {
    /// The child.
    pub child: Child,
    /// Its standard input, until [`Process::finish`] closes it.
    pub input: Option<ChildStdin>,
    /// Lines of its standard output, without their ends.
    pub out: Receiver<String>,
    /// Lines of its standard error.
    pub err: Receiver<String>,
}

/// What a process left.
#[derive(Debug)]
pub struct Finished {
    /// Exit code; none if a signal ended it.
    pub code: Option<i32>,
    /// The rest of its standard output.
    pub out: Vec<String>,
    /// The rest of its standard error, without how a search stands.
    pub err: Vec<String>,
}

/// Whether a line tells how a search for a plan stands. A search that lasts tells it from time to time: how often depends on the machine.
pub fn is_progress(line: &str) -> bool {
    line.starts_with("planning: ")
}

impl Process {
    /// Starts `flotilla` with these arguments in `folder`.
    pub fn start(folder: &Path, arguments: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_flotilla"));
        command.args(arguments).current_dir(folder);
        Self::spawn(command)
    }

    /// Starts `command`.
    pub fn spawn(mut command: Command) -> Self {
        let mut child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the binary starts");
        let input = child.stdin.take();
        let out = lines(child.stdout.take().expect("a pipe"));
        let err = lines(child.stderr.take().expect("a pipe"));
        Self { child, input, out, err }
    }

    /// Closes its input and waits for its end.
    pub fn finish(mut self) -> Finished {
        drop(self.input.take());
        let began = Instant::now();
        let status = loop {
            if let Some(status) = self.child.try_wait().expect("a child") {
                break status;
            }
            assert!(began.elapsed() < PATIENCE, "still running after {PATIENCE:?}");
            sleep(Duration::from_millis(5));
        };
        let err = self.err.iter().filter(|line| !is_progress(line)).collect();
        Finished { code: status.code(), out: self.out.iter().collect(), err }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The lines of a pipe, read by a thread so that neither side ever waits for the other. Bytes that are no UTF-8 are
/// shown as such.
fn lines(pipe: impl Read + Send + 'static) -> Receiver<String> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        for line in BufReader::new(pipe).split(b'\n').map_while(Result::ok) {
            if sender.send(String::from_utf8_lossy(&line).into_owned()).is_err() {
                break;
            }
        }
    });
    receiver
}
