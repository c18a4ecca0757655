//! Random and oversized requests and frames at the server while three modules swim over UDP: it goes on, it grows no more than without
//! them, and no more cycles come late. `FLOTILLA_CONSOLE_FRAMES=100000 cargo test -p host --test all console::storm` sends all of them.

use std::fs::File;
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::time::Duration;

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use runlog::flotilla::{Link, Links};
use runlog::reader::{LogError, read};
use serde_json::Value;
use tempfile::tempdir;
use tungstenite::WebSocket;

use super::client::{Page, host_of, open_as};
use super::{executing, served};
use crate::common::{PATIENCE, Process};
use crate::interrupt::end;
use crate::keys::{KEY, keygen};

/// As many as a check of every change has time for.
const SHARE: u64 = 3000;

/// Cycles are sent a second ahead, so that a process that waits for its turn on the processor still hears of them in time.
const SCENARIO: &str = "name = \"t\"\n[structure]\nsize = \"3x1\"\n[[leg]]\nduration_s = 3000\nvelocity_m_s = [0.04, 0]\n\
     heading_rad = 1.5\n[timing]\nlead_s = 1.0\njoin_s = 60\n";

fn random_bytes(random: &mut ChaCha8Rng, most: usize) -> Vec<u8> {
    (0..random.random_range(0..most)).map(|_| random.random()).collect()
}

/// A request that is none, or too long, or nearly right.
fn request(random: &mut ChaCha8Rng, host: &str) -> Vec<u8> {
    match random.random_range(0..5) {
        0 => random_bytes(random, 400),
        1 => vec![b'a'; random.random_range(1..40_000)],
        2 => format!(
            "GET / HTTP/1.1\r\nHost: {host}\r\n{}\r\n",
            "X: y\r\n".repeat(random.random_range(0..200))
        )
        .into(),
        3 => format!("GET /{} HTTP/1.1\r\n", "b".repeat(random.random_range(0..20_000))).into(),
        _ => {
            let mut whole = format!(
                "GET /socket HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
                 Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\
                 Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n"
            )
            .into_bytes();
            let at = random.random_range(0..whole.len());
            whole[at] = random.random();
            whole
        }
    }
}

/// A frame: random bytes, or a good head with a length, kind and mask that may be anything.
fn frame(random: &mut ChaCha8Rng) -> Vec<u8> {
    if random.random_range(0..4) == 0 {
        return random_bytes(random, 200);
    }
    let opcode: u8 = if random.random_range(0..3) == 0 {
        random.random()
    } else {
        [0x81, 0x82][random.random_range(0..2)]
    };
    let content: Vec<u8> = match random.random_range(0..5) {
        0 => random_bytes(random, 100),
        1 => br#"{"id":1,"do":"stop"}"#.to_vec(),
        2 => br#"{"op":"subscribe","subscriptions":[{"id":1,"channelId":1}]}"#.to_vec(),
        3 => vec![b'['; random.random_range(0..3000)],
        _ => vec![b'x'; random.random_range(0..100_000)],
    };
    let mut bytes = vec![opcode];
    let masked = if random.random_range(0..8) == 0 { 0 } else { 0x80 };
    // Once in a while it claims more than there is, or than there can be.
    let claimed = if random.random_range(0..10) == 0 { random.random() } else { content.len() as u64 };
    match claimed {
        0..126 => bytes.push(masked | claimed as u8),
        126..65_536 => {
            bytes.push(masked | 126);
            bytes.extend((claimed as u16).to_be_bytes());
        }
        _ => {
            bytes.push(masked | 127);
            bytes.extend(claimed.to_be_bytes());
        }
    }
    if masked != 0 {
        // A mask of zeros leaves the content as it is.
        bytes.extend([0; 4]);
    }
    bytes.extend(content);
    bytes
}

/// What a server that closes the connection does to a sender is no matter here.
fn send(stream: &mut TcpStream, bytes: &[u8]) -> bool {
    let sent = stream.write_all(bytes).is_ok();
    let mut taken = [0; 65_536];
    let open = match stream.read(&mut taken) {
        Ok(0) => false,
        Ok(_) => true,
        Err(error) => matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut),
    };
    sent && open
}

/// Memory of a process, kB.
fn resident_kb(process: &Process) -> u64 {
    let path = format!("/proc/{}/status", process.child.id());
    let text = std::fs::read_to_string(path).expect("it runs");
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("a size");
    line.trim().trim_end_matches(" kB").trim().parse().expect("a number")
}

/// Sends `frames` of them, over as many connections as that takes; false if the server is gone.
#[must_use]
fn storm(url: &str, frames: u64, seed: u64) -> bool {
    let (host, mut random) = (host_of(url), ChaCha8Rng::seed_from_u64(seed));
    let brief = Some(Duration::from_micros(200));
    let mut socket: Option<WebSocket<TcpStream>> = None;
    for number in 0..frames {
        if number % 4 == 0 {
            let Ok(mut stream) = TcpStream::connect(&host) else { return false };
            stream.set_read_timeout(brief).expect("a timeout");
            let bytes = request(&mut random, &host);
            send(&mut stream, &bytes);
            continue;
        }
        let mut open = match socket.take() {
            Some(open) => open,
            None => {
                let protocol = ["flotilla.console.v1", "foxglove.sdk.v1"][random.random_range(0..2)];
                match open_as(url, protocol, None, "") {
                    Ok(open) => open,
                    Err(0) => return false,
                    Err(code) => panic!("refused with {code}"),
                }
            }
        };
        open.get_ref().set_read_timeout(brief).expect("a timeout");
        let bytes = frame(&mut random);
        socket = send(open.get_mut(), &bytes).then_some(open);
    }
    true
}

/// Cycles of all modules.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    cycles: u64,
    late: u64,
    refused: u64,
}

impl Counts {
    fn since(self, before: Self) -> Self {
        Self {
            cycles: self.cycles - before.cycles,
            late: self.late - before.late,
            refused: self.refused - before.refused,
        }
    }
}

/// What the log of a run that wrote to `results` has counted by `fleet_s`.
fn counts(folder: &Path, fleet_s: f64) -> Counts {
    let mut counts = Counts::default();
    let log = File::open(folder.join("results/log.mcap")).expect("a log");
    let extent = read(log, |entry, _| {
        if entry.topic == "/links" && entry.at_s() <= fleet_s {
            let links = entry.read::<Links>()?.links;
            let sum = |of: fn(&Link) -> u64| links.iter().map(of).sum();
            counts = Counts { cycles: sum(|l| l.cycles), late: sum(|l| l.late), refused: sum(|l| l.refused) };
        }
        Ok::<(), LogError>(())
    });
    assert!(extent.expect("a log").whole);
    counts
}

#[test]
fn random_requests_and_frames_do_nothing_to_a_run() {
    let frames =
        std::env::var("FLOTILLA_CONSOLE_FRAMES").map_or(SHARE, |text| text.parse().expect("a number"));
    let folder = tempdir().expect("a folder");
    keygen(folder.path());
    std::fs::write(folder.path().join("t.toml"), SCENARIO).expect("a file");
    let arguments = [
        "run",
        "t.toml",
        "--radio",
        "udp",
        "--listen",
        "127.0.0.1:0",
        "--key",
        KEY,
        "--out",
        "results",
        "--serve",
        "127.0.0.1:0",
    ];
    let run = Process::reachable(folder.path(), &arguments);
    let (mut url, mut address) = (None, None);
    while url.is_none() || address.is_none() {
        let line = run.err.recv_timeout(PATIENCE).expect("a line");
        if let Some(found) = line.strip_prefix("the page: ") {
            url = Some(found.to_owned());
        }
        if let Some(rest) = line.strip_prefix("listening on ") {
            address = rest.split_once(' ').map(|(address, _)| address.to_owned());
        }
    }
    let (url, address) = (url.expect("an address"), address.expect("an address"));
    let modules = ["1", "2", "3"].map(|id| {
        let arguments = ["module", "--id", id, "--host", &address, "--duration", "3600", "--key", KEY];
        Process::start(folder.path(), &arguments)
    });
    // As long without as with them: what a busy machine does to a run it does to both.
    let fleet_s = || Page::open(&url).until(executing)["fleet_s"].as_f64().expect("a time");
    fleet_s();
    if !storm(&url, frames / 10, 1) {
        panic!("it is gone: {:?}", run.finish());
    }
    let (storm_s, before_kb) = (fleet_s(), resident_kb(&run));
    if !storm(&url, frames - frames / 10, 2) {
        panic!("it is gone: {:?}", run.finish());
    }
    let (quiet_s, between_kb) = (fleet_s(), resident_kb(&run));
    let spans_s = quiet_s - storm_s;
    std::thread::sleep(Duration::from_secs_f64(spans_s));
    let (over_s, after_kb) = (fleet_s(), resident_kb(&run));
    let snapshot = Page::open(&url).until(executing);
    assert_eq!((&snapshot["order"], &snapshot["lost"]), (&Value::Null, &Value::from(0)), "{snapshot}");
    end(&run, "INT");
    let finished = run.finish();
    assert!(finished.err.iter().all(|line| !line.contains("panicked")), "{finished:?}");

    let at = |t_s| counts(folder.path(), t_s);
    let [first, second, third] = [at(storm_s), at(quiet_s), at(over_s)];
    let (stormy, quiet) = (second.since(first), third.since(second));
    println!(
        "{frames} requests and frames, the last nine tenths in {spans_s:.0} s: {before_kb} kB, then {between_kb} kB; after as long \
         without {after_kb} kB. With: {stormy:?}. Without: {quiet:?}"
    );
    assert!(stormy.late <= quiet.late && stormy.refused <= quiet.refused, "{stormy:?}, without {quiet:?}");
    // A leak of a hundred bytes a frame would be 10 MB; buffers of 64 clients come and go.
    let grown_kb = |from: u64, to: u64| to.saturating_sub(from);
    assert!(
        grown_kb(before_kb, between_kb) <= grown_kb(between_kb, after_kb) + 8_000,
        "{before_kb} kB, then {between_kb} kB, then {after_kb} kB"
    );
    drop(modules);
}

/// A request that comes in pieces is one; one that never ends is closed.
#[test]
fn a_slow_request_is_a_request() {
    let folder = tempdir().expect("a folder");
    let arguments = ["run", "--serve", "127.0.0.1:0", "--out", "results"];
    let (_run, url) = served(folder.path(), &arguments);
    let host = host_of(&url);
    let mut slow = TcpStream::connect(&host).expect("a server");
    slow.set_read_timeout(Some(PATIENCE)).expect("a timeout");
    for piece in format!("GET / HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes().chunks(7) {
        slow.write_all(piece).expect("room");
        std::thread::sleep(Duration::from_millis(15));
    }
    let mut reply = String::new();
    slow.read_to_string(&mut reply).expect("a reply");
    assert!(reply.starts_with("HTTP/1.1 200"), "{reply}");
    let mut silent = TcpStream::connect(&host).expect("a server");
    silent.set_read_timeout(Some(PATIENCE)).expect("a timeout");
    silent.write_all(b"GET / HTTP/1.1\r\n").expect("room");
    assert_eq!(silent.read(&mut [0; 16]).expect("its end"), 0);
}
