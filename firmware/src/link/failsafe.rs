//! The failsafe: the one state machine that decides what a module may do, and the permissions derived from its state.
//!
//! Events come in, [`TRANSITIONS`] says what they change, and nothing else does. An event that the table does not
//! name for a state leaves it as it is. `firmware/docs/failsafe.svg` and `.md` are made from the same table.
//!
//! | state | drives | takes cycles | announces |
//! |---|---|---|---|
//! | Boot | nothing: it looks where it is | no | no |
//! | Unprovisioned | nothing, until the next boot | no | no |
//! | Unsynchronised | holds its pose | no: not synchronised | yes |
//! | Arming | neutral: the outputs see to it | yes | yes |
//! | Ready | holds its pose | yes | yes |
//! | Executing | its cycle | yes | yes |
//! | Holding | holds its pose | yes | yes |
//! | Stopped | nothing: the motor is shorted, or coasts if an output failed | no: stopped | yes |
//!
//! An ROV holds, and is stopped, by neutral thrust. The faults that stop are latched until released; a low battery is not: it lets what
//! was accepted run to its end, refuses what comes after, and is over when the voltage has recovered.
//!
//! | the robot owes, on entering | what |
//! |---|---|
//! | Unsynchronised | drops the cycles that wait: their starts mean nothing now |
//! | Stopped | freezes the reference and drops all cycles |
//! | Boot, after a release | takes the measured pose for its reference, wherever the tail was turned meanwhile |
//!
//! Decided here:
//! - The clock is lost while a cycle runs: it stays Executing until nothing runs, for others count on that cycle;
//!   but takes no more. Then it is Unsynchronised.
//! - Another host is heard while a cycle runs: nothing changes. The endpoint asks again once the cycle is over.
//! - An ROV that loses its arming shows Arming whatever it did before. The cycle goes on on paper, and is put
//!   out again from Ready if its lease lasts that long.
//! - A Modboat has nothing to arm and passes Arming within the tick.
//! - Released leads to Boot and not to Ready: a tail that coasted is anywhere.
//!
//! Assumptions and limits: the configuration is read once, before the first tick. [`Failsafe::follow`] runs first of
//! all and then every tick; stops, releases and a change of host come as events between two ticks. A stop is not
//! remembered over a loss of power.

use protocol::{Faults, ModuleState, Refusal};

mod battery;
mod lasting;
mod transitions;

pub use battery::BatteryWatch;
pub use lasting::{BLIND_FOR, Lasting, OUTPUT_FAILS_FOR};
pub use transitions::{FailsafeEvent, STATES, TRANSITIONS, Transition, transition};

/// Most transitions of one [`Failsafe::follow`]: from Boot to Executing there are four.
const STEPS: usize = 6;

/// What the outputs of a module may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Permission {
    /// Whatever its cycle or its pose needs.
    Drive,
    /// Nothing but short the motor, which brakes the tail; neutral on an ROV.
    Brake,
    /// Nothing: the motor is open.
    Coast,
}

/// What is the case at one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Conditions {
    /// Its configuration is valid.
    pub configured: bool,
    /// It has seen where it is. An ROV has nothing to see: true once its outputs are there.
    pub located: bool,
    /// It knows the fleet time.
    pub clock_known: bool,
    /// Its controllers obey. Always true for a Modboat.
    pub armed: bool,
    /// A cycle runs: its start has come, its end or the end of its lease has not.
    pub running: bool,
    /// The battery is low; see [`BatteryWatch`].
    pub low_battery: bool,
}

impl Conditions {
    /// The event that brings `state` nearer to these conditions, if it is not in line with them.
    #[must_use]
    pub const fn event(&self, state: ModuleState) -> Option<FailsafeEvent> {
        let &Self { configured, located, clock_known, armed, running, .. } = self;
        match state {
            ModuleState::Boot if !configured => Some(FailsafeEvent::Unconfigured),
            ModuleState::Boot if located => Some(FailsafeEvent::Located),
            ModuleState::Unsynchronised if clock_known => Some(FailsafeEvent::ClockKnown),
            ModuleState::Arming | ModuleState::Ready | ModuleState::Holding if !clock_known && !running => {
                Some(FailsafeEvent::ClockLost)
            }
            ModuleState::Arming if armed => Some(FailsafeEvent::Armed),
            ModuleState::Ready | ModuleState::Executing | ModuleState::Holding if !armed => {
                Some(FailsafeEvent::Disarmed)
            }
            ModuleState::Ready | ModuleState::Holding if running => Some(FailsafeEvent::CycleBegan),
            ModuleState::Executing if !running => Some(FailsafeEvent::CycleEnded),
            _ => None,
        }
    }
}

/// The failsafe state machine of one module.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Failsafe {
    state: ModuleState,
    faults: Faults,
    /// It has seen where it is since its boot or its last release.
    located: bool,
    /// The fleet time is not known, though a cycle may still run.
    unsure: bool,
}

impl Default for Failsafe {
    fn default() -> Self {
        Self::new()
    }
}

impl Failsafe {
    /// That of a module that has just booted.
    #[must_use]
    pub const fn new() -> Self {
        Self { state: ModuleState::Boot, faults: Faults(0), located: false, unsure: true }
    }

    /// Takes one event; the new state if it changed. A stop that comes while stopped adds its fault.
    pub fn handle(&mut self, event: FailsafeEvent) -> Option<ModuleState> {
        let next = transition(self.state, event).map(|transition| transition.to);
        self.state = next.unwrap_or(self.state);
        match event {
            FailsafeEvent::ClockLost => self.unsure = true,
            FailsafeEvent::ClockKnown => self.unsure = false,
            FailsafeEvent::Located if next.is_some() => self.located = true,
            FailsafeEvent::Released if next.is_some() => {
                self.located = false;
                self.faults = Faults(self.faults.0 & Faults::LOW_BATTERY.0);
            }
            _ if self.state == ModuleState::Stopped => self.faults = self.faults.with(event.fault()),
            _ => {}
        }
        next
    }

    /// Brings the state in line with the conditions, once a tick; the new state if it changed.
    pub fn follow(&mut self, conditions: &Conditions) -> Option<ModuleState> {
        let before = self.state;
        self.unsure = !conditions.clock_known;
        let others = Faults(self.faults.0 & !Faults::LOW_BATTERY.0);
        self.faults = if conditions.low_battery { others.with(Faults::LOW_BATTERY) } else { others };
        for _ in 0..STEPS {
            let Some(event) = conditions.event(self.state) else { break };
            self.handle(event);
        }
        (self.state != before).then_some(self.state)
    }

    /// What the module is doing.
    #[must_use]
    pub const fn state(&self) -> ModuleState {
        self.state
    }

    /// What is wrong with it.
    #[must_use]
    pub const fn faults(&self) -> Faults {
        self.faults
    }

    /// What its outputs may do. Holding a pose is driving.
    #[must_use]
    pub const fn permission(&self) -> Permission {
        match self.state {
            // What the bridge makes of a command is unknown.
            ModuleState::Stopped if self.faults.has(Faults::OUTPUT) => Permission::Coast,
            ModuleState::Stopped => Permission::Brake,
            _ if self.located => Permission::Drive,
            _ => Permission::Coast,
        }
    }

    /// Whether its outputs may do anything but brake, coast or neutral.
    #[must_use]
    pub const fn may_drive(&self) -> bool {
        matches!(self.permission(), Permission::Drive)
    }

    /// Whether a cycle may be accepted, as far as this goes: the robot looks at the cycle itself.
    ///
    /// # Errors
    /// Why every cycle is refused.
    pub const fn takes_cycles(&self) -> Result<(), Refusal> {
        match self.state {
            ModuleState::Stopped => Err(Refusal::Stopped),
            ModuleState::Boot | ModuleState::Unprovisioned | ModuleState::Unsynchronised => {
                Err(Refusal::NotSynchronised)
            }
            _ if self.unsure => Err(Refusal::NotSynchronised),
            _ if self.faults.has(Faults::LOW_BATTERY) => Err(Refusal::LowBattery),
            ModuleState::Arming | ModuleState::Ready | ModuleState::Executing | ModuleState::Holding => {
                Ok(())
            }
        }
    }

    /// Whether it may speak.
    #[must_use]
    pub const fn announces(&self) -> bool {
        !matches!(self.state, ModuleState::Boot | ModuleState::Unprovisioned)
    }
}

#[cfg(test)]
mod tests;
