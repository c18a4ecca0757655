//! The table of distances through the program: asked for, kept, found again, and done without a place to keep it.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Two amplitudes only, so that the table takes a moment.
const SCENARIO: &str = r#"
name = "table"
structure = { size = "3x1" }
modboat = { amplitude_min_rad = 2.5, amplitude_max_rad = 2.6 }
planner = { kind = "potential-field", distance = "table" }

[[leg]]
duration_s = 6.0
velocity_m_s = [0.04, 0.0]
heading_rad = 1.5707963267948966
"#;

const REQUESTS: &str = r#"{"cells":[[0,0],[1,0],[2,0]],"demand":{"fx_n":0.1,"fy_n":0.0,"tau_nm":0.0},"tail_rad":null}
{"cells":[[0,0],[1,0]],"demand":{"fx_n":0.0,"fy_n":0.03,"tau_nm":0.001},"tail_rad":[1.5,1.5]}
"#;

fn flotilla(folder: &Path, cache: &Path, arguments: &[&str]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_flotilla"))
        .args(arguments)
        .current_dir(folder)
        .env("XDG_CACHE_HOME", cache)
        .env("TMPDIR", folder.join("temporary"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(REQUESTS.as_bytes()).unwrap();
    child.wait_with_output().unwrap()
}

fn files(folder: &Path) -> Vec<std::path::PathBuf> {
    fs::read_dir(folder).map_or(Vec::new(), |entries| entries.map(|entry| entry.unwrap().path()).collect())
}

/// The answers without the time they took.
fn plans(output: &Output) -> Vec<serde_json::Value> {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let lines = String::from_utf8_lossy(&output.stdout).into_owned();
    let plan = |line: &str| {
        let mut plan: serde_json::Value = serde_json::from_str(line).unwrap();
        plan.as_object_mut().unwrap().remove("solve_us");
        plan
    };
    lines.lines().map(plan).collect()
}

#[test]
fn the_table_is_kept_and_found_again() {
    let place = tempfile::tempdir().unwrap();
    let (folder, cache) = (place.path(), place.path().join("cache"));
    fs::write(folder.join("table.toml"), SCENARIO).unwrap();
    let first = plans(&flotilla(folder, &cache, &["plan", "--scenario", "table.toml"]));
    assert!(first.iter().all(|plan| plan["outcome"] == "planned"), "{first:?}");
    let kept = files(&cache.join("flotilla"));
    let [path] = &kept[..] else { panic!("one table expected: {kept:?}") };
    let written = fs::metadata(path).unwrap().modified().unwrap();
    assert_eq!(plans(&flotilla(folder, &cache, &["plan", "--scenario", "table.toml"])), first);
    // A run takes the same table.
    let run = flotilla(folder, &cache, &["run", "table.toml", "--json"]);
    let summary: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    assert!(summary["cycles"]["planned"].as_u64().unwrap() > 0, "{summary}");
    assert_eq!(files(&cache.join("flotilla")), kept);
    assert_eq!(fs::metadata(path).unwrap().modified().unwrap(), written);
    // The regions themselves find cycles of their own.
    fs::write(folder.join("direct.toml"), SCENARIO.replace("\"table\" }", "\"direct\" }")).unwrap();
    assert_ne!(plans(&flotilla(folder, &cache, &["plan", "--scenario", "direct.toml"])), first);
}

#[test]
fn a_cache_that_cannot_be_written_is_no_obstacle() {
    let place = tempfile::tempdir().unwrap();
    let (folder, cache) = (place.path(), place.path().join("a-file"));
    fs::write(folder.join("table.toml"), SCENARIO).unwrap();
    fs::write(&cache, b"").unwrap();
    // The folder for temporary files steps in.
    let first = plans(&flotilla(folder, &cache, &["plan", "--scenario", "table.toml"]));
    let temporary = folder.join("temporary");
    assert_eq!(files(&temporary.join("flotilla")).len(), 1);
    // With that gone too, there is no place, and a plan all the same.
    fs::remove_dir_all(&temporary).unwrap();
    fs::write(&temporary, b"").unwrap();
    assert_eq!(plans(&flotilla(folder, &cache, &["plan", "--scenario", "table.toml"])), first);
}
