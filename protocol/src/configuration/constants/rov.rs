//! The constants of an ROV: its thrusters, their wiring, and what they may be asked.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use super::finite;
use crate::configuration::ConfigurationError;
use crate::message::MAX_THRUSTERS;
use crate::time::Duration;
use crate::units::Newtons;

/// Thrusters: `firmware::rov`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RovConstants {
    /// Each thruster's wiring, in the order of a cycle's thrusts.
    pub thrusters: Vec<ThrusterMounting, MAX_THRUSTERS>,
    /// What they may be asked.
    pub limits: LeaseLimits,
    /// How their pins are driven.
    pub bank: BankConstants,
}

/// Where one thruster is wired, and which way round.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ThrusterMounting {
    /// Which pin, in the order in which the board gives them.
    pub output: u8,
    /// Its wires are swapped or its propeller is the mirror image: thrust ahead needs a pulse below neutral.
    pub reversed: bool,
}

/// Bounds on one cycle: `firmware::rov::lease`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeaseLimits {
    /// Greatest |thrust|.
    pub thrust_max: Newtons,
    /// Longest lease.
    pub lease_max: Duration,
}

impl Default for LeaseLimits {
    /// No thrust that a T200 never gives (66 N ahead at 20 V), and a lease of one second, *assumed*: a vehicle of a metre a
    /// second that hears nothing any more goes on for no more than its own length or two.
    fn default() -> Self {
        Self { thrust_max: Newtons(66.0), lease_max: Duration(1_000_000) }
    }
}

/// How the pins of all thrusters are driven: `firmware::rov::thruster::bank`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BankConstants {
    /// Frames a second at every pin, Hz.
    pub frame_rate_hz: f32,
    /// Time in neutral after boot.
    pub arming: Duration,
    /// What each controller may be asked.
    pub esc: EscConstants,
}

impl Default for BankConstants {
    /// *Assumed*: Blue Robotics asks for a stop signal of a few seconds before a Basic ESC obeys.
    fn default() -> Self {
        Self { frame_rate_hz: 400.0, arming: Duration(3_000_000), esc: EscConstants::default() }
    }
}

/// How gently a speed controller is to be treated: `firmware::rov::thruster::esc`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EscConstants {
    /// Fastest growth of thrust, N/s.
    pub slew_n_s: f32,
    /// Rest at neutral before the thrust changes sign.
    pub reversal_delay: Duration,
}

impl Default for EscConstants {
    /// *Assumed*: full thrust at 16 V in a quarter of a second, and 20 ms for the propeller to come to rest.
    fn default() -> Self {
        Self { slew_n_s: 200.0, reversal_delay: Duration(20_000) }
    }
}

impl RovConstants {
    pub(super) fn check(&self) -> Result<(), ConfigurationError> {
        finite(&[
            ("thrust_max", self.limits.thrust_max.0, "N"),
            ("frame_rate_hz", self.bank.frame_rate_hz, "Hz"),
            ("slew_n_s", self.bank.esc.slew_n_s, "N/s"),
        ])
    }
}
