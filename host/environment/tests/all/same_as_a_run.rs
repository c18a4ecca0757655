//! The fidelity `module` is the simulation of `flotilla run`: the commands of a run's decisions give that run's poses, digit for digit.

use std::sync::Arc;

use environment::command::Command;
use environment::mean::Mean;
use environment::modules::Modules;
use host::run::RunError;
use host::run::boats::Cameras;
use host::run::closed_loop::Run;
use host::run::experiment::Site;
use host::run::fleet::InProcess;
use host::run::host::Step;
use host::run::pilot::{Decision, Pilot};
use host::run::pose_source::PoseSource;
use host::run::scenario::Scenario;
use modboat::distance::DistanceToCollision;
use modboat::observer::Fix;
use modboat::plan::Outcome;
use protocol::Motion;
use protocol::time::FleetInstant;
use record::PoseSample;
use sim::module::TICK;
use sim::tank::Tank;

fn command(decision: &Decision) -> Command {
    let sent = decision.sent_cycles();
    let [Some(Motion::Modboat(cycle))] = [sent[0].motions.first()] else { panic!("no Modboat: {sent:?}") };
    Command {
        cycle: decision.plan.cycle.clone(),
        turns: decision.turns.clone(),
        transition: decision.transition,
        law: cycle.law,
        period: decision.period,
    }
}

/// In a tank that is unlike what the host believes, and noisy.
const TANK: &str = "name = \"t\"\n[structure]\nsize = \"2x2\"\n[[leg]]\nduration_s = 40.0\nvelocity_m_s = [0.02, 0.01]\n\
    heading_rad = 0.7\n[planner]\nloss_tolerant = \"require\"\n[tank]\ngust_m_s = 0.004\ncurrent_m_s = [0.005, 0.0]\n\
    [tank.thrust]\nspread = 0.1\n[motor]\nspread = 0.1\n";

/// Cameras that keep the true pose of every tick.
struct Kept {
    cameras: Cameras,
    poses: Vec<PoseSample>,
}

impl PoseSource<Tank> for Kept {
    type Pose = Fix;

    fn poll<'a>(
        &'a mut self,
        now: FleetInstant,
        tank: Option<&'a Tank>,
    ) -> Result<Option<&'a Fix>, RunError> {
        self.poses.extend(tank.map(Tank::pose));
        self.cameras.poll(now, tank)
    }
}

/// Decisions of a run as the program makes it, and the true pose of every tick.
fn run(scenario: &Scenario, seed: u64) -> (Vec<Decision>, Vec<PoseSample>) {
    let mut fleet = InProcess::boats(scenario, seed).expect("a fleet");
    let pilot = Pilot::new(scenario, None, || FleetInstant(0)).expect("a pilot");
    let site = Site::simulated(scenario, seed).expect("a tank");
    let mut run = Run::new(pilot, &mut fleet, site.water, Kept { cameras: site.poses, poses: Vec::new() });
    let mut now = FleetInstant(0);
    loop {
        now = now.after(TICK);
        if matches!(run.step(now, || now).expect("goes on"), Step::End(_)) {
            return (run.host.controller.decisions().to_vec(), run.poses.poses);
        }
    }
}

#[test]
fn commands_of_a_run_give_its_poses() {
    for seed in [1, 12] {
        let scenario = Scenario::parse("t.toml", TANK).expect("a scenario");
        let (decisions, poses) = run(&scenario, seed);
        let mut modules = Modules::new(&scenario, seed).expect("modules");
        let (last, all) = decisions.split_last().expect("decisions");
        assert!(all.len() > 20 && last.number == decisions.len() as u32, "seed {seed}: {}", decisions.len());
        for (decision, next) in all.iter().zip(&decisions[1..]) {
            let is_plain = decision.plan.outcome != Outcome::Held && decision.via.is_none();
            assert!(is_plain && next.start == decision.end(), "seed {seed}: {decision:?}");
            assert_eq!(modules.run(&command(decision)).expect("goes on"), 0, "seed {seed}");
            let now = modules.pose();
            let kept = poses.iter().find(|pose| pose.t_s >= now.t_s).expect("not before the end");
            assert_eq!(*kept, now, "seed {seed}, cycle {}", decision.number);
        }
    }
}

/// What the planner believes comes near to that: the same commands, without motors and water at single instants.
#[test]
fn mean_cycles_are_near_to_simulated_modules() {
    let text = TANK.split("[tank]").next().expect("the rest");
    let scenario = Scenario::parse("t.toml", text).expect("a scenario");
    let (decisions, _) = run(&scenario, 3);
    let mut modules = Modules::new(&scenario, 3).expect("modules");
    let Scenario { structure, modboat, tank, timing, .. } = &scenario;
    let distance = Arc::new(DistanceToCollision::new(modboat));
    let mut mean = Mean::new(structure, modboat, tank, timing.lead_s, distance).expect("a hull");
    mean.place(&scenario.start_pose(), 0.0);
    let positions_m = structure.positions_m(modboat.pitch_m);
    for decision in &decisions {
        let command = command(decision);
        modules.run(&command).expect("goes on");
        mean.run(&command, command.wrench(modboat, &positions_m));
    }
    let (real, believed) = (modules.pose(), mean.pose());
    let apart_m = [0, 1].map(|axis| real.position_m[axis] - believed.position_m[axis]);
    let swum_m = real.position_m[0].hypot(real.position_m[1]);
    assert!(swum_m > 0.5 && apart_m[0].hypot(apart_m[1]) < 0.1 * swum_m, "{real:?} {believed:?}");
    assert!((mean.starts_s() - modules.starts_s()).abs() < 1e-6);
}
