//! What water and boat are really like (`[tank]`) against what the host believes (`[modboat]`, `[control]`, `[observer]`): the host gets
//! to know of the former by measurements alone.

use std::collections::VecDeque;

use host::run::RunError;
use host::run::boats::Cameras;
use host::run::closed_loop::Drive;
use host::run::experiment::{Pace, RunResult, Site, run_with};
use host::run::fleet::InProcess;
use host::run::log::Log;
use host::run::orders::Unattended;
use host::run::pose_source::PoseSource;
use host::run::progress::Quiet;
use host::run::scenario::Scenario;
use modboat::observer::Fix;
use protocol::time::FleetInstant;
use sim::tank::Tank;

const SEED: u64 = 17;

/// Everything in it differs from what the host believes.
const OTHER_WATER: &str = "[tank]\nmodule_mass_kg = 1.6\nmodule_inertia_kg_m2 = 0.005\ncentre_of_mass_m = [0.02, -0.01]\n\
    added_mass_sway = 0.9\nadded_mass_surge = 0.2\nadded_inertia = 0.1\ndrag_sway_n_s2_m2 = 9.0\ndrag_surge_n_s2_m2 = 3.0\n\
    drag_cross_n_s2_m2 = 2.0\ndrag_centre_m = [0.01, 0.02]\nyaw_drag_n_m_s2 = 1e-3\nyaw_drag_scale = 1.7\nyaw_drag_speed = 0.5\n\
    current_m_s = [0.01, -0.005]\ngust_m_s = 0.005\n\
    [tank.thrust]\nslope_n_rad = 0.03\noffset_n = 0.021\nspread = 0.15\nmodule_share = [1.0, 0.5, 0.9]\ninteraction = 0.1\n\
    [tank.wave]\nheight_m = 0.004\nperiod_s = 0.8\ndirection_rad = 1.0\n[tank.jonswap]\nheight_m = 0.004\nperiod_s = 0.9\n";

fn scenario(more: &str) -> Scenario {
    let text = format!(
        "name = \"t\"\n[structure]\nsize = \"3x1\"\n[[leg]]\nduration_s = 30.0\nvelocity_m_s = [0.03, 0.01]\nheading_rad = 1.5\n{more}"
    );
    Scenario::parse("t.toml", &text).expect(&text)
}

/// Cameras of which everything they say is kept, or a tape of that.
enum Poses {
    Live(Box<Cameras>, Vec<Fix>),
    Tape(VecDeque<Fix>, Option<Fix>),
}

impl PoseSource<Tank> for &mut Poses {
    type Pose = Fix;

    fn poll<'a>(
        &'a mut self,
        now: FleetInstant,
        tank: Option<&'a Tank>,
    ) -> Result<Option<&'a Fix>, RunError> {
        match &mut **self {
            Poses::Live(cameras, kept) => {
                let fix = cameras.poll(now, tank)?;
                kept.extend(fix);
                Ok(fix)
            }
            Poses::Tape(tape, shown) => {
                let due = tank.map_or(f64::INFINITY, |tank| tank.pose().t_s);
                *shown = tape.pop_front_if(|fix| fix.t_s <= due);
                Ok(shown.as_ref())
            }
        }
    }
}

fn run(scenario: &Scenario, poses: &mut Poses) -> RunResult {
    let water = Site::simulated(scenario, SEED).expect("a tank").water;
    let mut fleet = InProcess::boats(scenario, SEED).expect("a fleet");
    let drive = Drive { pace: Pace::Simulated, operator: &mut Unattended, hook: &mut |_, _, _| {} };
    let site = Site { water, poses };
    run_with(Log::default(), scenario, SEED, &mut fleet, drive, site, &mut Quiet).expect("a run")
}

#[test]
fn equal_measurements_give_equal_decisions_whatever_the_water_is() {
    let (plain, other) = (scenario(""), scenario(OTHER_WATER));
    let cameras = Site::simulated(&plain, SEED).expect("a tank").poses;
    let mut poses = Poses::Live(Box::new(cameras), Vec::new());
    let seen = run(&plain, &mut poses);
    let Poses::Live(_, kept) = poses else { unreachable!("live") };
    assert!(seen.decisions.len() > 15 && kept.len() > 3000, "seed {SEED}: {}", kept.len());
    let mut tape = Poses::Tape(kept.into(), None);
    let told = run(&other, &mut tape);
    let outputs = |result: &RunResult| {
        let decisions = result.decisions.iter();
        decisions
            .map(|decision| {
                let mut decision = decision.clone();
                decision.solve_us = 0;
                decision
            })
            .collect::<Vec<_>>()
    };
    assert_eq!(outputs(&seen), outputs(&told), "seed {SEED}");
    // The water was another one indeed: what the structure did there is not what the host was told.
    let end = |result: &RunResult| result.record.poses.last().expect("poses").position_m;
    let (there, here) = (end(&seen), end(&told));
    assert!((there[0] - here[0]).hypot(there[1] - here[1]) > 0.05, "seed {SEED}: {there:?} {here:?}");
}

#[test]
fn what_is_left_out_is_as_the_host_believes() {
    let spelled_out = "[tank]\nmodule_mass_kg = 1.0\nmodule_inertia_kg_m2 = 0.003\ndrag_sway_n_s2_m2 = 4.5\ndrag_surge_n_s2_m2 = 4.5\n\
        yaw_drag_n_m_s2 = 5e-4\n[tank.thrust]\nslope_n_rad = 0.022\noffset_n = 0.019\nmodule_share = [1.0, 1.0, 1.0]\n";
    let figures = |more: &str| {
        let scenario = scenario(more);
        let result = host::run::experiment::simulate(&scenario, SEED).expect("a run");
        format!("{:?}", result.record.poses)
    };
    assert_eq!(figures(""), figures(spelled_out));
}

#[test]
fn a_tank_that_cannot_be_is_refused_with_line_value_and_unit() {
    for (lines, said) in [
        (
            "[tank]\nmodule_mass_kg = 0",
            "9: [tank] module_mass_kg = 0 kg: must be a finite number greater than zero",
        ),
        ("[tank]\ndrag_sway_n_s2_m2 = -4.5", "9: [tank] drag_sway_n_s2_m2 = -4.5 N·s²/m²: must be"),
        ("[tank]\nyaw_drag_scale = nan", "9: [tank] yaw_drag_scale = NaN"),
        ("[tank.thrust]\nspread = 1.5", "9: [tank.thrust] spread = 1.5 : must lie between 0 and 1"),
        (
            "[tank.thrust]\nmodule_share = [1.0, 0.5]",
            "9: [tank.thrust] module_share = 2 numbers: must be one for each module of the structure, or none",
        ),
        ("[tank.thrust]\nmodule_share = [1, -1, 1]", "9: [tank.thrust] module_share = -1"),
        ("[tank.wave]\nheight_m = 0.3", "9: [tank.wave] height_m = 0.3 m: such a wave breaks"),
        ("[tank.jonswap]\npeakedness = 0.5", "9: [tank.jonswap] peakedness = 0.5"),
        ("[mocap]\nlatency_s = -1", "9: [mocap] latency_s = -1 s: must lie between 0 and 10"),
        ("[mocap]\nburst = 0.2", "[mocap] burst_s = 0 s: must be greater than zero with burst"),
    ] {
        let text = format!(
            "name = \"t\"\n[structure]\nsize = \"3x1\"\n[[leg]]\nduration_s = 30.0\nvelocity_m_s = [0.03, 0.01]\nheading_rad = 1.5\n{lines}\n"
        );
        let complaint = Scenario::parse("t.toml", &text).expect_err(lines).to_string();
        assert!(complaint.contains(said) && complaint.starts_with("t.toml"), "{complaint}\nfor {said}");
    }
}
