//! A simulated ROV: the firmware crate, compiled for the PC, on simulated speed controllers and propellers.
//!
//! ```text
//! radio → firmware::rov::Rov → pins: pulses → Propellers: thrusts → Basin: the water
//! ```
//!
//! The in-process run and `flotilla module --rov` use the same code. [`remote`] is the host's side of the latter.
//!
//! Assumptions and limits: the battery's voltage is constant. The firmware's settings (frame rate, arming, slew) are its
//! defaults, and thruster k is on output k.

pub mod basin;
pub mod propellers;
pub mod remote;

use std::cell::Cell;
use std::convert::Infallible;
use std::rc::Rc;

use embedded_hal::pwm::{ErrorType, SetDutyCycle};
use firmware::link::endpoint::Endpoint;
use firmware::link::session::Identity;
use firmware::module::Supply;
use firmware::rov::Rov;
use firmware::rov::lease::{SURE_WITHIN, ThrustLease};
use firmware::rov::thruster::bank::{Bank, BankError};
use firmware::rov::thruster::t200::{VOLTAGE_MAX_V, VOLTAGE_MIN_V};
use protocol::configuration::{BankConstants, LeaseLimits, ThrusterMounting};
use protocol::time::{Duration, FleetInstant};
use protocol::units::{Amperes, PulseMicros, Volts};
use protocol::{Connectors, Radio};
use quantity::ParameterError;
use thiserror::Error;

use self::propellers::Propellers;
use super::node::{Hardware, Simulated};

/// Counts of the pins' timer in one frame: 25 a microsecond at 400 Hz.
const MAX_DUTY: u16 = 62_500;

/// Errors of an ROV's setup.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum RovError {
    /// The firmware cannot drive such thrusters.
    #[error("thrusters: {0}")]
    Bank(#[from] BankError),
    /// No such battery.
    #[error("{0}")]
    Parameter(#[from] ParameterError),
}

/// A pin to a speed controller; no pulses at duty zero.
#[derive(Clone, Debug, Default)]
pub struct EscPin(Rc<Cell<u16>>);

impl ErrorType for EscPin {
    type Error = Infallible;
}

impl SetDutyCycle for EscPin {
    fn max_duty_cycle(&self) -> u16 {
        MAX_DUTY
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        self.0.set(duty);
        Ok(())
    }
}

/// One ROV at one end of a radio.
pub type SimRov<R> = Simulated<Thrusters, R>;

/// What one ROV does to the water, and what its controllers are told.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RovActuation {
    /// Thrusts along each thruster's axis as the water feels them, N.
    pub thrusts_n: Vec<f64>,
    /// Pulses of the controllers, µs.
    pub pulses_us: Vec<f64>,
}

impl RovActuation {
    fn write(&mut self, propellers: &Propellers, pulses: impl Iterator<Item = PulseMicros>) {
        self.thrusts_n.clear();
        self.thrusts_n.extend_from_slice(propellers.thrusts_n());
        self.pulses_us.clear();
        self.pulses_us.extend(pulses.map(|pulse| f64::from(pulse.0)));
    }
}

impl AsRef<[f64]> for RovActuation {
    fn as_ref(&self) -> &[f64] {
        &self.thrusts_n
    }
}

/// What an ROV is made of.
pub struct Thrusters {
    reversed: Vec<bool>,
    battery: Volts,
    pins: Vec<EscPin>,
    propellers: Propellers,
    ticked: Option<FleetInstant>,
}

impl<R: Radio> SimRov<R> {
    /// Thrusts along each thruster's axis as the water feels them, N.
    pub fn thrusts_n(&self) -> &[f64] {
        self.hardware.propellers.thrusts_n()
    }

    /// Pulses at the pins, µs. Without power there are none: the controllers stop, as at 1500.
    pub fn pulses_us(&self) -> Vec<f64> {
        self.hardware.pulses().map(|pulse| f64::from(pulse.0)).collect()
    }

    /// Whether its docking connectors are open at `now`, true time. Without power they are closed.
    pub fn is_open(&self, now: FleetInstant) -> bool {
        self.firmware(now).is_some_and(|(rov, local)| rov.connectors(local) == Connectors::Open)
    }

    /// Breaks a thruster for good.
    pub fn set_failed(&mut self, index: usize) {
        self.hardware.propellers.set_failed(index);
    }
}

impl Thrusters {
    /// One flag a thruster: whether its pulse is mirrored at neutral; and the battery's voltage, V.
    ///
    /// # Errors
    /// [`RovError`] for a battery outside the measured table.
    pub fn new(reversed: &[bool], battery_v: f64) -> Result<Self, RovError> {
        let (least_v, greatest_v) = (f64::from(VOLTAGE_MIN_V), f64::from(VOLTAGE_MAX_V));
        if !(least_v..=greatest_v).contains(&battery_v) {
            let reason = "must lie between 10 and 20, where thrusters were measured";
            return Err(ParameterError { key: "battery_v", value: battery_v, unit: "V", reason }.into());
        }
        Ok(Self {
            reversed: reversed.to_vec(),
            battery: Volts(battery_v as f32),
            pins: reversed.iter().map(|_| EscPin::default()).collect(),
            propellers: Propellers::new(reversed),
            ticked: None,
        })
    }

    fn pulses(&self) -> impl Iterator<Item = PulseMicros> {
        self.pins.iter().map(EscPin::pulse)
    }
}

impl Hardware for Thrusters {
    type Firmware = Rov<EscPin>;
    type Actuation = RovActuation;
    type Error = RovError;
    const SURE_WITHIN: Duration = SURE_WITHIN;

    fn boot(&self, identity: Identity) -> Result<Self::Firmware, RovError> {
        let wired = self.reversed.iter().enumerate();
        // A number that does not fit is too many thrusters anyway.
        let mounted =
            |(k, &reversed)| ThrusterMounting { output: u8::try_from(k).unwrap_or(u8::MAX), reversed };
        let mountings: Vec<ThrusterMounting> = wired.map(mounted).collect();
        let bank = Bank::new(self.pins.iter().cloned(), &mountings, BankConstants::default())?;
        let lease = ThrustLease::new(mountings.len(), LeaseLimits::default());
        Ok(Rov::new(Endpoint::new(Some(identity), lease), bank))
    }

    /// The propellers until now, then the firmware.
    fn tick<T>(&mut self, now: FleetInstant, run: impl FnOnce(&Self, &Supply) -> T) -> T {
        self.propellers.set_pulses(self.pins.iter().map(EscPin::pulse));
        let elapsed = now.since(self.ticked.replace(now).unwrap_or(now));
        self.propellers.step(f64::from(elapsed.0) * 1e-6, self.battery);
        let current = Amperes(self.propellers.current_a(self.battery) as f32);
        run(self, &Supply { battery: self.battery, current })
    }

    fn power_off(&mut self) {
        for pin in &self.pins {
            pin.0.set(0);
        }
    }

    fn actuate(&self, actuation: &mut RovActuation) {
        actuation.write(&self.propellers, self.pulses());
    }
}

impl EscPin {
    /// What its controller reads.
    fn pulse(&self) -> PulseMicros {
        match self.0.get() {
            0 => firmware::rov::thruster::law::NEUTRAL,
            // p = d/(f·D)
            duty => PulseMicros(
                f32::from(duty) * 1e6 / (BankConstants::default().frame_rate_hz * f32::from(MAX_DUTY)),
            ),
        }
    }
}

#[cfg(test)]
mod tests;
