//! Strangers: who was heard that is not followed, and why a module of the roster is silent.
//!
//! **These are hints.** What another fleet or another wire version sends cannot be checked: this host has no key for it. Anyone on the network can
//! make such a datagram, so nothing is decided by it; it gives an error a reason.
//!
//! | heard | known by | checked |
//! |---|---|---|
//! | an announcement with a number of the roster, of another fleet | the fleet's public number in the header | the checksum alone |
//! | a datagram of another wire version | its first byte; the rest has our checksum | the checksum alone |
//! | a module of the wrong kind | its reports | its seal |
//!
//! At most `CAPACITY` are remembered. One that is not heard for `FORGET_AFTER` gives its place to another; until then it keeps it, so a flood of
//! made-up strangers does not drive out who was there before.

use std::fmt;

use protocol::time::{Duration, FleetInstant};
use protocol::{FleetId, FrameError, Header, Kind, ModuleId, ModuleKind, WIRE_VERSION};

/// Strangers remembered, at most. *Assumed*: three fleets of 25 modules.
const CAPACITY: usize = 75;
/// A stranger that was not heard for this time is no reason for anything any more. *Assumed*: ten announcements.
const FORGET_AFTER: Duration = Duration(10_000_000);

/// What makes a sender a stranger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strangeness {
    /// It claims to be of this fleet: it may have another key.
    OtherFleet(FleetId),
    /// It claims to speak this wire version.
    OtherVersion(u8),
    /// It is of the fleet, and of this kind where another is wanted.
    WrongKind(ModuleKind),
}

/// A sender that is not followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stranger<A> {
    /// Why it is not followed.
    pub what: Strangeness,
    /// Its number, if it says one.
    pub module: Option<ModuleId>,
    /// Where its last datagram came from.
    pub address: A,
    /// When, fleet time.
    pub heard: FleetInstant,
    /// Datagrams of it since it is remembered.
    pub count: u64,
}

impl<A> Stranger<A> {
    fn is_fresh(&self, now: FleetInstant) -> bool {
        now.since(self.heard) < FORGET_AFTER
    }
}

/// Strangers that were heard, and cannot be checked.
#[derive(Clone, Debug)]
pub(super) struct Strangers<A>(Vec<Stranger<A>>);

impl<A: Copy> Strangers<A> {
    pub(super) const fn new() -> Self {
        Self(Vec::new())
    }

    pub(super) fn all(&self) -> &[Stranger<A>] {
        &self.0
    }

    /// Takes in the header of a datagram that is not for this host.
    pub(super) fn foreign(&mut self, now: FleetInstant, from: A, ours: FleetId, header: &Header) {
        if header.kind == Kind::Announce && header.fleet != ours {
            self.note(now, from, Strangeness::OtherFleet(header.fleet), Some(header.module));
        }
    }

    /// Takes in a datagram that did not parse, for that reason.
    pub(super) fn unread(
        &mut self,
        now: FleetInstant,
        from: A,
        ours: FleetId,
        datagram: &[u8],
        why: FrameError,
    ) {
        if let FrameError::Version(version) = why {
            self.note(now, from, Strangeness::OtherVersion(version), claimed(ours, datagram));
        }
    }

    fn note(&mut self, now: FleetInstant, from: A, what: Strangeness, module: Option<ModuleId>) {
        if let Some(known) = self.0.iter_mut().find(|known| (known.what, known.module) == (what, module)) {
            (known.address, known.heard) = (from, now);
            known.count = known.count.saturating_add(1);
            return;
        }
        if self.0.len() >= CAPACITY {
            let Some(place) = self.0.iter().position(|known| !known.is_fresh(now)) else { return };
            self.0.swap_remove(place);
        }
        self.0.push(Stranger { what, module, address: from, heard: now, count: 1 });
    }

    /// What was heard lately of one that claims to be `module`, or may be.
    pub(super) fn hint(&self, now: FleetInstant, module: ModuleId) -> Option<Silence> {
        let fresh = || self.0.iter().filter(|known| known.is_fresh(now));
        let named = fresh().find(|known| known.module == Some(module));
        let known = named.or_else(|| fresh().find(|known| known.module.is_none()))?;
        match known.what {
            Strangeness::OtherFleet(_) => Some(Silence::OtherFleet),
            Strangeness::OtherVersion(version) => Some(Silence::OtherVersion(version)),
            Strangeness::WrongKind(_) => None,
        }
    }
}

/// The module's number in a header of another version, if that has our fleet's number where ours has it.
fn claimed(ours: FleetId, datagram: &[u8]) -> Option<ModuleId> {
    let (fleet, rest) = datagram.get(2..)?.split_first_chunk::<4>()?;
    let number = rest.first_chunk::<2>().filter(|_| *fleet == ours.0)?;
    Some(ModuleId(u16::from_le_bytes(*number)))
}

/// Why a module is silent, or is not used though it is heard. Its `Display` says it after the module's number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Silence {
    /// Nothing came that claims to be from it.
    NeverHeard,
    /// It announces itself and takes no call up: it does not hear this host, or is a recording.
    Unanswered,
    /// One with its number announces itself for another fleet. A hint: it cannot be checked.
    OtherFleet,
    /// Datagrams of this wire version come. A hint: they cannot be checked.
    OtherVersion(u8),
    /// It is in a session, and reports as another kind of robot than is wanted.
    WrongKind,
    /// It serves another host.
    ServesAnotherHost,
    /// Two modules with its number answer.
    Doubled,
    /// It reports numbers that no module can have.
    Implausible,
    /// It reports that it is stopped.
    Stopped,
    /// It is in a session, and nothing is wrong with that.
    Known,
}

impl fmt::Display for Silence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NeverHeard => f.write_str("was never heard"),
            Self::Unanswered => f.write_str("announces itself and takes no call up"),
            Self::OtherFleet => f.write_str("seems to have another fleet's key"),
            Self::OtherVersion(version) => {
                write!(f, "seems to speak wire version {version}, not {WIRE_VERSION}")
            }
            Self::WrongKind => f.write_str("is another kind of robot"),
            Self::ServesAnotherHost => f.write_str("serves another host"),
            Self::Doubled => f.write_str("is there twice"),
            Self::Implausible => f.write_str("reports numbers that no module can have"),
            Self::Stopped => f.write_str("is stopped"),
            Self::Known => f.write_str("is in a session"),
        }
    }
}
