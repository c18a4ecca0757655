//! What every datagram of a storm was, counted at the taps and by none of the code that counts it in the link.
//!
//! A datagram is *genuine* when its bytes are, to the last, those that a node handed to its radio. What it is to its receiver
//! follows from that, from the numbers in its header and from the session in force:
//!
//! | datagram | class |
//! |---|---|
//! | wrong length, checksum, version or kind | corrupt |
//! | another module's, another fleet's, for the other side | foreign |
//! | a call that a module does not take | stale, or foreign: compared as one, as only the module knows whether it heard its host |
//! | a call with the number of the session that it would open: not genuine | forged, or not looked at: *doubtful* |
//! | of the session in force: not genuine | forged |
//! | genuine, of the session that another boot took the place of | stale; by its number once it is known that there are two |
//! | genuine, a lie | corrupt where it would be accepted |
//! | genuine, number not seen, at most 127 behind the newest | accepted |
//! | genuine, number seen, at most 127 behind the newest | duplicate |
//! | further behind; of a session that is not in force or on offer | stale |
//!
//! Announcements belong to no session: their numbers are followed for every boot nonce that a host has an offer for, or that a
//! module of its sessions would use next; of a used-up nonce they are stale. One that has no place, or is not offered one again yet, is
//! accepted, and its number is not followed.
//!
//! Taken from the link are only the number of the session that a module is in after a tick, the derivation of that number from
//! the two nonces, and whether a host holds two modules for one, and which of them stayed: that says a sealed receipt.

use std::collections::{HashMap, HashSet, VecDeque};

use protocol::{FleetId, FleetKey, ModuleId, ModuleKey, Nonce, Session, Side, WIRE_VERSION};

/// Sums by class: received, accepted, duplicate, stale, corrupt, forged, foreign.
pub type Classes = [u64; 7];

/// What a datagram is to its receiver; its place in [`Classes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the table above says what each is")]
pub enum Class {
    Accepted = 1,
    Duplicate,
    Stale,
    Corrupt,
    Forged,
    Foreign,
}

fn count(classes: &mut Classes, class: Class) {
    classes[0] += 1;
    classes[class as usize] += 1;
}

/// What came to a module in one boot: its classes, and how many of its stale ones may be forged as well.
pub type Doubtful = (Classes, u64);

const ANNOUNCE: u8 = 1;
const CALL: u8 = 2;
const TO_MODULE: u8 = 3;
const TO_HOST: u8 = 4;
/// Behind the newest by so much or more, a number is not followed.
const WINDOW: u32 = 128;
/// Offers that a host keeps for one module, and nonces that it remembers as used up.
const OFFERS: usize = 8;
const FORMER: usize = 16;
/// How old an offer is before it gives its place to another, µs, and the pause before the next to its boot, first and longest.
const OFFERED_FOR_US: u64 = 500_000;
const PAUSE_US: [u64; 2] = [1_000_000, 60_000_000];
/// How long a session is kept that another boot took the place of, µs.
const DISPLACED_FOR_US: u64 = 3_000_000;

/// What a datagram says in the clear.
#[derive(Clone, Copy, Debug)]
struct Clear {
    kind: u8,
    fleet: [u8; 4],
    module: u16,
    session: u32,
    sequence: u32,
    nonce: [u8; 16],
}

/// CRC-32, ISO-HDLC, bit by bit.
pub(super) fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |sum, &byte| {
        (0..8).fold(sum ^ u32::from(byte), |sum, _| (sum >> 1) ^ (0xEDB8_8320 & (sum & 1).wrapping_neg()))
    })
}

impl Clear {
    /// Nothing if the datagram is damaged.
    fn read(datagram: &[u8]) -> Option<Self> {
        let (guarded, sum) = datagram.split_last_chunk::<4>()?;
        if crc32(guarded) != u32::from_le_bytes(*sum) {
            return None;
        }
        let body = guarded.get(..guarded.len().checked_sub(16)?)?;
        let four = |at: usize| body.get(at..at + 4)?.try_into().ok();
        let (&version, &kind) = (body.first()?, body.get(1)?);
        if version != WIRE_VERSION || !(ANNOUNCE..=TO_HOST).contains(&kind) {
            return None;
        }
        let opens = kind == ANNOUNCE || kind == CALL;
        let nonce = if opens { body.get(16..32)?.try_into().ok()? } else { [0; 16] };
        Some(Self {
            kind,
            fleet: four(2)?,
            module: u16::from_le_bytes(body.get(6..8)?.try_into().ok()?),
            session: u32::from_le_bytes(four(8)?),
            sequence: u32::from_le_bytes(four(12)?),
            nonce,
        })
    }
}

/// The numbers that came.
#[derive(Clone, Debug, Default)]
struct Seen {
    newest: u32,
    numbers: HashSet<u32>,
}

impl Seen {
    fn note(&mut self, number: u32) -> Class {
        if number.saturating_add(WINDOW) <= self.newest {
            return Class::Stale;
        }
        self.newest = self.newest.max(number);
        if self.numbers.insert(number) { Class::Accepted } else { Class::Duplicate }
    }
}

/// A module, in one boot.
#[derive(Clone, Debug, Default)]
struct ModuleEnd {
    id: u16,
    /// Twelve bytes of its boot, once it has announced itself.
    boot: Option<[u8; 12]>,
    sessions: u32,
    session: u32,
    seen: Seen,
    /// Since it booted.
    classes: Classes,
    doubtful: u64,
}

/// A session that a host has offered, or is in.
#[derive(Clone, Debug)]
struct Offer {
    nonce: [u8; 16],
    session: Option<u32>,
    announced: Seen,
    seen: Seen,
    since_us: u64,
}

impl Offer {
    fn is_of_boot_of(&self, other: &Self) -> bool {
        self.nonce.first_chunk::<12>() == other.nonce.first_chunk::<12>()
    }
}

/// The nonce that a module's next session would have, once it has announced itself in this one, and the numbers of that.
type Next = Option<([u8; 16], Seen)>;

/// What a host knows of one module.
#[derive(Clone, Debug, Default)]
struct HostEnd {
    live: Option<Offer>,
    /// The nonce that the module's next session would have.
    next: Next,
    /// The session of another boot that `live` took the place of, with its next nonce, and when that was, µs: it is kept for a while, as it
    /// may be a second module's.
    displaced: Option<(Offer, Next, u64)>,
    /// The host knows that there are two: `displaced` is alive.
    doubled: bool,
    offers: VecDeque<Offer>,
    /// Nonces whose offers were given up: when there may be another, and the pause until then, µs.
    silent: HashMap<[u8; 16], (u64, u64)>,
    former: VecDeque<[u8; 16]>,
    classes: Classes,
}

/// The count of one fleet and its hosts, one after the other.
pub struct Count {
    fleet: FleetId,
    keys: Vec<ModuleKey>,
    modules: Vec<ModuleEnd>,
    hosts: Vec<HostEnd>,
    strays: Classes,
    /// What hosts sealed.
    by_hosts: HashSet<Vec<u8>>,
    /// What modules sealed, and the session that each was in.
    by_modules: HashMap<Vec<u8>, u32>,
    /// Those with numbers that no module can have.
    lies: HashSet<Vec<u8>>,
    /// The module (from 0) of each session.
    sessions: HashMap<u32, usize>,
}

impl Count {
    /// Of `modules` modules with ids from 1, and further ones with the ids of some of them.
    #[must_use]
    pub fn new(key: &FleetKey, modules: usize, doubles: &[u16]) -> Self {
        let ids = (1..=modules as u16).chain(doubles.iter().copied());
        Self {
            fleet: key.fleet(),
            keys: ids.clone().map(|id| key.module(ModuleId(id))).collect(),
            modules: ids.map(|id| ModuleEnd { id, ..ModuleEnd::default() }).collect(),
            hosts: vec![HostEnd::default(); modules],
            strays: [0; 7],
            by_hosts: HashSet::new(),
            by_modules: HashMap::new(),
            lies: HashSet::new(),
            sessions: HashMap::new(),
        }
    }

    /// The module (from 0) lost its power: what came to it in this boot.
    pub fn end_boot(&mut self, module: usize) -> Doubtful {
        let id = self.modules[module].id;
        let ended = std::mem::replace(&mut self.modules[module], ModuleEnd { id, ..ModuleEnd::default() });
        (ended.classes, ended.doubtful)
    }

    /// The host ended: what came to it, by module, and what no module can be charged with.
    pub fn end_host(&mut self) -> (Vec<Classes>, Classes) {
        let ends = self.hosts.iter_mut().map(|end| std::mem::take(end).classes).collect();
        (ends, std::mem::take(&mut self.strays))
    }

    fn session_of(&self, module: usize, boot: [u8; 16], host: [u8; 16]) -> u32 {
        let id = ModuleId(self.modules[module].id);
        Session::new(Side::Module, self.fleet, id, &self.keys[module], &Nonce(boot), Nonce(host)).id()
    }

    /// The host handed this to its radio.
    pub fn host_sent(&mut self, datagram: &[u8]) {
        self.by_hosts.insert(datagram.to_vec());
        let Some(clear) = Clear::read(datagram).filter(|clear| clear.kind == CALL) else { return };
        let module = usize::from(clear.module) - 1;
        let answered = self.hosts[module].offers.iter().position(|offer| {
            offer.session.is_none() && self.session_of(module, offer.nonce, clear.nonce) == clear.session
        });
        if let Some(answered) = answered {
            self.hosts[module].offers[answered].session = Some(clear.session);
        }
    }

    /// A module (from 0) handed this to its radio while in `session`, 0 for none.
    pub fn module_sent(&mut self, module: usize, session: u32, datagram: &[u8]) {
        if let Some(clear) = Clear::read(datagram).filter(|clear| clear.kind == ANNOUNCE) {
            self.modules[module].boot = clear.nonce.first_chunk().copied();
        }
        self.sessions.insert(session, module);
        self.by_modules.insert(datagram.to_vec(), session);
    }

    /// A module (from 0) handed this to its radio in `session`, and it is a lie.
    pub fn module_lied(&mut self, module: usize, session: u32, datagram: &[u8]) {
        self.module_sent(module, session, datagram);
        self.lies.insert(datagram.to_vec());
    }

    /// A stranger plays this to the host: a genuine announcement of before, of a module that was in `session`.
    pub fn recorded(&mut self, session: u32, datagram: &[u8]) {
        self.by_modules.insert(datagram.to_vec(), session);
    }

    /// This came to a module (from 0) with power in a tick after which it was in `session`.
    pub fn came_to_module(&mut self, module: usize, session: u32, datagram: &[u8]) {
        let class = self.at_module(module, session, datagram);
        count(&mut self.modules[module].classes, class.unwrap_or(Class::Stale));
        self.modules[module].doubtful += u64::from(class.is_none());
    }

    /// Nothing if it is forged, and may not have been looked at.
    fn at_module(&mut self, module: usize, session: u32, datagram: &[u8]) -> Option<Class> {
        let Some(clear) = Clear::read(datagram) else { return Some(Class::Corrupt) };
        let for_it = clear.fleet == self.fleet.0
            && clear.module == self.modules[module].id
            && (clear.kind == CALL || clear.kind == TO_MODULE);
        if !for_it {
            return Some(Class::Foreign);
        }
        let genuine = self.by_hosts.contains(datagram);
        let end = &self.modules[module];
        if clear.session != end.session || end.session == 0 {
            let mut answered = [0; 16];
            answered[12..].copy_from_slice(&end.sessions.to_le_bytes());
            let Some(boot) = end.boot.filter(|_| clear.kind == CALL) else { return Some(Class::Stale) };
            answered[..12].copy_from_slice(&boot);
            if self.session_of(module, answered, clear.nonce) != clear.session {
                return Some(Class::Stale);
            }
            if !genuine {
                return None;
            }
            if clear.session != session {
                return Some(Class::Foreign);
            }
            let end = &mut self.modules[module];
            (end.session, end.seen) = (session, Seen::default());
            end.sessions += 1;
        }
        Some(if genuine { self.modules[module].seen.note(clear.sequence) } else { Class::Forged })
    }

    /// This came to the running host in the tick at `now_us`, µs of its time: what it was. `second`: the module whose session is
    /// the other one's, where the host holds two for a module (from 0) after it.
    pub fn came_to_host(
        &mut self,
        now_us: u64,
        datagram: &[u8],
        second: impl Fn(usize) -> Option<usize>,
    ) -> Class {
        let clear = Clear::read(datagram);
        let of = clear.filter(|clear| {
            clear.fleet == self.fleet.0
                && (1..=self.hosts.len()).contains(&usize::from(clear.module))
                && (clear.kind == ANNOUNCE || clear.kind == TO_HOST)
        });
        let Some(clear) = of else {
            let class = if clear.is_some() { Class::Foreign } else { Class::Corrupt };
            count(&mut self.strays, class);
            return class;
        };
        let module = usize::from(clear.module) - 1;
        let end = &mut self.hosts[module];
        let sealed_in = self.by_modules.get(datagram).copied();
        let second = second(module);
        let class = match (clear.kind, sealed_in) {
            (ANNOUNCE, None) => Class::Forged,
            (ANNOUNCE, Some(session)) => end.announced(now_us, clear, session),
            (_, sealed_in) => {
                let sealed = sealed_in.map(|_| self.lies.contains(datagram));
                end.said(now_us, clear, sealed, second, &self.sessions)
            }
        };
        end.doubled = second.is_some();
        count(&mut end.classes, class);
        class
    }

    /// The host has looked at its timers at `now_us`. `holds`: for a module (from 0), whether the host holds two for it, and the module whose
    /// session is in force.
    pub fn host_timer(&mut self, now_us: u64, holds: impl Fn(usize) -> (bool, Option<usize>)) {
        for (module, end) in self.hosts.iter_mut().enumerate() {
            if end.displaced.is_none() {
                continue;
            }
            let (doubled, in_force) = holds(module);
            if !std::mem::replace(&mut end.doubled, doubled) {
                end.displaced.take_if(|(_, _, at_us)| now_us >= *at_us + DISPLACED_FOR_US);
            } else if !doubled && let Some((displaced, next, _)) = end.displaced.take() {
                let of =
                    |offer: &Offer| offer.session.and_then(|session| self.sessions.get(&session).copied());
                if end.live.as_ref().and_then(of) != in_force {
                    (end.live, end.next) = (Some(displaced), next);
                }
            }
        }
    }
}

impl HostEnd {
    /// A genuine announcement of a module that was in `session`.
    fn announced(&mut self, now_us: u64, clear: Clear, session: u32) -> Class {
        if self.former.contains(&clear.nonce) {
            return Class::Stale;
        }
        if self.live.as_ref().is_some_and(|live| live.session == Some(session)) {
            let next = self.next.take().filter(|(nonce, _)| *nonce == clear.nonce);
            let (_, seen) = self.next.insert(next.unwrap_or((clear.nonce, Seen::default())));
            return seen.note(clear.sequence);
        }
        if let Some((_, next, _)) = self.displaced.as_mut().filter(|(live, ..)| live.session == Some(session))
        {
            let known = next.take().filter(|(nonce, _)| *nonce == clear.nonce);
            let (_, seen) = next.insert(known.unwrap_or((clear.nonce, Seen::default())));
            return seen.note(clear.sequence);
        }
        if !self.offers.iter().any(|offer| offer.nonce == clear.nonce) {
            if self.silent.get(&clear.nonce).is_some_and(|(again_us, _)| now_us < *again_us) {
                return Class::Accepted;
            }
            if self.offers.len() == OFFERS {
                if self.offers.front().is_some_and(|first| now_us < first.since_us + OFFERED_FOR_US) {
                    return Class::Accepted;
                }
                if let Some(first) = self.offers.pop_front() {
                    let known = self.silent.get(&first.nonce);
                    let pause_us = known.map_or(PAUSE_US[0], |(_, pause_us)| (2 * pause_us).min(PAUSE_US[1]));
                    self.silent.insert(first.nonce, (now_us + pause_us, pause_us));
                }
            }
            let (announced, seen) = (Seen::default(), Seen::default());
            self.offers.push_back(Offer {
                nonce: clear.nonce,
                session: None,
                announced,
                seen,
                since_us: now_us,
            });
        }
        let offer = self.offers.iter_mut().find(|offer| offer.nonce == clear.nonce);
        offer.map_or(Class::Stale, |offer| offer.announced.note(clear.sequence))
    }

    /// A datagram that claims to be of a session; `sealed`: by a module, and whether it is a lie. `second`: the
    /// module whose session is the other one's, where the host knows of two after it. `sessions`: the module of each session.
    fn said(
        &mut self,
        now_us: u64,
        clear: Clear,
        sealed: Option<bool>,
        second: Option<usize>,
        sessions: &HashMap<u32, usize>,
    ) -> Class {
        let of = |offer: &Offer| offer.session == Some(clear.session);
        if !self.live.as_ref().is_some_and(of) {
            if let Some((displaced, ..)) = self.displaced.as_mut().filter(|(displaced, ..)| of(displaced)) {
                let class = sealed.map_or(Class::Forged, |_| displaced.seen.note(clear.sequence));
                let counts = self.doubled || second.is_some() && class == Class::Accepted;
                return if counts { class } else { Class::Stale };
            }
            let Some(offered) = self.offers.iter().position(of) else { return Class::Stale };
            if sealed.is_none() {
                return Class::Forged;
            }
            let Some(offer) = self.offers.remove(offered) else { return Class::Stale };
            if self.former.len() == FORMER {
                self.former.pop_front();
            }
            self.former.push_back(offer.nonce);
            let next = self.next.take();
            // Of three boots two stay, and receipts say which.
            let of = |offer: &Offer| offer.session.and_then(|session| sessions.get(&session).copied());
            let third = |(kept, ..): &(Offer, Next, u64)| {
                let is_second =
                    second.is_some() && of(kept) == second && self.live.as_ref().and_then(of) != second;
                self.doubled && !kept.is_of_boot_of(&offer) && is_second
            };
            let keeps = self.displaced.as_ref().is_some_and(third);
            if let Some(before) = self.live.replace(offer.clone())
                && !before.is_of_boot_of(&offer)
                && !keeps
            {
                self.displaced = Some((before, next, now_us));
            }
            self.offers.clear();
        }
        match (&mut self.live, sealed) {
            (Some(live), Some(lie)) => match live.seen.note(clear.sequence) {
                Class::Accepted if lie => Class::Corrupt,
                class => class,
            },
            _ => Class::Forged,
        }
    }
}
