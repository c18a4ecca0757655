//! Reads a log from its beginning to its end, or to where it is cut.

use std::collections::HashMap;
use std::io::{self, ErrorKind, Read};

use thiserror::Error;

use super::cdr::CdrError;
use super::mcap::{Content, MAGIC, RECORD_HEAD, check_sum, op};

/// No record of a log is longer, bytes; *assumed*.
const RECORD_MAX: u64 = 256 << 20;

/// Why a log is not read, or not to its end.
#[derive(Debug, Error)]
pub enum LogError {
    /// The file cannot be read.
    #[error("{0}")]
    File(#[from] io::Error),
    /// It is something else.
    #[error("not a log: it does not begin as MCAP files do")]
    NoLog,
    /// A chunk's check sum is wrong, or a record makes no sense.
    #[error("damaged after {at_s:.3} s: {what}")]
    Damaged {
        /// Time of the last message before, s.
        at_s: f64,
        /// What is wrong.
        what: &'static str,
    },
    /// It is written in a way that is not read here.
    #[error("its chunks are compressed ({0}): uncompress it first, by `mcap convert`")]
    Compressed(String),
    /// A message is none of its type.
    #[error("{topic} at {at_s:.3} s: no {schema}: {source}")]
    Message {
        /// Of which topic.
        topic: String,
        /// Of which type.
        schema: String,
        /// When, s.
        at_s: f64,
        /// Why.
        source: CdrError,
    },
    /// The schema of a topic cannot be read.
    #[error("{topic}: {reason}")]
    Schema {
        /// Of which topic.
        topic: String,
        /// What is wrong with it.
        reason: String,
    },
}

/// One message of a log.
#[derive(Clone, Copy, Debug)]
pub struct Entry<'a> {
    /// Its topic.
    pub topic: &'a str,
    /// The number of its topic in this log.
    pub channel: u16,
    /// Name of its type in full.
    pub schema: &'a str,
    /// Definition of its type, if that is `ros2msg`.
    pub definition: Option<&'a str>,
    /// When, ns.
    pub at_ns: u64,
    /// CDR.
    pub data: &'a [u8],
}

impl Entry<'_> {
    /// When, s.
    #[must_use]
    pub fn at_s(&self) -> f64 {
        self.at_ns as f64 * 1e-9
    }

    /// The message, of the type `M`.
    ///
    /// # Errors
    /// [`LogError::Message`].
    pub fn read<M: super::message::Message>(&self) -> Result<M, LogError> {
        M::read(self.data).map_err(|source| self.no_message(source))
    }

    /// That it is none of its type.
    #[must_use]
    pub fn no_message(&self, source: CdrError) -> LogError {
        LogError::Message {
            topic: self.topic.to_owned(),
            schema: self.schema.to_owned(),
            at_s: self.at_s(),
            source,
        }
    }
}

/// How far a log goes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extent {
    /// Whether the file ends as a log does; it is cut otherwise.
    pub whole: bool,
    /// Messages read.
    pub messages: u64,
    /// Time of the last one, ns.
    pub end_ns: u64,
    /// Bytes read.
    pub bytes: u64,
}

#[derive(Default)]
struct Topics {
    schemas: HashMap<u16, (String, Option<String>)>,
    channels: HashMap<u16, (String, u16)>,
}

impl Topics {
    /// Takes down what a record says of topics, or hands out the message that it is. `None` for one that makes no sense.
    fn take<'a>(&'a mut self, code: u8, content: &'a [u8]) -> Option<Option<Entry<'a>>> {
        let mut content = Content(content);
        match code {
            op::SCHEMA => {
                let (id, name, encoding) = (content.u16()?, content.text()?, content.text()?);
                let data = content.bytes()?;
                let definition = if encoding == "ros2msg" { str::from_utf8(data).ok() } else { None };
                self.schemas.insert(id, (name.to_owned(), definition.map(str::to_owned)));
            }
            op::CHANNEL => {
                let (id, schema, topic) = (content.u16()?, content.u16()?, content.text()?);
                self.channels.insert(id, (topic.to_owned(), schema));
            }
            op::MESSAGE => {
                let (channel, _sequence) = (content.u16()?, content.u32()?);
                let (at_ns, _published_ns) = (content.u64()?, content.u64()?);
                let (topic, schema) = self.channels.get(&channel)?;
                let (schema, definition) =
                    self.schemas.get(schema).map_or(("", None), |(name, text)| (name, text.as_deref()));
                return Some(Some(Entry { topic, channel, schema, definition, at_ns, data: content.0 }));
            }
            _ => {}
        }
        Some(None)
    }
}

/// Calls `take` with every message of `source`, in the order in which they lie in the file, and with how far it has come.
///
/// # Errors
/// [`LogError`], or what `take` says. A log that is cut is no error: see [`Extent`].
pub fn read<E: From<LogError>>(
    mut source: impl Read,
    mut take: impl FnMut(&Entry<'_>, &Extent) -> Result<(), E>,
) -> Result<Extent, E> {
    let (mut topics, mut extent) = (Topics::default(), Extent::default());
    let mut magic = [0; MAGIC.len()];
    let found = fill(&mut source, &mut magic)?;
    extent.bytes += found as u64;
    // Of one that is cut there, the beginning can still be told from other files.
    let known = magic.get(..found).unwrap_or_default();
    if found < 5 || !MAGIC.starts_with(known) {
        return Err(LogError::NoLog.into());
    }
    let mut content = Vec::new();
    loop {
        let mut head = [0; RECORD_HEAD];
        let found = fill(&mut source, &mut head)?;
        extent.bytes += found as u64;
        let [code, length @ ..] = head;
        if found < RECORD_HEAD {
            return Ok(extent);
        }
        let length = u64::from_le_bytes(length);
        if length > RECORD_MAX {
            return Err(damaged(&extent, "a record is longer than any").into());
        }
        content.clear();
        // A length that is wrong takes no more memory than there are bytes.
        let found = source.by_ref().take(length).read_to_end(&mut content).map_err(LogError::File)? as u64;
        extent.bytes += found;
        if found < length {
            return Ok(extent);
        }
        match code {
            op::CHUNK => {
                let records = records(&content, &extent)?;
                let at_s = extent.end_ns as f64 * 1e-9;
                each(records, at_s, |code, content| {
                    hand_on(&mut topics, &mut extent, code, content, &mut take)
                })?;
            }
            op::FOOTER => {
                let mut end = [0; MAGIC.len()];
                let found = fill(&mut source, &mut end)?;
                extent.bytes += found as u64;
                extent.whole = end == *MAGIC;
                return Ok(extent);
            }
            code => hand_on(&mut topics, &mut extent, code, &content, &mut take)?,
        }
    }
}

/// Reads until `space` is full, or the file ends; how much.
fn fill(source: &mut impl Read, space: &mut [u8]) -> Result<usize, LogError> {
    let mut filled = 0;
    while let Some(rest) = space.get_mut(filled..).filter(|rest| !rest.is_empty()) {
        match source.read(rest) {
            Ok(0) => break,
            Ok(count) => filled += count,
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error.into()),
        }
    }
    Ok(filled)
}

/// The records of a chunk, if its check sum is right.
fn records<'a>(content: &'a [u8], extent: &Extent) -> Result<Content<'a>, LogError> {
    let mut content = Content(content);
    let mut head = || {
        content.take(24)?;
        Some((content.u32()?, content.text()?, content.u64()?))
    };
    let Some((sum, compression, _size)) = head() else {
        return Err(damaged(extent, "a chunk makes no sense"));
    };
    if !compression.is_empty() {
        return Err(LogError::Compressed(compression.to_owned()));
    }
    if sum != 0 && sum != check_sum(content.0) {
        return Err(damaged(extent, "a check sum is wrong"));
    }
    Ok(content)
}

/// Calls `take` with every record of a chunk.
fn each<E: From<LogError>>(
    mut records: Content<'_>,
    at_s: f64,
    mut take: impl FnMut(u8, &[u8]) -> Result<(), E>,
) -> Result<(), E> {
    while !records.0.is_empty() {
        let mut next = || {
            let code = *records.take(1)?.first()?;
            let length = usize::try_from(records.u64()?).ok()?;
            Some((code, records.take(length)?))
        };
        let Some((code, content)) = next() else {
            return Err(LogError::Damaged { at_s, what: "a record in a chunk makes no sense" }.into());
        };
        take(code, content)?;
    }
    Ok(())
}

fn hand_on<E: From<LogError>>(
    topics: &mut Topics,
    extent: &mut Extent,
    code: u8,
    content: &[u8],
    take: &mut impl FnMut(&Entry<'_>, &Extent) -> Result<(), E>,
) -> Result<(), E> {
    let Some(entry) = topics.take(code, content) else {
        return Err(damaged(extent, "a record makes no sense").into());
    };
    if let Some(entry) = entry {
        extent.messages += 1;
        extent.end_ns = extent.end_ns.max(entry.at_ns);
        take(&entry, extent)?;
    }
    Ok(())
}

fn damaged(extent: &Extent, what: &'static str) -> LogError {
    LogError::Damaged { at_s: extent.end_ns as f64 * 1e-9, what }
}
