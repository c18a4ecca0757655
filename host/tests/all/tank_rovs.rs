//! Two processes in real time: `flotilla tank` has the robots, the water and QTM, `flotilla reconfigure` has the plan and no water. Poses
//! at 100 Hz with 2 mm and 0.01 rad of noise and 30 ms of latency, a current of 0.05 m/s, a thruster that fails in the third move.

use std::net::{TcpListener, UdpSocket};

use crate::common::Process;
use crate::keys::{KEY, keygen};
use tempfile::tempdir;

/// Ports that were free a moment ago: for datagrams, and for a server.
fn ports() -> (String, String) {
    let datagrams = UdpSocket::bind("127.0.0.1:0").and_then(|socket| socket.local_addr());
    let server = TcpListener::bind("127.0.0.1:0").and_then(|socket| socket.local_addr());
    (datagrams.expect("a port").to_string(), server.expect("a port").to_string())
}

/// What a scenario comes to: executed over planned energy, and what the tank saw of every docking, mm and degrees.
fn executed(scenario: &str, dead: &str) -> (f64, Vec<[f64; 2]>) {
    let folder = tempdir().expect("a folder");
    keygen(folder.path());
    let (host, qtm) = ports();
    let at = ["--host", &host, "--listen", &qtm, "--key", KEY, "--duration", "600", "--seed", "7"];
    let like = ["--mocap", "qtm", "--latency", "0.03", "--noise", "0.002", "--attitude-noise", "0.01"];
    let wrong = ["--current", "0.05,0", "--fail-thruster", dead];
    let tank = Process::start(folder.path(), &[&["tank", scenario][..], &at, &like, &wrong].concat());
    let pose = format!("qtm:{qtm}");
    let run = ["--criterion", "energy", "--radio", "udp", "--listen", &host, "--key", KEY];
    let poses = ["--pose", &pose, "--up", "z", "--out", "out"];
    let host =
        Process::start(folder.path(), &[&["reconfigure", scenario][..], &run, &poses].concat()).finish();
    let seen: Vec<String> = tank.err.try_iter().collect();
    println!("{}\n{}", seen.join("\n"), host.out.join("\n"));
    let text = std::fs::read_to_string(folder.path().join("out/summary.json")).expect("a summary");
    let summary: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let summary = &summary["energy"];
    let failure = summary["failure"].as_str().unwrap_or_default();
    assert!(failure.is_empty() || failure.starts_with("thruster "), "{scenario}: {host:?}");
    let docked = seen.iter().filter_map(|line| {
        let (off_mm, rest) = line.split_once("takes hold, ")?.1.split_once(" mm and ")?;
        Some([off_mm.parse().ok()?, rest.split_once('°')?.0.parse().ok()?])
    });
    (summary["ratio"].as_f64().expect("a ratio"), docked.collect())
}

#[test]
#[ignore = "four minutes of real time: cargo test -p host --test all tank_rovs:: -- --ignored --nocapture"]
fn robots_dock_by_motion_capture_in_a_current_with_a_dead_thruster() {
    for (scenario, robots, dead) in [("i-to-l", 3, "3,1@80"), ("t-to-i-far", 4, "2,3@60")] {
        let (ratio, docked) = executed(scenario, dead);
        println!("{scenario}: executed over planned {ratio:.3}, docked {docked:?} mm, degrees");
        assert_eq!(docked.len(), robots, "{scenario}");
        assert!(docked.iter().all(|[mm, degrees]| *mm <= 20.0 && *degrees <= 3.0), "{scenario}: {docked:?}");
    }
}
