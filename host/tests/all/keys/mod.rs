//! The key file that processes on a radio need, made as a user makes it.

use std::path::Path;

use crate::common::Process;

/// The fleet's key file in the folder of a test.
pub const KEY: &str = "fleet.key";

/// Writes [`KEY`] to `folder`.
pub fn keygen(folder: &Path) {
    let finished = Process::start(folder, &["keygen", "--out", KEY]).finish();
    assert_eq!((finished.code, finished.err.len()), (Some(0), 0), "{finished:?}");
}
