//! Logs of a run and of a reconfiguration, read by what ROS 2's users have: `mcap-ros2-support`, `rosbags` and `rerun`, from PyPI, in an
//! environment of their own below `target`.

use std::ffi::OsStr;
use std::path::Path;

use crate::environment::{python, run, words};

/// Lets `flotilla` do something that leaves `log.mcap` in its folder, and the readers judge that.
fn judged(name: &str, arguments: &[&str]) -> String {
    let flotilla = env!("CARGO_BIN_EXE_flotilla-to-read");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    let [log, tables] = ["log.mcap", "tables"].map(|name| folder.join(name));
    let out = [OsStr::new("--out"), folder.as_os_str()];
    run(flotilla, &[&words(arguments)[..], &out].concat());
    run(flotilla, &[OsStr::new("export"), log.as_os_str(), OsStr::new("--csv"), tables.as_os_str()]);
    let judge = Path::new(env!("CARGO_MANIFEST_DIR")).join("judge.py");
    let said = run(python(), &[judge.as_os_str(), log.as_os_str(), tables.as_os_str()]);
    let said = String::from_utf8(said.stdout).expect("text");
    println!("{name}\n{said}");
    said
}

/// Messages of a topic, by what the readers count.
fn count(said: &str, topic: &str) -> usize {
    let line = said.lines().find(|line| line.split_whitespace().nth(1) == Some(topic));
    let count = line.and_then(|line| line.split_whitespace().next()?.parse().ok());
    count.unwrap_or_else(|| panic!("{topic} is not there:\n{said}"))
}

#[test]
fn the_log_of_a_run_is_read_by_others() {
    let said = judged("run", &["run", "holonomic-1", "--seed", "3", "--loss", "0.1"]);
    // 90 s, in which frames come at 20 Hz, odometry at 10 Hz, tails at 50 Hz, counts at 1 Hz.
    for (topic, least, most) in [
        ("/truth/odom", 895, 902),
        ("/odom", 895, 902),
        ("/tf", 1790, 1802),
        ("/tails", 4490, 4502),
        ("/fix", 10_000, 11_500),
        ("/markers", 530, 550),
        ("/decision", 45, 70),
        ("/module_3/battery", 85, 95),
        ("/diagnostics", 85, 95),
        ("/acknowledgement", 100, 210),
        ("/scenario", 1, 1),
        ("/end", 1, 1),
    ] {
        let count = count(&said, topic);
        assert!((least..=most).contains(&count), "{count} messages of {topic}");
    }
}

#[test]
fn the_log_of_a_reconfiguration_is_read_by_others() {
    let said = judged("reconfigure", &["reconfigure", "i-to-l", "--criterion", "energy"]);
    assert!(
        count(&said, "/robots") > 400 && count(&said, "/robot_3/odom") > 200 && count(&said, "/moves") > 20,
        "{said}"
    );
}
