//! The folder that a run leaves behind, and the files in it.

use std::fmt::Display;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use runlog::writer::Tap;

use super::Failure;
use crate::run::log::Log;

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

    /// None written yet. The folder is made again if it has gone: what keeps it from being is told of each file.
    pub(super) fn files(&self) -> Files {
        let _ = std::fs::create_dir_all(&self.path);
        Files::default()
    }

    /// The log of a run, begun in it; `tap` gets what is written, too. The folder is there: it was probed.
    pub(super) fn log(&self, name: &str, tap: Option<Box<dyn Tap>>) -> Result<(Log, PathBuf), Failure> {
        let path = self.path.join(name);
        Ok((Log::create_tapped(&path, tap).map_err(Failure::Could)?, path))
    }

    /// A run that was not to be leaves no log and no empty folder.
    pub(super) fn discard(&self, logs: &[PathBuf]) {
        for path in logs {
            let _ = std::fs::remove_file(path);
        }
        if !self.old {
            let _ = std::fs::remove_dir(&self.path);
        }
    }
}

/// Files that were written, and what is to be said of those that were not: a full disk loses a file, not the others.
#[derive(Default)]
pub(super) struct Files {
    /// Their paths, in order.
    pub(super) paths: Vec<PathBuf>,
    /// Of each that could not be written, its name and why.
    pub(super) complaints: Vec<String>,
}

impl Files {
    /// Takes down what became of one.
    pub(super) fn add(&mut self, outcome: Result<PathBuf, impl Display>) {
        match outcome {
            Ok(path) => self.paths.push(path),
            Err(error) => self.complaints.push(error.to_string()),
        }
    }

    /// Takes down what became of a log.
    pub(super) fn log(&mut self, path: PathBuf, failure: Option<String>) {
        self.add(failure.map_or(Ok(path), Err));
    }

    /// Writes a line, or lines, of JSON.
    pub(super) fn json(&mut self, path: PathBuf, text: serde_json::Result<String>) {
        let outcome = text
            .map_err(|error| error.to_string())
            .and_then(|text| std::fs::write(&path, text + "\n").map_err(|error| error.to_string()));
        self.add(match outcome {
            Ok(()) => Ok(path),
            Err(error) => Err(format!("{}: cannot write: {error}", path.display())),
        });
    }
}

fn unwritable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::Bad(format!("cannot write to {}: {error}", path.display()))
}
