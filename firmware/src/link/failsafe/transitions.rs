//! The transition table of the failsafe, and the events that cause transitions. Nothing else in Flotilla changes a module's state.

use protocol::{Faults, ModuleState};

/// Every state, in the order in which a module meets them.
pub const STATES: [ModuleState; 8] = [
    ModuleState::Boot,
    ModuleState::Unprovisioned,
    ModuleState::Unsynchronised,
    ModuleState::Arming,
    ModuleState::Ready,
    ModuleState::Executing,
    ModuleState::Holding,
    ModuleState::Stopped,
];

/// Events that the failsafe acts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FailsafeEvent {
    /// No valid configuration was found.
    Unconfigured,
    /// It has seen where it is.
    Located,
    /// The fleet time is known.
    ClockKnown,
    /// The fleet time is not known any more.
    ClockLost,
    /// Another host has called it, with another epoch of fleet time.
    HostChanged,
    /// Its controllers obey.
    Armed,
    /// A controller does not obey any more.
    Disarmed,
    /// The start of a cycle has come.
    CycleBegan,
    /// The last cycle has ended, or its lease, or the host said hold.
    CycleEnded,
    /// The host said stop.
    EmergencyStop,
    /// The motor is driven and does not turn; see [`following`](crate::modboat::following).
    MotorStalled,
    /// The tail is not where it was told to be, though it turns.
    FollowingError,
    /// The tail turns against its drive.
    WrongWay,
    /// The encoder's index came where the count does not expect it.
    IndexMisplaced,
    /// The encoder has not been believed for [`BLIND_FOR`](super::BLIND_FOR).
    Blind,
    /// An output of the board failed.
    OutputFailed,
    /// The host lets it go on.
    Released,
}

impl FailsafeEvent {
    /// Every event.
    pub const ALL: [Self; 17] = [
        Self::Unconfigured,
        Self::Located,
        Self::ClockKnown,
        Self::ClockLost,
        Self::HostChanged,
        Self::Armed,
        Self::Disarmed,
        Self::CycleBegan,
        Self::CycleEnded,
        Self::EmergencyStop,
        Self::MotorStalled,
        Self::FollowingError,
        Self::WrongWay,
        Self::IndexMisplaced,
        Self::Blind,
        Self::OutputFailed,
        Self::Released,
    ];

    /// The fault that stays behind until it is released; none for an event that does not stop.
    #[must_use]
    pub const fn fault(self) -> Faults {
        match self {
            Self::EmergencyStop => Faults::EMERGENCY,
            Self::MotorStalled => Faults::STALLED,
            Self::FollowingError => Faults::FOLLOWING,
            Self::WrongWay => Faults::WRONG_WAY,
            Self::IndexMisplaced => Faults::INDEX,
            Self::Blind => Faults::BLIND,
            Self::OutputFailed => Faults::OUTPUT,
            Self::Unconfigured
            | Self::Located
            | Self::ClockKnown
            | Self::ClockLost
            | Self::HostChanged
            | Self::Armed
            | Self::Disarmed
            | Self::CycleBegan
            | Self::CycleEnded
            | Self::Released => Faults(0),
        }
    }
}

/// One line of the transition table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Transition {
    /// In this state
    pub from: ModuleState,
    /// this event
    pub event: FailsafeEvent,
    /// leads to this one,
    pub to: ModuleState,
    /// for this reason.
    pub why: &'static str,
}

macro_rules! table {
    ($($event:ident: $($from:ident)|+ => $to:ident, $why:literal;)+) => {
        &[$($(Transition {
            from: ModuleState::$from,
            event: FailsafeEvent::$event,
            to: ModuleState::$to,
            why: $why,
        },)+)+]
    };
}

/// Every transition.
pub const TRANSITIONS: &[Transition] = table! {
    Unconfigured: Boot => Unprovisioned, "a module that does not know who it is moves nothing and says nothing";
    Located: Boot => Unsynchronised, "it can hold a pose, and may speak";
    ClockKnown: Unsynchronised => Arming, "the start of a cycle means something now";
    Armed: Arming => Ready, "what a cycle asks will be done; a Modboat has nothing to arm";
    CycleBegan: Ready | Holding => Executing, "the start of an accepted cycle has come";
    CycleEnded: Executing => Holding, "nothing valid follows: holding is the safe act";
    Disarmed: Ready | Executing | Holding => Arming, "thrust would come from some controllers and not from others";
    ClockLost: Arming | Ready | Holding => Unsynchronised, "no cycle runs, and none could begin on time";
    HostChanged: Arming | Ready | Holding => Unsynchronised, "another host, another epoch of fleet time";
    EmergencyStop: Boot | Unsynchronised | Arming | Ready | Executing | Holding => Stopped,
        "a host said so: its drive is off";
    MotorStalled: Boot | Unsynchronised | Arming | Ready | Executing | Holding => Stopped,
        "something holds the tail: driving on would burn the motor, or what holds it";
    FollowingError: Boot | Unsynchronised | Arming | Ready | Executing | Holding => Stopped,
        "it is not where its neighbours take it to be";
    WrongWay: Boot | Unsynchronised | Arming | Ready | Executing | Holding => Stopped,
        "swapped leads or a wrong sign: the loop drives the tail away";
    IndexMisplaced: Boot | Unsynchronised | Arming | Ready | Executing | Holding => Stopped,
        "counts were lost: the tail is elsewhere than it says";
    Blind: Boot | Unsynchronised | Arming | Ready | Executing | Holding => Stopped,
        "a closed loop without eyes would run away";
    OutputFailed: Boot | Unsynchronised | Arming | Ready | Executing | Holding => Stopped,
        "what the board puts out is unknown";
    Released: Stopped => Boot, "it looks again where it is, for the tail may have been turned";
};

/// The transition that `event` causes in the state `from`, if any.
#[must_use]
pub fn transition(from: ModuleState, event: FailsafeEvent) -> Option<&'static Transition> {
    TRANSITIONS.iter().find(|transition| transition.from == from && transition.event == event)
}
