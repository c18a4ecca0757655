//! `flotilla run` as a user meets it: what is printed, what is left on disk, how it ends.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::common::{PATIENCE, Process};
use crate::interrupt::end;
use crate::keys::{KEY, keygen};
use crate::terminal;
use serde_json::Value;
use tempfile::{TempDir, tempdir};

const PICTURES: [&str; 4] = ["trajectory.svg", "wrench.svg", "tails.svg", "phase-space.svg"];

fn scenario(duration_s: f64, more: &str) -> TempDir {
    let folder = tempdir().expect("a folder");
    let text = format!(
        "name = \"t\"\n[structure]\nsize = \"3x1\"\n[[leg]]\nduration_s = {duration_s}\n\
         velocity_m_s = [0.04, 0]\nheading_rad = 1.5\n{more}"
    );
    std::fs::write(folder.path().join("t.toml"), text).expect("a file");
    folder
}

fn read(folder: &Path) -> Value {
    let text = std::fs::read_to_string(folder.join("summary.json")).expect("a summary");
    serde_json::from_str(&text).expect("JSON")
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut names: Vec<_> =
        entries.map(|e| e.expect("an entry").file_name().into_string().expect("a name")).collect();
    names.sort_unstable();
    names
}

#[test]
fn the_first_command_shows_experiment_one_and_leaves_its_pictures() {
    let folder = tempdir().expect("a folder");
    let finished = Process::start(folder.path(), &["run"]).finish();
    assert_eq!(finished.code, Some(0), "{finished:?}");
    assert!(finished.err.is_empty(), "quiet in a pipe: {finished:?}");
    let text = finished.out.join("\n");
    for part in [
        "holonomic-1: 3 modules, 90 s, seed 1",
        "demanded m/s",
        "contacts   none",
        " 0 refused, 0 late, 0 unanswered",
        " 0 corrupt, 0 forged, 0 foreign",
    ] {
        assert!(text.contains(part), "{text}\ndoes not say {part:?}");
    }
    assert!(!text.contains('\u{1b}'), "no escape codes in a pipe: {text:?}");
    let results = folder.path().join("runs/holonomic-1");
    let mut expected = [&PICTURES[..], &["log.mcap", "summary.json"]].concat();
    expected.sort_unstable();
    assert_eq!(names(&results), expected);
    for name in expected {
        assert!(text.contains(&format!("  runs/holonomic-1/{name}")), "{text}");
    }
    for name in PICTURES {
        let picture = std::fs::read_to_string(results.join(name)).expect("a picture");
        assert!(picture.starts_with("<svg") && picture.trim_end().ends_with("</svg>"), "{name}");
    }
    let summary = read(&results);
    assert_eq!((&summary["complete"], &summary["modules"]), (&Value::Bool(true), &Value::from(3)));
    // The README shows what the program prints.
    let readme = include_str!("../../../README.md");
    let block =
        readme.split_once("```text\n").and_then(|(_, rest)| rest.split_once("```")).expect("a block").0;
    assert!(block.lines().count() >= 6, "{block}");
    for line in block.lines() {
        assert!(text.lines().any(|printed| printed == line), "README: {line:?} is not in\n{text}");
    }
    // The table shows what the summary says.
    let mean = summary["legs"][0]["mean_m_s"][0].as_f64().expect("a number");
    assert!(text.contains(&format!("{mean:.4}")), "{mean} in {text}");
}

#[test]
fn no_run_overwrites_another() {
    let folder = scenario(2.0, "");
    let run = |seed: &str| Process::start(folder.path(), &["run", "t.toml", "--seed", seed]);
    assert_eq!(run("1").finish().code, Some(0));
    let first = std::fs::read(folder.path().join("runs/t/summary.json")).expect("a summary");
    let second = run("2").finish();
    assert!(second.out.join("\n").contains("runs/t-2/summary.json"), "{second:?}");
    assert!(
        first == std::fs::read(folder.path().join("runs/t/summary.json")).expect("a summary"),
        "overwritten"
    );
    assert_eq!(read(&folder.path().join("runs/t-2"))["seed"], 2);
    // Not even those that begin together.
    let together = ["3", "4", "5", "6"].map(run).map(Process::finish);
    assert!(together.iter().all(|finished| finished.code == Some(0)), "{together:?}");
    assert_eq!(names(&folder.path().join("runs")), ["t", "t-2", "t-3", "t-4", "t-5", "t-6"]);
    let mut seeds: Vec<_> = (3..=6)
        .map(|n| read(&folder.path().join(format!("runs/t-{n}")))["seed"].as_u64().expect("a seed"))
        .collect();
    seeds.sort_unstable();
    assert_eq!(seeds, [3, 4, 5, 6]);
}

/// A folder named like a scenario, such as that of an earlier run, does not hide the scenario.
#[test]
fn a_folder_does_not_hide_a_built_in_scenario() {
    let folder = tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("holonomic-2")).expect("a folder");
    let finished = Process::start(folder.path(), &["run", "holonomic-2", "--out", "holonomic-2"]).finish();
    assert_eq!(finished.code, Some(0), "{finished:?}");
    assert_eq!(read(&folder.path().join("holonomic-2"))["scenario"], "holonomic-2");
}

#[test]
fn json_is_the_summary() {
    let folder = scenario(4.0, "");
    let run = |out: &str| {
        let arguments = ["run", "t.toml", "--json", "--seed", "7", "--loss", "0.1", "--out", out];
        let finished = Process::start(folder.path(), &arguments).finish();
        assert_eq!((finished.code, finished.err.len()), (Some(0), 0), "{finished:?}");
        let printed: Value = serde_json::from_str(&finished.out.join("\n")).expect("JSON and nothing else");
        assert_eq!(printed, read(&folder.path().join(out)));
        printed
    };
    let (mut one, mut two) = (run("deep/er/one"), run("two"));
    assert_eq!((&one["seed"], &one["scenario"]), (&Value::from(7), &Value::from("t")));
    assert!(one["faults"]["lost"].as_u64() > Some(0), "{one}");
    // The same seed is the same run, but for the clock on the wall.
    for summary in [&mut one, &mut two] {
        summary["wall_s"] = Value::Null;
        summary["cycles"]["solve_us_median"] = Value::Null;
        summary["cycles"]["solve_us_max"] = Value::Null;
    }
    assert_eq!(one, two);
}

/// A motor too weak for its waveform, planned without any margin, in modules that take half a radian for no fault: the tails lag and meet.
#[test]
fn tails_that_touch_fail_the_run() {
    let weak = "[control]\nkind = \"paper\"\n[motor]\nacceleration_max_rad_s2 = 60\n[modboat]\ntracking_error_rad = 0.5\n\
                [planner]\nkind = \"potential-field\"\nmargin_rad = 0\ntransition_margin_rad = 0\n";
    let folder = scenario(40.0, weak);
    let path = folder.path().join("t.toml");
    let text = std::fs::read_to_string(&path).expect("a scenario").replace("3x1", "3x3");
    std::fs::write(&path, text).expect("a scenario");
    let finished = Process::start(folder.path(), &["run", "t.toml", "--out", "o"]).finish();
    assert_eq!((finished.code, finished.err.len()), (Some(1), 1), "{finished:?}");
    let summary = read(&folder.path().join("o"));
    let contacts = summary["contacts"].as_array().expect("a list");
    let first = &contacts[0];
    let said = format!(
        "flotilla: {} tail contacts, the first between modules {} and {} at {:.2} s: the structure would have come apart",
        contacts.len(),
        first["modules"][0],
        first["modules"][1],
        first["t_s"].as_f64().expect("a time")
    );
    assert_eq!(finished.err, [said]);
    assert!(finished.out.join("\n").contains(&format!("contacts   {}: ", contacts.len())), "{finished:?}");
    let modules = [0, 1].map(|side| first["modules"][side].as_u64().expect("an id"));
    // Three in a row, row after row.
    let [one, other] = modules.map(|id| [(id - 1) % 3, (id - 1) / 3]);
    assert_eq!(one[0].abs_diff(other[0]) + one[1].abs_diff(other[1]), 1, "neighbours: {modules:?}");
    assert!(first["overlap_m"].as_f64().expect("m") > 0.0);
}

/// Cycles longer than the firmware takes: all are refused, no module moves. That is no success.
#[test]
fn a_run_in_which_every_cycle_was_refused_fails() {
    let folder = scenario(4.0, "[modboat]\nperiod_s = 1000\n");
    let finished = Process::start(folder.path(), &["run", "t.toml", "--out", "o"]).finish();
    assert_eq!((finished.code, finished.err.len()), (Some(1), 1), "{finished:?}");
    assert!(finished.err[0].starts_with("flotilla: the modules took none of "), "{finished:?}");
    let summary = read(&folder.path().join("o"));
    let links = summary["link"].as_array().expect("a list");
    let sum = |key: &str| links.iter().map(|link| link[key].as_u64().expect(key)).sum::<u64>();
    // All but the turns before the first swim, which are of the usual length.
    let said = format!(" none of {} cycles and refused {}: ", sum("cycles") - 3, sum("refused"));
    assert!(sum("refused") >= 3 && finished.err[0].contains(&said), "{finished:?}");
}

#[test]
fn control_c_leaves_what_was_measured() {
    let folder = scenario(600.0, "");
    let run = Process::start(folder.path(), &["run", "t.toml", "--realtime", "--out", "o"]);
    // However far it comes by then.
    std::thread::sleep(Duration::from_secs(3));
    end(&run, "INT");
    let finished = run.finish();
    assert_eq!((finished.code, finished.err.len()), (Some(1), 1), "{finished:?}");
    assert!(finished.err[0].starts_with("flotilla: ended early, after "), "{finished:?}");
    assert!(finished.err[0].ends_with(" of 600.0 s: interrupted"), "{finished:?}");
    let summary = read(&folder.path().join("o"));
    assert_eq!((&summary["complete"], &summary["contacts"]), (&Value::Bool(false), &Value::Array(vec![])));
    assert!(PICTURES.iter().all(|picture| folder.path().join("o").join(picture).is_file()));
}

/// What a service manager sends, and what a terminal that goes away sends.
#[test]
fn requests_to_end_leave_what_was_measured() {
    for signal in ["TERM", "HUP"] {
        let folder = scenario(600.0, "");
        let run = terminal::start(folder.path(), &["run", "t.toml", "--realtime", "--out", "o"]);
        end(&run, signal);
        let finished = run.finish();
        assert_eq!((finished.code, finished.err.len()), (Some(1), 1), "{signal}: {finished:?}");
        assert!(finished.err[0].ends_with(" of 600.0 s: interrupted"), "{signal}: {finished:?}");
        assert_eq!(read(&folder.path().join("o"))["complete"], false);
        assert!(PICTURES.iter().all(|picture| folder.path().join("o").join(picture).is_file()), "{signal}");
    }
}

/// As `nohup` starts it: a terminal that goes away ends nothing, and the Ctrl-C after it is the first.
#[cfg(target_os = "linux")]
#[test]
fn a_run_that_ignores_its_terminal_goes_on() {
    let folder = scenario(600.0, "");
    let mut command = Command::new("sh");
    let program = env!("CARGO_BIN_EXE_flotilla");
    command.args(["-c", &format!("trap '' HUP; exec {program} run t.toml --realtime --out o")]);
    command.current_dir(folder.path());
    let run = Process::spawn(command);
    end(&run, "HUP");
    end(&run, "INT");
    let finished = run.finish();
    assert_eq!((finished.code, finished.err.len()), (Some(1), 1), "{finished:?}");
    assert!(finished.err[0].ends_with(" of 600.0 s: interrupted"), "{finished:?}");
}

/// A device that is always full takes the place of a file.
#[cfg(target_os = "linux")]
#[test]
fn a_file_that_cannot_be_written_is_named_and_the_others_are_kept() {
    for full in ["summary.json", "wrench.svg", "log.mcap"] {
        let folder = scenario(4.0, "");
        let results = folder.path().join("o");
        std::fs::create_dir(&results).expect("a folder");
        std::os::unix::fs::symlink("/dev/full", results.join(full)).expect("a link");
        let finished = Process::start(folder.path(), &["run", "t.toml", "--json", "--out", "o"]).finish();
        assert_eq!((finished.code, finished.err.len()), (Some(1), 1), "{full}: {finished:?}");
        assert!(
            finished.err[0].starts_with(&format!("flotilla: o/{full}: cannot write: No space")),
            "{finished:?}"
        );
        let printed: Value = serde_json::from_str(&finished.out.join("\n")).expect("all of the figures");
        assert_eq!(printed["failure"], Value::Null, "the run did what it was to do");
        for name in PICTURES.iter().chain(&["summary.json", "log.mcap"]).filter(|name| **name != full) {
            assert!(std::fs::metadata(results.join(name)).expect("it was written").len() > 100, "{name}");
        }
    }
    // The reader's end may be full as well.
    let folder = scenario(4.0, "");
    let mut command = Command::new("sh");
    let line = format!("exec '{}' run t.toml --out o > /dev/full", env!("CARGO_BIN_EXE_flotilla"));
    command.args(["-c", &line]).current_dir(folder.path());
    let finished = Process::spawn(command).finish();
    assert_eq!((finished.code, finished.err.len()), (Some(1), 1), "{finished:?}");
    assert!(finished.err[0].starts_with("flotilla: standard output: No space"), "{finished:?}");
    assert_eq!(read(&folder.path().join("o"))["complete"], true);
}

/// A folder that has gone is made again; where that cannot be, each file is named. The log has gone with its folder, in any case.
#[test]
fn a_folder_that_has_gone_loses_its_log_alone() {
    for obstacle in [false, true] {
        let folder = scenario(600.0, "");
        let results = folder.path().join("o");
        let run = Process::start(folder.path(), &["run", "t.toml", "--realtime", "--out", "o"]);
        let began = std::time::Instant::now();
        while !results.join("log.mcap").exists() {
            assert!(began.elapsed() < PATIENCE, "it never makes its log");
            std::thread::sleep(Duration::from_millis(5));
        }
        std::fs::remove_dir_all(&results).expect("a folder");
        if obstacle {
            std::fs::write(&results, b"").expect("a file");
        }
        end(&run, "INT");
        let finished = run.finish();
        assert_eq!(finished.code, Some(1), "{finished:?}");
        assert!(finished.err[0].ends_with(": interrupted"), "{finished:?}");
        assert!(finished.out.join("\n").contains("demanded m/s"), "{finished:?}");
        assert!(finished.err.iter().any(|line| line.starts_with("flotilla: o/log.mcap: ")), "{finished:?}");
        if !obstacle {
            assert_eq!((finished.err.len(), names(&results).len()), (2, 5), "{finished:?}");
            continue;
        }
        let named =
            |name: &str| finished.err.iter().filter(|line| line.contains(&format!("o/{name}: "))).count();
        assert_eq!(finished.err.len(), 7, "{finished:?}");
        assert!(PICTURES.iter().chain(&["summary.json"]).all(|name| named(name) == 1), "{finished:?}");
    }
}

/// No module has joined, nothing was measured: there are still a summary and four (empty) pictures.
#[test]
fn control_c_before_anything_happened() {
    let folder = scenario(600.0, "[timing]\njoin_s = 600\n");
    keygen(folder.path());
    let arguments = ["run", "t.toml", "--radio", "udp", "--listen", "127.0.0.1:0", "--out", "o"];
    let run = Process::start(folder.path(), &[&arguments[..], &["--key", KEY]].concat());
    assert!(run.err.recv_timeout(PATIENCE).expect("a line").starts_with("listening on "));
    end(&run, "INT");
    let finished = run.finish();
    assert_eq!(finished.code, Some(1), "{finished:?}");
    assert_eq!(finished.err, ["flotilla: ended early, after 0.0 of 600.0 s: interrupted"]);
    assert_eq!(read(&folder.path().join("o"))["cycles"]["total"], 0);
}

/// `flotilla run | head -1` is no accident.
#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let folder = scenario(2.0, "");
    for arguments in [&["run", "t.toml"][..], &["run", "t.toml", "--json"]] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_flotilla"))
            .args(arguments)
            .current_dir(folder.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the binary starts");
        drop(child.stdout.take());
        let output = child.wait_with_output().expect("an end");
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn help_has_an_example() {
    let folder = tempdir().expect("a folder");
    for arguments in
        [&["--help"][..], &["run", "--help"], &["plan", "--help"], &["module", "--help"], &["help", "run"]]
    {
        let finished = Process::start(folder.path(), arguments).finish();
        assert_eq!((finished.code, finished.err.len()), (Some(0), 0), "{finished:?}");
        let text = finished.out.join("\n");
        assert!(text.contains("Example") && text.contains("  flotilla "), "{arguments:?}: {text}");
    }
    assert_eq!(Process::start(folder.path(), &["--version"]).finish().code, Some(0));
}

/// The example of `plan --help`, taken from there, is a request that is answered.
#[test]
fn the_example_of_plan_works() {
    let folder = tempdir().expect("a folder");
    let help = Process::start(folder.path(), &["plan", "--help"]).finish().out.join("\n");
    let request =
        help.split('\'').find(|part| part.starts_with('{')).expect("a request in quotes").to_owned();
    let finished = Process::given(folder.path(), &["plan"], &request);
    assert_eq!(finished.code, Some(0), "{request}: {finished:?}");
    assert!(finished.out[0].contains("\"outcome\":\"planned\""), "{finished:?}");
}

/// What is asked of loss reaches the planner, from the command line as from the file; the share that was met is in the summary.
#[test]
fn loss_tolerance_is_what_was_asked() {
    let folder = scenario(8.0, "[planner]\nloss_tolerant = \"off\"\n");
    // Eastwards with the surge axis ahead, cycles are not power tolerant by chance.
    let path = folder.path().join("t.toml");
    let text = std::fs::read_to_string(&path).expect("a file");
    std::fs::write(&path, text.replace("heading_rad = 1.5", "heading_rad = 0")).expect("a file");
    let run = |how: &[&str], out: &str| {
        let arguments = [&["run", "t.toml", "--json", "--out", out], how].concat();
        let finished = Process::start(folder.path(), &arguments).finish();
        assert_eq!((finished.code, finished.err.len()), (Some(0), 0), "{finished:?}");
        let summary = read(&folder.path().join(out));
        let cycles = &summary["cycles"];
        assert!(cycles["total"].as_u64() >= Some(4) && cycles["planned"] == cycles["total"], "{summary}");
        ["loss_tolerant_share", "power_tolerant_share"].map(|key| cycles[key].as_f64().expect(key))
    };
    let [loss, _] = run(&[], "off");
    assert!(
        loss < 1.0,
        "with nothing asked {loss} of the cycles are loss tolerant: this scenario tells nothing"
    );
    let [loss, power] = run(&["--loss-tolerant", "require"], "require");
    assert!(loss >= 1.0, "{loss}");
    assert!(power < 1.0, "without being asked {power} are power tolerant: this scenario tells nothing");
    let shares = run(&["--loss-tolerant", "power"], "power");
    assert!(shares.iter().all(|share| *share >= 1.0), "{shares:?}");
    let wrong = Process::start(folder.path(), &["run", "t.toml", "--loss-tolerant", "always"]).finish();
    assert_eq!((wrong.code, wrong.out.len()), (Some(2), 0), "{wrong:?}");
    assert!(wrong.err.join("\n").contains("prefer, require, power, off"), "{wrong:?}");
}

/// As many modules as there are, or fewer: anything else is bad usage, and nothing is begun.
#[test]
fn as_many_modules_can_be_required_as_there_are() {
    let folder = scenario(4.0, "");
    for (require, why) in [
        ("4", "flotilla: --require 4: there are only 3 modules in t"),
        ("0", "must be `all` or a number of modules from 1 to 1024"),
        ("some", "must be `all` or a number of modules from 1 to 1024"),
    ] {
        let finished = Process::start(folder.path(), &["run", "t.toml", "--require", require]).finish();
        assert_eq!((finished.code, finished.out.len()), (Some(2), 0), "{finished:?}");
        assert!(finished.err.join("\n").contains(why), "{require}: {finished:?}");
    }
    assert_eq!(names(folder.path()), ["t.toml"]);
    for require in ["3", "all"] {
        let finished = Process::start(folder.path(), &["run", "t.toml", "--require", require]).finish();
        assert_eq!(finished.code, Some(0), "{finished:?}");
    }
}
