//! The module's side: link and endpoint of the firmware, around its real schedule and its real failsafe.
//!
//! | here | mirrors, in `firmware` |
//! |---|---|
//! | [`Module::called`] | `link.rs` `Link::called`; `endpoint.rs` `handle_datagram` (`Host::Another`) |
//! | [`Module::hears_host`] | `link.rs` `hears_host` |
//! | [`Module::hear`] | `session.rs` `Session::open` (of `protocol`), `endpoint.rs` `follow` |
//! | `Module::take_cycle` | `endpoint.rs` `take_cycle` |
//! | `Module::settle` | `endpoint.rs` `conditions`, `settle`; the state machine is the real one |
//! | [`Module::slot_begins`] | `endpoint.rs` `gate`; `schedule.rs` `settle` is the real one |
//! | [`Module::report`] | `endpoint.rs` `handle_timer`, `robot.rs` `report` |

use firmware::link::failsafe::{Conditions, Failsafe, FailsafeEvent};
use protocol::window::{Arrival, Window};
use protocol::{Delivery, ModuleState};

use crate::fleet::{Broken, Config};
use crate::said::{Ack, Answer, CycleSet, Held, Order, Pose, Report, Say, SessionId, Up};
use crate::slots::Slots;

/// Numbers of the newest commands of the session; 0 for none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
struct Newest {
    /// That made the waiting cycle wait.
    cycle: u8,
    stop: u8,
    release: u8,
    /// Hold, stop or release: what was sent before it is void.
    fence: u8,
    /// [`Past::stops`] at the last stop that its host does not know of: a release of a sender that had seen less is void. In the firmware the
    /// number of the next datagram stands for it.
    stopped_at: u8,
}

/// What happened to a module's cycles, for the properties; no module knows this.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Past {
    /// Begun.
    pub begun: CycleSet,
    /// Held once, and forgotten: by a boot, a stop, a hold, doubt, or another host.
    pub lost: CycleSet,
    /// Not held when a hold, a stop or a release was followed that was sent later.
    pub void: CycleSet,
    /// Times it was stopped or booted.
    pub stops: u8,
    /// What that was at the last stop that the host does not know of.
    pub unknown_stop: u8,
    /// Greatest number of a stop of the session that has come.
    pub told_stop: u8,
    /// A stop was ended by what is no release of it.
    pub slipped: bool,
    /// Given up by the host.
    pub dropped: CycleSet,
    /// The host was certain that it does not run it.
    pub never: CycleSet,
}

/// State of one module.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Module {
    /// Boots so far.
    pub boots: u8,
    /// Boot nonce, as [`SessionId::boot`] and [`SessionId::count`].
    pub nonce: (u8, u8),
    /// The session it is in.
    pub session: Option<SessionId>,
    /// When its host was heard last.
    heard: u8,
    /// It knows the fleet time.
    clock_known: bool,
    /// What it may do.
    pub failsafe: Failsafe,
    /// What it does.
    pub slots: Slots,
    newest: Newest,
    /// Greatest number that it refused; 0 for none.
    refused: u8,
    /// What has come in this session; left alone where every order has any number of copies.
    window: Window,
    /// What was said to it in its session, and can still make a difference.
    pub down: Vec<Order>,
    /// What it said in its session, as long as that is not in force with the host: then the host has it.
    pub up: Up,
    /// For the properties.
    pub past: Past,
}

impl Module {
    /// Located, and not in a session yet.
    #[must_use]
    pub fn booted(boots: u8, nonce: (u8, u8), tail: Pose, past: Past) -> Self {
        let mut module = Self {
            boots,
            nonce,
            session: None,
            heard: 0,
            clock_known: false,
            failsafe: Failsafe::new(),
            slots: Slots::new(tail),
            newest: Newest::default(),
            refused: 0,
            window: Window::new(),
            down: Vec::new(),
            up: Up::default(),
            past,
        };
        module.settle(0);
        module
    }

    /// Loses its memory.
    pub fn reboot(&mut self, config: &Config, now: u8) {
        let same = config.broken == Some(Broken::SameNonce);
        let mut past = self.past.clone();
        self.lose_all(&mut past);
        past.stops += 1;
        let nonce = if same { (0, 0) } else { (self.nonce.0 + 1, 0) };
        let tail = self.slots.tail(now);
        let down = std::mem::take(&mut self.down);
        *self = Self::booted(self.boots + 1, nonce, tail, past);
        if same {
            // What was recorded of the session opens in its twin.
            self.down = down;
        }
    }

    /// What waits, runs or ran last is forgotten.
    fn lose_all(&self, past: &mut Past) {
        past.lost |= self.slots.all().map(|held| held.bit()).fold(0, |sum, bit| sum | bit);
    }

    fn lose_next(&mut self, now: u8) {
        self.past.lost |= self.slots.next.map_or(0, |next| next.held.bit());
        self.slots.hold(now);
    }

    /// Whether its host has been heard lately. A slot is as long as it takes to believe that it is dead, or longer.
    #[must_use]
    pub fn hears_host(&self, now: u8) -> bool {
        self.session.is_some() && now <= self.heard
    }

    /// Whether a call to that session would be followed.
    #[must_use]
    pub fn may_be_called(&self, now: u8, session: SessionId) -> bool {
        (session.boot, session.count) == self.nonce
            && self.slots.running(now).is_none()
            && !self.hears_host(now)
    }

    /// Follows a call.
    pub fn called(&mut self, config: &Config, now: u8, session: SessionId) {
        let again = self.session.is_some_and(|former| former.life == session.life);
        self.session = Some(session);
        self.heard = now;
        (self.newest, self.window, self.up) = (Newest::default(), Window::new(), Up::default());
        self.past.told_stop = 0;
        if config.broken == Some(Broken::StopOfOneHost) && self.failsafe.state() == ModuleState::Stopped {
            self.past.slipped = true;
            self.slots.resume(now);
            self.failsafe.handle(FailsafeEvent::Released);
        }
        // One boot nonce, one session.
        if config.broken != Some(Broken::SameNonce) {
            self.nonce.1 += 1;
            self.down.clear();
        }
        if !again {
            let mut past = self.past.clone();
            self.lose_all(&mut past);
            self.past = past;
            self.slots.reset(now);
            self.refused = 0;
            self.clock_known = false;
            self.failsafe.handle(FailsafeEvent::HostChanged);
        }
        self.settle(now);
    }

    /// Whether it has still to learn the fleet time.
    #[must_use]
    pub const fn wants_time(&self) -> bool {
        self.session.is_some() && !self.clock_known
    }

    /// Learns the fleet time.
    pub fn take_time(&mut self, now: u8) {
        (self.clock_known, self.heard) = (true, now);
        self.settle(now);
    }

    /// A fault of its own stops it.
    pub fn stall(&mut self, config: &Config, now: u8) {
        let before = self.failsafe.faults();
        self.stop(config, now, FailsafeEvent::MotorStalled);
        if self.failsafe.faults() != before {
            self.newest.stopped_at = self.past.stops;
            self.past.unknown_stop = self.past.stops;
        }
        self.settle(now);
    }

    fn stop(&mut self, config: &Config, now: u8, reason: FailsafeEvent) {
        self.failsafe.handle(reason);
        if config.broken == Some(Broken::LateStop) && self.slots.running(now).is_some() {
            return;
        }
        if self.failsafe.state() == ModuleState::Stopped && !self.slots.is_stopped() {
            let mut past = self.past.clone();
            self.lose_all(&mut past);
            past.stops += 1;
            self.past = past;
            self.slots.stop(now);
        }
    }

    /// An order of its session comes. `doubt`: it is not sure of the time then.
    pub fn hear(&mut self, config: &Config, now: u8, order: Order, doubt: bool) {
        let Order { sequence, say } = order;
        if config.once && !matches!(self.window.note(u32::from(sequence)), Arrival::Fresh { .. }) {
            return;
        }
        self.heard = now;
        match say {
            // Called off already.
            Say::Cycle(_) | Say::Commit(_) if self.is_void(config, sequence) => {}
            Say::Cycle(held) => {
                let answer = self.take_cycle(config, now, held, doubt);
                self.answered(sequence, held.number, answer);
            }
            Say::Commit(number) => {
                let answer = self.slots.commit(now, number);
                self.answered(sequence, number, answer);
            }
            Say::Hold => {
                if self.newest.cycle <= sequence {
                    self.lose_next(now);
                }
                self.fence(sequence);
            }
            Say::Stop => {
                self.newest.stop = self.newest.stop.max(sequence);
                self.past.told_stop = self.past.told_stop.max(sequence);
                if self.newest.release <= sequence {
                    self.stop(config, now, FailsafeEvent::EmergencyStop);
                }
                self.fence(sequence);
            }
            Say::Release { seen, .. } if self.is_late(config, sequence, seen) => {}
            Say::Release { sent_at, .. } => {
                self.newest.release = self.newest.release.max(sequence);
                self.fence(sequence);
                if self.failsafe.state() == ModuleState::Stopped {
                    let before = sent_at < self.past.unknown_stop || sequence < self.past.told_stop;
                    self.past.slipped |= before;
                    self.slots.resume(now);
                    self.failsafe.handle(FailsafeEvent::Released);
                }
            }
        }
        self.settle(now);
    }

    /// Whether a release knew nothing of the last stop.
    fn is_late(&self, config: &Config, sequence: u8, seen: u8) -> bool {
        let late = self.newest.stop > sequence || seen < self.newest.stopped_at;
        late && config.broken != Some(Broken::BlindRelease)
    }

    /// From now on nothing counts that was sent before and is not held.
    fn fence(&mut self, sequence: u8) {
        self.newest.fence = self.newest.fence.max(sequence);
        for order in self.down.iter().filter(|order| order.sequence < sequence) {
            if let Say::Cycle(held) = order.say
                && !self.slots.has(held.id)
            {
                self.past.void |= held.bit();
            }
        }
    }

    fn is_void(&self, config: &Config, sequence: u8) -> bool {
        sequence < self.newest.fence && config.broken != Some(Broken::NoFence)
    }

    fn take_cycle(&mut self, config: &Config, now: u8, held: Held, doubt: bool) -> Answer {
        let known = self.slots.knows(held.number) && config.broken != Some(Broken::ForgetfulRefusals);
        let final_no = held.number <= self.refused && config.broken != Some(Broken::ForgetfulRefusals);
        if !known && (final_no || doubt || self.failsafe.takes_cycles().is_err()) {
            return Answer::Refused;
        }
        let early = config.broken == Some(Broken::NoCommit);
        let delivery = if early { Delivery::Direct } else { held.delivery };
        self.slots.offer(now, held, delivery)
    }

    fn answered(&mut self, sequence: u8, number: u8, answer: Answer) {
        if answer == Answer::Refused {
            self.refused = self.refused.max(number);
        } else {
            self.newest.cycle = self.newest.cycle.max(sequence);
        }
        self.up.acknowledge(Ack { number, answer });
    }

    /// A slot begins. `doubt`: the time is not known well enough just before.
    pub fn slot_begins(&mut self, now: u8, doubt: bool) {
        if doubt {
            self.lose_next(now - 1);
        }
        self.slots.begin(now);
        self.settle(now);
    }

    fn settle(&mut self, now: u8) {
        let conditions = Conditions {
            configured: true,
            located: true,
            clock_known: self.clock_known,
            armed: true,
            running: self.slots.running(now).is_some(),
            low_battery: false,
        };
        if self.failsafe.follow(&conditions) == Some(ModuleState::Unsynchronised) {
            self.lose_next(now);
        }
    }

    /// What it would report.
    #[must_use]
    pub fn report(&self, now: u8) -> Report {
        let at = if self.clock_known { now } else { 0 };
        let (state, latest) = (self.failsafe.state(), self.slots.reported());
        Report { at, state, latest, tail: self.slots.tail(now), stops: self.past.stops }
    }

    /// Forgets what can make no difference any more; `asked`: the number whose answers the host still wants.
    pub fn tidy(&mut self, config: &Config, now: u8, asked: Option<u8>) {
        let blind = config.broken == Some(Broken::BlindRelease);
        let Newest { stop, release, fence, stopped_at, .. } = self.newest;
        self.down.retain(|order| match order.say {
            Say::Cycle(held) => held.start > now || asked == Some(held.number),
            Say::Commit(number) => asked == Some(number) || self.slots.knows(number),
            Say::Hold => fence < order.sequence,
            Say::Stop => stop.max(release) < order.sequence,
            Say::Release { seen, .. } => blind || (stop < order.sequence && stopped_at <= seen),
        });
    }
}
