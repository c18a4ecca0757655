//! The suite's own statistics as campaigns: numbered runs on all cores, a row each, judged by what the rows say.
//!
//! Rows go to a folder that is removed, or with `FLOTILLA_STATISTICS=FOLDER` to one that stays: there a run that was stopped goes on, and
//! `flotilla campaign report` shows it. A program of other code begins again.

use std::path::{Path, PathBuf};
use std::time::Duration;

use campaign::cell::{Cell, flatten};
use campaign::execute::{Watch, execute};
use campaign::folder::{Folder, FolderError, Shard};
use campaign::table::{Format, Table};
use campaign::work::{Work, caught, fingerprint};
use serde_json::{Map, Value};

/// Numbered runs of a test.
pub struct Statistic<F> {
    /// Its name.
    pub name: &'static str,
    /// What a run is called.
    pub of: &'static str,
    /// How many runs.
    pub runs: usize,
    /// What is varied, beside the number of the run: rows of another are not this one's.
    pub varied: String,
    /// Run so and so, from 0: an object.
    pub row: F,
}

impl<F: Fn(usize) -> Value + Sync> Work for Statistic<F> {
    fn name(&self) -> &str {
        self.name
    }

    fn runs(&self) -> usize {
        self.runs
    }

    fn told(&self) -> String {
        format!("{} {}", self.runs, self.of)
    }

    fn fingerprint(&self) -> String {
        let program = std::env::current_exe().and_then(std::fs::metadata).expect("this program is a file");
        let built = program.modified().expect("files have a time");
        fingerprint([self.name, &self.varied, &format!("{built:?}")].map(str::as_bytes))
    }

    fn row(&self, number: usize) -> Map<String, Value> {
        let mut row = Map::new();
        match caught(|| (self.row)(number)) {
            Ok(value) => flatten(&mut row, "", value),
            Err(panic) => drop(row.insert("error".to_owned(), format!("a panic: {panic}").into())),
        }
        row
    }
}

/// All rows of a statistic.
pub struct Rows(Table);

/// One of them.
#[derive(Clone, Copy)]
pub struct Row<'t> {
    table: &'t Table,
    number: usize,
}

impl Rows {
    /// In the order of the runs.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Row<'_>> + Clone {
        (0..self.0.rows.len()).map(|number| self.row(number))
    }

    /// One of them.
    #[must_use]
    pub fn row(&self, number: usize) -> Row<'_> {
        Row { table: &self.0, number }
    }

    /// The sum of a column of counts.
    #[must_use]
    pub fn sum(&self, column: &str) -> u64 {
        self.iter().map(|row| row.count(column)).sum()
    }
}

impl<'t> Row<'t> {
    fn cell(&self, column: &str) -> Option<&'t Cell> {
        let cell = &self.table.rows[self.number][self.table.column(column)?];
        (*cell != Cell::Null).then_some(cell)
    }

    /// A number; `None` where this row has none.
    #[must_use]
    pub fn perhaps(&self, column: &str) -> Option<f64> {
        self.cell(column).and_then(Cell::number)
    }

    /// A number, or a truth as 1 or 0.
    ///
    /// # Panics
    /// If there is none.
    #[must_use]
    pub fn number(&self, column: &str) -> f64 {
        self.perhaps(column).unwrap_or_else(|| panic!("run {}: no number in {column}", self.number))
    }

    /// A whole number, not below zero, or a truth as 1 or 0.
    ///
    /// # Panics
    /// If there is none.
    #[must_use]
    pub fn count(&self, column: &str) -> u64 {
        let number = self.number(column);
        assert!(
            number >= 0.0 && number.fract() == 0.0,
            "run {}: {column} = {number} is no count",
            self.number
        );
        number as u64
    }

    /// A text; empty where there is none.
    #[must_use]
    pub fn text(&self, column: &str) -> &'t str {
        match self.cell(column) {
            Some(Cell::Text(text)) => text,
            _ => "",
        }
    }
}

/// The statistic's rows: made now, or what is left of them.
///
/// # Panics
/// If a run panicked, or its folder cannot be used.
#[must_use]
pub fn rows(statistic: &dyn Work) -> Rows {
    let kept = std::env::var_os("FLOTILLA_STATISTICS").map(PathBuf::from);
    let passing = kept.is_none().then(|| tempfile::tempdir().expect("a folder"));
    let path = kept.unwrap_or_else(|| passing.as_ref().map_or(PathBuf::new(), |folder| folder.path().into()));
    rows_in(&path.join(statistic.name()), statistic)
}

fn rows_in(path: &Path, statistic: &dyn Work) -> Rows {
    let mut folder = Folder::of(statistic, path, 1, Format::Parquet);
    // Of other code, or of another number of runs.
    if let Err(FolderError::Other { .. }) = folder {
        std::fs::remove_dir_all(path).expect("a folder of this test");
        folder = Folder::of(statistic, path, 1, Format::Parquet);
    }
    let folder = folder.unwrap_or_else(|error| panic!("{error}"));
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let outcome = execute(statistic, &folder, Shard::WHOLE, cores, &Quiet);
    let outcome = outcome.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((outcome.rows, outcome.errors), (statistic.runs(), 0), "{:?}", outcome.first_error);
    if outcome.made < outcome.rows {
        println!("{}: {} rows were there", statistic.name(), outcome.rows - outcome.made);
    }
    if outcome.took > Duration::from_secs(60) {
        println!("{}: {} in {:.0} s", statistic.name(), statistic.told(), outcome.took.as_secs_f64());
    }
    Rows(Table::read(&folder.rows()).unwrap_or_else(|error| panic!("{error}")))
}

struct Quiet;

impl Watch for Quiet {
    fn waits(&self) {}

    fn rows(&self, _: usize, _: usize) {}
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use serde_json::json;

    use super::*;

    #[test]
    fn rows_that_are_there_are_not_made_again_unless_what_is_varied_changes() {
        let folder = tempfile::tempdir().expect("a folder");
        let made = AtomicUsize::new(0);
        let row = |number: usize| {
            made.fetch_add(1, Ordering::Relaxed);
            json!({ "square": number * number, "wrong": Vec::<String>::new(), "name": "n", "half": null })
        };
        let statistic = |varied: &str| Statistic {
            name: "squares",
            of: "numbers",
            runs: 5,
            varied: varied.to_owned(),
            row,
        };
        for (varied, count) in [("a", 5), ("a", 5), ("b", 10)] {
            let rows = rows_in(folder.path(), &statistic(varied));
            assert_eq!(made.load(Ordering::Relaxed), count);
            assert_eq!(rows.sum("square"), 30);
            let last = rows.iter().last().expect("five");
            assert_eq!(
                (last.number("wrong.count"), last.text("name"), last.perhaps("half")),
                (0.0, "n", None)
            );
        }
    }

    #[test]
    #[should_panic(expected = "run 1: a panic")]
    fn a_run_that_panics_is_told() {
        let row = |number: usize| if number == 1 { panic!("on purpose") } else { json!({}) };
        let statistic = Statistic { name: "broken", of: "runs", runs: 2, varied: String::new(), row };
        let _ = rows(&statistic);
    }
}
