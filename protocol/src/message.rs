//! The messages of wire version 2.
//!
//! The order of enum variants and struct fields *is* the wire format (postcard writes them in order, without
//! names): append only, and bump [`WIRE_VERSION`] for anything else. `protocol/tests/wire/` holds the bytes.
//!
//! | message | from → to | when |
//! |---|---|---|
//! | [`Hello`] | module → host | announced from boot until a host is heard, then once a second |
//! | [`Message::Called`] | host → module | the answer to an announcement: opens a session |
//! | [`TimeRequest`], [`TimeReply`] | module → host → module | clock exchange, four timestamps |
//! | [`Cycle`] | host → module | ahead of its start, again until acknowledged |
//! | [`Message::Commit`] | host → module | when all have acknowledged a [`Delivery::Prepare`], again until acknowledged |
//! | [`Acknowledge`] | module → host | for every cycle and commit received, accepted or not |
//! | [`Telemetry`], [`RovTelemetry`] | module → host | at a fixed rate; which of the two, its kind decides |
//! | [`TailUnknown`] | module → host | in their place, while a Modboat has not seen its tail or has lost its zero |
//! | [`Health`] | module → host | once a second |
//! | [`Message::Hold`] | host → module | finish the running cycle, drop the next, hold the pose |
//! | [`Message::EmergencyStop`], [`Message::Release`] | host → module | freeze at once, and no longer |

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::ledger::Incoming;
use crate::time::{Duration, FleetInstant, LocalInstant};
use crate::units::{Amperes, Newtons, PulseMicros, Radians, RadiansPerSecond, Volts};

/// First byte of every datagram.
pub const WIRE_VERSION: u8 = 2;

/// Most thrusters of one ROV.
pub const MAX_THRUSTERS: usize = 8;

/// A module's number in its fleet, from 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ModuleId(pub u16);

impl core::fmt::Display for ModuleId {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}", self.0)
    }
}

/// One datagram's content.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Message {
    /// A module announces itself.
    Hello(Hello),
    /// A module asks for the fleet time.
    TimeRequest(TimeRequest),
    /// The host answers with it.
    TimeReply(TimeReply),
    /// What to execute, and when.
    Cycle(Cycle),
    /// What became of a cycle.
    Acknowledge(Acknowledge),
    /// What a module does and measures.
    Telemetry(Telemetry),
    /// Finish the running cycle, drop what follows, hold the pose.
    Hold,
    /// Freeze at once.
    EmergencyStop,
    /// What an ROV does and measures.
    RovTelemetry(RovTelemetry),
    /// A host takes a module into a session.
    Called,
    /// Every module has prepared the cycle with this number: run it.
    Commit(u32),
    /// Ends an emergency stop.
    Release,
    /// How a module's link and clock are.
    Health(Health),
    /// What a module does that does not know where its tail is.
    TailUnknown(TailUnknown),
}

/// What kind of robot a module is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ModuleKind {
    /// One motor, one tail.
    Modboat,
    /// Thrusters.
    Rov,
}

/// A module announces itself. The host needs no address list: it answers to where this came from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hello {
    /// What it is.
    pub kind: ModuleKind,
    /// Firmware version (major, minor, patch).
    pub firmware: (u8, u8, u8),
    /// The session it is in, 0 for none: a host sees whether it is its own.
    pub session: u32,
}

/// First half of a clock exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TimeRequest {
    /// t₁: when the module sent this, on its own clock.
    pub sent: LocalInstant,
}

/// Second half of a clock exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TimeReply {
    /// t₁, as received: which request this answers.
    pub request_sent: LocalInstant,
    /// t₂: when the host received the request, fleet time.
    pub received: FleetInstant,
    /// t₃: when the host sent this, fleet time.
    pub sent: FleetInstant,
}

/// One cycle of one module. Idempotent: the same cycle may arrive any number of times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cycle {
    /// Cycle number, counted by the host, growing.
    pub number: u32,
    /// When it starts, fleet time.
    pub start: FleetInstant,
    /// What to do.
    pub motion: Motion,
    /// When it may run.
    pub delivery: Delivery,
}

/// What a cycle needs before it may run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Delivery {
    /// Nothing more: any modules may miss it and no tails collide.
    Direct,
    /// A [`Message::Commit`] before its start; without one the module holds.
    Prepare,
}

/// What to do in a cycle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Motion {
    /// For a Modboat.
    Modboat(ModboatCycle),
    /// For an ROV.
    Rov(RovCycle),
}

/// A transition, then one period of waveform (1), φ(t) = φ₀ + A·cos(2πt/T).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModboatCycle {
    /// Rotation to take during the transition, signed: positive is counter-clockwise. It ends at φ₀ + A (mod 2π).
    pub rotation: Radians,
    /// Centerline φ₀, counter-clockwise from the sway axis.
    pub centerline: Radians,
    /// Amplitude A; the sign chooses the end at which the waveform starts, zero rests.
    pub amplitude: Radians,
    /// t_trans. Zero where no module of the fleet needs a transition.
    pub transition: Duration,
    /// T.
    pub period: Duration,
    /// How the transition goes through its time. On the wire it follows the whole message, and its absence means constant
    /// speed: cycles of hosts that know no other law are read as before.
    #[serde(skip)]
    pub law: TransitionLaw,
}

/// The law of time of a transition, one for the whole fleet: φ = from + s(t)·(to − from). In the phase space of two tails a
/// common s traces the same straight segment whatever it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum TransitionLaw {
    /// s grows at constant speed: the paper's law (§II-E), with a jump of speed at both ends.
    #[default]
    ConstantSpeed,
    /// s starts and ends at rest: constant acceleration for `ramp`, constant speed, constant deceleration for `ramp`.
    RestToRest {
        /// Length of each ramp, at most half of the transition.
        ramp: Duration,
    },
}

/// What is written behind a message. Its absence is the first variant of what it carries: messages of hosts that know neither are
/// read as before. A Modboat's cycle has the law of its transition there, an ROV's its connectors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Trailer {
    /// [`TransitionLaw::ConstantSpeed`], never written.
    ConstantSpeed,
    /// [`TransitionLaw::RestToRest`].
    RestToRest {
        /// Length of each ramp.
        ramp: Duration,
    },
    /// [`Connectors::Open`].
    Open,
}

impl Message {
    /// What is written behind the message, if anything.
    pub(crate) const fn trailer(&self) -> Option<Trailer> {
        match self {
            Self::Cycle(Cycle { motion: Motion::Modboat(ModboatCycle { law, .. }), .. }) => match *law {
                TransitionLaw::ConstantSpeed => None,
                TransitionLaw::RestToRest { ramp } => Some(Trailer::RestToRest { ramp }),
            },
            Self::Cycle(Cycle { motion: Motion::Rov(RovCycle { connectors, .. }), .. }) => match connectors {
                Connectors::Closed => None,
                Connectors::Open => Some(Trailer::Open),
            },
            _ => None,
        }
    }

    /// The same with what was read behind it; `None` where that may not stand.
    pub(crate) fn with_trailer(mut self, trailer: Trailer) -> Option<Self> {
        let Self::Cycle(Cycle { motion, .. }) = &mut self else { return None };
        match (motion, trailer) {
            (Motion::Modboat(cycle), Trailer::RestToRest { ramp }) => {
                cycle.law = TransitionLaw::RestToRest { ramp };
            }
            (Motion::Rov(cycle), Trailer::Open) => cycle.connectors = Connectors::Open,
            _ => return None,
        }
        Some(self)
    }
}

/// Thrusts to hold until the lease ends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RovCycle {
    /// Thrust of each thruster, along its own axis.
    pub thrusts: Vec<Newtons, MAX_THRUSTERS>,
    /// After this long without another cycle the thrusters go to neutral.
    pub lease: Duration,
    /// What its docking connectors do as long. On the wire it follows the whole message, and its absence means closed.
    #[serde(skip)]
    pub connectors: Connectors,
}

/// What the docking connectors of an ROV do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Connectors {
    /// They keep hold of what they have, and take hold of what meets them.
    #[default]
    Closed,
    /// They let go.
    Open,
}

/// What became of a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Acknowledge {
    /// Which cycle.
    pub cycle: u32,
    /// What the module decided.
    pub verdict: Verdict,
}

/// A module's decision about a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Verdict {
    /// It will run, or runs.
    Accepted,
    /// It had been accepted before; nothing changes.
    Duplicate,
    /// It will not run.
    Refused(Refusal),
    /// It is held, and will run if a commit comes before its start.
    Prepared,
}

/// Why a cycle was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// Its start has passed.
    Late,
    /// Its start lies further ahead than any plan.
    TooFarAhead,
    /// Its number is not after the last one run.
    AlreadyRun,
    /// Another cycle with this number, or one that overlaps it, was accepted before.
    Conflict,
    /// The tail is not where the cycle begins, or the rotation does not lead to φ₀ + A.
    PoseMismatch,
    /// Amplitude, speed or a duration is beyond the module's own limits, or not a number.
    BeyondLimits,
    /// The module does not know the fleet time.
    NotSynchronised,
    /// It is a cycle for another kind of robot.
    WrongKind,
    /// The module is stopped.
    Stopped,
    /// The module does not know the fleet time well enough.
    Unsure,
    /// The battery does not last for another one.
    LowBattery,
    /// A commit for a cycle that is not held.
    NotPrepared,
}

/// What a module is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ModuleState {
    /// It does not know the fleet time yet.
    Unsynchronised,
    /// It waits for its first cycle.
    Ready,
    /// It executes a cycle.
    Executing,
    /// It finished its last cycle and holds the end pose.
    Holding,
    /// Stopped until released.
    Stopped,
    /// It keeps its thrusters at neutral until their controllers obey.
    Arming,
    /// It looks where it is, and has not spoken yet.
    Boot,
    /// It has no valid configuration: it moves nothing, and says nothing.
    Unprovisioned,
}

/// What is wrong with a module, one bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Faults(pub u8);

impl Faults {
    /// The host stopped it.
    pub const EMERGENCY: Self = Self(1);
    /// The battery is low: it finishes its cycle, and takes no other.
    pub const LOW_BATTERY: Self = Self(1 << 1);
    /// The motor was driven and did not follow: it stopped.
    pub const STALLED: Self = Self(1 << 2);
    /// The encoder is not believed: the motor coasts.
    pub const BLIND: Self = Self(1 << 3);
    /// An output of the board failed.
    pub const OUTPUT: Self = Self(1 << 4);
    /// The tail stayed away from where it was told to be: it stopped.
    pub const FOLLOWING: Self = Self(1 << 5);
    /// The tail turned against its drive, as with swapped leads: it stopped.
    pub const WRONG_WAY: Self = Self(1 << 6);
    /// The index of the encoder came where the count does not expect it: the tail angle is unknown.
    pub const INDEX: Self = Self(1 << 7);

    /// Their names, for people.
    pub const NAMES: [(Self, &'static str); 8] = [
        (Self::EMERGENCY, "emergency stop"),
        (Self::LOW_BATTERY, "low battery"),
        (Self::STALLED, "motor stalled"),
        (Self::BLIND, "encoder not believed"),
        (Self::OUTPUT, "output failed"),
        (Self::FOLLOWING, "following error"),
        (Self::WRONG_WAY, "wrong direction of motion"),
        (Self::INDEX, "encoder index misplaced"),
    ];

    /// Names of those that are set.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        Self::NAMES.into_iter().filter(move |(fault, _)| self.has(*fault)).map(|(_, name)| name)
    }

    /// Whether all of `which` are set.
    #[must_use]
    pub const fn has(self, which: Self) -> bool {
        self.0 & which.0 == which.0
    }

    /// These and `which`.
    #[must_use]
    pub const fn with(self, which: Self) -> Self {
        Self(self.0 | which.0)
    }
}

/// How a module's link and clock are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Health {
    /// What came to it since its boot.
    pub incoming: Incoming,
    /// How far its fleet time may be off.
    pub uncertainty: Duration,
    /// How much faster fleet time runs than its own clock, 10⁻⁹.
    pub drift_ppb: i32,
}

/// What a module does and measures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Telemetry {
    /// When it was measured, fleet time (0 while unsynchronised).
    pub at: FleetInstant,
    /// What it is doing.
    pub state: ModuleState,
    /// The cycle that runs, or ran last; 0 before the first.
    pub cycle: u32,
    /// Tail angle, unwrapped.
    pub tail: Radians,
    /// Tail speed.
    pub rate: RadiansPerSecond,
    /// Motor current.
    pub current: Amperes,
    /// Battery voltage.
    pub battery: Volts,
    /// What is wrong with it.
    pub faults: Faults,
}

/// What a Modboat does that has not seen its tail yet, or has lost its zero.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TailUnknown {
    /// When that was so, fleet time (0 while unsynchronised).
    pub at: FleetInstant,
    /// What it is doing.
    pub state: ModuleState,
    /// The cycle that runs, or ran last; 0 before the first.
    pub cycle: u32,
    /// Battery voltage.
    pub battery: Volts,
    /// What is wrong with it.
    pub faults: Faults,
}

/// What an ROV does and measures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RovTelemetry {
    /// When it was measured, fleet time (0 while unsynchronised).
    pub at: FleetInstant,
    /// What it is doing.
    pub state: ModuleState,
    /// The cycle that runs, or ran last; 0 before the first.
    pub cycle: u32,
    /// Pulses that are really put out, one for each thruster in the order of the cycle's thrusts.
    pub pulses: Vec<PulseMicros, MAX_THRUSTERS>,
    /// Battery voltage.
    pub battery: Volts,
    /// Current drawn from the battery, all thrusters together.
    pub current: Amperes,
    /// What is wrong with it.
    pub faults: Faults,
}
