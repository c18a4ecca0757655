//! An environment with the readers in it, below `target`, and programs that run to their end.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// Runs a program to its end, which must be good.
pub fn run(program: impl AsRef<OsStr>, arguments: &[&OsStr]) -> Output {
    let mut command = Command::new(program);
    command.args(arguments);
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let said = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(
        output.status.success(),
        "{command:?}: {}\n{}{}",
        output.status,
        said(&output.stdout),
        said(&output.stderr)
    );
    output
}

pub fn words<'a>(words: &'a [&'a str]) -> Vec<&'a OsStr> {
    words.iter().map(OsStr::new).collect()
}

/// The Python of an environment with the readers in it; made when they are not there yet.
pub fn python() -> &'static Path {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| {
        let wanted = Path::new(env!("CARGO_MANIFEST_DIR")).join("requirements.txt");
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("readers");
        let (python, done) = (folder.join("bin/python"), folder.join("requirements.txt"));
        let text = std::fs::read(&wanted).expect("it is part of this package");
        if std::fs::read(&done).is_ok_and(|installed| installed == text) {
            return python;
        }
        let made = Command::new("python3").args(["-m", "venv", "--clear"]).arg(&folder).output();
        if !made.is_ok_and(|output| output.status.success()) {
            let root = Command::new("id").arg("-u").output().is_ok_and(|output| output.stdout == b"0\n");
            let install = "apt-get update && DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends python3-venv";
            let (shell, lead) = if root { ("sh", vec!["-c"]) } else { ("sudo", vec!["sh", "-c"]) };
            run(shell, &words(&[&lead[..], &[install]].concat()));
            run("python3", &[OsStr::new("-m"), OsStr::new("venv"), OsStr::new("--clear"), folder.as_os_str()]);
        }
        let install = words(&["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r"]);
        run(&python, &[&install[..], &[wanted.as_os_str()]].concat());
        std::fs::write(&done, text).expect("writes");
        python
    })
}
