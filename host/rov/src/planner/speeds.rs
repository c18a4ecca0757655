//! Propulsion of the vehicles of a problem, and speeds that the rules ask for and the thrusters do not give.

use reconfiguration::plan::Manner;
use reconfiguration::problem::{Problem, Rules};

use super::super::power::PowerLaw;
use super::super::propulsion::{Propulsion, Steady};
use super::PlanError;

/// Each vehicle's propulsion, with the first robot that is one; `None` for tools, which do not swim.
pub(crate) fn engines<'a>(
    problem: &'a Problem,
    law: &'a PowerLaw,
    steady: Steady,
) -> impl Iterator<Item = Result<Option<(u16, Propulsion)>, PlanError>> + 'a {
    problem.vehicles.iter().enumerate().map(move |(index, vehicle)| {
        let Some(robot) = problem.robots.iter().find(|robot| robot.vehicle == index) else { return Ok(None) };
        let propulsion = Propulsion::new(vehicle, law.clone(), &problem.rules, steady).map_err(|source| {
            PlanError::Propulsion { robot: robot.id, vehicle: vehicle.name.clone(), source }
        })?;
        Ok(Some((robot.id, propulsion)))
    })
}

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
