//! Tables of distances in files: read, or else generated on all cores and written.
//!
//! A file is written beside its place and moved there, so that a reader never meets half of one.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use modboat::distance_table::DistanceTable;
use modboat::parameters::Parameters;
use thiserror::Error;

/// A table that could not be kept.
#[derive(Debug, Error)]
pub enum TableError {
    /// The folder cannot be made or the file not be written.
    #[error("{}: cannot keep the DoC table: {source}", path.display())]
    Write {
        /// File or folder.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}

/// Called with the values done and the values in all, from any thread.
pub type Count<'a> = &'a (dyn Fn(u64, u64) + Sync);

/// Reads the table of these parameters from the first of `folders` that has it, or else generates it and keeps it in the
/// first that takes it. With the table comes why no folder took it, if none did.
pub fn load_or_generate(
    folders: &[PathBuf],
    parameters: &Parameters,
    count: Count<'_>,
) -> (DistanceTable, Option<TableError>) {
    let name = DistanceTable::file_name(parameters);
    let read = |folder: &PathBuf| DistanceTable::decode(&fs::read(folder.join(&name)).ok()?, parameters);
    if let Some(table) = folders.iter().find_map(read) {
        return (table, None);
    }
    let table = generate(parameters, count);
    let bytes = table.encode(parameters);
    let mut error = None;
    for folder in folders {
        match keep(folder, &name, &bytes) {
            Ok(()) => return (table, None),
            Err(refusal) => error = error.or(Some(refusal)),
        }
    }
    (table, error)
}

/// Generates the table on all available cores.
fn generate(parameters: &Parameters, count: Count<'_>) -> DistanceTable {
    DistanceTable::generate_with(parameters, |rows| {
        let total: usize = rows.iter().map(|row| row.len()).sum();
        let rows = Mutex::new(rows.into_iter());
        let done = AtomicU64::new(0);
        let work = || {
            // The lock is held for as long as it takes to pick the next row.
            let next = || rows.lock().ok().and_then(|mut rows| rows.next());
            while let Some(row) = next() {
                let length = row.len() as u64;
                row.compute();
                count(done.fetch_add(length, Ordering::Relaxed) + length, total as u64);
            }
        };
        let workers = thread::available_parallelism().map_or(1, usize::from);
        thread::scope(|scope| (0..workers).for_each(|_| drop(scope.spawn(work))));
    })
}

fn keep(folder: &Path, name: &str, bytes: &[u8]) -> Result<(), TableError> {
    // A name of its own for each writer, so that two of them never share a half-written file.
    static WRITERS: AtomicU64 = AtomicU64::new(0);
    let writer = WRITERS.fetch_add(1, Ordering::Relaxed);
    let path = folder.join(name);
    let draft = path.with_extension(format!("{}-{writer}.draft", std::process::id()));
    let kept = fs::create_dir_all(folder)
        .and_then(|()| fs::write(&draft, bytes))
        .and_then(|()| fs::rename(&draft, &path));
    kept.map_err(|source| {
        // The draft may not exist; what matters is the error that came first.
        let _ = fs::remove_file(&draft);
        TableError::Write { path, source }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two amplitudes only, so that a table takes a moment.
    fn small() -> Parameters {
        Parameters { amplitude_min_rad: 0.9, amplitude_max_rad: 1.0, ..Parameters::default() }
    }

    #[test]
    fn a_table_on_all_cores_is_the_one_on_a_single_core() {
        let total = AtomicU64::new(0);
        let table = generate(&small(), &|_, all| total.store(all, Ordering::Relaxed));
        assert!(table == DistanceTable::generate(&small()));
        assert_eq!(total.load(Ordering::Relaxed), table.len() as u64);
    }

    #[test]
    fn a_kept_file_is_read_again_and_a_spoilt_one_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let cache = folder.path().join("made/on/demand");
        // A file where a folder should be takes nothing; the next in line does.
        let blocked = folder.path().join("a-file");
        fs::write(&blocked, b"").unwrap();
        let folders = [blocked.clone(), cache.clone()];
        let calls = AtomicU64::new(0);
        let progress = |done: u64, total: u64| {
            assert!(done <= total);
            calls.fetch_add(1, Ordering::Relaxed);
        };
        let load = || {
            calls.store(0, Ordering::Relaxed);
            let (table, error) = load_or_generate(&folders, &small(), &progress);
            assert!(error.is_none(), "{error:?}");
            (table, calls.load(Ordering::Relaxed) > 0)
        };
        let (fresh, generated) = load();
        assert!(generated);
        let files: Vec<_> = fs::read_dir(&cache).unwrap().map(|entry| entry.unwrap().path()).collect();
        let [path] = &files[..] else { panic!("one file expected: {files:?}") };
        let good = fs::read(path).unwrap();
        assert!(load() == (fresh.clone(), false));
        let mut flipped = good.clone();
        flipped[1000] ^= 0x10;
        for bytes in [flipped, good[..good.len() - 2].to_vec(), Vec::new()] {
            fs::write(path, &bytes).unwrap();
            assert!(load() == (fresh.clone(), true));
            assert!(fs::read(path).unwrap() == good);
        }
        // A table of other parameters gets a file of its own.
        let other = Parameters { tail_width_m: 0.014, ..small() };
        assert!(load_or_generate(&folders, &other, &progress).1.is_none());
        assert_eq!(fs::read_dir(&cache).unwrap().count(), 2);
        // With no folder that takes it the table is there all the same.
        let (table, error) = load_or_generate(&[blocked], &small(), &progress);
        assert!(table == fresh && error.unwrap().to_string().contains("a-file"));
    }
}
