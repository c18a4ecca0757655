//! The host's side of the link: takes modules in, answers their clocks, sends each cycle ahead of its start and again until
//! it is answered, and keeps what each module has certainly, possibly and certainly not.
//!
//! A cycle of a Modboat is of use until it starts, the thrusts of an ROV until their lease ends; a newer cycle takes the
//! place of one that is still open. [`delivery`](super::delivery) has the two ways of delivery.
//!
//! Sans-IO: datagrams and the time go in, datagrams come out of [`Dispatcher::poll_transmit`]. Host time is fleet
//! time. A module is known by its id and its key; its address is wherever its newest datagram came from.

mod all_or_none;
mod orders;

use std::collections::{HashMap, VecDeque};

use protocol::ledger::{Class, Incoming};
use protocol::time::{Duration, FleetInstant};
use protocol::{
    Acknowledge, Cycle, Delivery, FleetId, FleetKey, Frame, Message, ModuleId, ModuleKind, ModuleState,
    Motion, Nonce, Refusal, TimeReply, Verdict,
};

use self::orders::Orders;
use super::delivery::{CycleDelivery, DeliveryState};
use super::lead::RoundTrip;
use super::member::{Heard, Joined};
pub use super::member::{IMPLAUSIBLE_FOR, ModuleLink};
use super::strangers::Strangers;
pub use super::strangers::{Silence, Strangeness, Stranger};

/// Event that a datagram of a module caused on the host.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DispatcherEvent {
    /// A module is in a session for the first time.
    Joined(usize),
    /// A module is in a new session because it booted: it lost its memory and no longer has any cycle.
    Rebooted(usize),
    /// A module is in a new session within the same boot.
    Rejoined(usize),
    /// A module serves another host.
    Elsewhere(usize),
    /// Two modules answer to one number: [`ModuleLink::doubled`] says where. Neither is used while they do.
    Doubled(usize),
    /// A module took a cycle.
    Accepted {
        /// Which module (index).
        module: usize,
        /// Which cycle.
        cycle: u32,
    },
    /// A module refused a cycle.
    Refused {
        /// Which module (index).
        module: usize,
        /// Which cycle.
        cycle: u32,
        /// Why.
        reason: Refusal,
    },
    /// A module reported.
    Reported(usize),
}

/// Session nonces of one start of the host: twelve random bytes drawn at the start, then the number of the session.
#[derive(Clone, Debug)]
struct SessionNonces {
    boot: [u8; 12],
    sessions: u32,
}

impl SessionNonces {
    /// A nonce that no session has had.
    fn next(&mut self) -> Nonce {
        let mut nonce = [0; 16];
        nonce[..12].copy_from_slice(&self.boot);
        nonce[12..].copy_from_slice(&self.sessions.to_le_bytes());
        self.sessions = self.sessions.wrapping_add(1);
        Nonce(nonce)
    }
}

/// A datagram that waits to be sent to a module (index); it is sealed when it is sent.
#[derive(Clone, Debug)]
enum QueuedDatagram {
    Call(usize, Nonce),
    /// For a module that is in no session with this host.
    Stop(usize, Nonce),
    Message(usize, Message),
    /// For the session that the one in force took the place of.
    Rival(usize, Message),
}

/// The host's end of the link to every module of a roster.
#[derive(Debug)]
pub struct Dispatcher<A> {
    fleet: FleetId,
    nonces: SessionNonces,
    modules: Vec<ModuleLink<A>>,
    /// Place of each id in the roster.
    places: HashMap<ModuleId, usize>,
    outbox: VecDeque<QueuedDatagram>,
    /// Of each module.
    orders: Vec<Orders>,
    strays: Incoming,
    strangers: Strangers<A>,
    round_trip: RoundTrip,
    /// What the modules should be.
    kind: Option<ModuleKind>,
}

impl<A: Copy> Dispatcher<A> {
    /// For the modules of `roster`, whose keys follow from `key`; the random `boot` tells this start of the host from its
    /// other ones.
    pub fn new(roster: &[ModuleId], key: &FleetKey, boot: [u8; 12]) -> Self {
        let fleet = key.fleet();
        let modules = roster.iter().map(|&id| ModuleLink::new(fleet, id, key.module(id))).collect();
        let places = roster.iter().enumerate().map(|(index, &id)| (id, index)).collect();
        let (nonces, outbox) = (SessionNonces { boot, sessions: 0 }, VecDeque::new());
        let orders = vec![Orders::default(); roster.len()];
        Self {
            fleet,
            nonces,
            modules,
            places,
            outbox,
            orders,
            strays: Incoming::default(),
            strangers: Strangers::new(),
            round_trip: RoundTrip::default(),
            kind: None,
        }
    }

    /// The same, where every module should be of that kind: one that is not is called a stranger.
    #[must_use]
    pub fn of_kind(self, kind: ModuleKind) -> Self {
        Self { kind: Some(kind), ..self }
    }

    /// All modules, in the order of the roster.
    pub fn modules(&self) -> &[ModuleLink<A>] {
        &self.modules
    }

    /// Datagrams that no module of the roster can be charged with: damaged ones, other fleets', strangers'.
    pub fn strays(&self) -> &Incoming {
        &self.strays
    }

    /// Who was heard that is not followed. What other fleets and other wire versions send is not checked, and may be made up.
    pub fn strangers(&self) -> Vec<Stranger<A>> {
        let wrong = |link: &ModuleLink<A>| {
            let (kind, address) = (link.kind().filter(|_| self.is_wrong(link))?, link.address()?);
            let (what, module) = (Strangeness::WrongKind(kind), Some(link.id()));
            let count = u64::from(link.incoming().accepted);
            Some(Stranger { what, module, address, heard: link.heard(), count })
        };
        self.strangers.all().iter().copied().chain(self.modules.iter().filter_map(wrong)).collect()
    }

    /// Why a module of the roster is silent or not used, as far as that is known at `now`.
    pub fn silence(&self, now: FleetInstant, module: ModuleId) -> Option<Silence> {
        let link = &self.modules[*self.places.get(&module)?];
        let never = || match link.incoming().accepted {
            0 => Silence::NeverHeard,
            _ => Silence::Unanswered,
        };
        Some(match () {
            () if link.is_doubled() => Silence::Doubled,
            () if link.is_elsewhere() => Silence::ServesAnotherHost,
            () if !link.is_known() => self.strangers.hint(now, module).unwrap_or_else(never),
            () if self.is_wrong(link) => Silence::WrongKind,
            () if link.is_implausible(now) => Silence::Implausible,
            () if link.state() == Some(ModuleState::Stopped) => Silence::Stopped,
            () => Silence::Known,
        })
    }

    fn is_wrong(&self, link: &ModuleLink<A>) -> bool {
        self.kind.zip(link.kind()).is_some_and(|(wanted, kind)| wanted != kind)
    }

    /// Takes in one datagram. What is not to be followed is counted and otherwise ignored.
    ///
    /// # Errors
    /// What it is instead, for those who want to show it; nothing needs to be done about it.
    pub fn handle_datagram(
        &mut self,
        now: FleetInstant,
        from: A,
        datagram: &[u8],
    ) -> Result<Option<DispatcherEvent>, Class> {
        let (index, frame) =
            self.addressed(now, from, datagram).inspect_err(|&class| self.strays.count(class))?;
        let nonces = &mut self.nonces;
        let was_doubled = self.modules[index].is_doubled();
        let heard = self.modules[index].open(now, from, &frame, || nonces.next())?;
        let doubled = !was_doubled && self.modules[index].is_doubled();
        match heard {
            Heard::Call { boot, in_another } => {
                self.outbox.push_back(QueuedDatagram::Call(index, boot));
                // Behind the call, which uses the nonce up where it is followed: a stop in the session comes next then.
                if in_another {
                    self.stop_outside(index, boot);
                }
                Ok(self.modules[index].is_elsewhere().then_some(DispatcherEvent::Elsewhere(index)))
            }
            Heard::Elsewhere(boot) => {
                self.stop_outside(index, boot);
                Ok(Some(DispatcherEvent::Elsewhere(index)))
            }
            Heard::Known => Ok(None),
            Heard::Rival { ask } => {
                if ask {
                    // It says nothing; that it came is the answer.
                    self.outbox.push_back(QueuedDatagram::Rival(index, Message::Called));
                }
                if doubled {
                    self.doubt(index);
                    return Ok(Some(DispatcherEvent::Doubled(index)));
                }
                if was_doubled { Ok(None) } else { Err(Class::Stale) }
            }
            Heard::Said { opened, joined } => {
                let first = joined.map(|joined| match joined {
                    _ if doubled || was_doubled => DispatcherEvent::Doubled(index),
                    Joined::First => DispatcherEvent::Joined(index),
                    Joined::Rebooted => DispatcherEvent::Rebooted(index),
                    Joined::Again => DispatcherEvent::Rejoined(index),
                });
                if joined == Some(Joined::Rebooted) {
                    self.forget(index);
                }
                if doubled {
                    self.doubt(index);
                }
                let Some(opened) = opened else { return first.map(Some).ok_or(Class::Corrupt) };
                // An answer is sent at once.
                if let Message::Acknowledge(_) = opened.message
                    && let Some(sent) = self.modules[index].saw(opened.seen)
                {
                    self.round_trip.add(now.since(sent));
                }
                let event = self.follow(now, index, opened.sequence, opened.message);
                Ok(first.or(event))
            }
        }
    }

    /// While a stop is in force, a module that announces itself is stopped whichever host it serves.
    fn stop_outside(&mut self, index: usize, boot: Nonce) {
        if self.orders[index].is_stop() {
            self.outbox.push_back(QueuedDatagram::Stop(index, boot));
        }
    }

    /// Whose datagram it is; strangers are noted.
    fn addressed<'a>(
        &mut self,
        now: FleetInstant,
        from: A,
        datagram: &'a [u8],
    ) -> Result<(usize, Frame<'a>), Class> {
        let frame = Frame::parse(datagram).map_err(|why| {
            self.strangers.unread(now, from, self.fleet, datagram, why);
            Class::Corrupt
        })?;
        let header = &frame.header;
        let index = self.places.get(&header.module).copied().ok_or(Class::Foreign)?;
        if header.fleet == self.fleet && header.kind.is_for_host() {
            return Ok((index, frame));
        }
        self.strangers.foreign(now, from, self.fleet, header);
        Err(Class::Foreign)
    }

    fn follow(
        &mut self,
        now: FleetInstant,
        index: usize,
        sequence: u32,
        message: Message,
    ) -> Option<DispatcherEvent> {
        match message {
            Message::TimeRequest(request) => {
                let reply = TimeReply { request_sent: request.sent, received: now, sent: now };
                self.outbox.push_back(QueuedDatagram::Message(index, Message::TimeReply(reply)));
                None
            }
            // Whose word it is is not known.
            _ if self.modules[index].is_doubled() => None,
            Message::Acknowledge(acknowledge) => self.acknowledged(now, index, acknowledge),
            // Reports may overtake each other; only the newest counts.
            Message::Telemetry(_) | Message::RovTelemetry(_) | Message::TailUnknown(_) => {
                let link = &mut self.modules[index];
                if link.note_report(now, sequence, message) {
                    self.orders[index].reported(now, link.state(), link.faults());
                    return Some(DispatcherEvent::Reported(index));
                }
                link.came_late();
                None
            }
            Message::Health(health) => {
                self.modules[index].note_health(health);
                None
            }
            _ => None,
        }
    }

    fn acknowledged(
        &mut self,
        now: FleetInstant,
        index: usize,
        acknowledge: Acknowledge,
    ) -> Option<DispatcherEvent> {
        let Acknowledge { cycle, verdict } = acknowledge;
        let link = &mut self.modules[index];
        let delivery = link.delivery.as_mut().filter(|delivery| delivery.number == cycle)?;
        let state = delivery.state.answered(verdict)?;
        if delivery.state == DeliveryState::Sent {
            link.answers.add(now.since(delivery.sent));
        }
        delivery.state = state;
        // An answer that comes after the start still tells what the module has.
        let counted = delivery.closed;
        delivery.closed |= !state.is_open();
        let (count, event) = match (state, verdict) {
            (DeliveryState::Taken, _) => {
                (&mut link.ledger.acknowledged, DispatcherEvent::Accepted { module: index, cycle })
            }
            (DeliveryState::Refused, Verdict::Refused(reason)) => {
                let event = DispatcherEvent::Refused { module: index, cycle, reason };
                let late = reason == Refusal::Late;
                (if late { &mut link.ledger.late } else { &mut link.ledger.refused }, event)
            }
            _ => return None,
        };
        *count += u64::from(!counted);
        Some(event)
    }

    /// Queues what is due: cycles not answered yet are sent again for as long as they are of use, prepared ones are committed
    /// or given up, stops are repeated until followed.
    pub fn handle_timer(&mut self, now: FleetInstant) {
        for index in 0..self.modules.len() {
            let link = &mut self.modules[index];
            if link.handle_timer(now) {
                self.outbox.push_back(QueuedDatagram::Message(index, Message::Called));
            }
            let in_session = link.is_reachable();
            let Some(delivery) = link.delivery.as_mut().filter(|delivery| delivery.is_open()) else {
                continue;
            };
            if delivery.useful_until <= now {
                // No answer says whether it was taken; without a commit no module took it.
                let never = delivery.state == DeliveryState::Prepared;
                let state = if never { DeliveryState::Dropped } else { delivery.state };
                self.abandon(index, state);
            } else if in_session && let Some(message) = delivery.due(now) {
                if delivery.state == DeliveryState::Unsent {
                    (delivery.state, delivery.sent) = (DeliveryState::Sent, now);
                } else {
                    link.ledger.resent += 1;
                }
                self.outbox.push_back(QueuedDatagram::Message(index, message));
            }
        }
        self.decide(now);
        self.repeat_orders(now);
    }

    /// Sends every module its part of cycle `number`, in the order of the roster, and keeps at it; a module without a motion gets
    /// none. One that was dispatched before and is still open is given up.
    pub fn dispatch(
        &mut self,
        now: FleetInstant,
        number: u32,
        start: FleetInstant,
        motions: &[Option<Motion>],
        delivery: Delivery,
    ) {
        debug_assert_eq!(motions.len(), self.modules.len(), "one motion for each module");
        let commit_lead = if delivery == Delivery::Prepare { self.lead().commit } else { Duration(0) };
        for (index, motion) in motions.iter().enumerate() {
            self.give_up(index);
            let Some(motion) = motion.clone() else { continue };
            self.orders[index].end_hold();
            let cycle = Cycle { number, start, motion, delivery };
            let link = &mut self.modules[index];
            link.ledger.cycles += 1;
            link.dispatched(CycleDelivery::new(now, cycle.clone(), link.is_reachable(), commit_lead));
            if link.is_reachable() {
                self.outbox.push_back(QueuedDatagram::Message(index, Message::Cycle(cycle)));
            }
        }
    }

    /// Writes the next datagram to the start of `buffer` (of [`protocol::MAX_DATAGRAM`] bytes) and returns that part, and where it goes
    /// to.
    pub fn poll_transmit<'a>(&mut self, now: FleetInstant, buffer: &'a mut [u8]) -> Option<(A, &'a [u8])> {
        // A loop over indices: a datagram that cannot be written leaves the buffer to the next.
        while let Some(queued) = self.outbox.pop_front() {
            let sealed = match queued {
                QueuedDatagram::Call(index, boot) => {
                    self.modules[index].seal_call(boot, buffer).map(|(to, bytes)| (to, bytes.len()))
                }
                QueuedDatagram::Stop(index, boot) => {
                    self.modules[index].seal_stop(boot, buffer).map(|(to, bytes)| (to, bytes.len()))
                }
                QueuedDatagram::Rival(index, message) => {
                    self.modules[index].seal_rival(now, &message, buffer).map(|(to, bytes)| (to, bytes.len()))
                }
                QueuedDatagram::Message(index, mut message) => {
                    if let Message::TimeReply(reply) = &mut message {
                        reply.sent = now;
                    }
                    self.modules[index].seal(now, &message, buffer).map(|(to, bytes)| (to, bytes.len()))
                }
            };
            if let Some((to, length)) = sealed {
                return Some((to, &buffer[..length]));
            }
        }
        None
    }

    /// A module that rebooted holds nothing that was sent before, and nothing queued before is to reach it.
    fn forget(&mut self, index: usize) {
        self.abandon(index, DeliveryState::Dropped);
        if let Some(delivery) = &mut self.modules[index].delivery {
            delivery.state = DeliveryState::Dropped;
        }
        self.outbox.retain(|queued| !matches!(queued, QueuedDatagram::Message(of, _) if *of == index));
    }

    /// Two modules answer: what was on its way to one of them is given up.
    fn doubt(&mut self, index: usize) {
        self.give_up(index);
        self.modules[index].doubt();
        let is_order = |message: &Message| !matches!(message, Message::Cycle(_) | Message::Commit(_));
        self.outbox.retain(|queued| match queued {
            QueuedDatagram::Message(of, message) => *of != index || is_order(message),
            _ => true,
        });
    }

    /// Gives up the cycle that is on its way to a module, if one is: another takes its place.
    fn give_up(&mut self, index: usize) {
        if let Some(state) = self.modules[index].delivery.as_ref().map(|delivery| delivery.state) {
            self.abandon(index, state);
        }
    }

    /// Ends a cycle that is still open, without an answer.
    fn abandon(&mut self, index: usize, state: DeliveryState) {
        let link = &mut self.modules[index];
        if let Some(delivery) = link.delivery.as_mut().filter(|delivery| delivery.is_open()) {
            link.ledger.unanswered += 1;
            delivery.state = state;
            delivery.closed = true;
        }
    }
}

#[cfg(test)]
mod tests;
