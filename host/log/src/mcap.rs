//! Records of an MCAP file: `opcode: u8, length: u64, content`, everything little endian.
//!
//! Source: <https://mcap.dev/spec>.

use crc::{CRC_32_ISO_HDLC, Crc, Table};

/// At both ends of a file.
pub const MAGIC: &[u8; 8] = b"\x89MCAP0\r\n";
/// Opcode and length of a record, bytes.
pub const RECORD_HEAD: usize = 9;
/// What stands before the data of a message: channel, sequence, time of the log, time of its publishing; bytes.
pub const MESSAGE_HEAD: usize = 22;

/// Opcodes.
pub mod op {
    /// Profile, library.
    pub const HEADER: u8 = 0x01;
    /// Where the summary is.
    pub const FOOTER: u8 = 0x02;
    /// A type of messages.
    pub const SCHEMA: u8 = 0x03;
    /// A topic.
    pub const CHANNEL: u8 = 0x04;
    /// A message.
    pub const MESSAGE: u8 = 0x05;
    /// Records, with their check sum.
    pub const CHUNK: u8 = 0x06;
    /// Where the messages of a channel are in the chunk before.
    pub const MESSAGE_INDEX: u8 = 0x07;
    /// Where a chunk is.
    pub const CHUNK_INDEX: u8 = 0x08;
    /// Counts.
    pub const STATISTICS: u8 = 0x0b;
    /// Where records of a kind are in the summary.
    pub const SUMMARY_OFFSET: u8 = 0x0e;
    /// The end of what was logged.
    pub const DATA_END: u8 = 0x0f;
}

/// CRC-32, of which a zero says that there is none.
#[must_use]
pub fn check_sum(bytes: &[u8]) -> u32 {
    static CRC: Crc<u32, Table<16>> = Crc::<u32, Table<16>>::new(&CRC_32_ISO_HDLC);
    CRC.checksum(bytes)
}

/// Adds a record with what `write` puts into it.
pub fn record(out: &mut Vec<u8>, code: u8, write: impl FnOnce(&mut Vec<u8>)) {
    out.push(code);
    let at = out.len();
    out.extend_from_slice(&[0; 8]);
    write(out);
    let length = (out.len() - at - 8) as u64;
    if let Some(place) = out.get_mut(at..at + 8) {
        place.copy_from_slice(&length.to_le_bytes());
    }
}

/// Adds bytes behind their number.
pub fn bytes(out: &mut Vec<u8>, bytes: &[u8]) {
    out.extend_from_slice(&(bytes.len() as u32).to_le_bytes());
    out.extend_from_slice(bytes);
}

/// Adds text.
pub fn text(out: &mut Vec<u8>, text: &str) {
    bytes(out, text.as_bytes());
}

/// Content of a record, read from its beginning on.
#[derive(Clone, Copy, Debug)]
pub struct Content<'a>(pub &'a [u8]);

impl<'a> Content<'a> {
    /// The next `count` bytes.
    pub fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    /// A number of two bytes.
    pub fn u16(&mut self) -> Option<u16> {
        self.take(2)?.try_into().ok().map(u16::from_le_bytes)
    }

    /// A number of four bytes.
    pub fn u32(&mut self) -> Option<u32> {
        self.take(4)?.try_into().ok().map(u32::from_le_bytes)
    }

    /// A number of eight bytes.
    pub fn u64(&mut self) -> Option<u64> {
        self.take(8)?.try_into().ok().map(u64::from_le_bytes)
    }

    /// Bytes behind their number.
    pub fn bytes(&mut self) -> Option<&'a [u8]> {
        let count = self.u32()?;
        self.take(usize::try_from(count).ok()?)
    }

    /// Text.
    pub fn text(&mut self) -> Option<&'a str> {
        str::from_utf8(self.bytes()?).ok()
    }
}
