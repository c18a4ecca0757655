//! The table of what the firmware takes, `firmware/boards/costs.md`: what is measured is compared with it.
//!
//! With `FLOTILLA_WRITE_DOCS=1` the numbers there are replaced instead. Its text is left as it is.

use std::path::{Path, PathBuf};

/// Where the table is.
fn path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../firmware/boards/costs.md")
}

/// Holds `measured` against the numbers in the line of the table that begins with `what`: each may differ by the share `tolerance`.
///
/// # Panics
/// If there is no such line, or if it says something else.
pub fn compare(what: &str, measured: &[u64], tolerance: f64) {
    let path = path();
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let head = format!("| {what} |");
    let line = text.lines().find(|line| line.starts_with(&head));
    let line = line.unwrap_or_else(|| panic!("{}: no line begins with {head:?}", path.display()));
    let kept: Vec<u64> = line[head.len()..].split('|').filter_map(|cell| cell.trim().parse().ok()).collect();
    assert_eq!(kept.len(), measured.len(), "{}: {line}", path.display());
    println!("{what}: {measured:?}");
    if std::env::var_os("FLOTILLA_WRITE_DOCS").is_some() {
        let cells: Vec<String> = measured.iter().map(u64::to_string).collect();
        let new = format!("{head} {} |", cells.join(" | "));
        std::fs::write(&path, text.replace(line, &new)).expect("writable");
        return;
    }
    for (&now, &then) in measured.iter().zip(&kept) {
        // A few more or less are nothing, whatever their share.
        let near = now.abs_diff(then) <= 10 || now.abs_diff(then) as f64 <= tolerance * then as f64;
        assert!(
            near,
            "{what}: {measured:?} for {kept:?} in {}: FLOTILLA_WRITE_DOCS=1 rewrites it",
            path.display()
        );
    }
}
