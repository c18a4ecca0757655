//! Errors are named, and end with 1 or 2.

use crate::environment::{BRIDGE, FLOTILLA, Program, domain, folder, port};

fn ends(program: &str, arguments: &[&str], code: i32, part: &str) {
    let folder = folder("errors");
    let (status, said) = Program::start(program, arguments, &folder, &domain()).finish();
    assert_eq!(status.code(), Some(code), "{arguments:?}: {said}");
    assert!(said.contains(part), "{arguments:?}: {said}");
}

#[test]
fn what_is_wrong_is_named() {
    let absent = format!("http://127.0.0.1:{}/#token=1", port());
    ends(BRIDGE, &["bridge", &absent], 1, "no run at 127.0.0.1");
    ends(BRIDGE, &["bridge", "127.0.0.1:4880"], 2, "is no page of a run");
    ends(BRIDGE, &["bridge", &absent, "--namespace", "a b"], 2, "\"a b\" is no namespace");
    ends(BRIDGE, &["bridge", &absent, "--domain", "300"], 2, "300 is not in 0..=232");
    ends(BRIDGE, &["poses", "pose"], 2, "\"pose\" is no topic");
    // What has started it is gone: so is its end of standard input.
    ends(BRIDGE, &["poses", "/boat/pose", "--listen", "127.0.0.1:0", "--attached"], 0, "vrpn 127.0.0.1:");
    ends(BRIDGE, &["--help"], 0, "Example:");
    ends(FLOTILLA, &["probe", "ros2:boat"], 2, "\"boat\" is no topic");
}

#[test]
fn a_program_that_is_missing_is_named_with_how_to_make_it() {
    let folder = folder("missing");
    // Beside this copy there is no `flotilla-ros2`, and in `PATH` neither.
    let alone = folder.join("flotilla");
    std::fs::copy(FLOTILLA, &alone).expect("a copy");
    let mut command = std::process::Command::new(&alone);
    command.args(["probe", "ros2:/boat/pose"]).env("PATH", "").env_remove("FLOTILLA_ROS2");
    let output = command.output().expect("it starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("cargo build --release -p flotilla-ros2"), "{said}");
}
