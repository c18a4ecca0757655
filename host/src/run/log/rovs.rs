//! The log of an executed reconfiguration: what is told and shown after each step of the closed loop. Answers are not: robots answer
//! twenty times a second.
//!
//! | topics | how often |
//! |---|---|
//! | `/robots`, `/tf` | 20 Hz of the plan's time |
//! | `/sighting` | 50 Hz at most, of the fixes of a motion capture |
//! | odometry of each, for others' tools | 10 Hz |
//! | `/markers` | 5 Hz |
//! | `/status` | 5 Hz, and at once when something changes |
//! | `/order` | as they come |
//! | counts, `/moves`, `/pauses`, `/diagnostics`, batteries | 1 Hz, and at the end |

use std::cell::RefCell;

use nalgebra::Vector6;
use protocol::time::{Duration, FleetInstant};
use reconfiguration::plan::Plan;
use reconfiguration::pose::Pose;
use reconfiguration::problem::Problem;
use reconfiguration::vehicle::Vehicle;
use rov::configuration_matrix::{ConfigurationMatrix, ThrusterError};
use rov::dynamics::State;
use runlog::flotilla;
use serde::{Deserialize, Serialize};
use sim::rov::RovActuation;

use super::super::RunError;
use super::super::closed_loop::{Ending, Observer, Run};
use super::super::fleet::Fleet;
use super::super::host::Controller;
use super::super::pose_source::PoseSource;
use super::super::reconfigure::accounts::Accounts;
use super::super::reconfigure::conductor::PERIOD;
use super::super::reconfigure::controller::Execution;
use super::super::reconfigure::estimator::Sighting;
use super::super::reconfigure::water::{ExactPoses, STEP, STEP_S, Water, is_step};
use super::super::watch::Watch;
use super::shown::modules;
use super::shown::rovs::Scene;
use super::standing::{Standing, order};
use super::topics::{Shown, Told};
use super::{Log, counts, stamp};

pub use reading::{Outcome, Reading};

mod reading;

/// Fixes that come sooner after the last one that was written are left out, s.
const SIGHTED_EVERY_S: f64 = 0.019;
/// Pause between two sets of counts.
const COUNTS_EVERY: Duration = Duration(1_000_000);
/// Every so manyth set of robots is written in others' form too: most of it is covariances.
const REPEATED: u32 = 2;
/// Every so manyth set of robots is drawn.
const DRAWN: u32 = 4;

/// The closed loop of a reconfiguration with the fleet `F`.
pub type RovRun<'a, 'p, F, P = ExactPoses> = Run<'a, Execution<'p>, F, Water, P>;

/// What an execution is called beside others of the same problem.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Title {
    /// In tables and names of files.
    pub name: String,
    /// Which of them it is, from 0.
    pub index: usize,
}

/// What is kept of what was asked, as JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Document {
    /// What it is called.
    pub title: Title,
    /// What was asked.
    pub problem: Problem,
    /// What was planned.
    pub plan: Plan,
}

impl Document {
    /// The first message of its log.
    #[must_use]
    pub fn head(&self, seed: u64) -> flotilla::Scenario {
        let ids = self.problem.robots.iter().map(|robot| robot.id).collect();
        // Numbers and texts have a form in JSON.
        let document = serde_json::to_string(self).unwrap_or_default();
        super::head("rovs", &self.problem.name, seed, ids, document)
    }
}

/// See the module's documentation.
pub struct RovLog<'a> {
    log: Log,
    reading: Reading,
    watch: Watch,
    scene: Scene,
    ids: Vec<u16>,
    /// What was said to a person meanwhile.
    notes: &'a RefCell<Vec<String>>,
    accounts: Accounts,
    /// Of robots, then tools.
    vehicles: Vec<&'a Vehicle>,
    /// Of robots, about their own origins.
    matrices: Vec<ConfigurationMatrix>,
    /// The beginning of the next step, whose thrusts are not known yet.
    open: Option<flotilla::Robots>,
    sampled_s: Option<f64>,
    sighted_s: f64,
    samples: u32,
    /// The moves that were under way when the step began, with their robots.
    moving: Vec<(usize, usize)>,
    counted: Option<FleetInstant>,
    standing: Standing,
    /// Why the plan waited for want of poses, and for how long.
    troubles: Vec<flotilla::Trouble>,
}

impl<'a> RovLog<'a> {
    /// Of the execution of `document` from `seed`, with these bodies, robots first.
    ///
    /// # Errors
    /// [`ThrusterError`] for a robot whose thrusters cannot be.
    pub fn new(
        mut log: Log,
        document: Document,
        seed: u64,
        accounts: Accounts,
        bodies: &[(Pose, &'a Vehicle)],
        notes: &'a RefCell<Vec<String>>,
    ) -> Result<Self, ThrusterError> {
        let head = document.head(seed);
        let robots = head.modules.len();
        let vehicles: Vec<&Vehicle> = bodies.iter().map(|(_, vehicle)| *vehicle).collect();
        let matrices = vehicles.iter().take(robots).map(|vehicle| ConfigurationMatrix::of_vehicle(vehicle));
        let matrices = matrices.collect::<Result<_, _>>()?;
        let scene = Scene::new(bodies, &head.modules);
        log.tell(FleetInstant(0), Told::Scenario(&head));
        log.show(FleetInstant(0), Shown::Fixed(&scene.fixed()));
        Ok(Self {
            log,
            reading: Reading::new(document, seed),
            watch: Watch::new(vec![f64::INFINITY]),
            scene,
            ids: head.modules,
            notes,
            accounts,
            vehicles,
            matrices,
            open: None,
            sampled_s: None,
            sighted_s: f64::NEG_INFINITY,
            samples: 0,
            moving: Vec::new(),
            counted: None,
            standing: Standing::default(),
            troubles: Vec::new(),
        })
    }

    fn tell(&mut self, now: FleetInstant, told: Told<'_>) {
        self.reading.take(told);
        self.log.tell(now, told);
    }

    /// Tells the end. What became of the execution, and of its log. The last sample is of the end, whenever that was.
    ///
    /// # Errors
    /// As for [`Reading::finish`].
    pub fn finish<F: Fleet<Actuation = RovActuation>, P: PoseSource<Water>>(
        mut self,
        ending: &Ending,
        run: &RovRun<'_, '_, F, P>,
    ) -> Result<(Outcome, Option<String>), String> {
        let now = ending.at;
        self.events(now);
        self.close(now);
        let t_s = plan_time_s(now, run);
        if self.sampled_s.is_none_or(|last_s| last_s < t_s) {
            self.open = self.sample(now, t_s, run);
            self.close(now);
        }
        self.count(now, run);
        let end = flotilla::End { stamp: stamp(now), why: ending.why.clone(), wall_s: ending.wall_s };
        self.tell(now, Told::End(&end));
        Ok((self.reading.finish()?, self.log.finish()))
    }

    fn events(&mut self, now: FleetInstant) {
        for text in self.notes.take() {
            self.log.show(now, Shown::Event(&flotilla::Event { stamp: stamp(now), module: 0, text }));
        }
    }

    /// How the run stands.
    fn stand<F: Fleet, P>(&mut self, now: FleetInstant, run: &RovRun<'_, '_, F, P>) {
        for ordered in &run.ordered {
            self.tell(now, Told::Order(&order(ordered)));
        }
        if self.log.is_kept()
            && let Some(status) = self.standing.status(now, run, &self.ids, |_| {}, |_| {})
        {
            self.log.show(now, Shown::Status(status));
        }
    }

    fn sample<F: Fleet<Actuation = RovActuation>, P>(
        &mut self,
        now: FleetInstant,
        t_s: f64,
        run: &RovRun<'_, '_, F, P>,
    ) -> Option<flotilla::Robots> {
        let (conductor, water) = (run.host.controller.conductor(), run.world.as_ref());
        // What is held true, where the water is real.
        let states = water.map_or_else(|| run.host.controller.states(), Water::states);
        if states.len() < self.vehicles.len() {
            return None;
        }
        let followed = conductor.followed();
        self.accounts.look(&followed, states, &self.vehicles);
        let robots = self.ids.iter().enumerate().map(|(robot, &id)| flotilla::Robot {
            id,
            eta: states[robot].eta(),
            nu: states[robot].nu.into(),
            reference: followed
                .iter()
                .find(|followed| followed.robot == robot)
                .and_then(|followed| followed.reference)
                .map(|reference| place(&reference.pose)),
            arrived: conductor.arrived()[robot],
            ..flotilla::Robot::default()
        });
        let robots: Vec<flotilla::Robot> = robots.collect();
        let tool = (robots.len() < states.len()).then_some(robots.len());
        self.sampled_s = Some(t_s);
        let mut sample = flotilla::Robots {
            stamp: stamp(now),
            t_s,
            moving: conductor.moving().map_or(-1, |moving| moving as i32),
            restoring_nm: tool.zip(water).map_or([0.0; 2], |(tool, water)| water.restoring_nm(tool)),
            robots,
        };
        self.note_thrusts(&mut sample, &run.actuation);
        Some(sample)
    }

    /// What robots do.
    fn note_thrusts(&self, sample: &mut flotilla::Robots, actuation: &[RovActuation]) {
        for ((robot, matrix), RovActuation { thrusts_n, pulses_us }) in
            sample.robots.iter_mut().zip(&self.matrices).zip(actuation)
        {
            (robot.tau, robot.power_w) = (matrix.wrench(thrusts_n), self.accounts.power_w(thrusts_n));
            robot.thrusts_n.clone_from(thrusts_n);
            robot.pulses_us.clone_from(pulses_us);
        }
    }

    /// Tells the sample whose thrusts are known now.
    fn close(&mut self, now: FleetInstant) {
        let Some(sample) = self.open.take() else { return };
        self.tell(now, Told::Robots(&sample));
        if self.log.is_kept() {
            self.log.show(now, Shown::Transforms(&self.scene.transforms(&sample)));
            if self.samples.is_multiple_of(REPEATED) {
                for (place, robot) in sample.robots.iter().enumerate() {
                    self.log.odometry(now, place, robot.id, self.scene.odometry(&sample.stamp, robot));
                }
            }
            if self.samples.is_multiple_of(DRAWN) {
                self.log.show(now, Shown::Markers(self.scene.markers(&sample)));
            }
        }
        self.samples += 1;
    }

    /// Everything that is counted, so far.
    fn count<F: Fleet<Actuation = RovActuation>, P: PoseSource<Water>>(
        &mut self,
        now: FleetInstant,
        run: &RovRun<'_, '_, F, P>,
    ) {
        self.counted = Some(now);
        let links = run.host.dispatcher();
        self.tell(now, Told::Links(&counts::links(stamp(now), &self.ids, links)));
        let ledger = flotilla::Ledger {
            stamp: stamp(now),
            strays: counts::incoming(links.strays()),
            medium: run.fleet.faults().as_ref().map(counts::medium),
            ..flotilla::Ledger::default()
        };
        self.tell(now, Told::Ledger(&ledger));
        if let Some(account) = run.poses.account() {
            self.tell(now, Told::Poses(&counts::poses(stamp(now), &account, &self.troubles)));
        }
        let (legs, absences, holds) = counts::legs(stamp(now), self.watch.legs());
        self.tell(now, Told::Legs(&legs));
        self.tell(now, Told::Absences(&absences));
        if let Some(holds) = holds {
            self.tell(now, Told::Holds(&holds));
        }
        let moves =
            flotilla::Moves { stamp: stamp(now), moves: self.accounts.moves().map(reading::told).collect() };
        self.tell(now, Told::Moves(&moves));
        let dead = run.host.controller.failed_thrusters();
        if !dead.is_empty() {
            let told = flotilla::DeadThrusters {
                stamp: stamp(now),
                robot: dead.iter().map(|(robot, ..)| self.ids[*robot]).collect(),
                thruster: dead.iter().map(|(_, thruster, _)| *thruster as u16 + 1).collect(),
                at_s: dead.iter().map(|(.., at_s)| *at_s).collect(),
            };
            self.tell(now, Told::DeadThrusters(&told));
        }
        let (start_s, length_s) = run.host.controller.gaps().iter().copied().unzip();
        self.tell(now, Told::Pauses(&flotilla::Pauses { stamp: stamp(now), start_s, length_s }));
        if self.log.is_kept() {
            self.log.show(now, Shown::Diagnostics(&modules::diagnostics(now, &self.ids, links)));
            for (place, (link, &id)) in links.modules().iter().zip(&self.ids).enumerate() {
                self.log.battery(now, place, id, &modules::battery(now, id, link));
            }
        }
    }
}

/// Time since the water let go, in whole steps, s; 0 before.
fn plan_time_s<F: Fleet, P>(now: FleetInstant, run: &RovRun<'_, '_, F, P>) -> f64 {
    let since_us = run.host.controller.origin().map_or(0, |origin| now.0.saturating_sub(origin.0));
    (since_us / u64::from(STEP.0)) as f64 * STEP_S
}

fn place(pose: &Pose) -> flotilla::Place {
    let [x_m, y_m, z_m, yaw_rad] = <[f64; 4]>::from(*pose);
    flotilla::Place { x_m, y_m, z_m, yaw_rad }
}

impl<F: Fleet<Actuation = RovActuation>, P: PoseSource<Water>> Observer<RovRun<'_, '_, F, P>> for RovLog<'_> {
    fn observe(&mut self, now: FleetInstant, run: &RovRun<'_, '_, F, P>) -> Result<(), RunError> {
        self.events(now);
        self.stand(now, run);
        self.sight(now, run.host.controller.sighting());
        self.step(now, run);
        self.watch.observe(now, run)?;
        let controller = &run.host.controller;
        if let Some(text) =
            run.poses.trouble().filter(|_| controller.origin().is_some() && !controller.gets_on())
        {
            counts::suffer(&mut self.troubles, text);
        }
        let is_due = self.counted.is_none_or(|counted| now.since(counted) >= COUNTS_EVERY);
        if is_due && self.log.is_kept() {
            self.count(now, run);
        }
        Ok(())
    }
}

impl RovLog<'_> {
    /// Where a motion capture shows the robots.
    fn sight(&mut self, now: FleetInstant, sighting: Option<&Sighting>) {
        let is_due = |sighting: &&Sighting| sighting.at_s - self.sighted_s >= SIGHTED_EVERY_S;
        let Some(sighting) = sighting.filter(is_due).filter(|_| self.log.is_kept()) else { return };
        self.sighted_s = sighting.at_s;
        let seen = self.ids.iter().zip(&sighting.bodies).filter_map(|(&id, body)| {
            let (position_m, attitude) = body.as_ref()?;
            let state = State { position_m: *position_m, attitude: *attitude, nu: Vector6::zeros() };
            Some(flotilla::Sighted { id, eta: state.eta() })
        });
        let (stamp, captured_s) = (stamp(now), sighting.at_s);
        let sighting = flotilla::Sighting { stamp, captured_s, robots: seen.collect() };
        self.log.show(now, Shown::Sighting(&sighting));
    }

    fn step<F: Fleet<Actuation = RovActuation>, P>(&mut self, now: FleetInstant, run: &RovRun<'_, '_, F, P>) {
        let controller = &run.host.controller;
        let Some(origin) = controller.origin().filter(|_| is_step(now)) else { return };
        if run.is_blind() {
            return;
        }
        let conductor = controller.conductor();
        if let Some(mut sample) = self.open.take() {
            self.note_thrusts(&mut sample, &run.actuation);
            self.open = Some(sample);
            self.close(now);
        }
        if now > origin && !self.moving.is_empty() {
            self.accounts.spend(STEP_S, &self.moving, &run.actuation);
            let drawn_in = match &run.world {
                Some(water) => water.drawn_in(),
                None => controller.drawn_in(),
            };
            for &(number, _) in &self.moving {
                let ended = conductor.under_way().all(|(still, _)| still != number);
                if ended && let Some(misfit) = drawn_in {
                    self.accounts.end(number, misfit);
                }
            }
        }
        self.moving.clear();
        self.moving.extend(conductor.under_way());
        if now >= origin && (now.0 - origin.0).is_multiple_of(u64::from(PERIOD.0)) {
            self.open = self.sample(now, plan_time_s(now, run), run);
        }
    }
}
