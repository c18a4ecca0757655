//! The constants of a module's hardware, as the configuration holds them and as the firmware takes them.
//!
//! Each set is one struct: what the image stores is what the firmware reads, field by field. A `Default` or a constant beside
//! it is what a module has where its file says nothing else.

use serde::{Deserialize, Serialize};

use super::ConfigurationError;

mod modboat;
mod rov;
mod supply;

pub use modboat::{EncoderConstants, EncoderMounting, ServoConstants, TailConstants, TailLimits};
pub use rov::{BankConstants, EscConstants, LeaseLimits, RovConstants, ThrusterMounting};
pub use supply::{BatteryLimits, SupplyConstants};

/// The kind of robot, with the constants of its hardware.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Robot {
    /// One motor, one tail.
    Modboat(TailConstants),
    /// Thrusters.
    Rov(RovConstants),
}

impl Robot {
    pub(super) fn check(&self) -> Result<(), ConfigurationError> {
        match self {
            Self::Modboat(tail) => tail.check(),
            Self::Rov(rov) => rov.check(),
        }
    }
}

/// Refuses the first that is not a finite number: key, value, unit.
fn finite(constants: &[(&'static str, f32, &'static str)]) -> Result<(), ConfigurationError> {
    let wrong = constants.iter().find(|(_, value, _)| !value.is_finite());
    wrong.map_or(Ok(()), |&(key, value, unit)| Err(ConfigurationError::Constant { key, value, unit }))
}
