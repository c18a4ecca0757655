//! The log of a run: written as it happens, and read again. Summary and pictures are made of it, and of nothing else.
//!
//! ```text
//! closed loop ──→ BoatLog, RovLog ──┬─→ file (runlog::writer) ─→ file ─→ replay ──┐
//!                                   └──────────── Told ──────────────────────────┴─→ Reading ─→ Summary, record
//! ```
//!
//! What is told goes to the file and to the [reading](boats::Reading) alike, so that a live run and a replay take one way. What
//! others' tools look at ([`Shown`]: odometry, transforms, markers …) goes to the file alone, and so nowhere if there is none.
//!
//! | file | what |
//! |---|---|
//! | [`topics`] | which message goes by which topic |
//! | [`boats`], [`rovs`] | what is told of a run of each fleet, and what becomes of it |
//! | [`counts`] | links, ledgers and watch as messages, and back |
//! | `shown` | what others' tools look at |
//! | `standing` | how the run stands, for a console |
//! | [`replay`] | a log, read again |

use std::path::{Path, PathBuf};

use protocol::time::FleetInstant;
use runlog::message::Message;
use runlog::ros::{BatteryState, Odometry, Time};
use runlog::writer::{FileWriter, Tap, Topic};

pub use topics::{Shown, Told};

pub mod boats;
pub mod counts;
pub mod replay;
pub mod rovs;
mod shown;
mod standing;
pub mod topics;

/// Where a run's log goes: to a file, or nowhere.
#[derive(Default)]
pub struct Log {
    file: Option<Opened>,
    /// Where the file is; empty where there never was one.
    path: PathBuf,
    /// What became of it, if that was not good.
    failure: Option<String>,
}

struct Opened {
    writer: FileWriter,
    told: topics::ToldTopics,
    shown: topics::ShownTopics,
    batteries: Vec<Topic<BatteryState>>,
    odometry: Vec<Topic<Odometry>>,
}

impl Log {
    /// In a new file.
    ///
    /// # Errors
    /// That it cannot be written, with its path.
    pub fn create(path: &Path) -> Result<Self, String> {
        Self::create_tapped(path, None)
    }

    /// The same; `tap` gets every message as well.
    ///
    /// # Errors
    /// As for [`create`](Self::create).
    pub fn create_tapped(path: &Path, tap: Option<Box<dyn Tap>>) -> Result<Self, String> {
        let mut writer = FileWriter::create(path).map_err(|error| cannot(path, &error))?;
        if let Some(tap) = tap {
            writer = writer.tapped(tap);
        }
        let (told, shown) = (topics::ToldTopics::default(), topics::ShownTopics::default());
        let file = Some(Opened { writer, told, shown, batteries: Vec::new(), odometry: Vec::new() });
        Ok(Self { file, path: path.to_owned(), failure: None })
    }

    /// Whether anything is written.
    #[must_use]
    pub fn is_kept(&self) -> bool {
        self.file.is_some()
    }

    /// A disk that is full ends the log, not the run.
    fn write(&mut self, write: impl FnOnce(&mut Opened) -> std::io::Result<()>) {
        let Some(file) = &mut self.file else { return };
        if let Err(error) = write(file) {
            self.failure = Some(cannot(&self.path, &error));
            self.file = None;
        }
    }

    /// Writes what figures are made of.
    fn tell(&mut self, now: FleetInstant, told: Told<'_>) {
        self.write(|file| file.told.write(&mut file.writer, nanos(now), told));
    }

    /// Writes what others' tools look at.
    fn show(&mut self, now: FleetInstant, shown: Shown<'_>) {
        self.write(|file| file.shown.write(&mut file.writer, nanos(now), shown));
    }

    /// Writes the battery of the module at `place`, whose number is `id`.
    fn battery(&mut self, now: FleetInstant, place: usize, id: u16, battery: &BatteryState) {
        self.write(|file| {
            let name = || format!("/module_{id}/battery");
            one_of(&mut file.batteries, &mut file.writer, place, name, now, battery)
        });
    }

    /// Writes the motion of the ROV at `place`, whose number is `id`.
    fn odometry(&mut self, now: FleetInstant, place: usize, id: u16, odometry: &Odometry) {
        self.write(|file| {
            let name = || format!("/robot_{id}/odom");
            one_of(&mut file.odometry, &mut file.writer, place, name, now, odometry)
        });
    }

    /// Ends it. What became of it, if that was not good.
    #[must_use]
    pub fn finish(mut self) -> Option<String> {
        if let Some(file) = self.file.take()
            && let Err(error) = file.writer.finish()
        {
            self.failure = Some(cannot(&self.path, &error));
        }
        // A file that was removed can be written to its end.
        if self.failure.is_none() && !self.path.as_os_str().is_empty() && !self.path.exists() {
            self.failure = Some(format!("{}: it has been removed while it was written", self.path.display()));
        }
        self.failure
    }
}

fn cannot(path: &Path, error: &std::io::Error) -> String {
    format!("{}: cannot write: {error}", path.display())
}

/// Writes to the topic of one module; topics are made in the order of places.
fn one_of<M: Message>(
    known: &mut Vec<Topic<M>>,
    writer: &mut FileWriter,
    place: usize,
    name: impl FnOnce() -> String,
    now: FleetInstant,
    message: &M,
) -> std::io::Result<()> {
    if place == known.len() {
        known.push(writer.topic(&name())?);
    }
    known.get(place).map_or(Ok(()), |&topic| writer.write(topic, nanos(now), message))
}

/// A topic for the messages `M`, made when it is first used.
fn topic<M: Message>(
    known: &mut Option<Topic<M>>,
    writer: &mut FileWriter,
    name: &str,
) -> std::io::Result<Topic<M>> {
    if let Some(topic) = *known {
        return Ok(topic);
    }
    let topic = writer.topic(name)?;
    *known = Some(topic);
    Ok(topic)
}

/// The first message of a log.
fn head(
    fleet: &str,
    name: &str,
    seed: u64,
    modules: Vec<u16>,
    document: String,
) -> runlog::flotilla::Scenario {
    let since_1970 = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    runlog::flotilla::Scenario {
        format: runlog::flotilla::FORMAT,
        program: concat!("flotilla ", env!("CARGO_PKG_VERSION")).to_owned(),
        fleet: fleet.to_owned(),
        name: name.to_owned(),
        seed,
        began_unix_s: since_1970.map_or(0.0, |since| since.as_secs_f64()),
        modules,
        document,
    }
}

/// Fleet time as that of a log, ns.
#[must_use]
pub fn nanos(at: FleetInstant) -> u64 {
    at.0.saturating_mul(1000)
}

/// Fleet time as ROS has it.
#[must_use]
pub fn stamp(at: FleetInstant) -> Time {
    Time::from_nanos(nanos(at))
}

/// The fleet time of a stamp.
#[must_use]
pub fn instant(stamp: &Time) -> FleetInstant {
    FleetInstant(stamp.nanos() / 1000)
}
