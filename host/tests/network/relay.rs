//! A bad network as a process, for kernels without netem: takes every datagram off a real socket and hands it on over another,
//! or not, or twice, or late.
//!
//! ```text
//! module a ─→ front 10.77.0.2:4870 ─→ 10.77.0.2:a ─→ veth ─→ 10.77.0.1:4870 host
//! module b ─→                      ─→ 10.77.0.2:b ─→
//! ```
//!
//! Each module gets a socket of its own towards the host, which so sees an address for each, and answers to it. Both
//! directions suffer the same.

use std::collections::HashMap;
use std::io::Read;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use link::faults::{FaultCount, FaultParameters, Faulty};
use link::udp::UdpRadio;
use protocol::time::FleetInstant;
use protocol::{MAX_DATAGRAM, Radio};

use crate::common::Process;
use crate::net::{HOST, MODULES, Net, Side};

/// Set in the process that is the relay.
const VARIABLE: &str = "FLOTILLA_TEST_RELAY";
/// The port of both the host and the relay.
pub const PORT: u16 = 4870;

/// What netem would do: a tenth lost, 20 ± 15 ms, a twentieth twice, a tenth out of turn.
const WEATHER: FaultParameters = FaultParameters {
    loss: 0.1,
    delay_s: 0.005,
    jitter_s: 0.030,
    duplication: 0.05,
    reordering: 0.1,
    reorder_s: 0.020,
    burst: 0.0,
    burst_s: 0.0,
    corruption: 0.0,
    truncation: 0.0,
    late: 0.0,
    late_s: 0.0,
    replay: 0.0,
    replay_s: 0.0,
    forgery: 0.0,
};

/// Starts one beside the modules: this test program, told to run [`main`] alone.
pub fn start(net: &Net, folder: &Path) -> Process {
    let program = std::env::current_exe().expect("this program");
    let program = program.to_str().expect("a path in UTF-8");
    let relay = ["relay_process", "--exact", "--nocapture"];
    net.start_with(Side::Modules, folder, program, &relay, &[(VARIABLE, "1")])
}

/// The relay's own life, until its standard input ends; nothing in any other process.
pub fn main() {
    static END: AtomicBool = AtomicBool::new(false);
    if std::env::var_os(VARIABLE).is_none() {
        return;
    }
    std::thread::spawn(|| {
        let _ = std::io::stdin().read(&mut [0]);
        END.store(true, Ordering::Relaxed);
    });
    let host: SocketAddr = format!("{HOST}:{PORT}").parse().expect("an address");
    let bad = |address: &str, seed| Faulty::new(UdpRadio::bind(address).expect("a socket"), WEATHER, seed);
    let mut front = bad(&format!("{MODULES}:{PORT}"), 0);
    let mut backs: HashMap<SocketAddr, Faulty<UdpRadio>> = HashMap::new();
    let mut buffer = [0; MAX_DATAGRAM];
    let began = Instant::now();
    while !END.load(Ordering::Relaxed) {
        let now = FleetInstant(began.elapsed().as_micros() as u64);
        while let Some((length, module)) = front.receive(now, &mut buffer).expect("a socket") {
            let seed = backs.len() as u64 + 1;
            let back = backs.entry(module).or_insert_with(|| bad(&format!("{MODULES}:0"), seed));
            back.send(now, host, &buffer[..length]).expect("a socket");
        }
        for (&module, back) in &mut backs {
            while let Some((length, _)) = back.receive(now, &mut buffer).expect("a socket") {
                front.send(now, module, &buffer[..length]).expect("a socket");
            }
        }
        std::thread::sleep(Duration::from_micros(500));
    }
    let to_host = backs.values().map(Faulty::count).fold(FaultCount::default(), |sum, count| sum + count);
    for (way, count) in [("to the modules", front.count()), ("to the host", to_host)] {
        let FaultCount { sent, lost, duplicated, reordered, .. } = count;
        eprintln!("relay {way}: {sent} sent, {lost} lost, {duplicated} doubled, {reordered} held back");
    }
}
