//! What clients of the console cost the loop: how late its ticks are with fifty clients of the Foxglove stream, five of which take nothing,
//! and how late with none, turn about in one run of the program. `cargo bench -p host --bench console`.
//!
//! The clients are a process of their own, so that memory is the run's alone. The scheduler runs it where nothing else wants to run: clients
//! stand for other machines, and what is measured is what the server costs the loop. A tick is late against the earliest of its run.

use std::cell::RefCell;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use host::run::closed_loop::Drive;
use host::run::experiment::{Pace, run_into};
use host::run::fleet::InProcess;
use host::run::log::Log;
use host::run::orders::Unattended;
use host::run::pilot::Pilot;
use host::run::progress::Quiet;
use host::run::scenario::Scenario;
use protocol::time::FleetInstant;
use runconsole::desk::desk;
use runconsole::server::{Source, bind};
use runconsole::tap::tap;
use serde_json::{Value, json};
use tungstenite::protocol::Role;
use tungstenite::{Error, Message, WebSocket};

const CLIENTS: usize = 50;
const STALLED: usize = 5;
/// Turn about, so that a busy machine is busy for both.
const TURNS: usize = 5;

/// Time from one tick to the next.
const TICK_MS: f64 = 1.0;

const SCENARIO: &str = "name = \"nine\"\n[structure]\nsize = \"3x3\"\n[[leg]]\nduration_s = 12\nvelocity_m_s = [0.03, 0]\n\
                        heading_rad = 1.57\n";

/// How late each tick of a run is, ms, in order of size.
fn lateness_ms(scenario: &Scenario, log: Log) -> Vec<f64> {
    let mut fleet = InProcess::boats(scenario, 1).expect("valid");
    let (began, at) = (Instant::now(), RefCell::new(Vec::with_capacity(20_000)));
    let mut hook = |now: FleetInstant, _: &Pilot, _: &mut InProcess| {
        at.borrow_mut().push(1e3 * began.elapsed().as_secs_f64() - 1e-3 * now.0 as f64);
    };
    let drive = Drive { pace: Pace::Watched, operator: &mut Unattended, hook: &mut hook };
    run_into(log, scenario, 1, &mut fleet, drive, &mut Quiet).expect("runs");
    let mut late = at.into_inner();
    late.sort_by(f64::total_cmp);
    let earliest = late[0];
    late.iter_mut().for_each(|late| *late -= earliest);
    late
}

/// What was measured of a run with clients or without.
struct Turn {
    late_ms: Vec<f64>,
    before_mb: f64,
    after_mb: f64,
}

/// A run with a page, and `clients` that follow all of it.
fn turn(scenario: &Scenario, path: &std::path::Path, clients: bool) -> Turn {
    let (tap, live) = tap();
    let (counter, _desk) = desk();
    let bound = bind("127.0.0.1:0", false).expect("a port");
    let address = bound.address().to_string();
    let source = Source::Run { live, counter, steer: true };
    let server = bound.start(source, Box::new(|_| Ok(json!({})))).expect("a thread");
    let before_mb = resident_mb();
    let clients = clients.then(|| Followers::start(&address));
    let log = Log::create_tapped(path, Some(Box::new(tap))).expect("a file");
    let late_ms = lateness_ms(scenario, log);
    let after_mb = resident_mb();
    let told = clients.map(Followers::stop);
    drop(server);
    told.iter().for_each(|told| println!("{told}"));
    Turn { late_ms, before_mb, after_mb }
}

fn resident_mb() -> f64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok()).unwrap_or(f64::NAN) / 1024.0
}

/// The process of the clients.
struct Followers {
    child: Child,
}

impl Followers {
    /// All are connected when it returns.
    fn start(address: &str) -> Self {
        let program = std::env::current_exe().expect("this program");
        // Of util-linux; --idle is SCHED_IDLE.
        let mut command = Command::new("chrt");
        command
            .args(["--idle", "0"])
            .arg(program)
            .args(["clients", address])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped());
        let mut child = command.spawn().expect("a process");
        let mut ready = [0; 6];
        child.stdout.as_mut().expect("a pipe").read_exact(&mut ready).expect("it connects");
        Self { child }
    }

    /// Ends it: what it says of what came.
    fn stop(mut self) -> String {
        drop(self.child.stdin.take());
        let mut lines = BufReader::new(self.child.stdout.take().expect("a pipe")).lines();
        let line = lines.next().expect("a line").expect("a line");
        self.child.wait().expect("it ends");
        line
    }
}

/// One client of the stream.
struct Follower {
    socket: WebSocket<TcpStream>,
    /// Messages of topics that came, and were dropped as the server says.
    came: u64,
    dropped: u64,
    subscriptions: u64,
    is_over: bool,
}

impl Follower {
    fn open(address: &str) -> Self {
        let mut stream = TcpStream::connect(address).expect("a server");
        let request = format!(
            "GET /socket HTTP/1.1\r\nHost: {address}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
             Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\
             Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n"
        );
        stream.write_all(request.as_bytes()).expect("room");
        let mut head = Vec::new();
        while !head.ends_with(b"\r\n\r\n") {
            let mut byte = [0];
            stream.read_exact(&mut byte).expect("a reply");
            head.extend(byte);
        }
        assert!(head.starts_with(b"HTTP/1.1 101 "), "{}", String::from_utf8_lossy(&head));
        let socket = WebSocket::from_raw_socket(stream, Role::Client, None);
        Self { socket, came: 0, dropped: 0, subscriptions: 0, is_over: false }
    }

    fn subscribe(&mut self, channels: impl Iterator<Item = u64>) {
        let subscriptions: Vec<Value> = (self.subscriptions..)
            .zip(channels)
            .map(|(id, channel)| json!({ "id": id, "channelId": channel }))
            .collect();
        self.subscriptions += subscriptions.len() as u64;
        let text = json!({ "op": "subscribe", "subscriptions": subscriptions }).to_string();
        self.is_over |= self.socket.send(Message::text(text)).is_err();
    }

    /// Takes in what has come.
    fn read(&mut self) {
        while !self.is_over {
            match self.socket.read() {
                Ok(Message::Binary(_)) => self.came += 1,
                Ok(Message::Text(text)) => {
                    let value: Value = serde_json::from_str(&text).expect("JSON");
                    if let Some(channels) = value["channels"].as_array() {
                        self.subscribe(channels.iter().filter_map(|channel| channel["id"].as_u64()));
                    }
                    let words = value["message"].as_str().unwrap_or_default();
                    if let Some((dropped, _)) = words.split_once(" messages were dropped") {
                        self.dropped = dropped.parse().expect("a number");
                    }
                }
                Ok(_) => {}
                Err(Error::Io(error)) if error.kind() == std::io::ErrorKind::WouldBlock => return,
                Err(_) => self.is_over = true,
            }
        }
    }
}

/// The process of the clients: follows everything at `address` until its input ends.
fn follow(address: &str) {
    let mut reading: Vec<Follower> = (STALLED..CLIENTS).map(|_| Follower::open(address)).collect();
    // Those that take nothing ask for every topic twelve times, so that what waits for them gets as big as it can in a short run.
    let mut stalled: Vec<Follower> = (0..STALLED).map(|_| Follower::open(address)).collect();
    for follower in &mut stalled {
        socket2::SockRef::from(follower.socket.get_ref()).set_recv_buffer_size(4096).expect("a size");
        follower.subscribe((0..12).flat_map(|_| 0..40));
    }
    for follower in reading.iter().chain(&stalled) {
        follower.socket.get_ref().set_nonblocking(true).expect("a socket");
    }
    println!("ready");
    let goes_on = AtomicBool::new(true);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let _ = std::io::stdin().read_to_end(&mut Vec::new());
            goes_on.store(false, Ordering::Relaxed);
        });
        while goes_on.load(Ordering::Relaxed) {
            reading.iter_mut().for_each(Follower::read);
            std::thread::sleep(Duration::from_millis(5));
        }
    });
    // What was left for the stalled ones: the system's buffers and the server's queue.
    for follower in &stalled {
        let _ = socket2::SockRef::from(follower.socket.get_ref()).set_recv_buffer_size(1 << 20);
    }
    let until = Instant::now() + Duration::from_secs(5);
    while Instant::now() < until {
        reading.iter_mut().chain(&mut stalled).for_each(Follower::read);
        std::thread::sleep(Duration::from_millis(5));
    }
    let sum = |all: &[Follower], of: fn(&Follower) -> u64| all.iter().map(of).sum::<u64>();
    println!(
        "    {} clients that read: {} messages came, {} dropped, {} closed; {STALLED} stalled: {} came in the end, {} dropped, {} closed",
        reading.len(),
        sum(&reading, |follower| follower.came),
        sum(&reading, |follower| follower.dropped),
        sum(&reading, |follower| u64::from(follower.is_over)),
        sum(&stalled, |follower| follower.came),
        sum(&stalled, |follower| follower.dropped),
        sum(&stalled, |follower| u64::from(follower.is_over)),
    );
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let [_, word, address] = arguments.as_slice()
        && word == "clients"
    {
        return follow(address);
    }
    let scenario = Scenario::parse("nine", SCENARIO).expect("a scenario");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("log.mcap");
    let at = |late_ms: &[f64], share: f64| late_ms[((late_ms.len() - 1) as f64 * share) as usize];
    let mut pooled_ms = [Vec::new(), Vec::new()];
    for number in 1..=TURNS {
        for (clients, pooled_ms) in [false, true].into_iter().zip(&mut pooled_ms) {
            let Turn { late_ms, before_mb, after_mb } = turn(&scenario, &path, clients);
            println!(
                "turn {number}, {:2} clients: late by {:.3} ms (median), {:.3} ms (99 %), {:.3} ms (greatest); \
                 {before_mb:.1} MB before, {after_mb:.1} MB at the end",
                if clients { CLIENTS } else { 0 },
                at(&late_ms, 0.5),
                at(&late_ms, 0.99),
                at(&late_ms, 1.0)
            );
            pooled_ms.extend(late_ms);
        }
    }
    pooled_ms.iter_mut().for_each(|late_ms| late_ms.sort_by(f64::total_cmp));
    for (name, share) in [("median", 0.5), ("99 %", 0.99), ("99.9 %", 0.999), ("greatest", 1.0)] {
        let [without, with] = pooled_ms.each_ref().map(|late_ms| at(late_ms, share));
        // A median of nothing has no ratio.
        let ratio = with / without.max(1e-3);
        println!("{name}: {without:.3} ms without, {with:.3} ms with: {ratio:.2} times");
    }
    let [without, with] =
        pooled_ms.each_ref().map(|late_ms| late_ms.iter().filter(|late| **late > TICK_MS).count());
    println!("later than a tick: {without} without, {with} with, of {}", pooled_ms[0].len());
}
