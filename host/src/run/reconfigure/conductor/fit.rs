//! Whether a plan is one of this problem, and can be followed.

use quantity::wrap_rad;
use reconfiguration::plan::{ActionKind, Move, Plan};
use reconfiguration::pose::Pose;
use reconfiguration::problem::Problem;

use super::super::ExecutionError;
use super::HAND_OVER_S;

/// Whether the plan's moves can be followed.
pub(super) fn check(problem: &Problem, plan: &Plan) -> Result<(), ExecutionError> {
    let refuse =
        |number: usize, what: String| Err(ExecutionError::Misfit(format!("move {}: {what}", number + 1)));
    for (number, own @ Move { robot, slot, to, actions, .. }) in plan.moves.iter().enumerate() {
        let Some(mover) = problem.robots.iter().find(|known| known.id == *robot) else {
            return refuse(number, format!("there is no robot {robot}"));
        };
        let end = match (slot, to) {
            (Some(slot), None) => problem.slots.get(*slot).map(|slot| slot.pose),
            (None, to) => *to,
            _ => None,
        };
        let Some(end) = end else {
            return refuse(number, format!("there is no {}", own.destination()));
        };
        let before = plan.moves[..number].iter().rfind(|earlier| earlier.robot == *robot);
        if before.is_some_and(|before| before.slot.is_some()) {
            return refuse(number, format!("robot {robot} has moved before"));
        }
        let (Some(first), Some(last)) = (actions.first(), actions.last()) else {
            return refuse(number, "no actions".to_owned());
        };
        if first.kind != ActionKind::Undock || last.kind != ActionKind::Dock {
            return refuse(number, "it does not begin with undocking and end with docking".to_owned());
        }
        // One after the other that is added to what was planned; others under way would be ahead of their time.
        if plan.is_parallel() && first.duration_s < HAND_OVER_S - 1e-9 {
            let what = format!("undocking takes {} s, handing over {HAND_OVER_S} s", first.duration_s);
            return refuse(number, what);
        }
        let mut at = before.and_then(|before| before.to).unwrap_or(mover.start);
        for (index, action) in actions.iter().enumerate() {
            if !same(&at, &action.from) {
                let from: [f64; 4] = action.from.into();
                return refuse(number, format!("action {} begins elsewhere, at {from:?}", index + 1));
            }
            at = action.to;
        }
        if !same(&at, &end) {
            let at: [f64; 4] = at.into();
            return refuse(number, format!("it ends at {at:?} and not in {}", own.destination()));
        }
    }
    Ok(())
}

/// Poses that a file's rounding may have moved apart.
fn same(a: &Pose, b: &Pose) -> bool {
    const NEAR: f64 = 1e-3;
    let apart = (0..3).map(|k| (a.position_m[k] - b.position_m[k]).abs()).fold(0.0, f64::max);
    apart <= NEAR && wrap_rad(a.yaw_rad - b.yaw_rad).abs() <= NEAR
}
