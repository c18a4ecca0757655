//! Moves that overlap in time: what waits from one departure or arrival to the next, and robots that are under way
//! together, every few millimetres of what they come nearer.
//!
//! | | what is looked at |
//! |---|---|
//! | intervals | they follow each other from 0 to the end; a robot leaves and arrives where one ends; some robot is under way in each |
//! | balance | thrusts of every interval balance what waits in it; no tool is alone |
//! | energy | Σ P_bal T of the intervals is what the moves account for, in equal shares of those under way |
//! | (19) | a robot farther than d from its start and its slot keeps d to every other, resting or moving |
//! | hulls | no two overlap, ever |
//!
//! Limits. Both robots of a pair are seen every 2.5 mm and 0.01 rad of their own motion, so that the two together are not
//! nearer than one mover is to what rests when it is looked at every 5 mm.

use std::collections::BTreeMap;

use reconfiguration::plan::{Action, ActionKind, Interval, Manner, Move};
use reconfiguration::pose::Pose;

use super::accounts::{SAME_S, adds_up};
use super::kinematics::{length, peak, pose_at};
use super::{Body, Condition, Judge, bodies, clearance_m, distance_m, geometry, too_near};

/// Longest way of a robot between two looks, m.
const STEP_M: f64 = 0.0025;
/// Its greatest turn, rad.
const STEP_RAD: f64 = 0.01;
/// No span between two events is looked at more often.
const LOOKS_MAX: f64 = 2e6;
/// What rounding may take off a clearance, m.
const ROUNDING_M: f64 = 1e-5;

fn end_s(own: &Move) -> f64 {
    own.start_s + own.duration_s
}

/// Checks of times and energies of the whole plan.
pub(super) fn account(judge: &mut Judge<'_>) {
    let plan = judge.plan;
    let mut wrong: Vec<(Option<usize>, f64, Condition, String)> = Vec::new();
    if plan.manner == Manner::Paper {
        let message = "by the paper's rules one robot moves after the other".to_owned();
        wrong.push((None, 0.0, Condition::V1, message));
    }
    for (index, own) in plan.moves.iter().enumerate() {
        if own.start_s < 0.0 {
            let message = format!("robot {} sets out at {} s", own.robot, own.start_s);
            wrong.push((Some(index), own.start_s, Condition::Timing, message));
        }
        if let Some(later) = plan.moves[..index].iter().find(|before| before.start_s > own.start_s + SAME_S) {
            let message = format!("it stands behind a move that begins later, at {:.3} s", later.start_s);
            wrong.push((Some(index), own.start_s, Condition::Timing, message));
        }
        let mut same = plan.moves[..index].iter().filter(|before| before.robot == own.robot);
        if let Some(before) = same.rfind(|before| end_s(before) > own.start_s + SAME_S) {
            let message = format!(
                "robot {} sets out before its move before it ends, at {:.3} s",
                own.robot,
                end_s(before)
            );
            wrong.push((Some(index), own.start_s, Condition::V1, message));
        }
        if !own.balance.is_empty() {
            let message = "thrusts of waiting robots stand with the move, not with the intervals".to_owned();
            wrong.push((Some(index), own.start_s, Condition::V6, message));
        }
        for event_s in [own.start_s, end_s(own)] {
            let within =
                |i: &Interval| i.start_s < event_s - SAME_S && i.start_s + i.duration_s > event_s + SAME_S;
            if plan.intervals.iter().any(within) {
                let message =
                    format!("robot {} leaves or arrives at {event_s:.3} s, within an interval", own.robot);
                wrong.push((Some(index), event_s, Condition::Timing, message));
            }
        }
    }
    let mut now_s = 0.0;
    let mut shares_j = vec![0.0; plan.moves.len()];
    for interval in &plan.intervals {
        let Interval { start_s, duration_s, balance_w, .. } = interval;
        if (start_s - now_s).abs() > SAME_S || *duration_s < 0.0 {
            let message =
                format!("an interval of {duration_s} s begins at {start_s:.6} s, not at {now_s:.6} s");
            wrong.push((None, *start_s, Condition::Timing, message));
        }
        if *balance_w < 0.0 {
            wrong.push((None, *start_s, Condition::Energy, format!("balance_w = {balance_w} is negative")));
        }
        now_s = start_s + duration_s;
        let movers: Vec<usize> =
            (0..plan.moves.len()).filter(|&own| is_away(&plan.moves[own], interval)).collect();
        if movers.is_empty() {
            let message = format!("no robot moves from {start_s:.3} s to {now_s:.3} s");
            wrong.push((None, *start_s, Condition::Timing, message));
        }
        for &own in &movers {
            shares_j[own] += balance_w * duration_s / movers.len() as f64;
        }
    }
    let last_s = plan.moves.iter().map(end_s).fold(0.0, f64::max);
    for (what, value_s) in [("the intervals end", now_s), ("the last move ends", last_s)] {
        if (plan.time_s - value_s).abs() > SAME_S {
            let message = format!("time_s = {:.6} s, {what} at {value_s:.6} s", plan.time_s);
            wrong.push((None, value_s, Condition::Timing, message));
        }
    }
    for ((index, own), share_j) in plan.moves.iter().enumerate().zip(shares_j) {
        if !adds_up(own.energy_balance_j, share_j) {
            let value = own.energy_balance_j;
            let message =
                format!("energy_balance_j = {value:.6} J, its share of the intervals is {share_j:.6} J");
            wrong.push((Some(index), own.start_s, Condition::Energy, message));
        }
    }
    for (index, time_s, condition, message) in wrong {
        judge.add(index, time_s, condition, message);
    }
}

fn is_away(own: &Move, interval: &Interval) -> bool {
    let middle_s = interval.start_s + interval.duration_s / 2.0;
    own.start_s < middle_s && middle_s < end_s(own)
}

/// Plays all moves back together.
pub(super) fn check(judge: &mut Judge<'_>) {
    for interval in &judge.plan.intervals {
        let resting = waiting(judge, interval);
        let until_s = interval.start_s + interval.duration_s;
        let meanwhile = format_args!("until {until_s:.2} s");
        judge.judge_waiting((None, interval.start_s), &interval.balance, &resting, meanwhile);
    }
    together(judge);
}

/// Robots that wait in an interval, where they are then, and tools.
fn waiting<'a>(judge: &Judge<'a>, interval: &Interval) -> Vec<Body<'a>> {
    let problem = judge.problem;
    let poses: Vec<Pose> = problem
        .robots
        .iter()
        .map(|robot| {
            let over = judge.plan.moves.iter().rfind(|own| {
                own.robot == robot.id && end_s(own) <= interval.start_s + interval.duration_s / 2.0
            });
            over.and_then(|own| own.actions.last()).map_or(robot.start, |last| last.to)
        })
        .collect();
    let moves = &judge.plan.moves;
    bodies(problem, &poses, |robot| {
        !moves.iter().any(|own| own.robot == problem.robots[robot].id && is_away(own, interval))
    })
}

/// A robot at an instant.
struct Seen {
    pose: Pose,
    box_m: [f64; 3],
    /// Its move, if it is under way, and whether it is in the open.
    under_way: Option<(usize, bool)>,
}

/// By move and what it came too near to: when first, the least distance of the centres, and the clearance of the mover, m.
type Found = BTreeMap<(usize, String), (f64, f64, f64)>;

/// (19) and hulls between robots.
fn together(judge: &mut Judge<'_>) {
    let plan = judge.plan;
    let mut events_s: Vec<f64> = plan.moves.iter().flat_map(|own| &own.actions).map(|a| a.start_s).collect();
    events_s.extend(plan.moves.iter().map(end_s));
    events_s.sort_by(f64::total_cmp);
    let mut found = Found::new();
    for span in events_s.windows(2) {
        let (from_s, to_s) = (span[0], span[1]);
        let middle_s = 0.5 * (from_s + to_s);
        let current = plan.moves.iter().filter_map(|own| action_at(own, middle_s));
        let steps = current.map(|action| {
            let step = if action.kind == ActionKind::Turn { STEP_RAD } else { STEP_M };
            if length(action) > 0.0 { peak(action) * (to_s - from_s) / step } else { 0.0 }
        });
        let steps = steps.fold(1.0, f64::max).ceil();
        if !steps.is_finite() || steps > LOOKS_MAX {
            let message = format!("from {from_s} s to {to_s} s: too long to be judged");
            judge.add(None, from_s, Condition::Kinematics, message);
            return;
        }
        // Whole numbers below 2²¹.
        for step in 0..=steps as u32 {
            let now_s = from_s + (to_s - from_s) * f64::from(step) / steps;
            look(judge, now_s, &mut found);
        }
    }
    for ((index, what), (time_s, value_m, d_m)) in found {
        judge.add(Some(index), time_s, Condition::V3, too_near(&what, value_m, d_m));
    }
}

fn action_at(own: &Move, now_s: f64) -> Option<&Action> {
    if now_s < own.start_s || now_s >= end_s(own) {
        return None;
    }
    own.actions.iter().rfind(|action| action.start_s <= now_s)
}

/// All pairs of robots of which one is under way, at one instant.
fn look(judge: &Judge<'_>, now_s: f64, found: &mut Found) {
    let robots: Vec<Option<Seen>> =
        (0..judge.problem.robots.len()).map(|robot| seen(judge, robot, now_s)).collect();
    let mut note = |index: usize, what: String, value_m: f64, d_m: f64| {
        let entry = found.entry((index, what)).or_insert((now_s, value_m, d_m));
        entry.1 = entry.1.min(value_m);
    };
    for (first, one) in robots.iter().enumerate() {
        for (second, two) in robots.iter().enumerate() {
            let (Some(one), Some(two)) = (one, two) else { continue };
            let Some((index, open)) = one.under_way.filter(|_| first != second) else { continue };
            let name = || format!("robot {}", judge.problem.robots[second].id);
            let apart_m = distance_m(one.pose.position_m, two.pose.position_m);
            let d_m = clearance_m(judge.problem, one.box_m);
            if open && apart_m < d_m - ROUNDING_M {
                note(index, format!("clearance to {}", name()), apart_m, d_m);
            }
            if geometry::overlap((one.pose, one.box_m), (two.pose, two.box_m)) {
                note(index, format!("collision with {}", name()), apart_m, d_m);
            }
        }
    }
}

fn seen(judge: &Judge<'_>, robot: usize, now_s: f64) -> Option<Seen> {
    let known = judge.problem.robots.get(robot)?;
    let box_m = judge.problem.vehicles.get(known.vehicle)?.box_m;
    let own = judge.plan.moves.iter().enumerate().filter(|(_, own)| own.robot == known.id);
    let mut pose = known.start;
    for (index, own) in own {
        let (Some(first), Some(last)) = (own.actions.first(), own.actions.last()) else { continue };
        if let Some(action) = action_at(own, now_s) {
            let pose = pose_at(action, now_s - action.start_s);
            let d_m = clearance_m(judge.problem, box_m);
            let open = [first.from, last.to]
                .iter()
                .all(|dock| distance_m(pose.position_m, dock.position_m) > d_m + ROUNDING_M);
            return Some(Seen { pose, box_m, under_way: Some((index, open)) });
        }
        if end_s(own) <= now_s {
            pose = last.to;
        }
    }
    Some(Seen { pose, box_m, under_way: None })
}

#[cfg(test)]
mod tests;
