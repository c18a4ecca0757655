//! Scenarios that once broke the program, and how each has to end. The files are in `host/tests/trials`.

use std::path::{Path, PathBuf};

use crate::common::{Finished, Process};
use crate::cores::all_cores;
use serde_json::Value;
use tempfile::{TempDir, tempdir};

fn flotilla(arguments: &[&str]) -> (TempDir, Finished) {
    let folder = tempdir().expect("a folder");
    let _cores = all_cores();
    let finished = Process::start(folder.path(), arguments).finish();
    (folder, finished)
}

fn file(name: &str) -> String {
    let path: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/trials").join(name);
    path.to_str().expect("UTF-8").to_owned()
}

/// The lines of `--json`: what each criterion and manner came to.
fn planned(name: &str, more: &[&str]) -> (Finished, Vec<Value>) {
    let (_folder, finished) = flotilla(&[&["reconfigure", &file(name), "--json"], more].concat());
    let plans = finished.out.iter().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    (finished, plans)
}

fn joules(plan: &Value) -> f64 {
    plan["energy_total_j"].as_f64().unwrap_or_else(|| panic!("no plan: {plan}"))
}

/// 173.3 J, and turned by 90° a dead end.
#[test]
fn a_quarter_turn_changes_no_joules() {
    let [(_, north), (_, east)] = ["rot0.toml", "rot90.toml"].map(|name| planned(name, &[]));
    assert_eq!((north.len(), east.len()), (3, 3));
    for (north, east) in north.iter().zip(&east) {
        assert_eq!((&north["criterion"], &north["manner"]), (&east["criterion"], &east["manner"]));
        let ratio = joules(east) / joules(north);
        assert!((ratio - 1.0).abs() < 0.005, "{ratio} by {}, {}", north["criterion"], north["manner"]);
    }
}

/// Two columns vanished without a word in a pipe.
#[test]
fn every_criterion_is_named_in_a_pipe() {
    let (finished, plans) = planned("narrow.toml", &[]);
    let asked = [("energy", "paper"), ("euclidean", "paper"), ("energy", "best")];
    assert_eq!(plans.len(), asked.len(), "{finished:?}");
    let (_folder, shown) = flotilla(&["reconfigure", &file("narrow.toml"), "--plan-only"]);
    let mut made = 0;
    for ((plan, (criterion, manner)), title) in plans.iter().zip(asked).zip(["energy", "euclidean", "best"]) {
        assert_eq!((&plan["criterion"], &plan["manner"]), (&criterion.into(), &manner.into()));
        let named = shown.out.iter().filter(|line| line.contains(&format!("{title}: "))).count();
        assert!(named > 0 || shown.err.iter().any(|line| line.contains(title)), "{title}: {shown:?}");
        match plan["failure"].as_str() {
            Some(why) => {
                assert!(!why.is_empty() && plan.get("moves").is_none(), "{plan}");
                let all = shown.out.iter().chain(&shown.err).cloned().collect::<String>();
                assert!(all.contains(why), "{title}: {why} in {shown:?}");
            }
            None => made += usize::from(joules(plan) > 0.0),
        }
    }
    // Some plan is enough where none was asked for by name.
    let expected = i32::from(made == 0);
    assert_eq!((finished.code, shown.code), (Some(expected), Some(expected)), "{finished:?}, {shown:?}");
    // Asked for by name, it decides.
    for (index, criterion) in ["energy", "euclidean"].into_iter().enumerate() {
        let manner = ["--criterion", criterion, "--manner", "paper"];
        let (finished, alone) = planned("narrow.toml", &manner);
        let failed = plans[index]["failure"].is_string();
        assert_eq!(alone[0]["failure"].is_string(), failed, "{finished:?}");
        assert_eq!(finished.code, Some(i32::from(failed)), "{finished:?}");
    }
}

/// −0.00 and NaN.
#[test]
fn nothing_to_do_is_said_so() {
    let (_folder, finished) = flotilla(&["reconfigure", &file("enclosed.toml")]);
    assert_eq!(finished.code, Some(0), "{finished:?}");
    let text = finished.out.join("\n");
    assert!(text.contains("nothing to do") && !text.contains("NaN") && !text.contains("-0.00"), "{text}");
    let (_, plans) = planned("enclosed.toml", &[]);
    assert!(
        plans.iter().all(|plan| plan["energy_total_j"]
            .as_f64()
            .is_some_and(|energy_j| energy_j == 0.0 && energy_j.is_sign_positive())),
        "{plans:?}"
    );
}

/// The built-in BlueROV2 could not be planned with: it has no thruster for pitch.
#[test]
fn a_bluerov2_holds_its_pitch_by_its_own_stability() {
    let (finished, plans) = planned("bv2.toml", &["--criterion", "energy"]);
    assert_eq!(finished.code, Some(0), "{finished:?}");
    assert_eq!(plans[0]["moves"].as_array().map(Vec::len), Some(1), "{plans:?}");
    assert!(joules(&plans[0]) > 1.0);
}

/// A thruster out of order: what is left is planned with, or what is missing is named.
#[test]
fn a_robot_without_one_thruster_plans_with_what_is_left_or_says_what_is_missing() {
    let folder = tempdir().expect("a folder");
    let scenario = |failed: &str| {
        format!(
            "name = \"t\"\n[[robot]]\nid = 7\nvehicle = \"bluerov1\"\nstart = [0.0, 0.0, 5.0, 0.0]\nfailed = {failed}\n\
             [[slot]]\npose = [2.0, 0.0, 5.0, 0.0]\n"
        )
    };
    let run = |failed: &str| {
        std::fs::write(folder.path().join("t.toml"), scenario(failed)).expect("a file");
        let arguments = ["reconfigure", "t.toml", "--criterion", "energy", "--json"];
        Process::start(folder.path(), &arguments).finish()
    };
    // Without sway it goes bow first.
    let without_sway = run("[6]");
    assert_eq!((without_sway.code, without_sway.out.len()), (Some(0), 1), "{without_sway:?}");
    // One of the two upright ones before: roll, pitch and heave are no longer free of each other.
    for (failed, parts) in [
        ("[4]", ["robot 7", "without thruster 4", "(v6)"]),
        ("[1]", ["robot 7", "surge", "(v1)"]),
        ("[9]", ["t.toml:6", "failed = [9]", "thrusters 1 to 6"]),
    ] {
        let refused = run(failed);
        assert_eq!((refused.code, refused.err.len()), (Some(2), 1), "{refused:?}");
        for part in parts {
            assert!(refused.err[0].contains(part), "{part} in {refused:?}");
        }
    }
}

/// A speed that no thrust gives is named, and takes only the plans down that swim at it.
#[test]
fn a_speed_beyond_thrust_is_named_with_the_one_that_can_be_reached() {
    let folder = tempdir().expect("a folder");
    let text = std::fs::read_to_string(file("rot0.toml")).expect("a file") + "[rules]\nspeed_m_s = 5.0\n";
    std::fs::write(folder.path().join("t.toml"), text).expect("a file");
    let finished = Process::start(folder.path(), &["reconfigure", "t.toml", "--json"]).finish();
    assert_eq!((finished.code, finished.out.len()), (Some(0), 3), "{finished:?}");
    for (line, is_paper) in finished.out.iter().zip([true, true, false]) {
        let named = line.contains("speed_m_s = 5 m/s takes more thrust than there is");
        assert_eq!(named, is_paper, "{line}");
    }
}

/// A boat's run from its log: its picture of the trajectory.
fn trajectory(name: &str) -> String {
    let (folder, finished) = flotilla(&["run", &file(name), "--out", "o"]);
    let path = folder.path().join("o/trajectory.svg");
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{error}: {finished:?}"))
}

/// Least and greatest of what stands before (0) or after (1) the commas of polylines of that colour, px.
fn extent(svg: &str, colour: &str, axis: usize) -> Vec<(f64, f64)> {
    let lines = svg.split("<polyline").skip(1).filter(|line| line.contains(colour));
    lines
        .map(|line| {
            let points = line.split("points=\"").nth(1).and_then(|rest| rest.split('"').next()).unwrap_or("");
            let values =
                points.split_whitespace().filter_map(|point| point.split(',').nth(axis)?.parse().ok());
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v: f64| (low.min(v), high.max(v)))
        })
        .collect()
}

/// A heading of 3.1 rad and one of −3.1 rad were drawn a turn apart, and axes a thousand kilometres out hid the run.
#[test]
fn headings_are_drawn_on_one_turn_far_away_too() {
    let svg = trajectory("wrap.toml");
    let ticks: Vec<&str> = svg.split(['<', '>']).map(str::trim).filter(|text| !text.is_empty()).collect();
    // Between 177.6° and 182.4° and the band of 0.15 rad: no tick is at an angle far from there.
    assert!(ticks.contains(&"180") && !ticks.contains(&"−90") && !ticks.contains(&"90"), "{ticks:?}");
    assert!(ticks.contains(&"1000000.0"), "the map's ticks are tenths of a metre: {ticks:?}");
}

/// The path of a run 1 km away is a line of some length on the map.
#[test]
fn a_map_far_from_the_origin_shows_the_run() {
    let svg = trajectory("far1000.toml");
    let orange = extent(&svg, "#E69F00", 0);
    let widest = orange.iter().map(|(low, high)| high - low).fold(0.0, f64::max);
    assert!(widest > 200.0, "{orange:?}");
}

/// 0.5 m/s asked, 0.083 swum, "wrench error 0.0 %", exit 0.
#[test]
fn a_demand_too_fast_is_said_with_the_attainable_speed() {
    let (_folder, finished) = flotilla(&["run", &file("plusfast.toml"), "--out", "o"]);
    assert_eq!(finished.code, Some(1), "{finished:?}");
    let said = finished.err.join("\n");
    assert!(said.contains("0.510 m/s asked is more than this structure can give: at most 0."), "{said}");
}
