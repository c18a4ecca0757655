//! A whole ROV: the link endpoint above the thrusters.
//!
//! A board calls [`Rov::tick`] some hundred times a second, [`Rov::handle_datagram`] for every datagram that came, and
//! sends what [`Rov::poll_transmit`] gives. The simulated ROV of the host does exactly the same.

use embedded_hal::pwm::SetDutyCycle;
use protocol::configuration::BatteryLimits;
use protocol::ledger::Class;
use protocol::units::{Amperes, Micros, Volts};

use crate::link::endpoint::Endpoint;
use crate::link::failsafe::BatteryWatch;
use crate::rov::lease::{Output, ThrustLease};
use crate::rov::thruster::bank::Bank;

pub mod lease;
pub mod thruster;

/// What the power sensor shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Supply {
    /// Battery voltage.
    pub battery: Volts,
    /// Battery current.
    pub current: Amperes,
}

/// See the module's documentation.
#[derive(Debug)]
pub struct Rov<P> {
    endpoint: Endpoint<ThrustLease>,
    bank: Bank<P>,
    battery: BatteryWatch,
}

impl<P: SetDutyCycle> Rov<P> {
    /// From its two halves.
    #[must_use]
    pub const fn new(endpoint: Endpoint<ThrustLease>, bank: Bank<P>) -> Self {
        Self { endpoint, bank, battery: BatteryWatch::new(BatteryLimits::ROV) }
    }

    /// With another battery.
    #[must_use]
    pub fn with_battery(self, limits: BatteryLimits) -> Self {
        Self { battery: BatteryWatch::new(limits), ..self }
    }

    /// Puts out the thrusts of `now`, own clock; then whatever the link has to say.
    ///
    /// # Errors
    /// The output that failed; the others and the link go on all the same.
    pub fn tick(&mut self, now: Micros, supply: &Supply) -> Result<(), P::Error> {
        let low = self.battery.update(now, supply.battery);
        self.endpoint.set_low_battery(low);
        let outcome = self.bank.tick(now, self.endpoint.thrusts(now), supply.battery);
        let &Supply { battery, current } = supply;
        let (pulses, armed) = (self.bank.pulses().clone(), self.bank.is_armed());
        let output = Output { pulses, battery, current, armed };
        self.endpoint.handle_timer(now, &output);
        outcome
    }

    /// Follows one datagram that arrived at `now`, own clock.
    ///
    /// # Errors
    /// What it is, if it is not to be followed; nothing happens then.
    pub fn handle_datagram(&mut self, now: Micros, datagram: &[u8]) -> Result<(), Class> {
        self.endpoint.handle_datagram(now, datagram)
    }

    /// The next datagram to send; see [`Endpoint::poll_transmit`].
    pub fn poll_transmit<'a>(&mut self, buffer: &'a mut [u8]) -> Option<&'a [u8]> {
        self.endpoint.poll_transmit(buffer)
    }

    /// Its side of the link.
    #[must_use]
    pub const fn endpoint(&self) -> &Endpoint<ThrustLease> {
        &self.endpoint
    }

    /// Its thrusters.
    #[must_use]
    pub const fn bank(&self) -> &Bank<P> {
        &self.bank
    }
}

#[cfg(test)]
mod tests;
