//! `flotilla reconfigure` through the binary: the contract of its JSON, its judge, and what it refuses.

use std::path::Path;

use crate::common::{Finished, PATIENCE, Process};
use crate::cores::all_cores;
use crate::interrupt::end;
use crate::keys::{KEY, keygen};
use crate::terminal;
use serde_json::Value;
use tempfile::{TempDir, tempdir};

/// Two robots side by side; the second goes to the other side of the first. Line 6 is robot 1's start, 10 robot 2's,
/// 12 and 14 are the slots.
const GOOD: &str = "name = \"t\"\n\n[[robot]]\nid = 1\nvehicle = \"bluerov1\"\nstart = [0.0, 0.0, 0.0, 0.0]\n[[robot]]\n\
                    id = 2\nvehicle = \"bluerov1\"\nstart = [0.0, 0.33, 0.0, 0.0]\n[[slot]]\n\
                    pose = [0.0, 0.0, 0.0, 0.0]\n[[slot]]\npose = [0.0, -0.33, 0.0, 0.0]\n";

fn flotilla(folder: &Path, arguments: &[&str], input: &str) -> Finished {
    let _cores = all_cores();
    Process::given(folder, arguments, input)
}

fn folder_with(text: &str) -> TempDir {
    let folder = tempdir().expect("a folder");
    std::fs::write(folder.path().join("t.toml"), text).expect("a file");
    folder
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|number| number.as_f64().expect("a number")).collect()
}

#[test]
fn a_plan_is_one_line_with_the_fields_that_scripts_read() {
    let folder = folder_with(GOOD);
    // By the measured table two short ways at its least count cost less than one long one.
    let arguments = ["reconfigure", "t.toml", "--criterion", "energy", "--power", "fitted", "--json"];
    let finished = flotilla(folder.path(), &arguments, "");
    assert_eq!((finished.code, finished.out.len()), (Some(0), 1), "{finished:?}");
    let plan: Value = serde_json::from_str(&finished.out[0]).expect("JSON");
    assert_eq!(plan["criterion"], "energy");
    assert_eq!(plan["robots"][1]["id"], 2);
    assert_eq!(numbers(&plan["robots"][1]["start"]), [0.0, 0.33, 0.0, 0.0]);
    assert_eq!(numbers(&plan["slots"][1]), [0.0, -0.33, 0.0, 0.0]);
    // Robot 1 may stay where it is: it is in a slot.
    let moves = plan["moves"].as_array().expect("moves");
    assert_eq!(moves.len(), 1, "{plan}");
    assert_eq!((moves[0]["robot"].as_u64(), moves[0]["slot"].as_u64()), (Some(2), Some(1)));
    let path: Vec<Vec<f64>> = moves[0]["path"].as_array().expect("a path").iter().map(numbers).collect();
    assert_eq!(path.first().expect("a start"), &[0.0, 0.33, 0.0]);
    assert_eq!(path.last().expect("an end"), &[0.0, -0.33, 0.0]);
    let sum = |key: &str| -> f64 { moves.iter().map(|part| part[key].as_f64().expect(key)).sum() };
    let whole = |key: &str| plan[key].as_f64().expect(key);
    assert!((sum("energy_navigate_j") - whole("energy_navigate_j")).abs() < 1e-9);
    assert!((sum("energy_balance_j") - whole("energy_balance_j")).abs() < 1e-9);
    assert!((sum("duration_s") - whole("time_s")).abs() < 1e-9);
    let total = whole("energy_navigate_j") + whole("energy_balance_j");
    assert!((whole("energy_total_j") - total).abs() < 1e-9 && total > 1.0);
    // Nothing is left behind.
    let left = std::fs::read_dir(folder.path()).expect("a folder").count();
    assert_eq!(left, 1, "only the scenario");
}

#[test]
fn a_plan_that_was_handed_out_is_kept_and_one_that_was_changed_is_not() {
    let folder = folder_with(GOOD);
    let plan = flotilla(folder.path(), &["reconfigure", "t.toml", "--criterion", "energy", "--json"], "")
        .out
        .remove(0);
    let judged = |text: &str| flotilla(folder.path(), &["reconfigure", "t.toml", "--verify", "-"], text);
    let kept = judged(&plan);
    assert_eq!(kept.code, Some(0), "{kept:?}");
    assert!(kept.out[0].contains("keeps every condition"), "{kept:?}");
    let mut changed: Value = serde_json::from_str(&plan).expect("JSON");
    changed["moves"][0]["slot"] = 0.into();
    let broken = judged(&changed.to_string());
    assert_eq!(broken.code, Some(1), "{broken:?}");
    assert!(!broken.out.is_empty() && broken.err[0].contains("condition"), "{broken:?}");
    let cut = judged(&plan[..plan.len() / 2]);
    assert_eq!(cut.code, Some(2), "{cut:?}");
    assert!(cut.err[0].starts_with("flotilla: -:1: not a plan"), "{cut:?}");
}

#[test]
fn what_cannot_be_planned_is_refused_in_one_line() {
    let tool = "[[tool]]\nvehicle = \"tool-20n\"\npose = [5.0, 0.0, 0.0, 0.0]\n";
    let five = "name = \"five\"\nbox_m = [0.4, 0.3, 0.2]\nmass_kg = 5.0\ninertia_kg_m2 = [0.1, 0.1, 0.1]\n\
                added_mass = [5.0, 9.0, 9.0, 0.1, 0.1, 0.1]\nlinear_damping = [4.0, 6.0, 5.0, 0.1, 0.1, 0.1]\n\
                quadratic_damping = [18.0, 21.0, 36.0, 1.0, 1.0, 1.0]\n[[thrusters]]\nposition_m = [0.0, 0.1, 0.0]\n\
                direction = [1.0, 0.0, 0.0]\n[[thrusters]]\nposition_m = [0.0, -0.1, 0.0]\n\
                direction = [1.0, 0.0, 0.0]\n";
    let single = |start: &str, slot: &str, more: &str| {
        format!(
            "name = \"t\"\n[[robot]]\nid = 1\nvehicle = \"five.toml\"\nstart = {start}\n[[slot]]\npose = {slot}\n{more}"
        )
    };
    let cases: Vec<(&str, String, i32, Vec<&str>)> = vec![
        (
            "outside the water",
            format!("{GOOD}[rules]\nbounds_m = [[-1, -1, -1], [1, 0.4, 1]]\n"),
            2,
            vec!["t.toml:10", "robot 2", "water"],
        ),
        (
            "two in one place",
            GOOD.replace("0.33, 0.0, 0.0]\n[[slot]]", "0.0, 0.0, 0.0]\n[[slot]]"),
            2,
            vec!["robot 1", "robot 2"],
        ),
        (
            "fewer slots than robots",
            GOOD.replace("[[slot]]\npose = [0.0, -0.33, 0.0, 0.0]\n", ""),
            2,
            vec!["slot", "2"],
        ),
        ("a capability no robot has", format!("{GOOD}requires = [\"laser\"]\n"), 2, vec!["laser"]),
        ("a tool left alone", format!("{GOOD}{tool}"), 2, vec!["tool 1"]),
        ("voltage", format!("{GOOD}[rules]\nbattery_v = 24.0\n"), 2, vec!["24", "V"]),
        (
            "not a number",
            GOOD.replace("0.33, 0.0, 0.0]\n[[slot]]", "nan, 0.0, 0.0]\n[[slot]]"),
            2,
            vec!["t.toml:10", "NaN"],
        ),
        ("rank", single("[0.0, 0.0, 0.0, 0.0]", "[1.0, 0.0, 0.0, 0.0]", ""), 2, vec!["five", "rank 2"]),
        (
            // Water only as wide as the row, and the one behind is to end in front.
            "unreachable",
            format!(
                "{}requires = [\"sonar\"]\n[rules]\nbounds_m = [[-0.25, -0.8, -0.14], [0.25, 0.5, 0.14]]\n",
                GOOD.replace(
                    "0.33, 0.0, 0.0]\n[[slot]]",
                    "0.33, 0.0, 0.0]\ncapabilities = [\"sonar\"]\n[[slot]]"
                )
                .replace("pose = [0.0, -0.33, 0.0, 0.0]", "pose = [0.0, -0.6, 0.0, 0.0]")
                .replace("pose = [0.0, 0.0, 0.0, 0.0]", "pose = [0.0, -0.27, 0.0, 0.0]")
            ),
            1,
            vec!["cannot be reached", "every one there is"],
        ),
        ("an unknown key", format!("{GOOD}colour = 1\n"), 2, vec!["t.toml:15", "unknown field `colour`"]),
        ("no such scenario", String::new(), 2, vec!["no-such"]),
    ];
    for (name, text, code, parts) in cases {
        let folder = folder_with(&text);
        std::fs::write(folder.path().join("five.toml"), five).expect("a file");
        let scenario = if text.is_empty() { "no-such" } else { "t.toml" };
        let arguments = ["reconfigure", scenario, "--criterion", "energy"];
        let finished = flotilla(folder.path(), &arguments, "");
        assert_eq!(finished.code, Some(code), "{name}: {finished:?}");
        assert_eq!(finished.err.len(), 1, "{name}, one line: {finished:?}");
        assert!(finished.out.is_empty(), "{name}: {finished:?}");
        for part in parts {
            assert!(finished.err[0].contains(part), "{name}: {part} in {finished:?}");
        }
        assert!(!folder.path().join("runs").exists(), "{name} leaves nothing behind");
    }
}

/// No robot has joined, nothing was executed: the plan is kept, with its pictures.
#[test]
fn requests_to_end_leave_what_there_is() {
    for signal in ["INT", "TERM", "HUP"] {
        let folder = folder_with(GOOD);
        keygen(folder.path());
        let arguments = ["reconfigure", "t.toml", "--criterion", "energy", "--out", "o"];
        let radio = ["--radio", "udp", "--listen", "127.0.0.1:0", "--key", KEY];
        let process = terminal::start(folder.path(), &[&arguments[..], &radio].concat());
        assert!(process.err.recv_timeout(PATIENCE).expect("a line").starts_with("listening on "));
        end(&process, signal);
        let finished = process.finish();
        assert_eq!(
            (finished.code, &finished.err[..]),
            (Some(1), &["flotilla: energy: interrupted".to_owned()][..])
        );
        assert!(finished.out.join("\n").contains("planned: to navigate, J"), "{finished:?}");
        for name in ["plan-energy.json", "summary.json", "scene.svg", "pwm.svg"] {
            assert!(folder.path().join("o").join(name).is_file(), "{signal}: {name}");
        }
    }
}

/// A device that is always full takes the place of a file, then a folder does.
#[cfg(target_os = "linux")]
#[test]
fn a_file_that_cannot_be_written_is_named_and_the_others_are_kept() {
    let all = [
        "log.mcap",
        "plan-energy.json",
        "summary.json",
        "scene.svg",
        "top.svg",
        "velocity.svg",
        "force.svg",
        "power.svg",
        "pwm.svg",
    ];
    for (failing, why) in
        [("plan-energy.json", "No space"), ("summary.json", "No space"), ("top.svg", "Is a directory")]
    {
        let folder = folder_with(GOOD);
        let results = folder.path().join("o");
        std::fs::create_dir(&results).expect("a folder");
        if why == "No space" {
            std::os::unix::fs::symlink("/dev/full", results.join(failing)).expect("a link");
        } else {
            std::fs::create_dir(results.join(failing)).expect("a folder");
        }
        let arguments = ["reconfigure", "t.toml", "--criterion", "energy", "--out", "o"];
        let finished = flotilla(folder.path(), &arguments, "");
        assert_eq!((finished.code, finished.err.len()), (Some(1), 1), "{finished:?}");
        assert!(
            finished.err[0].starts_with(&format!("flotilla: o/{failing}: cannot write: {why}")),
            "{finished:?}"
        );
        for name in all.iter().filter(|name| **name != failing) {
            assert!(std::fs::metadata(results.join(name)).expect("it was written").len() > 100, "{name}");
            assert!(finished.out.contains(&format!("  o/{name}")), "{finished:?}");
        }
        assert!(!finished.out.contains(&format!("  o/{failing}")), "{finished:?}");
    }
}
