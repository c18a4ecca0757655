//! Whether the motor of a scenario keeps its tail as near to planned angles as plans rely on.

use std::f64::consts::TAU;

use firmware::link::session::SURE_WITHIN;
use modboat::parameters::Parameters;
use modboat::planner_config::{LawOfTime, PlannerConfig};
use sim::motor::MotorParameters;
use sim::tracking::{Stops, Tracking};

/// What plans rely on: that modules with this motor keep their tails as near to planned angles as `[modboat]` says, with clocks as
/// sure as the firmware wants them. Not asked where transitions go at constant speed, which guarantees nothing.
pub(super) fn tail_is_kept(
    modboat: &Parameters,
    motor: &MotorParameters,
    planner: &PlannerConfig,
) -> Result<(), String> {
    if planner.law() == LawOfTime::ConstantSpeed {
        return Ok(());
    }
    let (asked_s, sure_s) = (modboat.clock_error_s, f64::from(SURE_WITHIN.as_secs_f32()));
    if asked_s < sure_s - 1e-9 {
        return Err(format!(
            "[modboat] clock_error_s = {asked_s} s: modules move while they are sure of the fleet time within {sure_s} s"
        ));
    }
    let asked_rad = modboat.tracking_error_rad;
    let tracking = Tracking::known(motor, modboat)
        .map_or_else(|| Tracking::measure(motor, modboat), Ok)
        .map_err(|error| format!("[motor]: {error}"))?;
    let (phase, kept_rad) = tracking.greatest();
    if kept_rad > asked_rad {
        return Err(format!(
            "[motor]: such a tail strays by up to {kept_rad:.4} rad from its planned angle {phase}; plans rely on [modboat] \
             tracking_error_rad = {asked_rad} rad. A better motor, a lower tail_acceleration_max_rad_s2, or a greater tracking_error_rad"
        ));
    }
    let Stops { past_swing_rad, past_turn_rad } = tracking.stops;
    for (key, motion, stops_rad, asked_rad) in [
        ("stop_past_swing_rad", "swing", past_swing_rad, modboat.stop_past_swing_rad),
        ("stop_past_turn_rad", "transition", past_turn_rad, modboat.stop_past_turn_rad),
    ] {
        // Beyond a whole turn it is anywhere.
        if stops_rad.min(TAU) > asked_rad {
            return Err(format!(
                "[motor]: without power such a tail comes to rest up to {stops_rad:.4} rad beyond the end of a {motion}; plans rely on \
                 [modboat] {key} = {asked_rad} rad. 7 says that it may stop anywhere"
            ));
        }
    }
    Ok(())
}
