//! The shards of a campaign as one file.

use std::path::PathBuf;

use thiserror::Error;

use crate::folder::{Folder, Shard};
use crate::table::{Table, TableError};

/// Why shards are not merged.
#[derive(Debug, Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum MergeError {
    /// See there.
    #[error(transparent)]
    Table(#[from] TableError),
    /// Some are not done.
    #[error("{}: shards {} of {of} are not done (--partial merges the others)", path.display(), list(missing))]
    Missing { path: PathBuf, missing: Vec<usize>, of: usize },
    /// A file has rows of others, or not all of its own.
    #[error("{}: has not the rows of this shard: remove it and run the shard again", path.display())]
    Rows { path: PathBuf },
}

fn list(shards: &[usize]) -> String {
    shards.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")
}

/// Shards without a file.
#[must_use]
pub fn missing(folder: &Folder) -> Vec<usize> {
    folder.shards().filter(|&shard| !folder.file(shard).exists()).map(|shard| shard.index).collect()
}

/// Merges the shards of `folder` into one file; those that there are, if `partial`. Its path, and how many rows it has.
///
/// # Errors
/// [`MergeError`].
pub fn merge(folder: &Folder, partial: bool) -> Result<(PathBuf, usize), MergeError> {
    let missing = missing(folder);
    let of = folder.manifest.shards;
    if !missing.is_empty() && (!partial || missing.len() == of) {
        return Err(MergeError::Missing { path: folder.path.clone(), missing, of });
    }
    let mut tables = Vec::new();
    for shard in folder.shards().filter(|shard: &Shard| !missing.contains(&shard.index)) {
        let path = folder.file(shard);
        let table = Table::read(&path)?;
        if !table.runs().eq(shard.runs(folder.manifest.runs).map(|run| run as i64)) {
            return Err(MergeError::Rows { path });
        }
        tables.push(table);
    }
    let table = Table::merged(tables, &folder.varied());
    let path = folder.rows();
    table.write(&path, folder.format())?;
    Ok((path, table.rows.len()))
}
