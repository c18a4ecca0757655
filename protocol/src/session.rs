//! Sessions: the one way from a message to a datagram and back. Nothing is followed that did not come through
//! [`Session::open`] or [`open_announcement`].
//!
//! Seal: ChaCha20-Poly1305 with the key of (session, direction), the nonce
//!
//! ```text
//! session 4 B │ kind 4 B │ sequence 4 B
//! ```
//!
//! and the whole header as associated data. A sequence number is used once: the counter is private, grows, and at its
//! end the session is [`Exhausted`](EncodeError::Exhausted). A [`Kind::Call`] counts with the session it opens. A [`Kind::Stop`] is
//! sealed with the key of an announcement and always says the same, so two hosts that seal it seal the same bytes.
//!
//! | attack | why it fails |
//! |---|---|
//! | forgery, damage with a right checksum | the tag, compared in constant time |
//! | replay within the session | [`Window`] |
//! | replay after a reboot of either side | its nonce, and so the keys, are others |
//! | reflection | each direction has its own key and its own kinds |
//! | another module's, another fleet's | other keys; the header says so first |

use chacha20poly1305::ChaCha20Poly1305;
use chacha20poly1305::aead::AeadInOut;

use crate::frame::{CHECKSUM, EncodeError, Frame, Header, Kind, MAX_DATAGRAM, TAG, finish};
use crate::keys::{FleetId, ModuleKey, Nonce, SessionKeys};
use crate::ledger::{Class, Outgoing, Receipt};
use crate::message::{Message, ModuleId};
use crate::window::{Arrival, Window};

/// Which end of a session this is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// The PC.
    Host,
    /// The robot.
    Module,
}

/// A message that was opened.
#[derive(Clone, Debug, PartialEq)]
pub struct Opened {
    /// What it says.
    pub message: Message,
    /// Something newer came before it.
    pub overtaken: bool,
    /// Its number.
    pub sequence: u32,
    /// Datagrams of this side that the sender had seen, by its receipt: one more than the greatest number.
    pub seen: u32,
}

/// One end of a session: seals and opens its datagrams, each number once.
#[derive(Clone, Debug)]
pub struct Session {
    side: Side,
    fleet: FleetId,
    module: ModuleId,
    host_nonce: Nonce,
    keys: SessionKeys,
    /// Number of the next datagram.
    sequence: u32,
    window: Window,
    /// What came, for the other side.
    came: Receipt,
    /// What the other side says came to it.
    receipt: Receipt,
}

impl Session {
    /// One end of the session that a module's boot nonce and a host's nonce make.
    #[must_use]
    pub fn new(
        side: Side,
        fleet: FleetId,
        module: ModuleId,
        key: &ModuleKey,
        boot: &Nonce,
        host_nonce: Nonce,
    ) -> Self {
        let keys = key.session(boot, &host_nonce);
        let (window, came, receipt) = (Window::new(), Receipt::default(), Receipt::default());
        Self { side, fleet, module, host_nonce, keys, sequence: 0, window, came, receipt }
    }

    /// Its public number.
    #[must_use]
    pub const fn id(&self) -> u32 {
        self.keys.id
    }

    /// The nonce that the host drew for it.
    #[must_use]
    pub const fn host_nonce(&self) -> &Nonce {
        &self.host_nonce
    }

    /// Number of the next datagram of this side: so many were sent.
    #[must_use]
    pub const fn sent(&self) -> u32 {
        self.sequence
    }

    /// Whether anything has come through it.
    #[must_use]
    pub const fn is_confirmed(&self) -> bool {
        self.window.newest().is_some()
    }

    /// What became of what this side sent in it.
    #[must_use]
    pub fn outgoing(&self) -> Outgoing {
        let Receipt { seen, accepted, late } = self.receipt;
        Outgoing {
            sent: u64::from(self.sequence),
            acknowledged: u64::from(accepted.saturating_sub(late)),
            late: u64::from(late),
            lost: u64::from(seen.saturating_sub(accepted)),
        }
    }

    /// Counts what was opened last as too late to be of use; the sender is told with the next datagram.
    pub fn came_late(&mut self) {
        self.came.late = self.came.late.saturating_add(1).min(self.came.accepted);
    }

    /// Writes `message` as one datagram to the start of `buffer` and returns that part.
    ///
    /// # Errors
    /// [`EncodeError`]; never [`BufferTooSmall`](EncodeError::BufferTooSmall) with [`MAX_DATAGRAM`] bytes.
    pub fn seal<'a>(&mut self, message: &Message, buffer: &'a mut [u8]) -> Result<&'a [u8], EncodeError> {
        let kind = match self.side {
            Side::Host => Kind::ToModule,
            Side::Module => Kind::ToHost,
        };
        self.seal_as(kind, message, buffer)
    }

    /// The host's answer to an announcement.
    ///
    /// # Errors
    /// As for [`seal`](Self::seal).
    pub fn seal_call<'a>(&mut self, buffer: &'a mut [u8]) -> Result<&'a [u8], EncodeError> {
        self.seal_as(Kind::Call, &Message::Called, buffer)
    }

    fn seal_as<'a>(
        &mut self,
        kind: Kind,
        message: &Message,
        buffer: &'a mut [u8],
    ) -> Result<&'a [u8], EncodeError> {
        let next = self.sequence.checked_add(1).ok_or(EncodeError::Exhausted)?;
        let nonce = kind.carries_nonce().then_some(self.host_nonce);
        let (fleet, module, session) = (self.fleet, self.module, self.keys.id);
        let header = Header { kind, fleet, module, session, sequence: self.sequence, nonce };
        let cipher = if kind.is_for_host() { &self.keys.to_host } else { &self.keys.to_module };
        let datagram = seal(cipher, &header, &self.came, message, buffer)?;
        self.sequence = next;
        Ok(datagram)
    }

    /// Opens a datagram that claims to be of this session.
    ///
    /// # Errors
    /// What it is instead; nothing has changed then.
    pub fn open(&mut self, frame: &Frame<'_>) -> Result<Opened, Class> {
        let Header { kind, fleet, module, session, sequence, .. } = frame.header;
        let for_host = self.side == Side::Host;
        if fleet != self.fleet || module != self.module || kind.is_for_host() != for_host {
            return Err(Class::Foreign);
        }
        if session != self.keys.id || matches!(kind, Kind::Announce | Kind::Stop) {
            return Err(Class::Stale);
        }
        let cipher = if for_host { &self.keys.to_host } else { &self.keys.to_module };
        let (receipt, message) = open(cipher, frame)?;
        let overtaken = match self.window.note(sequence) {
            Arrival::Fresh { overtaken } => overtaken,
            Arrival::Duplicate => return Err(Class::Duplicate),
            Arrival::Stale => return Err(Class::Stale),
        };
        self.came.seen = self.came.seen.max(sequence.saturating_add(1));
        self.came.accepted = self.came.accepted.saturating_add(1);
        // Each of the three only grows: whichever datagram says most came last.
        // Whatever it claims, no more arrived than was sent, or the sums would be wrong.
        let claimed = receipt.seen.min(self.sequence);
        let seen = self.receipt.seen.max(claimed);
        let accepted = self.receipt.accepted.max(receipt.accepted).min(seen);
        let late = self.receipt.late.max(receipt.late).min(accepted);
        self.receipt = Receipt { seen, accepted, late };
        Ok(Opened { message, overtaken, sequence, seen: claimed })
    }
}

/// A module's announcements in one boot.
#[derive(Clone, Debug)]
pub struct Announcer {
    fleet: FleetId,
    module: ModuleId,
    boot: Nonce,
    cipher: Cipher,
    sequence: u32,
}

impl Announcer {
    /// Of `module`, which drew `boot` when it booted.
    #[must_use]
    pub fn new(fleet: FleetId, module: ModuleId, key: &ModuleKey, boot: Nonce) -> Self {
        Self { fleet, module, boot, cipher: Cipher(key.announcements(&boot)), sequence: 0 }
    }

    /// Announcements sent.
    #[must_use]
    pub const fn sent(&self) -> u32 {
        self.sequence
    }

    /// Writes one announcement to the start of `buffer` and returns that part.
    ///
    /// # Errors
    /// As for [`Session::seal`].
    pub fn seal<'a>(&mut self, message: &Message, buffer: &'a mut [u8]) -> Result<&'a [u8], EncodeError> {
        let next = self.sequence.checked_add(1).ok_or(EncodeError::Exhausted)?;
        let (fleet, module, sequence) = (self.fleet, self.module, self.sequence);
        let header =
            Header { kind: Kind::Announce, fleet, module, session: 0, sequence, nonce: Some(self.boot) };
        let datagram = seal(&self.cipher.0, &header, &Receipt::default(), message, buffer)?;
        self.sequence = next;
        Ok(datagram)
    }
}

impl Announcer {
    /// Opens a stop of a host that answers one of these announcements. It may come any number of times: the nonce that it names is used up
    /// with the first.
    ///
    /// # Errors
    /// [`Class::Stale`] if it names another nonce, otherwise as for [`Session::open`].
    pub fn open_stop(&self, frame: &Frame<'_>) -> Result<(), Class> {
        let Header { kind, fleet, module, nonce, .. } = frame.header;
        if fleet != self.fleet || module != self.module || kind != Kind::Stop {
            return Err(Class::Foreign);
        }
        if nonce != Some(self.boot) {
            return Err(Class::Stale);
        }
        match open(&self.cipher.0, frame)? {
            (_, Message::EmergencyStop) => Ok(()),
            _ => Err(Class::Corrupt),
        }
    }
}

/// Writes the stop of the module that announced itself with `boot` to the start of `buffer` and returns that part.
///
/// # Errors
/// [`EncodeError::BufferTooSmall`]; never with [`MAX_DATAGRAM`] bytes.
pub fn seal_stop<'a>(
    fleet: FleetId,
    module: ModuleId,
    key: &ModuleKey,
    boot: Nonce,
    buffer: &'a mut [u8],
) -> Result<&'a [u8], EncodeError> {
    let header = Header { kind: Kind::Stop, fleet, module, session: 0, sequence: 0, nonce: Some(boot) };
    seal(&key.announcements(&boot), &header, &Receipt::default(), &Message::EmergencyStop, buffer)
}

/// Opens an announcement. It is genuine, but may be a recording: only an answer within the session proves that the
/// module is there.
///
/// # Errors
/// [`Class::Forged`] if the tag is wrong, [`Class::Corrupt`] if what was sealed is no message, [`Class::Foreign`] if it is
/// no announcement.
pub fn open_announcement(key: &ModuleKey, frame: &Frame<'_>) -> Result<Message, Class> {
    let (Kind::Announce, Some(boot)) = (frame.header.kind, &frame.header.nonce) else {
        return Err(Class::Foreign);
    };
    open(&key.announcements(boot), frame).map(|(_, message)| message)
}

#[derive(Clone)]
struct Cipher(ChaCha20Poly1305);

impl core::fmt::Debug for Cipher {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Cipher(…)")
    }
}

fn cipher_nonce(header: &Header) -> [u8; 12] {
    let mut nonce = [0; 12];
    let kind = u32::from(header.kind as u8);
    let words = [header.session, kind, header.sequence];
    for (bytes, word) in nonce.chunks_exact_mut(4).zip(words) {
        bytes.copy_from_slice(&word.to_le_bytes());
    }
    nonce
}

fn seal<'a>(
    cipher: &ChaCha20Poly1305,
    header: &Header,
    receipt: &Receipt,
    message: &Message,
    buffer: &'a mut [u8],
) -> Result<&'a [u8], EncodeError> {
    let too_small = EncodeError::BufferTooSmall { have: buffer.len() };
    let clear = header.write(buffer)?;
    let (head, rest) = buffer.split_at_mut_checked(clear).ok_or(too_small)?;
    let mut length = postcard::to_slice(&(receipt, message), rest).map_err(|_| too_small)?.len();
    if let (Some(trailer), Some(behind)) = (message.trailer(), rest.get_mut(length..)) {
        length = length.saturating_add(postcard::to_slice(&trailer, behind).map_err(|_| too_small)?.len());
    }
    // Before anything is sealed: its number is given to another message if this one does not fit.
    if rest.len() < length.saturating_add(TAG).saturating_add(CHECKSUM) {
        return Err(too_small);
    }
    let sealed = rest.get_mut(..length).ok_or(too_small)?;
    let tag = cipher
        .encrypt_inout_detached(&cipher_nonce(header).into(), head, sealed.into())
        .map_err(|_| too_small)?;
    let end = clear.saturating_add(length);
    let guarded = end.saturating_add(TAG);
    *buffer.get_mut(end..).and_then(<[u8]>::first_chunk_mut).ok_or(too_small)? = tag.into();
    finish(buffer, guarded)
}

fn open(cipher: &ChaCha20Poly1305, frame: &Frame<'_>) -> Result<(Receipt, Message), Class> {
    let mut room = [0; MAX_DATAGRAM];
    let plain = room.get_mut(..frame.sealed.len()).ok_or(Class::Corrupt)?;
    plain.copy_from_slice(frame.sealed);
    let nonce = cipher_nonce(&frame.header);
    cipher
        .decrypt_inout_detached(&nonce.into(), frame.clear, (&mut *plain).into(), &frame.tag.into())
        .map_err(|_| Class::Forged)?;
    let (receipt, message) = match postcard::take_from_bytes::<(Receipt, Message)>(plain) {
        Ok((content, [])) => return Ok(content),
        Ok(((receipt, message), behind)) => match postcard::take_from_bytes(behind) {
            Ok((trailer, [])) => (receipt, message.with_trailer(trailer)),
            _ => return Err(Class::Corrupt),
        },
        Err(_) => return Err(Class::Corrupt),
    };
    Ok((receipt, message.ok_or(Class::Corrupt)?))
}

#[cfg(test)]
mod tests;
