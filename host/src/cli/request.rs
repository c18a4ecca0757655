//! A request of `flotilla plan`: one line of JSON.

use modboat::motion::Wrench;
use serde::Deserialize;

use super::filter;

/// Greatest force (N) and torque (N·m) that is taken for a demand.
const DEMAND_MAX: f64 = 1e6;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Request {
    pub(super) cells: Vec<[i32; 2]>,
    pub(super) demand: Wrench,
    #[serde(default)]
    pub(super) tail_rad: Tails,
}

impl Request {
    /// From a line, with a demand that can be computed with.
    pub(super) fn read(line: &str) -> Result<Self, String> {
        let request: Self = filter::read(line)?;
        let Wrench { fx_n, fy_n, tau_nm } = request.demand;
        for (key, value, unit) in [("fx_n", fx_n, "N"), ("fy_n", fy_n, "N"), ("tau_nm", tau_nm, "N·m")] {
            if !value.is_finite() || value.abs() > DEMAND_MAX {
                return Err(format!(
                    "demand.{key} = {value:e} {unit}: must be at most {DEMAND_MAX:e} in size"
                ));
            }
        }
        Ok(request)
    }
}

#[derive(Default, Deserialize)]
#[serde(untagged, expecting = "must be a list of angles, null or \"previous\"")]
pub(super) enum Tails {
    #[default]
    Unknown,
    Angles(Vec<f64>),
    Word(Previous),
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Previous {
    Previous,
}
