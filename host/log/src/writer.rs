//! Writes a log as it happens.
//!
//! Messages go out in chunks, not compressed. A chunk is kept in memory and written in one piece, [`CHUNK_NS`] of fleet time or
//! [`CHUNK_BYTES`] after it began: what a killed process leaves behind reads up to there. Only the index at the end of the file is
//! missing then.
//!
//! Source: the MCAP specification, <https://mcap.dev/spec>: `Header, (Chunk, MessageIndex…)…, DataEnd, Schema…, Channel…, Statistics,
//! ChunkIndex…, SummaryOffset…, Footer`.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::marker::PhantomData;
use std::path::Path;

use super::cdr::Encoder;
use super::mcap::{self, MAGIC, op};
use super::message::Message;

/// Length of a chunk, ns.
pub const CHUNK_NS: u64 = 1_000_000_000;
/// Size of a chunk, bytes.
pub const CHUNK_BYTES: usize = 1 << 20;

/// What gets each message that is written, as it is written: a console, a stream.
pub trait Tap: Send {
    /// A topic is new: its number, its name, and the name and definition of its type.
    fn topic(&mut self, channel: u16, name: &str, schema: &'static str, definition: String);

    /// A message of a topic, in CDR.
    fn message(&mut self, channel: u16, at_ns: u64, data: &[u8]);
}

/// A topic of a log, for messages of the type `M`.
#[derive(Debug)]
pub struct Topic<M> {
    /// Its place among the channels; its number there is one more.
    index: usize,
    message: PhantomData<fn(M)>,
}

impl<M> Clone for Topic<M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M> Copy for Topic<M> {}

/// One topic as the file has it.
#[derive(Default)]
struct Channel {
    /// Its record.
    record: Vec<u8>,
    /// Messages so far.
    count: u32,
    /// Messages of the chunk that is being filled: time and offset of each, as they lie in the index.
    index: Vec<u8>,
}

/// Where the messages of a chunk are.
struct ChunkIndex {
    bounds_ns: [u64; 2],
    start: u64,
    length: u64,
    /// Where the index of each channel is.
    offsets: Vec<u8>,
    index_length: u64,
    size: u64,
}

/// See the module's documentation.
pub struct Writer<W: Write> {
    sink: W,
    /// Bytes written.
    position: u64,
    encoder: Encoder,
    /// Names of types, and their records.
    schemas: Vec<(&'static str, Vec<u8>)>,
    channels: Vec<Channel>,
    /// Records of the chunk that is being filled.
    chunk: Vec<u8>,
    /// The least and the greatest time of its messages, if it has any, ns.
    bounds_ns: Option<[u64; 2]>,
    chunks: Vec<ChunkIndex>,
    /// What goes to the sink next.
    out: Vec<u8>,
    tap: Option<Box<dyn Tap>>,
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
        let mut writer = Self {
            sink,
            position: 0,
            encoder: Encoder::default(),
            schemas: Vec::new(),
            channels: Vec::new(),
            chunk: Vec::new(),
            bounds_ns: None,
            chunks: Vec::new(),
            out: Vec::new(),
            tap: None,
        };
        writer.out.extend_from_slice(MAGIC);
        mcap::record(&mut writer.out, op::HEADER, |out| {
            mcap::text(out, "ros2");
            mcap::text(out, concat!("flotilla ", env!("CARGO_PKG_VERSION")));
        });
        writer.send()?;
        Ok(writer)
    }

    /// With `tap`, before the first topic.
    #[must_use]
    pub fn tapped(mut self, tap: Box<dyn Tap>) -> Self {
        self.tap = Some(tap);
        self
    }

    /// Adds a topic.
    ///
    /// # Errors
    /// [`io::ErrorKind::InvalidInput`] for more topics than a log has numbers for.
    pub fn topic<M: Message>(&mut self, name: &str) -> io::Result<Topic<M>> {
        let id = number(self.channels.len())?;
        let schema = match self.schemas.iter().position(|(known, _)| *known == M::NAME) {
            Some(index) => number(index)?,
            None => {
                let (schema, mut record) = (number(self.schemas.len())?, Vec::new());
                mcap::record(&mut record, op::SCHEMA, |out| {
                    out.extend_from_slice(&schema.to_le_bytes());
                    mcap::text(out, M::NAME);
                    mcap::text(out, "ros2msg");
                    mcap::text(out, &M::schema());
                });
                self.chunk.extend_from_slice(&record);
                self.schemas.push((M::NAME, record));
                schema
            }
        };
        let mut record = Vec::new();
        mcap::record(&mut record, op::CHANNEL, |out| {
            out.extend_from_slice(&id.to_le_bytes());
            out.extend_from_slice(&schema.to_le_bytes());
            mcap::text(out, name);
            mcap::text(out, "cdr");
            // No metadata.
            out.extend_from_slice(&0_u32.to_le_bytes());
        });
        self.chunk.extend_from_slice(&record);
        self.channels.push(Channel { record, ..Channel::default() });
        if let Some(tap) = &mut self.tap {
            tap.topic(id, name, M::NAME, M::schema());
        }
        Ok(Topic { index: self.channels.len() - 1, message: PhantomData })
    }

    /// Writes a message of the instant `at_ns`.
    ///
    /// # Errors
    /// The sink's.
    pub fn write<M: Message>(&mut self, topic: Topic<M>, at_ns: u64, message: &M) -> io::Result<()> {
        let is_over = |[began_ns, _]: [u64; 2]| at_ns.saturating_sub(began_ns) >= CHUNK_NS;
        if self.bounds_ns.is_some_and(is_over) || self.chunk.len() >= CHUNK_BYTES {
            self.flush()?;
        }
        message.write(&mut self.encoder);
        let [least_ns, most_ns] = self.bounds_ns.unwrap_or([at_ns; 2]);
        self.bounds_ns = Some([least_ns.min(at_ns), most_ns.max(at_ns)]);
        let (id, offset) = (number(topic.index)?, self.chunk.len() as u64);
        let Some(channel) = self.channels.get_mut(topic.index) else {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "a topic of another log"));
        };
        channel.index.extend_from_slice(&at_ns.to_le_bytes());
        channel.index.extend_from_slice(&offset.to_le_bytes());
        let data = self.encoder.bytes();
        if let Some(tap) = &mut self.tap {
            tap.message(id, at_ns, data);
        }
        self.chunk.push(op::MESSAGE);
        self.chunk.extend_from_slice(&(mcap::MESSAGE_HEAD as u64 + data.len() as u64).to_le_bytes());
        self.chunk.extend_from_slice(&id.to_le_bytes());
        self.chunk.extend_from_slice(&channel.count.to_le_bytes());
        self.chunk.extend_from_slice(&at_ns.to_le_bytes());
        self.chunk.extend_from_slice(&at_ns.to_le_bytes());
        self.chunk.extend_from_slice(data);
        channel.count = channel.count.wrapping_add(1);
        Ok(())
    }

    /// Writes what is kept in memory.
    ///
    /// # Errors
    /// The sink's.
    pub fn flush(&mut self) -> io::Result<()> {
        let Some(bounds_ns) = self.bounds_ns.take() else { return Ok(()) };
        let (start, size) = (self.position, self.chunk.len() as u64);
        mcap::record(&mut self.out, op::CHUNK, |out| {
            bounds_ns.iter().for_each(|bound_ns| out.extend_from_slice(&bound_ns.to_le_bytes()));
            out.extend_from_slice(&size.to_le_bytes());
            out.extend_from_slice(&mcap::check_sum(&self.chunk).to_le_bytes());
            mcap::text(out, "");
            out.extend_from_slice(&size.to_le_bytes());
            out.extend_from_slice(&self.chunk);
        });
        self.chunk.clear();
        let length = self.out.len() as u64;
        let mut offsets = Vec::new();
        for (id, channel) in (1_u16..).zip(&mut self.channels) {
            if channel.index.is_empty() {
                continue;
            }
            offsets.extend_from_slice(&id.to_le_bytes());
            offsets.extend_from_slice(&(start + self.out.len() as u64).to_le_bytes());
            mcap::record(&mut self.out, op::MESSAGE_INDEX, |out| {
                out.extend_from_slice(&id.to_le_bytes());
                mcap::bytes(out, &channel.index);
            });
            channel.index.clear();
        }
        let index_length = self.out.len() as u64 - length;
        self.chunks.push(ChunkIndex { bounds_ns, start, length, offsets, index_length, size });
        self.send()?;
        self.sink.flush()
    }

    /// Hands on what is to go to the sink, in one piece.
    fn send(&mut self) -> io::Result<()> {
        self.position += self.out.len() as u64;
        let outcome = self.sink.write_all(&self.out);
        self.out.clear();
        outcome
    }

    /// Ends the log with its index.
    ///
    /// # Errors
    /// The sink's.
    pub fn finish(mut self) -> io::Result<()> {
        self.flush()?;
        mcap::record(&mut self.out, op::DATA_END, |out| out.extend_from_slice(&0_u32.to_le_bytes()));
        self.send()?;
        let summary = self.position;
        let mut groups = Vec::new();
        let mut group = |out: &mut Vec<u8>, code: u8, write: &dyn Fn(&mut Vec<u8>)| {
            let start = out.len();
            write(out);
            if out.len() > start {
                groups.push((code, summary + start as u64, (out.len() - start) as u64));
            }
        };
        group(&mut self.out, op::SCHEMA, &|out| {
            self.schemas.iter().for_each(|(_, record)| out.extend_from_slice(record));
        });
        group(&mut self.out, op::CHANNEL, &|out| {
            self.channels.iter().for_each(|channel| out.extend_from_slice(&channel.record));
        });
        group(&mut self.out, op::STATISTICS, &|out| {
            mcap::record(out, op::STATISTICS, |out| {
                statistics(out, self.schemas.len(), &self.channels, &self.chunks);
            });
        });
        group(&mut self.out, op::CHUNK_INDEX, &|out| {
            self.chunks.iter().for_each(|chunk| chunk_index(out, chunk));
        });
        let offsets = summary + self.out.len() as u64;
        for (code, start, length) in groups {
            mcap::record(&mut self.out, op::SUMMARY_OFFSET, |out| {
                out.push(code);
                out.extend_from_slice(&start.to_le_bytes());
                out.extend_from_slice(&length.to_le_bytes());
            });
        }
        // The footer's check sum is of everything from the summary's beginning up to itself.
        self.out.push(op::FOOTER);
        self.out.extend_from_slice(&20_u64.to_le_bytes());
        self.out.extend_from_slice(&summary.to_le_bytes());
        self.out.extend_from_slice(&offsets.to_le_bytes());
        let sum = mcap::check_sum(&self.out);
        self.out.extend_from_slice(&sum.to_le_bytes());
        self.out.extend_from_slice(MAGIC);
        self.send()?;
        self.sink.flush()
    }
}

/// Numbers in a log count from 1.
fn number(index: usize) -> io::Result<u16> {
    let number = u16::try_from(index + 1);
    number.map_err(|_| io::Error::new(io::ErrorKind::InvalidInput, "more than 65535 topics"))
}

fn statistics(out: &mut Vec<u8>, schemas: usize, channels: &[Channel], chunks: &[ChunkIndex]) {
    let messages: u64 = channels.iter().map(|channel| u64::from(channel.count)).sum();
    out.extend_from_slice(&messages.to_le_bytes());
    out.extend_from_slice(&(schemas as u16).to_le_bytes());
    // Attachments and metadata: none.
    for count in [channels.len() as u32, 0, 0, chunks.len() as u32] {
        out.extend_from_slice(&count.to_le_bytes());
    }
    let least_ns = chunks.iter().map(|chunk| chunk.bounds_ns[0]).min().unwrap_or(0);
    let most_ns = chunks.iter().map(|chunk| chunk.bounds_ns[1]).max().unwrap_or(0);
    out.extend_from_slice(&least_ns.to_le_bytes());
    out.extend_from_slice(&most_ns.to_le_bytes());
    let mut counts = Vec::new();
    for (id, channel) in (1_u16..).zip(channels) {
        counts.extend_from_slice(&id.to_le_bytes());
        counts.extend_from_slice(&u64::from(channel.count).to_le_bytes());
    }
    mcap::bytes(out, &counts);
}

fn chunk_index(out: &mut Vec<u8>, chunk: &ChunkIndex) {
    mcap::record(out, op::CHUNK_INDEX, |out| {
        for number in [chunk.bounds_ns[0], chunk.bounds_ns[1], chunk.start, chunk.length] {
            out.extend_from_slice(&number.to_le_bytes());
        }
        mcap::bytes(out, &chunk.offsets);
        out.extend_from_slice(&chunk.index_length.to_le_bytes());
        mcap::text(out, "");
        out.extend_from_slice(&chunk.size.to_le_bytes());
        out.extend_from_slice(&chunk.size.to_le_bytes());
    });
}
