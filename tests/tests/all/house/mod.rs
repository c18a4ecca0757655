//! The rules of the house, held against every source file of the workspace.

use std::fs;
use std::path::{Path, PathBuf};

mod crates;
mod imports;
mod words;

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

/// Files of a crate's library: path below `src`, and text.
fn crate_files(name: &str) -> Vec<(String, String)> {
    let folder = match name {
        "host" | "protocol" | "firmware" => name.to_owned(),
        "images" | "plant" => format!("firmware/{name}"),
        // Their folders have names that other packages of crates.io have.
        "runlog" => "host/log".to_owned(),
        "runconsole" => "host/console".to_owned(),
        "flotilla-ros2" => "host/ros2".to_owned(),
        "flotilla-python" => "host/python".to_owned(),
        _ => format!("host/{name}"),
    };
    let start = format!("{folder}/src/");
    let below = |(file, text): (String, String)| Some((file.strip_prefix(&start)?.to_owned(), text));
    sources().into_iter().filter_map(below).collect()
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

#[test]
fn no_two_files_import_each_other() {
    let mut circles = Vec::new();
    for name in crates::names() {
        circles.extend(imports::circles(&crate_files(name)).into_iter().map(|circle| (name, circle)));
    }
    assert!(circles.is_empty(), "{circles:#?}");
}
