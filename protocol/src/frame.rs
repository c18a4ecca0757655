//! Framing: the parts of a datagram that can be read without keys.
//!
//! ```text
//! version 1 │ kind 1 │ fleet 4 │ module 2 │ session 4 │ sequence 4 │ [nonce 16] │ sealed … │ tag 16 │ CRC-32 4
//! ╰───────────────────── header, authenticated, in the clear ──────────────────╯
//! ```
//!
//! Integers are little endian. The nonce is there only in the kinds that belong to no session yet ([`Kind::carries_nonce`]). What is sealed is
//! the postcard of a [`Receipt`](crate::ledger::Receipt) and a [`Message`](crate::Message). Over that the datagram is
//! longer by [`OVERHEAD`] bytes.
//!
//! Two guards, for two questions. The checksum (CRC-32, ISO-HDLC) tells damage on the way, which is accidental and
//! cheap to see; the 128-bit tag proves who sent it. A datagram with a right checksum and a wrong tag was *made* wrong.

use crc::{CRC_32_ISO_HDLC, Crc};

use crate::keys::{FleetId, Nonce};
use crate::message::{ModuleId, WIRE_VERSION};

/// No datagram is longer, in bytes.
pub const MAX_DATAGRAM: usize = 512;

/// Bytes of the header without a nonce.
pub const HEADER: usize = 16;
/// Bytes of a nonce.
pub const NONCE: usize = 16;
/// Bytes of the authentication tag.
pub const TAG: usize = 16;
/// Bytes of the checksum.
pub const CHECKSUM: usize = 4;
/// What a datagram of a session has more than its sealed bytes.
pub const OVERHEAD: usize = HEADER + TAG + CHECKSUM;

const CRC32: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// CRC-32, ISO-HDLC, of `bytes`: what tells damage from what was written.
#[must_use]
pub fn checksum(bytes: &[u8]) -> u32 {
    CRC32.checksum(bytes)
}

/// What a datagram is for: its second byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// A module announces itself: its boot nonce in the clear, sealed with the key of that boot.
    Announce = 1,
    /// The host answers an announcement: its own nonce in the clear, sealed with the key of the session that the two make.
    Call = 2,
    /// Host to module, within a session.
    ToModule = 3,
    /// Module to host, within a session.
    ToHost = 4,
    /// Any host with the fleet's key stops a module that announces itself, whichever host that serves: the boot nonce of the announcement in
    /// the clear, sealed with the key of that announcement.
    Stop = 5,
}

impl Kind {
    const fn of(byte: u8) -> Option<Self> {
        match byte {
            1 => Some(Self::Announce),
            2 => Some(Self::Call),
            3 => Some(Self::ToModule),
            4 => Some(Self::ToHost),
            5 => Some(Self::Stop),
            _ => None,
        }
    }

    /// True for those that carry a nonce.
    #[must_use]
    pub const fn carries_nonce(self) -> bool {
        matches!(self, Self::Announce | Self::Call | Self::Stop)
    }

    /// True for what modules send.
    #[must_use]
    pub const fn is_for_host(self) -> bool {
        matches!(self, Self::Announce | Self::ToHost)
    }
}

/// The header: whose datagram this is, and which. Nothing of it is believed before the tag is checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// What it is for.
    pub kind: Kind,
    /// Which fleet.
    pub fleet: FleetId,
    /// The module that sends it, or that it is for.
    pub module: ModuleId,
    /// Which session; 0 in an announcement and in a stop.
    pub session: u32,
    /// Counts the datagrams of one sender in one session, from 0.
    pub sequence: u32,
    /// The nonce, in the kinds that have one.
    pub nonce: Option<Nonce>,
}

/// Why a message could not become a datagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EncodeError {
    /// The buffer has fewer bytes than the datagram needs.
    BufferTooSmall {
        /// Length of the buffer, bytes.
        have: usize,
    },
    /// Every sequence number of the session is used up: another session is needed.
    Exhausted,
}

impl core::fmt::Display for EncodeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::BufferTooSmall { have } => write!(f, "{have} bytes are too few for the datagram"),
            Self::Exhausted => f.write_str("the session has no sequence numbers left"),
        }
    }
}

impl core::error::Error for EncodeError {}

/// Why bytes are not a datagram of this protocol, for any receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// Longer than [`MAX_DATAGRAM`] or too short to hold anything.
    Length(usize),
    /// The checksum does not match: damaged on the way.
    Checksum,
    /// Another wire version.
    Version(u8),
    /// A kind this build does not know.
    Kind(u8),
}

impl core::fmt::Display for FrameError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Length(bytes) => write!(f, "{bytes} bytes are no datagram (at most {MAX_DATAGRAM})"),
            Self::Checksum => f.write_str("checksum mismatch"),
            Self::Version(version) => write!(f, "wire version {version}, this build speaks {WIRE_VERSION}"),
            Self::Kind(kind) => write!(f, "unknown kind {kind}"),
        }
    }
}

impl core::error::Error for FrameError {}

/// A datagram whose checksum is right, taken apart; not opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// What it claims.
    pub header: Header,
    /// The header's bytes, which the tag covers.
    pub(crate) clear: &'a [u8],
    /// The sealed bytes.
    pub(crate) sealed: &'a [u8],
    /// The tag.
    pub(crate) tag: [u8; TAG],
}

/// A reader of bytes that ends where they end.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (&first, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(first)
    }
}

impl<'a> Frame<'a> {
    /// Takes a datagram apart.
    ///
    /// # Errors
    /// [`FrameError`] says what is wrong with it; no input panics.
    pub fn parse(datagram: &'a [u8]) -> Result<Self, FrameError> {
        let length = FrameError::Length(datagram.len());
        if datagram.len() > MAX_DATAGRAM {
            return Err(length);
        }
        let (guarded, &sum) = datagram.split_last_chunk::<CHECKSUM>().ok_or(length)?;
        if checksum(guarded).to_le_bytes() != sum {
            return Err(FrameError::Checksum);
        }
        let (body, &tag) = guarded.split_last_chunk::<TAG>().ok_or(length)?;
        let mut reader = Reader(body);
        let [version] = reader.take().ok_or(length)?;
        if version != WIRE_VERSION {
            return Err(FrameError::Version(version));
        }
        let [kind] = reader.take().ok_or(length)?;
        let kind = Kind::of(kind).ok_or(FrameError::Kind(kind))?;
        let header = Header {
            kind,
            fleet: FleetId(reader.take().ok_or(length)?),
            module: ModuleId(u16::from_le_bytes(reader.take().ok_or(length)?)),
            session: u32::from_le_bytes(reader.take().ok_or(length)?),
            sequence: u32::from_le_bytes(reader.take().ok_or(length)?),
            nonce: if kind.carries_nonce() { Some(Nonce(reader.take().ok_or(length)?)) } else { None },
        };
        let sealed = reader.0;
        let clear = body.get(..body.len().saturating_sub(sealed.len())).ok_or(length)?;
        Ok(Self { header, clear, sealed, tag })
    }
}

impl Header {
    /// Writes it to the start of `buffer` and returns its length.
    pub(crate) fn write(&self, buffer: &mut [u8]) -> Result<usize, EncodeError> {
        let have = buffer.len();
        let mut rest = buffer;
        let mut written = 0_usize;
        let mut put = |bytes: &[u8]| {
            let (head, tail) = core::mem::take(&mut rest).split_at_mut_checked(bytes.len())?;
            head.copy_from_slice(bytes);
            rest = tail;
            written = written.saturating_add(bytes.len());
            Some(())
        };
        let mut all = || {
            put(&[WIRE_VERSION, self.kind as u8])?;
            put(&self.fleet.0)?;
            put(&self.module.0.to_le_bytes())?;
            put(&self.session.to_le_bytes())?;
            put(&self.sequence.to_le_bytes())?;
            self.nonce.as_ref().map_or(Some(()), |nonce| put(&nonce.0))
        };
        all().ok_or(EncodeError::BufferTooSmall { have })?;
        Ok(written)
    }
}

/// Puts the checksum behind the first `guarded` bytes of `buffer` and returns the whole datagram.
pub(crate) fn finish(buffer: &mut [u8], guarded: usize) -> Result<&[u8], EncodeError> {
    let too_small = EncodeError::BufferTooSmall { have: buffer.len() };
    let total = guarded.saturating_add(CHECKSUM);
    let checksum = checksum(buffer.get(..guarded).ok_or(too_small)?);
    buffer.get_mut(guarded..total).ok_or(too_small)?.copy_from_slice(&checksum.to_le_bytes());
    buffer.get(..total).ok_or(too_small)
}
