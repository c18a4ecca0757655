//! Framing: one datagram.
//!
//! ```text
//! version 1 B │ seal 1 B │ Header (postcard) │ Message (postcard) │ trailer
//! ```
//!
//! The [`Seal`] says what the trailer is. A checksum guards against what slips past UDP's own; it proves nothing
//! about the sender. The authenticated seal has its number and its room (a 16-byte tag fits after the largest
//! message) and is refused until it exists.

use crc::{CRC_32_ISO_HDLC, Crc};
use serde::{Deserialize, Serialize};

use crate::message::{Message, ModuleId, WIRE_VERSION};

/// No datagram is longer, in bytes.
pub const MAX_DATAGRAM: usize = 512;

/// Room kept at the end of every datagram, in bytes: the tag of the authenticated seal.
pub const MAX_TRAILER: usize = 16;

const CRC32: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);
const CRC32_LEN: usize = 4;

/// What guards a datagram: its second byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Seal {
    /// Trailer: CRC-32 (ISO-HDLC), little endian, of everything before it.
    Checksum = 0,
    /// Trailer: 128-bit authentication tag. Reserved.
    Authenticated = 1,
}

/// Whose datagram this is, and which.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// The module that sends it, or that it is for.
    pub module: ModuleId,
    /// Drawn at the sender's boot: tells its lives apart.
    pub session: u32,
    /// Counts the sender's datagrams in this session, from 0.
    pub sequence: u32,
}

/// Why a message could not become a datagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EncodeError {
    /// The buffer has fewer bytes than the datagram needs.
    BufferTooSmall {
        /// Length of the buffer, bytes.
        have: usize,
    },
}

/// Why bytes are not a datagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DecodeError {
    /// Longer than [`MAX_DATAGRAM`] or too short to hold anything.
    Length(usize),
    /// Another wire version.
    Version(u8),
    /// A seal this build does not know.
    Seal(u8),
    /// The checksum does not match: damaged on the way.
    Checksum,
    /// Header or message is not valid postcard, or bytes are left over.
    Malformed,
}

impl core::fmt::Display for DecodeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Length(bytes) => write!(f, "{bytes} bytes are no datagram (at most {MAX_DATAGRAM})"),
            Self::Version(version) => write!(f, "wire version {version}, this build speaks {WIRE_VERSION}"),
            Self::Seal(seal) => write!(f, "unknown seal {seal}"),
            Self::Checksum => f.write_str("checksum mismatch"),
            Self::Malformed => f.write_str("malformed header or message"),
        }
    }
}

impl core::error::Error for DecodeError {}

/// Writes `message` as one datagram to the start of `buffer` and returns that part.
///
/// # Errors
/// [`EncodeError::BufferTooSmall`]; never with a buffer of [`MAX_DATAGRAM`] bytes.
pub fn encode<'a>(header: &Header, message: &Message, buffer: &'a mut [u8]) -> Result<&'a [u8], EncodeError> {
    let have = buffer.len();
    let too_small = EncodeError::BufferTooSmall { have };
    let body = {
        let (front, rest) = buffer.split_first_chunk_mut::<2>().ok_or(too_small)?;
        *front = [WIRE_VERSION, Seal::Checksum as u8];
        let room = rest.len().saturating_sub(CRC32_LEN);
        let rest = rest.get_mut(..room).ok_or(too_small)?;
        postcard::to_slice(&(header, message), rest).map_err(|_| too_small)?.len()
    };
    let guarded = body.saturating_add(2);
    let total = guarded.saturating_add(CRC32_LEN);
    let checksum = CRC32.checksum(buffer.get(..guarded).ok_or(too_small)?);
    let trailer = buffer.get_mut(guarded..total).ok_or(too_small)?;
    trailer.copy_from_slice(&checksum.to_le_bytes());
    buffer.get(..total).ok_or(too_small)
}

/// Reads one datagram.
///
/// # Errors
/// [`DecodeError`] says what is wrong with it; no input panics.
pub fn decode(datagram: &[u8]) -> Result<(Header, Message), DecodeError> {
    let length = DecodeError::Length(datagram.len());
    if datagram.len() > MAX_DATAGRAM {
        return Err(length);
    }
    let (&[version, seal], rest) = datagram.split_first_chunk::<2>().ok_or(length)?;
    if version != WIRE_VERSION {
        return Err(DecodeError::Version(version));
    }
    if seal != Seal::Checksum as u8 {
        return Err(DecodeError::Seal(seal));
    }
    let (body, &trailer) = rest.split_last_chunk::<CRC32_LEN>().ok_or(length)?;
    let guarded = datagram.len().saturating_sub(CRC32_LEN);
    let checksum = CRC32.checksum(datagram.get(..guarded).ok_or(length)?);
    if checksum.to_le_bytes() != trailer {
        return Err(DecodeError::Checksum);
    }
    match postcard::take_from_bytes(body) {
        Ok((content, [])) => Ok(content),
        _ => Err(DecodeError::Malformed),
    }
}
