//! What clients of the console cost the loop: how late its ticks are with fifty of them, five of which take nothing, and how late without,
//! in one run of the program. `cargo bench -p host --bench console`.
//!
//! The clients live in the same process and take their share of the machine; the ratio holds that against the console.

use std::cell::RefCell;
use std::net::TcpStream;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
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
use tungstenite::ClientRequestBuilder;

const CLIENTS: usize = 50;
const STALLED: usize = 5;
/// Turn about, so that a busy machine is busy for both.
const TURNS: usize = 3;

const SCENARIO: &str = "name = \"nine\"\n[structure]\nsize = \"3x3\"\n[[leg]]\nduration_s = 12\nvelocity_m_s = [0.03, 0]\n\
                        heading_rad = 1.57\n";

/// How late each tick of a run is, ms.
fn lateness_ms(scenario: &Scenario, log: Log) -> Vec<f64> {
    let mut fleet = InProcess::boats(scenario, 1).expect("valid");
    let (began, late) = (RefCell::new(None), RefCell::new(Vec::new()));
    let mut hook = |now: FleetInstant, _: &Pilot, _: &mut InProcess| {
        let mut began = began.borrow_mut();
        let (wall, fleet) = *began.get_or_insert((Instant::now(), now));
        let due = Duration::from_micros(now.0 - fleet.0);
        late.borrow_mut().push(1e3 * wall.elapsed().saturating_sub(due).as_secs_f64());
    };
    let drive = Drive { pace: Pace::Watched, operator: &mut Unattended, hook: &mut hook };
    run_into(log, scenario, 1, &mut fleet, drive, &mut Quiet).expect("runs");
    let mut late = late.into_inner();
    late.sort_by(f64::total_cmp);
    late
}

/// A client that reads for as long as it is to; or only connects.
fn client(host: &str, reads: bool, goes_on: &AtomicBool, came: &AtomicU64) {
    let uri = format!("ws://{host}/socket").parse().expect("an address");
    let request = ClientRequestBuilder::new(uri).with_sub_protocol("flotilla.console.v1");
    let stream = TcpStream::connect(host).expect("a server");
    stream.set_read_timeout(Some(Duration::from_millis(500))).expect("a timeout");
    let (mut socket, _) = tungstenite::client(request, stream).expect("a socket");
    while goes_on.load(Ordering::Relaxed) {
        if !reads {
            std::thread::sleep(Duration::from_millis(50));
        } else if socket.read().is_ok() {
            came.fetch_add(1, Ordering::Relaxed);
        } else {
            return;
        }
    }
}

fn resident_mb() -> f64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok()).unwrap_or(f64::NAN) / 1024.0
}

fn main() {
    let scenario = Scenario::parse("nine", SCENARIO).expect("a scenario");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("log.mcap");
    for turn in 0..TURNS {
        let alone = lateness_ms(&scenario, Log::create(&path).expect("a file"));
        let (tap, live) = tap();
        let (counter, _desk) = desk();
        let bound = bind("127.0.0.1:0", false).expect("a port");
        let host = bound.address().to_string();
        let source = Source::Run { live, counter, steer: true };
        let server = bound.start(source, Box::new(|_| Ok(serde_json::json!({})))).expect("a thread");
        let (goes_on, came) = (AtomicBool::new(true), AtomicU64::new(0));
        let before_mb = resident_mb();
        let served = std::thread::scope(|scope| {
            for number in 0..CLIENTS {
                let (host, goes_on, came) = (&host, &goes_on, &came);
                scope.spawn(move || client(host, number >= STALLED, goes_on, came));
            }
            let log = Log::create_tapped(&path, Some(Box::new(tap))).expect("a file");
            let served = lateness_ms(&scenario, log);
            goes_on.store(false, Ordering::Relaxed);
            served
        });
        let after_mb = resident_mb();
        drop(server);
        let at = |all: &[f64], share: f64| all[((all.len() - 1) as f64 * share) as usize];
        for (name, share) in [("median", 0.5), ("p99", 0.99), ("latest", 1.0)] {
            let (without, with) = (at(&alone, share), at(&served, share));
            println!(
                "turn {turn}: {name:7} {without:8.3} ms without, {with:8.3} ms with: {:.2} times",
                with / without
            );
        }
        let came = came.load(Ordering::Relaxed);
        println!("turn {turn}: {came} messages came; {before_mb:.1} MB before, {after_mb:.1} MB at the end");
    }
}
