//! `flotilla export`: the topics of a log as tables for others' tools.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};

use runlog::reader::{Entry, LogError, read};
use runlog::schema::Schema;
use runlog::table::Table;

use super::folder::Folder;
use super::progress::Bar;
use super::{Failure, bad, could, written};
use crate::run::progress::Progress;

#[derive(clap::Args)]
#[command(after_help = "Example:\n  flotilla export runs/holonomic-1/log.mcap --csv tables")]
pub(super) struct Arguments {
    /// The log of a run; of any MCAP file, the topics of ROS 2 (ros2msg, CDR, not compressed)
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// Folder for the tables: one a topic, units at the ends of the columns' names
    #[arg(long, value_name = "FOLDER")]
    csv: PathBuf,
}

/// A topic's table, and where its rows go.
struct Sheet {
    table: Table,
    path: PathBuf,
    out: BufWriter<File>,
}

/// Why a log is not exported.
enum Trouble {
    Log(LogError),
    File(PathBuf, std::io::Error),
}

impl From<LogError> for Trouble {
    fn from(error: LogError) -> Self {
        Self::Log(error)
    }
}

pub(super) fn main(arguments: &Arguments) -> Result<(), Failure> {
    let name = arguments.log.display();
    let of_log = |error: &dyn std::fmt::Display| bad(format!("{name}: {error}"));
    let file = File::open(&arguments.log).map_err(|error| of_log(&error))?;
    let length = file.metadata().map_or(0, |metadata| metadata.len());
    let folder = Folder::of(Some(&arguments.csv), "")?;
    let mut bar = Bar::new(&name.to_string());
    let mut sheets: HashMap<u16, Option<Sheet>> = HashMap::new();
    let (mut paths, mut skipped, mut ended, mut told) = (Vec::new(), Vec::new(), false, false);
    let outcome = read(BufReader::new(file), |entry, extent| {
        if extent.messages.is_multiple_of(4096) {
            bar.preparing("reading", extent.bytes, length);
        }
        told |= entry.topic == "/scenario";
        ended |= entry.topic == "/end";
        let sheet = match sheets.entry(entry.channel) {
            std::collections::hash_map::Entry::Occupied(known) => known.into_mut(),
            std::collections::hash_map::Entry::Vacant(new) => {
                let sheet = sheet(entry, &folder.path)?;
                match &sheet {
                    Some(sheet) => paths.push(sheet.path.clone()),
                    None => skipped.push(entry.topic.to_owned()),
                }
                new.insert(sheet)
            }
        };
        let Some(sheet) = sheet else { return Ok(()) };
        sheet.table.take(entry.data).map_err(|error| entry.no_message(error))?;
        let outcome = sheet.table.write_rows(entry.at_ns, &mut sheet.out);
        outcome.map_err(|error| Trouble::File(sheet.path.clone(), error))
    });
    drop(bar);
    let extent = outcome.map_err(|trouble| match trouble {
        Trouble::Log(error) => of_log(&error),
        Trouble::File(path, error) => could(format!("{}: cannot write: {error}", path.display())),
    })?;
    for sheet in sheets.into_values().flatten() {
        let Sheet { mut out, path, .. } = sheet;
        out.flush().map_err(|error| could(format!("{}: cannot write: {error}", path.display())))?;
    }
    let mut out = std::io::stdout().lock();
    for path in &paths {
        written(writeln!(out, "  {}", path.display()))?;
    }
    for topic in skipped {
        written(writeln!(out, "  {topic} is left out: no ros2msg"))?;
    }
    written(out.flush())?;
    if !extent.whole || told && !ended {
        let end_s = extent.end_ns as f64 * 1e-9;
        return Err(could(format!("{name}: cut after {end_s:.3} s: the end of the run is missing")));
    }
    Ok(())
}

/// The table of a topic, with its header written; none where its schema is not one of ROS 2.
fn sheet(entry: &Entry<'_>, folder: &Path) -> Result<Option<Sheet>, Trouble> {
    let Some(definition) = entry.definition else { return Ok(None) };
    let schema = Schema::parse(entry.schema, definition)
        .map_err(|reason| LogError::Schema { topic: entry.topic.to_owned(), reason })?;
    let table = Table::new(schema);
    let path = folder.join(file_name(entry.topic));
    let of_file = |error| Trouble::File(path.clone(), error);
    let mut out = BufWriter::new(File::create(&path).map_err(of_file)?);
    table.write_header(&mut out).map_err(of_file)?;
    Ok(Some(Sheet { table, path, out }))
}

/// `/wrench/demanded` goes to `wrench_demanded.csv`; no topic leads out of the folder.
fn file_name(topic: &str) -> String {
    let fit = |c: char| if c.is_alphanumeric() || c == '_' || c == '-' { c } else { '_' };
    let name: String = topic.trim_matches('/').chars().map(fit).collect();
    format!("{name}.csv")
}
