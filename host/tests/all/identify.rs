//! `flotilla identify` as its users meet it.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use host::run::scenario::Scenario;
use serde_json::Value;
use tempfile::tempdir;

use crate::said::{done, refused};

fn flotilla(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_flotilla"));
    command.args(arguments).current_dir(folder).output().expect("it runs")
}

const BOAT: &str = "name = \"t\"\n[structure]\nsize = \"2x1\"\n[bounds]\nedge_m = [[-2, -2], [2, -2], [2, 2], [-2, 2]]\n\
                    [[leg]]\nduration_s = 5\nvelocity_m_s = [0.0, 0.0]\nheading_rad = 0.0\n\
                    [tank]\ndrag_sway_n_s2_m2 = 8.0\n";

#[test]
fn an_experiment_is_run_and_what_it_shows_is_told_written_and_pasted() {
    let folder = tempdir().expect("a folder");
    let at = folder.path();
    fs::write(at.join("t.toml"), BOAT).expect("a file");
    let experiment = done(&flotilla(at, &["identify", "--experiment", "t.toml", "--duration", "60"]));
    fs::write(at.join("x.toml"), experiment).expect("a file");
    done(&flotilla(at, &["run", "x.toml", "--out", "o"]));
    let told = done(&flotilla(at, &["identify", "o/log.mcap", "--out", "found"]));
    for word in ["drag_sway_n_s2_m2", "95 % interval", "taken as known", "foretold", "[modboat]"] {
        assert!(told.contains(word), "{word}: {told}");
    }
    let json = fs::read_to_string(at.join("found/identified.json")).expect("written");
    let outcome: Value = serde_json::from_str(&json).expect("JSON");
    let mut constants = outcome["constants"].as_array().expect("a list").iter();
    let drag = constants.find(|constant| constant["name"] == "drag_sway_n_s2_m2").expect("sway");
    // The water has 8, the scenario believes 4.5.
    assert!((drag["value"].as_f64().expect("a number") / 8.0 - 1.0).abs() < 0.3, "{drag}");
    assert_eq!(drag["belief"].as_f64(), Some(4.5));
    for picture in ["foretold.svg", "residuals.svg"] {
        assert!(fs::read_to_string(at.join("found").join(picture)).expect(picture).contains("</svg>"));
    }
    // What is to be pasted is a scenario's: the tables parse.
    let pasted = done(&flotilla(at, &["identify", "o/log.mcap", "--toml"]));
    let scenario = format!("{}{}", BOAT.split("[tank]").next().expect("a head"), pasted);
    Scenario::parse("pasted", &scenario).unwrap_or_else(|error| panic!("{error}\n{scenario}"));
}

#[test]
fn what_nothing_can_be_identified_from_is_refused_by_name() {
    let folder = tempdir().expect("a folder");
    let at = folder.path();
    fs::write(at.join("t.toml"), BOAT).expect("a file");
    let says = |arguments: &[&str], expected: &str| {
        let said = refused(&flotilla(at, arguments));
        assert!(said.contains(expected), "{said}");
    };
    says(&["identify", "none.mcap"], "none.mcap");
    says(&["identify", "t.toml"], "not a log");
    says(&["identify", "--experiment", "holonomic-1"], "[bounds] is missing");
    says(&["identify", "--experiment", "t.toml", "--duration", "1"], "--duration 1 s");
    done(&flotilla(at, &["run", "t.toml", "--out", "o"]));
    says(&["identify", "o/log.mcap"], "10 s are needed");
}
