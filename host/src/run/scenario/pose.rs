//! `[pose]`: how the world lies in the laboratory of a motion capture, and what is done without poses.

use pose::axes::{Axes, Unit, Up};
use quantity::{ParameterError, check_within};
use serde::{Deserialize, Serialize};

/// See the module's documentation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PoseParameters {
    /// Where poses come from, with modules on UDP, as for `--pose`; the simulated water if it is not given.
    pub source: Option<String>,
    /// The laboratory's axis that points up. Never guessed: needed with a motion capture.
    pub up: Option<UpAxis>,
    /// The laboratory's unit; that of the protocol if it is not given.
    pub unit: Option<LengthUnit>,
    /// The world's origin in the laboratory's axes, m.
    pub origin_m: [f64; 3],
    /// Heading of the world's x axis in the laboratory, counter-clockwise seen from above, rad.
    pub heading_rad: f64,
    /// No cycle starts with a pose older than this, s (where the lead is more than half of it: no cycle is decided on with a pose older
    /// than half of it): the fleet finishes its cycle and holds until poses come again. *Assumed*: at 0.04 m/s a structure moves by a
    /// quarter of a module in it.
    pub hold_after_s: f64,
}

/// An axis that points up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum UpAxis {
    /// QTM, Vicon, and Motive where it is set so
    Z,
    /// Motive's standard
    Y,
}

/// A unit of lengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum LengthUnit {
    /// Metres
    M,
    /// Millimetres
    Mm,
}

impl Default for PoseParameters {
    fn default() -> Self {
        Self { source: None, up: None, unit: None, origin_m: [0.0; 3], heading_rad: 0.0, hold_after_s: 1.0 }
    }
}

impl PoseParameters {
    /// Refuses what cannot work, by the first offending key.
    pub(in super::super) fn validate(&self) -> Result<(), ParameterError> {
        let reason = "must lie between 0.1 and 60";
        let [x, y, z] = self.origin_m.map(|value| ("origin_m", value, "m", -1e6..=1e6, "is out of range"));
        check_within(&[
            x,
            y,
            z,
            ("heading_rad", self.heading_rad, "rad", -1e3..=1e3, "is out of range"),
            ("hold_after_s", self.hold_after_s, "s", 0.1..=60.0, reason),
        ])
    }

    /// How the world lies in the laboratory of a motion capture that measures in `standard` where nothing else is said; `None` where
    /// the axis that points up is not known.
    #[must_use]
    pub fn axes(&self, standard: Unit) -> Option<Axes> {
        let up = match self.up? {
            UpAxis::Z => Up::Z,
            UpAxis::Y => Up::Y,
        };
        let unit = match self.unit {
            Some(LengthUnit::M) => Unit::Metre,
            Some(LengthUnit::Mm) => Unit::Millimetre,
            None => standard,
        };
        Some(Axes { up, unit, origin_m: self.origin_m.into(), heading_rad: self.heading_rad })
    }
}
