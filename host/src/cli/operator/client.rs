//! The operator's end of a run's [socket](super::socket).

use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::Deserialize;

use super::socket::{Request, folder};
use super::{Failure, Wish};
use crate::run::orders::{ModuleStatus, RunStatus};

/// How long a run may take for an answer: it looks a thousand times a second.
const ANSWER_WITHIN: Duration = Duration::from_secs(2);
/// Pause between two looks at whether an order is followed.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// A run that is going on.
pub(super) struct Running {
    pid: u32,
    path: PathBuf,
}

impl Running {
    /// For a person.
    pub(super) fn name(&self) -> String {
        format!("run {}", self.pid)
    }
}

#[derive(Deserialize)]
struct Reply {
    status: Option<RunStatus>,
    error: Option<String>,
}

/// The run of process `pid`, or the only one; `None` where none is going on.
pub(super) fn running(pid: Option<u32>) -> Result<Option<Running>, Failure> {
    let folder = folder().map_err(super::super::could)?;
    let entries = std::fs::read_dir(&folder)
        .map_err(|error| Failure::Could(format!("{}: {error}", folder.display())))?;
    let mut all: Vec<Running> = entries
        .flatten()
        .filter_map(|entry| {
            let path = entry.path();
            let pid =
                path.file_name()?.to_str()?.strip_prefix("run-")?.strip_suffix(".sock")?.parse().ok()?;
            is_alive(&path).then_some(Running { pid, path })
        })
        .filter(|run| pid.is_none_or(|pid| run.pid == pid))
        .collect();
    match (all.pop(), all.as_slice(), pid) {
        (None, _, Some(pid)) => Err(Failure::Bad(format!("--run {pid}: no run of this process is going on"))),
        (run, [], _) => Ok(run),
        (run, others, _) => {
            let pids: Vec<String> = run.iter().chain(others).map(|run| run.pid.to_string()).collect();
            Err(Failure::Bad(format!("several runs are going on: say which, by --run {}", pids.join(" or "))))
        }
    }
}

/// Whether a process listens; the socket of one that is over is removed.
fn is_alive(path: &Path) -> bool {
    let alive = UnixStream::connect(path).is_ok();
    if !alive {
        let _ = std::fs::remove_file(path);
    }
    alive
}

/// Tells the run what is wanted, and waits until it is followed, at most `wait_s`. The modules at last.
pub(super) fn ask(
    run: &Running,
    wish: Wish,
    module: Option<u16>,
    wait_s: f64,
) -> Result<Vec<ModuleStatus>, Failure> {
    let mut modules = once(run, wish, module)?.modules;
    if wish == Wish::Status {
        return Ok(modules);
    }
    let until = Instant::now() + Duration::from_secs_f64(wait_s);
    loop {
        std::thread::sleep(LOOK_EVERY);
        let Ok(status) = once(run, Wish::Status, None) else {
            // It has ended.
            return Ok(modules);
        };
        modules = status.modules;
        let asked = |of: &&ModuleStatus| module.is_none_or(|id| of.id == id);
        let done = modules.iter().filter(asked).all(|module| wish.is_followed(module) != Some(false));
        if done || Instant::now() >= until {
            return Ok(modules);
        }
    }
}

fn once(run: &Running, wish: Wish, module: Option<u16>) -> Result<RunStatus, Failure> {
    let could = |why: &dyn std::fmt::Display| Failure::Could(format!("{}: {why}", run.name()));
    let request = serde_json::to_string(&Request { wish, module }).map_err(|error| could(&error))?;
    let mut stream = UnixStream::connect(&run.path).map_err(|error| could(&error))?;
    stream.set_read_timeout(Some(ANSWER_WITHIN)).map_err(|error| could(&error))?;
    stream.write_all(format!("{request}\n").as_bytes()).map_err(|error| could(&error))?;
    let mut line = String::new();
    let read = BufReader::new(stream).read_line(&mut line);
    read.map_err(|_| could(&format!("does not answer within {} s", ANSWER_WITHIN.as_secs())))?;
    let reply: Reply = serde_json::from_str(&line).map_err(|error| could(&error))?;
    reply.status.ok_or_else(|| could(&reply.error.unwrap_or_else(|| "no status".to_owned())))
}
