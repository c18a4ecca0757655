//! Connected configurations: robots docked face to face to what there is, one after the other.

use std::collections::HashSet;
use std::f64::consts::FRAC_PI_2;
use std::ops::ControlFlow;

use quantity::bounds::Bounds;
use quantity::wrap_rad;
use reconfiguration::pose::Pose;
use reconfiguration::problem::Problem;
use reconfiguration::task::{Passage, Task};
use reconfiguration::vehicle::Vehicle;

use super::super::configuration::{LevelBox, TOUCH_M, connectors};
use super::super::order::Workers;
use super::super::vector::{dot, turned};
use super::KEPT;
use super::progress::{GoalProgress, Search, each};

/// Configurations of a size that are still grown on once the search is to end.
const HURRIED: usize = 16;

/// A place for a kind of robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub pose: Pose,
    /// Index of its vehicle.
    pub kind: usize,
}

/// Poses to a millimetre and a milliradian, and kinds: what is equal is one configuration.
type Key = Vec<([i64; 4], usize)>;

fn key(places: &[Place]) -> Key {
    let mut key: Key = places
        .iter()
        .map(|Place { pose, kind }| {
            let [x, y, z] = pose.position_m;
            // −π and π are one heading.
            let yaw = (wrap_rad(pose.yaw_rad + 1e-6) - 1e-6) * 1e3;
            ([x * 1e3, y * 1e3, z * 1e3, yaw].map(|value| value.round() as i64), *kind)
        })
        .collect();
    key.sort_unstable();
    key
}

/// All configurations of all robots that fit the passage and the water, and whether some were left out on the way: those
/// that cost the most by `bound_j`.
pub(super) fn grown(
    problem: &Problem,
    task: &Task,
    bound_j: &(dyn Fn(&[Place]) -> f64 + Sync),
    workers: &dyn Workers,
    progress: &mut dyn GoalProgress,
) -> (Vec<Vec<Place>>, bool) {
    let mut counts = vec![0_usize; problem.vehicles.len()];
    problem.robots.iter().for_each(|robot| counts[robot.vehicle] += 1);
    let tools: Vec<(Pose, &Vehicle)> =
        problem.tools.iter().map(|tool| (tool.pose, &problem.vehicles[tool.vehicle])).collect();
    let grower = Grower { problem, passage: task.passage, bounds_m: problem.rules.bounds_m, tools };
    let mut cut = false;
    let mut level: Vec<Vec<Place>> = grower.seeds();
    let planted = level.first().map_or(0, Vec::len);
    let robots = problem.robots.len();
    let mut hurried = false;
    for placed in planted..robots {
        // In a hurry only the cheapest are grown on, so that some are whole in the end.
        let most = if hurried { HURRIED } else { level.len() };
        cut |= level.len() > most;
        let mut search = Search { placed: placed + 1, robots, ..Search::default() };
        let mut goes_on = |configurations: usize| {
            search.configurations = configurations;
            hurried |= progress.report(&search).is_break();
            if hurried && configurations >= HURRIED {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        let of_one = |places: &Vec<Place>| {
            let mut grown = Vec::new();
            for (kind, &count) in counts.iter().enumerate() {
                if places.iter().filter(|place| place.kind == kind).count() < count {
                    grower.grow(places, kind, &mut |more| grown.push((key(&more), more)));
                }
            }
            grown
        };
        let parents = &level[..most.min(level.len())];
        let grown = each(parents, workers, of_one, &mut goes_on);
        cut |= grown.len() < parents.len();
        let mut known = HashSet::new();
        let new = grown.into_iter().flatten().filter(|(key, _)| known.insert(key.clone()));
        let new: Vec<Vec<Place>> = new.map(|(_, places)| places).collect();
        let bounds_j = each(&new, workers, |places| bound_j(places), &mut goes_on);
        cut |= bounds_j.len() < new.len();
        let mut next: Vec<(f64, Vec<Place>)> = bounds_j.into_iter().zip(new).collect();
        // Equal ones stay in the order in which they were found.
        next.sort_by(|a, b| a.0.total_cmp(&b.0));
        // What cannot do the task any more is no loss.
        cut |= next.get(KEPT).is_some_and(|(bound_j, _)| bound_j.is_finite());
        next.truncate(KEPT);
        level = next.into_iter().map(|(_, places)| places).collect();
    }
    (level, cut)
}

struct Grower<'a> {
    problem: &'a Problem,
    passage: Option<Passage>,
    bounds_m: Option<[[f64; 3]; 2]>,
    tools: Vec<(Pose, &'a Vehicle)>,
}

impl Grower<'_> {
    /// With tools, nothing; without, any kind of robot where the first is.
    fn seeds(&self) -> Vec<Vec<Place>> {
        if !self.tools.is_empty() {
            return vec![Vec::new()];
        }
        let Some(first) = self.problem.robots.first() else { return Vec::new() };
        let mut kinds: Vec<usize> = self.problem.robots.iter().map(|robot| robot.vehicle).collect();
        kinds.sort_unstable();
        kinds.dedup();
        kinds.into_iter().map(|kind| vec![Place { pose: first.start, kind }]).collect()
    }

    /// One robot more at every free face.
    fn grow(&self, places: &[Place], kind: usize, take: &mut impl FnMut(Vec<Place>)) {
        let robots = places.iter().map(|place| (place.pose, &self.problem.vehicles[place.kind]));
        let bodies: Vec<(Pose, &Vehicle)> = self.tools.iter().copied().chain(robots).collect();
        let vehicle = &self.problem.vehicles[kind];
        let boxes: Vec<LevelBox> =
            bodies.iter().map(|(pose, vehicle)| LevelBox::around(*pose, vehicle)).collect();
        for (at, held) in &bodies {
            for (meets_m, outward) in connectors(*at, held) {
                for own in vehicle.connectors().iter() {
                    for quarter in 0..4 {
                        let yaw_rad = wrap_rad(at.yaw_rad + FRAC_PI_2 * f64::from(quarter));
                        if dot(turned(own.normal, yaw_rad), outward) > -1.0 + 1e-9 {
                            continue;
                        }
                        let arm = turned(own.position_m, yaw_rad);
                        let position_m = std::array::from_fn(|k| meets_m[k] - arm[k]);
                        let pose = Pose { position_m, yaw_rad };
                        let around = LevelBox::around(pose, vehicle);
                        let free = boxes.iter().all(|known| !around.overlaps(known));
                        if free && self.fits(&around, &boxes) {
                            let mut more = places.to_vec();
                            more.push(Place { pose, kind });
                            take(more);
                        }
                    }
                }
            }
        }
    }

    /// Whether with one more the whole fits the water, inside its edge, and the passage.
    fn fits(&self, around: &LevelBox, boxes: &[LevelBox]) -> bool {
        if self.bounds_m.is_some_and(|bounds_m| !around.is_within(bounds_m)) {
            return false;
        }
        let in_edge = |bounds: &Bounds| bounds.room_m(&around.outline_m()) >= bounds.margin_m - TOUCH_M;
        if !self.problem.bounds.as_ref().is_none_or(in_edge) {
            return false;
        }
        let Some(Passage { heading_rad, width_m, height_m }) = self.passage else { return true };
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for own in boxes.iter().chain([around]) {
            // As if north were along the passage: what is across is y.
            let turned_box = LevelBox {
                centre_m: turned(own.centre_m, -heading_rad),
                half_m: own.half_m,
                yaw_rad: own.yaw_rad - heading_rad,
            };
            let [least, greatest] = turned_box.extent_m();
            for (k, axis) in [(0, 1), (1, 2)] {
                low[k] = low[k].min(least[axis]);
                high[k] = high[k].max(greatest[axis]);
            }
        }
        high[0] - low[0] <= width_m + TOUCH_M && high[1] - low[1] <= height_m + TOUCH_M
    }
}
