//! Rows in columns, and files of them: Parquet or CSV.
//!
//! Columns stand in an order that does not depend on which rows there are: those of [`HEAD`] first, then the keys that
//! are varied, then all others by name, numbers in names counted as numbers. Rows stand by the number of their run. So a campaign
//! that is run in one piece and one that is merged from shards are one file, byte by byte.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value};
use thiserror::Error;

use crate::cell::Cell;
use crate::journal::replace;
use crate::row::HEAD;

mod csv;
mod parquet;

/// Why a file of rows cannot be read or written.
#[derive(Debug, Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum TableError {
    /// Reading or writing failed.
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: std::io::Error },
    /// It is not what its name says.
    #[error("{}: {reason}", path.display())]
    Content { path: PathBuf, reason: String },
}

/// How rows are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// Apache Parquet, not compressed
    Parquet,
    /// Texts in quotes, all else without; one line of names first
    Csv,
}

impl Format {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Parquet, Self::Csv];

    /// The end of the names of such files.
    #[must_use]
    pub const fn extension(self) -> &'static str {
        match self {
            Self::Parquet => "parquet",
            Self::Csv => "csv",
        }
    }

    /// The format of a file by the end of its name.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        let end = path.extension()?.to_str()?;
        Self::ALL.into_iter().find(|format| format.extension() == end)
    }
}

/// See the module's documentation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Rows, each with a cell for each column.
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    /// Of rows by the number of their run; `varied` are the keys that are varied.
    #[must_use]
    pub fn new(rows: &BTreeMap<usize, Map<String, Value>>, varied: &[String]) -> Self {
        let mut names: BTreeSet<&str> = rows.values().flat_map(Map::keys).map(String::as_str).collect();
        names.insert("run");
        let mut columns: Vec<String> = names.into_iter().map(str::to_owned).collect();
        columns.sort_by(|a, b| order(a, b, varied));
        let cells = |(run, row): (&usize, &Map<String, Value>)| {
            let cell = |name: &String| match name.as_str() {
                "run" => Cell::Int(*run as i64),
                name => row.get(name).map_or(Cell::Null, Cell::from),
            };
            columns.iter().map(cell).collect()
        };
        let rows = rows.iter().map(cells).collect();
        Self { columns, rows }
    }

    /// Several as one, in the order of their runs.
    #[must_use]
    pub fn merged(tables: Vec<Self>, varied: &[String]) -> Self {
        let names: BTreeSet<&String> = tables.iter().flat_map(|table| &table.columns).collect();
        let mut columns: Vec<String> = names.into_iter().cloned().collect();
        columns.sort_by(|a, b| order(a, b, varied));
        let mut rows = Vec::with_capacity(tables.iter().map(|table| table.rows.len()).sum());
        for table in tables {
            let places: Vec<Option<usize>> = columns.iter().map(|name| table.column(name)).collect();
            rows.extend(table.rows.into_iter().map(|mut row| -> Vec<Cell> {
                let mut take = |at: usize| std::mem::replace(&mut row[at], Cell::Null);
                places.iter().map(|place| place.map_or(Cell::Null, &mut take)).collect()
            }));
        }
        let mut table = Self { columns, rows };
        if let Some(run) = table.column("run") {
            table.rows.sort_by_key(|row| match row[run] {
                Cell::Int(run) => run,
                _ => i64::MAX,
            });
        }
        table
    }

    /// Where a column is.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|known| known == name)
    }

    /// The numbers of the runs, in order.
    pub fn runs(&self) -> impl Iterator<Item = i64> {
        let column = self.column("run");
        self.rows.iter().filter_map(move |row| match row[column?] {
            Cell::Int(run) => Some(run),
            _ => None,
        })
    }

    /// Reads a file by the end of its name.
    ///
    /// # Errors
    /// [`TableError`].
    pub fn read(path: &Path) -> Result<Self, TableError> {
        let content = |reason: String| TableError::Content { path: path.to_owned(), reason };
        let failed = |source| TableError::File { path: path.to_owned(), source };
        match Format::of(path) {
            Some(Format::Parquet) => {
                let file = File::open(path).map_err(failed)?;
                parquet::read(file).map_err(|error| content(error.to_string()))
            }
            Some(Format::Csv) => {
                let text = std::fs::read_to_string(path).map_err(failed)?;
                csv::read(&text).map_err(content)
            }
            None => Err(content("its name ends neither with .parquet nor with .csv".to_owned())),
        }
    }

    /// Writes a file whole, or none.
    ///
    /// # Errors
    /// [`TableError::File`].
    pub fn write(&self, path: &Path, format: Format) -> Result<(), TableError> {
        let written = replace(path, |file| match format {
            Format::Parquet => parquet::write(self, file).map_err(std::io::Error::other),
            Format::Csv => csv::write(self, file),
        });
        written.map_err(|source| TableError::File { path: path.to_owned(), source })
    }
}

/// The order of columns.
fn order(a: &str, b: &str, varied: &[String]) -> Ordering {
    let head = |name: &str| HEAD.iter().position(|known| *known == name).unwrap_or(HEAD.len());
    let varied = |name: &str| {
        let of_key = |key: &String| {
            name.strip_prefix(key.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        varied.iter().position(of_key).unwrap_or(varied.len())
    };
    let parts = || a.split('.').zip(b.split('.')).map(|(a, b)| part_order(a, b));
    (head(a), varied(a))
        .cmp(&(head(b), varied(b)))
        .then_with(|| parts().find(|order| order.is_ne()).unwrap_or(Ordering::Equal))
        .then_with(|| a.len().cmp(&b.len()))
        .then_with(|| a.cmp(b))
}

fn part_order(a: &str, b: &str) -> Ordering {
    match (a.parse::<u64>(), b.parse::<u64>()) {
        (Ok(a), Ok(b)) => a.cmp(&b),
        _ => a.cmp(b),
    }
}

#[cfg(test)]
mod tests;
