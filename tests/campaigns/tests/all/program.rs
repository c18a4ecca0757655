//! The program, run to its end, and the campaigns of these tests.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

pub const PROGRAM: &str = env!("CARGO_BIN_EXE_flotilla-campaign-to-run");

/// The file of a campaign of these tests.
pub fn study(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("study").join(name)
}

/// A file among those that the product has for schedulers.
pub fn scheduler(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../host/campaign/schedulers").join(name)
}

/// An empty folder below `target`, the same in every run of the tests.
pub fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("campaigns").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("writable");
    folder
}

/// The program with its arguments.
pub fn program(arguments: &[&dyn AsRef<OsStr>]) -> Command {
    let mut command = Command::new(PROGRAM);
    for argument in arguments {
        command.arg(argument);
    }
    command
}

/// What a program says that ends well.
pub fn said(command: &mut Command) -> String {
    let output = output(command);
    assert!(output.status.success(), "{command:?}: {}\n{}", output.status, both(&output));
    String::from_utf8(output.stdout).expect("UTF-8")
}

pub fn output(command: &mut Command) -> Output {
    command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"))
}

pub fn both(output: &Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    text(&output.stdout) + &text(&output.stderr)
}

/// The rows of the 200 runs, made in one piece on this machine, as a file's bytes.
pub fn whole() -> &'static [u8] {
    static WHOLE: OnceLock<Vec<u8>> = OnceLock::new();
    WHOLE.get_or_init(|| {
        let folder = folder("whole");
        let said = said(&mut program(&[&study("two-hundred.toml"), &"--out", &folder]));
        println!("{said}");
        fs::read(folder.join("rows.parquet")).expect("rows")
    })
}

/// Holds the merged rows in `folder` against those that were made in one piece.
pub fn judge(folder: &Path) {
    let rows = fs::read(folder.join("rows.parquet")).expect("rows");
    assert!(rows == whole(), "{}: other rows than in one piece", folder.display());
}

/// How many rows a journal holds.
pub fn rows(journal: &Path) -> usize {
    let bytes = fs::read(journal).unwrap_or_default();
    bytes.iter().filter(|&&byte| byte == b'\n').count().saturating_sub(1)
}
