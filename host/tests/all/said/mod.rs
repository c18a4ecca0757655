//! Output and files of a `flotilla` run, for tests that run it to its end.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Output;

use crate::common::is_progress;

/// As text.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

/// What was said on standard output by one that did well.
#[track_caller]
pub fn done(output: &Output) -> String {
    let complains = text(&output.stderr).lines().any(|line| !is_progress(line));
    assert!(output.status.success() && !complains, "{output:?}");
    text(&output.stdout)
}

/// The one line with which `flotilla` refuses, without its first word.
#[track_caller]
pub fn refused(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(output.stdout.is_empty(), "{output:?}");
    let said = text(&output.stderr);
    assert_eq!(said.lines().count(), 1, "{said}");
    let line = said.strip_suffix('\n').expect("a whole line");
    line.strip_prefix("flotilla: ").expect("says who speaks").to_owned()
}

/// The permission bits of a file.
pub fn mode(path: &Path) -> u32 {
    fs::metadata(path).expect("a file").permissions().mode() & 0o7777
}
