//! The frame that a problem is planned in, so that neither north, nor the origin of the world, nor the order of a file
//! matters.
//!
//! ```text
//! p' = R_z(−ψ₀)·(p − p₀),   ψ' = ψ − ψ₀
//! ```
//!
//! | symbol | meaning | frame, unit |
//! |---|---|---|
//! | p₀, ψ₀ | pose of the reference: a tool, or a robot where there is none | world; m, rad |
//! | p, ψ; p', ψ' | a pose in the file; in the frame | world; frame; m, rad |
//!
//! **Reference.** From every tool (every robot) the problem is written down as a sorted list of what is where; the least
//! list wins. Two references with the same list see the same problem, so that it does not matter which is taken.
//!
//! **Order.** Robots, tools, slots and vehicles are sorted by where and what they are.
//!
//! **Numbers.** The origin is subtracted first, and what is left is rounded to a decimal of a billionth of the
//! problem's size or less: faces that are docked in the file are docked in the frame to the last bit, at every heading.
//! 10⁶ m from the world's origin a number of the file ends at 10⁻¹⁰ m.
//!
//! Corners of the water given in a file stay where they are in the world: [`Water`] turned by −ψ₀. Water that is not given
//! is a box in this frame.

use std::f64::consts::{FRAC_PI_2, PI};

use quantity::wrap_rad;
use reconfiguration::plan::{Placed, Plan};
use reconfiguration::pose::Pose;
use reconfiguration::problem::Problem;

use super::conditions::Conditions;
use super::vector::{length, offset, turned};
use super::water::Water;

/// Headings are rounded to this, rad.
const STEP_RAD: f64 = 1e-9;
/// A place of a plan nearer than this to where its robot starts or ends is that place, m.
const KEPT_M: f64 = 1e-9;
/// Places are compared in so many steps of what they are rounded to: what rounding may part is still one.
const COARSE: f64 = 1000.0;

/// A problem in its own frame.
#[derive(Clone, Debug)]
pub struct Framed {
    /// The problem in the frame, sorted; corners of the water, if given, are those of the box around it.
    pub problem: Problem,
    /// The water, in the frame.
    pub water: Water,
    frame: Frame,
    /// Indices in the file, by index in the frame.
    robots: Vec<usize>,
    slots: Vec<usize>,
}

impl Framed {
    /// A problem in its frame.
    #[must_use]
    pub fn of(problem: &Problem) -> Self {
        let vehicles = order(problem.vehicles.len(), |k| format!("{:?}", problem.vehicles[k]));
        let mut rank = vec![0; vehicles.len()];
        vehicles.iter().enumerate().for_each(|(new, &old)| rank[old] = new);
        let places = Places { problem, rank: &rank };
        let (frame, robots, tools, slots) = places.least();
        let mut framed = problem.clone();
        framed.vehicles = vehicles.iter().map(|&k| problem.vehicles[k].clone()).collect();
        framed.robots = robots.iter().map(|&k| problem.robots[k].clone()).collect();
        framed.tools = tools.iter().map(|&k| problem.tools[k].clone()).collect();
        framed.slots = slots.iter().map(|&k| problem.slots[k].clone()).collect();
        for robot in &mut framed.robots {
            robot.start = frame.into_frame(robot.start);
            robot.vehicle = rank.get(robot.vehicle).copied().unwrap_or(robot.vehicle);
        }
        for tool in &mut framed.tools {
            tool.pose = frame.into_frame(tool.pose);
            tool.vehicle = rank.get(tool.vehicle).copied().unwrap_or(tool.vehicle);
        }
        framed.slots.iter_mut().for_each(|slot| slot.pose = frame.into_frame(slot.pose));
        let water = match problem.rules.bounds_m {
            None => Water::from(framed.bounds_m()),
            Some(corners_m) => {
                let corners_m = corners_m.map(|corner| offset(frame.origin_m, corner));
                Water::new(corners_m, -frame.yaw_rad)
            }
        };
        framed.rules.bounds_m = problem.rules.bounds_m.map(|_| water.extent_m());
        if let Some(bounds) = &mut framed.bounds {
            for point in &mut bounds.edge_m {
                let [x, y, _] =
                    turned(offset(frame.origin_m, [point[0], point[1], frame.origin_m[2]]), -frame.yaw_rad);
                *point = [x, y];
            }
        }
        let water = water.within(framed.bounds.clone());
        Self { problem: framed, water, frame, robots, slots }
    }

    /// Indices of slots in the file, by index in the frame.
    #[must_use]
    pub fn slots(&self) -> &[usize] {
        &self.slots
    }

    /// A plan of the framed problem as one of the problem in the file. Where a robot starts or ends, the plan has the
    /// file's own numbers.
    #[must_use]
    pub fn into_world(&self, mut plan: Plan, problem: &Problem) -> Plan {
        for own in &mut plan.moves {
            let robot = self.problem.robots.iter().position(|robot| robot.id == own.robot);
            let ends =
                own.slot.and_then(|framed| Some((self.problem.slots.get(framed)?, *self.slots.get(framed)?)));
            let known: Vec<(Pose, Pose)> = [
                robot.map(|k| (self.problem.robots[k].start, problem.robots[self.robots[k]].start)),
                ends.map(|(framed, slot)| (framed.pose, problem.slots[slot].pose)),
            ]
            .into_iter()
            .flatten()
            .collect();
            let place = |at_m: [f64; 3]| {
                let kept = known.iter().find(|(framed, _)| length(offset(framed.position_m, at_m)) < KEPT_M);
                kept.map_or_else(|| self.frame.place_in_world(at_m), |(_, file)| file.position_m)
            };
            let pose = |pose: Pose| {
                let kept = known.iter().find(|(framed, _)| *framed == pose);
                let yaw_rad = wrap_rad(pose.yaw_rad + self.frame.yaw_rad);
                kept.map_or_else(|| Pose { position_m: place(pose.position_m), yaw_rad }, |(_, file)| *file)
            };
            own.slot = ends.map(|(_, slot)| slot);
            own.to = own.to.map(pose);
            own.path.iter_mut().for_each(|corner| *corner = place(*corner));
            for action in &mut own.actions {
                (action.from, action.to) = (pose(action.from), pose(action.to));
            }
        }
        plan.robots =
            problem.robots.iter().map(|robot| Placed { id: robot.id, start: robot.start }).collect();
        plan.slots = problem.slots.iter().map(|slot| slot.pose).collect();
        plan
    }
}

/// Origin, axes and precision.
#[derive(Clone, Copy, Debug)]
struct Frame {
    origin_m: [f64; 3],
    yaw_rad: f64,
    /// Steps of a metre that places are rounded to; a power of ten.
    steps_per_m: f64,
}

impl Frame {
    fn into_frame(self, pose: Pose) -> Pose {
        // p' = R_z(−ψ₀)·(p − p₀)
        let place_m = turned(offset(self.origin_m, pose.position_m), -self.yaw_rad);
        // By a whole number of steps per metre, so that 0.483 is the number that 0.483 in a file is; −0 becomes 0.
        let position_m = place_m.map(|x| (x * self.steps_per_m).round() / self.steps_per_m + 0.0);
        Pose { position_m, yaw_rad: rounded_rad(pose.yaw_rad - self.yaw_rad) }
    }

    fn place_in_world(self, place_m: [f64; 3]) -> [f64; 3] {
        let arm_m = turned(place_m, self.yaw_rad);
        std::array::from_fn(|k| self.origin_m[k] + arm_m[k])
    }
}

/// In (−π, π], a quarter turn where it is one to rounding.
fn rounded_rad(angle_rad: f64) -> f64 {
    let angle_rad = wrap_rad(angle_rad);
    let quarters = (angle_rad / FRAC_PI_2).round();
    if (angle_rad - quarters * FRAC_PI_2).abs() <= STEP_RAD {
        return if quarters < -1.5 { PI } else { quarters * FRAC_PI_2 + 0.0 };
    }
    (angle_rad / STEP_RAD).round() * STEP_RAD
}

/// What is where, comparable: place in coarse steps, heading, kind, services.
type Entry = (u8, [i64; 4], usize, Vec<String>);

/// A problem to be written down from different references.
struct Places<'a> {
    problem: &'a Problem,
    /// Place of each vehicle in the order of vehicles.
    rank: &'a [usize],
}

type Sorted = (Frame, Vec<usize>, Vec<usize>, Vec<usize>);

impl Places<'_> {
    /// The frame of the least list, and robots, tools and slots in its order.
    fn least(&self) -> Sorted {
        let problem = self.problem;
        let tools = problem.tools.iter().map(|tool| tool.pose);
        let robots = problem.robots.iter().map(|robot| robot.start);
        let references: Vec<Pose> = if problem.tools.is_empty() { robots.collect() } else { tools.collect() };
        let steps_per_m = self.steps_per_m();
        let seen = references.iter().map(|pose| {
            let frame = Frame { origin_m: pose.position_m, yaw_rad: pose.yaw_rad, steps_per_m };
            let (mut list, sorted) = self.from(frame);
            list.sort_unstable();
            (list, sorted)
        });
        let nowhere = Frame { origin_m: [0.0; 3], yaw_rad: 0.0, steps_per_m };
        seen.min_by(|a, b| a.0.cmp(&b.0)).map_or_else(|| self.from(nowhere).1, |(_, sorted)| sorted)
    }

    /// A decimal of at most a billionth of the problem's size, and not below what a file's numbers can carry.
    fn steps_per_m(&self) -> f64 {
        let problem = self.problem;
        let places = problem.robots.iter().map(|robot| robot.start.position_m);
        let places: Vec<_> = places.chain(problem.slots.iter().map(|slot| slot.pose.position_m)).collect();
        let pairs = places.iter().flat_map(|a| places.iter().map(move |b| (*a, *b)));
        let size_m = pairs.map(|(a, b)| length(offset(a, b))).fold(0.0, f64::max);
        if size_m > 10.0 { 1e8 } else { 1e9 }
    }

    fn from(&self, frame: Frame) -> (Vec<Entry>, Sorted) {
        let problem = self.problem;
        let entry = |class: u8, pose: Pose, vehicle: Option<usize>, words: &[String]| {
            let Pose { position_m: [x, y, z], yaw_rad } = frame.into_frame(pose);
            let coarse = |x: f64, steps: f64| (x * steps / COARSE).round() as i64;
            let [x, y, z] = [x, y, z].map(|x| coarse(x, frame.steps_per_m));
            let mut words = words.to_vec();
            words.sort_unstable();
            let kind = vehicle.map_or(0, |vehicle| self.rank.get(vehicle).copied().unwrap_or(vehicle));
            (class, [x, y, z, coarse(yaw_rad, 1.0 / STEP_RAD)], kind, words)
        };
        let robots: Vec<Entry> = problem
            .robots
            .iter()
            .map(|robot| entry(1, robot.start, Some(robot.vehicle), &robot.capabilities))
            .collect();
        let tools: Vec<Entry> =
            problem.tools.iter().map(|tool| entry(0, tool.pose, Some(tool.vehicle), &[])).collect();
        let slots: Vec<Entry> =
            problem.slots.iter().map(|slot| entry(2, slot.pose, None, &slot.requires)).collect();
        let sorted = |entries: &[Entry]| order(entries.len(), |k| entries[k].clone());
        let orders = (frame, sorted(&robots), sorted(&tools), sorted(&slots));
        (tools.into_iter().chain(robots).chain(slots).collect(), orders)
    }
}

/// Indices in the order of their keys.
fn order<K: Ord>(count: usize, key: impl FnMut(usize) -> K) -> Vec<usize> {
    let mut indices: Vec<usize> = (0..count).collect();
    let mut key = key;
    indices.sort_by_cached_key(|&index| key(index));
    indices
}

#[cfg(test)]
mod tests {
    use reconfiguration::problem::{Robot, Rules, Slot, Tool};
    use reconfiguration::vehicle::Vehicle;

    use super::*;

    /// T to I of the paper, without its tool if not asked for.
    fn t_to_i(tool: bool) -> Problem {
        let vehicles =
            ["bluerov1", "tool-20n"].map(|name| Vehicle::built_in(name).expect("built in")).to_vec();
        let starts = [[0.0, -0.33], [0.0, 0.33], [-0.483, 0.0], [-0.966, 0.0]];
        let pose = |[x, y]: [f64; 2]| Pose::from([x, y, 0.0, 0.0]);
        Problem {
            name: "t-to-i".to_owned(),
            description: String::new(),
            vehicles,
            robots: (1..)
                .zip(starts)
                .map(|(id, at)| Robot { id, vehicle: 0, start: pose(at), capabilities: Vec::new() })
                .collect(),
            tools: if tool { vec![Tool { vehicle: 1, pose: pose([0.0, 0.0]) }] } else { Vec::new() },
            slots: [0.483, 0.966, 1.449, 1.932]
                .map(|x| Slot { pose: pose([x, 0.0]), requires: Vec::new() })
                .to_vec(),
            rules: Rules::default(),
            bounds: None,
        }
    }

    fn placed(problem: &Problem, yaw_rad: f64, to_m: [f64; 3]) -> Problem {
        let place = |pose: Pose| {
            let arm = turned(pose.position_m, yaw_rad);
            let position_m = std::array::from_fn(|k| to_m[k] + arm[k]);
            Pose { position_m, yaw_rad: pose.yaw_rad + yaw_rad }
        };
        let mut problem = problem.clone();
        problem.robots.iter_mut().for_each(|robot| robot.start = place(robot.start));
        problem.tools.iter_mut().for_each(|tool| tool.pose = place(tool.pose));
        problem.slots.iter_mut().for_each(|slot| slot.pose = place(slot.pose));
        problem
    }

    #[test]
    fn a_problem_has_one_frame_wherever_it_is_and_however_it_is_listed() {
        for tool in [true, false] {
            let problem = t_to_i(tool);
            let expected = Framed::of(&problem).problem;
            for step in 0..24_u32 {
                let far = [999_990.0, -999_990.0, 20.0].map(|x| x * f64::from(step % 5) / 4.0);
                let mut other = placed(&problem, f64::from(step) * PI / 12.0, far);
                other.robots.rotate_left(step as usize % 4);
                other.slots.rotate_left(step as usize % 3);
                let framed = Framed::of(&other).problem;
                // To the last bit.
                assert_eq!(framed, expected, "step {step}, tool {tool}");
            }
        }
    }

    #[test]
    fn at_the_tool_a_file_keeps_its_numbers() {
        let framed = Framed::of(&t_to_i(true)).problem;
        let xs: Vec<f64> = framed.slots.iter().map(|slot| slot.pose.position_m[0]).collect();
        assert_eq!(xs, [0.483, 0.966, 1.449, 1.932]);
        assert_eq!(framed.robots.iter().map(|robot| robot.id).collect::<Vec<_>>(), [4, 3, 1, 2]);
    }

    #[test]
    fn corners_of_the_water_stay_where_they_are() {
        let mut problem = placed(&t_to_i(true), 0.5, [100.0, 200.0, 5.0]);
        problem.rules.bounds_m = Some([[98.0, 199.0, 4.0], [103.0, 202.0, 6.0]]);
        let Framed { water, frame, .. } = Framed::of(&problem);
        for (at, inside) in [
            ([98.3, 199.3, 5.0], true),
            ([98.1, 199.3, 5.0], false),
            ([102.7, 201.7, 5.0], true),
            ([102.7, 201.9, 5.0], false),
            ([100.0, 200.0, 5.95], false),
        ] {
            let seen = frame.into_frame(Pose { position_m: at, yaw_rad: 0.0 });
            let held = water.holds(seen.position_m, [0.25, 0.25, 0.1], seen.yaw_rad, 1e-6);
            assert_eq!(held, inside, "{at:?}");
        }
    }
}
