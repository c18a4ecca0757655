//! The folder that a run leaves behind.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::Failure;

/// Where results go.
pub(super) struct Folder {
    /// Its path.
    pub(super) path: PathBuf,
    /// Whether it was there before this run.
    old: bool,
}

impl Folder {
    /// `path`, made if need be.
    pub(super) fn named(path: &Path) -> Result<Self, Failure> {
        let old = path.exists();
        std::fs::create_dir_all(path).map_err(|error| unwritable(path, &error))?;
        Self { path: path.to_owned(), old }.probed()
    }

    /// `parent/name`, or `name-2`, `name-3`, … if that is taken: no run overwrites another, not even one that
    /// begins at the same moment.
    pub(super) fn unused(parent: &Path, name: &str) -> Result<Self, Failure> {
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
