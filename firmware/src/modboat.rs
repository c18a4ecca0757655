//! The firmware of a Modboat: the link endpoint above the tail.
//!
//! It is run as every [`Module`] is, at the servo rate.
//!
//! What it watches, every tick: the battery, a tail that is not where it was told to be, an encoder that is not believed or whose
//! index is misplaced, a bridge that fails, and whether the ticks come when they should. What follows from them decides the
//! [`failsafe`](crate::link::failsafe).

use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;
use protocol::ModuleState;
use protocol::configuration::BatteryLimits;
use protocol::ledger::Class;
use protocol::time::{Duration, LocalInstant};
use protocol::units::Amperes;

use crate::link::endpoint::Endpoint;
use crate::link::failsafe::{BLIND_FOR, BatteryWatch, FailsafeEvent, Lasting, OUTPUT_FAILS_FOR, Permission};
use crate::modboat::encoder::Encoder;
use crate::modboat::following::FollowingWatch;
use crate::modboat::homing::{Homing, Search};
use crate::modboat::motor::ErrorOf;
use crate::modboat::robot::{Measurement, ModboatRobot};
use crate::modboat::servo::CurrentSense;
use crate::modboat::tail::{Tail, TailStatus};
use crate::module::{Module, Supply};

pub mod cycle;
pub mod disturbance;
pub mod encoder;
pub mod following;
pub mod homing;
pub mod kept_zero;
pub mod limits;
pub mod motor;
pub mod quadrature;
pub mod reference;
pub mod robot;
pub mod schedule;
pub mod servo;
pub mod tail;
pub mod transition;
pub mod waveform;

/// Ticks come every millisecond; after such a gap the own clock may have jumped, or the processor was elsewhere. *Assumed.*
const TICK_MISSED: Duration = Duration(20_000);

/// The firmware of a Modboat: link endpoint and tail.
#[derive(Debug)]
pub struct Modboat<E, S, P, A, B> {
    endpoint: Endpoint<ModboatRobot>,
    tail: Tail<E, S, P, A, B>,
    battery: BatteryWatch,
    following: FollowingWatch,
    homing: Homing,
    blind: Lasting,
    output: Lasting,
    last_tick: Option<LocalInstant>,
}

impl<E: Encoder, S: CurrentSense, P: SetDutyCycle, A: OutputPin, B: OutputPin> Modboat<E, S, P, A, B> {
    /// From its two halves.
    #[must_use]
    pub fn new(endpoint: Endpoint<ModboatRobot>, tail: Tail<E, S, P, A, B>) -> Self {
        Self {
            following: FollowingWatch::new(tail.following_error_time()),
            endpoint,
            tail,
            battery: BatteryWatch::new(BatteryLimits::MODBOAT),
            homing: Homing::by_hand(),
            blind: Lasting::new(),
            output: Lasting::new(),
            last_tick: None,
        }
    }

    /// With another battery.
    #[must_use]
    pub fn with_battery(self, limits: BatteryLimits) -> Self {
        Self { battery: BatteryWatch::new(limits), ..self }
    }

    /// With another way to find its zero.
    #[must_use]
    pub fn with_homing(self, homing: Homing) -> Self {
        Self { homing, ..self }
    }

    /// Finds out where the tail is, and drives it no more than that needs.
    fn look(&mut self, now: LocalInstant) -> Result<(), ErrorOf<P, A, B>> {
        let located = self.tail.locate().is_some();
        if self.endpoint.failsafe().permission() == Permission::Brake {
            // Stopped in mid-search: once released it waits again before it turns.
            self.homing.end();
            self.watch_eyes(now, self.tail.is_homed() && !located);
            return self.tail.brake();
        }
        if self.tail.is_homed() {
            self.watch_eyes(now, !located);
            self.homing.settles(now, self.tail.counter().rate());
            return self.tail.coast();
        }
        // A module that knows nothing of itself, or whose bridge failed, drives nothing.
        let may_search =
            self.endpoint.link().is_some() && self.endpoint.failsafe().state() == ModuleState::Boot;
        if !may_search {
            self.homing.end();
            return self.tail.coast();
        }
        match self.homing.search(now) {
            Search::Turn(drive) => self.tail.search(drive),
            Search::Wait => self.tail.coast(),
            Search::Fail => {
                self.homing.end();
                self.endpoint.stop(now, FailsafeEvent::Blind);
                self.tail.coast()
            }
        }
    }

    fn watch_ticks(&mut self, now: LocalInstant) {
        if let Some(last) = self.last_tick.replace(now) {
            let gap = now.since(last).max(last.since(now));
            if gap > TICK_MISSED {
                self.endpoint.disturbed(now, gap);
            }
        }
    }

    fn watch_tail(&mut self, now: LocalInstant, status: &TailStatus) {
        // Asked for a tail that is beyond its bound alone.
        let step_rad_s = if status.command.lagging { self.endpoint.speed_step_rad_s(now) } else { 0.0 };
        if let Some(why) = self.following.update(now, status, step_rad_s) {
            self.endpoint.stop(now, why);
        }
        self.watch_eyes(now, status.blind);
    }

    fn watch_eyes(&mut self, now: LocalInstant, blind: bool) {
        if self.blind.update(now, blind, BLIND_FOR) {
            self.endpoint.stop(now, FailsafeEvent::Blind);
        }
    }

    /// Its tail.
    #[must_use]
    pub const fn tail(&self) -> &Tail<E, S, P, A, B> {
        &self.tail
    }
}

impl<E: Encoder, S: CurrentSense, P: SetDutyCycle, A: OutputPin, B: OutputPin> Module
    for Modboat<E, S, P, A, B>
{
    type Robot = ModboatRobot;
    type Error = ErrorOf<P, A, B>;

    fn tick(&mut self, now: LocalInstant, &Supply { battery, .. }: &Supply) -> Result<(), Self::Error> {
        self.watch_ticks(now);
        let low = self.battery.update(now, battery);
        self.endpoint.set_low_battery(low);
        // Just booted, or stopped: look where the tail is, and let it be.
        let reference = self.endpoint.reference(now).filter(|_| self.endpoint.failsafe().may_drive());
        let (outcome, current) = match reference {
            Some(reference) => match self.tail.tick(&reference) {
                Ok(status) => {
                    self.watch_tail(now, &status);
                    (Ok(()), status.current)
                }
                Err(error) => (Err(error), None),
            },
            None => (self.look(now), None),
        };
        if self.output.update(now, outcome.is_err(), OUTPUT_FAILS_FOR) {
            self.endpoint.stop(now, FailsafeEvent::OutputFailed);
        }
        if self.tail.take_index_fault() {
            self.endpoint.stop(now, FailsafeEvent::IndexMisplaced);
        }
        let counter = self.tail.counter();
        let measurement = Measurement {
            tail: counter.unwrapped().filter(|_| !self.tail.is_blind() && !self.homing.is_searching()),
            lost: !self.tail.is_homed(),
            rate: counter.rate(),
            current: current.unwrap_or(Amperes(0.0)),
            battery,
        };
        self.endpoint.handle_timer(now, &measurement);
        outcome
    }

    fn handle_datagram(&mut self, now: LocalInstant, datagram: &[u8]) -> Result<(), Class> {
        self.endpoint.handle_datagram(now, datagram)
    }

    fn poll_transmit<'a>(&mut self, buffer: &'a mut [u8]) -> Option<&'a [u8]> {
        self.endpoint.poll_transmit(buffer)
    }

    fn endpoint(&self) -> &Endpoint<ModboatRobot> {
        &self.endpoint
    }
}

#[cfg(test)]
mod tests;
