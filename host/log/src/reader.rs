//! Reads a log from its beginning to its end, or to where it is cut.

use std::collections::HashMap;
use std::io::{self, ErrorKind, Read};

use mcap::McapError;
use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use thiserror::Error;

use super::cdr::CdrError;

/// No record of a log is longer, bytes; *assumed*.
const RECORD_MAX: usize = 256 << 20;
/// The first bytes of every MCAP file.
const MAGIC: [u8; 5] = *b"\x89MCAP";

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
    #[error("damaged after {at_s:.3} s: {source}")]
    Damaged {
        /// Time of the last message before, s.
        at_s: f64,
        /// What is wrong.
        source: McapError,
    },
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
    /// Takes down what a record says of topics; the message, if it is one.
    fn take<'a>(&'a mut self, record: &'a Record<'a>) -> Option<Entry<'a>> {
        match record {
            Record::Schema { header, data } => {
                let definition = (header.encoding == "ros2msg").then(|| str::from_utf8(data).ok()).flatten();
                self.schemas.insert(header.id, (header.name.clone(), definition.map(str::to_owned)));
                None
            }
            Record::Channel(channel) => {
                self.channels.insert(channel.id, (channel.topic.clone(), channel.schema_id));
                None
            }
            Record::Message { header, data } => {
                let (topic, schema) = self.channels.get(&header.channel_id)?;
                let (schema, definition) =
                    self.schemas.get(schema).map_or(("", None), |(name, text)| (name, text.as_deref()));
                Some(Entry {
                    topic,
                    channel: header.channel_id,
                    schema,
                    definition,
                    at_ns: header.log_time,
                    data,
                })
            }
            _ => None,
        }
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
    let options =
        LinearReaderOptions::default().with_prevalidate_chunk_crcs(true).with_record_length_limit(RECORD_MAX);
    let mut reader = LinearReader::new_with_options(options);
    let mut head = Vec::new();
    loop {
        match reader.next_event() {
            None => {
                extent.whole = true;
                return Ok(extent);
            }
            Some(Ok(LinearReadEvent::ReadRequest(bytes))) => {
                let space = reader.insert(bytes);
                let read = loop {
                    match source.read(space) {
                        Err(error) if error.kind() == ErrorKind::Interrupted => {}
                        outcome => break outcome.map_err(LogError::File)?,
                    }
                };
                let wanted = MAGIC.len().saturating_sub(head.len()).min(read);
                head.extend_from_slice(space.get(..wanted).unwrap_or_default());
                if !MAGIC.starts_with(&head) || read == 0 && head.len() < MAGIC.len() {
                    return Err(LogError::NoLog.into());
                }
                extent.bytes += read as u64;
                reader.notify_read(read);
            }
            Some(Ok(LinearReadEvent::Record { opcode, data })) => {
                let record = mcap::parse_record(opcode, data);
                let record = record.map_err(|source| damaged(&extent, source))?;
                if let Some(entry) = topics.take(&record) {
                    extent.messages += 1;
                    extent.end_ns = extent.end_ns.max(entry.at_ns);
                    take(&entry, &extent)?;
                }
            }
            Some(Err(McapError::UnexpectedEof | McapError::UnexpectedEoc)) => return Ok(extent),
            Some(Err(McapError::BadMagic)) if extent.messages == 0 => return Err(LogError::NoLog.into()),
            Some(Err(source)) => return Err(damaged(&extent, source).into()),
        }
    }
}

fn damaged(extent: &Extent, source: McapError) -> LogError {
    LogError::Damaged { at_s: extent.end_ns as f64 * 1e-9, source }
}
