//! The console in Debian's chromium, driven by `playwright-core`: a fleet is operated, strangers are refused, a log is looked at.
//!
//! The scripts in `pages/` do it and judge it; here the program is started for them. What they saw is printed, and their pictures lie in
//! `target/tmp/browser`.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;

const FLOTILLA: &str = env!("CARGO_BIN_EXE_flotilla-to-browse");

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("browser").join(name);
    std::fs::create_dir_all(&folder).expect("a folder below target");
    folder
}

/// The folder with the packages of the browser's driver; made when it is not there yet.
fn packages() -> &'static Path {
    static PACKAGES: OnceLock<PathBuf> = OnceLock::new();
    PACKAGES.get_or_init(|| {
        let folder = folder("packages");
        let status = Command::new(here().join("set-up")).arg(&folder).status().expect("set-up starts");
        assert!(status.success(), "set-up: {status}");
        folder
    })
}

/// The program with a console, ended with the test.
struct Served {
    program: Child,
    address: String,
}

impl Served {
    fn start(arguments: &[&str], out: &Path) -> Self {
        let mut command = Command::new(FLOTILLA);
        command.args(arguments).current_dir(out).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut program = command.spawn().expect("the program starts");
        let mut lines = BufReader::new(program.stderr.take().expect("is piped")).lines();
        let mut said = Vec::new();
        let address = loop {
            let line = lines.next().unwrap_or_else(|| panic!("no address, but {said:?}")).expect("text");
            match line.find("http://") {
                Some(at) => break line[at..].split_whitespace().next().unwrap_or_default().to_owned(),
                None => said.push(line),
            }
        };
        // What it goes on to say must not fill the pipe.
        std::thread::spawn(move || {
            lines.map_while(Result::ok).for_each(|line| eprintln!("flotilla: {line}"));
        });
        Self { program, address }
    }

    fn browse(&self, script: &str) {
        let packages = packages();
        let output = Command::new("node")
            .args([here().join("pages").join(script), PathBuf::from(&self.address), folder("pictures")])
            .env("FLOTILLA_BROWSER", packages)
            .output()
            .expect("node starts");
        let [out, err] =
            [output.stdout, output.stderr].map(|said| String::from_utf8_lossy(&said).into_owned());
        println!("{script}\n{out}");
        assert!(output.status.success(), "{script}: {}\n{out}{err}", output.status);
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

#[test]
fn a_fleet_is_operated_from_a_browser() {
    packages();
    let out = folder("operate");
    let arguments =
        ["run", "--interactive", "--realtime", "--serve", "127.0.0.1:0", "--seed", "5", "--out", "."];
    let served = Served::start(&arguments, &out);
    served.browse("operate.mjs");
}

#[test]
fn orders_without_the_token_or_from_another_origin_are_refused() {
    packages();
    let out = folder("refuse");
    let arguments =
        ["run", "holonomic-1", "--realtime", "--serve", "127.0.0.1:0", "--seed", "6", "--out", "."];
    let served = Served::start(&arguments, &out);
    served.browse("refuse.mjs");
}

#[test]
fn a_log_is_played_and_scrubbed() {
    packages();
    let out = folder("scrub");
    let made = Command::new(FLOTILLA)
        .args(["run", "holonomic-1", "--seed", "7", "--out", "."])
        .current_dir(&out)
        .output();
    assert!(made.is_ok_and(|output| output.status.success()), "a run to look at");
    let served = Served::start(&["serve", "log.mcap", "--at", "127.0.0.1:0"], &out);
    served.browse("scrub.mjs");
}
