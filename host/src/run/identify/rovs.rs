//! From a log of ROVs to what their constants are identified from: swims of robots that are docked to nothing.
//!
//! A robot has let go where it is [`CLEAR_M`] from where its move began, and takes hold within as much of where that ends. Poses are those of
//! the motion capture (`/sighting`), where the log has any, else those of the simulation (`/robots`); thrusts are what its propellers gave by
//! their law.

use std::collections::BTreeMap;

use identify::rov::data::{Pose, Recording, Swim, Thrusts};
use reconfiguration::vehicle::Vehicle;
use runlog::flotilla::{Robots, Sighting};
use runlog::reader::{Entry, LogError};

use super::super::log::instant;
use super::super::log::rovs::Document;

/// So far from a slot a robot is docked to nothing, m. *Assumed*: connectors draw in from a third of that.
const CLEAR_M: f64 = 0.06;
/// Two sets of robots further apart than this are of two swims, s.
const PAUSE_S: f64 = 0.3;
/// Thrusts are kept for this time before and after a swim, s: they are felt later, or poses are stamped so.
const AROUND_S: f64 = 0.5;

/// What robots of one kind did in a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Kind {
    /// As the problem has it.
    pub vehicle: Vehicle,
    /// Their swims.
    pub recording: Recording,
}

/// One robot at one instant.
#[derive(Clone, Debug)]
struct Seen {
    t_s: f64,
    eta: [f64; 6],
    thrusts_n: Vec<f64>,
    moves: bool,
}

/// What is taken of a log of ROVs.
#[derive(Default)]
pub(super) struct Taken {
    seen: BTreeMap<u16, Vec<Seen>>,
    sighted: BTreeMap<u16, Vec<Pose>>,
}

fn pose(t_s: f64, eta: &[f64; 6]) -> Pose {
    let [n, e, d, roll, pitch, yaw] = *eta;
    Pose { t_s, position_m: [n, e, d], attitude_rad: [roll, pitch, yaw] }
}

impl Taken {
    pub(super) fn take(&mut self, entry: &Entry<'_>) -> Result<(), LogError> {
        match entry.topic {
            "/robots" => {
                let robots: Robots = entry.read()?;
                let t_s = instant(&robots.stamp).as_secs_f64();
                for robot in robots.robots {
                    let moves = robot.reference.is_some();
                    let seen = Seen { t_s, eta: robot.eta, thrusts_n: robot.thrusts_n, moves };
                    self.seen.entry(robot.id).or_default().push(seen);
                }
            }
            "/sighting" => {
                let sighting: Sighting = entry.read()?;
                for robot in &sighting.robots {
                    let poses = self.sighted.entry(robot.id).or_default();
                    poses.push(pose(sighting.captured_s, &robot.eta));
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Swims of the robots of each kind in `document`.
    pub(super) fn finish(&self, name: &str, document: &Document) -> Vec<Kind> {
        let mut kinds: Vec<Kind> = Vec::new();
        for robot in &document.problem.robots {
            let seen = self.seen.get(&robot.id).map_or(&[][..], Vec::as_slice);
            let swims = swims(seen).map(|around| self.swim(robot.id, seen, around));
            let Some(vehicle) = document.problem.vehicles.get(robot.vehicle) else { continue };
            let kind = kinds.iter_mut().find(|kind| kind.vehicle == *vehicle);
            match kind {
                Some(kind) => kind.recording.swims.extend(swims),
                None => kinds.push(Kind {
                    vehicle: vehicle.clone(),
                    recording: Recording { name: name.to_owned(), swims: swims.collect() },
                }),
            }
        }
        kinds
    }

    fn swim(&self, robot: u16, seen: &[Seen], [from_s, to_s]: [f64; 2]) -> Swim {
        let within = |t_s: f64, around_s: f64| (from_s - around_s..=to_s + around_s).contains(&t_s);
        let known = seen.iter().filter(|seen| within(seen.t_s, AROUND_S));
        let thrusts = known.map(|seen| Thrusts { t_s: seen.t_s, thrusts_n: seen.thrusts_n.clone() });
        let poses = match self.sighted.get(&robot) {
            Some(poses) => poses.iter().filter(|pose| within(pose.t_s, 0.0)).copied().collect(),
            None => {
                let exact = seen.iter().filter(|seen| within(seen.t_s, 0.0));
                exact.map(|seen| pose(seen.t_s, &seen.eta)).collect()
            }
        };
        Swim { robot, poses, thrusts: thrusts.collect() }
    }
}

/// When each swim begins and ends, s.
fn swims(seen: &[Seen]) -> impl Iterator<Item = [f64; 2]> {
    let moves = seen.chunk_by(|a, b| a.moves == b.moves && b.t_s - a.t_s < PAUSE_S);
    moves.filter(|of| of.first().is_some_and(|first| first.moves)).filter_map(|of| {
        let (first, last) = (of.first()?, of.last()?);
        let far = |from: &Seen, other: &Seen| {
            let squares = (0..3).map(|axis| (from.eta[axis] - other.eta[axis]).powi(2));
            squares.sum::<f64>() > CLEAR_M * CLEAR_M
        };
        let begin = of.iter().find(|seen| far(first, seen))?;
        let end = of.iter().rfind(|seen| far(last, seen))?;
        (begin.t_s < end.t_s).then_some([begin.t_s, end.t_s])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_swim_is_what_lies_clear_of_both_slots() {
        let at = |n: u32, x_m: f64, moves: bool| Seen {
            t_s: 0.05 * f64::from(n),
            eta: [x_m, 0.0, 0.0, 0.0, 0.0, 0.0],
            thrusts_n: vec![1.0],
            moves,
        };
        // 1 m at 0.2 m/s, with a rest before and after; then another robot's move.
        let moved = |n: u32| at(n, (0.01 * (f64::from(n) - 20.0)).clamp(0.0, 1.0), (10..140).contains(&n));
        let seen: Vec<Seen> = (0..200).map(moved).collect();
        let found: Vec<[f64; 2]> = swims(&seen).collect();
        assert_eq!(found.len(), 1);
        let [from_s, to_s] = found[0];
        assert!((from_s - 1.35).abs() < 0.051 && (to_s - 5.65).abs() < 0.051, "{found:?}");
        assert!(swims(&seen[..12]).next().is_none(), "it has not let go");
    }
}
