//! Exact answers against samples of the same motions.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use reconfiguration::plan::{Action, ActionKind, Move};
use reconfiguration::pose::Pose;
use reconfiguration::problem::Rules;

use super::super::super::configuration::LevelBox;
use super::super::super::guidance::reference::ReferenceTrajectory;
use super::super::super::vector::{length, offset};
use super::super::track::pieces;
use super::*;

const HALF_M: [f64; 3] = [0.2415, 0.165, 0.1335];
const CLEAR_M: f64 = 0.7245;

/// A move by way of the poses: to each place with the heading held, then to its heading.
fn by_way_of(poses: &[Pose], start_s: f64) -> Move {
    let rules = Rules::default();
    let mut actions: Vec<Action> = Vec::new();
    let mut now_s = start_s;
    for pair in poses.windows(2) {
        let arrived = Pose { yaw_rad: pair[0].yaw_rad, ..pair[1] };
        for (kind, from, to) in [(ActionKind::Leg, pair[0], arrived), (ActionKind::Turn, arrived, pair[1])] {
            let (speed, a) = if kind == ActionKind::Leg { (0.3, 0.2) } else { (0.8, 1.0) };
            let (acceleration, energy_j) = (Some(a), 0.0);
            let mut action =
                Action { kind, start_s: now_s, duration_s: 0.0, from, to, speed, acceleration, energy_j };
            action.duration_s = ReferenceTrajectory::new(&action, &rules).duration_s();
            now_s += action.duration_s;
            actions.push(action);
        }
    }
    Move {
        robot: 1,
        slot: Some(0),
        to: None,
        path: Vec::new(),
        start_s,
        duration_s: now_s - start_s,
        energy_navigate_j: 0.0,
        energy_balance_j: 0.0,
        balance_w: 0.0,
        balance: Vec::new(),
        actions,
    }
}

fn track(own: &Move) -> Vec<Piece> {
    let (first, last) = (own.actions[0].from, own.actions[own.actions.len() - 1].to);
    let mut track = vec![Piece::at_rest(first, [0.0; 3], -1e9, own.start_s)];
    track.extend(pieces(own, [0.0; 3], CLEAR_M).into_iter().map(|piece| piece.later(own.start_s)));
    track.push(Piece::at_rest(last, [0.0; 3], own.start_s + own.duration_s, 1e9));
    track
}

fn pose(own: &Move, t_s: f64) -> (Pose, bool) {
    let rules = Rules::default();
    let action = own.actions.iter().rfind(|action| action.start_s <= t_s).unwrap_or(&own.actions[0]);
    let turning = action.kind == ActionKind::Turn && t_s < action.start_s + action.duration_s;
    (ReferenceTrajectory::new(action, &rules).at(t_s - action.start_s).pose, turning)
}

#[test]
fn what_is_called_clear_is_clear_in_every_sample_and_what_is_not_nearly_meets() {
    let seed = 11;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut clear, mut met, mut late) = (0, 0, 0);
    for case in 0..600 {
        let mut random = |spread: f64| {
            let [x, y, z, yaw] = [0; 4].map(|_| rng.random_range(-1.0..1.0));
            Pose::from([spread * x, spread * y, 0.3 * spread * z, 3.0 * yaw])
        };
        let [a, b] = [[random(2.0), random(2.0), random(2.0)], [random(2.0), random(2.0), random(2.0)]];
        let own = by_way_of(&a, 0.0);
        let other = by_way_of(&b, rng.random_range(-5.0..15.0));
        let size = Size { half_m: HALF_M, distance_m: CLEAR_M };
        let answer = keep_clear((size, &track(&own)), (size, &track(&other)));
        assert_eq!(
            answer,
            keep_clear((size, &track(&other)), (size, &track(&own))),
            "seed {seed}, case {case}"
        );
        // Margins: how far inside the rule the worst sample is; a turning hull is the circle around it.
        let (mut worst_m, mut overlap_m) = (f64::INFINITY, f64::INFINITY);
        let (from_s, to_s) = (own.start_s.min(other.start_s) - 0.1, 60.0);
        let mut t_s: f64 = from_s;
        while t_s < to_s {
            let poses = [pose(&own, t_s), pose(&other, t_s)];
            let apart_m = length(offset(poses[0].0.position_m, poses[1].0.position_m));
            for (moves, (at, _)) in [(&own, poses[0]), (&other, poses[1])] {
                let docks = [moves.actions[0].from, moves.actions[moves.actions.len() - 1].to];
                let out = |dock: Pose| length(offset(dock.position_m, at.position_m)) > CLEAR_M;
                if docks.into_iter().all(out) {
                    worst_m = worst_m.min(apart_m - CLEAR_M);
                }
            }
            let boxes = poses.map(|(at, _)| LevelBox {
                centre_m: at.position_m,
                half_m: HALF_M,
                yaw_rad: at.yaw_rad,
            });
            let gap_m = boxes[0].gap_m(&boxes[1]);
            overlap_m = overlap_m.min(gap_m);
            // As far as a turning hull reaches beyond its box.
            let loose = if poses.iter().any(|(_, turning)| *turning) { 0.13 } else { 0.0 };
            worst_m = worst_m.min(gap_m - loose);
            t_s += 0.01;
        }
        if answer {
            clear += 1;
            assert!(worst_m > -0.13 - 1e-4 && overlap_m > -1e-4, "seed {seed}, case {case}: {worst_m} m");
        } else {
            met += 1;
            // In 0.01 s two robots come 6 mm nearer.
            assert!(worst_m < 0.007, "seed {seed}, case {case}: {worst_m} m");
            let later = by_way_of(&b, 100.0);
            late += usize::from(keep_clear((size, &track(&own)), (size, &track(&later))));
        }
    }
    assert!(clear > 60 && met > 60, "{clear} clear, {met} met");
    assert!(late > 0, "some meet only because they are under way together");
}

/// Docked side by side, both slide off along each other, in step and out of step; one that turns there does not.
#[test]
fn neighbours_leave_along_each_other() {
    let size = Size { half_m: HALF_M, distance_m: CLEAR_M };
    let start = [[0.0; 4], [0.0, 0.33, 0.0, 0.0]].map(Pose::from);
    for (ahead, late_s, clear) in [(1.0, 0.0, true), (1.0, 1.0, true), (-1.0, 0.7, true), (0.2, 0.0, true)] {
        let ends = [[2.0, -1.0], [2.0 * ahead, 3.0]].map(|[x, y]| Pose::from([x, y, 0.0, 0.0]));
        let slid = [0, 1].map(|k| Pose {
            position_m: [0.4 * ends[k].position_m[0].signum(), start[k].position_m[1], 0.0],
            ..start[k]
        });
        let own = by_way_of(&[start[0], slid[0]], 0.0);
        let other = by_way_of(&[start[1], slid[1]], late_s);
        assert_eq!(keep_clear((size, &track(&own)), (size, &track(&other))), clear, "{ahead}, {late_s} s");
    }
    let turned = by_way_of(&[start[0], Pose { yaw_rad: 1.0, ..start[0] }], 0.0);
    let rests = by_way_of(&[start[1], start[1]], 0.0);
    assert!(!keep_clear((size, &track(&turned)), (size, &track(&rests))));
}
