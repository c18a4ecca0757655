//! The log of a run of Modboats: what is told and shown after each step of the closed loop.
//!
//! | topics | how often |
//! |---|---|
//! | `/truth/state`, `/estimate/state`, `/tf` | 20 Hz, from the start of the first cycle on |
//! | odometry, for others' tools | 10 Hz, the same: most of it is covariances |
//! | `/tails` | 50 Hz, the same |
//! | `/markers` | tails 5 Hz, bodies 1 Hz |
//! | `/fix`, `/acknowledgement`, `/event`, `/gap`, `/decision`, `/cycle` | as they come |
//! | `/status`, `/bodies` | 5 Hz, the first at once when something changes |
//! | `/goal`, `/order` | when they change, as they come |
//! | counts, `/contact`, `/diagnostics`, batteries, `/target` | 1 Hz, and at the end |

use std::cell::RefCell;

use link::dispatcher::DispatcherEvent;
use modboat::motion::Wrench;
use protocol::time::{Duration, FleetInstant};
use record::PoseSample;
use runlog::{flotilla, ros};
use sim::TailState;
use sim::module::TICK;
use sim::tank::Tank;

use super::super::RunError;
use super::super::boats::BoatRun;
use super::super::closed_loop::{Ending, Observer};
use super::super::fleet::Fleet;
use super::super::host::Controller;
use super::super::pilot::Decision;
use super::super::pose_source::PoseSource;
use super::super::scenario::Scenario;
use super::super::watch::{Watch, worded};
use super::shown::boats::Scene;
use super::shown::modules;
use super::standing::Standing;
use super::topics::{Shown, Told};
use super::{Log, counts, stamp};

use messages::{message, state, wrench};

pub use messages::head;
pub use reading::{Outcome, Reading};

mod messages;
mod reading;
mod standing;

/// Seconds between two poses: 20 Hz.
pub const POSE_EVERY_S: f64 = 0.05;
/// Seconds between two sets of tails: 50 Hz.
const TAILS_EVERY_S: f64 = 0.02;
/// Seconds between two of others' forms of the pose.
const ODOMETRY_EVERY_S: f64 = 0.1;
/// Seconds between two drawings of the tails.
const TAILS_DRAWN_EVERY_S: f64 = 0.2;
/// Pause between two sets of counts.
const COUNTS_EVERY: Duration = Duration(1_000_000);

/// Impulse of the tails on the water over one swim cycle.
#[derive(Clone, Copy, Debug, Default)]
struct Impulse {
    sum: Wrench,
    time_s: f64,
}

/// What can still change in a decision.
type Form = (FleetInstant, Duration, Duration, bool);

/// Instants at regular distances.
#[derive(Clone, Copy, Debug)]
struct Beat {
    every_s: f64,
    last_s: Option<f64>,
}

impl Beat {
    const fn new(every_s: f64) -> Self {
        Self { every_s, last_s: None }
    }

    /// Whether one is due.
    fn is_due(&mut self, t_s: f64) -> bool {
        let due = self.last_s.is_none_or(|last_s| t_s >= last_s + self.every_s - 1e-9);
        if due {
            self.last_s = Some(t_s);
        }
        due
    }
}

/// See the module's documentation.
pub struct BoatLog<'a> {
    log: Log,
    reading: Reading,
    watch: Watch,
    scene: Scene,
    ids: Vec<u16>,
    /// What was said to a person meanwhile.
    notes: &'a RefCell<Vec<String>>,
    origin: Option<FleetInstant>,
    poses: Beat,
    odometry: Beat,
    tails: Beat,
    markers: Beat,
    /// Used again for each message.
    joints: ros::JointState,
    fix_s: Option<f64>,
    impulses: Vec<Impulse>,
    /// By decision: as it was told last.
    told: Vec<Form>,
    /// How many cycles were told.
    closed: usize,
    /// How many gaps were told.
    gaps: usize,
    /// By contact: the overlap that was told.
    contacts: Vec<f64>,
    /// Why there were no poses, and for how long the fleet held for it.
    troubles: Vec<flotilla::Trouble>,
    clock_error_us: Option<u64>,
    counted: Option<FleetInstant>,
    standing: Standing,
    /// Of the goal that was told last: its leg or target, and how often there was another.
    steered: Option<(Option<usize>, (usize, usize))>,
}

impl<'a> BoatLog<'a> {
    /// Of a run of `scenario` from `seed`, with these modules; `head` is the first message.
    #[must_use]
    pub fn new(
        mut log: Log,
        scenario: &Scenario,
        head: &flotilla::Scenario,
        notes: &'a RefCell<Vec<String>>,
    ) -> Self {
        let now = FleetInstant(0);
        log.tell(now, Told::Scenario(head));
        let mut end_s = 0.0;
        let ends_s = scenario.legs.iter().map(|leg| {
            end_s += leg.duration_s;
            end_s
        });
        let scene = Scene::new(scenario, &head.modules);
        log.show(now, Shown::Fixed(&scene.fixed()));
        let name = head.modules.iter().map(|id| format!("tail_{id}"));
        let header = ros::Header { frame_id: "structure".to_owned(), ..ros::Header::default() };
        Self {
            reading: Reading::new(scenario, head.seed, &head.modules),
            watch: Watch::new(ends_s.collect()),
            scene,
            ids: head.modules.clone(),
            notes,
            origin: None,
            poses: Beat::new(POSE_EVERY_S),
            odometry: Beat::new(ODOMETRY_EVERY_S),
            tails: Beat::new(TAILS_EVERY_S),
            markers: Beat::new(TAILS_DRAWN_EVERY_S),
            joints: ros::JointState { header, name: name.collect(), ..ros::JointState::default() },
            fix_s: None,
            impulses: Vec::new(),
            told: Vec::new(),
            closed: 0,
            gaps: 0,
            contacts: Vec::new(),
            troubles: Vec::new(),
            clock_error_us: None,
            counted: None,
            standing: Standing::default(),
            steered: None,
            log,
        }
    }

    fn tell(&mut self, now: FleetInstant, told: Told<'_>) {
        self.reading.take(told);
        self.log.tell(now, told);
    }

    /// Tells the end. What became of the run, and of its log.
    ///
    /// # Errors
    /// As for [`Reading::finish`].
    pub fn finish<F: Fleet<Actuation = TailState>, P: PoseSource<Tank>>(
        mut self,
        ending: &Ending,
        run: &BoatRun<'_, F, P>,
    ) -> Result<(Outcome, Option<String>), String> {
        let now = ending.at;
        self.happenings(now, run);
        self.decisions(now, run.host.controller.decisions());
        self.close(now, run.host.controller.decisions(), |_| true);
        self.tell_gaps(now, run, run.gaps.len());
        self.count(now, run);
        let end = flotilla::End { stamp: stamp(now), why: ending.why.clone(), wall_s: ending.wall_s };
        self.tell(now, Told::End(&end));
        Ok((self.reading.finish()?, self.log.finish()))
    }

    /// What modules answered, and what was said.
    fn happenings<F: Fleet, P>(&mut self, now: FleetInstant, run: &BoatRun<'_, F, P>) {
        for text in self.notes.take() {
            self.log.show(now, Shown::Event(&flotilla::Event { stamp: stamp(now), module: 0, text }));
        }
        if !self.log.is_kept() {
            return;
        }
        for &(at, event) in run.host.events() {
            let id = |module: usize| self.ids.get(module).copied().unwrap_or_default();
            let answer = |module, cycle, reason: Option<&str>| flotilla::Acknowledgement {
                stamp: stamp(at),
                module: id(module),
                cycle,
                accepted: reason.is_none(),
                reason: reason.unwrap_or_default().to_owned(),
            };
            let (module, text) = match event {
                DispatcherEvent::Accepted { module, cycle } => {
                    self.log.show(now, Shown::Acknowledgement(&answer(module, cycle, None)));
                    continue;
                }
                DispatcherEvent::Refused { module, cycle, reason } => {
                    let answer = answer(module, cycle, Some(worded(reason)));
                    self.log.show(now, Shown::Acknowledgement(&answer));
                    continue;
                }
                DispatcherEvent::Joined(module) => (module, "joined"),
                DispatcherEvent::Rebooted(module) => (module, "rebooted"),
                DispatcherEvent::Rejoined(module) => (module, "rejoined"),
                DispatcherEvent::Elsewhere(module) => (module, "serves another host"),
                DispatcherEvent::Doubled(module) => (module, "two modules answer to its number"),
                DispatcherEvent::Reported(_) => continue,
            };
            let event = flotilla::Event { stamp: stamp(at), module: id(module), text: text.to_owned() };
            self.log.show(now, Shown::Event(&event));
        }
    }

    /// Decisions that are new, or were given up.
    fn decisions(&mut self, now: FleetInstant, decisions: &[Decision]) {
        // Only the last ones can change.
        let from = self.told.len().saturating_sub(2);
        for (index, decision) in decisions.iter().enumerate().skip(from) {
            let form = (decision.start, decision.transition, decision.period, decision.via.is_some());
            if self.told.get(index) == Some(&form) {
                continue;
            }
            self.told.truncate(index);
            self.told.push(form);
            let message = message(now, index, decision);
            self.tell(now, Told::Decision(&message));
            if self.log.is_kept() {
                let [demanded, commanded] =
                    [&message.demand, &message.commanded].map(|wrench| self.scene.wrench(now, wrench));
                self.log.show(now, Shown::Demanded(&demanded));
                self.log.show(now, Shown::Commanded(&commanded));
            }
        }
    }

    /// Tells what came of the cycles that are over, as far as they are.
    fn close(&mut self, now: FleetInstant, decisions: &[Decision], is_over: impl Fn(&Decision) -> bool) {
        while let (Some(decision), Some(impulse)) =
            (decisions.get(self.closed), self.impulses.get(self.closed))
            && is_over(decision)
        {
            let per_s = if impulse.time_s > 0.0 { 1.0 / impulse.time_s } else { 0.0 };
            let achieved =
                wrench(Wrench::from_array(impulse.sum.to_array().map(|component| component * per_s)));
            let cycle = flotilla::Cycle {
                stamp: stamp(now),
                index: self.closed as u32,
                number: decision.number,
                achieved,
                swum_s: impulse.time_s,
            };
            self.tell(now, Told::Cycle(&cycle));
            if self.log.is_kept() {
                self.log.show(now, Shown::Achieved(&self.scene.wrench(now, &cycle.achieved)));
            }
            self.closed += 1;
        }
    }

    /// Tells of the gaps up to the one numbered `until`.
    fn tell_gaps<F: Fleet, P>(&mut self, now: FleetInstant, run: &BoatRun<'_, F, P>, until: usize) {
        while let Some(gap) = run.gaps.get(self.gaps).filter(|_| self.gaps < until) {
            let (index, start_us, end_us) = (self.gaps as u32, gap.start.0, gap.end.0);
            self.tell(now, Told::Gap(&flotilla::Gap { stamp: stamp(now), index, start_us, end_us }));
            self.gaps += 1;
        }
    }

    /// Pose, tails and the wrench that acted in the tick that ends at `now`. Nothing is told of the time before time zero.
    fn motion<F: Fleet<Actuation = TailState>, P>(&mut self, now: FleetInstant, run: &BoatRun<'_, F, P>) {
        if let Some(fix) =
            run.host.controller.fix().filter(|fix| self.log.is_kept() && self.fix_s != Some(fix.t_s))
        {
            self.fix_s = Some(fix.t_s);
            let fix = flotilla::Fix {
                stamp: stamp(now),
                captured_s: fix.t_s,
                position_m: fix.position_m,
                heading_rad: fix.heading_rad,
            };
            self.log.show(now, Shown::Fix(&fix));
        }
        let Some(origin) = self.origin.filter(|&origin| origin <= now) else { return };
        let t_s = now.as_secs_f64() - origin.as_secs_f64();
        if self.poses.is_due(t_s) {
            self.tell_pose(now, t_s, run);
        }
        if self.tails.is_due(t_s) {
            // Tails in real water are told of late; simulated water feels them late, and that is then when they are so.
            let late = if run.world.is_some() { Duration(0) } else { run.fleet.delay() };
            self.joints.header.stamp = stamp(FleetInstant(now.0.saturating_sub(u64::from(late.0))));
            self.joints.position.clear();
            self.joints.position.extend(run.actuation.iter().map(|tail| tail.angle_rad));
            self.joints.velocity.clear();
            self.joints.velocity.extend(run.actuation.iter().map(|tail| tail.rate_rad_s));
            self.reading.take(Told::Tails(&self.joints));
            self.log.tell(now, Told::Tails(&self.joints));
        }
        if self.log.is_kept() && self.markers.is_due(t_s) {
            self.log.show(now, Shown::Markers(self.scene.tails(now, &run.actuation)));
        }
        let decisions = run.host.controller.decisions();
        if let Some(tank) = &run.world {
            self.push(now, decisions, tank.last_wrench());
        }
        self.close(now, decisions, |decision| decision.end() < now);
    }

    /// The wrench of one tick.
    fn push(&mut self, now: FleetInstant, decisions: &[Decision], wrench: Wrench) {
        let dt_s = f64::from(TICK.as_secs_f32());
        self.impulses.resize(decisions.len(), Impulse::default());
        // The last decision may wait for its start while the one before it runs.
        for (decision, impulse) in decisions.iter().zip(&mut self.impulses).rev().take(2) {
            if decision.swim_start() < now && now <= decision.end() {
                let [fx_n, fy_n, tau_nm] = wrench.to_array().map(|component| component * dt_s);
                impulse.sum = impulse.sum + Wrench { fx_n, fy_n, tau_nm };
                impulse.time_s += dt_s;
            }
        }
    }

    fn tell_pose<F: Fleet, P>(&mut self, now: FleetInstant, t_s: f64, run: &BoatRun<'_, F, P>) {
        let truth = run.world.as_ref().map(|tank| tank.pose());
        if let Some(truth) = &truth {
            self.tell(now, Told::Truth(&state(now, truth)));
        }
        // Poses of the observer are asked for where there are no others, and to be looked at.
        if truth.is_some() && !self.log.is_kept() {
            return;
        }
        let estimate = run.host.controller.estimate().map(|estimate| PoseSample {
            t_s: estimate.t_s,
            position_m: estimate.position_m,
            heading_rad: estimate.heading_rad,
            velocity_m_s: estimate.velocity_m_s,
            yaw_rate_rad_s: estimate.yaw_rate_rad_s,
        });
        if let Some(estimate) = &estimate {
            self.tell(now, Told::Estimate(&state(now, estimate)));
        }
        if self.log.is_kept() {
            if self.odometry.is_due(t_s) {
                if let Some(truth) = &truth {
                    self.log.show(now, Shown::TrueOdometry(self.scene.odometry(now, truth, "base_link")));
                }
                if let Some(estimate) = &estimate {
                    self.log.show(now, Shown::Odometry(self.scene.odometry(now, estimate, "estimate")));
                }
            }
            let base = truth.as_ref().or(estimate.as_ref());
            self.log.show(now, Shown::Transforms(self.scene.transforms(now, base, estimate.as_ref())));
        }
    }

    /// Everything that is counted, so far.
    fn count<F: Fleet, P: PoseSource<Tank>>(&mut self, now: FleetInstant, run: &BoatRun<'_, F, P>) {
        self.counted = Some(now);
        let (pilot, links) = (&run.host.controller, run.host.dispatcher());
        let tank = run.world.as_ref();
        self.tell(now, Told::Links(&counts::links(stamp(now), &self.ids, links)));
        let ledger = flotilla::Ledger {
            stamp: stamp(now),
            strays: counts::incoming(links.strays()),
            medium: run.fleet.faults().as_ref().map(counts::medium),
            clock_error_us: self.clock_error_us,
            refusals: pilot.refusals(),
            least_clearance_m: tank.map(|tank| tank.least_clearance_m()),
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
        let origin_s = self.origin.map_or(0.0, FleetInstant::as_secs_f64);
        let (mut module, mut share, mut at_s) = (Vec::new(), Vec::new(), Vec::new());
        for (index, weak) in pilot.weak_modules() {
            module.push(self.ids.get(index).copied().unwrap_or_default());
            share.push(weak.share);
            at_s.push(weak.found.as_secs_f64() - origin_s);
        }
        if !module.is_empty() {
            let weak = flotilla::WeakModules { stamp: stamp(now), module, share, at_s };
            self.tell(now, Told::WeakModules(&weak));
        }
        let contacts = tank.map_or(&[][..], |tank| tank.contacts());
        for (index, contact) in contacts.iter().enumerate() {
            let overlap_m = -contact.clearance_m;
            if self.contacts.get(index).is_some_and(|told_m| told_m.to_bits() == overlap_m.to_bits()) {
                continue;
            }
            self.contacts.truncate(index);
            self.contacts.push(overlap_m);
            let modules = [contact.modules.0, contact.modules.1];
            let contact = flotilla::Contact {
                stamp: stamp(now),
                index: index as u32,
                began_s: contact.t_s,
                modules: modules.map(|module| self.ids.get(module).copied().unwrap_or_default()),
                overlap_m,
            };
            self.tell(now, Told::Contact(&contact));
        }
        if self.log.is_kept() {
            self.log.show(now, Shown::Markers(self.scene.bodies(now)));
            self.log.show(now, Shown::Diagnostics(&modules::diagnostics(now, &self.ids, links)));
            for (place, (link, &id)) in links.modules().iter().zip(&self.ids).enumerate() {
                self.log.battery(now, place, id, &modules::battery(now, id, link));
            }
            let t_s = self.origin.map_or(0.0, |origin| now.as_secs_f64() - origin.as_secs_f64());
            if let Some(asked) = pilot.asked(t_s) {
                let from_m = pilot.estimate().map(|estimate| estimate.position_m);
                self.log.show(now, Shown::Target(&self.scene.target(now, &asked, from_m)));
            }
        }
    }
}

impl<F: Fleet<Actuation = TailState>, P: PoseSource<Tank>> Observer<BoatRun<'_, F, P>> for BoatLog<'_> {
    fn observe(&mut self, now: FleetInstant, run: &BoatRun<'_, F, P>) -> Result<(), RunError> {
        self.watch.observe(now, run)?;
        let pilot = &run.host.controller;
        self.happenings(now, run);
        if self.origin != pilot.origin() {
            self.origin = pilot.origin();
            if let Some(origin) = self.origin {
                let begin = flotilla::Begin { stamp: stamp(now), origin_us: origin.0 };
                self.tell(now, Told::Begin(&begin));
            }
        }
        self.stand(now, run);
        self.decisions(now, pilot.decisions());
        // A gap whose end is not known yet is told of later.
        self.tell_gaps(now, run, run.gaps.len() - usize::from(run.is_blind()));
        if let Some(text) = run.poses.trouble().filter(|_| !pilot.gets_on() && self.origin.is_some()) {
            counts::suffer(&mut self.troubles, text);
        }
        if !run.is_blind() {
            self.motion(now, run);
            if pilot.is_under_way() {
                self.clock_error_us = self.clock_error_us.max(run.fleet.clock_error_us(now));
            }
        }
        let is_due = self.counted.is_none_or(|counted| now.since(counted) >= COUNTS_EVERY);
        if is_due && self.log.is_kept() {
            self.count(now, run);
        }
        Ok(())
    }
}
