//! A log, read again: summary and record as they were made when it was written.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use runlog::flotilla::{FORMAT, Scenario as Head};
use runlog::reader::{Entry, Extent, LogError, read};
use thiserror::Error;

use super::super::progress::Progress;
use super::super::scenario::Scenario;
use super::topics::Told;
use super::{boats, rovs};

/// Why a log is not read.
#[derive(Debug, Error)]
pub enum ReplayError {
    /// It is none, or damaged.
    #[error(transparent)]
    Log(#[from] LogError),
    /// It says nothing of a run of Flotilla.
    #[error("a log, but not of Flotilla: it does not begin with /scenario")]
    Foreign,
    /// It ends before anything is said.
    #[error("cut before it says what was run")]
    Empty,
    /// This program is too old.
    #[error("{program} wrote it, in format {format}: this is flotilla {}, which reads up to format {FORMAT}", env!("CARGO_PKG_VERSION"))]
    Newer {
        /// The program that wrote it.
        program: String,
        /// Its format.
        format: u32,
    },
    /// What it says cannot be.
    #[error("{0}")]
    Senseless(String),
}

/// What became of a run, by its log.
pub enum Replayed {
    /// Of Modboats.
    Boats(Box<boats::Outcome>),
    /// Of ROVs.
    Rovs(Box<rovs::Outcome>),
}

enum Reading {
    Boats(Box<boats::Reading>),
    Rovs(Box<rovs::Reading>),
}

impl Reading {
    fn new(head: &Head) -> Result<Self, ReplayError> {
        if head.format > FORMAT {
            return Err(ReplayError::Newer { program: head.program.clone(), format: head.format });
        }
        match head.fleet.as_str() {
            "modboats" => {
                let scenario = Scenario::parse("/scenario", &head.document)
                    .map_err(|error| ReplayError::Senseless(error.to_string()))?;
                let modules = scenario.structure.len();
                if head.modules.len() != modules {
                    let told = head.modules.len();
                    return Err(ReplayError::Senseless(format!(
                        "/scenario: {told} numbers of {modules} modules"
                    )));
                }
                Ok(Self::Boats(Box::new(boats::Reading::new(&scenario, head.seed, &head.modules))))
            }
            "rovs" => {
                let document: rovs::Document = serde_json::from_str(&head.document)
                    .map_err(|error| ReplayError::Senseless(format!("/scenario: {error}")))?;
                Ok(Self::Rovs(Box::new(rovs::Reading::new(document, head.seed))))
            }
            fleet => Err(ReplayError::Senseless(format!("/scenario: a fleet of {fleet:?}"))),
        }
    }

    fn take(&mut self, told: Told<'_>) {
        match self {
            Self::Boats(reading) => reading.take(told),
            Self::Rovs(reading) => reading.take(told),
        }
    }
}

/// Only the beginning, which every version begins with.
fn format(entry: &Entry<'_>) -> Result<(u32, String), LogError> {
    use runlog::cdr::{Cdr, Decoder};
    let mut decoder = Decoder::new(entry.data).map_err(|error| entry.no_message(error))?;
    let format = u32::decode(&mut decoder).map_err(|error| entry.no_message(error))?;
    Ok((format, String::decode(&mut decoder).unwrap_or_else(|_| "a newer program".to_owned())))
}

/// What a log is of, by its first message.
///
/// # Errors
/// [`ReplayError`] where it is none of Flotilla's, or too new.
pub fn head(entry: &Entry<'_>) -> Result<Head, ReplayError> {
    if entry.topic != "/scenario" || entry.schema != "flotilla_msgs/msg/Scenario" {
        return Err(ReplayError::Foreign);
    }
    let (format, program) = format(entry)?;
    if format > FORMAT {
        return Err(ReplayError::Newer { program, format });
    }
    Ok(entry.read()?)
}

/// Reads a log from `source`, of `length` bytes. What became of the run, and how far the log goes.
///
/// # Errors
/// [`ReplayError`]. A log that is cut is no error.
pub fn replay(
    source: impl Read,
    length: u64,
    progress: &mut dyn Progress,
) -> Result<(Replayed, Extent), ReplayError> {
    let mut reading = None;
    let extent = read(source, |entry, extent| {
        if extent.messages.is_multiple_of(4096) {
            progress.preparing("reading", extent.bytes, length);
        }
        if let Some(reading) = &mut reading {
            let take = |told: Told<'_>| Reading::take(reading, told);
            return Ok::<(), ReplayError>(Told::of(entry, take)?);
        }
        reading = Some(Reading::new(&head(entry)?)?);
        Ok(())
    })?;
    let replayed = match reading.ok_or(ReplayError::Empty)? {
        Reading::Boats(reading) => {
            Replayed::Boats(Box::new(reading.finish().map_err(ReplayError::Senseless)?))
        }
        Reading::Rovs(reading) => Replayed::Rovs(Box::new(reading.finish().map_err(ReplayError::Senseless)?)),
    };
    Ok((replayed, extent))
}

/// [`replay`] of a file.
///
/// # Errors
/// As for [`replay`].
pub fn replay_file(path: &Path, progress: &mut dyn Progress) -> Result<(Replayed, Extent), ReplayError> {
    let file = File::open(path).map_err(LogError::from)?;
    let length = file.metadata().map_or(0, |metadata| metadata.len());
    replay(BufReader::new(file), length, progress)
}
