//! The pilot as the closed loop sees it: the controller of Modboats.

use std::convert::Infallible;

use link::dispatcher::{Dispatcher, DispatcherEvent, ModuleLink};
use modboat::bounds::Place;
use modboat::control::Controller as Control;
use modboat::motion::Wrench;
use modboat::observer::{Fix, Observer};
use protocol::time::FleetInstant;
use protocol::{ModuleKind, ModuleState};

use super::super::RunError;
use super::super::clock::Gap;
use super::super::hold::Hold;
use super::super::host::{Controller, Patience, Step};
use super::super::orders::Order;
use super::super::scenario::{Scenario, Timing};
use super::super::steering::Steering;
use super::Pilot;
use super::decision::pose_of;
use super::phase::{Phase, PhaseEvent};

impl Controller for Pilot {
    const MODULE: &'static str = "module";
    const KIND: ModuleKind = ModuleKind::Modboat;
    type Pose = Fix;
    /// Modules stay docked.
    type Coupling = Infallible;

    fn handle_event<A: Copy>(&mut self, event: DispatcherEvent, links: &Dispatcher<A>) {
        match event {
            DispatcherEvent::Refused { .. } => self.refusals += 1,
            // Which of the two has what was sent is not known.
            DispatcherEvent::Doubled(_) => {
                self.give_up_if_turning();
                self.handle_phase(PhaseEvent::Stopped);
            }
            // From where to go on is seen when all modules rest.
            DispatcherEvent::Reported(index)
                if links.modules()[index].state() == Some(ModuleState::Stopped) =>
            {
                self.give_up_if_turning();
                self.handle_phase(PhaseEvent::Stopped);
            }
            _ => {}
        }
    }

    fn handle_pose(&mut self, fix: &Fix) {
        self.fix = Some(*fix);
        self.observer.update(fix);
        self.control.update(fix);
        if let Some(weak) = &mut self.weak {
            weak.update(fix);
        }
    }

    fn handle_coupled(&mut self, never: Infallible) -> Result<(), RunError> {
        match never {}
    }

    fn step<A: Copy>(
        &mut self,
        now: FleetInstant,
        links: &Dispatcher<A>,
    ) -> Result<Step<Infallible>, RunError> {
        let wrench = self.wrench_at(now);
        self.observer.set_wrench(now.as_secs_f64(), wrench);
        self.control.set_wrench(now.as_secs_f64(), wrench, self.tails_at(now));
        if self.phase == Phase::Finished {
            return Ok(Step::Wait);
        }
        let ends_s = self.scenario.ends_s();
        if self.origin.is_some_and(|origin| now.as_secs_f64() - origin.as_secs_f64() >= ends_s) {
            self.finish();
            return Ok(Step::End(None));
        }
        Ok(self.next(now, links).map_or(Step::Wait, Step::Dispatch))
    }

    /// The modules have finished what they had and hold; how the structure moved meanwhile is not known.
    fn handle_gap(&mut self, _gap: &Gap) {
        self.give_up_if_turning();
        self.handle_phase(PhaseEvent::Paused);
        let Scenario { structure, modboat, observer, control, .. } = &self.scenario;
        // They were valid when the run began.
        if let Ok(observer) = Observer::new(structure, modboat, observer) {
            self.observer = observer;
        }
        self.control = Control::new(structure, modboat, control, &self.scenario.observer);
    }

    fn finish(&mut self) {
        self.handle_phase(PhaseEvent::Ended);
    }

    fn halt(&mut self, _: Order) {
        self.halted = true;
        self.targets.halt();
        self.give_up_if_turning();
        self.handle_phase(PhaseEvent::Halted);
    }

    fn resume(&mut self) {
        self.halted = false;
        if self.targets.lacks_target().is_none() {
            self.handle_phase(PhaseEvent::Released);
        }
    }

    fn steer(&mut self, now: FleetInstant, steering: &Steering) -> Result<String, String> {
        if self.phase == Phase::Finished {
            return Err("the run is over".to_owned());
        }
        if self.halted && matches!(steering, Steering::Velocity(..)) {
            return Err("the fleet is stopped or held: a velocity is for now".to_owned());
        }
        let t_s = self.origin.map_or(0.0, |origin| now.as_secs_f64() - origin.as_secs_f64());
        let fixed = self.fix.map(|fix| Place { position_m: fix.position_m, heading_rad: fix.heading_rad });
        let observed = self.observer.estimate();
        let place = observed.map(|seen| Place { position_m: seen.position_m, heading_rad: seen.heading_rad });
        self.targets.steer(steering, &self.scenario, place.or(fixed), t_s)?;
        if self.targets.lacks_target().is_some() {
            self.give_up_if_turning();
            self.handle_phase(PhaseEvent::Halted);
            return Ok("the fleet finishes its cycle and holds until the next target".to_owned());
        }
        if self.halted {
            return Ok("followed when the stop or hold is over".to_owned());
        }
        self.handle_phase(PhaseEvent::Released);
        Ok("followed from the next cycle on".to_owned())
    }

    fn lacks_target(&self) -> Option<&'static str> {
        self.targets.lacks_target()
    }

    /// Start of the first cycle.
    fn origin(&self) -> Option<FleetInstant> {
        self.origin
    }

    fn duration_s(&self) -> f64 {
        self.scenario.duration_s()
    }

    fn is_under_way(&self) -> bool {
        self.phase.is_under_way()
    }

    fn lacks_pose(&self) -> bool {
        !self.is_under_way() && self.lacks_pose
    }

    /// A fleet that rests because no wrench is asked for does what it is to do.
    fn gets_on(&self) -> bool {
        let rests = || self.decisions.last().is_some_and(|last| last.demand == Wrench::default());
        self.is_under_way() || self.phase == Phase::Pausing && rests()
    }

    fn hold(&self) -> Hold {
        match self.phase {
            Phase::Halted => Hold::Operator,
            _ if self.lacks_pose => Hold::PosesLost,
            Phase::Pausing => Hold::NoCycle,
            _ => Hold::Module,
        }
    }

    fn take_news(&mut self) -> Option<String> {
        self.news.pop_front()
    }

    fn status<A: Copy>(&self, links: &Dispatcher<A>) -> String {
        match self.targets.lacks_target() {
            _ if self.halted => return "the fleet is halted by an operator".to_owned(),
            Some("") => return "the fleet waits for its first target".to_owned(),
            Some(why) => return format!("the fleet holds until the next target: {why}"),
            None => {}
        }
        if Controller::lacks_pose(self) {
            return "the fleet holds: there is no new pose".to_owned();
        }
        if !self.is_under_way() {
            return "the fleet holds: a module's tail is not known".to_owned();
        }
        let missing = self.decisions.last().map_or(&[][..], |decision| &decision.missing);
        let missing = links.modules().iter().zip(missing).filter(|(_, missing)| **missing);
        let missing: Vec<String> = missing.map(|(link, _)| link.id().to_string()).collect();
        match missing.as_slice() {
            [] => "all modules are ready: swimming".to_owned(),
            missing => format!("swimming without {}: their tails may be anywhere", missing.join(", ")),
        }
    }

    /// Those with unknown tail angles, and those that do not know the time.
    fn missing<A: Copy>(&self, links: &Dispatcher<A>) -> Vec<usize> {
        let waited_for = |&(index, link): &(usize, &ModuleLink<A>)| {
            pose_of(self.phase, self.decisions.last(), index, link).is_none() || !self.is_sure(link)
        };
        links.modules().iter().enumerate().filter(waited_for).map(|(index, _)| index).collect()
    }

    fn id<A: Copy>(&self, index: usize, links: &Dispatcher<A>) -> u16 {
        links.modules()[index].id().0
    }

    fn patience(&self) -> Patience {
        let Timing { missing_after_s, join_s, .. } = self.scenario.timing;
        Patience { missing_after_s, join_s }
    }
}
