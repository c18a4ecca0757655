//! Writes a log as it happens.
//!
//! Messages go out in chunks, not compressed. A chunk is kept in memory and written in one piece, [`CHUNK_NS`] of fleet time or
//! [`CHUNK_BYTES`] after it began: what a killed process leaves behind reads up to there. Only the index at the end of the file is
//! missing then.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::marker::PhantomData;
use std::path::Path;

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{McapError, WriteOptions};

use super::cdr::Encoder;
use super::message::Message;

/// Length of a chunk, ns.
pub const CHUNK_NS: u64 = 1_000_000_000;
/// Size of a chunk, bytes.
pub const CHUNK_BYTES: u64 = 1 << 20;

/// A topic of a log, for messages of the type `M`.
#[derive(Debug)]
pub struct Topic<M> {
    id: u16,
    index: usize,
    message: PhantomData<fn(M)>,
}

impl<M> Clone for Topic<M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M> Copy for Topic<M> {}

/// See the module's documentation.
pub struct Writer<W: Write> {
    mcap: mcap::Writer<NoSeek<W>>,
    encoder: Encoder,
    /// Messages of each topic so far.
    counts: Vec<u32>,
    /// When the chunk that is being filled began, ns.
    began_ns: Option<u64>,
}

/// Into a file.
pub type FileWriter = Writer<BufWriter<File>>;

impl FileWriter {
    /// A new file; one that is there already is written over.
    ///
    /// # Errors
    /// The file system's.
    pub fn create(path: &Path) -> io::Result<Self> {
        Self::new(BufWriter::new(File::create(path)?))
    }
}

impl<W: Write> Writer<W> {
    /// Into `sink`.
    ///
    /// # Errors
    /// The sink's.
    pub fn new(sink: W) -> io::Result<Self> {
        let options = WriteOptions::new()
            .compression(None)
            .profile("ros2")
            .library(concat!("flotilla ", env!("CARGO_PKG_VERSION")))
            .disable_seeking(true)
            .calculate_data_section_crc(false)
            .chunk_size(Some(CHUNK_BYTES));
        let mcap = options.create(NoSeek::new(sink)).map_err(told)?;
        Ok(Self { mcap, encoder: Encoder::default(), counts: Vec::new(), began_ns: None })
    }

    /// Adds a topic.
    ///
    /// # Errors
    /// The sink's.
    pub fn topic<M: Message>(&mut self, name: &str) -> io::Result<Topic<M>> {
        let schema = self.mcap.add_schema(M::NAME, "ros2msg", M::schema().as_bytes()).map_err(told)?;
        let id = self.mcap.add_channel(schema, name, "cdr", &BTreeMap::new()).map_err(told)?;
        self.counts.push(0);
        Ok(Topic { id, index: self.counts.len() - 1, message: PhantomData })
    }

    /// Writes a message of the instant `at_ns`.
    ///
    /// # Errors
    /// The sink's.
    pub fn write<M: Message>(&mut self, topic: Topic<M>, at_ns: u64, message: &M) -> io::Result<()> {
        let began_ns = *self.began_ns.get_or_insert(at_ns);
        if at_ns.saturating_sub(began_ns) >= CHUNK_NS {
            self.flush()?;
            self.began_ns = Some(at_ns);
        }
        message.write(&mut self.encoder);
        let sequence = self.counts.get(topic.index).copied().unwrap_or_default();
        let header = MessageHeader { channel_id: topic.id, sequence, log_time: at_ns, publish_time: at_ns };
        self.mcap.write_to_known_channel(&header, self.encoder.bytes()).map_err(told)?;
        if let Some(count) = self.counts.get_mut(topic.index) {
            *count = sequence.wrapping_add(1);
        }
        Ok(())
    }

    /// Writes what is kept in memory.
    ///
    /// # Errors
    /// The sink's.
    pub fn flush(&mut self) -> io::Result<()> {
        self.mcap.flush().map_err(told)
    }

    /// Ends the log with its index.
    ///
    /// # Errors
    /// The sink's.
    pub fn finish(mut self) -> io::Result<()> {
        self.mcap.finish().map_err(told)?;
        self.mcap.into_inner().into_inner().flush()
    }
}

/// All that can go wrong with a log of known topics is its file.
fn told(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        error => io::Error::other(error),
    }
}
