//! The firmware of an ROV: the link endpoint above the thrusters.
//!
//! It is run as every [`Module`] is, some hundred times a second. What it watches, every tick: the battery, and its outputs. One that
//! fails for [`OUTPUT_FAILS_FOR`] stops it: the others go to neutral.

use embedded_hal::pwm::SetDutyCycle;
use protocol::Connectors;
use protocol::configuration::BatteryLimits;
use protocol::ledger::Class;
use protocol::time::LocalInstant;

use crate::link::endpoint::Endpoint;
use crate::link::failsafe::{BatteryWatch, FailsafeEvent, Lasting, OUTPUT_FAILS_FOR};
use crate::module::{Module, Supply};
use crate::rov::lease::{Output, ThrustLease};
use crate::rov::thruster::bank::Bank;

pub mod lease;
pub mod thruster;

/// The firmware of an ROV: link endpoint and thrusters.
#[derive(Debug)]
pub struct Rov<P> {
    endpoint: Endpoint<ThrustLease>,
    bank: Bank<P>,
    battery: BatteryWatch,
    output: Lasting,
}

impl<P: SetDutyCycle> Rov<P> {
    /// From its two halves.
    #[must_use]
    pub const fn new(endpoint: Endpoint<ThrustLease>, bank: Bank<P>) -> Self {
        Self { endpoint, bank, battery: BatteryWatch::new(BatteryLimits::ROV), output: Lasting::new() }
    }

    /// With another battery.
    #[must_use]
    pub fn with_battery(self, limits: BatteryLimits) -> Self {
        Self { battery: BatteryWatch::new(limits), ..self }
    }

    /// What its docking connectors do at `now`, for a board that has some: to be read after every tick.
    #[must_use]
    pub fn connectors(&self, now: LocalInstant) -> Connectors {
        self.endpoint.connectors(now)
    }

    /// Its thrusters.
    #[must_use]
    pub const fn bank(&self) -> &Bank<P> {
        &self.bank
    }
}

impl<P: SetDutyCycle> Module for Rov<P> {
    type Robot = ThrustLease;
    type Error = P::Error;

    fn tick(&mut self, now: LocalInstant, supply: &Supply) -> Result<(), Self::Error> {
        let low = self.battery.update(now, supply.battery);
        self.endpoint.set_low_battery(low);
        let outcome = self.bank.tick(now, self.endpoint.thrusts(now), supply.battery);
        if self.output.update(now, outcome.is_err(), OUTPUT_FAILS_FOR) {
            self.endpoint.stop(now, FailsafeEvent::OutputFailed);
        }
        let &Supply { battery, current } = supply;
        let (pulses, armed) = (self.bank.pulses().clone(), self.bank.is_armed());
        let output = Output { pulses, battery, current, armed };
        self.endpoint.handle_timer(now, &output);
        outcome
    }

    fn handle_datagram(&mut self, now: LocalInstant, datagram: &[u8]) -> Result<(), Class> {
        self.endpoint.handle_datagram(now, datagram)
    }

    fn poll_transmit<'a>(&mut self, buffer: &'a mut [u8]) -> Option<&'a [u8]> {
        self.endpoint.poll_transmit(buffer)
    }

    fn endpoint(&self) -> &Endpoint<ThrustLease> {
        &self.endpoint
    }
}

#[cfg(test)]
mod tests;
