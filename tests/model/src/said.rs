//! Messages between host and modules, reduced to what matters: keys are symbols, motions are poses.

use protocol::{Delivery, ModuleState};

/// Modules, docked to each other.
pub const MODULES: usize = 2;

/// One bit for each cycle of all boots of the host, by [`Held::id`].
pub type CycleSet = u32;

/// A session, by the nonces of both sides: the module's boot and its sessions in that boot so far, and the life of the host. Two sessions have
/// the same keys if and only if these are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SessionId {
    /// Boot nonce of the module: the twelve bytes drawn at boot
    pub boot: u8,
    /// and the count of sessions in the last four.
    pub count: u8,
    /// Host nonce: the twelve bytes drawn when it started.
    pub life: u8,
}

/// Where a tail rests: 0 at first, n at the end of cycle n (by [`Held::id`]), n + `ADRIFT` somewhere within it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Pose(pub u8);

impl Pose {
    const ADRIFT: u8 = 64;

    /// Where a tail is that was stopped on its way to this one.
    #[must_use]
    pub const fn short_of(self) -> Self {
        Self(self.0 | Self::ADRIFT)
    }

    /// For the real schedule, rad: further apart than its tolerance, all in (−π, π].
    #[must_use]
    pub fn angle_rad(self) -> f32 {
        let magnitude_rad = 0.05 * f32::from(self.0 & !Self::ADRIFT);
        if self.0 & Self::ADRIFT == 0 { magnitude_rad } else { -0.025 - magnitude_rad }
    }
}

/// One module's part of a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Held {
    /// Its number, as sent.
    pub number: u8,
    /// Tells it from every other cycle; never sent. As the number, eight more for each life of the host.
    pub id: u8,
    /// The slot that begins with its start.
    pub start: u8,
    /// When it may run.
    pub delivery: Delivery,
    /// Where the plan takes the tail to be.
    pub from: Pose,
    /// Where it takes the other tail to be; never sent.
    pub beside: Pose,
    /// The module's boot when it was sent; never sent.
    pub boot: u8,
}

impl Held {
    /// Where it ends.
    #[must_use]
    pub const fn to(&self) -> Pose {
        Pose(self.id)
    }

    /// Its bit.
    #[must_use]
    pub const fn bit(&self) -> CycleSet {
        1 << self.id
    }

    /// The life of the host that planned it.
    #[must_use]
    pub const fn life(&self) -> u8 {
        life_of(self.id)
    }
}

/// The life of the host that the cycle `id` is from.
#[must_use]
pub const fn life_of(id: u8) -> u8 {
    id / 8 + 1
}

/// A message of the host in a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Say {
    /// A cycle.
    Cycle(Held),
    /// Its commit, by number.
    Commit(u8),
    /// Drop what has not begun.
    Hold,
    /// Freeze.
    Stop,
    /// No longer.
    Release {
        /// How often the module had been stopped or booted by the last report that the host had of it: what the receipt in the datagram says.
        seen: u8,
        /// How often it had really been when this was sent; never sent.
        sent_at: u8,
    },
}

/// Something said by the host, and everything that repeats it: a copy stands for all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Order {
    /// Its place in the session, from 1.
    pub sequence: u8,
    /// What.
    pub say: Say,
}

/// Content of an acknowledgement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Answer {
    /// Accepted, or a duplicate of what was: no difference to the host.
    Taken,
    /// Held until committed.
    Prepared,
    /// For whatever reason: no difference to the host.
    Refused,
}

/// An acknowledgement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Ack {
    /// Which cycle.
    pub number: u8,
    /// What became of it.
    pub answer: Answer,
}

/// A report, with what it says of the module at one time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Report {
    /// The slot it is from; 0 while the module does not know.
    pub at: u8,
    /// What it does.
    pub state: ModuleState,
    /// The cycle that runs or ran last, 0 for none.
    pub latest: u8,
    /// Where the tail is, if it rests.
    pub tail: Pose,
    /// How often the module had been stopped; never sent.
    pub stops: u8,
}

/// What a module has sent in one session and what may still come.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Up {
    /// In order.
    pub acks: Vec<Ack>,
    /// As sent; the newest one is not among them, but what the module would say now.
    pub reports: Vec<Report>,
}

impl Up {
    /// Adds an acknowledgement.
    pub fn acknowledge(&mut self, ack: Ack) {
        if let Err(place) = self.acks.binary_search(&ack) {
            self.acks.insert(place, ack);
        }
    }
}
