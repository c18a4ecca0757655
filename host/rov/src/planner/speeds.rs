//! Speeds that the rules ask for and the thrusters do not give.

use reconfiguration::plan::Manner;
use reconfiguration::problem::Rules;

use super::super::propulsion::Propulsion;

/// A speed of the rules beyond the thrust that there is.
pub(super) struct Beyond {
    /// Key of the rule.
    pub(super) key: &'static str,
    /// What it asks for, in `unit`.
    pub(super) asked: f64,
    /// m/s or rad/s.
    pub(super) unit: &'static str,
    /// What can be reached.
    pub(super) attainable: f64,
}

/// The first rule that asks for too much, ahead or turning.
pub(super) fn beyond_thrust(propulsion: &Propulsion, rules: &Rules, manner: Manner) -> Option<Beyond> {
    let (speed, rate) = match manner {
        Manner::Paper => (("speed_m_s", rules.speed_m_s), ("yaw_rate_rad_s", rules.yaw_rate_rad_s)),
        Manner::Best => (("speeds_m_s", rules.speeds_m_s[0]), ("yaw_rates_rad_s", rules.yaw_rates_rad_s[0])),
    };
    [(speed, 0, "m/s"), (rate, 5, "rad/s")].into_iter().find_map(|((key, asked), axis, unit)| {
        let can = |speed: f64| {
            let nu = std::array::from_fn(|k| if k == axis { speed } else { 0.0 });
            propulsion.power_w(&nu, &[0.0; 6]).is_some()
        };
        if can(asked) {
            return None;
        }
        let (mut low, mut high) = (0.0, asked);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if can(middle) { low = middle } else { high = middle }
        }
        Some(Beyond { key, asked, unit, attainable: low })
    })
}
