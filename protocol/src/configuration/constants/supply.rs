//! The constants of a module's supply: what the board's inputs show, and when the battery is low.

use serde::{Deserialize, Serialize};

use super::finite;
use crate::configuration::ConfigurationError;
use crate::time::Duration;
use crate::units::Volts;

/// What the board measures of its supply.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SupplyConstants {
    /// Battery voltage for one volt at the board's input, V/V: the divider's ratio; 0: nothing is wired there.
    pub volts_per_volt: f32,
    /// Current for one volt at the board's input, A/V: of the motor, or of an ROV's battery; 0: nothing is wired there.
    pub amperes_per_volt: f32,
    /// When the battery is low.
    pub battery: BatteryLimits,
}

/// When a battery is low: `firmware::link::failsafe::battery`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BatteryLimits {
    /// U_low: the battery is low below this.
    pub low: Volts,
    /// U_recover: and no longer from this on. Taken for U_low where it is less.
    pub recover: Volts,
    /// How long the voltage must have crossed.
    pub hold_off: Duration,
}

impl BatteryLimits {
    /// Two lithium cells. *Assumed.*
    pub const MODBOAT: Self = Self { low: Volts(6.4), recover: Volts(6.8), hold_off: Duration(2_000_000) };

    /// Four lithium cells, under more load. *Assumed.*
    pub const ROV: Self = Self { low: Volts(13.2), recover: Volts(13.6), hold_off: Duration(2_000_000) };
}

impl SupplyConstants {
    pub(in crate::configuration) fn check(&self) -> Result<(), ConfigurationError> {
        finite(&[
            ("supply.volts_per_volt", self.volts_per_volt, "V/V"),
            ("supply.amperes_per_volt", self.amperes_per_volt, "A/V"),
            ("supply.low", self.battery.low.0, "V"),
            ("supply.recover", self.battery.recover.0, "V"),
        ])
    }
}
