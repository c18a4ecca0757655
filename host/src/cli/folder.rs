//! The folder that a run leaves behind.

use std::fmt::Display;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::Failure;

/// Where results go.
pub(super) struct Folder {
    /// Its path.
    pub(super) path: PathBuf,
    /// Whether it was there before this run.
    old: bool,
}

impl Folder {
    /// The one that was named, or else a new one for this run below `runs`.
    pub(super) fn of(named: Option<&Path>, run: &str) -> Result<Self, Failure> {
        named.map_or_else(|| Self::unused(Path::new("runs"), run), Self::named)
    }

    /// Writes a value as JSON into the file `name`.
    pub(super) fn write(&self, name: &str, value: &impl Serialize) -> Result<PathBuf, Failure> {
        let path = self.path.join(name);
        let failed = |error: &dyn Display| Failure::Could(format!("{}: {error}", path.display()));
        let text = serde_json::to_string_pretty(value).map_err(|error| failed(&error))?;
        std::fs::write(&path, text + "\n").map_err(|error| failed(&error))?;
        Ok(path)
    }

    /// `path`, made if need be.
    fn named(path: &Path) -> Result<Self, Failure> {
        let old = path.exists();
        std::fs::create_dir_all(path).map_err(|error| unwritable(path, &error))?;
        Self { path: path.to_owned(), old }.probed()
    }

    /// `parent/name`, or `name-2`, `name-3`, … if that is taken: no run overwrites another, not even one that
    /// begins at the same moment.
    fn unused(parent: &Path, name: &str) -> Result<Self, Failure> {
        let mut path = parent.join(name);
        std::fs::create_dir_all(parent).map_err(|error| unwritable(&path, &error))?;
        for number in 2_u32.. {
            match std::fs::create_dir(&path) {
                Ok(()) => break,
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                    path = parent.join(format!("{name}-{number}"));
                }
                Err(error) => return Err(unwritable(&path, &error)),
            }
        }
        Self { path, old: false }.probed()
    }

    /// Makes sure that files can be written.
    fn probed(self) -> Result<Self, Failure> {
        let probe = self.path.join(".flotilla");
        std::fs::write(&probe, b"")
            .and_then(|()| std::fs::remove_file(&probe))
            .map_err(|error| unwritable(&self.path, &error))?;
        Ok(self)
    }

    /// A run that was not to be leaves no empty folder.
    pub(super) fn discard(&self) {
        if !self.old {
            let _ = std::fs::remove_dir(&self.path);
        }
    }
}

fn unwritable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::Bad(format!("cannot write to {}: {error}", path.display()))
}
