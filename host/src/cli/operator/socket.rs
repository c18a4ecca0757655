//! The socket by which an operator reaches a run that is going on: a Unix socket that its owner alone can open.
//!
//! One JSON line in, one JSON line out, then the connection is closed:
//!
//! ```text
//! → {"wish":"stop"}                       stop, hold, release (of one "module" alone, too) or status
//! ← {"scenario":"nine","status":{…}}      see RunStatus; of before the order
//! ```
//!
//! It lies in `$XDG_RUNTIME_DIR/flotilla`, or in `/tmp/flotilla-UID`, as `run-PID.sock`. The folder must belong to the user and be closed
//! to others.

use std::fs::{DirBuilder, Permissions};
use std::io::{self, ErrorKind, Read, Write};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use protocol::ModuleId;
use serde::{Deserialize, Serialize};

use super::Wish;
use crate::cli::signal::Signals;
use crate::run::orders::{Operator, Order, RunStatus};

/// The longest request, bytes.
const REQUEST_MAX: usize = 256;
/// Operators at the same time, at most.
const CLIENTS: usize = 8;
/// How long one may take to say what it wants.
const PATIENCE: Duration = Duration::from_secs(2);

/// A request.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Request {
    /// What is wanted.
    pub(super) wish: Wish,
    /// Of one module alone.
    #[serde(default)]
    pub(super) module: Option<u16>,
}

/// The folder of the sockets; made if it is not there.
///
/// # Errors
/// Of the file system, or that the folder is not this user's alone.
pub(super) fn folder() -> io::Result<PathBuf> {
    let owner = std::fs::metadata("/proc/self")?.uid();
    let folder = match std::env::var_os("XDG_RUNTIME_DIR").filter(|name| !name.is_empty()) {
        Some(runtime) => Path::new(&runtime).join("flotilla"),
        None => PathBuf::from(format!("/tmp/flotilla-{owner}")),
    };
    match DirBuilder::new().mode(0o700).create(&folder) {
        Err(error) if error.kind() != ErrorKind::AlreadyExists => return Err(error),
        _ => {}
    }
    let is = std::fs::symlink_metadata(&folder)?;
    if !is.is_dir() || is.uid() != owner || is.mode() & 0o077 != 0 {
        let why = format!("{}: must be a folder of this user, closed to others", folder.display());
        return Err(io::Error::new(ErrorKind::PermissionDenied, why));
    }
    Ok(folder)
}

struct Client {
    stream: UnixStream,
    request: Vec<u8>,
    since: Instant,
}

/// Orders by signals, and by the socket.
pub(in crate::cli) struct Desk {
    signals: Signals,
    scenario: String,
    listener: Option<(UnixListener, PathBuf)>,
    clients: Vec<Client>,
}

impl Desk {
    /// Signals alone: of a run in simulated time, which is over before one could reach it.
    pub(in crate::cli) fn signals() -> Self {
        Self { signals: Signals::default(), scenario: String::new(), listener: None, clients: Vec::new() }
    }

    /// With a socket for the run of `scenario`.
    ///
    /// # Errors
    /// As for [`folder`], or of the socket.
    pub(in crate::cli) fn open(scenario: &str) -> io::Result<Self> {
        let path = folder()?.join(format!("run-{}.sock", std::process::id()));
        // One of a process with this number that is over.
        let _ = std::fs::remove_file(&path);
        let listener = UnixListener::bind(&path)?;
        std::fs::set_permissions(&path, Permissions::from_mode(0o600))?;
        listener.set_nonblocking(true)?;
        let mut desk = Self::signals();
        (desk.scenario, desk.listener) = (scenario.to_owned(), Some((listener, path)));
        Ok(desk)
    }

    fn accept(&mut self) {
        let Some((listener, _)) = &self.listener else { return };
        while self.clients.len() < CLIENTS
            && let Ok((stream, _)) = listener.accept()
        {
            if stream.set_nonblocking(true).is_ok() {
                self.clients.push(Client { stream, request: Vec::new(), since: Instant::now() });
            }
        }
    }

    /// The next request that is whole, with where its answer goes.
    fn request(&mut self) -> Option<(UnixStream, Vec<u8>)> {
        let mut index = 0;
        while index < self.clients.len() {
            match self.clients[index].read() {
                Progress::Whole => {
                    let Client { stream, request, .. } = self.clients.swap_remove(index);
                    return Some((stream, request));
                }
                Progress::Gone => drop(self.clients.swap_remove(index)),
                Progress::Open => index += 1,
            }
        }
        None
    }
}

enum Progress {
    Open,
    Whole,
    Gone,
}

impl Client {
    fn read(&mut self) -> Progress {
        let mut bytes = [0; REQUEST_MAX];
        match self.stream.read(&mut bytes) {
            Ok(0) => return Progress::Gone,
            Ok(read) => self.request.extend_from_slice(&bytes[..read]),
            Err(error) if error.kind() == ErrorKind::WouldBlock => {}
            Err(_) => return Progress::Gone,
        }
        match self.request.contains(&b'\n') {
            true => Progress::Whole,
            false if self.request.len() > REQUEST_MAX || self.since.elapsed() > PATIENCE => Progress::Gone,
            false => Progress::Open,
        }
    }
}

impl Operator for Desk {
    fn poll(&mut self, status: &dyn Fn() -> RunStatus) -> Option<Order> {
        if let Some(order) = self.signals.poll(status) {
            return Some(order);
        }
        self.accept();
        while let Some((mut stream, request)) = self.request() {
            let (reply, order) = match serde_json::from_slice::<Request>(&request) {
                Ok(Request { wish, module }) => {
                    let reply = serde_json::json!({ "scenario": self.scenario, "status": status() });
                    (reply, wish.order(module.map(ModuleId)))
                }
                Err(error) => (serde_json::json!({ "error": error.to_string() }), None),
            };
            // An operator that does not take the answer has had its order followed all the same.
            let _ = stream.write_all(format!("{reply}\n").as_bytes());
            if order.is_some() {
                return order;
            }
        }
        None
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        if let Some((_, path)) = &self.listener {
            let _ = std::fs::remove_file(path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status() -> RunStatus {
        RunStatus { t_s: 1.5, duration_s: 9.0, fleet: "swims".to_owned(), order: None, modules: Vec::new() }
    }

    fn desk() -> (tempfile::TempDir, Desk) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("run-1.sock");
        let listener = UnixListener::bind(&path).expect("a socket");
        listener.set_nonblocking(true).expect("a socket");
        let mut desk = Desk::signals();
        desk.listener = Some((listener, path));
        (folder, desk)
    }

    fn says(desk: &Desk, words: &[u8]) -> UnixStream {
        let (_, path) = desk.listener.as_ref().expect("open");
        let mut stream = UnixStream::connect(path).expect("a run");
        stream.write_all(words).expect("room");
        stream
    }

    fn hears(mut stream: UnixStream) -> String {
        let mut reply = String::new();
        stream.read_to_string(&mut reply).expect("an answer");
        reply
    }

    #[test]
    fn orders_come_in_their_turn_and_each_is_answered() {
        let (_folder, mut desk) = desk();
        let streams = ["stop", "status", "release", "hold"]
            .map(|wish| says(&desk, format!("{{\"wish\":\"{wish}\"}}\n").as_bytes()));
        let orders: Vec<Order> = std::iter::from_fn(|| desk.poll(&status)).collect();
        assert_eq!(orders.len(), 3, "{orders:?}");
        for order in [Order::Stop, Order::Release(None), Order::Hold] {
            assert!(orders.contains(&order), "{orders:?}");
        }
        for stream in streams {
            assert!(hears(stream).contains("\"fleet\":\"swims\""));
        }
    }

    #[test]
    fn what_is_no_request_orders_nothing_and_blocks_nothing() {
        let (_folder, mut desk) = desk();
        let silent = says(&desk, b"{\"wish\"");
        let wrong = says(&desk, b"{\"wish\":\"jump\"}\n");
        let more = says(&desk, b"{\"wish\":\"stop\",\"boat\":3}\n");
        let long = says(&desk, &[b'x'; 2 * REQUEST_MAX]);
        drop(says(&desk, b""));
        assert_eq!((desk.poll(&status), desk.poll(&status)), (None, None));
        assert!(hears(wrong).contains("jump"));
        assert!(hears(more).contains("boat"));
        let good = says(&desk, b"{\"wish\":\"stop\"}\n");
        assert_eq!(desk.poll(&status), Some(Order::Stop));
        drop((silent, long, good));
    }

    #[test]
    fn more_operators_than_there_is_room_for_wait_for_their_turn() {
        let (_folder, mut desk) = desk();
        let silent: Vec<UnixStream> = (0..CLIENTS).map(|_| says(&desk, b"{")).collect();
        assert_eq!(desk.poll(&status), None);
        let waits = says(&desk, b"{\"wish\":\"stop\"}\n");
        assert_eq!(desk.poll(&status), None);
        drop(silent);
        assert_eq!((desk.poll(&status), desk.poll(&status)), (None, Some(Order::Stop)));
        drop(waits);
    }
}
