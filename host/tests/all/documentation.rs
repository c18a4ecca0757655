//! Pictures and blocks of output in the documentation are what the program makes today.
//!
//! Each is made by one command, and compared with what is stored; `FLOTILLA_WRITE_DOCS=1 cargo test -p host --test all documentation::` writes
//! the pictures. `tests/all` refuses to run with that variable. The README's own block is held by `run.rs`, the pictures of the
//! failsafe and of both planners' times by tests of `firmware` and `tests`.

use std::path::{Path, PathBuf};

use crate::common::{Finished, Process};
use crate::cores::all_cores;
use serde_json::Value;
use tempfile::tempdir;

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs")
}

fn flotilla(folder: &Path, arguments: &[&str], input: &str) -> Finished {
    let _cores = all_cores();
    let finished = Process::given(folder, arguments, input);
    assert_eq!((finished.code, finished.err.len()), (Some(0), 0), "{arguments:?}: {finished:?}");
    finished
}

/// The stored picture is the one that was drawn.
fn compare(name: &str, drawn: &Path, command: &str) {
    let stored = docs().join(name);
    let drawn = std::fs::read_to_string(drawn).unwrap_or_else(|error| panic!("{}: {error}", drawn.display()));
    if std::env::var_os("FLOTILLA_WRITE_DOCS").is_some() {
        std::fs::write(&stored, &drawn).expect("writable");
    }
    let text = std::fs::read_to_string(&stored).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert!(
        text == drawn,
        "host/docs/{name} is not what `{command}` draws: run this test with FLOTILLA_WRITE_DOCS=1"
    );
}

/// The text between the first fence that begins with `fence` after `from` and the end of that block.
fn block<'a>(page: &'a str, from: &str, fence: &str) -> &'a str {
    let rest = page.split_once(from).unwrap_or_else(|| panic!("no {from:?}")).1;
    let rest = rest.split_once(fence).unwrap_or_else(|| panic!("no {fence:?} after {from:?}")).1;
    rest.split_once("```").expect("an end").0
}

#[test]
fn pictures_of_a_run_are_those_of_holonomic_4() {
    let folder = tempdir().expect("a folder");
    flotilla(folder.path(), &["run", "holonomic-4", "--out", "o"], "");
    for name in ["trajectory.svg", "phase-space.svg"] {
        compare(name, &folder.path().join("o").join(name), "flotilla run holonomic-4");
    }
}

#[test]
fn picture_and_table_of_a_reconfiguration_are_those_of_the_default() {
    let folder = tempdir().expect("a folder");
    let finished = flotilla(folder.path(), &["reconfigure", "--out", "o"], "");
    compare("reconfiguration.svg", &folder.path().join("o/scene.svg"), "flotilla reconfigure");
    let page = std::fs::read_to_string(docs().join("rovs.md")).expect("a page");
    let shown = block(&page, "# ROVs", "```text\n");
    assert!(shown.lines().count() >= 15, "{shown}");
    for line in shown.lines().filter(|line| line.trim() != "…") {
        assert!(
            finished.out.iter().any(|printed| printed == line),
            "rovs.md: {line:?} is not in {finished:#?}"
        );
    }
}

#[test]
fn the_example_of_a_plan_is_answered_as_shown() {
    let page = std::fs::read_to_string(docs().join("plans.md")).expect("a page");
    let command = block(&page, "# Modboat plans", "```sh\n");
    let request = command.split('\'').nth(1).expect("a request in quotes");
    let folder = tempdir().expect("a folder");
    let finished = flotilla(folder.path(), &["plan"], request);
    let timeless = |text: &str| {
        let mut plan: Value = serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"));
        assert!(plan["solve_us"].take().is_u64(), "{text}");
        plan
    };
    assert_eq!(timeless(block(&page, request, "```json\n")), timeless(&finished.out[0]), "plans.md is old");
}
