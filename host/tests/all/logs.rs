//! Logs of runs: what replay makes of them, whole or cut, what export makes of them, and what is no log.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use host::run::closed_loop::Drive;
use host::run::experiment::{Pace, run_into};
use host::run::fleet::InProcess;
use host::run::log::Log;
use host::run::log::replay::{Replayed, replay};
use host::run::orders::Unattended;
use host::run::progress::Quiet;
use host::run::scenario::{BUILT_IN, Scenario};
use protocol::time::FleetInstant;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use runlog::flotilla;
use runlog::writer::FileWriter;
use serde_json::Value;
use tempfile::{TempDir, tempdir};

use crate::common::{PATIENCE, Process};
use crate::said::{done, refused, text};

/// Long enough for more than a chunk, with cycles in it.
const SHORT: &str = "name = \"t\"\n[structure]\nsize = \"3x1\"\n[[leg]]\nduration_s = 12\nvelocity_m_s = [0.03, 0.01]\nheading_rad = 1.5\n";

fn flotilla(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_flotilla"));
    command.args(arguments).current_dir(folder).output().expect("it runs")
}

/// The time that a run of that process tells an operator, s; nothing before it can be asked.
fn told_s(folder: &Path, process: u32) -> Option<f64> {
    let socket = folder.join(format!("sockets/flotilla/run-{process}.sock"));
    let mut stream = UnixStream::connect(socket).ok()?;
    stream.write_all(b"{\"wish\":\"status\"}\n").ok()?;
    let mut line = String::new();
    BufReader::new(stream).read_line(&mut line).ok()?;
    serde_json::from_str::<Value>(&line).ok()?["status"]["t_s"].as_f64()
}

/// A folder with a short run in `o`.
fn short() -> TempDir {
    let folder = tempdir().expect("a folder");
    fs::write(folder.path().join("t.toml"), SHORT).expect("a file");
    done(&flotilla(folder.path(), &["run", "t.toml", "--out", "o"]));
    folder
}

/// Files of a folder by name, but for the log itself.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let made =
        |path: &PathBuf| path.extension().is_some_and(|end| end == "svg") || path.ends_with("summary.json");
    let mut files: Vec<_> = entries
        .filter(made)
        .map(|path| {
            (
                path.file_name().expect("a name").to_string_lossy().into_owned(),
                fs::read(&path).expect("reads"),
            )
        })
        .collect();
    files.sort_unstable();
    files
}

#[test]
fn a_replay_leaves_what_the_run_left_byte_for_byte() {
    let folder = tempdir().expect("a folder");
    for (name, _) in BUILT_IN {
        done(&flotilla(folder.path(), &["run", name, "--loss", "0.05", "--out", name]));
        let (log, again) = (format!("{name}/log.mcap"), format!("{name}-again"));
        done(&flotilla(folder.path(), &["replay", &log, "--out", &again]));
        let (run, again) = (files(&folder.path().join(name)), files(&folder.path().join(again)));
        assert_eq!(run.len(), 5, "{name}");
        for (run, again) in run.iter().zip(&again) {
            assert!(run == again, "{name}: {} is another", run.0);
        }
    }
}

#[test]
fn a_replay_of_a_reconfiguration_does_too() {
    let folder = tempdir().expect("a folder");
    done(&flotilla(folder.path(), &["reconfigure", "i-to-l", "--out", "o"]));
    // In any order.
    let logs = ["o/log-best.mcap", "o/log-euclidean.mcap", "o/log-energy.mcap"];
    done(&flotilla(folder.path(), &[&["replay"], &logs[..], &["--out", "again"]].concat()));
    assert_eq!(files(&folder.path().join("o")), files(&folder.path().join("again")));
    let one = flotilla(folder.path(), &["replay", logs[0], "--json"]);
    let [one, all] =
        [text(&one.stdout), fs::read_to_string(folder.path().join("o/summary.json")).expect("reads")]
            .map(|text| serde_json::from_str::<Value>(&text).expect("JSON"));
    assert_eq!(one["best"], all["best"]);
}

#[test]
fn ninety_seconds_of_three_modules_take_eight_megabytes_at_most() {
    let folder = tempdir().expect("a folder");
    done(&flotilla(folder.path(), &["run", "holonomic-1", "--out", "o"]));
    let bytes = fs::metadata(folder.path().join("o/log.mcap")).expect("a log").len();
    assert!((1_000_000..=8_000_000).contains(&bytes), "{bytes} bytes");
}

/// A process that is killed leaves what it has handed to the system: the file as it is at that moment. It is looked at in twenty moments of
/// a run, by the run's own time.
#[test]
fn at_any_moment_the_file_reads_to_within_a_second_and_a_half() {
    let seed = 7;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut moments_us: Vec<u64> = (0..20).map(|_| rng.random_range(0..20_000_000)).collect();
    moments_us.sort_unstable();
    let folder = tempdir().expect("a folder");
    let path = folder.path().join("log.mcap");
    let scenario = Scenario::parse("t.toml", &SHORT.replace("= 12", "= 25")).expect("valid");
    let mut fleet = InProcess::boats(&scenario, seed).expect("valid");
    let mut copies = Vec::new();
    let mut hook = |now: FleetInstant, _: &_, _: &mut _| {
        while moments_us.first().is_some_and(|moment_us| *moment_us <= now.0) {
            moments_us.remove(0);
            copies.push((now, fs::read(&path).expect("reads")));
        }
    };
    let drive = Drive { pace: Pace::Simulated, operator: &mut Unattended, hook: &mut hook };
    let log = Log::create(&path).expect("a file");
    let result = run_into(log, &scenario, seed, &mut fleet, drive, &mut Quiet).expect("runs");
    assert_eq!((result.log_failure, copies.len()), (None, 20));
    let mut cycles = 0;
    for (now, bytes) in copies {
        if now.0 < 1_500_000 && bytes.len() < 5 {
            continue;
        }
        let length = bytes.len() as u64;
        let (replayed, extent) =
            replay(&bytes[..], length, &mut Quiet).unwrap_or_else(|error| panic!("{now:?}: {error}"));
        assert!(!extent.whole && extent.end_ns + 1_500_000_000 >= 1000 * now.0, "{now:?}: {extent:?}");
        let Replayed::Boats(outcome) = replayed else { panic!("a run of Modboats") };
        assert!(!outcome.ended && !outcome.summary.complete);
        let failure = outcome.summary.failure.expect("it is cut");
        assert!(failure.ends_with("the log ends there"), "{failure}");
        // What is there is what the whole run has.
        let known = outcome.record.poses.len();
        assert_eq!(outcome.record.poses[..], result.record.poses[..known]);
        assert!(outcome.record.cycles.len() >= cycles);
        cycles = outcome.record.cycles.len();
        for (cycle, whole) in outcome.record.cycles.iter().zip(&result.record.cycles) {
            assert_eq!((cycle.number, &cycle.turns), (whole.number, &whole.turns));
        }
    }
    assert!(cycles > 5, "{cycles} cycles");
}

/// Killed for good: nothing in the process runs any more. Six runs in real time, or as many as `FLOTILLA_KILLS` says, each killed at another
/// moment of its own time, which it tells itself right before: its log reads to within a second and a half of that.
#[test]
fn runs_that_are_killed_leave_their_logs() {
    let kills = std::env::var("FLOTILLA_KILLS").map_or(6, |kills| kills.parse().expect("a number"));
    let seed = 11;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut moments_s: Vec<f64> = (0..kills).map(|_| rng.random_range(0.0..4.0)).collect();
    moments_s.sort_unstable_by(f64::total_cmp);
    let scenario = SHORT.replace("= 12", "= 600");
    let runs: Vec<(TempDir, Process)> = (0..kills)
        .map(|_| {
            let folder = tempdir().expect("a folder");
            fs::write(folder.path().join("t.toml"), &scenario).expect("a file");
            fs::create_dir(folder.path().join("sockets")).expect("a folder");
            let run = Process::reachable(folder.path(), &["run", "t.toml", "--realtime", "--out", "o"]);
            (folder, run)
        })
        .collect();
    let mut killed_s = Vec::new();
    let mut folders = Vec::new();
    for ((folder, mut run), moment_s) in runs.into_iter().zip(moments_s) {
        let began = std::time::Instant::now();
        let at_s = loop {
            assert!(began.elapsed() < PATIENCE, "no run that tells its time");
            match told_s(folder.path(), run.child.id()) {
                Some(at_s) if at_s >= moment_s => break at_s,
                _ => std::thread::sleep(std::time::Duration::from_millis(20)),
            }
        };
        run.child.kill().expect("SIGKILL");
        assert_eq!(run.finish().code, None);
        assert!(!folder.path().join("o/summary.json").exists());
        killed_s.push(at_s);
        folders.push(folder);
    }
    for (folder, at_s) in folders.iter().zip(killed_s) {
        let bytes = fs::read(folder.path().join("o/log.mcap")).expect("a log");
        let (replayed, extent) = replay(&bytes[..], bytes.len() as u64, &mut Quiet)
            .unwrap_or_else(|error| panic!("seed {seed}, killed at {at_s} s: {error}"));
        let Replayed::Boats(outcome) = replayed else { panic!("a run of Modboats") };
        let end_s = outcome.record.poses.last().map_or(0.0, |pose| pose.t_s);
        println!("killed at {at_s:.3} s or later, the log reads to {end_s:.3} s");
        assert!(!extent.whole && !outcome.ended);
        assert!(end_s + 1.5 >= at_s, "seed {seed}, killed at {at_s} s: the log ends at {end_s} s");
    }
    let folder = folders.last().expect("a run");
    let replayed = flotilla(folder.path(), &["replay", "o/log.mcap", "--out", "again"]);
    assert_eq!(replayed.status.code(), Some(1));
    let said = text(&replayed.stderr);
    assert!(
        said.starts_with("flotilla: o/log.mcap: cut after ")
            && said.contains("the end of the run is missing"),
        "{said}"
    );
    assert_eq!(files(&folder.path().join("again")).len(), 5);
}

#[test]
fn a_log_that_is_cut_is_read_up_to_there_and_says_so() {
    let folder = short();
    let whole = fs::read(folder.path().join("o/log.mcap")).expect("a log");
    for share in [0.2, 0.5, 0.9, 0.999] {
        let length = (share * whole.len() as f64) as usize;
        fs::write(folder.path().join("cut.mcap"), &whole[..length]).expect("a file");
        for arguments in [&["replay", "cut.mcap"][..], &["export", "cut.mcap", "--csv", "tables"]] {
            let output = flotilla(folder.path(), arguments);
            let said = text(&output.stderr);
            // The index alone is missing at last: the run's end is told.
            if share > 0.95 && arguments[0] == "replay" {
                assert_eq!(output.status.code(), Some(0), "{said}");
                continue;
            }
            assert_eq!(output.status.code(), Some(1), "{said}");
            assert!(said.starts_with("flotilla: cut.mcap: cut after "), "{said}");
            assert!(!output.stdout.is_empty());
        }
    }
    // Too little to say what was run.
    fs::write(folder.path().join("cut.mcap"), &whole[..50]).expect("a file");
    assert_eq!(
        refused(&flotilla(folder.path(), &["replay", "cut.mcap"])),
        "cut.mcap: cut before it says what was run"
    );
}

#[test]
fn what_is_no_log_is_named_in_one_line() {
    let folder = short();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("empty.mcap"), b"").expect("a file");
    let mut damaged = fs::read(at("o/log.mcap")).expect("a log");
    let middle = damaged.len() / 2;
    damaged[middle] ^= 4;
    fs::write(at("damaged.mcap"), damaged).expect("a file");
    let written = |name: &str, write: &dyn Fn(&mut FileWriter)| {
        let mut writer = FileWriter::create(&at(name)).expect("a file");
        write(&mut writer);
        writer.finish().expect("writes");
    };
    written("foreign.mcap", &|writer| {
        let topic = writer.topic("/odom").expect("writes");
        writer.write(topic, 0, &runlog::ros::Odometry::default()).expect("writes");
    });
    let head = |writer: &mut FileWriter, head: flotilla::Scenario| {
        let topic = writer.topic("/scenario").expect("writes");
        writer.write(topic, 0, &head).expect("writes");
    };
    let boats = || flotilla::Scenario {
        format: flotilla::FORMAT,
        fleet: "modboats".to_owned(),
        modules: vec![1, 2, 3],
        document: SHORT.to_owned(),
        ..flotilla::Scenario::default()
    };
    let format = flotilla::FORMAT + 1;
    written("newer.mcap", &|writer| {
        head(writer, flotilla::Scenario { format, program: "flotilla 9.0.0".to_owned(), ..boats() });
    });
    written("other.mcap", &|writer| {
        head(writer, flotilla::Scenario { fleet: "kites".to_owned(), ..boats() });
    });
    written("few.mcap", &|writer| {
        head(writer, flotilla::Scenario { modules: vec![1], ..boats() });
    });
    written("tails.mcap", &|writer| {
        head(writer, boats());
        let topic = writer.topic("/tails").expect("writes");
        let tails = runlog::ros::JointState { position: vec![0.0; 2], ..runlog::ros::JointState::default() };
        writer.write(topic, 0, &tails).expect("writes");
    });
    for (log, expected) in [
        ("none.mcap", "none.mcap: No such file".to_owned()),
        ("empty.mcap", "empty.mcap: not a log: it does not begin as MCAP files do".to_owned()),
        ("t.toml", "t.toml: not a log: it does not begin as MCAP files do".to_owned()),
        ("damaged.mcap", "damaged.mcap: damaged after ".to_owned()),
        ("foreign.mcap", "foreign.mcap: a log, but not of Flotilla".to_owned()),
        ("newer.mcap", format!("newer.mcap: flotilla 9.0.0 wrote it, in format {format}: this is flotilla ")),
        ("other.mcap", "other.mcap: /scenario: a fleet of \"kites\"".to_owned()),
        ("few.mcap", "few.mcap: /scenario: 1 numbers of 3 modules".to_owned()),
        ("tails.mcap", "tails.mcap: tails of 2 modules, in a log of 3".to_owned()),
    ] {
        let said = refused(&flotilla(folder.path(), &["replay", log]));
        assert!(said.starts_with(&expected), "{said}\nexpected {expected}");
    }
    for log in ["none.mcap", "empty.mcap", "t.toml"] {
        refused(&flotilla(folder.path(), &["export", log, "--csv", "tables"]));
    }
    let two = refused(&flotilla(folder.path(), &["replay", "o/log.mcap", "o/log.mcap"]));
    assert!(two.starts_with("several logs make one summary only where"), "{two}");
}

/// The tables say what the summary says: modules, cycles, the length of the run.
#[test]
fn tables_agree_with_the_summary() {
    let folder = short();
    let said = done(&flotilla(folder.path(), &["export", "o/log.mcap", "--csv", "tables"]));
    let table = |name: &str| {
        assert!(said.contains(&format!("  tables/{name}.csv")), "{said}");
        let text = fs::read_to_string(folder.path().join(format!("tables/{name}.csv"))).expect("a table");
        let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        let header = lines.next().expect("a header");
        (header, lines.collect::<Vec<_>>())
    };
    let summary = fs::read_to_string(folder.path().join("o/summary.json")).expect("a summary");
    let summary: Value = serde_json::from_str(&summary).expect("JSON");
    let column = |header: &[String], name: &str| {
        header.iter().position(|known| known == name).unwrap_or_else(|| panic!("no {name} in {header:?}"))
    };
    let (header, rows) = table("links");
    let (index, acknowledged) = (column(&header, "index"), column(&header, "links_acknowledged"));
    for (place, link) in summary["link"].as_array().expect("links").iter().enumerate() {
        let last = rows.iter().rev().find(|row| row[index] == place.to_string()).expect("a row");
        assert_eq!(last[acknowledged], link["acknowledged"].to_string());
    }
    let (header, rows) = table("truth_state");
    assert_eq!(
        header,
        [
            "t_s",
            "stamp_s",
            "position_m_0",
            "position_m_1",
            "heading_rad",
            "velocity_m_s_0",
            "velocity_m_s_1",
            "yaw_rate_rad_s"
        ]
    );
    let time_s = |row: &Vec<String>| row[0].parse::<f64>().expect("a number");
    let [first, .., last] = &rows[..] else { panic!("{} rows", rows.len()) };
    // The first is of the first tick after time zero.
    assert!((time_s(last) - time_s(first) - summary["duration_s"].as_f64().expect("s")).abs() < 1.1e-3);
    let (header, rows) = table("tails");
    assert_eq!(header[5..], ["position_rad", "velocity_rad_s", "effort_nm"]);
    assert_eq!(rows.len() % 3, 0);
    let (header, rows) = table("decision");
    let (number, module) = (column(&header, "number"), column(&header, "index"));
    let decisions = rows.iter().filter(|row| row[module] == "0").count();
    assert!(decisions as u64 >= summary["cycles"]["total"].as_u64().expect("a count"), "{number}");
}
