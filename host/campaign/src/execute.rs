//! A shard, run on all cores: row by row into its journal, and from there into its file.
//!
//! Nothing is to be tidied up when the process is killed, at whatever moment: what the journal holds is not run again, and the file
//! comes whole or not at all.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Map, Value};
use thiserror::Error;

use crate::folder::{Folder, Shard};
use crate::journal::{Head, Journal, JournalError};
use crate::table::{Table, TableError};
use crate::work::Work;

/// Why a shard is not done.
#[derive(Debug, Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ExecuteError {
    /// See there.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// See there.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A file that is there is not this shard's.
    #[error("{}: has not the rows of this shard: remove it to have them made", path.display())]
    Rows { path: PathBuf },
}

/// What became of a shard.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Rows that there are.
    pub rows: usize,
    /// Of these, made now.
    pub made: usize,
    /// How long that took.
    pub took: Duration,
    /// Runs that did not do what was asked.
    pub failed: usize,
    /// Runs that could not be begun or went wrong, and the first of them.
    pub errors: usize,
    /// The first of these, in words.
    pub first_error: Option<String>,
}

/// What is told while it goes on.
pub trait Watch: Sync {
    /// Another process runs the shard: its end is waited for.
    fn waits(&self);
    /// So many rows of so many are there.
    fn rows(&self, done: usize, total: usize);
}

/// Runs `shard` of `work` on `jobs` threads.
///
/// # Errors
/// [`ExecuteError`].
pub fn execute(
    work: &dyn Work,
    folder: &Folder,
    shard: Shard,
    jobs: usize,
    watch: &dyn Watch,
) -> Result<Outcome, ExecuteError> {
    let file = folder.file(shard);
    if file.exists() {
        return finished(work, folder, shard);
    }
    let head = Head {
        campaign: work.name().to_owned(),
        fingerprint: folder.manifest.fingerprint.clone(),
        shard: shard.index,
        shards: shard.count,
    };
    let journal = Journal::open(&folder.journal(shard), &head, || watch.waits())?;
    // Another process may have come to the end while this one waited.
    if file.exists() {
        return finished(work, folder, shard);
    }
    let total = shard.runs(work.runs()).count();
    let left: Vec<usize> = shard.runs(work.runs()).filter(|run| !journal.rows().contains_key(run)).collect();
    watch.rows(total - left.len(), total);
    let began = Instant::now();
    let journal = Mutex::new(journal);
    let next = AtomicUsize::new(0);
    let failure = Mutex::new(None);
    let runs = || {
        while let Some(&number) = left.get(next.fetch_add(1, Ordering::Relaxed)) {
            let row = work.row(number);
            // A panic is in no lock: rows are made outside of it.
            let mut journal = journal.lock().unwrap_or_else(PoisonError::into_inner);
            match journal.add(number, row) {
                Ok(()) => watch.rows(journal.rows().len(), total),
                Err(error) => {
                    next.store(left.len(), Ordering::Relaxed);
                    failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                }
            }
        }
    };
    thread::scope(|scope| {
        for _ in 1..jobs.clamp(1, left.len().max(1)) {
            scope.spawn(runs);
        }
        runs();
    });
    if let Some(error) = failure.into_inner().unwrap_or_else(PoisonError::into_inner) {
        return Err(error.into());
    }
    let (rows, held) = journal.into_inner().unwrap_or_else(PoisonError::into_inner).into_rows();
    let took = began.elapsed();
    Table::new(&rows, &folder.varied()).write(&file, folder.format())?;
    held.remove();
    Ok(Outcome { made: left.len(), took, ..told(&rows) })
}

fn told(rows: &BTreeMap<usize, Map<String, Value>>) -> Outcome {
    let is_there = |row: &Map<String, Value>, key: &str| row.get(key).is_some_and(|value| !value.is_null());
    let error = |(run, row): (&usize, &Map<String, Value>)| {
        Some(format!("run {run}: {}", row.get("error")?.as_str()?))
    };
    Outcome {
        rows: rows.len(),
        failed: rows.values().filter(|row| is_there(row, "failure")).count(),
        errors: rows.values().filter(|row| is_there(row, "error")).count(),
        first_error: rows.iter().find_map(error),
        ..Outcome::default()
    }
}

/// A shard that has its file.
fn finished(work: &dyn Work, folder: &Folder, shard: Shard) -> Result<Outcome, ExecuteError> {
    let path = folder.file(shard);
    let table = Table::read(&path)?;
    if !table.runs().eq(shard.runs(work.runs()).map(|run| run as i64)) {
        return Err(ExecuteError::Rows { path });
    }
    // Left behind by a process that was killed between the two.
    let _ = std::fs::remove_file(folder.journal(shard));
    let texts = |name: &str| {
        let column = table.column(name);
        table
            .rows
            .iter()
            .filter(move |row| column.is_some_and(|at| row[at] != crate::cell::Cell::Null))
            .count()
    };
    Ok(Outcome {
        rows: table.rows.len(),
        failed: texts("failure"),
        errors: texts("error"),
        ..Outcome::default()
    })
}
