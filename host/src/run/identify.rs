//! From a log to what constants are identified from. Nothing that only a simulation knows is read (`/truth/…`, `[tank]`, `/cycle`), but for
//! the poses of ROVs that were simulated without a motion capture.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use identify::data::{Boat, Recording};
use identify::rov::data::Recording as Swims;
use reconfiguration::vehicle::Vehicle;
use runlog::flotilla::Scenario as Head;
use runlog::reader::{LogError, read};

use super::log::replay::{ReplayError, head};
use super::log::rovs::Document;
use super::progress::Progress;

pub use boats::Logged as Boats;
pub use rovs::Kind;

mod boats;
mod rovs;

/// What a log says.
pub enum Logged {
    /// Of a run of Modboats.
    Boats(Box<Boats>),
    /// Of a reconfiguration: each kind of robot that is in it.
    Rovs(Vec<Kind>),
}

/// What is taken of a log, message by message.
enum Begun {
    Boats(Box<(Head, boats::Taken)>),
    Rovs(Box<Document>, rovs::Taken),
}

impl Begun {
    fn new(head: Head) -> Result<Self, ReplayError> {
        match head.fleet.as_str() {
            "modboats" => Ok(Self::Boats(Box::new((head, boats::Taken::default())))),
            "rovs" => {
                let document = serde_json::from_str(&head.document)
                    .map_err(|error| ReplayError::Senseless(format!("/scenario: {error}")))?;
                Ok(Self::Rovs(Box::new(document), rovs::Taken::default()))
            }
            fleet => Err(ReplayError::Senseless(format!("/scenario: a fleet of {fleet:?}"))),
        }
    }
}

/// Reads a log.
///
/// # Errors
/// [`ReplayError`]. A log that is cut is read as far as it goes.
pub fn logged(
    name: &str,
    source: impl Read,
    length: u64,
    progress: &mut dyn Progress,
) -> Result<Logged, ReplayError> {
    let mut begun: Option<Begun> = None;
    read(source, |entry, extent| {
        if extent.messages.is_multiple_of(4096) {
            progress.preparing("reading", extent.bytes, length);
        }
        match &mut begun {
            Some(Begun::Boats(begun)) => begun.1.take(entry)?,
            Some(Begun::Rovs(_, taken)) => taken.take(entry)?,
            None => begun = Some(Begun::new(head(entry)?)?),
        }
        Ok::<(), ReplayError>(())
    })?;
    match begun.ok_or(ReplayError::Empty)? {
        Begun::Boats(begun) => {
            let (head, taken) = *begun;
            Ok(Logged::Boats(Box::new(taken.finish(name, head)?)))
        }
        Begun::Rovs(document, taken) => Ok(Logged::Rovs(taken.finish(name, &document))),
    }
}

/// [`logged`] of a file.
///
/// # Errors
/// As for [`logged`].
pub fn logged_file(path: &Path, progress: &mut dyn Progress) -> Result<Logged, ReplayError> {
    let file = File::open(path).map_err(LogError::from)?;
    let length = file.metadata().map_or(0, |metadata| metadata.len());
    logged(&path.display().to_string(), BufReader::new(file), length, progress)
}

/// What several logs say together.
pub enum Logs {
    /// Of one structure.
    Boats(Box<Boat>, Vec<Recording>),
    /// Each kind of robot, with what its robots did in each log.
    Rovs(Vec<(Vehicle, Vec<Swims>)>),
}

impl Logs {
    /// Of Modboats.
    ///
    /// # Errors
    /// They are of ROVs.
    pub fn boats(self) -> Result<(Boat, Vec<Recording>), String> {
        match self {
            Self::Boats(boat, recordings) => Ok((*boat, recordings)),
            Self::Rovs(_) => Err("logs of ROVs: Modboats are asked for".to_owned()),
        }
    }

    /// Adds a log to those before.
    fn add(known: Option<Self>, logged: Logged) -> Result<Self, &'static str> {
        match (known, logged) {
            (None, Logged::Boats(logged)) => Ok(Self::Boats(Box::new(logged.boat), vec![logged.recording])),
            (None, Logged::Rovs(kinds)) => {
                let of = |kind: Kind| (kind.vehicle, vec![kind.recording]);
                Ok(Self::Rovs(kinds.into_iter().map(of).collect()))
            }
            (Some(Self::Boats(boat, mut recordings)), Logged::Boats(logged)) => {
                if boat.structure.cells() != logged.boat.structure.cells() || boat.ids != logged.boat.ids {
                    return Err("of other modules or another shape than the first log");
                }
                recordings.push(logged.recording);
                Ok(Self::Boats(boat, recordings))
            }
            (Some(Self::Rovs(mut known)), Logged::Rovs(kinds)) => {
                for kind in kinds {
                    match known.iter_mut().find(|(vehicle, _)| *vehicle == kind.vehicle) {
                        Some((_, recordings)) => recordings.push(kind.recording),
                        None => known.push((kind.vehicle, vec![kind.recording])),
                    }
                }
                Ok(Self::Rovs(known))
            }
            (Some(Self::Boats(..)), Logged::Rovs(_)) => Err("of ROVs, and the first log of Modboats"),
            (Some(Self::Rovs(_)), Logged::Boats(_)) => Err("of Modboats, and the first log of ROVs"),
        }
    }
}

/// All logs together, which must be of one fleet. `progress` makes what shows how far each is read.
///
/// # Errors
/// Which log is not read, or is of another fleet or structure.
pub fn logged_files<P: Progress>(paths: &[PathBuf], progress: impl Fn(&Path) -> P) -> Result<Logs, String> {
    let mut known: Option<Logs> = None;
    for path in paths {
        let of_log = |reason: &str| format!("{}: {reason}", path.display());
        let logged = logged_file(path, &mut progress(path)).map_err(|error| of_log(&error.to_string()))?;
        known = Some(Logs::add(known, logged).map_err(of_log)?);
    }
    known.ok_or_else(|| "no log was given".to_owned())
}
