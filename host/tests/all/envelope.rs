//! The contract of `flotilla plan --envelope`, through the binary.

use std::path::Path;

use crate::common::{Finished, Process};
use serde_json::{Value, json};
use tempfile::tempdir;

/// 0.022·2.6 − 0.019 N.
const F: f64 = 0.0382;
const D: f64 = 0.15;
const LINE: &str = "[[0,0],[1,0],[2,0]]";

fn request(cells: &str, [fx_n, fy_n, tau_nm]: [f64; 3]) -> String {
    format!(
        "{{\"cells\":{cells},\"demand\":{{\"fx_n\":{fx_n:?},\"fy_n\":{fy_n:?},\"tau_nm\":{tau_nm:?}}}}}\n"
    )
}

fn finished(folder: &Path, more: &[&str], input: &str) -> Finished {
    Process::given(folder, &[&["plan", "--envelope"], more].concat(), input)
}

fn answers(folder: &Path, more: &[&str], input: &str) -> Vec<Value> {
    let finished = finished(folder, more, input);
    assert_eq!((finished.code, finished.err.len()), (Some(0), 0), "{finished:?}");
    finished.out.iter().map(|line| serde_json::from_str(line).expect("JSON")).collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn close(found: &Value, told: f64, what: &str) {
    let found = number(found);
    assert!((found - told).abs() <= 1e-9 * (1e-3 + told.abs()), "{what}: {found}, not {told}");
}

#[track_caller]
fn is_wrench(found: &Value, told: [f64; 3], what: &str) {
    assert_eq!(found.as_object().map(serde_json::Map::len), Some(3), "{what}: {found}");
    for (key, told) in ["fx_n", "fy_n", "tau_nm"].into_iter().zip(told) {
        close(&found[key], told, &format!("{what} {key}"));
    }
}

/// Three in a row: all along gives 3F; the torque is that of the outer two, 2·F·d; half a demand is half a gauge.
#[test]
fn a_demand_is_measured_against_its_structure() {
    let folder = tempdir().expect("a folder");
    let demands = [[0.02, 0.0, 0.0], [0.0, -0.3, 0.0], [0.0, 0.0, 0.001], [0.0; 3]];
    let input: String = demands.into_iter().map(|demand| request(LINE, demand)).collect();
    let told = answers(folder.path(), &[], &input);
    let extremes = [3.0 * F, 3.0 * F, 2.0 * F * D];
    let expected = [
        (0.02 / (3.0 * F), true, [3.0 * F, 0.0, 0.0]),
        (0.3 / (3.0 * F), false, [0.0, -3.0 * F, 0.0]),
        (0.001 / (2.0 * F * D), true, [0.0, 0.0, 2.0 * F * D]),
    ];
    assert_eq!(told.len(), 4);
    for (told, (gauge, inside, boundary)) in told.iter().zip(expected) {
        close(&told["gauge"], gauge, "gauge");
        assert_eq!(told["inside"], inside, "{told}");
        is_wrench(&told["boundary"], boundary, "boundary");
        is_wrench(&told["extremes"], extremes, "extremes");
    }
    close(&told[3]["gauge"], 0.0, "no demand");
    assert_eq!((&told[3]["inside"], &told[3]["boundary"]), (&json!(true), &Value::Null));
}

#[test]
fn one_module_has_no_torque_and_its_border_is_inside() {
    let folder = tempdir().expect("a folder");
    let input = request("[[4,4]]", [0.0, 0.03, 1e-6]) + &request("[[4,4]]", [0.3, 0.4, 0.0]);
    let told = answers(folder.path(), &[], &input);
    assert_eq!((&told[0]["gauge"], &told[0]["boundary"]), (&Value::Null, &Value::Null));
    assert_eq!(told[0]["inside"], false);
    is_wrench(&told[1]["boundary"], [0.6 * F, 0.8 * F, 0.0], "boundary");
    is_wrench(&told[1]["extremes"], [F, F, 0.0], "extremes");

    // The border, asked again, in the digits in which it was told.
    let cells = "[[0,0],[1,0],[1,1],[2,1],[2,2]]";
    let demand = |k: u32| [1.0, 0.1 * f64::from(k), 0.3 - 0.02 * f64::from(k)];
    let first = answers(folder.path(), &[], &(0..30).map(|k| request(cells, demand(k))).collect::<String>());
    assert!(first.iter().all(|told| told["inside"] == false));
    let again: String = first
        .iter()
        .map(|told| request(cells, ["fx_n", "fy_n", "tau_nm"].map(|key| number(&told["boundary"][key]))))
        .collect();
    for told in answers(folder.path(), &[], &again) {
        close(&told["gauge"], 1.0, "the border");
        assert_eq!(told["inside"], true, "{told}");
    }
}

/// A stream for the planner can be sent as it is; the modules may come from a scenario.
#[test]
fn requests_are_those_of_plan() {
    let folder = tempdir().expect("a folder");
    let text = "name = \"t\"\n[structure]\nsize = \"1x1\"\n[[leg]]\nduration_s = 1\nvelocity_m_s = [0, 0]\n\
                heading_rad = 0\n[modboat]\npitch_m = 0.3\nforce_offset_n = 0.01\n";
    std::fs::write(folder.path().join("t.toml"), text).expect("a file");
    let input = request(LINE, [0.02, 0.0, 0.0]).replace("}}", "},\"tail_rad\":[0.1,1.4,-1.0]}")
        + &request(LINE, [0.02, 0.0, 0.0]).replace("}}", "},\"tail_rad\":\"previous\"}");
    let told = answers(folder.path(), &["--scenario", "t.toml"], &input);
    let thrust_n = 0.022 * 2.6 - 0.01;
    for told in told {
        is_wrench(&told["extremes"], [3.0 * thrust_n, 3.0 * thrust_n, 0.6 * thrust_n], "extremes");
    }
}

#[test]
fn the_picture_holds_the_demands_on_the_first_structure() {
    let folder = tempdir().expect("a folder");
    let input = request(LINE, [0.02, 0.0, 0.0])
        + &request("[[0,0]]", [0.02, 0.0, 0.0])
        + &request(LINE, [0.2, 0.1, 0.001]);
    answers(folder.path(), &["--plot", "e.svg"], &input);
    let picture = std::fs::read_to_string(folder.path().join("e.svg")).expect("a picture");
    assert!(picture.starts_with("<svg ") && picture.trim_end().ends_with("</svg>"));
    for label in ["3 modules · envelope", "demands 2, outside 1", "Fx ±114.6 mN", "τ ±11.5 mN·m"] {
        assert!(picture.contains(label), "{label} is missing");
    }
}

#[test]
fn mistakes_are_named() {
    let folder = tempdir().expect("a folder");
    let input = request("[[0,0],[2,0]]", [0.0; 3])
        + &request(LINE, [0.0, 2e6, 0.0])
        + "{\"cells\":[[0,0]]}\n"
        + &request(LINE, [0.1, 0.0, 0.0]);
    let told = finished(folder.path(), &[], &input);
    assert_eq!((told.code, told.err.len(), told.out.len()), (Some(2), 3, 4), "{told:?}");
    for (line, what) in told.out.iter().zip(["in pieces", "demand.fy_n = 2e6 N", "missing field `demand`"]) {
        let refusal: Value = serde_json::from_str(line).expect("JSON");
        assert!(refusal["error"].as_str().is_some_and(|error| error.contains(what)), "{line}: {what}");
    }
    assert!(told.out[3].contains("gauge"), "the stream goes on: {told:?}");

    for (arguments, code, what) in [
        (&["--plot", "not/there.svg"][..], 1, "not/there.svg: cannot write"),
        (&["--plot", "e.svg"], 2, "e.svg: no request, nothing to draw"),
        (&["--planner", "potential-field"], 2, "cannot be used with"),
    ] {
        let told = finished_without_input(folder.path(), arguments);
        assert_eq!(told.code, Some(code), "{told:?}");
        assert!(told.err.join("\n").contains(what), "{told:?}");
    }
    assert!(!folder.path().join("e.svg").exists(), "an empty file is no picture");
    let told = Process::start(folder.path(), &["plan", "--plot", "e.svg"]).finish();
    assert_eq!(told.code, Some(2), "{told:?}");
    assert!(told.err.join("\n").contains("--envelope"), "{told:?}");

    let help = Process::start(folder.path(), &["plan", "--help"]).finish().out.join(" ");
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(help.contains("flotilla plan --envelope --plot envelope.svg"), "{help}");
}

fn finished_without_input(folder: &Path, more: &[&str]) -> Finished {
    Process::start(folder, &[&["plan", "--envelope"], more].concat()).finish()
}
