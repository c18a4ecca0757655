//! The live stream of a run, followed by `websockets` and decoded by `mcap-ros2-support`, from PyPI: what comes is what the log has.

use std::ffi::OsStr;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

use crate::environment::{python, run};

#[test]
fn the_stream_of_a_run_is_its_log() {
    let flotilla = env!("CARGO_BIN_EXE_flotilla-to-read");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("stream");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    let scenario = "name = \"short\"\n[structure]\nsize = \"3x1\"\n[[leg]]\nduration_s = 12\nvelocity_m_s = [0.04, 0]\n\
                    heading_rad = 1.5\n";
    std::fs::write(folder.join("short.toml"), scenario).expect("a file");
    // It is made before there is something to follow.
    let python = python();
    let arguments = ["run", "short.toml", "--serve", "127.0.0.1:0", "--out", "results"];
    let mut served = Command::new(flotilla);
    served.args(arguments).current_dir(&folder).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut served = served.spawn().expect("it starts");
    let said = BufReader::new(served.stderr.take().expect("a pipe")).lines().map_while(Result::ok);
    let url = said.map(|line| line.strip_prefix("the page: ").map(str::to_owned)).find_map(|url| url);
    let url = url.expect("an address");
    let (judge, log) =
        (Path::new(env!("CARGO_MANIFEST_DIR")).join("stream.py"), folder.join("results/log.mcap"));
    let counted = run(python, &[judge.as_os_str(), OsStr::new(&url), log.as_os_str()]);
    assert!(served.wait().expect("a child").success());
    let counted = String::from_utf8(counted.stdout).expect("text");
    println!("{counted}");
    let count = |topic: &str| -> usize {
        let line = counted.lines().find(|line| line.ends_with(&format!(" {topic}")));
        line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(0)
    };
    assert!(count("/tails") > 300 && count("/odom") > 60 && count("/scenario") == 1, "{counted}");
}
