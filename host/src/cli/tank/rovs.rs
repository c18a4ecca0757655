//! ROVs in the laboratory in a box: firmware on sockets of their own, robots and tools in one water, connectors.
//!
//! As hands do, everything is held in its place until every robot has followed thrusts for [`HANDS_S`]. A robot whose connectors are
//! open lets go; one that is loose and whose connectors are closed takes hold in a slot that it is within the tolerance of.

use std::str::FromStr;

use link::udp::UdpRadio;
use pose::axes::{Pose, swap_world_and_ned};
use pose::frame::Label;
use pose::roster::{Entry, Name, Roster as Bodies};
use protocol::ModuleId;
use protocol::ModuleState;
use protocol::time::FleetInstant;
use reconfiguration::pose::Pose as Level;
use reconfiguration::problem::Problem;
use reconfiguration::vehicle::Vehicle;
use rov::dynamics::State;
use rov::power::PowerLaw;
use sim::mocap::MocapParameters;
use sim::module::TICK;
use sim::rov::{RovActuation, SimRov, Thrusters};

use super::super::module::{ROV_REPORTS, radio, resolve, setup};
use super::super::poses::{rov_bodies, rovs};
use super::super::real_time::Live;
use super::super::{Failure, bad, could, tell};
use super::{Arguments, axes, cameras, film, serve};
use crate::run::RunError;
use crate::run::closed_loop::World;
use crate::run::reconfigure::conductor::{Coupling, HAND_OVER_S};
use crate::run::reconfigure::scenario::{BUILT_IN, ReconfigureScenario};
use crate::run::reconfigure::water::{STEP_S, Water, is_step};

mod truth;

use truth::Truth;

/// What [`Execution`](crate::run::reconfigure::controller::Execution) waits before its plan begins, s.
const HANDS_S: f64 = 2.0 * HAND_OVER_S;

/// A thruster that fails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Dead {
    robot: u16,
    thruster: usize,
    at_s: f64,
}

impl FromStr for Dead {
    type Err = String;

    fn from_str(given: &str) -> Result<Self, String> {
        let read = || {
            let (what, at_s) = given.split_once('@')?;
            let (robot, thruster) = what.split_once(',')?;
            let dead = Self {
                robot: robot.parse().ok()?,
                thruster: thruster.parse().ok()?,
                at_s: at_s.parse().ok()?,
            };
            (dead.thruster > 0 && dead.at_s >= 0.0).then_some(dead)
        };
        read().ok_or_else(|| "it takes ROBOT,THRUSTER@SECONDS, such as 3,1@80".to_owned())
    }
}

/// Velocity of the water along x and y, m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Current([f64; 2]);

impl FromStr for Current {
    type Err = String;

    fn from_str(given: &str) -> Result<Self, String> {
        let numbers = given.split_once(',').map(|(x, y)| [x, y].map(|number| number.trim().parse::<f64>()));
        match numbers {
            Some([Ok(x), Ok(y)]) if x.abs() <= 10.0 && y.abs() <= 10.0 => Ok(Self([x, y])),
            _ => Err("it takes X,Y in m/s, each between -10 and 10, such as 0.05,0".to_owned()),
        }
    }
}

/// Whether a scenario is one of ROVs.
pub(super) fn is_meant(scenario: &str) -> bool {
    BUILT_IN.iter().any(|(name, _)| *name == scenario)
        || std::fs::read_to_string(scenario).is_ok_and(|text| text.contains("[[robot]]"))
}

pub(super) fn main(arguments: &Arguments) -> Result<(), Failure> {
    let scenario = ReconfigureScenario::open(&arguments.scenario).map_err(bad)?;
    let problem = &scenario.problem;
    let (roster, seats) = rovs(arguments.roster.as_deref(), problem)?;
    let bodies = rov_bodies(problem, &roster, &seats, false)?;
    let labels: Vec<Label> = bodies.entries().iter().map(label).collect();
    let mut robots = Robots::new(arguments, problem, &seats, bodies)?;
    let mut truth = arguments.out.as_deref().map(Truth::create).transpose()?;
    let server = serve(arguments, &labels)?;
    let mocap = MocapParameters { rate_hz: 100.0, ..MocapParameters::default() };
    let axes = axes(arguments, &scenario.pose);
    let mut cameras = cameras(arguments, &mocap, arguments.seed.unwrap_or(scenario.seed), axes, labels)?;
    tell(&format!("{} ROVs, host at {}", robots.rovs.len(), arguments.host));
    tell(&format!("motion capture on {}", server.address()));
    film(arguments, server, &mut cameras, |live| {
        let poses = robots.step(live)?;
        if let Some(truth) = &mut truth {
            truth.write(live.tick.now.0, &mut robots)?;
        }
        Ok(poses)
    })?;
    truth.map_or(Ok(()), |truth| truth.finish(&mut robots))
}

/// How the motion capture calls a body: by its number and its name, of which the roster may say one.
fn label(entry: &Entry) -> Label {
    match &entry.body {
        Name::Name(name) => Label::new(i32::from(entry.module), name),
        Name::Number(number) => Label::new(*number, &format!("module-{}", entry.module)),
    }
}

/// Robots and tools in one water.
struct Robots {
    ids: Vec<u16>,
    rovs: Vec<SimRov<UdpRadio>>,
    actuation: Vec<RovActuation>,
    water: Water,
    /// Bodies of the motion capture on robots, then on tools.
    bodies: Bodies,
    /// What was told meanwhile, and of which robot, for a log.
    happened: Vec<(u16, String)>,
    docked: Vec<bool>,
    /// Which robots have taken hold in a slot.
    arrived: Vec<bool>,
    /// Where robots may take hold.
    slots: Vec<Level>,
    dead: Option<(usize, usize, f64)>,
    law: PowerLaw,
    energy_j: f64,
    /// Since when all follow thrusts, and since when nothing holds them, s.
    following_s: Option<f64>,
    released_s: Option<f64>,
    stepped: u64,
}

impl Robots {
    fn new(
        arguments: &Arguments,
        problem: &Problem,
        seats: &[ModuleId],
        mounted: Bodies,
    ) -> Result<Self, Failure> {
        let host = resolve(&arguments.host)?;
        let vehicle = |kind: usize| {
            problem.vehicles.get(kind).ok_or_else(|| Failure::Bad("a vehicle is missing".to_owned()))
        };
        let (mut rovs, mut bodies): (Vec<_>, Vec<(Level, &Vehicle)>) = (Vec::new(), Vec::new());
        for (robot, number) in problem.robots.iter().zip(seats) {
            let vehicle = vehicle(robot.vehicle)?;
            bodies.push((robot.start, vehicle));
            let setup = setup(arguments.key.as_deref(), number.0, ROV_REPORTS)?;
            let reversed: Vec<bool> = vehicle.thrusters.iter().map(|thruster| thruster.reversed).collect();
            let thrusters = Thrusters::new(&reversed, problem.rules.battery_v).map_err(bad)?;
            rovs.push(SimRov::new(&setup, thrusters, radio(None, host)?, host).map_err(bad)?);
        }
        for tool in &problem.tools {
            bodies.push((tool.pose, vehicle(tool.vehicle)?));
        }
        let mut water = Water::new(&bodies).map_err(bad)?;
        if let Some(Current([x, y])) = arguments.current {
            water.set_current([x, y, 0.0]);
        }
        let ids: Vec<u16> = problem.robots.iter().map(|robot| robot.id).collect();
        let dead = arguments.fail_thruster.map(|Dead { robot, thruster, at_s }| {
            let place = ids.iter().position(|id| *id == robot);
            let place = place.filter(|&place| thruster <= bodies[place].1.thrusters.len());
            let place = place.ok_or_else(|| {
                Failure::Bad(format!("--fail-thruster {robot},{thruster}: there is no such thruster"))
            })?;
            Ok((place, thruster - 1, at_s))
        });
        Ok(Self {
            actuation: vec![RovActuation::default(); rovs.len()],
            docked: vec![true; rovs.len()],
            arrived: vec![false; rovs.len()],
            slots: problem.slots.iter().map(|slot| slot.pose).collect(),
            dead: dead.transpose()?,
            law: arguments.power.law(problem.rules.battery_v).map_err(bad)?,
            energy_j: 0.0,
            bodies: mounted,
            happened: Vec::new(),
            following_s: None,
            released_s: None,
            stepped: 0,
            ids,
            rovs,
            water,
        })
    }

    /// One tick; where everything is then in the cameras' world.
    fn step(&mut self, live: &Live) -> Result<Vec<Pose>, Failure> {
        let now = live.tick.now;
        let tick_s = now.as_secs_f64();
        for (rov, actuation) in self.rovs.iter_mut().zip(&mut self.actuation) {
            rov.live(now, live.hears).map_err(could)?;
            rov.actuate(actuation);
        }
        self.stepped += 1;
        let ticked = FleetInstant(self.stepped * u64::from(TICK.0));
        if is_step(ticked) {
            self.let_go(now, tick_s);
            if let Some(released_s) = self.released_s {
                self.water.step(ticked, true, &self.actuation);
                self.flow(now, tick_s - released_s).map_err(could)?;
            }
        }
        let ned = |state: &State| Pose { position: state.position_m, attitude: state.attitude };
        let states = self.water.states().iter().zip(self.bodies.entries());
        Ok(states.map(|(state, entry)| swap_world_and_ned(&entry.body_of_vehicle(&ned(state)))).collect())
    }

    /// Tells a person, and the log.
    fn say(&mut self, robot: u16, text: String) {
        tell(&text);
        self.happened.push((robot, text));
    }

    /// Hands that hold everything let go when all robots follow thrusts.
    fn let_go(&mut self, now: FleetInstant, tick_s: f64) {
        if self.released_s.is_some() {
            return;
        }
        let follow = self.rovs.iter().all(|rov| rov.state(now) == Some(ModuleState::Executing));
        let since_s = if follow { *self.following_s.get_or_insert(tick_s) } else { tick_s };
        if !follow {
            self.following_s = None;
        } else if tick_s - since_s >= HANDS_S {
            self.released_s = Some(tick_s);
            self.say(0, format!("{tick_s:.1} s: the water lets go"));
        }
    }

    /// What has come of a step of the water, which ends `t_s` after it has let go.
    fn flow(&mut self, now: FleetInstant, t_s: f64) -> Result<(), RunError> {
        if let Some((robot, thruster, at_s)) = self.dead
            && t_s >= at_s
        {
            self.rovs[robot].set_failed(thruster);
            self.dead = None;
            let id = self.ids[robot];
            self.say(id, format!("{t_s:.1} s: thruster {} of robot {id} fails", thruster + 1));
        }
        let thrusts = self.actuation.iter().flat_map(|actuation| &actuation.thrusts_n);
        self.energy_j += STEP_S * thrusts.map(|&thrust_n| self.law.power_w(thrust_n)).sum::<f64>();
        for robot in 0..self.rovs.len() {
            let open = self.rovs[robot].is_open(now);
            if self.docked[robot] && open {
                self.water.couple(Coupling::Undock(robot))?;
                self.docked[robot] = false;
                let id = self.ids[robot];
                self.say(id, format!("{t_s:.1} s: robot {id} lets go"));
            } else if !self.docked[robot] && !open {
                for &slot in &self.slots {
                    if self.water.couple(Coupling::Dock(robot, slot))?.is_some() {
                        (self.docked[robot], self.arrived[robot]) = (true, true);
                        break;
                    }
                }
                let Some(misfit) = self.water.drawn_in().filter(|_| self.docked[robot]) else { continue };
                let (id, off_mm, off_deg) =
                    (self.ids[robot], misfit.position_m * 1e3, misfit.angle_rad.to_degrees());
                let drawn = format!("{:.1} J drawn so far", self.energy_j);
                self.say(
                    id,
                    format!(
                        "{t_s:.1} s: robot {id} takes hold, {off_mm:.1} mm and {off_deg:.2}° off; {drawn}"
                    ),
                );
            }
        }
        Ok(())
    }
}
