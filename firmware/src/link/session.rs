//! Sessions of the module: announces it, lets one host in, and opens nothing that is not sealed by that host.
//!
//! ```text
//!            Call of a host                    silent for HOST_SILENCE, nothing runs,
//! seeking ──────────────────→ in a session ──── and another host calls ──→ in that one's
//! ```
//!
//! A module serves one host. While that one is heard, or a cycle of its runs, others are told nothing and change nothing. The
//! boot nonce of an announcement serves for one session: its last four bytes count the sessions of this boot. A replayed
//! session fails, as the module expects another nonce.
//!
//! Any host of the fleet may stop it all the same, with a [`Kind::Stop`] for the announcement in force: that costs no derivation of keys, uses the
//! nonce up, and changes nothing else about whom the module serves.
//!
//! A call costs the derivation of a session's keys before it can be told from a forged one, as much as twelve forged datagrams. So none is
//! derived while another host is heard or a cycle runs, and otherwise at most [`CALLS`] for one announcement: the rest are not looked at.
//!
//! | datagram | class |
//! |---|---|
//! | does not parse, or no message inside | corrupt |
//! | another fleet's, another module's, for the host, or a call of another host while this one is heard | foreign |
//! | of a session that is not in force, a call or a stop that answers no announcement in force, a call beyond [`CALLS`], from before the window | stale |
//! | came before | duplicate |
//! | wrong tag | forged |
//!
//! Assumptions and limits: the boot nonce is different at every boot ([`Identity::boot`]); a module that draws the same twice
//! lets recordings of the former boot in.

use protocol::ledger::{Class, Incoming, Outgoing};
use protocol::session::Opened;
use protocol::time::{Duration, LocalInstant};
use protocol::{
    Announcer, EncodeError, FleetId, Frame, Hello, Kind, Message, ModuleId, ModuleKey, Nonce, Session, Side,
};

/// Silence of a host after which another host is let in. *Assumed*: the clock exchange brings an
/// answer at least every second, and several are lost in a row now and then.
pub const HOST_SILENCE: Duration = Duration(1_500_000);

/// Calls that are looked at for one announcement. *Assumed*: the host's and its repetition; a stranger's fill what is left. At 5
/// announcements a second it bounds the work to a third of a percent of a board's processor.
pub const CALLS: u8 = 4;

/// Who a module is.
#[derive(Clone, Debug)]
pub struct Identity {
    /// Its number in the fleet.
    pub module: ModuleId,
    /// Its fleet.
    pub fleet: FleetId,
    /// Its key.
    pub key: ModuleKey,
    /// Drawn at boot, different from boot to boot; the last four bytes are counted on by the link.
    pub boot: [u8; 12],
    /// Pause between two reports.
    pub report_every: Duration,
    /// No cycle starts while fleet time may be off by more.
    pub sure_within: Duration,
}

/// [`Identity::sure_within`] where nothing else is said: 2 ms, in which a tail at 11 rad/s moves 0.02 rad. *Assumed.*
pub const SURE_WITHIN: Duration = Duration(2_000);

/// A datagram that was let in.
#[derive(Clone, Debug, PartialEq)]
pub struct Heard {
    /// What it says.
    pub opened: Opened,
    /// A host was taken: the first, or another boot of it.
    pub host: Host,
}

/// Whose words they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Host {
    /// The host that is served.
    Same,
    /// The same boot of the host, in another session: its epoch and its cycles go on.
    Again,
    /// The first host, or another boot of it: its epoch and its cycle numbers are new.
    Another,
    /// A host that stays out: it has stopped the module, and that is all.
    Outside,
}

/// The module's side of its sessions with hosts.
#[derive(Clone, Debug)]
pub struct Link {
    identity: Identity,
    announcer: Announcer,
    /// Sessions of this boot so far.
    sessions: u32,
    session: Option<Session>,
    /// Nonce of the host that was let in last.
    host: Option<Nonce>,
    heard: LocalInstant,
    incoming: Incoming,
    /// Of sessions that are over.
    former: Outgoing,
    /// Announcements with nonces that are used up.
    announced: u64,
    /// Calls looked at since the last announcement.
    calls: u8,
}

impl Link {
    /// Of a module that has just booted.
    #[must_use]
    pub fn new(identity: Identity) -> Self {
        let announcer = announcer(&identity, 0);
        Self {
            identity,
            announcer,
            sessions: 0,
            session: None,
            host: None,
            heard: LocalInstant(0),
            incoming: Incoming::default(),
            former: Outgoing::default(),
            announced: 0,
            calls: 0,
        }
    }

    /// Who it is.
    #[must_use]
    pub const fn identity(&self) -> &Identity {
        &self.identity
    }

    /// What came to it since its boot.
    #[must_use]
    pub const fn incoming(&self) -> &Incoming {
        &self.incoming
    }

    /// What became of what it sent in sessions since its boot.
    #[must_use]
    pub fn outgoing(&self) -> Outgoing {
        self.former.plus(&self.session.as_ref().map_or(Outgoing::default(), Session::outgoing))
    }

    /// Announcements sent since its boot. They are not acknowledged.
    #[must_use]
    pub fn announced(&self) -> u64 {
        self.announced.saturating_add(u64::from(self.announcer.sent()))
    }

    /// Whether it is in a session.
    #[must_use]
    pub const fn is_open(&self) -> bool {
        self.session.is_some()
    }

    /// Whether its host has been heard lately.
    #[must_use]
    pub fn hears_host(&self, now: LocalInstant) -> bool {
        self.session.is_some() && now.since(self.heard) < HOST_SILENCE
    }

    /// The nonce of the host whose session it is in: twelve bytes of that boot, four of the session.
    #[must_use]
    pub fn host_nonce(&self) -> Option<&Nonce> {
        self.session.as_ref().map(Session::host_nonce)
    }

    /// The session's number, 0 for none.
    #[must_use]
    pub fn session(&self) -> u32 {
        self.session.as_ref().map_or(0, Session::id)
    }

    /// What was let in last came too late to be of use.
    pub fn came_late(&mut self) {
        if let Some(session) = &mut self.session {
            session.came_late();
        }
    }

    /// Takes in a datagram that arrived at `now`, own clock. `busy`: a cycle runs, and no other host may interfere.
    ///
    /// # Errors
    /// What the datagram is, if it is not let in; it is counted and nothing else happens.
    // Out of line: what it needs of the stack is given back before what it heard is followed.
    #[inline(never)]
    pub fn open(&mut self, now: LocalInstant, datagram: &[u8], busy: bool) -> Result<Heard, Class> {
        let heard = self.admit(now, datagram, busy);
        self.incoming.count(heard.as_ref().err().copied().unwrap_or(Class::Accepted));
        // One that was overtaken may have been held back, and be played now: it keeps no host alive that is gone.
        if heard.as_ref().is_ok_and(|heard| heard.host != Host::Outside && !heard.opened.overtaken) {
            self.heard = now;
        }
        heard
    }

    fn admit(&mut self, now: LocalInstant, datagram: &[u8], busy: bool) -> Result<Heard, Class> {
        let frame = Frame::parse(datagram).map_err(|_| Class::Corrupt)?;
        let header = &frame.header;
        let Identity { module, fleet, .. } = self.identity;
        if header.fleet != fleet || header.module != module || header.kind.is_for_host() {
            return Err(Class::Foreign);
        }
        if header.kind == Kind::Stop {
            self.announcer.open_stop(&frame)?;
            // It cannot be played again.
            self.next_nonce();
            let opened = Opened { message: Message::EmergencyStop, overtaken: false, sequence: 0, seen: 0 };
            return Ok(Heard { opened, host: Host::Outside });
        }
        if let Some(session) = self.session.as_mut().filter(|session| session.id() == header.session) {
            return session.open(&frame).map(|opened| Heard { opened, host: Host::Same });
        }
        match (header.kind, header.nonce) {
            (Kind::Call, Some(nonce)) => self.called(now, &frame, nonce, busy),
            _ => Err(Class::Stale),
        }
    }

    /// A host that this module is not in a session with calls it.
    fn called(
        &mut self,
        now: LocalInstant,
        frame: &Frame<'_>,
        nonce: Nonce,
        busy: bool,
    ) -> Result<Heard, Class> {
        if busy || self.hears_host(now) {
            return Err(Class::Foreign);
        }
        if self.calls >= CALLS {
            return Err(Class::Stale);
        }
        self.calls = self.calls.saturating_add(1);
        let Identity { module, fleet, key, .. } = &self.identity;
        let boot = boot_nonce(&self.identity, self.sessions);
        let mut session = Session::new(Side::Module, *fleet, *module, key, &boot, nonce);
        if session.id() != frame.header.session {
            // It answers an announcement of another boot, or one that another host has answered.
            return Err(Class::Stale);
        }
        let opened = session.open(frame)?;
        let host = match self.host.replace(nonce) {
            Some(former) if same_life(&former, &nonce) => Host::Again,
            _ => Host::Another,
        };
        self.end_session();
        self.session = Some(session);
        // One boot nonce, one session.
        self.next_nonce();
        Ok(Heard { opened, host })
    }

    /// The nonce of its announcements is used up.
    fn next_nonce(&mut self) {
        self.announced = self.announced();
        self.sessions = self.sessions.wrapping_add(1);
        self.announcer = announcer(&self.identity, self.sessions);
    }

    /// Datagrams sent in the session in force.
    #[must_use]
    pub fn sent(&self) -> u32 {
        self.session.as_ref().map_or(0, Session::sent)
    }

    /// Writes a message of the session to the start of `buffer`; nothing without a session.
    pub fn seal<'a>(&mut self, message: &Message, buffer: &'a mut [u8]) -> Option<&'a [u8]> {
        match self.session.as_mut()?.seal(message, buffer) {
            Ok(datagram) => Some(datagram),
            Err(EncodeError::Exhausted) => {
                // The host sees that it is gone from the next announcement, and calls again.
                self.end_session();
                None
            }
            Err(EncodeError::BufferTooSmall { .. }) => None,
        }
    }

    /// What was under way in it is lost.
    fn end_session(&mut self) {
        if let Some(session) = self.session.take() {
            self.former = self.former.plus(&session.outgoing().closed());
        }
    }

    /// Writes an announcement to the start of `buffer`.
    pub fn seal_announcement<'a>(&mut self, hello: &Hello, buffer: &'a mut [u8]) -> Option<&'a [u8]> {
        self.calls = 0;
        self.announcer.seal(&Message::Hello(*hello), buffer).ok()
    }
}

fn boot_nonce(identity: &Identity, session: u32) -> Nonce {
    let mut nonce = [0; 16];
    let bytes = identity.boot.iter().copied().chain(session.to_le_bytes());
    nonce.iter_mut().zip(bytes).for_each(|(to, from)| *to = from);
    Nonce(nonce)
}

fn announcer(identity: &Identity, session: u32) -> Announcer {
    Announcer::new(identity.fleet, identity.module, &identity.key, boot_nonce(identity, session))
}

/// Hosts draw twelve bytes when they start, and count their sessions in the last four.
fn same_life(one: &Nonce, other: &Nonce) -> bool {
    one.0.first_chunk::<12>() == other.0.first_chunk::<12>()
}
