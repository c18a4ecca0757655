//! Checks of single actions: where they begin and end, and how long a robot takes from rest to rest.
//!
//! ```text
//! T = L/v + v/a    if v² ≤ a·L: up to v, along, and down again
//! T = 2·√(L/a)     otherwise: half way up, half way down
//! T = L/v          at constant speed, no acceleration given
//! ```
//!
//! L is the length of a leg or the angle of a turn.

use reconfiguration::plan::{Action, ActionKind, Manner, Move};
use reconfiguration::pose::Pose;

use super::{Condition, Judge, SAME, distance_m, end_of, same, show, turn_rad};

/// Durations may be off by this share, and by a microsecond.
const SHARE: f64 = 1e-6;

/// How far an action goes: m for a leg, rad for a turn.
pub(super) fn length(action: &Action) -> f64 {
    match action.kind {
        ActionKind::Leg => distance_m(action.from.position_m, action.to.position_m),
        ActionKind::Turn => turn_rad(action.from.yaw_rad, action.to.yaw_rad).abs(),
        ActionKind::Undock | ActionKind::Dock => 0.0,
    }
}

/// From rest to rest.
fn duration_s(length: f64, speed: f64, acceleration: Option<f64>) -> f64 {
    match acceleration {
        _ if length <= 0.0 => 0.0,
        None => length / speed,
        Some(a) if speed * speed <= a * length => length / speed + speed / a,
        Some(a) => 2.0 * (length / a).sqrt(),
    }
}

/// Greatest speed that is reached.
pub(super) fn peak(action: &Action) -> f64 {
    action.acceleration.map_or(action.speed, |a| action.speed.min((a * length(action)).sqrt()))
}

/// Where a robot is `t_s` after an action began.
pub(super) fn pose_at(action: &Action, t_s: f64) -> Pose {
    let length = length(action);
    let peak = peak(action);
    let total_s = duration_s(length, action.speed, action.acceleration);
    let done = match action.acceleration {
        _ if length <= 0.0 || t_s >= total_s => 1.0,
        None => peak * t_s / length,
        Some(a) => {
            let ramp_s = peak / a;
            let way = if t_s < ramp_s {
                a * t_s * t_s / 2.0
            } else if t_s <= total_s - ramp_s {
                peak * (t_s - ramp_s / 2.0)
            } else {
                length - a * (total_s - t_s).powi(2) / 2.0
            };
            way / length
        }
    };
    let (from, to) = (action.from, action.to);
    let position_m =
        std::array::from_fn(|k| from.position_m[k] + done * (to.position_m[k] - from.position_m[k]));
    Pose { position_m, yaw_rad: from.yaw_rad + done * turn_rad(from.yaw_rad, to.yaw_rad) }
}

/// Looks at the actions of one move, of a robot that is at `before`.
pub(super) fn check(judge: &mut Judge<'_>, index: usize, own: &Move, before: Pose) {
    let mut wrong: Vec<(f64, Condition, String)> = Vec::new();
    let (Some(first), Some(last)) = (own.actions.first(), own.actions.last()) else {
        judge.add(Some(index), own.start_s, Condition::Continuity, "a move without actions".to_owned());
        return;
    };
    if !same(first.from, before) {
        let message = format!("robot {} is at {}, not at {}", own.robot, show(before), show(first.from));
        wrong.push((first.start_s, Condition::V1, message));
    }
    if let Some(end) = end_of(judge.problem, own).filter(|end| !same(*end, last.to)) {
        let place = own.slot.map_or("its parking place".to_owned(), |slot| format!("slot {}", slot + 1));
        let message = format!("robot {} ends at {}, {place} is at {}", own.robot, show(last.to), show(end));
        wrong.push((last.start_s, Condition::V1, message));
    }
    for pair in own.actions.windows(2).filter(|pair| !same(pair[0].to, pair[1].from)) {
        let message = format!("jumps from {} to {}", show(pair[0].to), show(pair[1].from));
        wrong.push((pair[1].start_s, Condition::Continuity, message));
    }
    let ends =
        own.actions.iter().filter(|action| action.kind == ActionKind::Leg).map(|leg| leg.to.position_m);
    let legs: Vec<[f64; 3]> = std::iter::once(first.from.position_m).chain(ends).collect();
    let (legs, path) = (corners(&legs), corners(&own.path));
    if legs.len() != path.len() || legs.iter().zip(&path).any(|(a, b)| distance_m(*a, *b) > SAME) {
        let message = format!("the path {path:.3?} m is not that of its legs, {legs:.3?} m");
        wrong.push((own.start_s, Condition::Continuity, message));
    }
    docking(judge, own, &mut wrong);
    for action in &own.actions {
        if let Some(message) = unlike(action).or_else(|| against_rules(judge, action)) {
            wrong.push((action.start_s, Condition::Kinematics, message));
        }
    }
    for (time_s, condition, message) in wrong {
        judge.add(Some(index), time_s, condition, message);
    }
}

/// Undocking comes first and docking last, and they take what the rules say, undocking at its best that at least.
fn docking(judge: &Judge<'_>, own: &Move, wrong: &mut Vec<(f64, Condition, String)>) {
    let rules = &judge.problem.rules;
    for (kind, place, takes_s) in
        [(ActionKind::Undock, 0, rules.undock_s), (ActionKind::Dock, own.actions.len() - 1, rules.dock_s)]
    {
        let all = own.actions.iter().enumerate().filter(|(_, action)| action.kind == kind);
        let mut took_s = 0.0;
        for (at, action) in all {
            took_s += action.duration_s;
            if at != place {
                let message = format!("{kind:?} is action {} of {}", at + 1, own.actions.len());
                wrong.push((action.start_s, Condition::V5, message));
            }
        }
        // A robot that hands over its balance first takes its time for that.
        let longer = judge.plan.manner == Manner::Best && kind == ActionKind::Undock && took_s > takes_s;
        if (took_s - takes_s).abs() > SAME && !longer {
            let message = format!("{kind:?} takes {took_s} s, by the rules {takes_s} s");
            wrong.push((own.start_s, Condition::Kinematics, message));
        }
    }
}

/// What of an action does not fit the rest of it.
fn unlike(action: &Action) -> Option<String> {
    let Action { kind, from, to, speed, acceleration, .. } = action;
    let (moved_m, turned_rad) =
        (distance_m(from.position_m, to.position_m), turn_rad(from.yaw_rad, to.yaw_rad).abs());
    let (may_move, may_turn) = (*kind == ActionKind::Leg, *kind == ActionKind::Turn);
    if !may_move && moved_m > SAME {
        return Some(format!("{kind:?} moves by {moved_m:.6} m"));
    }
    if !may_turn && turned_rad > SAME {
        return Some(format!("{kind:?} turns by {turned_rad:.6} rad"));
    }
    let length = length(action);
    if length > 0.0 && (*speed <= 0.0 || acceleration.is_some_and(|a| a <= 0.0)) {
        return Some(format!("{kind:?} over {length:.3} at speed {speed}, acceleration {acceleration:?}"));
    }
    let takes_s = duration_s(length, *speed, *acceleration);
    let fixed = matches!(kind, ActionKind::Undock | ActionKind::Dock);
    let off_s = (action.duration_s - takes_s).abs();
    (!fixed && off_s > SHARE * takes_s + SAME).then(|| {
        let took_s = action.duration_s;
        format!("{kind:?} over {length:.6} takes {took_s:.6} s; at speed {speed} it takes {takes_s:.6} s")
    })
}

/// What of an action is faster than the rules allow.
fn against_rules(judge: &Judge<'_>, action: &Action) -> Option<String> {
    let rules = &judge.problem.rules;
    let ([paper, best], acceleration_limit, unit) = match action.kind {
        ActionKind::Leg => ([rules.speed_m_s, rules.speeds_m_s[1]], rules.acceleration_m_s2, "m/s"),
        ActionKind::Turn => {
            ([rules.yaw_rate_rad_s, rules.yaw_rates_rad_s[1]], rules.yaw_acceleration_rad_s2, "rad/s")
        }
        ActionKind::Undock | ActionKind::Dock => return None,
    };
    let kind = action.kind;
    let speed_limit = if judge.plan.manner == Manner::Paper { paper } else { best };
    match (judge.plan.manner, action.acceleration) {
        _ if action.speed > speed_limit * (1.0 + SHARE) => {
            Some(format!("{kind:?} at {} {unit}, by the rules {speed_limit} {unit} at most", action.speed))
        }
        (_, Some(a)) if a > acceleration_limit * (1.0 + SHARE) => {
            Some(format!("{kind:?} at {a} {unit}², by the rules {acceleration_limit} {unit}² at most"))
        }
        (Manner::Best, None) if length(action) > SAME => {
            Some(format!("{kind:?} at {} {unit} from the first instant: no acceleration", action.speed))
        }
        _ => None,
    }
}

/// A path without the corners that lie on the straight line between their neighbours.
fn corners(path: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut kept: Vec<[f64; 3]> = Vec::new();
    for &next in path {
        if kept.last().is_some_and(|last| distance_m(*last, next) <= SAME) {
            continue;
        }
        if let [.., before, last] = kept[..]
            && distance_m(before, last) + distance_m(last, next) - distance_m(before, next) <= 1e-12
        {
            kept.pop();
        }
        kept.push(next);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    fn leg(length_m: f64, speed: f64, acceleration: Option<f64>) -> Action {
        Action {
            kind: ActionKind::Leg,
            start_s: 0.0,
            duration_s: duration_s(length_m, speed, acceleration),
            from: Pose::default(),
            to: [length_m, 0.0, 0.0, 0.0].into(),
            speed,
            acceleration,
            energy_j: 0.0,
        }
    }

    /// Speed integrated in small steps must arrive where and when the closed form says.
    #[test]
    fn profiles_agree_with_integrated_speed() {
        for (length_m, speed, a) in [(1.0, 0.3, 0.2), (0.1, 0.3, 0.2), (0.45, 0.3, 0.2), (5.0, 1.0, 0.5)] {
            let leg = leg(length_m, speed, Some(a));
            let (mut x, mut v, step_s) = (0.0, 0.0_f64, 1e-5);
            let mut t_s = 0.0;
            while t_s < leg.duration_s {
                // Brake when the way that is left is that of braking.
                v = if length_m - x <= v * v / (2.0 * a) {
                    v - a * step_s
                } else {
                    (v + a * step_s).min(speed)
                };
                x += v.max(0.0) * step_s;
                t_s += step_s;
                let closed = pose_at(&leg, t_s).position_m[0];
                assert!((closed - x).abs() < 2e-4, "{length_m} m at {t_s} s: {closed} against {x}");
            }
            assert!((x - length_m).abs() < 2e-4 && v.abs() < 0.02, "{x} of {length_m} m, {v} m/s left");
        }
        // By hand: 2 s up over 0.4 m, 0.2 m at 0.4 m/s, 2 s down.
        assert!((leg(1.0, 0.4, Some(0.2)).duration_s - 4.5).abs() < 1e-12);
        assert!((leg(1.0, 0.25, None).duration_s - 4.0).abs() < 1e-12);
    }

    #[test]
    fn corners_are_where_a_path_bends() {
        let path = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0]];
        assert_eq!(corners(&path), [[0.0; 3], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0]]);
    }
}
