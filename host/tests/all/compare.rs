//! `flotilla compare` as a user meets it: the table, the folder, the JSON, and what is refused.

use crate::common::Process;
use serde_json::Value;
use tempfile::{TempDir, tempdir};

fn scenario(more: &str) -> TempDir {
    let folder = tempdir().expect("a folder");
    let text = format!(
        "name = \"t\"\n[structure]\nsize = \"2x2\"\n[[leg]]\nduration_s = 24\n\
         velocity_m_s = [0.03, 0]\nheading_rad = 1.5\n{more}"
    );
    std::fs::write(folder.path().join("t.toml"), text).expect("a file");
    folder
}

#[test]
fn planners_stand_side_by_side_and_leave_figures_and_two_pictures() {
    let folder = scenario("[[leg]]\nduration_s = 24\nposition_m = [0.5, 0.0]\nheading_rad = 1.5\n");
    let finished = Process::start(folder.path(), &["compare", "t.toml", "--seeds", "2"]).finish();
    assert_eq!((finished.code, finished.err.len()), (Some(0), 0), "quiet in a pipe: {finished:?}");
    let text = finished.out.join("\n");
    for part in
        ["t: 4 modules, seeds 1 to 2: mean, worst", "exact", "potential-field", "heading error RMS, mrad"]
    {
        assert!(text.contains(part), "{text}\ndoes not say {part:?}");
    }
    assert!(!text.contains('\u{1b}'), "no escape codes in a pipe: {text:?}");
    let results = folder.path().join("runs/t-compared");
    for picture in ["trajectories.svg", "heading.svg"] {
        let svg = std::fs::read_to_string(results.join(picture)).expect("a picture");
        assert!(
            svg.starts_with("<svg") && svg.contains("potential-field") && svg.contains("exact"),
            "{picture}"
        );
    }
    let summary = std::fs::read_to_string(results.join("summary.json")).expect("a summary");
    let summary: Value = serde_json::from_str(&summary).expect("JSON");
    assert_eq!(summary["seeds"], serde_json::json!([1, 2]));
    // The table shows what the summary says.
    let heading = text.lines().find(|line| line.contains("heading error RMS")).expect("a row");
    for planner in summary["planners"].as_array().expect("a list") {
        let mean = planner["figures"]["heading_rms_rad"]["mean"].as_f64().expect("a number");
        assert!(heading.contains(&format!("{:.2}", 1e3 * mean)), "{mean} in {heading}");
        assert!(planner["figures"]["position_rms_m"]["mean"].as_f64() > Some(0.0), "{planner}");
        assert_eq!(planner["runs"].as_array().map(Vec::len), Some(2));
    }
}

#[test]
fn json_is_the_summary_and_the_runs_are_those_of_run() {
    let folder = scenario("");
    let arguments =
        ["compare", "t.toml", "--planners", "potential-field", "--seeds", "1", "--seed", "9", "--json"];
    let finished = Process::start(folder.path(), &arguments).finish();
    assert_eq!((finished.code, finished.err.len()), (Some(0), 0), "{finished:?}");
    let compared: Value = serde_json::from_str(&finished.out.join("\n")).expect("JSON and nothing else");
    let of_compare = &compared["planners"][0]["runs"][0];
    let arguments = ["run", "t.toml", "--planner", "potential-field", "--seed", "9", "--json"];
    let finished = Process::start(folder.path(), &arguments).finish();
    let of_run: Value = serde_json::from_str(&finished.out.join("\n")).expect("JSON");
    for key in ["planner", "seed", "legs", "contacts", "link", "least_clearance_m"] {
        assert_eq!(of_compare[key], of_run[key], "{key}");
    }
}

#[test]
fn what_cannot_be_compared_is_named() {
    let folder = scenario("");
    for (arguments, expected) in [
        (&["--planners", "best"][..], "best"),
        (&["--planners", "exact,exact"], "--planners: exact is named twice"),
        (&["--seeds", "0"], "0 is not in 1..=1000"),
        (&["--seeds", "many"], "many"),
        (&["--out", "t.toml/results"], "cannot write to t.toml/results: "),
        (&["--radio", "udp"], "--radio"),
    ] {
        let arguments = [&["compare", "t.toml"], arguments].concat();
        let finished = Process::start(folder.path(), &arguments).finish();
        assert_eq!((finished.code, finished.out.len()), (Some(2), 0), "{arguments:?}: {finished:?}");
        assert!(finished.err.join("\n").contains(expected), "{arguments:?}: {finished:?}");
        assert!(!folder.path().join("runs").exists(), "{arguments:?} left a folder");
    }
    let finished = Process::start(folder.path(), &["compare", "nowhere"]).finish();
    assert_eq!(finished.code, Some(2));
    assert!(finished.err[0].starts_with("flotilla: nowhere: no such file"), "{finished:?}");
    let text = "name = \"t\"\n[structure]\nsize = \"2x2\"\n[[leg]]\nduration_s = 24\nheading_rad = 1.5\n";
    for more in ["", "velocity_m_s = [0.0, 0.0]\nposition_m = [0.0, 0.0]\n"] {
        std::fs::write(folder.path().join("t.toml"), format!("{text}{more}")).expect("a file");
        let finished = Process::start(folder.path(), &["compare", "t.toml"]).finish();
        let line = if more.is_empty() { 4 } else { 7 };
        let said =
            format!("flotilla: t.toml:{line}: [[leg]] 1: takes exactly one of velocity_m_s and position_m");
        assert_eq!((finished.code, &finished.err), (Some(2), &vec![said]));
    }
}

#[test]
fn help_has_an_example_that_parses() {
    let folder = tempdir().expect("a folder");
    let finished = Process::start(folder.path(), &["compare", "--help"]).finish();
    let text = finished.out.join("\n");
    assert_eq!(finished.code, Some(0));
    assert!(text.contains("flotilla compare station-keeping --planners exact,potential-field"), "{text}");
}
