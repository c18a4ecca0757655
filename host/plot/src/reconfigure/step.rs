//! The cluster at rest between two moves: what one picture of `scene.svg` shows.

use reconfiguration::pose::Pose;
use record::reconfigure::Record;

use super::executed_move::{ExecutedMove, executed_moves};
use super::solid::{Solid, Vec3};
use crate::lines::{Point, thin_path};

/// Moves that overlap by no more than this follow each other, s.
const TOGETHER_S: f64 = 1e-3;

/// Points of an executed path nearer to each other than this are not told apart, m.
const SAME_M: f64 = 0.02;

/// No robot swims farther than this from where the first one starts, m: a broken record must not shrink the rest of a
/// picture to nothing.
const FAR_M: f64 = 1e3;

/// A robot at rest.
#[derive(Clone, Debug)]
pub struct Resting {
    /// Its number.
    pub id: u16,
    /// Its hull.
    pub hull: Solid,
    /// Whether it is in its slot.
    pub arrived: bool,
    /// Whether it brings something that not every robot has, or that a slot asks for.
    pub has_sensor: bool,
}

/// The move that ended in this step.
#[derive(Clone, Debug)]
pub struct Way {
    /// The mover: index into [`Rest::robots`].
    pub robot: usize,
    /// Its slot, from 0; none where it parks.
    pub slot: Option<usize>,
    /// Where it came from and where it was to go.
    pub ends: [Vec3; 2],
    /// Corners as planned.
    pub planned: Vec<Vec3>,
    /// Where it went.
    pub executed: Vec<Vec3>,
    /// How long it took, s.
    pub duration_s: f64,
    /// What all robots drew meanwhile, J.
    pub energy_j: f64,
    /// The clearance (19) from resting modules, m.
    pub clearance_m: f64,
}

/// The cluster at rest, at the start or after a move.
#[derive(Clone, Debug)]
pub struct Rest {
    /// All robots, in the order of the problem.
    pub robots: Vec<Resting>,
    /// Tools.
    pub tools: Vec<Solid>,
    /// Slots that no robot has reached: their numbers and their boxes.
    pub slots: Vec<(usize, Solid)>,
    /// Starts that were left: in order, the last one just now.
    pub left: Vec<Vec3>,
    /// How it came to be: one move, or several that were under way together; none at the start.
    pub ways: Vec<Way>,
}

/// The steps of a record: the start, then the cluster after each move. Moves whose times overlap are one step.
#[must_use]
pub fn rests(record: &Record) -> Vec<Rest> {
    let problem = &record.problem;
    let box_of = |vehicle: usize| problem.vehicles.get(vehicle).map_or([0.3; 3], |v| v.box_m);
    let level = |p: Pose| [p.position_m[0], p.position_m[1], p.position_m[2], 0.0, 0.0, p.yaw_rad];
    let hull_of = |robot: usize| problem.robots.get(robot).map_or([0.3; 3], |r| box_of(r.vehicle));
    let is_special = |capability: &String| {
        problem.slots.iter().any(|s| s.requires.contains(capability))
            || !problem.robots.iter().all(|r| r.capabilities.contains(capability))
    };
    let home_m = problem.robots.first().map_or([0.0; 3], |robot| robot.start.position_m);
    let is_near = |p: &Vec3| p.iter().zip(home_m).all(|(v, home)| (v - home).abs() < FAR_M);
    let mut robots: Vec<Resting> = problem
        .robots
        .iter()
        .map(|robot| Resting {
            id: robot.id,
            hull: Solid::hull(level(robot.start), box_of(robot.vehicle)),
            arrived: false,
            has_sensor: robot.capabilities.iter().any(is_special),
        })
        .collect();
    let tools: Vec<Solid> =
        problem.tools.iter().map(|t| Solid::hull(level(t.pose), box_of(t.vehicle))).collect();
    let mut slots: Vec<(usize, Solid)> = problem
        .slots
        .iter()
        .enumerate()
        .map(|(n, slot)| (n, Solid::hull(level(slot.pose), hull_of(0))))
        .collect();
    let mut left = Vec::new();
    let mut rests = vec![Rest {
        robots: robots.clone(),
        tools: tools.clone(),
        slots: slots.clone(),
        left: vec![],
        ways: Vec::new(),
    }];
    let mut until_s = f64::NEG_INFINITY;
    for moved in executed_moves(record) {
        let planned = moved.planned;
        let end = planned.to.or_else(|| Some(problem.slots.get(planned.slot?)?.pose));
        if let Some(mover) = robots.get_mut(moved.robot) {
            // Without an execution the plan is shown.
            if let Some(end) = end {
                mover.hull = Solid::hull(level(end), hull_of(moved.robot));
            }
            mover.arrived = planned.slot.is_some();
        }
        if let Some(after) = moved.after {
            for (n, (resting, sample)) in robots.iter_mut().zip(&after.robots).enumerate() {
                let [x, y, z, angles @ ..] = sample.eta;
                if is_near(&[x, y, z]) && angles.iter().all(|angle| angle.is_finite()) {
                    resting.hull = Solid::hull(sample.eta, hull_of(n));
                }
                // What is marked only while it rests has arrived all the same when its move is over.
                resting.arrived |= sample.arrived && !(n == moved.robot && planned.slot.is_none());
            }
        }
        let start = problem.robots.get(moved.robot).map_or([0.0; 3], |r| r.start.position_m);
        let start = planned.actions.first().map_or(start, |first| first.from.position_m);
        left.push(start);
        slots.retain(|(n, _)| Some(*n) != planned.slot);
        let longest = hull_of(moved.robot).into_iter().fold(0.0, f64::max);
        let (from_s, to_s) = moved.span_s();
        let way = Way {
            robot: moved.robot,
            slot: planned.slot,
            ends: [start, end.map_or(start, |end| end.position_m)],
            planned: planned.path.iter().copied().filter(&is_near).collect(),
            executed: executed(&moved, &is_near),
            duration_s: to_s - from_s,
            energy_j: moved.executed_j().unwrap_or(planned.energy_navigate_j + planned.energy_balance_j),
            clearance_m: problem.rules.clearance_factor * longest,
        };
        let mut ways = vec![way];
        // Under way together with the last one: the same step.
        if from_s < until_s - TOGETHER_S
            && let Some(before) = rests.pop_if(|rest| !rest.ways.is_empty())
        {
            ways.splice(0..0, before.ways);
        }
        until_s = until_s.max(to_s);
        rests.push(Rest {
            robots: robots.clone(),
            tools: tools.clone(),
            slots: slots.clone(),
            left: left.clone(),
            ways,
        });
    }
    rests
}

/// Where the mover was, thinned.
fn executed(moved: &ExecutedMove<'_>, is_near: &impl Fn(&Vec3) -> bool) -> Vec<Vec3> {
    let states = moved.samples.iter().chain(moved.after).filter_map(|s| s.robots.get(moved.robot));
    let mut path: Vec<Vec3> = Vec::new();
    for state in states {
        let [x, y, z, ..] = state.eta;
        let far = |p: &Vec3| (p[0] - x).hypot(p[1] - y).hypot(p[2] - z) >= SAME_M;
        if is_near(&[x, y, z]) && path.last().is_none_or(far) {
            path.push([x, y, z]);
        }
    }
    path
}

/// The executed path from above (east, north), thinned.
#[must_use]
pub fn from_above(path: &[Vec3]) -> Vec<Point> {
    let flat: Vec<Point> = path.iter().map(|p| (p[1], p[0])).collect();
    thin_path(&flat, 0.5 * SAME_M)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reconfigure::sample;

    #[test]
    fn each_move_fills_a_slot_and_leaves_a_start() {
        let rests = rests(&sample::far()[0]);
        assert_eq!(rests.len(), 5);
        for (moves, rest) in rests.iter().enumerate() {
            assert_eq!(rest.robots.iter().filter(|r| r.arrived).count(), moves);
            assert_eq!((rest.slots.len(), rest.left.len()), (4 - moves, moves));
        }
        let last = rests[4].ways.last().expect("a way");
        assert_eq!((last.robot, last.slot), (2, Some(3)));
        assert!((last.clearance_m - 0.7245).abs() < 1e-12);
        assert!((rests[4].robots[2].hull.centre[0] - 1.932).abs() < 1e-12);
    }

    #[test]
    fn moves_that_overlap_in_time_are_one_step() {
        let mut record = sample::far()[0].clone();
        record.samples.clear();
        let [first, second, ..] = record.plan.moves.as_mut_slice() else { panic!("four moves") };
        second.start_s = first.start_s + 0.5 * first.duration_s;
        let rests = rests(&record);
        let ways: Vec<usize> = rests.iter().map(|rest| rest.ways.len()).collect();
        assert_eq!(ways, [0, 2, 1, 1]);
        assert_eq!(rests[1].ways.iter().map(|way| way.robot).collect::<Vec<_>>(), [1, 0]);
        assert_eq!((rests[1].left.len(), rests[1].robots.iter().filter(|r| r.arrived).count()), (2, 2));
    }

    #[test]
    fn without_an_execution_the_plan_is_shown() {
        let mut record = sample::far()[0].clone();
        record.samples.clear();
        let rests = rests(&record);
        assert!((rests[1].robots[1].hull.centre[0] - 0.483).abs() < 1e-12);
        assert!(rests[1].ways.last().is_some_and(|w| w.executed.is_empty() && w.energy_j > 0.0));
    }

    #[test]
    fn only_what_tells_robots_apart_is_a_sensor() {
        let mut record = sample::far()[0].clone();
        for robot in &mut record.problem.robots {
            robot.capabilities = vec!["depth".to_owned()];
        }
        record.problem.robots[2].capabilities.push("camera".to_owned());
        let has: Vec<bool> = rests(&record)[0].robots.iter().map(|r| r.has_sensor).collect();
        assert_eq!(has, [false, false, true, false]);
    }
}
