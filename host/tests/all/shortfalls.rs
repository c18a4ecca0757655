//! A run that was not what was asked does not end with 0: which module, how much of the time, why, how fast it could have gone.

use std::path::Path;

use crate::common::Process;
use host::run::closed_loop::Drive;
use host::run::experiment::{Pace, run};
use host::run::fleet::InProcess;
use host::run::host::Controller;
use host::run::orders::Unattended;
use host::run::pilot::Pilot;
use host::run::progress::Quiet;
use host::run::scenario::Scenario;
use host::run::shortfall::Shortfall;
use host::run::summary::Summary;
use link::faults::FaultParameters;
use protocol::time::FleetInstant;
use protocol::units::Volts;
use serde_json::Value;
use tempfile::tempdir;

const SEED: u64 = 3;

fn scenario(more: &str) -> Scenario {
    let text = format!(
        "name = \"t\"\n[structure]\nsize = \"3x1\"\n[[leg]]\nduration_s = 40.0\nvelocity_m_s = [0.03, 0.0]\n\
         heading_rad = 1.5\n[[leg]]\nduration_s = 20.0\nvelocity_m_s = [0.0, 0.03]\nheading_rad = 1.5\n{more}"
    );
    Scenario::parse("t.toml", &text).expect("valid")
}

/// Runs with what becomes of the modules at each time since the start of the first cycle, s.
fn run_with(scenario: &Scenario, fault: &mut dyn FnMut(f64, &mut InProcess)) -> Summary {
    let mut fleet = InProcess::boats(scenario, SEED).expect("valid");
    let mut hook = |now: FleetInstant, pilot: &Pilot, fleet: &mut InProcess| {
        fault(pilot.origin().map_or(-1.0, |origin| now.as_secs_f64() - origin.as_secs_f64()), fleet);
    };
    let drive = Drive { pace: Pace::Simulated, operator: &mut Unattended, hook: &mut hook };
    run(scenario, SEED, &mut fleet, drive, &mut Quiet).expect("it runs").summary
}

/// Module 2 hears and says nothing between two times, s.
fn deaf(from_s: f64, to_s: f64) -> impl FnMut(f64, &mut InProcess) {
    move |t_s, fleet| {
        let loss = if (from_s..to_s).contains(&t_s) { 1.0 } else { 0.0 };
        let parameters = FaultParameters { loss, ..FaultParameters::default() };
        fleet.modules_mut()[1].radio_mut().set_parameters(parameters);
    }
}

fn absent(summary: &Summary) -> Vec<(Option<usize>, u16, String)> {
    let one = |found: &Shortfall| match found {
        Shortfall::Absent { leg, module, reason, .. } => Some((*leg, *module, reason.clone())),
        _ => None,
    };
    summary.shortfalls.iter().filter_map(one).collect()
}

#[test]
fn a_module_that_is_silent_for_a_quarter_of_a_leg_is_named() {
    // The fleet holds with it, and is waited for.
    let patient = "[timing]\njoin_s = 60\n";
    let summary = run_with(&scenario(patient), &mut deaf(10.0, 26.0));
    assert_eq!(absent(&summary), [(Some(1), 2, "it does not answer".to_owned())], "{:?}", summary.shortfalls);
    assert!(summary.complete && summary.failure.is_some(), "{:?}", summary.failure);
    let away_s: f64 = summary.absences.iter().filter(|a| a.module == 2).map(|a| a.time_s).sum();
    // It is missed a second after it was heard last.
    assert!((14.5..16.1).contains(&away_s), "{:?}", summary.absences);
    assert!(summary.legs[0].held_s > 10.0 && summary.legs[1].held_s < 1.0, "{:?}", summary.legs);

    // One that dies for good is named for both legs, and the end of the run too.
    let summary = run_with(&scenario("[timing]\njoin_s = 12\n"), &mut deaf(10.0, f64::INFINITY));
    let complaints = summary.complaints();
    assert!(
        complaints[0].starts_with("ended early, ") && complaints[0].contains("module 2 did not answer"),
        "{complaints:?}"
    );
    assert!(complaints[1].starts_with("leg 1: module 2 took no part for "), "{complaints:?}");
    assert_eq!((complaints.len(), summary.complete), (3, false), "{complaints:?}");

    // A tenth of a leg is in the summary, and no shortfall.
    let summary = run_with(&scenario(patient), &mut deaf(10.0, 14.0));
    assert_eq!(summary.failure, None);
    assert!(summary.absences.iter().any(|absence| absence.module == 2), "{:?}", summary.absences);

    // Where two are enough, the third may be left out.
    let summary = run_with(&scenario("[timing]\nrequire = 2\njoin_s = 60\n"), &mut deaf(10.0, 30.0));
    assert_eq!(absent(&summary), []);
    assert!(summary.absences.iter().any(|absence| absence.module == 2), "{:?}", summary.absences);
}

#[test]
fn a_module_that_refuses_is_named_with_its_reason() {
    let patient = scenario("[timing]\njoin_s = 100\n");
    let summary = run_with(&patient, &mut |t_s, fleet| {
        if t_s >= 8.0 {
            fleet.modules_mut()[2].set_battery(Volts(5.5));
        }
    });
    let absent = absent(&summary);
    assert_eq!(absent.len(), 2, "in both legs: {:?}", summary.shortfalls);
    for (_, module, reason) in absent {
        assert!(module == 3 && reason.contains("low battery"), "module {module}: {reason}");
    }
    assert!(summary.passed() == summary.failure.is_none() && !summary.passed());

    // Or it has stopped: its motor is jammed.
    let summary = run_with(&patient, &mut |t_s, fleet| {
        if t_s >= 8.0 {
            fleet.modules_mut()[0].motor_mut().set_jammed(true);
        }
    });
    let absent = self::absent(&summary);
    assert!(!absent.is_empty(), "{:?}", summary.shortfalls);
    for (_, module, reason) in absent {
        assert!(module == 1 && reason.contains("has stopped: "), "module {module}: {reason}");
    }
}

fn ran(folder: &Path, text: &str) -> (Option<i32>, Vec<String>, String, Value) {
    std::fs::write(folder.join("t.toml"), text).expect("a file");
    let finished = Process::start(folder, &["run", "t.toml", "--out", "o"]).finish();
    let summary = std::fs::read_to_string(folder.join("o/summary.json")).expect("a summary");
    (finished.code, finished.err, finished.out.join("\n"), serde_json::from_str(&summary).expect("JSON"))
}

/// Five modules give 0.19 N; at 0.51 m/s the water takes 5.6 N.
#[test]
fn a_demand_beyond_what_the_structure_can_give_is_told_with_the_attainable_speed() {
    let folder = tempdir().expect("a folder");
    for (structure, leg, least, most) in [
        (
            "picture = \"\"\"\n.#.\n###\n.#.\"\"\"",
            "velocity_m_s = [0.5, 0.1]\nheading_rad = 1.57",
            0.093,
            0.095,
        ),
        // √(0.0382/4.5) along an axis, whatever the number of modules.
        ("size = \"3x2\"", "velocity_m_s = [0.0, -0.12]\nheading_rad = 0.0", 0.0920, 0.0923),
    ] {
        let text = format!(
            "name = \"t\"\n[structure]\n{structure}\n[[leg]]\nduration_s = 60\n{leg}\n[[leg]]\nduration_s = 60\n\
             velocity_m_s = [0, 0.02]\nheading_rad = 0\n"
        );
        let (code, err, out, summary) = ran(folder.path(), &text);
        assert_eq!((code, err.len()), (Some(1), 1), "{err:?}");
        let found = summary["shortfalls"].as_array().expect("a list");
        assert!(found.len() == 1 && found[0]["kind"] == "unattainable" && found[0]["leg"] == 1, "{found:?}");
        let attainable = summary["legs"][0]["attainable_m_s"].as_f64().expect("m/s");
        assert!((least..most).contains(&attainable), "{attainable} m/s");
        let [mx, my] = [0, 1].map(|axis| summary["legs"][0]["mean_m_s"][axis].as_f64().expect("m/s"));
        // What is swum comes near it: nine tenths of the thrust are used.
        let share = f64::hypot(mx, my) / attainable;
        assert!((0.75..1.0).contains(&share), "{share} of it was swum");
        let said = format!("at most {attainable:.3} m/s that way; {:.3} m/s swum", f64::hypot(mx, my));
        assert!(err[0].ends_with(&said) && out.contains(&said), "{err:?} does not say {said:?}:\n{out}");
        std::fs::remove_dir_all(folder.path().join("o")).expect("a folder");
    }
}

/// A share of nothing is none: a demand of zero is missed by so many millimetres a second.
#[test]
fn a_demand_of_zero_has_an_error_with_a_unit() {
    let folder = tempdir().expect("a folder");
    let text = "name = \"t\"\n[structure]\nsize = \"2x2\"\n[[leg]]\nduration_s = 10\nvelocity_m_s = [0, 0]\nheading_rad = 0\n";
    let (code, _, out, summary) = ran(folder.path(), text);
    assert_eq!(code, Some(0), "{out}");
    assert_eq!(summary["legs"][0]["attainable_m_s"], Value::Null);
    let row = out.lines().find(|line| line.trim_start().starts_with("1 ")).expect("a leg");
    let error_mm_s = 1e3 * summary["legs"][0]["velocity_error"].as_f64().expect("m/s");
    assert!(row.contains(&format!("{error_mm_s:.1} mm/s")) && !row.contains('%'), "{row}");
}
