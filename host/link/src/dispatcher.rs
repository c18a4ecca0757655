//! The host's side of the link: takes modules in, answers their clocks, sends each cycle ahead of its start and again until
//! it is answered, and keeps what each module has certainly, possibly and certainly not.
//!
//! A cycle of a Modboat is of use until it starts, the thrusts of an ROV until their lease ends; a newer cycle takes the
//! place of one that is still open. [`delivery`](super::delivery) has the two ways of delivery.
//!
//! Sans-IO: datagrams and the time go in, datagrams come out of [`Dispatcher::poll_transmit`]. Host time is fleet
//! time. A module is known by its id and its key; its address is wherever its newest datagram came from.

mod orders;

use std::collections::{HashMap, VecDeque};

use protocol::ledger::{Class, Incoming};
use protocol::time::FleetInstant;
use protocol::{
    Acknowledge, Cycle, Delivery, FleetId, FleetKey, Frame, Message, ModuleId, Motion, Nonce, Refusal,
    TimeReply, Verdict,
};

use self::orders::Orders;
use super::delivery::{COMMIT_LEAD, CycleDelivery, DeliveryState, PhaseOutcome};
pub use super::member::ModuleLink;
use super::member::{Heard, Joined};

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
    Message(usize, Message),
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
        Self { fleet, nonces, modules, places, outbox, orders, strays: Incoming::default() }
    }

    /// All modules, in the order of the roster.
    pub fn modules(&self) -> &[ModuleLink<A>] {
        &self.modules
    }

    /// Datagrams that no module of the roster can be charged with: damaged ones, other fleets', strangers'.
    pub fn strays(&self) -> &Incoming {
        &self.strays
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
        let addressed = Frame::parse(datagram).map_err(|_| Class::Corrupt).and_then(|frame| {
            let index = self.places.get(&frame.header.module).copied();
            let ours = frame.header.fleet == self.fleet && frame.header.kind.is_for_host();
            index.filter(|_| ours).map(|index| (index, frame)).ok_or(Class::Foreign)
        });
        let (index, frame) = addressed.inspect_err(|&class| self.strays.count(class))?;
        let nonces = &mut self.nonces;
        match self.modules[index].open(now, from, &frame, || nonces.next())? {
            Heard::Call(boot) => {
                self.outbox.push_back(QueuedDatagram::Call(index, boot));
                Ok(self.modules[index].is_elsewhere().then_some(DispatcherEvent::Elsewhere(index)))
            }
            Heard::Elsewhere => Ok(Some(DispatcherEvent::Elsewhere(index))),
            Heard::Known => Ok(None),
            Heard::Said { opened, joined } => {
                let first = joined.map(|joined| match joined {
                    Joined::First => DispatcherEvent::Joined(index),
                    Joined::Rebooted => DispatcherEvent::Rebooted(index),
                    Joined::Again => DispatcherEvent::Rejoined(index),
                });
                if joined == Some(Joined::Rebooted) {
                    self.forget(index);
                }
                let event = self.follow(now, index, opened.sequence, opened.message);
                Ok(first.or(event))
            }
        }
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
            Message::Acknowledge(acknowledge) => self.acknowledged(now, index, acknowledge),
            // Reports may overtake each other; only the newest counts.
            Message::Telemetry(_) | Message::RovTelemetry(_) => {
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
            let in_session = link.is_known();
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

    /// The deliveries of cycle `number`.
    fn deliveries(&self, number: u32) -> impl Iterator<Item = (usize, &CycleDelivery)> {
        let all = self
            .modules
            .iter()
            .enumerate()
            .filter_map(|(index, link)| Some((index, link.delivery.as_ref()?)));
        all.filter(move |(_, delivery)| delivery.number == number)
    }

    /// Commits a prepared cycle that every module holds, or gives it up.
    fn decide(&mut self, now: FleetInstant) {
        let prepared = |link: &ModuleLink<A>| {
            link.delivery.as_ref().filter(|delivery| delivery.needs_all() && delivery.is_open()).cloned()
        };
        let Some(CycleDelivery { number, start, .. }) = self.modules.iter().find_map(prepared) else {
            return;
        };
        let states = self.deliveries(number).map(|(_, delivery)| delivery.state);
        let outcome = DeliveryState::decide(states, now.after(COMMIT_LEAD) <= start);
        let all: Vec<usize> = self.deliveries(number).map(|(index, _)| index).collect();
        match outcome {
            PhaseOutcome::Wait => {}
            PhaseOutcome::Commit => {
                for index in all {
                    if let Some(delivery) = &mut self.modules[index].delivery {
                        self.outbox.push_back(QueuedDatagram::Message(index, delivery.commit(now)));
                    }
                }
            }
            PhaseOutcome::Drop => {
                all.into_iter().for_each(|index| self.abandon(index, DeliveryState::Dropped))
            }
        }
    }

    /// Whether cycle `number` was given up before its start: no module runs it.
    pub fn is_dropped(&self, number: u32) -> bool {
        let states = || {
            self.deliveries(number)
                .filter(|(_, delivery)| delivery.needs_all())
                .map(|(_, delivery)| delivery.state)
        };
        states().any(|state| matches!(state, DeliveryState::Dropped | DeliveryState::Refused))
            && !states().any(|state| matches!(state, DeliveryState::Committing | DeliveryState::Taken))
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
        for (index, motion) in motions.iter().enumerate() {
            self.give_up(index);
            let Some(motion) = motion.clone() else { continue };
            self.orders[index].end_hold();
            let cycle = Cycle { number, start, motion, delivery };
            let link = &mut self.modules[index];
            link.ledger.cycles += 1;
            link.dispatched(CycleDelivery::new(now, cycle.clone(), link.is_known()));
            if link.is_known() {
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
                QueuedDatagram::Message(index, mut message) => {
                    if let Message::TimeReply(reply) = &mut message {
                        reply.sent = now;
                    }
                    self.modules[index].seal(&message, buffer).map(|(to, bytes)| (to, bytes.len()))
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
