//! The rules of the house, held against every source file of the workspace.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use tests::rules::{breaches, test_modules};

/// Files that may be longer than [`LINES_MAX`], and why. Empty at best.
const LONG: [(&str, &str); 0] = [];
const LINES_MAX: usize = 500;

fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().expect("the package has a parent")
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("readable").map(|entry| entry.expect("readable").path()) {
        let name = entry.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        if entry.is_dir() && name != "target" {
            collect(&entry, files);
        } else if name.ends_with(".rs") {
            files.push(entry);
        }
    }
}

/// Every source file of the packages: path below the top, and text.
fn sources() -> Vec<(String, String)> {
    let top = top();
    let mut files = Vec::new();
    ["protocol", "firmware", "host", "tests"]
        .iter()
        .for_each(|package| collect(&top.join(package), &mut files));
    files.sort();
    let read = |path: &PathBuf| {
        let below = path.strip_prefix(&top).expect("below the top").to_str().expect("UTF-8");
        (below.replace('\\', "/"), fs::read_to_string(path).expect("UTF-8"))
    };
    files.iter().map(read).collect()
}

/// Paths, without the ending, of modules that are tests.
fn tests_by_path(sources: &[(String, String)]) -> BTreeSet<String> {
    let mut tests = BTreeSet::new();
    for (file, text) in sources {
        let (folder, name) = file.rsplit_once('/').unwrap_or(("", file));
        let own = match name {
            "mod.rs" | "lib.rs" | "main.rs" => folder.to_owned(),
            _ => file.trim_end_matches(".rs").to_owned(),
        };
        tests.extend(test_modules(text).into_iter().map(|module| format!("{own}/{module}")));
    }
    tests
}

#[test]
fn imports_run_one_way_and_planners_are_pure() {
    let sources = sources();
    let tests = tests_by_path(&sources);
    assert!(
        tests.contains("host/src/modboat/potential_field/planner/tests"),
        "test modules are recognised: {tests:?}"
    );
    let is_test = |file: &str| {
        let path = file.trim_end_matches(".rs");
        tests
            .iter()
            .any(|test| path == test || path.strip_prefix(test).is_some_and(|rest| rest.starts_with('/')))
    };
    let mut looked_at = 0;
    let mut found = Vec::new();
    for (file, text) in sources.iter().filter(|(file, _)| !is_test(file)) {
        looked_at += 1;
        found.extend(breaches(file, text).iter().map(ToString::to_string));
    }
    assert!(looked_at > 60, "only {looked_at} files looked at");
    assert!(found.is_empty(), "{} breaches:\n{}", found.len(), found.join("\n"));
    println!("{looked_at} files keep the import rules");
}

#[test]
fn no_file_is_too_long() {
    let long: Vec<String> = sources()
        .iter()
        .map(|(file, text)| (file, text.lines().count()))
        .filter(|&(file, lines)| lines > LINES_MAX && !LONG.iter().any(|(may, _)| may == file))
        .map(|(file, lines)| format!("{file}:{LINES_MAX}: {lines} lines, split it"))
        .collect();
    assert!(long.is_empty(), "{}", long.join("\n"));
}
