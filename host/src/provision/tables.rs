//! The shape of a module's TOML file. A number that is left out is the firmware's own.
//!
//! What each key means is said where its constant stands: `protocol::configuration`.

use serde::{Deserialize, Deserializer, Serialize};
use zeroize::Zeroizing;

/// The file.
#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Tables {
    pub(super) network: NetworkTable,
    pub(super) report: ReportTable,
    pub(super) supply: SupplyTable,
    pub(super) modboat: Option<ModboatTable>,
    pub(super) rov: Option<RovTable>,
}

/// A text that is wiped after use, and never written.
pub(super) struct Secret(pub(super) Zeroizing<String>);

impl<'de> Deserialize<'de> for Secret {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Self(Zeroizing::new(String::deserialize(deserializer)?)))
    }
}

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct NetworkTable {
    pub(super) ssid: Option<String>,
    #[serde(skip_serializing)]
    pub(super) passphrase: Option<Secret>,
    pub(super) passphrase_file: Option<String>,
    pub(super) host: Option<String>,
    pub(super) address: Option<String>,
    pub(super) gateway: Option<String>,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct ReportTable {
    pub(super) every_ms: Option<f64>,
    pub(super) sure_within_ms: Option<f64>,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct SupplyTable {
    pub(super) volts_per_volt: Option<f64>,
    pub(super) amperes_per_volt: Option<f64>,
    pub(super) low_v: Option<f64>,
    pub(super) recover_v: Option<f64>,
    pub(super) hold_off_s: Option<f64>,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct ModboatTable {
    pub(super) limits: LimitsTable,
    pub(super) servo: ServoTable,
    pub(super) encoder: EncoderTable,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct LimitsTable {
    pub(super) amplitude_min_rad: Option<f64>,
    pub(super) amplitude_max_rad: Option<f64>,
    pub(super) centerline_max_rad: Option<f64>,
    pub(super) rotation_max_rad: Option<f64>,
    pub(super) speed_max_rad_s: Option<f64>,
    pub(super) period_min_s: Option<f64>,
    pub(super) period_max_s: Option<f64>,
    pub(super) transition_max_s: Option<f64>,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct ServoTable {
    pub(super) no_load_speed_rad_s: Option<f64>,
    pub(super) time_constant_s: Option<f64>,
    pub(super) position_gain_per_s: Option<f64>,
    pub(super) rate_gain: Option<f64>,
    pub(super) speed_max_rad_s: Option<f64>,
    pub(super) stall_current_a: Option<f64>,
    pub(super) current_max_a: Option<f64>,
    pub(super) following_error_max_rad: Option<f64>,
    pub(super) following_error_time_ms: Option<f64>,
    pub(super) interval_ms: Option<f64>,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct EncoderTable {
    pub(super) counts_per_turn: Option<i64>,
    pub(super) zero_counts: Option<i64>,
    pub(super) reversed: bool,
    pub(super) homing_speed_rad_s: Option<f64>,
    pub(super) homing_after_s: Option<f64>,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RovTable {
    pub(super) thrust_max_n: Option<f64>,
    pub(super) lease_max_s: Option<f64>,
    pub(super) frame_rate_hz: Option<f64>,
    pub(super) arming_s: Option<f64>,
    pub(super) slew_n_s: Option<f64>,
    pub(super) reversal_delay_ms: Option<f64>,
    #[serde(rename = "thruster")]
    pub(super) thrusters: Vec<ThrusterTable>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ThrusterTable {
    pub(super) output: i64,
    #[serde(default)]
    pub(super) reversed: bool,
}
