//! The fidelity `module` is the simulation of `flotilla run`: the commands of a run's decisions give that run's poses, digit for digit.

use environment::command::Command;
use environment::mean::Mean;
use environment::modules::Modules;
use host::run::experiment::simulate;
use host::run::pilot::Decision;
use host::run::scenario::Scenario;
use modboat::plan::Outcome;
use protocol::Motion;
use record::PoseSample;

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

#[test]
fn commands_of_a_run_give_its_poses() {
    for seed in [1, 12] {
        let scenario = Scenario::parse("t.toml", TANK).expect("a scenario");
        let run = simulate(&scenario, seed).expect("a run");
        let mut modules = Modules::new(&scenario, seed).expect("modules");
        let mut compared = 0;
        for decision in &run.decisions {
            assert!(decision.plan.outcome != Outcome::Held && decision.via.is_none(), "seed {seed}: {decision:?}");
            assert_eq!(modules.run(&command(decision)).expect("goes on"), 0, "seed {seed}");
            // The run keeps every fiftieth pose.
            let now = modules.pose();
            let kept = run.record.poses.iter().find(|pose| same_time(pose, &now, &run.decisions[0]));
            if let Some(pose) = kept {
                let moved = PoseSample { t_s: now.t_s, ..*pose };
                assert_eq!(moved, now, "seed {seed}, cycle {}", decision.number);
                compared += 1;
            }
        }
        assert!(compared >= 20, "seed {seed}: {compared} of {} decisions", run.decisions.len());
    }
}

/// Times of a record count from the start of the first cycle.
fn same_time(kept: &PoseSample, now: &PoseSample, first: &Decision) -> bool {
    (kept.t_s - (now.t_s - first.start.as_secs_f64())).abs() < 1e-6
}

/// What the planner believes comes near to that: the same commands, without motors and water at single instants.
#[test]
fn mean_cycles_are_near_to_simulated_modules() {
    let text = TANK.split("[tank]").next().expect("the rest");
    let scenario = Scenario::parse("t.toml", text).expect("a scenario");
    let run = simulate(&scenario, 3).expect("a run");
    let mut modules = Modules::new(&scenario, 3).expect("modules");
    let Scenario { structure, modboat, tank, timing, .. } = &scenario;
    let mut mean = Mean::new(structure, modboat, tank, timing.lead_s).expect("a hull");
    mean.place(&PoseSample { heading_rad: scenario.start_heading_rad(), ..PoseSample::default() }, 0.0);
    let positions_m = structure.positions_m(modboat.pitch_m);
    for decision in &run.decisions {
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
