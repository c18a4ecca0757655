//! Parallel plans of ROVs spoilt in time: moves begin at other times, legs are swum more slowly. Everything else is in
//! order: times follow, thrusts balance what waits, sums add up. What robots come to in such a plan is sampled here.

use rand::{Rng, RngExt};
use reconfiguration::plan::{ActionKind, Holding, Interval, Move, Plan};
use reconfiguration::pose::Pose;
use reconfiguration::problem::Problem;
use rov::balance::balance;
use rov::conditions::Conditions;
use rov::configuration::LevelBox;
use rov::guidance::reference::ReferenceTrajectory;
use rov::power::{PowerLaw, limits_n};

/// Pause between two samples, s.
const SAMPLE_S: f64 = 0.002;
/// Hulls that run into each other by less touch, m: half of what a judge lets pass.
const TOUCH_M: f64 = 5e-4;

/// A plan spoilt in time, and what is known of it.
pub struct Shifted {
    /// It.
    pub plan: Plan,
    /// How much room there is at the worst instant, m: less than none where hulls overlap or (19) is broken.
    pub margin_m: f64,
    /// Whether everything that waits can be balanced, with no tool alone.
    pub balanced: bool,
}

/// The plan with something shifted; `None` where then no robot moves for a while.
pub fn shifted(problem: &Problem, plan: &Plan, law: &PowerLaw, rng: &mut impl Rng) -> Option<Shifted> {
    let mut plan = plan.clone();
    let index = rng.random_range(0..plan.moves.len());
    if rng.random_bool(0.3) {
        slow_down(&mut plan.moves[index], rng.random_range(0.4..0.9));
    } else {
        let own = &mut plan.moves[index];
        own.start_s = (own.start_s + rng.random_range(-12.0..12.0)).max(0.0);
    }
    let balanced = lay(problem, &mut plan, law)?;
    let margin_m = margin_m(problem, &plan);
    Some(Shifted { plan, margin_m, balanced })
}

/// Every leg of a move at a share of its speed.
fn slow_down(own: &mut Move, share: f64) {
    for action in own.actions.iter_mut().filter(|action| action.kind == ActionKind::Leg) {
        let squares: f64 =
            (0..3).map(|k| (action.to.position_m[k] - action.from.position_m[k]).powi(2)).sum();
        let Some(a) = action.acceleration.filter(|_| squares > 0.0) else { continue };
        let way_m = squares.sqrt();
        action.speed = share * action.speed.min((a * way_m).sqrt());
        action.duration_s = way_m / action.speed + action.speed / a;
    }
}

/// Times, intervals and sums from start times and durations of actions; whether what waits can be balanced.
fn lay(problem: &Problem, plan: &mut Plan, law: &PowerLaw) -> Option<bool> {
    plan.moves.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
    let first_s = plan.moves.first()?.start_s;
    for own in &mut plan.moves {
        own.start_s -= first_s;
        let mut now_s = own.start_s;
        for action in &mut own.actions {
            action.start_s = now_s;
            now_s += action.duration_s;
        }
        own.duration_s = now_s - own.start_s;
        own.energy_balance_j = 0.0;
    }
    let mut cuts: Vec<f64> =
        plan.moves.iter().flat_map(|own| [own.start_s, own.start_s + own.duration_s]).collect();
    cuts.sort_by(f64::total_cmp);
    cuts.dedup_by(|b, a| *b - *a < 1e-9);
    let limits_n = limits_n(problem.rules.battery_v).ok()?;
    let mut all_balanced = true;
    plan.intervals.clear();
    for cut in cuts.windows(2) {
        let middle_s = 0.5 * (cut[0] + cut[1]);
        let away = |own: &Move| own.start_s < middle_s && middle_s < own.start_s + own.duration_s;
        let movers = plan.moves.iter().filter(|own| away(own)).count();
        if movers == 0 {
            return None;
        }
        let (mut ids, mut bodies) = (Vec::new(), Vec::new());
        bodies.extend(problem.tools.iter().map(|tool| (tool.pose, &problem.vehicles[tool.vehicle])));
        for robot in &problem.robots {
            let own: Vec<&Move> = plan.moves.iter().filter(|own| own.robot == robot.id).collect();
            if !own.iter().any(|own| away(own)) {
                let over = own.iter().rfind(|own| own.start_s + own.duration_s <= middle_s);
                let pose = over.and_then(|own| own.actions.last()).map_or(robot.start, |last| last.to);
                ids.push(robot.id);
                bodies.push((pose, &problem.vehicles[robot.vehicle]));
            }
        }
        let (balance_w, thrusts_n) = match balance(&bodies, law, limits_n, &problem.rules) {
            Ok(balance) => (balance.power_w, balance.thrusts_n),
            Err(_) => {
                all_balanced = false;
                (0.0, Vec::new())
            }
        };
        let thrusts_n = thrusts_n.into_iter().skip(problem.tools.len());
        let balance = ids.into_iter().zip(thrusts_n).map(|(robot, thrusts_n)| Holding { robot, thrusts_n });
        let duration_s = cut[1] - cut[0];
        plan.intervals.push(Interval { start_s: cut[0], duration_s, balance_w, balance: balance.collect() });
        for own in plan.moves.iter_mut().filter(|own| away(own)) {
            own.energy_balance_j += balance_w * duration_s / movers as f64;
        }
    }
    for own in &mut plan.moves {
        own.balance_w = own.energy_balance_j / own.duration_s;
    }
    plan.time_s = *cuts.last()?;
    plan.energy_navigate_j = plan.moves.iter().map(|own| own.energy_navigate_j).sum();
    plan.energy_balance_j = plan.moves.iter().map(|own| own.energy_balance_j).sum();
    plan.energy_total_j = plan.energy_navigate_j + plan.energy_balance_j;
    Some(all_balanced)
}

/// A robot under way at an instant: where it is, and whether it is outside its dock zones.
type Place = (Pose, Option<bool>);

/// Where every robot of a plan is at an instant: its pose, and whether it is under way in the open.
pub fn places(problem: &Problem, plan: &Plan, now_s: f64) -> Vec<Place> {
    let place = |robot: &reconfiguration::problem::Robot| {
        let mut pose = robot.start;
        for own in plan.moves.iter().filter(|own| own.robot == robot.id) {
            let (Some(first), Some(last)) = (own.actions.first(), own.actions.last()) else { continue };
            if now_s >= own.start_s + own.duration_s {
                pose = last.to;
            } else if now_s >= own.start_s {
                let action = own.actions.iter().rfind(|a| a.start_s <= now_s).unwrap_or(first);
                let reference = ReferenceTrajectory::new(action, &problem.rules).at(now_s - action.start_s);
                let d_m = problem.clearance_m(&problem.vehicles[robot.vehicle]);
                let out = |dock: Pose| apart_m(dock, reference.pose) > d_m;
                return (reference.pose, Some(out(first.from) && out(last.to)));
            }
        }
        (pose, None)
    };
    problem.robots.iter().map(place).collect()
}

fn apart_m(a: Pose, b: Pose) -> f64 {
    (0..3).map(|k| (a.position_m[k] - b.position_m[k]).powi(2)).sum::<f64>().sqrt()
}

/// The least room between two robots of which one is under way.
fn margin_m(problem: &Problem, plan: &Plan) -> f64 {
    let mut margin_m = f64::INFINITY;
    let mut now_s = 0.0;
    while now_s < plan.time_s {
        let places = places(problem, plan, now_s);
        for (first, (pose, under_way)) in places.iter().enumerate() {
            let Some(open) = under_way else { continue };
            let vehicle = |robot: usize| &problem.vehicles[problem.robots[robot].vehicle];
            let d_m = problem.clearance_m(vehicle(first));
            for (second, (other, _)) in places.iter().enumerate().filter(|(second, _)| *second != first) {
                let apart_m = apart_m(*pose, *other);
                if *open {
                    margin_m = margin_m.min(apart_m - d_m);
                }
                if apart_m < d_m {
                    let around = |robot: usize, at: Pose| LevelBox::around(at, vehicle(robot));
                    let gap_m = around(first, *pose).gap_m(&around(second, *other));
                    margin_m = margin_m.min(if gap_m > -TOUCH_M { f64::INFINITY } else { gap_m });
                }
            }
        }
        now_s += SAMPLE_S;
    }
    margin_m
}
