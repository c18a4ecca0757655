//! Without poses a fleet finishes its cycle and holds, and goes on when poses come again.

use std::cell::Cell;

use host::run::RunError;
use host::run::boats::Cameras;
use host::run::closed_loop::Drive;
use host::run::experiment::{Pace, Site, run_with};
use host::run::fleet::InProcess;
use host::run::log::Log;
use host::run::orders::Unattended;
use host::run::pose_source::PoseSource;
use host::run::progress::Quiet;
use host::run::scenario::Scenario;
use modboat::observer::Fix;
use protocol::time::FleetInstant;
use sim::tank::Tank;

/// Cameras that see nothing for a while.
struct Covered<'a> {
    cameras: Cameras,
    /// From when to when, s.
    blind_s: [f64; 2],
    told: &'a Cell<f64>,
}

impl PoseSource<Tank> for Covered<'_> {
    type Pose = Fix;

    fn poll<'a>(
        &'a mut self,
        now: FleetInstant,
        tank: Option<&'a Tank>,
    ) -> Result<Option<&'a Fix>, RunError> {
        let [from_s, to_s] = self.blind_s;
        let fix = self.cameras.poll(now, tank)?;
        let fix = fix.filter(|fix| !(from_s..to_s).contains(&fix.t_s));
        if let Some(fix) = fix {
            self.told.set(fix.t_s);
        }
        Ok(fix)
    }
}

#[test]
fn a_blind_fleet_holds_until_it_sees_again() {
    let text = "name = \"t\"\n[structure]\nsize = \"3x1\"\n[[leg]]\nduration_s = 60.0\nvelocity_m_s = [0.03, 0.0]\n\
                heading_rad = 1.5\n";
    let scenario = Scenario::parse("t.toml", text).expect("valid");
    for (seed, from_s) in [(1, 20.0), (2, 20.7), (3, 21.3), (4, 21.9)] {
        let told = Cell::new(0.0);
        let Site { water, poses: cameras } = Site::simulated(&scenario, seed).expect("valid");
        let covered = Covered { cameras, blind_s: [from_s, from_s + 10.0], told: &told };
        let site = Site { water, poses: covered };
        let mut fleet = InProcess::boats(&scenario, seed).expect("valid");
        let mut starts = Vec::new();
        let mut hook = |now: FleetInstant, _: &_, fleet: &mut InProcess| {
            let moves = fleet
                .modules()
                .iter()
                .any(|module| module.state(now) == Some(protocol::ModuleState::Executing));
            let age_s = now.as_secs_f64() - told.get();
            if moves && age_s > 0.2 {
                starts.push((now.as_secs_f64(), age_s));
            }
        };
        let drive = Drive { pace: Pace::Simulated, operator: &mut Unattended, hook: &mut hook };
        let result =
            run_with(Log::default(), &scenario, seed, &mut fleet, drive, site, &mut Quiet).expect("it runs");
        // A cycle begins with a pose of at most hold_after_s, and takes its transition and its period.
        let (_, oldest_s) = starts.iter().copied().fold((0.0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
        let cycle_s = result.decisions.iter().map(|d| f64::from(d.transition.as_secs_f32()) + 1.5);
        let most_s = scenario.pose.hold_after_s + cycle_s.fold(0.0, f64::max);
        assert!(oldest_s < most_s + 0.01, "seed {seed}: swam blind for {oldest_s} s, at most {most_s} s");
        assert!(oldest_s > 1.0, "seed {seed}: it was never blind");
        let goes_on = result.decisions.iter().find(|d| d.start.as_secs_f64() > from_s + 10.0);
        let again_s = goes_on.expect("it swims again").start.as_secs_f64() - (from_s + 10.0);
        assert!(again_s < 1.0, "seed {seed}: it went on {again_s} s late");
        let held_s = result.summary.legs[0].held_s;
        assert!((6.5..9.5).contains(&held_s), "seed {seed}: held for {held_s} s");
    }
}
