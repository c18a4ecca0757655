//! Delivery of one cycle to its module, and of a plan that is not loss tolerant to all modules or none.
//!
//! ```text
//! direct    Sent ──accepted──→ Taken
//! prepare   Sent ──prepared──→ Prepared ──all prepared──→ Committing ──accepted──→ Taken
//!             └─── refused ──→ Refused        └── start comes near ──→ Dropped
//! ```
//!
//! A cycle goes out ahead of its start and again until it is answered, after 10 ms first, then after ever longer pauses up to
//! [`RESEND_MAX`]; a commit every [`COMMIT_EVERY`], because it has less time. Within 0.3 s a cycle goes out 17 times: at 30 % loss it
//! misses a module once in 10⁸.
//!
//! **What two phases can do, and what no protocol can.** A prepared cycle runs only where a commit came; a commit is sent only
//! when every module certainly holds the cycle, and only while there is still time to repeat it ([`lead`](super::lead)). So no module
//! runs a cycle that its neighbour never received. That the *commit* reaches all or none by a given instant, no
//! protocol over a link that may lose without bound can promise (J. Gray, Notes on Data Base Operating Systems, 1978; J. Halpern and
//! Y. Moses, JACM 37, 1990): the last message may always be the lost one. Plans that are loss tolerant need no promise,
//! and the exact planner makes them wherever it can; `loss_tolerant = "require"` makes no others.

use protocol::time::{Duration, FleetInstant};
use protocol::{Cycle, Delivery, Message, Motion, Verdict};

/// First pause between two sends of one cycle. *Assumed.*
pub const RESEND_FIRST: Duration = Duration(10_000);
/// Longest pause between two sends of one cycle. *Assumed.*
pub const RESEND_MAX: Duration = Duration(20_000);
/// Pause between two sends of one commit. *Assumed.*
pub const COMMIT_EVERY: Duration = Duration(10_000);
/// No commit is sent for the first time closer to the start: fifteen more fit in. *Assumed*; at high loss [`lead`](super::lead) says more.
pub const COMMIT_LEAD: Duration = Duration(150_000);

/// The pause after `pause`: a fifth longer each time.
pub(super) fn next_pause(pause: Duration) -> Duration {
    Duration(pause.0 + pause.0 / 5).min(RESEND_MAX)
}

/// What the host knows about whether a module has a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Knowledge {
    /// It reports that it runs or ran it.
    Certainly,
    /// It may.
    Possibly,
    /// It does not, and will not run it.
    CertainlyNot,
}

/// State of the delivery of one cycle to one module.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DeliveryState {
    /// The module was in no session: nothing was sent.
    Unsent,
    /// Sent, not answered.
    Sent,
    /// Held by the module, which waits for a commit; none was sent.
    Prepared,
    /// A commit was sent, and not answered.
    Committing,
    /// The module runs it at its start.
    Taken,
    /// The module does not run it.
    Refused,
    /// No commit was sent in time: no module runs it.
    Dropped,
}

impl DeliveryState {
    /// The state after an answer; `None` if the answer says nothing new.
    #[must_use]
    pub fn answered(self, verdict: Verdict) -> Option<Self> {
        match (self, verdict) {
            (Self::Sent | Self::Committing, Verdict::Accepted | Verdict::Duplicate) => Some(Self::Taken),
            (Self::Sent, Verdict::Prepared) => Some(Self::Prepared),
            // To a commit: it came too late, or the module has lost the cycle.
            (Self::Sent | Self::Committing, Verdict::Refused(_)) => Some(Self::Refused),
            _ => None,
        }
    }

    /// Whether the module certainly does not run it, whatever still comes.
    #[must_use]
    pub const fn is_never_run(self) -> bool {
        matches!(self, Self::Unsent | Self::Refused | Self::Dropped)
    }

    /// What is known of a cycle that has got so far. `reported`: whether the module's newest report says that it runs or ran it
    /// last; nothing if that is from before the start. To have taken a cycle does not mean to run it: the module may
    /// have been stopped, or have doubted its clock.
    #[must_use]
    pub const fn knowledge(self, reported: Option<bool>) -> Knowledge {
        match reported {
            Some(true) => Knowledge::Certainly,
            Some(false) => Knowledge::CertainlyNot,
            None if self.is_never_run() => Knowledge::CertainlyNot,
            None => Knowledge::Possibly,
        }
    }

    /// Whether something is still to be sent.
    #[must_use]
    pub const fn is_open(self) -> bool {
        matches!(self, Self::Unsent | Self::Sent | Self::Prepared | Self::Committing)
    }

    /// What the states of all modules in one cycle allow: commit, give up, or wait. `in_time`: a commit can still be repeated
    /// before the start. Once a commit was sent there is nothing to give up: a module that has it runs the cycle.
    #[must_use]
    pub fn decide(all: impl IntoIterator<Item = Self>, in_time: bool) -> PhaseOutcome {
        let (mut ready, mut missing) = (true, false);
        for state in all {
            match state {
                Self::Committing | Self::Taken => return PhaseOutcome::Wait,
                Self::Refused | Self::Dropped | Self::Unsent => missing = true,
                Self::Prepared => {}
                Self::Sent => ready = false,
            }
        }
        match (missing || !in_time, ready) {
            (true, _) => PhaseOutcome::Drop,
            (false, true) => PhaseOutcome::Commit,
            (false, false) => PhaseOutcome::Wait,
        }
    }
}

/// What becomes of a prepared cycle, from its deliveries to all modules.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PhaseOutcome {
    /// Some module has not answered yet, or it is committed.
    Wait,
    /// Every module holds it.
    Commit,
    /// Some module does not hold it, or it is too late.
    Drop,
}

/// The delivery of one cycle to one module.
#[derive(Clone, Debug)]
pub struct CycleDelivery {
    /// Its number.
    pub number: u32,
    /// When it starts, fleet time.
    pub start: FleetInstant,
    /// When it makes no difference any more whether it arrives, fleet time.
    pub useful_until: FleetInstant,
    /// Its state.
    pub state: DeliveryState,
    /// Nothing more is sent, and the ledger has counted it.
    pub(super) closed: bool,
    /// First sent.
    pub(super) sent: FleetInstant,
    cycle: Cycle,
    next_send: FleetInstant,
    pause: Duration,
    /// No commit of it is sent for the first time closer to the start.
    commit_lead: Duration,
}

impl CycleDelivery {
    /// Of a cycle that is sent for the first time at `now`, or cannot be.
    pub(super) fn new(now: FleetInstant, cycle: Cycle, sent: bool, commit_lead: Duration) -> Self {
        let useful_until = match &cycle.motion {
            Motion::Modboat(_) => cycle.start,
            Motion::Rov(thrusts) => cycle.start.after(thrusts.lease),
        };
        let state = if sent { DeliveryState::Sent } else { DeliveryState::Unsent };
        let Cycle { number, start, .. } = cycle;
        let (pause, next_send) = (RESEND_FIRST, now.after(RESEND_FIRST));
        let (sent, closed) = (now, false);
        Self { number, start, useful_until, state, closed, sent, cycle, next_send, pause, commit_lead }
    }

    /// Whether a commit can still be repeated often enough before the start.
    pub(super) fn is_in_time(&self, now: FleetInstant) -> bool {
        now.after(self.commit_lead) <= self.start
    }

    /// Whether it runs only if every module has it.
    pub(super) fn needs_all(&self) -> bool {
        self.cycle.delivery == Delivery::Prepare
    }

    /// Whether something is still to be sent.
    pub(super) fn is_open(&self) -> bool {
        !self.closed && self.state.is_open()
    }

    /// Goes over to committing at `now`; the commit to send.
    pub(super) fn commit(&mut self, now: FleetInstant) -> Message {
        self.state = DeliveryState::Committing;
        (self.pause, self.next_send) = (COMMIT_EVERY, now.after(COMMIT_EVERY));
        Message::Commit(self.number)
    }

    /// What is due to be sent again at `now`.
    pub(super) fn due(&mut self, now: FleetInstant) -> Option<Message> {
        if self.state == DeliveryState::Prepared || now < self.next_send {
            return None;
        }
        if self.state == DeliveryState::Committing {
            self.next_send = now.after(COMMIT_EVERY);
            return Some(Message::Commit(self.number));
        }
        self.pause = next_pause(self.pause);
        self.next_send = now.after(self.pause);
        Some(Message::Cycle(self.cycle.clone()))
    }
}
