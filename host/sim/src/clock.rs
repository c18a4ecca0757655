//! The clock of a simulated module.

use quantity::{ParameterError, Range, check_ranges};
use serde::{Deserialize, Serialize};

/// How wrong the modules' own clocks are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ClockParameters {
    /// Each clock starts anywhere between zero and this, s.
    pub offset_s: f64,
    /// Each clock runs fast or slow by at most this, 10⁻⁶. *Assumed*: an ordinary quartz.
    pub drift_ppm: f64,
}

impl Default for ClockParameters {
    fn default() -> Self {
        Self { offset_s: 100.0, drift_ppm: 30.0 }
    }
}

impl ClockParameters {
    /// Refuses what no clock does, by the first offending key.
    ///
    /// # Errors
    /// [`ParameterError`].
    pub fn validate(&self) -> Result<(), ParameterError> {
        check_ranges(&[
            ("offset_s", self.offset_s, "s", Range::NonNegative),
            ("drift_ppm", self.drift_ppm, "ppm", Range::NonNegative),
        ])?;
        if self.drift_ppm > 10_000.0 {
            let reason = "must be at most 10000";
            return Err(ParameterError { key: "drift_ppm", value: self.drift_ppm, unit: "ppm", reason });
        }
        Ok(())
    }
}
