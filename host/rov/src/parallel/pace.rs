//! The same way at another speed: every leg and turn at its least E + ωT, ω what a second is worth to the robot.

use quantity::wrap_rad;
use reconfiguration::plan::{Action, ActionKind, Move};
use reconfiguration::problem::Rules;

use super::super::docking::HAND_OVER_S;
use super::super::propulsion::Propulsion;
use super::super::vector::{length, offset, turned};

/// The move from time 0 on, with the time it takes to hand over; with `omega_w` its legs and turns at another speed.
/// `None` where they cannot be swum.
pub(super) fn paced(own: &Move, rules: &Rules, at: Option<(&Propulsion, f64)>) -> Option<Move> {
    let mut now_s = 0.0;
    let mut actions = Vec::with_capacity(own.actions.len());
    for action in &own.actions {
        let mut action = Action { start_s: now_s, ..action.clone() };
        if action.kind == ActionKind::Undock {
            action.duration_s = action.duration_s.max(HAND_OVER_S);
        }
        if let Some((propulsion, omega_w)) = at {
            repace(&mut action, rules, propulsion, omega_w)?;
        }
        now_s += action.duration_s;
        actions.push(action);
    }
    let energy_navigate_j = actions.iter().map(|action| action.energy_j).sum();
    let path = own.path.clone();
    Some(Move {
        path,
        start_s: 0.0,
        duration_s: now_s,
        energy_navigate_j,
        energy_balance_j: 0.0,
        balance_w: 0.0,
        balance: Vec::new(),
        actions,
        ..*own
    })
}

fn repace(action: &mut Action, rules: &Rules, propulsion: &Propulsion, omega_w: f64) -> Option<()> {
    let expense = match action.kind {
        ActionKind::Undock | ActionKind::Dock => return Some(()),
        ActionKind::Leg => {
            let way_m = offset(action.from.position_m, action.to.position_m);
            let size_m = length(way_m);
            if size_m == 0.0 {
                return Some(());
            }
            let direction = turned(way_m, -action.from.yaw_rad).map(|component| component / size_m);
            propulsion.best_leg(direction, size_m, rules.speeds_m_s, rules.acceleration_m_s2, omega_w)?
        }
        ActionKind::Turn => {
            let angle_rad = wrap_rad(action.to.yaw_rad - action.from.yaw_rad);
            let (rates, most) = (rules.yaw_rates_rad_s, rules.yaw_acceleration_rad_s2);
            propulsion.best_turn(angle_rad, rates, most, omega_w)?
        }
    };
    action.duration_s = expense.duration_s;
    (action.speed, action.acceleration, action.energy_j) =
        (expense.speed, expense.acceleration, expense.energy_j);
    Some(())
}
