//! How a run of Modboats stands, what it is steered by, and what was ordered.

use protocol::time::FleetInstant;
use quantity::wrap_rad;
use runlog::flotilla;
use sim::tank::Tank;

use super::super::super::boats::BoatRun;
use super::super::super::fleet::Fleet;
use super::super::super::pose_source::PoseSource;
use super::super::stamp;
use super::super::standing::order;
use super::super::topics::{Shown, Told};
use super::BoatLog;
use super::messages::goal;

impl BoatLog<'_> {
    /// How the run stands, and what it is steered by.
    pub(super) fn stand<F: Fleet, P: PoseSource<Tank>>(
        &mut self,
        now: FleetInstant,
        run: &BoatRun<'_, F, P>,
    ) {
        for ordered in &run.ordered {
            self.tell(now, Told::Order(&order(ordered)));
        }
        if !self.log.is_kept() {
            return;
        }
        let (pilot, links) = (&run.host.controller, run.host.dispatcher());
        let t_s = self.origin.map_or(0.0, |origin| now.as_secs_f64() - origin.as_secs_f64());
        let asked = pilot.asked(t_s);
        let steered = (asked.map(|asked| asked.target), pilot.targets().changes());
        if self.steered != Some(steered) {
            self.steered = Some(steered);
            self.log.show(now, Shown::Goal(&goal(now, asked.as_ref(), pilot.targets())));
        }
        let words = |status: &mut flotilla::Status| {
            status.poses = run.poses.trouble().unwrap_or_default().to_owned();
        };
        let measured = |status: &mut flotilla::Status| {
            if let Some(seen) = pilot.estimate() {
                status.unknown_m_s2 = seen.unknown_m_s2.to_vec();
                status.unknown_rad_s2 = vec![seen.unknown_rad_s2];
            }
            let sent = pilot.sent_lately();
            for (index, (module, link)) in status.modules.iter_mut().zip(links.modules()).enumerate() {
                let Some(report) = link.telemetry() else { continue };
                let tail_rad = f64::from(report.tail.0);
                let cycle = sent.iter().find(|cycle| cycle.number == report.cycle);
                let planned_rad = cycle.and_then(|cycle| cycle.tail_rad(index, report.at));
                module.tail_rad = Some(tail_rad);
                module.tail_error_rad = planned_rad.map(|planned_rad| wrap_rad(tail_rad - planned_rad));
            }
        };
        let status = self.standing.status(now, run, &self.ids, words, measured);
        let Some(status) = status else { return };
        self.log.show(now, Shown::Status(status));
        if let Some(bodies) = run.poses.bodies() {
            self.log.show(now, Shown::Bodies(&flotilla::Bodies { stamp: stamp(now), bodies }));
        }
    }
}
