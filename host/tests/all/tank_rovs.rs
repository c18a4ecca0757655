//! Two processes in real time: `flotilla tank` has the robots, the water and QTM, `flotilla reconfigure` has the plan and no water. Poses
//! at 100 Hz with 2 mm and 0.01 rad of noise and 30 ms of latency, a current of 0.05 m/s that the plan is priced for, a thruster that fails
//! in the third move. What the tank saw is in its own log.

use std::collections::BTreeMap;
use std::path::Path;

use crate::common::Process;
use crate::cores::in_real_time;
use crate::interrupt::end;
use crate::keys::{KEY, keygen};
use crate::ports::port;
use crate::stalls::{Stalls, TRIES};
use host::run::reconfigure::scenario::BUILT_IN;
use runlog::flotilla;
use runlog::reader::{LogError, read};
use tempfile::tempdir;

/// A scenario that comes with the program, as a file that states the current.
fn stated(folder: &Path, name: &str) {
    let (_, text) = BUILT_IN.iter().find(|(built_in, _)| *built_in == name).expect("built in");
    let current = "current_m_s = [0.05, 0.0, 0.0]\n";
    let text = match text.split_once("[rules]\n") {
        Some((before, after)) => format!("{before}[rules]\n{current}{after}"),
        None => format!("{text}\n[rules]\n{current}"),
    };
    std::fs::write(folder.join("t.toml"), text).expect("a file");
}

/// Bodies of a laboratory: the second robot's has another name, sits beside its middle and is turned; the fleet's numbers are not those of
/// the scenario.
fn roster(folder: &Path, robots: u16) {
    let mut text = "name = \"tank\"\n".to_owned();
    for robot in 1..=robots {
        text += &format!("[[module]]\nid = {}\nkind = \"rov\"\n", 10 + robot);
        if robot == 2 {
            text += "body = \"yellow\"\nbody_offset_m = [0.1, -0.05, -0.1]\nbody_turn_rad = 1.2\n";
        }
    }
    std::fs::write(folder.join("fleet.toml"), text).expect("a file");
}

/// A thruster that gave so much is named, N. What gave less is found most of the time, and not missed (`rov::guidance::residual`).
const MISSED_N: f64 = 0.2;

/// Executes a scenario of so many robots, in which a thruster fails, and looks at what came of it: every robot docks within 2 cm and 3°, the
/// thruster is named if it is missed, and the tank's log says what the host says. What the moves before the fault draw, and what the plan
/// has for them, J.
fn executed(name: &str, robots: u16, dead: (u16, u16, f64)) -> [f64; 2] {
    let folder = tempdir().expect("a folder");
    let at_home = folder.path();
    keygen(at_home);
    stated(at_home, name);
    roster(at_home, robots);
    let [host, qtm] = [(); 2].map(|()| format!("127.0.0.1:{}", port()));
    let (of, thruster, at_s) = dead;
    let fails = format!("{of},{thruster}@{at_s}");
    let at = ["--host", &host, "--listen", &qtm, "--key", KEY, "--duration", "600", "--seed", "7"];
    let like = ["--mocap", "qtm", "--latency", "0.03", "--noise", "0.002", "--attitude-noise", "0.01"];
    let wrong = ["--current", "0.05,0", "--fail-thruster", &fails];
    let fleet = ["--roster", "fleet.toml"];
    let truth = ["--out", "truth.mcap"];
    // By the smooth law plans are slow: there is time to miss a thruster.
    let law = ["--power", "fitted"];
    let tank = Process::start(
        at_home,
        &[&["tank", "t.toml"][..], &at, &like, &wrong, &fleet, &truth, &law].concat(),
    );
    let pose = format!("qtm:{qtm}");
    let run = ["--criterion", "energy", "--radio", "udp", "--listen", &host, "--key", KEY];
    let poses = ["--pose", &pose, "--up", "z", "--out", "out"];
    let said =
        Process::start(at_home, &[&["reconfigure", "t.toml"][..], &run, &poses, &fleet, &law].concat())
            .finish();
    end(&tank, "INT");
    let seen = tank.finish().err;
    println!("{}\n{}\n{}", seen.join("\n"), said.err.join("\n"), said.out.join("\n"));
    let text = std::fs::read_to_string(at_home.join("out/summary.json")).expect("a summary");
    let summary: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let summary = &summary["energy"];
    // By robot: one that the host sees too far off lets go and docks again, and the last time counts.
    let docked: BTreeMap<u16, [f64; 2]> = seen
        .iter()
        .filter_map(|line| {
            let (robot, off) = line.split_once("robot ")?.1.split_once(" takes hold, ")?;
            let (off_mm, rest) = off.split_once(" mm and ")?;
            Some((robot.parse().ok()?, [off_mm.parse().ok()?, rest.split_once('°')?.0.parse().ok()?]))
        })
        .collect();
    assert_eq!(docked.len(), usize::from(robots), "{name}: {seen:?}");
    assert!(docked.values().all(|[mm, degrees]| *mm <= 20.0 && *degrees <= 3.0), "{name}: {docked:?}");
    let [planned_j, executed_j] =
        ["planned", "executed"].map(|of| summary[of]["total_j"].as_f64().expect("J"));
    println!(
        "{name}: {executed_j:.2} J of {planned_j:.2} J planned in the current, docked {docked:?} mm, degrees"
    );
    // The moves that were over when the thruster failed.
    let (mut before_s, mut before_j) = (0.0, 0.0);
    for own in summary["moves"].as_array().expect("moves") {
        let number = |of: &str, key: &str| own[of][key].as_f64().expect("a number");
        let end_s = before_s + number("executed", "time_s");
        if end_s < at_s {
            (before_s, before_j) = (end_s, before_j + number("planned", "total_j"));
        }
    }
    // The ledger of poses, in the log and in the summary.
    let frames = &summary["poses"]["frames"];
    assert!(
        frames["accepted"].as_u64() > Some(1000)
            && frames["received"].as_u64() >= frames["accepted"].as_u64()
    );
    // The truth: where the robots are at the end, and what they drew.
    let file = std::fs::File::open(at_home.join("truth.mcap")).expect("a log");
    let (mut last, mut drawn_j, mut sound_j, mut events) = (None::<flotilla::Robots>, 0.0, 0.0, Vec::new());
    // What the thruster gave in the second before it failed.
    let (mut load_n, mut loads) = (0.0, 0.0);
    let extent = read::<LogError>(file, |entry, _| {
        match entry.topic {
            "/truth/robots" => {
                let robots: flotilla::Robots = entry.read()?;
                let power_w: f64 = robots.robots.iter().map(|robot| robot.power_w).sum();
                if robots.t_s >= 0.0 {
                    drawn_j += 0.05 * power_w;
                    sound_j += if robots.t_s < before_s { 0.05 * power_w } else { 0.0 };
                }
                let its_robot = robots.robots.iter().find(|robot| robot.id == of);
                if let Some(robot) = its_robot.filter(|_| (at_s - 1.0..at_s).contains(&robots.t_s)) {
                    (load_n, loads) = (load_n + robot.thrusts_n[usize::from(thruster) - 1], loads + 1.0);
                }
                last = Some(robots);
            }
            "/truth/event" => events.push(entry.read::<flotilla::Event>()?.text),
            _ => {}
        }
        Ok(())
    });
    assert!(extent.expect("a log").whole);
    load_n /= loads;
    let named = format!("thruster {thruster} of robot {of} gives nothing");
    let failure = summary["failure"].as_str().unwrap_or_default();
    println!("{name}: the thruster gave {load_n:.3} N before it failed; {failure:?}");
    assert!(failure.is_empty() || failure.starts_with(&named), "{name}: {failure}");
    assert!(load_n.abs() < MISSED_N || !failure.is_empty(), "{name}: it gave {load_n:.3} N and is not named");
    let last = last.expect("a sample");
    assert!(last.robots.iter().all(|robot| robot.arrived), "{name}: {last:?}");
    let holds = |robot: &u16| events.iter().any(|text| text.contains(&format!("robot {robot} takes hold")));
    assert!(docked.keys().all(holds), "{name}: {events:?}");
    println!(
        "{name}: {drawn_j:.2} J by the tank's own log; {sound_j:.2} J of {before_j:.2} J planned before the fault, {:.3}",
        sound_j / before_j
    );
    assert!(before_j > 0.0, "{name}: no move was over");
    assert!(
        (drawn_j / executed_j - 1.0).abs() < 0.15,
        "{name}: {drawn_j} J in the tank, {executed_j} J by the host"
    );
    [sound_j, before_j]
}

/// Executes it, and draws at most 1.2 of the planned energy in the moves before the fault. Robots that a machine gives its thrusts late draw
/// more: on one that stalls it is executed again, and that is printed.
fn is_executed_at_the_planned_price(name: &str, robots: u16, dead: (u16, u16, f64)) {
    let _cores = in_real_time();
    for attempt in 1..=TRIES {
        let stalls = Stalls::watch();
        let [drawn_j, planned_j] = executed(name, robots, dead);
        if drawn_j <= 1.2 * planned_j {
            return;
        }
        let said = format!("{name}: {drawn_j} J of {planned_j} J");
        assert!(attempt < TRIES && stalls.excuse(), "{said}, and {stalls}");
        println!("{said}: {stalls}, again");
    }
}

#[test]
fn robots_dock_by_motion_capture_in_a_current_with_a_dead_thruster() {
    is_executed_at_the_planned_price("i-to-l", 3, (3, 1, 80.0));
}

#[test]
#[ignore = "two minutes of real time, beside the one above: tests/night tank"]
fn robots_with_a_tool_dock_by_motion_capture_in_a_current_with_a_dead_thruster() {
    is_executed_at_the_planned_price("t-to-i-far", 4, (1, 4, 46.0));
}
