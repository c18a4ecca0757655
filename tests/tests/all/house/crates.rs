//! Which crate of the workspace depends on which, by Cargo's own metadata, and what crates keep their hands off.

use std::collections::BTreeMap;
use std::process::Command;

use serde_json::Value;

/// Crates of the product, each with those that it depends on.
const CRATES: [(&str, &[&str]); 24] = [
    ("protocol", &[]),
    ("firmware", &["protocol"]),
    ("plant", &[]),
    ("images", &[]),
    ("quantity", &[]),
    ("reader", &[]),
    ("grid", &[]),
    ("pose", &[]),
    ("runlog", &[]),
    ("runconsole", &["runlog"]),
    ("flotilla-ros2", &["pose", "runlog"]),
    ("modboat", &["quantity"]),
    ("identify", &["modboat", "quantity", "reconfiguration", "rov"]),
    ("reconfiguration", &["quantity", "reader"]),
    ("rov", &["grid", "quantity", "reconfiguration"]),
    // Of a reconfiguration the judge knows the data, and nothing of the planner that it judges.
    ("judge", &["reconfiguration"]),
    ("record", &["modboat", "reconfiguration"]),
    ("plot", &["firmware", "grid", "modboat", "protocol", "quantity", "reconfiguration", "record"]),
    ("link", &["protocol", "quantity", "reader"]),
    (
        "sim",
        &["firmware", "modboat", "plant", "pose", "protocol", "quantity", "reconfiguration", "record", "rov"],
    ),
    (
        "host",
        &[
            "firmware",
            "grid",
            "identify",
            "images",
            "judge",
            "link",
            "modboat",
            "plot",
            "pose",
            "protocol",
            "quantity",
            "reader",
            "reconfiguration",
            "record",
            "rov",
            "runconsole",
            "runlog",
            "sim",
        ],
    ),
    // Parquet comes into the build with it, and into no other.
    ("campaign", &["host", "modboat", "plot", "reader"]),
    // Threads of its own, and nothing of Python.
    ("environment", &["firmware", "host", "link", "modboat", "protocol", "quantity", "record", "sim"]),
    // And Python with this one.
    (
        "flotilla-python",
        &[
            "environment",
            "grid",
            "host",
            "identify",
            "link",
            "modboat",
            "reader",
            "reconfiguration",
            "record",
            "rov",
            "runlog",
        ],
    ),
];

/// Crates that only compute.
const PURE: [&str; 7] = ["grid", "identify", "judge", "modboat", "quantity", "reconfiguration", "rov"];
/// What they may use beside each other: none of it has a clock, a socket, a thread or a console.
const PURE_MAY_USE: [&str; 5] = ["nalgebra", "rand", "reader", "serde", "thiserror"];
/// Modules of the standard library, and macros, that they do without.
const IMPURE: [&str; 14] = [
    "reader::file",
    "std::{",
    "std::env",
    "std::fs",
    "std::io",
    "std::net",
    "std::process",
    "std::thread",
    "std::time",
    "print!",
    "println!",
    "eprint!",
    "eprintln!",
    "dbg!",
];
/// Crates that open sockets.
const SOCKETS: [&str; 5] = ["flotilla-ros2", "host", "link", "pose", "runconsole"];

/// Crates of the product.
pub fn names() -> impl Iterator<Item = &'static str> {
    CRATES.iter().map(|(name, _)| *name)
}

/// Packages of the workspace with the dependencies of their products, not of their tests.
fn dependencies() -> BTreeMap<String, Vec<String>> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--format-version", "1", "--offline"])
        .current_dir(super::top())
        .output()
        .expect("Cargo starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let name = |value: &Value| value["name"].as_str().expect("a name").to_owned();
    let packages = metadata["packages"].as_array().expect("packages").iter();
    packages
        .map(|package| {
            let all = package["dependencies"].as_array().expect("dependencies").iter();
            let mut products: Vec<String> = all.filter(|one| one["kind"].is_null()).map(name).collect();
            products.sort_unstable();
            (name(package), products)
        })
        .collect()
}

#[test]
fn crates_depend_on_each_other_as_listed() {
    let dependencies = dependencies();
    for (name, listed) in CRATES {
        let found: Vec<&str> = dependencies[name]
            .iter()
            .map(String::as_str)
            .filter(|dependency| dependencies.contains_key(*dependency))
            .collect();
        assert_eq!(found, listed, "{name}");
    }
    let listed = |name: &str| CRATES.iter().any(|(listed, _)| *listed == name);
    let unlisted: Vec<&String> = dependencies.keys().filter(|name| !listed(name)).collect();
    assert_eq!(
        unlisted,
        ["browser", "campaigns", "mocap", "model", "python", "qemu", "readers", "ros2", "tests"],
        "packages of tests alone"
    );
}

#[test]
fn planners_have_no_clock_socket_thread_or_console() {
    let dependencies = dependencies();
    for name in PURE {
        for dependency in &dependencies[name] {
            let known = PURE.iter().chain(&PURE_MAY_USE).any(|known| *known == dependency);
            assert!(known, "{name} depends on {dependency}");
        }
        let files = super::crate_files(name);
        assert!(!files.is_empty(), "{name}");
        for (file, text) in super::imports::without_test_files(&files) {
            for word in IMPURE {
                let names = text
                    .match_indices(word)
                    .any(|(at, _)| !text[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_'));
                assert!(!names, "{name}/src/{file} names {word}");
            }
        }
    }
}

#[test]
fn sockets_are_opened_by_the_link_motion_capture_the_console_and_the_program_alone() {
    let mut met = Vec::new();
    for (name, _) in CRATES {
        let named = super::crate_files(name).into_iter().find(|(_, text)| {
            ["std::net", "UdpSocket", "TcpStream", "TcpListener"].iter().any(|word| text.contains(word))
        });
        met.extend(named.map(|_| name));
    }
    met.sort_unstable();
    assert_eq!(met, SOCKETS);
}
