//! The [`Robot`] of a Modboat: runs cycles through a [`Schedule`], and reports the tail.
//!
//! The schedule begins with the first measurement: before it the tail angle is unknown, and every cycle is refused.
//! After a stop it goes on from the next one, wherever the tail was turned meanwhile.

use protocol::time::{FleetInstant, LocalInstant};
use protocol::units::{Amperes, Radians, RadiansPerSecond, Volts};
use protocol::{Cycle, Message, ModboatCycle, ModuleKind, Motion, Refusal, TailUnknown, Telemetry, Verdict};

use crate::link::endpoint::{Endpoint, Present, Robot};
use crate::modboat::cycle::SwimCycle;
use crate::modboat::reference::Reference;
use crate::modboat::schedule::{self, Schedule};
use crate::modboat::waveform::Waveform;
use protocol::configuration::TailLimits;

/// What a Modboat measures for its reports.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measurement {
    /// Tail angle, unwrapped; nothing while the encoder is not believed.
    pub tail: Option<Radians>,
    /// The encoder does not know where in the turn it is: what was seen before means nothing.
    pub lost: bool,
    /// Tail speed.
    pub rate: RadiansPerSecond,
    /// Motor current.
    pub current: Amperes,
    /// Battery voltage.
    pub battery: Volts,
}

/// The [`Robot`] of a Modboat: its schedule of cycles and its tail reports.
#[derive(Clone, Debug)]
pub struct ModboatRobot {
    limits: TailLimits,
    schedule: Option<Schedule>,
    /// Where the tail was seen last, unless it was lost since.
    tail: Option<Radians>,
    measured: Measurement,
    /// It was released and has not seen its tail since.
    released: bool,
}

impl ModboatRobot {
    /// One that has not seen its tail yet.
    #[must_use]
    pub const fn new(limits: TailLimits) -> Self {
        let none = RadiansPerSecond(0.0);
        let measured = Measurement {
            tail: None,
            lost: false,
            rate: none,
            current: Amperes(0.0),
            battery: Volts(f32::NAN),
        };
        Self { limits, schedule: None, tail: None, measured, released: false }
    }
}

impl Endpoint<ModboatRobot> {
    /// What the tail is to do at `now`, own clock; nothing before the first measurement.
    #[must_use]
    pub fn reference(&self, now: LocalInstant) -> Option<Reference> {
        Some(self.robot().schedule.as_ref()?.reference(self.fleet(now)))
    }

    /// The steps of speed, rad/s, in the transition of the cycle that is being run.
    #[must_use]
    pub fn speed_step_rad_s(&self, now: LocalInstant) -> f32 {
        self.robot().schedule.as_ref().map_or(0.0, |schedule| schedule.speed_step_rad_s(self.fleet(now)))
    }
}

impl Robot for ModboatRobot {
    const KIND: ModuleKind = ModuleKind::Modboat;
    type Measurement = Measurement;

    fn observe(&mut self, measurement: &Measurement) {
        self.measured = *measurement;
        if measurement.lost {
            self.tail = None;
        }
        let Some(tail) = measurement.tail else { return };
        self.tail = Some(tail);
        let schedule = self.schedule.get_or_insert_with(|| Schedule::new(self.limits, tail));
        if core::mem::take(&mut self.released) {
            schedule.resume(tail);
        }
    }

    fn is_located(&self) -> bool {
        self.schedule.is_some() && !self.released
    }

    fn knows(&self, cycle: u32) -> bool {
        self.schedule.as_ref().is_some_and(|schedule| schedule.knows(cycle))
    }

    fn offer(&mut self, now: FleetInstant, cycle: &Cycle) -> Verdict {
        let Motion::Modboat(motion) = &cycle.motion else { return Verdict::Refused(Refusal::WrongKind) };
        let Some(schedule) = &mut self.schedule else { return Verdict::Refused(Refusal::NotSynchronised) };
        let &ModboatCycle { rotation, centerline, amplitude, transition, period, law } = motion;
        let waveform = Waveform::new(centerline, amplitude, period);
        let offered = SwimCycle::new(cycle.number, cycle.start, rotation, (transition, law), waveform);
        on_the_wire(schedule.offer(now, offered, cycle.delivery))
    }

    fn commit(&mut self, now: FleetInstant, cycle: u32) -> Verdict {
        let Some(schedule) = &mut self.schedule else { return Verdict::Refused(Refusal::NotPrepared) };
        on_the_wire(schedule.commit(now, cycle))
    }

    fn waiting(&self, now: FleetInstant) -> Option<FleetInstant> {
        self.schedule.as_ref()?.waiting(now).map(SwimCycle::start)
    }

    fn hold(&mut self, now: FleetInstant) {
        if let Some(schedule) = &mut self.schedule {
            schedule.hold(now);
        }
    }

    fn emergency_stop(&mut self, now: FleetInstant) {
        self.released = false;
        if let Some(schedule) = &mut self.schedule {
            schedule.emergency_stop(now);
        }
    }

    fn release(&mut self) {
        self.released = true;
    }

    fn running(&self, now: FleetInstant) -> Option<u32> {
        self.schedule.as_ref()?.running(now)
    }

    fn latest(&self, now: FleetInstant) -> Option<u32> {
        self.schedule.as_ref()?.latest(now)
    }

    fn start_new_epoch(&mut self, now: FleetInstant) {
        self.schedule = self.schedule.as_ref().map(|schedule| schedule.for_new_epoch(now));
    }

    fn report(&self, present: &Present) -> Option<Message> {
        let &Present { at, state, cycle, faults } = present;
        let Measurement { rate, current, battery, .. } = self.measured;
        Some(match self.tail {
            Some(tail) => {
                Message::Telemetry(Telemetry { at, state, cycle, tail, rate, current, battery, faults })
            }
            None => Message::TailUnknown(TailUnknown { at, state, cycle, battery, faults }),
        })
    }
}

/// The schedule's verdict without its numbers.
fn on_the_wire(verdict: schedule::Verdict) -> Verdict {
    let refusal = match verdict {
        schedule::Verdict::Accepted => return Verdict::Accepted,
        schedule::Verdict::Duplicate => return Verdict::Duplicate,
        schedule::Verdict::Prepared => return Verdict::Prepared,
        schedule::Verdict::Refused(refusal) => refusal,
    };
    Verdict::Refused(match refusal {
        schedule::Refusal::Stopped => Refusal::Stopped,
        schedule::Refusal::Conflict | schedule::Refusal::Full { .. } | schedule::Refusal::Overlap { .. } => {
            Refusal::Conflict
        }
        schedule::Refusal::NotPrepared => Refusal::NotPrepared,
        schedule::Refusal::AlreadyRun { .. } => Refusal::AlreadyRun,
        schedule::Refusal::Limit(_) => Refusal::BeyondLimits,
        schedule::Refusal::Late { .. } => Refusal::Late,
        schedule::Refusal::TooFarAhead { .. } => Refusal::TooFarAhead,
        schedule::Refusal::PoseMismatch { .. } => Refusal::PoseMismatch,
    })
}
