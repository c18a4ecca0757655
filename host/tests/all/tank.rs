//! `flotilla tank` and `flotilla run` as two processes on real UDP, poses by each protocol, in real time.
//!
//! All pairs run at once. A machine that stalls may make a fleet hold; a verdict on such a run is taken again, and that is printed.

use std::path::{Path, PathBuf};
use std::sync::mpsc;

use crate::common::{Finished, Process};
use crate::cores::in_real_time;
use crate::interrupt::send;
use crate::keys::{KEY, keygen};
use crate::ports::port;
use crate::stalls::{Stalls, TRIES};
use serde_json::Value;
use tempfile::tempdir;

use self::identified::Experiment;

mod identified;

/// A scenario in a tank, and what each is told.
#[derive(Clone)]
struct Pair {
    name: String,
    scenario: String,
    protocol: &'static str,
    tank: Vec<String>,
    run: Vec<String>,
}

fn words(text: &str) -> Vec<String> {
    text.split_whitespace().map(str::to_owned).collect()
}

/// What came of a pair.
#[derive(Debug)]
struct Swim {
    summary: Value,
    run: Finished,
    tank: Finished,
    /// Where the run's files are.
    out: PathBuf,
}

fn swim(folder: &Path, pair: &Pair) -> Swim {
    let (host, mocap) = (format!("127.0.0.1:{}", port()), format!("127.0.0.1:{}", port()));
    let pose = format!("{}:{mocap}", pair.protocol);
    let out = format!("out-{}", pair.name);
    let mut tank = vec!["tank", &pair.scenario, "--key", KEY, "--host", &host, "--mocap", pair.protocol];
    tank.extend(["--listen", &mocap, "--duration", "600"]);
    tank.extend(pair.tank.iter().map(String::as_str));
    let tank = Process::start(folder, &tank);
    let mut run =
        vec!["run", &pair.scenario, "--radio", "udp", "--key", KEY, "--listen", &host, "--pose", &pose];
    run.extend(["--json", "--out", &out]);
    run.extend(pair.run.iter().map(String::as_str));
    let run = Process::start(folder, &run).finish();
    // As an operator ends it.
    send(&tank, "INT");
    let tank = tank.finish();
    let text = run.out.join("\n");
    let summary = serde_json::from_str(&text)
        .unwrap_or_else(|error| panic!("{}: {error}: {run:?} {tank:?}", pair.name));
    Swim { summary, run, tank, out: folder.join(out) }
}

/// Swims all pairs at once and judges each; those that fail while the machine stalls are swum again.
fn all(pairs: &[Pair], judge: impl Fn(&Pair, &Swim) -> Result<String, String>) {
    let _cores = in_real_time();
    let folder = tempdir().expect("a folder");
    keygen(folder.path());
    let mut left: Vec<Pair> = pairs.to_vec();
    for attempt in 1..=TRIES {
        let stalls = Stalls::watch();
        let (sender, results) = mpsc::channel();
        std::thread::scope(|scope| {
            for pair in &left {
                let (sender, folder) = (sender.clone(), folder.path());
                scope.spawn(move || sender.send((pair.clone(), swim(folder, pair))).expect("a listener"));
            }
        });
        drop(sender);
        let mut again = Vec::new();
        for (pair, swim) in results {
            match judge(&pair, &swim) {
                Ok(said) => println!("{:>24}  {said}", pair.name),
                Err(said) if attempt < TRIES && stalls.excuse() => {
                    println!("{:>24}  {said}: {stalls}, again", pair.name);
                    again.push(pair);
                }
                Err(said) => {
                    panic!("{}: {said}\n{:#}\n{:?}\n{:?}", pair.name, swim.summary, swim.run, swim.tank)
                }
            }
        }
        if again.is_empty() {
            return;
        }
        left = again;
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

/// A fleet that held for a gap of its host begins again within a cycle, s.
const BEGINS_AGAIN_S: f64 = 1.5;

/// For how long a fleet may have held because the machine was late, s: modules did not know the fleet time, or the host did not run.
fn machine_s(summary: &Value) -> f64 {
    let list = |key: &str| summary[key].as_array().cloned().unwrap_or_default();
    let unsure = list("absences").into_iter();
    let unsure = unsure.filter(|absence| absence["reason"] == "it does not know the fleet time");
    let unsure_s: f64 = unsure.map(|absence| number(&absence["time_s"])).sum();
    let gaps_s = list("gaps").into_iter().map(|gap| number(&gap["length_s"]) + BEGINS_AGAIN_S);
    unsure_s + gaps_s.sum::<f64>()
}

fn no_contact(tank: &Finished) -> Result<(), String> {
    let told = tank.code == Some(0) && tank.err.iter().any(|line| line.contains("no contacts"));
    if told { Ok(()) } else { Err(format!("the tank says {:?}, {:?}", tank.code, tank.err)) }
}

#[test]
fn the_experiments_swim_by_poses_of_each_protocol() {
    let weather = "--latency 0.02 --jitter 0.01 --loss 0.02";
    let pair = |experiment: u32, protocol, tank: &str, run: &str| Pair {
        name: format!("holonomic-{experiment}-{protocol}{}", if run.contains('y') { "-y-mm" } else { "" }),
        scenario: format!("holonomic-{experiment}"),
        protocol,
        tank: words(&format!("{weather} {tank}")),
        run: words(run),
    };
    let mut pairs = Vec::new();
    for protocol in ["natnet", "qtm", "vrpn"] {
        pairs.extend((1..=4).map(|experiment| pair(experiment, protocol, "--up z", "--up z")));
        pairs.push(pair(1, protocol, "--up y --unit mm", "--up y --unit mm"));
    }
    let experiment = Experiment::new(tempdir().expect("a folder"));
    pairs.push(Pair {
        name: "identify-natnet".to_owned(),
        scenario: experiment.file(),
        protocol: "natnet",
        tank: words(&format!("{weather} --up z")),
        run: words("--up z"),
    });
    all(&pairs, |pair, swim| {
        let Swim { summary, run, tank, out } = swim;
        no_contact(tank)?;
        if pair.scenario == experiment.file() {
            return experiment.compare(&out.join("log.mcap"));
        }
        let legs = summary["legs"].as_array().ok_or("no legs")?;
        let errors: Vec<f64> = legs.iter().map(|leg| number(&leg["velocity_error"])).collect();
        let headings: Vec<f64> = legs.iter().map(|leg| number(&leg["heading_rms_rad"])).collect();
        let said = format!("velocity error {errors:.4?}, heading RMS {headings:.4?} rad");
        let good = errors.iter().all(|error| *error <= 0.05) && headings.iter().all(|rms| *rms <= 0.15);
        if good && run.code == Some(0) { Ok(said) } else { Err(format!("{said}, exit {:?}", run.code)) }
    });
}

#[test]
fn each_fault_of_the_poses_ends_in_a_hold_with_its_name_or_in_a_swim() {
    let scenario = "name = \"t\"\n[structure]\nsize = \"3x1\"\n[[leg]]\nduration_s = 60.0\nvelocity_m_s = [0.02, 0.0]\n\
                    heading_rad = 1.5707963\n[start]\nposition_m = [-0.6, 0.0]\n[bounds]\n\
                    edge_m = [[-1.5, -1.0], [1.5, -1.0], [1.5, 1.0], [-1.5, 1.0]]\n[pose]\nup = \"z\"\n";
    let folder = tempdir().expect("a folder");
    let file = folder.path().join("t.toml");
    std::fs::write(&file, scenario).expect("written");
    // Each fault, and the name of the hold that it ends in, if it does.
    let faults = [
        ("dead@15+10", Some("no answer")),
        ("frozen@15+10", Some("frozen")),
        ("blind@15+10", Some("no frames come")),
        ("swap:1,3@15+10", Some("each other's label")),
        ("lost:2@15", None),
        ("away:2@15", Some("module 2 is not in its place")),
        ("nan:2@15", None),
        ("clock:3600@15", None),
        ("slow@15", None),
        ("doubled@15", None),
    ];
    let pairs = faults.map(|(fault, _)| Pair {
        name: fault.to_owned(),
        scenario: file.display().to_string(),
        protocol: "natnet",
        tank: words(&format!("--latency 0.02 --jitter 0.01 --fault {fault} --out truth-{fault}.mcap")),
        run: Vec::new(),
    });
    all(&pairs, |pair, swim| {
        let Swim { summary, run, tank, .. } = swim;
        no_contact(tank)?;
        let (_, name) = faults.iter().find(|(fault, _)| *fault == pair.name).ok_or("no such fault")?;
        let troubles = summary["poses"]["troubles"].as_array().ok_or("no troubles")?;
        let held_s = number(&summary["legs"][0]["held_s"]);
        let said = format!("held for {held_s:.1} s, {troubles:?}");
        let named = name.is_none_or(|name| {
            troubles
                .iter()
                .any(|trouble| trouble["reason"].as_str().is_some_and(|reason| reason.contains(name)))
        });
        // Ten seconds without poses, less the age that is allowed and a cycle. A run that has held for a quarter of a leg says so.
        let (least_s, most_s, code) = match pair.name.as_str() {
            "away:2@15" => (40.0, 46.0, 1),
            _ if name.is_some() => (6.0, 10.5, 0),
            _ => (0.0, 0.5, 0),
        };
        // What a machine is late by is no fault of the poses.
        let most_s = most_s + machine_s(summary);
        let good = named && (least_s..=most_s).contains(&held_s) && run.code == Some(code);
        if good { Ok(said) } else { Err(format!("{said}, exit {:?}", run.code)) }
    });
}

/// What cannot be is said in one line, before anything is begun.
#[test]
fn bad_input_is_one_clear_line() {
    let folder = tempdir().expect("a folder");
    keygen(folder.path());
    let two = "[[module]]\nid = 1\nbody = \"a\"\n[[module]]\nid = 2\nbody = \"a\"\n[[module]]\nid = 3\n";
    std::fs::write(folder.path().join("two.toml"), two).expect("written");
    let run = "run holonomic-1 --radio udp --listen 127.0.0.1:0 --key fleet.key";
    for (arguments, says) in [
        (format!("{run} --pose natnet:127.0.0.1"), "[pose] up: say which axis of the laboratory points up"),
        (
            format!("{run} --pose optitrack:127.0.0.1 --up z"),
            "no pose source \"optitrack\"; there are natnet:",
        ),
        (format!("{run} --pose natnet: --up z"), "the host is missing"),
        (
            format!("{run} --pose qtm:no-such-host.invalid --up z"),
            "the host \"no-such-host.invalid\" is not found",
        ),
        (
            format!("{run} --pose qtm:127.0.0.1 --up z --roster two.toml"),
            "two.toml:6: [[module]] 2: body = \"a\"",
        ),
        (format!("{run} --pose log:no-such.mcap"), "no-such.mcap: No such file"),
        (format!("{run} --pose log:two.toml"), "two.toml: not a log"),
        ("run holonomic-1 --pose natnet:127.0.0.1 --up z".to_owned(), "--pose needs --radio udp"),
        ("tank holonomic-1 --key fleet.key --fault lost:4@2".to_owned(), "--fault: body 4: there are only 3"),
        ("tank holonomic-1 --key fleet.key --fault deaf@2".to_owned(), "no fault \"deaf\""),
    ] {
        let arguments: Vec<&str> = arguments.split_whitespace().collect();
        let finished = Process::start(folder.path(), &arguments).finish();
        let said = finished.err.join("\n");
        assert_eq!(finished.code, Some(2), "{arguments:?}: {finished:?}");
        assert!(said.contains(says), "{arguments:?}: {said}");
    }
}

/// A body that the roster names and the server does not send is named before anything swims.
#[test]
fn a_body_that_is_never_seen_is_named() {
    let folder = tempdir().expect("a folder");
    keygen(folder.path());
    let roster = "[[module]]\nid = 1\n[[module]]\nid = 2\nbody = \"blue boat\"\n[[module]]\nid = 3\n";
    std::fs::write(folder.path().join("fleet.toml"), roster).expect("written");
    let pair = Pair {
        name: "unseen".to_owned(),
        scenario: "holonomic-1".to_owned(),
        protocol: "natnet",
        tank: Vec::new(),
        run: words("--up z --roster fleet.toml"),
    };
    let (host, mocap) = (format!("127.0.0.1:{}", port()), format!("127.0.0.1:{}", port()));
    let tank =
        ["tank", &pair.scenario, "--key", KEY, "--host", &host, "--listen", &mocap, "--duration", "600"];
    let tank = Process::start(folder.path(), &tank);
    let probe =
        ["probe", &format!("natnet:{mocap}"), "--up", "z", "--roster", "fleet.toml", "--duration", "2"];
    let probed = Process::start(folder.path(), &probe).finish();
    assert_eq!(probed.code, Some(1), "{probed:?}");
    assert!(probed.err.join("\n").contains("never seen: module 2 (body \"blue boat\")"), "{probed:?}");
    let pose = format!("natnet:{mocap}");
    let mut run =
        vec!["run", &pair.scenario, "--radio", "udp", "--key", KEY, "--listen", &host, "--pose", &pose];
    run.extend(pair.run.iter().map(String::as_str));
    let finished = Process::start(folder.path(), &run).finish();
    drop(tank);
    assert_eq!(finished.code, Some(1), "{finished:?}");
    let said = finished.err.join("\n");
    assert!(said.contains("body \"blue boat\" of module 2 is never seen; the server sends"), "{said}");
}
