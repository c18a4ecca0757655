//! The pilot's progress through a run: its phases, and the table of what leads from one to another. Nothing else changes a phase.
//!
//! An event that the table does not name for a phase leaves it as it is. `host/docs/pilot.md` and its picture are made from
//! this table.

/// Progress of a pilot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Phase {
    /// No cycle is under way; one is decided on as soon as enough tails are known.
    Waiting,
    /// The last decision moves nothing, or was given up; the next is made when its time is over.
    Pausing,
    /// The first of a decision's two steps is under way; the second is still to be sent.
    Turning,
    /// A decision is under way, and all of it sent.
    Swimming,
    /// An operator has ordered a stop or a hold, or taken the target away.
    Halted,
    /// The run is over.
    Finished,
}

/// Every phase, in the order in which a pilot meets them.
pub const PHASES: [Phase; 6] =
    [Phase::Waiting, Phase::Pausing, Phase::Turning, Phase::Swimming, Phase::Halted, Phase::Finished];

/// Events that change the phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PhaseEvent {
    /// All of a decision is sent.
    Sent,
    /// The first of a decision's two steps is sent.
    FirstSent,
    /// The second is.
    SecondSent,
    /// A module has not the first step when the second is due.
    FirstMissed,
    /// The plan moves nothing.
    Held,
    /// The dispatcher has dropped what not all modules held in time.
    Dropped,
    /// The time of a decision that is not swum is over.
    PauseOver,
    /// A module does not run what it was sent, or too few tails are known.
    Lost,
    /// The newest pose is too old to swim by.
    Blind,
    /// A module reports that it has stopped, or turns out to be two.
    Stopped,
    /// An operator orders a stop or a hold, or takes the target away.
    Halted,
    /// An operator orders a release, or gives a target.
    Released,
    /// The host did not run for a while.
    Paused,
    /// The scenario's time is over, or the run is ended.
    Ended,
}

/// One line of the transition table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PhaseTransition {
    /// In this phase
    pub from: Phase,
    /// this event
    pub event: PhaseEvent,
    /// leads to this one,
    pub to: Phase,
    /// for this reason.
    pub why: &'static str,
}

macro_rules! table {
    ($($event:ident: $($from:ident)|+ => $to:ident, $why:literal;)+) => {
        &[$($(PhaseTransition {
            from: Phase::$from,
            event: PhaseEvent::$event,
            to: Phase::$to,
            why: $why,
        },)+)+]
    };
}

/// Every transition.
pub const PHASE_TRANSITIONS: &[PhaseTransition] = table! {
    Sent: Waiting | Swimming => Swimming, "the cycle starts one lead from now, or when the running one ends";
    FirstSent: Waiting | Swimming => Turning, "the tails turn by way of poses between, and rest there";
    SecondSent: Turning => Swimming, "every module certainly has the first step";
    FirstMissed: Turning => Waiting, "the second step is never sent: tails rest at the poses between, or where they were";
    Held: Waiting | Swimming => Pausing, "no plan was found that the tails can follow; they rest where they are";
    Dropped: Turning | Swimming => Pausing, "no module runs it: the next decision is made when it would have started";
    PauseOver: Pausing => Waiting, "the next decision is due";
    Lost: Swimming => Waiting, "the others finish their cycle and hold: from where to go on is seen when all rest";
    Blind: Turning | Swimming => Waiting, "the modules finish their cycle and hold; the next decision is made when poses come again";
    Stopped: Turning | Swimming => Waiting, "it let go of its cycle, and its tail may be anywhere";
    Paused: Turning | Swimming => Waiting, "the modules have finished what they had and hold: from where to go on is seen in what they report next";
    Halted: Waiting | Pausing | Turning | Swimming => Halted, "the modules have stopped, or finish what runs and hold";
    Released: Halted => Waiting, "from where to go on is seen when all rest";
    Ended: Waiting | Pausing | Turning | Swimming | Halted => Finished, "the modules finish what runs and hold";
};

impl Phase {
    /// The phase after an event.
    #[must_use]
    pub fn after(self, event: PhaseEvent) -> Self {
        let named = PHASE_TRANSITIONS.iter().find(|line| line.from == self && line.event == event);
        named.map_or(self, |line| line.to)
    }

    /// Whether a decision is on its way to the modules or being executed.
    #[must_use]
    pub const fn is_under_way(self) -> bool {
        matches!(self, Self::Turning | Self::Swimming)
    }
}
