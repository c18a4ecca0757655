//! Packets, and how a stream is cut into them.

use crate::bytes::{Malformed, Reader, put_text, text_of};

/// The port for little-endian clients: one above the base port 22222.
pub const PORT: u16 = 22_223;
/// Length of a packet's header, bytes.
const HEADER: usize = 8;
/// The largest packet that is taken, bytes. *Assumed*: settings of hundreds of bodies; images and files are not asked for.
const LARGEST: usize = 1 << 24;

/// A packet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Packet {
    /// Type 0: what went wrong.
    Error(String),
    /// Type 1: a command or the answer to one.
    Command(String),
    /// Type 2: settings.
    Xml(String),
    /// Type 3: a frame; for [`super::data`].
    Data(Vec<u8>),
    /// Type 4: nothing is measured.
    NoMoreData,
    /// Type 6: an event.
    Event(u8),
    /// Another type, which is passed over.
    Other(u32),
}

/// Events that are used here.
#[expect(missing_docs, reason = "the names of the documentation")]
pub mod event {
    pub const CONNECTED: u8 = 1;
    pub const CONNECTION_CLOSED: u8 = 2;
    pub const CAPTURE_STARTED: u8 = 3;
    pub const RT_FROM_FILE_STARTED: u8 = 8;
    pub const CAMERA_SETTINGS_CHANGED: u8 = 11;
    pub const QTM_SHUTTING_DOWN: u8 = 12;
}

impl Packet {
    /// From a packet's type and content.
    ///
    /// # Errors
    /// An event without a number.
    fn decode(kind: u32, content: &[u8]) -> Result<Self, Malformed> {
        Ok(match kind {
            0 => Self::Error(text_of(content)),
            1 => Self::Command(text_of(content)),
            2 => Self::Xml(text_of(content)),
            3 => Self::Data(content.to_vec()),
            4 => Self::NoMoreData,
            6 => Self::Event(Reader::new(content).u8()?),
            other => Self::Other(other),
        })
    }

    /// As bytes.
    pub fn encode(&self) -> Vec<u8> {
        let mut content = Vec::new();
        let kind: u32 = match self {
            Self::Error(text) => text_packet(&mut content, text, 0),
            Self::Command(text) => text_packet(&mut content, text, 1),
            Self::Xml(text) => text_packet(&mut content, text, 2),
            Self::Data(data) => {
                content.extend(data);
                3
            }
            Self::NoMoreData => 4,
            Self::Event(event) => {
                content.push(*event);
                6
            }
            Self::Other(kind) => *kind,
        };
        let size = u32::try_from(HEADER + content.len()).unwrap_or(u32::MAX);
        [&size.to_le_bytes()[..], &kind.to_le_bytes(), &content].concat()
    }
}

fn text_packet(content: &mut Vec<u8>, text: &str, kind: u32) -> u32 {
    put_text(content, text);
    kind
}

/// The first packet of `stream`, which it is taken from; `None` until it is whole.
///
/// # Errors
/// A size that no packet has: the stream cannot be followed any more.
pub fn take(stream: &mut Vec<u8>) -> Result<Option<Packet>, Malformed> {
    let mut reader = Reader::new(stream);
    let (Ok(size), Ok(kind)) = (reader.u32_le(), reader.u32_le()) else { return Ok(None) };
    let size = usize::try_from(size).unwrap_or(usize::MAX);
    if !(HEADER..=LARGEST).contains(&size) {
        return Err(Malformed { what: "a size that no packet has", at: 0 });
    }
    let Ok(content) = reader.take(size - HEADER) else { return Ok(None) };
    let packet = Packet::decode(kind, content);
    stream.drain(..size);
    packet.map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_is_cut_where_packets_end() {
        let packets = [
            Packet::Command("Version set to 1.23".into()),
            Packet::Event(event::CONNECTED),
            Packet::NoMoreData,
            Packet::Data(vec![1, 2, 3]),
            Packet::Other(5),
        ];
        let bytes: Vec<u8> = packets.iter().flat_map(Packet::encode).collect();
        let mut stream = Vec::new();
        let mut found = Vec::new();
        for byte in bytes {
            stream.push(byte);
            while let Some(packet) = take(&mut stream).expect("its own packets") {
                found.push(packet);
            }
        }
        assert_eq!(found, packets);
        assert!(stream.is_empty());
    }

    #[test]
    fn the_documentation_s_example_of_a_command() {
        let bytes = Packet::Command("Version 1.2".into()).encode();
        assert_eq!(&bytes[..8], [20, 0, 0, 0, 1, 0, 0, 0]);
        assert_eq!(&bytes[8..], b"Version 1.2\0");
    }

    #[test]
    fn sizes_that_no_packet_has_end_the_stream() {
        assert!(take(&mut vec![7, 0, 0, 0, 1, 0, 0, 0]).is_err());
        assert!(take(&mut vec![255, 255, 255, 255, 1, 0, 0, 0]).is_err());
        assert_eq!(take(&mut vec![9, 0, 0, 0, 1, 0, 0, 0]), Ok(None));
    }
}
