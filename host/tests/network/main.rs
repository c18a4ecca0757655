//! A real network, and a bad one: the host in one network namespace, three module processes in another, between them a virtual
//! cable that loses 10 %, delays by 20 ± 15 ms, doubles 5 % and reorders 10 %, either way. In real time, so nothing is asked
//! that does not hold however busy this machine is: that they swim, that a killed host is followed by another, and that every count is
//! exact. How well they do on such a network is asked in simulated time.
//!
//! netem does that where the kernel has it (`sch_netem`), otherwise a relay between real sockets; what it was is printed. Wants
//! root and iproute2, and fails without. In namespaces of its own; nothing of the machine's network is changed.

#[path = "../all/common/mod.rs"]
mod common;
#[path = "../all/interrupt/mod.rs"]
mod interrupt;
mod net;
mod relay;

use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use common::{Finished, PATIENCE, Process};
use interrupt::end;
use net::{HOST, MODULES, Net, Side};
use relay::PORT;
use serde_json::Value;
use tempfile::{TempDir, tempdir};

const FLOTILLA: &str = env!("CARGO_BIN_EXE_flotilla");

/// One at a time: they run in real time.
static TURN: Mutex<()> = Mutex::new(());

/// holonomic-1, shorter.
fn scenario(duration_s: f64) -> String {
    format!(
        "name = \"t\"\n[structure]\nsize = \"3x1\"\n[[leg]]\nduration_s = {duration_s}\nvelocity_m_s = [0.04, 0.0]\n\
         heading_rad = 1.5707963267948966\n[timing]\nlead_s = 1.0\njoin_s = 600\n"
    )
}

/// A network with a relay where the kernel cannot spoil it, and a fleet's key. What is dropped first is named first.
struct Tank {
    relay: Option<Process>,
    net: Net,
    folder: TempDir,
}

impl Tank {
    fn new() -> Self {
        let folder = tempdir().expect("a folder");
        let key = Process::start(folder.path(), &["keygen", "--out", "fleet.key"]).finish();
        assert_eq!(key.code, Some(0), "{key:?}");
        let net = Net::new();
        let relay = (!net.netem).then(|| relay::start(&net, folder.path()));
        Self { relay, net, folder }
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    /// A run of `duration_s`.
    fn host(&self, name: &str, duration_s: f64) -> Process {
        let file = format!("{name}.toml");
        std::fs::write(self.path().join(&file), scenario(duration_s)).expect("a file");
        let listen = format!("{HOST}:{PORT}");
        let run = [
            "run",
            &file,
            "--radio",
            "udp",
            "--listen",
            &listen,
            "--key",
            "fleet.key",
            "--json",
            "--out",
            name,
        ];
        self.net.start(Side::Host, self.path(), FLOTILLA, &run)
    }

    fn modules(&self) -> [Process; 3] {
        std::fs::write(self.path().join("module.toml"), scenario(1.0)).expect("a file");
        let host = format!("{}:{PORT}", if self.net.netem { HOST } else { MODULES });
        ["1", "2", "3"].map(|id| {
            // Should this test be killed, they end by themselves.
            let module = [
                "module",
                "--id",
                id,
                "--host",
                &host,
                "--key",
                "fleet.key",
                "--scenario",
                "module.toml",
                "--duration",
                "3600",
            ];
            self.net.start(Side::Modules, self.path(), FLOTILLA, &module)
        })
    }

    /// Says what made the network bad, and what that did.
    fn tell(mut self) {
        match self.relay.take() {
            Some(relay) => {
                let relay = relay.finish();
                println!("no netem in this kernel; the relay between real sockets did:");
                relay
                    .err
                    .iter()
                    .filter(|line| line.starts_with("relay"))
                    .for_each(|line| println!("  {line}"));
                assert_eq!(relay.code, Some(0), "{relay:?}");
            }
            None => println!("netem did:\n{}", self.net.netem_count()),
        }
    }
}

/// What the run left, which ended by itself or was interrupted. A tail that stops in mid-swing, as its process waits for the processor, may
/// be touched by those that swim on: that is told first.
fn summary(finished: &Finished, complete: bool) -> Value {
    let summary = serde_json::from_str(&finished.out.join("\n"));
    let summary: Value = summary.unwrap_or_else(|error| panic!("{error}: {finished:?}"));
    let contacts = summary["contacts"].as_array().expect("a list").len();
    println!("{contacts} contacts");
    let shortfalls = summary["shortfalls"].as_array().expect("a list").len();
    let failed = contacts > 0 || !complete || shortfalls > 0;
    assert_eq!(finished.code, Some(i32::from(failed)), "{finished:?}");
    assert_eq!(summary["complete"], complete, "{summary}");
    assert!(number(&summary["cycles"]["planned"]) >= 1, "{summary}");
    summary
}

fn number(value: &Value) -> u64 {
    value.as_u64().unwrap_or_else(|| panic!("{value} is no whole number"))
}

/// Checks the sums of each link, prints its figures, and returns how many datagrams were lost and doubled.
fn audit(summary: &Value) -> (u64, u64) {
    let (mut lost, mut doubled) = (0, 0);
    let links = summary["link"].as_array().expect("a list");
    assert_eq!(links.len(), 3);
    for link in links {
        let sum = |of: &Value, keys: &[&str]| -> u64 { keys.iter().map(|&key| number(&of[key])).sum() };
        let closed = sum(link, &["acknowledged", "late", "refused", "unanswered"]);
        let cycles = number(&link["cycles"]);
        assert!(cycles == closed || cycles == closed + 1, "one cycle may be open: {link}");
        let out = &link["to_module"];
        let told = sum(out, &["acknowledged", "late", "lost"]);
        assert!(told <= number(&out["sent"]), "{link}");
        for received in [&link["from_module"], &link["module_received"]] {
            let classes = ["accepted", "duplicate", "stale", "corrupt", "forged", "foreign"];
            assert_eq!(number(&received["received"]), sum(received, &classes), "{link}");
            assert_eq!(sum(received, &["corrupt", "forged"]), 0, "{link}");
            doubled += number(&received["duplicate"]);
        }
        lost += number(&out["lost"]);
        assert!(number(&link["acknowledged"]) >= 1, "{link}");
        println!(
            "module {}: {cycles} cycles, {} acknowledged, {} late, {} refused, {} unanswered, {} resent; answers {} ms \
             median, {} ms 99 %; {} of {} datagrams lost to it; clock ± {} µs",
            link["module"],
            link["acknowledged"],
            link["late"],
            link["refused"],
            link["unanswered"],
            link["resent"],
            link["answer"]["p50_ms"],
            link["answer"]["p99_ms"],
            out["lost"],
            out["sent"],
            link["clock_uncertainty_us"],
        );
    }
    println!(
        "{} planned, {} repeated, {} held",
        summary["cycles"]["planned"], summary["cycles"]["repeated"], summary["cycles"]["held"]
    );
    (lost, doubled)
}

/// Waits until all modules say that they are in `state`, at the same time.
fn await_all(modules: &[Process; 3], state: &str) {
    let began = Instant::now();
    let mut last = [const { String::new() }; 3];
    while !last.iter().all(|line| line.ends_with(state)) {
        assert!(began.elapsed() < PATIENCE, "never all {state}: {last:?}");
        std::thread::sleep(Duration::from_millis(5));
        for (last, module) in last.iter_mut().zip(modules) {
            *last = module.err.try_iter().last().unwrap_or_else(|| std::mem::take(last));
        }
    }
}

#[test]
fn three_modules_swim_over_a_bad_network() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let tank = Tank::new();
    let host = tank.host("run", 25.0);
    let modules = tank.modules();
    let summary = summary(&host.finish(), true);
    let (lost, doubled) = audit(&summary);
    drop(modules);
    tank.tell();
    assert!(lost > 0 && doubled > 0, "the network was not bad: {lost} lost, {doubled} doubled");
}

#[test]
fn a_killed_host_is_followed_by_another_over_a_bad_network() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let tank = Tank::new();
    let host = tank.host("first", 600.0);
    let modules = tank.modules();
    await_all(&modules, "Executing");
    drop(host); // kill -9
    let killed = Instant::now();
    await_all(&modules, "Holding");
    println!("all held {:.2} s after the host was killed", killed.elapsed().as_secs_f64());
    let host = tank.host("second", 600.0);
    await_all(&modules, "Executing");
    // Some more cycles, so that there is something to count.
    std::thread::sleep(Duration::from_secs(6));
    end(&host, "INT");
    audit(&summary(&host.finish(), false));
    drop(modules);
    tank.tell();
}

/// No test of its own: the others start it as a process.
#[test]
fn relay_process() {
    relay::main();
}
