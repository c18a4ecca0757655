//! `[pose]`: where poses come from, and what is done without them.

use quantity::{ParameterError, check_within};
use serde::{Deserialize, Serialize};

/// See the module's documentation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PoseParameters {
    /// No cycle starts with a pose older than this, s: the fleet finishes its cycle and holds until poses come again. *Assumed*: at
    /// 0.04 m/s a structure moves by a quarter of a module in it.
    pub hold_after_s: f64,
}

impl Default for PoseParameters {
    fn default() -> Self {
        Self { hold_after_s: 1.0 }
    }
}

impl PoseParameters {
    /// Refuses what cannot work, by the first offending key.
    pub(super) fn validate(&self) -> Result<(), ParameterError> {
        let reason = "must lie between 0.35 and 60: a cycle is decided on 0.3 s before it starts";
        check_within(&[("hold_after_s", self.hold_after_s, "s", 0.35..=60.0, reason)])
    }
}
