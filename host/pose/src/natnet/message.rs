//! Headers, versions, the server's information and requests.

use std::fmt;
use std::net::Ipv4Addr;

use crate::bytes::{Malformed, Reader, put_text, text_of};

/// The port that clients ask on.
pub const COMMAND_PORT: u16 = 1510;
/// The port that frames come on.
pub const DATA_PORT: u16 = 1511;
/// The group that frames are sent to.
pub const GROUP: Ipv4Addr = Ipv4Addr::new(239, 255, 42, 99);

/// Length of a message's header, bytes.
const HEADER: usize = 4;
/// Length of a name in a fixed field, bytes.
const NAME: usize = 256;
/// The largest payload, bytes: `MAX_PACKETSIZE`.
pub const LARGEST: usize = 65_503;

/// Kinds of messages that are used here.
#[expect(missing_docs, reason = "the names of NatNetTypes.h")]
pub mod kind {
    pub const CONNECT: u16 = 0;
    pub const SERVER_INFO: u16 = 1;
    pub const REQUEST: u16 = 2;
    pub const RESPONSE: u16 = 3;
    pub const REQUEST_MODEL_DEF: u16 = 4;
    pub const MODEL_DEF: u16 = 5;
    pub const REQUEST_FRAME_OF_DATA: u16 = 6;
    pub const FRAME_OF_DATA: u16 = 7;
    pub const DISCONNECT: u16 = 9;
    pub const KEEP_ALIVE: u16 = 10;
    pub const ECHO_REQUEST: u16 = 12;
    pub const ECHO_RESPONSE: u16 = 13;
    pub const UNRECOGNIZED_REQUEST: u16 = 100;
}

/// A version of the protocol, which decides how messages are laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Version {
    /// The first number.
    pub major: u8,
    /// The second number.
    pub minor: u8,
}

impl Version {
    /// Motive 2.
    pub const V3_0: Self = Self { major: 3, minor: 0 };
    /// Motive 2.1 and 2.2.
    pub const V3_1: Self = Self { major: 3, minor: 1 };
    /// Motive 3.0.
    pub const V4_0: Self = Self { major: 4, minor: 0 };
    /// Motive 3.1.
    pub const V4_1: Self = Self { major: 4, minor: 1 };
    /// What `PacketClient.cpp` of the SDK 4.2 reads.
    pub const V4_2: Self = Self { major: 4, minor: 2 };

    /// Whether messages of this version are read here.
    pub fn is_read(self) -> bool {
        self.major == 3 || (Self::V4_0..=Self::V4_2).contains(&self)
    }

    /// Whether a newer server can be asked for [`Version::V4_1`] instead.
    pub fn can_step_down(self) -> bool {
        self.major == 4 && self > Self::V4_2
    }

    /// Whether sections carry their length.
    pub fn has_lengths(self) -> bool {
        self >= Self::V4_1
    }
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.major, self.minor)
    }
}

/// What a server says of itself: `sSender_Server`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ServerInfo {
    /// Its name, such as `Motive`.
    pub application: String,
    /// Its own version.
    pub application_version: [u8; 4],
    /// The protocol's version; messages after this one follow it unless another was agreed.
    pub version: Version,
    /// Ticks a second of the clock that frames are stamped with.
    pub clock_hz: u64,
    /// The port that frames come on.
    pub data_port: u16,
    /// The group that frames are sent to; `None` for unicast.
    pub group: Option<Ipv4Addr>,
}

impl ServerInfo {
    /// From a payload. A server before 3.0 ends after the versions; the rest is zero then.
    ///
    /// # Errors
    /// A payload that is too short.
    pub fn decode(payload: &[u8]) -> Result<Self, Malformed> {
        let mut reader = Reader::new(payload);
        let application = text_of(reader.take(NAME)?);
        let application_version = reader.array()?;
        let [major, minor, ..] = reader.array::<4>()?;
        let version = Version { major, minor };
        let (mut clock_hz, mut data_port, mut group) = (0, 0, None);
        if major >= 3 {
            clock_hz = reader.u64_le()?;
            data_port = reader.u16_le()?;
            let multicast = reader.u8()? != 0;
            let address = Ipv4Addr::from(reader.array::<4>()?);
            group = (multicast && address.is_multicast()).then_some(address);
            if clock_hz == 0 {
                return Err(reader.malformed("a clock without ticks"));
            }
        }
        Ok(Self { application, application_version, version, clock_hz, data_port, group })
    }

    /// As a message.
    pub fn encode(&self) -> Vec<u8> {
        message(kind::SERVER_INFO, |out| {
            put_name(out, &self.application);
            out.extend(self.application_version);
            out.extend([self.version.major, self.version.minor, 0, 0]);
            out.extend(self.clock_hz.to_le_bytes());
            out.extend(self.data_port.to_le_bytes());
            out.push(u8::from(self.group.is_some()));
            out.extend(self.group.unwrap_or(GROUP).octets());
        })
    }
}

/// Text in a field of fixed length, cut where it does not fit.
fn put_name(out: &mut Vec<u8>, name: &str) {
    let start = out.len();
    out.extend(name.bytes().take(NAME - 1));
    out.resize(start + NAME, 0);
}

/// A message: its header, and the payload that `fill` writes.
pub fn message(kind: u16, fill: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let mut out = Vec::with_capacity(512);
    out.extend(kind.to_le_bytes());
    out.extend([0, 0]);
    fill(&mut out);
    // A payload of 64 KiB or more does not fit into a datagram anyway.
    let length = u16::try_from(out.len() - HEADER).unwrap_or(u16::MAX);
    if let Some(field) = out.get_mut(2..HEADER) {
        field.copy_from_slice(&length.to_le_bytes());
    }
    out
}

/// A datagram's kind and payload. The length in the header is left aside: the datagram's own is what there is.
///
/// # Errors
/// A datagram shorter than a header.
pub fn split(datagram: &[u8]) -> Result<(u16, &[u8]), Malformed> {
    let mut reader = Reader::new(datagram);
    let kind = reader.u16_le()?;
    reader.u16_le()?;
    Ok((kind, reader.take(reader.left())?))
}

/// The hello of a client: `sSender`, then `sConnectionOptions` with the bitstream left to the server.
pub fn connect() -> Vec<u8> {
    message(kind::CONNECT, |out| {
        put_name(out, "flotilla");
        out.extend([0, 1, 0, 0]);
        out.extend([Version::V4_1.major, Version::V4_1.minor, 0, 0]);
        out.extend([0; 5]);
        out.push(0);
    })
}

/// The bitstream that a hello asks for, `None` for the server's own.
pub fn wanted_bitstream(payload: &[u8]) -> Option<Version> {
    let mut reader = Reader::new(payload);
    reader.take(NAME + 4 + 4 + 1).ok()?;
    let [major, minor, ..] = reader.array::<4>().ok()?;
    (major != 0).then_some(Version { major, minor })
}

/// A request in words, such as `Bitstream,4.1`.
pub fn request(text: &str) -> Vec<u8> {
    message(kind::REQUEST, |out| put_text(out, text))
}

/// A question for the server's clock; `stamp` comes back with the answer.
pub fn echo_request(stamp: u64) -> Vec<u8> {
    message(kind::ECHO_REQUEST, |out| out.extend(stamp.to_le_bytes()))
}

/// An answer's stamp and the ticks of the server's clock.
///
/// # Errors
/// A payload that is too short.
pub fn echo_response(payload: &[u8]) -> Result<(u64, u64), Malformed> {
    let mut reader = Reader::new(payload);
    Ok((reader.u64_le()?, reader.u64_le()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn information_survives_the_wire() {
        let info = ServerInfo {
            application: "Motive".into(),
            application_version: [3, 1, 2, 1],
            version: Version::V4_1,
            clock_hz: 10_000_000,
            data_port: DATA_PORT,
            group: Some(GROUP),
        };
        let datagram = info.encode();
        assert_eq!(datagram.len(), 283, "as long as Motive's own");
        let (kind, payload) = split(&datagram).expect("a header");
        assert_eq!(kind, kind::SERVER_INFO);
        assert_eq!(ServerInfo::decode(payload), Ok(info));
    }

    #[test]
    fn the_hello_is_as_long_as_the_sample_client_s_and_leaves_the_bitstream_open() {
        let datagram = connect();
        assert_eq!(datagram.len(), 4 + 264 + 6);
        let (_, payload) = split(&datagram).expect("a header");
        assert_eq!(wanted_bitstream(payload), None);
        let mut asking = payload.to_vec();
        asking[265..269].copy_from_slice(&[3, 1, 0, 0]);
        assert_eq!(wanted_bitstream(&asking), Some(Version::V3_1));
        assert_eq!(wanted_bitstream(&[]), None);
    }
}
