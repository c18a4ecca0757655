//! The server: one thread for all connections, that waits for none.

use std::net::{SocketAddr, TcpListener, ToSocketAddrs};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::access::{Access, Token};
use super::desk::Counter;
use super::player::Player;
use super::tap::Live;
use super::view::Stage;
use hub::Hub;

mod audience;
mod hub;
mod session;

/// Where it listens if nothing else is said.
pub const ADDRESS: &str = "127.0.0.1:4880";
/// It looks at least so often at what the loop has for it.
const LOOK_EVERY: Duration = Duration::from_millis(10);
/// And no more often than this, whatever clients send.
const LOOK_AT_MOST: Duration = Duration::from_millis(1);
/// What the system may keep of what is on its way to a client: by itself Linux goes up to 4 MiB, twenty seconds of snapshots. *Assumed.*
const SENT_BYTES: usize = 128 << 10;
/// When the run is over, clients have this time to take what is left, and as much to take that it was the last.
const LEFT_WITHIN: Duration = Duration::from_millis(300);

/// What is shown.
pub enum Source {
    /// A run that is going on.
    Run {
        /// Its messages.
        live: Live,
        /// Where its orders go.
        counter: Counter,
        /// Whether it takes targets.
        steer: bool,
    },
    /// A log.
    Log(Box<Player>),
}

/// A server that does not serve yet: its port is taken.
pub struct Bound {
    listener: TcpListener,
    access: Access,
}

/// Takes the port.
///
/// # Errors
/// One line: an address that does not resolve, is in use, or is no loopback and not allowed to be.
pub fn bind(address: &str, allow_remote: bool) -> Result<Bound, String> {
    let failed = |error: &dyn std::fmt::Display| format!("--serve {address}: {error}");
    let mut all = address.to_socket_addrs().map_err(|error| failed(&error))?;
    let first = all.next().ok_or_else(|| failed(&"no such address"))?;
    if !first.ip().is_loopback() && !allow_remote {
        return Err(failed(&"others could reach it: that needs --allow-remote"));
    }
    let listener = TcpListener::bind(first).map_err(|error| failed(&error))?;
    listener.set_nonblocking(true).map_err(|error| failed(&error))?;
    // Connections inherit it. Where it cannot be set, what a slow client is sent is only older.
    let _ = socket2::SockRef::from(&listener).set_send_buffer_size(SENT_BYTES);
    let address = listener.local_addr().map_err(|error| failed(&error))?;
    Ok(Bound { listener, access: Access { address, token: Token::random()? } })
}

impl Bound {
    /// Where it listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.access.address
    }

    /// The page's address, with the token.
    #[must_use]
    pub fn url(&self) -> String {
        let mut address = self.access.address;
        if address.ip().is_unspecified() {
            let local = if address.is_ipv4() { "127.0.0.1" } else { "::1" };
            if let Ok(local) = local.parse() {
                address.set_ip(local);
            }
        }
        format!("http://{address}/#token={}", self.access.token.text())
    }

    /// Begins to serve.
    ///
    /// # Errors
    /// That there is no thread for it.
    pub fn start(self, source: Source, stage: Box<Stage>) -> Result<Server, String> {
        let stop = Arc::new(AtomicBool::new(false));
        let asked = Arc::clone(&stop);
        let Self { listener, access } = self;
        let mut hub = Hub::new(access, source, stage, Instant::now());
        let thread = std::thread::Builder::new().name("console".to_owned());
        let thread = thread.spawn(move || serve(&listener, &mut hub, &asked));
        Ok(Server { stop, thread: Some(thread.map_err(|error| format!("the console's thread: {error}"))?) })
    }
}

/// A server that serves until it is dropped.
pub struct Server {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A server that broke has nothing more to say.
            let _ = thread.join();
        }
    }
}

fn serve(listener: &TcpListener, hub: &mut Hub, stop: &AtomicBool) {
    let (mut over, mut told) = (None, false);
    loop {
        let began = Instant::now();
        hub.look(began);
        if stop.load(Ordering::Relaxed) {
            // What is told last may be of a topic that is new, to which clients subscribe first.
            let since = began.saturating_duration_since(*over.get_or_insert(began));
            if hub.clients().next().is_none() || since >= 2 * LEFT_WITHIN || told && !hub.has_left() {
                return;
            }
            if since >= LEFT_WITHIN && !told {
                hub.finish(began);
                told = true;
            }
        }
        wait(listener, hub);
        let now = Instant::now();
        hub.accept(listener, now);
        hub.read(now);
        std::thread::sleep(LOOK_AT_MOST.saturating_sub(now.saturating_duration_since(began)));
    }
}

/// Until a client says something or takes something, and not for long.
fn wait(listener: &TcpListener, hub: &Hub) {
    let mut all = vec![PollFd::new(listener, PollFlags::IN)];
    all.extend(hub.clients().filter_map(|client| {
        let writes = if client.wants_to_write() { PollFlags::OUT } else { PollFlags::empty() };
        Some(PollFd::new(client.stream()?, PollFlags::IN | writes))
    }));
    let timeout = Timespec { tv_sec: 0, tv_nsec: i64::from(LOOK_EVERY.subsec_nanos()) };
    if poll(&mut all, Some(&timeout)).is_err() {
        std::thread::sleep(LOOK_AT_MOST);
    }
}
