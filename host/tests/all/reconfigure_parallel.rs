//! `flotilla reconfigure` with robots that move at once, and with a goal that is to be found.

use std::path::Path;

use serde_json::Value;
use tempfile::tempdir;

use crate::common::{Finished, Process};
use crate::cores::all_cores;

/// Three in a row, to a row 3 m ahead.
const ROW: &str = "name = \"row\"\n\n[[robot]]\nid = 1\nvehicle = \"bluerov1\"\nstart = [0.0, 0.0, 0.0, 0.0]\n[[robot]]\n\
                   id = 2\nvehicle = \"bluerov1\"\nstart = [0.0, 0.33, 0.0, 0.0]\n[[robot]]\nid = 3\n\
                   vehicle = \"bluerov1\"\nstart = [0.0, 0.66, 0.0, 0.0]\ncapabilities = [\"sonar\"]\n[[slot]]\n\
                   pose = [3.0, 0.0, 0.0, 0.0]\n[[slot]]\npose = [3.0, 0.33, 0.0, 0.0]\n[[slot]]\n\
                   pose = [3.0, 0.66, 0.0, 0.0]\n";

fn reconfigure(folder: &Path, arguments: &[&str], input: &str) -> Finished {
    let all: Vec<&str> = ["reconfigure", "row.toml"].iter().chain(arguments).copied().collect();
    let _cores = all_cores();
    Process::given(folder, &all, input)
}

fn plan(finished: &Finished) -> Value {
    assert_eq!((finished.code, finished.out.len()), (Some(0), 1), "{finished:?}");
    serde_json::from_str(&finished.out[0]).expect("JSON")
}

#[test]
fn moves_overlap_where_that_is_asked_for_and_the_plan_is_kept() {
    let folder = tempdir().expect("a folder");
    std::fs::write(folder.path().join("row.toml"), ROW).expect("a file");
    let energy = ["--criterion", "energy", "--json"];
    let one_by_one = plan(&reconfigure(folder.path(), &energy, ""));
    assert!(one_by_one.get("intervals").is_none(), "{one_by_one}");
    let finished = reconfigure(folder.path(), &[&energy[..], &["--parallel", "time"]].concat(), "");
    let together = plan(&finished);
    let figure = |plan: &Value, key: &str| plan[key].as_f64().expect(key);
    assert!(figure(&together, "time_s") < 0.7 * figure(&one_by_one, "time_s"), "{together}");
    assert!(figure(&together, "energy_total_j") <= figure(&one_by_one, "energy_total_j") * (1.0 + 1e-6));
    assert!(together["intervals"].as_array().is_some_and(|intervals| intervals.len() > 1));
    let judged = reconfigure(folder.path(), &["--verify", "-"], &finished.out[0]);
    assert_eq!(judged.code, Some(0), "{judged:?}");
    // The same with an interval longer than to the next event is refused.
    let mut spoilt = together;
    spoilt["intervals"][0]["duration_s"] = 1e3.into();
    let refused = reconfigure(folder.path(), &["--verify", "-"], &spoilt.to_string());
    assert_eq!(refused.code, Some(1), "{refused:?}");
    for wrong in [
        &["--parallel", "time", "--manner", "paper"][..],
        &["--parallel", "time", "--weight", "-1"],
        &["--weight", "1"],
    ] {
        let finished = reconfigure(folder.path(), &[&energy[..], wrong].concat(), "");
        assert_eq!(finished.code, Some(2), "{wrong:?}: {finished:?}");
    }
}

#[test]
fn a_goal_is_found_for_a_task() {
    let folder = tempdir().expect("a folder");
    std::fs::write(folder.path().join("row.toml"), ROW).expect("a file");
    let asked = |task: &str| {
        std::fs::write(folder.path().join("task.toml"), task).expect("a file");
        reconfigure(folder.path(), &["--criterion", "energy", "--task", "task.toml", "--json"], "")
    };
    // A column one robot wide, across the row.
    let column = "[passage]\nheading_rad = 0.0\nwidth_m = 0.4\nheight_m = 0.3\n";
    let plan = plan(&asked(column));
    let slots = plan["slots"].as_array().expect("slots");
    assert!(
        slots.len() == 3 && slots.iter().all(|slot| slot[1].as_f64().is_some_and(|y| y.abs() < 0.04)),
        "{plan}"
    );
    let incapable = asked("[[service]]\ncapability = \"drill\"\nplace_m = [0.0, 0.0, 0.0]\nwithin_m = 0.1\n");
    assert_eq!(incapable.code, Some(2), "{incapable:?}");
    let nowhere = asked("[[service]]\ncapability = \"sonar\"\nplace_m = [9.0, 0.0, 0.0]\nwithin_m = 0.1\n");
    assert_eq!(nowhere.code, Some(1), "{nowhere:?}");
    let misspelt = asked("[passage]\nheading = 0.0\n");
    assert_eq!(misspelt.code, Some(2), "{misspelt:?}");
}
