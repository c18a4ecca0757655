//! The journal of a shard: rows as they come, one line of JSON each, safe on the disk before the next.
//!
//! ```text
//! {"campaign":"…","fingerprint":"…","shard":3,"shards":8}
//! {"run":2,"row":{…}}
//! ```
//!
//! A process that is killed leaves whole lines, and at most one that is torn: the next one drops that and goes on behind the others.
//! The lock on the file is the process's, and ends with it: two processes never write to one journal, the second waits.
//!
//! Limits: on a network file system the lock is as good as that system's.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use thiserror::Error;

/// Why a journal cannot be used.
#[derive(Debug, Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum JournalError {
    /// Reading or writing failed.
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: std::io::Error },
    /// It is not of this campaign.
    #[error("{}: is of another campaign, or of an earlier text of this one: name another folder by --out, or remove it", path.display())]
    Other { path: PathBuf },
    /// A line in its midst is none of its own.
    #[error("{}:{line}: is no row: {reason}", path.display())]
    Line { path: PathBuf, line: usize, reason: String },
}

/// What a journal is of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Head {
    /// The campaign's name.
    pub campaign: String,
    /// See [`Study::fingerprint`](crate::study::Study::fingerprint).
    pub fingerprint: String,
    /// Which shard, from 1.
    pub shard: usize,
    /// Of how many.
    pub shards: usize,
}

#[derive(Serialize, Deserialize)]
struct Line {
    run: usize,
    row: Map<String, Value>,
}

/// See the module's documentation.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    rows: BTreeMap<usize, Map<String, Value>>,
}

impl Journal {
    /// Opens the journal at `path`, or begins it. `waits` is called once if another process has it, whose end is waited for.
    ///
    /// # Errors
    /// [`JournalError`].
    pub fn open(path: &Path, head: &Head, waits: impl FnOnce()) -> Result<Self, JournalError> {
        let failed = |source| JournalError::File { path: path.to_owned(), source };
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .map_err(failed)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                waits();
                file.lock().map_err(failed)?;
            }
            Err(TryLockError::Error(source)) => return Err(failed(source)),
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(failed)?;
        // What follows the last end of a line was torn.
        let whole = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
        file.set_len(whole as u64).map_err(failed)?;
        file.seek(SeekFrom::Start(whole as u64)).map_err(failed)?;
        let mut rows = BTreeMap::new();
        let mut lines = bytes[..whole].split_inclusive(|&byte| byte == b'\n').enumerate();
        let Some((_, first)) = lines.next() else {
            let mut journal = Self { path: path.to_owned(), file, rows };
            journal.append(head)?;
            sync_folder(path).map_err(failed)?;
            return Ok(journal);
        };
        if serde_json::from_slice::<Head>(first).ok().as_ref() != Some(head) {
            return Err(JournalError::Other { path: path.to_owned() });
        }
        for (index, line) in lines {
            let Line { run, row } = serde_json::from_slice(line).map_err(|error| JournalError::Line {
                path: path.to_owned(),
                line: index + 1,
                reason: error.to_string(),
            })?;
            rows.entry(run).or_insert(row);
        }
        Ok(Self { path: path.to_owned(), file, rows })
    }

    /// The rows that are there, by the numbers of their runs.
    #[must_use]
    pub fn rows(&self) -> &BTreeMap<usize, Map<String, Value>> {
        &self.rows
    }

    /// The same, of a journal that has done its work.
    #[must_use]
    pub fn into_rows(self) -> (BTreeMap<usize, Map<String, Value>>, Held) {
        (self.rows, Held { _file: self.file, path: self.path })
    }

    /// Adds the row of `run`. When this comes back it is on the disk.
    ///
    /// # Errors
    /// [`JournalError::File`].
    pub fn add(&mut self, run: usize, row: Map<String, Value>) -> Result<(), JournalError> {
        let line = Line { run, row };
        self.append(&line)?;
        self.rows.entry(run).or_insert(line.row);
        Ok(())
    }

    fn append(&mut self, line: &impl Serialize) -> Result<(), JournalError> {
        let text = serde_json::to_string(line).map_err(std::io::Error::other);
        let written = text.and_then(|text| {
            self.file.write_all(format!("{text}\n").as_bytes())?;
            self.file.sync_data()
        });
        written.map_err(|source| JournalError::File { path: self.path.clone(), source })
    }
}

/// A journal that is still locked.
#[derive(Debug)]
pub struct Held {
    _file: File,
    path: PathBuf,
}

impl Held {
    /// Removes it: its rows are elsewhere.
    pub fn remove(self) {
        // One that stays is removed by the next process.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Makes the name of a file that is new in its folder as safe as the file itself.
pub fn sync_folder(path: &Path) -> std::io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    File::open(folder)?.sync_all()
}

/// Writes a file whole: as `path` with `.new` behind it, to the disk, and then under its own name. What a process that is killed leaves
/// behind the next one overwrites.
pub fn replace(path: &Path, write: impl FnOnce(&mut File) -> std::io::Result<()>) -> std::io::Result<()> {
    replace_by(path, ".new", write)
}

/// The same by a name of its own, for what several processes write at once.
pub fn replace_by(
    path: &Path,
    end: &str,
    write: impl FnOnce(&mut File) -> std::io::Result<()>,
) -> std::io::Result<()> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(end);
    let new = path.with_file_name(name);
    let written = File::create(&new).and_then(|mut file| {
        write(&mut file)?;
        file.sync_all()
    });
    let done = written.and_then(|()| std::fs::rename(&new, path)).and_then(|()| sync_folder(path));
    done.inspect_err(|_| drop(std::fs::remove_file(&new)))
}

#[cfg(test)]
mod tests;
