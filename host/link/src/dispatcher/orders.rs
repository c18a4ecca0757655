//! Orders to modules, each sent again until it is followed: stop, release and hold.
//!
//! | order | ends | sent again |
//! |---|---|---|
//! | stop | with a release | every [`ORDER_EVERY`] while the module does not report that it is stopped |
//! | release | when the module goes on, or is stopped for another reason | every [`ORDER_EVERY`] |
//! | hold | with the next cycle, with a stop, or when no cycle sent before it can begin any more | after ever longer pauses up to [`HOLD_MAX`] |
//!
//! Each module has orders of its own: a release of one leaves the stop of the others in force.
//!
//! **A release ends the stop it was meant for, and no later one.** Copies under way are told apart by the module: what was sent before its
//! last stop is void (`firmware::link::endpoint`). Here no copy is sent any more once the stop was followed by another:
//!
//! | last report at the release | then reports | what it means |
//! |---|---|---|
//! | stopped | goes on | followed; a stop after it is another one |
//! | stopped | stopped, with a fault that it did not have | another stop |
//! | goes on | stopped by a host, within [`RELEASE_SETTLES`] | a stop that was under way; to be released |
//! | goes on | stopped later, or for another reason | another stop |
//! | goes on | goes on, after [`RELEASE_SETTLES`] | nothing to release |
//! | none | stopped | stopped before the host knew it: to be released |
//!
//! Assumptions and limits: a module that is stopped for the same reason twice, with no report between, is released once too often. A
//! module that joins after a release is released whenever it was stopped.

use protocol::time::{Duration, FleetInstant};
use protocol::{Faults, Message, ModuleId, ModuleState};

use super::{Dispatcher, ModuleLink, QueuedDatagram};

/// Pause between two sends of a stop or its release, and the first of a hold. *Assumed.*
pub(super) const ORDER_EVERY: Duration = Duration(20_000);

/// Longest pause between two sends of a hold. At 30 % loss it misses a module once in 10⁸ within a second. *Assumed.*
pub(super) const HOLD_MAX: Duration = Duration(100_000);

/// Time after a release within which a stop sent before it, or a report of before that stop, may still arrive. *Assumed.*
pub(super) const RELEASE_SETTLES: Duration = Duration(300_000);

/// Faults that are no reason of the module's own to be stopped.
const NOT_ITS_OWN: Faults = Faults::EMERGENCY.with(Faults::LOW_BATTERY);

/// What a module's reports have said so far, seen from a release.
#[derive(Clone, Copy, Debug)]
enum Reported {
    Nothing,
    Going,
    Stopped(Faults),
}

#[derive(Clone, Copy, Debug)]
enum Order {
    /// In force until a release, also for a module that joins or goes on meanwhile.
    Stop { since: FleetInstant, next_send: FleetInstant },
    /// Over once it is followed.
    Release { next_send: FleetInstant, settled: FleetInstant, reported: Reported },
}

#[derive(Clone, Copy, Debug)]
struct Hold {
    /// When nothing sent before it can begin any more, fleet time.
    until: FleetInstant,
    pause: Duration,
    /// Nothing before the first timer.
    next_send: Option<FleetInstant>,
}

/// The orders in force for one module.
#[derive(Clone, Debug, Default)]
pub(super) struct Orders {
    order: Option<Order>,
    hold: Option<Hold>,
}

impl Orders {
    fn stop(&mut self, now: FleetInstant) {
        // It drops all that a hold would.
        *self = Self { order: Some(Order::Stop { since: now, next_send: now }), hold: None };
    }

    fn release<A: Copy>(&mut self, now: FleetInstant, link: &ModuleLink<A>) {
        let reported = match link.state() {
            None => Reported::Nothing,
            Some(ModuleState::Stopped) => Reported::Stopped(link.faults()),
            Some(_) => Reported::Going,
        };
        let settled = now.after(RELEASE_SETTLES);
        self.order = Some(Order::Release { next_send: now, settled, reported });
    }

    fn hold(&mut self, until: FleetInstant) {
        if !self.is_stop() {
            self.hold = Some(Hold { until, pause: ORDER_EVERY, next_send: None });
        }
    }

    /// A cycle is dispatched: what comes after it is not to be dropped.
    pub(super) fn end_hold(&mut self) {
        self.hold = None;
    }

    /// Whether a stop is in force.
    pub(super) fn is_stop(&self) -> bool {
        matches!(self.order, Some(Order::Stop { .. }))
    }

    /// Takes in a report of the module.
    pub(super) fn reported(&mut self, now: FleetInstant, state: Option<ModuleState>, faults: Faults) {
        let (Some(state), Some(Order::Release { settled, reported, .. })) = (state, &mut self.order) else {
            return;
        };
        let stopped = state == ModuleState::Stopped;
        let by_a_host = faults.0 & !NOT_ITS_OWN.0 == 0;
        let over = match *reported {
            Reported::Stopped(known) => !stopped || faults.0 & !known.with(Faults::LOW_BATTERY).0 != 0,
            Reported::Going if stopped => now >= *settled || !by_a_host,
            Reported::Going | Reported::Nothing => !stopped && now >= *settled,
        };
        if over {
            self.order = None;
        } else {
            *reported = if stopped { Reported::Stopped(faults) } else { Reported::Going };
        }
    }

    /// What is due to be sent at `now`.
    fn due<A: Copy>(&mut self, now: FleetInstant, link: &ModuleLink<A>) -> [Option<Message>; 2] {
        let order = match &mut self.order {
            Some(Order::Stop { since, next_send }) if *next_send <= now => {
                *next_send = now.after(ORDER_EVERY);
                (link.state_since(*since) != Some(ModuleState::Stopped)).then_some(Message::EmergencyStop)
            }
            Some(Order::Release { next_send, .. }) if *next_send <= now => {
                *next_send = now.after(ORDER_EVERY);
                Some(Message::Release)
            }
            _ => None,
        };
        self.hold = self.hold.filter(|hold| now < hold.until);
        let hold = self.hold.as_mut().and_then(|hold| {
            let due = hold.next_send.is_some_and(|next_send| next_send <= now);
            if due {
                // A fifth longer each time.
                hold.pause = Duration(hold.pause.0 + hold.pause.0 / 5).min(HOLD_MAX);
            }
            if due || hold.next_send.is_none() {
                hold.next_send = Some(now.after(hold.pause));
            }
            due.then_some(Message::Hold)
        });
        [order, hold]
    }
}

impl<A: Copy> Dispatcher<A> {
    /// Tells every module to finish the running cycle, to drop what follows and to hold; again until no cycle that was sent before can
    /// begin any more, or the next is dispatched. A stop stays in force.
    pub fn hold(&mut self) {
        for index in 0..self.modules.len() {
            self.give_up(index);
            self.orders[index].hold(self.modules[index].nothing_begins_after());
            self.tell(index, Message::Hold);
        }
    }

    /// Tells every module to freeze at once, again until it has. In force until a release, also for modules that join meanwhile.
    pub fn emergency_stop(&mut self, now: FleetInstant) {
        for index in 0..self.modules.len() {
            self.give_up(index);
            self.orders[index].stop(now);
        }
        self.repeat_orders(now);
    }

    /// Ends the stop of every module, the host's or the module's own.
    pub fn release(&mut self, now: FleetInstant) {
        for index in 0..self.modules.len() {
            self.give_up(index);
            self.orders[index].release(now, &self.modules[index]);
        }
        self.repeat_orders(now);
    }

    /// Ends the stop of one module; the others' stays in force. False if the roster has no such module.
    pub fn release_one(&mut self, now: FleetInstant, module: ModuleId) -> bool {
        let Some(&index) = self.places.get(&module) else { return false };
        self.give_up(index);
        self.orders[index].release(now, &self.modules[index]);
        self.repeat_orders(now);
        true
    }

    /// Queues the orders that are due.
    pub(super) fn repeat_orders(&mut self, now: FleetInstant) {
        for index in 0..self.modules.len() {
            let due = self.orders[index].due(now, &self.modules[index]);
            due.into_iter().flatten().for_each(|message| self.tell(index, message));
        }
    }

    /// Queues an order for a module, and for the other one with its number.
    fn tell(&mut self, index: usize, message: Message) {
        if self.modules[index].is_doubled() {
            self.outbox.push_back(QueuedDatagram::Rival(index, message.clone()));
        }
        self.outbox.push_back(QueuedDatagram::Message(index, message));
    }
}
